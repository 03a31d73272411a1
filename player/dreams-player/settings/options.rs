//! The command line of `dreams-player`.
//!
//! Owns the options and their help. Every key of the config is an option of the same name, which a test holds;
//! an option wins over the config.

use crate::settings::choices::{Clock, ScreenChoice, StatusAddress};
use crate::settings::config::{AHEAD, CLIPS, Config, PREFETCH_MS, SEED, THREADS};
use clap::{Parser, value_parser};
use player::{LogLevel, MarkSocket};
use settings::hours::{Brightness, Night, Zone};
use settings::week::Hours;
use settings::{ConfigError, config_file};
use std::path::PathBuf;

/// The end of the help. `diagnostics::Exit` has the same four codes.
const EXIT_STATUS: &str = "\
Exit status:
  0  the run ended as asked: by a signal, or after --clips
  1  the answer is no: there was nothing to play
  2  the command line, the config or the flock's manifest is wrong
  3  a file or a screen could not be opened, read or written";

/// Play a flock for ever, every join frame-exact
#[derive(Debug, Default, Parser)]
#[command(name = "dreams-player", version, after_help = EXIT_STATUS)]
pub(crate) struct Options {
    /// Read settings from this file; options win over it
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
    /// Play nothing: light a still picture, and hold it whatever happens; the last resort of a unit
    #[arg(long)]
    pub(crate) still: bool,
    /// Play nothing: light the first picture of the path, say so, and hold it until a player takes the screen over; how a
    /// unit starts
    #[arg(long, conflicts_with = "still")]
    pub(crate) prelude: bool,
    /// The flock to play: a folder with `flock.toml`; when that is edited, the next join goes over to it
    #[arg(long, value_name = "DIR")]
    flock: Option<PathBuf>,
    /// The flock that stands in while there is none to be read at `flock`
    #[arg(long, value_name = "DIR")]
    spare: Option<PathBuf>,
    /// What to light: `auto`, `kms[:DEVICE]` or `virtual[:WxH@HZ]`
    #[arg(long, value_name = "SCREEN")]
    screen: Option<ScreenChoice>,
    /// When the picture is lit, in local time, as `08:00-23:00`
    #[arg(long, value_name = "FROM-TO")]
    hours: Option<Hours>,
    /// What the display does at other times: `off`; `black` where it would light a box of its own; `ddc` or `cec` to ask it
    /// to switch itself off besides
    #[arg(long, value_name = "NIGHT")]
    night: Option<Night>,
    /// How bright it is: a percentage, or some with their times, as `07:00 100, 20:00 40`
    #[arg(long, value_name = "PERCENT")]
    brightness: Option<Brightness>,
    /// The time zone of the unit, as `Europe/Zurich`
    #[arg(long, value_name = "ZONE")]
    timezone: Option<Zone>,
    /// The settings of the unit's owner, as `dreams-owner` keeps them: their hours, brightness and time zone win
    #[arg(long, value_name = "FILE")]
    owner: Option<PathBuf>,
    /// What makes the virtual screen's vblanks: `vblank` (time) or `free` (it flips as fast as frames come)
    #[arg(long, value_name = "CLOCK")]
    clock: Option<Clock>,
    /// Where the path's place is kept
    #[arg(long, value_name = "DIR")]
    state: Option<PathBuf>,
    /// Walk the path of this seed, the one that `dreams walk --seed` prints
    #[arg(long, value_name = "S", value_parser = value_parser!(u64).range(*SEED.start()..=*SEED.end()))]
    seed: Option<u64>,
    /// Stop after this many clips
    #[arg(long, value_name = "N", value_parser = value_parser!(u64).range(*CLIPS.start()..=*CLIPS.end()))]
    clips: Option<u64>,
    /// Write every flip, join and fault to this file, one JSON object a line
    #[arg(long, value_name = "FILE")]
    trace: Option<PathBuf>,
    /// Put the MD5 of every frame's planes into the trace
    #[arg(long)]
    hash: bool,
    /// Decoder threads
    #[arg(long, value_name = "N", value_parser = value_parser!(u64).range(*THREADS.start()..=*THREADS.end()))]
    threads: Option<u64>,
    /// Frames decoded ahead
    #[arg(long, value_name = "FRAMES", value_parser = value_parser!(u64).range(*AHEAD.start()..=*AHEAD.end()))]
    ahead: Option<u64>,
    /// How long before its join a clip is open and paged in, in milliseconds
    #[arg(long, value_name = "MS", value_parser = value_parser!(u64).range(*PREFETCH_MS.start()..=*PREFETCH_MS.end()))]
    prefetch_ms: Option<u64>,
    /// Where the status page is: `off`, a loopback `HOST:PORT` or `unix:PATH`
    #[arg(long, value_name = "ADDRESS")]
    status: Option<StatusAddress>,
    /// Where the other programs write notices that are shown over the picture
    #[arg(long, alias = "card", value_name = "FILE")]
    notice: Option<PathBuf>,
    /// The socket at which `dreams-votes` asks for the mark that acknowledges a press, or `off`
    #[arg(long, value_name = "FILE")]
    acknowledge: Option<MarkSocket>,
    /// The least urgent log line that is kept: `error`, `warn`, `info`, `debug` or `trace`
    #[arg(long, value_name = "LEVEL")]
    log: Option<LogLevel>,
}

impl Options {
    /// The settings of this run: the defaults, then the config, then the options.
    /// Errors: [`ConfigError`], if there is a config and it is refused.
    pub(crate) fn settings(self) -> Result<Config, ConfigError> {
        let config = self.config.as_deref().map(config_file::load::<Config>).transpose()?.unwrap_or_default();
        Ok(Config {
            flock: self.flock.unwrap_or(config.flock),
            spare: self.spare.unwrap_or(config.spare),
            screen: self.screen.unwrap_or(config.screen),
            hours: self.hours.or(config.hours),
            night: self.night.unwrap_or(config.night),
            brightness: self.brightness.unwrap_or(config.brightness),
            timezone: self.timezone.or(config.timezone),
            owner: self.owner.unwrap_or(config.owner),
            clock: self.clock.unwrap_or(config.clock),
            state: self.state.unwrap_or(config.state),
            seed: self.seed.or(config.seed),
            clips: self.clips.or(config.clips),
            trace: self.trace.or(config.trace),
            hash: self.hash || config.hash,
            threads: self.threads.unwrap_or(config.threads),
            ahead: self.ahead.unwrap_or(config.ahead),
            prefetch_ms: self.prefetch_ms.unwrap_or(config.prefetch_ms),
            status: self.status.unwrap_or(config.status),
            notice: self.notice.unwrap_or(config.notice),
            acknowledge: self.acknowledge.unwrap_or(config.acknowledge),
            log: self.log.unwrap_or(config.log),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::{EXIT_STATUS, Options};
    use crate::settings::choices::ScreenChoice;
    use crate::settings::config::{Config, tests::keys_of_the_sample};
    use clap::{CommandFactory, Parser};
    use diagnostics::Exit;
    use std::io::Write;

    #[test]
    fn every_key_of_the_config_is_an_option() {
        let command = Options::command();
        let options = command.get_arguments().filter_map(|option| option.get_long());
        let options: Vec<_> = options.map(|long| long.replace('-', "_")).collect();
        let options: Vec<_> =
            options.into_iter().filter(|long| !["config", "still", "prelude"].contains(&long.as_str())).collect();
        assert_eq!(options, keys_of_the_sample());
    }

    #[test]
    fn an_option_wins_over_the_config_and_the_config_over_the_default() {
        let mut file = tempfile::NamedTempFile::new().unwrap();
        writeln!(file, "seed = 7\nahead = 20").unwrap();
        let path = file.path().to_str().unwrap();
        let options = Options::parse_from(["dreams-player", "--config", path, "--seed", "8", "--screen", "virtual"]);
        let settings = options.settings().unwrap();
        let expected = Config { seed: Some(8), ahead: 20, screen: ScreenChoice::Virtual(None), ..Config::default() };
        assert_eq!(settings, expected);
    }

    #[test]
    fn the_option_for_the_notice_has_its_earlier_name_too() {
        let settings = |option| Options::parse_from(["dreams-player", option, "/run/here"]).settings().unwrap();
        assert_eq!(settings("--card"), settings("--notice"));
        assert_eq!(settings("--card").notice.to_str(), Some("/run/here"));
    }

    #[test]
    fn the_help_names_every_exit_code() {
        for exit in [Exit::Fine, Exit::No, Exit::Malformed, Exit::Unreadable] {
            assert!(EXIT_STATUS.contains(&format!("\n  {}  ", exit as u8)));
        }
        assert_eq!(EXIT_STATUS.lines().count(), 5);
    }
}
