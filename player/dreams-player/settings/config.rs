//! The config of the player: every setting, its default and its range.
//!
//! Owns [`Config`]. Never acts on it. Every key explains itself in `config/player.toml`,
//! which a test holds equal to [`Config::default`]; every key is an option too, in `options.rs`.

use crate::settings::choices::{Clock, ScreenChoice, StatusAddress};
use player::{LogLevel, MarkSocket};
use serde::Deserialize;
use serde::de::Deserializer;
use settings::hours::{Brightness, Day, Night, Zone};
use settings::week::{Closed, Hours};
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

/// Decoder threads: at most the cores of a large unit.
pub(crate) const THREADS: RangeInclusive<u64> = 1..=16;
/// Frames decoded ahead: a third of a second of film at least, memory for a second at most.
pub(crate) const AHEAD: RangeInclusive<u64> = 8..=60;
/// Milliseconds before its join at which a clip is open.
pub(crate) const PREFETCH_MS: RangeInclusive<u64> = 2_000..=60_000;
/// Seeds that TOML can write.
pub(crate) const SEED: RangeInclusive<u64> = 0..=i64::MAX as u64;
/// Clips after which a run ends.
pub(crate) const CLIPS: RangeInclusive<u64> = 1..=u32::MAX as u64;

/// Where the other programs of a unit write notices.
const NOTICE: &str = "/run/dreams-update/notice";
/// The same, as the sample of earlier versions had it.
const EARLIER_NOTICE: &str = "/run/dreams-update/card";

/// Every setting of a unit, as `config/player.toml` explains them.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct Config {
    pub(crate) flock: PathBuf,
    pub(crate) spare: PathBuf,
    pub(crate) screen: ScreenChoice,
    pub(crate) hours: Option<Hours>,
    pub(crate) night: Night,
    pub(crate) brightness: Brightness,
    pub(crate) timezone: Option<Zone>,
    pub(crate) owner: PathBuf,
    pub(crate) clock: Clock,
    pub(crate) state: PathBuf,
    #[serde(deserialize_with = "seed")]
    pub(crate) seed: Option<u64>,
    #[serde(deserialize_with = "clips")]
    pub(crate) clips: Option<u64>,
    pub(crate) trace: Option<PathBuf>,
    pub(crate) hash: bool,
    #[serde(deserialize_with = "threads")]
    pub(crate) threads: u64,
    #[serde(deserialize_with = "ahead")]
    pub(crate) ahead: u64,
    #[serde(deserialize_with = "prefetch_ms")]
    pub(crate) prefetch_ms: u64,
    pub(crate) status: StatusAddress,
    #[serde(alias = "card", deserialize_with = "notice")]
    pub(crate) notice: PathBuf,
    pub(crate) acknowledge: MarkSocket,
    pub(crate) log: LogLevel,
}

impl Default for Config {
    fn default() -> Self {
        Self {
            flock: "/var/lib/dreams/store/current".into(),
            spare: "/usr/share/dreams/flock".into(),
            screen: ScreenChoice::Auto,
            hours: None,
            night: Night::Off,
            brightness: Brightness::full(),
            timezone: None,
            owner: "/var/lib/dreams/owner/dreams.toml".into(),
            clock: Clock::Vblank,
            state: "/var/lib/dreams/state".into(),
            seed: None,
            clips: None,
            trace: None,
            hash: false,
            threads: 2,
            ahead: 8,
            prefetch_ms: 4_000,
            status: StatusAddress::Host("127.0.0.1:7180".to_owned()),
            notice: NOTICE.into(),
            acknowledge: MarkSocket::default(),
            log: LogLevel(tracing::Level::INFO),
        }
    }
}

impl Config {
    /// What it says about the days of the unit.
    pub(crate) fn day(&self) -> Day {
        Day {
            hours: self.hours.clone(),
            closed: Closed::default(),
            night: self.night,
            brightness: self.brightness.clone(),
            zone: self.timezone.clone(),
        }
    }
}

settings::ranged! {
    seed -> Option<u64>: SEED;
    clips -> Option<u64>: CLIPS;
    threads -> u64: THREADS;
    ahead -> u64: AHEAD;
    prefetch_ms -> u64: PREFETCH_MS;
}

/// A config of an earlier version goes with the programs of this one.
fn notice<'de, D: Deserializer<'de>>(from: D) -> Result<PathBuf, D::Error> {
    let path = PathBuf::deserialize(from)?;
    Ok(if path == Path::new(EARLIER_NOTICE) { NOTICE.into() } else { path })
}

#[cfg(test)]
pub(crate) mod tests {
    use super::{Config, EARLIER_NOTICE};
    use settings::config_file::parse;
    use std::path::Path;

    const SAMPLE: &str = include_str!("../../../config/player.toml");

    /// The keys that the sample explains, also those it leaves out by a leading `# `.
    pub(crate) fn keys_of_the_sample() -> Vec<String> {
        let key = |line: &str| {
            let (key, _) = line.trim_start_matches("# ").split_once(" = ")?;
            key.chars().all(|c| c.is_ascii_lowercase() || c == '_').then(|| key.to_owned())
        };
        SAMPLE.lines().filter_map(key).collect()
    }

    fn refusal(text: &str) -> String {
        parse::<Config>(Path::new("player.toml"), text).unwrap_err().to_string()
    }

    #[test]
    fn the_sample_is_the_default() {
        let read = |text| parse::<Config>(Path::new("player.toml"), text).unwrap();
        assert_eq!(read(SAMPLE), Config::default());
        assert_eq!(read(""), Config::default());
    }

    #[test]
    fn the_sample_explains_every_key_and_no_other() {
        let expected = refusal("no_such_key = 1");
        let known = expected.split("expected one of ").nth(1).unwrap().split(", ");
        let known: Vec<_> = known.map(|key| key.trim_matches('`').to_owned()).filter(|key| key != "card").collect();
        assert_eq!(keys_of_the_sample(), known);
        assert!(known.len() <= 21, "{} keys are too many to explain to an installer", known.len());
        let left_out = ["hours", "timezone", "seed", "clips", "trace"];
        let everything = left_out.iter().fold(SAMPLE.to_owned(), |text, key| {
            assert!(text.contains(&format!("\n# {key} = ")), "{key}");
            text.replace(&format!("\n# {key} = "), &format!("\n{key} = "))
        });
        let config = parse::<Config>(Path::new("player.toml"), &everything).unwrap();
        assert!(config.seed.is_some() && config.hours.is_some() && config.timezone.is_some());
    }

    #[test]
    fn a_config_that_calls_the_notice_a_card_is_understood() {
        let read = |text: &str| parse::<Config>(Path::new("player.toml"), text).unwrap();
        assert_eq!(read(&format!("card = \"{EARLIER_NOTICE}\"")), Config::default());
        assert_eq!(read("card = \"/run/here\"").notice, Path::new("/run/here"));
        assert!(refusal("card = \"a\"\nnotice = \"b\"").contains("duplicate field"));
    }

    #[test]
    fn an_unknown_key_is_named_with_file_and_line() {
        let said = refusal("hash = true\ncolour = 3\n");
        assert!(said.starts_with("`player.toml` line 2, key `colour`: unknown field `colour`"), "{said}");
    }

    #[test]
    fn a_value_out_of_range_is_named_with_both_ends() {
        let said = refusal("\nahead = 2\n");
        assert_eq!(
            said,
            "`player.toml` line 2, key `ahead`: invalid value: integer `2`, expected a number from 8 to 60"
        );
        let said = refusal("status = \"0.0.0.0:80\"\n");
        assert!(
            said.starts_with("`player.toml` line 1, key `status`: `0.0.0.0:80` is not a loopback address"),
            "{said}"
        );
    }
}
