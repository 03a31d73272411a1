//! The command line of `dreams-update`.
//!
//! Owns the options and their help, and what they make of the settings. Never acts on them: `update_run.rs` does.

use crate::config::Config;
use crate::fatal::Fatal;
use crate::stick_format::StickFormat;
use crate::tls::Judgement;
use bundle::{Consent, PublicKey, UnitId};
use clap::Parser;
use player::{ClockReader, HOST_NAME};
use settings::authorities::Authorities;
use settings::button::VOTES_FOLDER;
use settings::{Owner, config_file};
use std::path::PathBuf;

/// The end of the help. `diagnostics::Exit` has the same four codes.
const EXIT_STATUS: &str = "\
Exit status:
  0  a flock or a system was taken in, or there was nothing new
  1  the answer is no: the bundle is refused, or there is no room for it
  2  the command line, the config or a key is wrong
  3  the source, the store or the slot could not be read or written; another attempt goes on from there";

/// Bring this unit a flock or a system, from a stick or a server, whole or not at all
#[derive(Debug, Default, Parser)]
#[command(name = "dreams-update", version, after_help = EXIT_STATUS)]
pub(crate) struct Options {
    /// Where bundles lie: a folder, as `dreams publish` made it, or the address of one on a web server; without it, the
    /// `url` of the settings
    #[arg(value_name = "SOURCE")]
    source: Option<String>,
    /// Read settings from this file; options win over it
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
    /// Where the flocks of this unit are kept
    #[arg(long, value_name = "DIR")]
    store: Option<PathBuf>,
    /// Whom this unit trusts: a folder of public keys, or one of them
    #[arg(long, value_name = "DIR")]
    keys: Option<PathBuf>,
    /// What this unit is called
    #[arg(long, value_name = "NAME", value_parser = UnitId::new)]
    unit: Option<UnitId>,
    /// Take the bundle also if it is older than what this unit has played, or did not play on it, or is for every unit
    /// although this one has its own
    #[arg(long)]
    allow_older: bool,
    /// Only look if it is time, and remember in this file when that is next
    #[arg(long, value_name = "FILE")]
    schedule: Option<PathBuf>,
    /// Write the system that has come to this slot, which must not be the one that runs, and nothing else
    #[arg(long, value_name = "DEVICE", requires = "boot", conflicts_with_all = ["source", "schedule", "scrub"])]
    slot: Option<PathBuf>,
    /// The folder of the boot loader's partition, for that slot
    #[arg(long, value_name = "DIR", requires = "slot")]
    boot: Option<PathBuf>,
    /// First read every byte that is kept; what is damaged stays until it was fetched again
    #[arg(long)]
    scrub: bool,
    /// Only say that a stick with this file system, by its name in udev, is not read
    #[arg(long, value_name = "TYPE", conflicts_with_all = ["source", "schedule", "scrub", "slot"])]
    unreadable: Option<StickFormat>,
    /// Tell people in front of the picture, through this file, how far it is
    #[arg(long, alias = "card", value_name = "FILE")]
    notice: Option<PathBuf>,
    /// Answer with one JSON document
    #[arg(long)]
    json: bool,
}

/// What is to be done.
#[derive(Debug)]
pub(crate) struct Order {
    pub(crate) config: Config,
    pub(crate) clock: ClockReader,
    /// Whom the owner trusts besides.
    pub(crate) owners_keys: Vec<PublicKey>,
    /// Who may vouch for a server besides.
    pub(crate) owners_authorities: Authorities,
    pub(crate) unit: UnitId,
    /// `None` if there is nowhere to look.
    pub(crate) source: Option<String>,
    pub(crate) consent: Consent,
    pub(crate) schedule: Option<PathBuf>,
    /// Seconds between two status reports; `None` for one after each look.
    pub(crate) report_every_s: Option<u64>,
    /// Whether a report has a small picture of what is shown.
    pub(crate) report_picture: bool,
    /// The slot that a system is to be written to, and where the boot loader finds what to start.
    pub(crate) slot: Option<(PathBuf, PathBuf)>,
    pub(crate) scrub: bool,
    /// The stick's file system, if that is not read.
    pub(crate) unreadable: Option<StickFormat>,
    pub(crate) notice: Option<PathBuf>,
    pub(crate) json: bool,
}

impl Options {
    /// What is to be done: the defaults, then the config, then the options.
    /// Errors: [`Fatal`] if the config is refused, or the unit has no name.
    pub(crate) fn order(self) -> Result<Order, Fatal> {
        let config = self.config.as_deref().map(config_file::load::<Config>).transpose()?.unwrap_or_default();
        let owner = Owner::kept(&config.owner);
        let unit = self.unit.or(owner.unit).or_else(|| config.unit.clone()).map_or_else(host_name, Ok)?;
        let source = self.source.or(owner.url).or_else(|| config.url.clone());
        let slot = self.slot.zip(self.boot);
        // Who is told, and whether of the votes, is one decision.
        let (report_to, votes) = match owner.report_to {
            Some(address) => {
                (Some(address), owner.report_votes.then(|| config.votes.unwrap_or_else(|| VOTES_FOLDER.into())))
            }
            None => (config.report_to, config.votes),
        };
        let is_told_what = self.schedule.is_some() || self.scrub || slot.is_some() || self.unreadable.is_some();
        if source.is_none() && !is_told_what {
            return Err(Fatal::Nowhere);
        }
        Ok(Order {
            clock: ClockReader::new(&config.system, &config.synchronised),
            config: Config {
                store: self.store.unwrap_or(config.store),
                keys: self.keys.unwrap_or(config.keys),
                proxy: owner.proxy.or(config.proxy),
                report_to,
                votes,
                ..config
            },
            owners_keys: owner.keys,
            owners_authorities: owner.authorities,
            unit,
            source,
            consent: if self.allow_older { Consent::Any } else { Consent::Newer },
            schedule: self.schedule,
            report_every_s: owner.report_every.map(|minutes| minutes * 60),
            report_picture: owner.report_picture,
            slot,
            scrub: self.scrub,
            unreadable: self.unreadable,
            notice: self.notice,
            json: self.json,
        })
    }
}

impl Order {
    /// By what the certificates of servers are judged now.
    pub(crate) fn judgement(&self) -> Judgement {
        let (system, owners) = (self.config.authorities.clone(), self.owners_authorities.clone());
        Judgement { system, owners, clock: self.clock.read() }
    }
}

/// What the machine calls itself.
fn host_name() -> Result<UnitId, Fatal> {
    let name = player::host_name().map_err(|source| Fatal::Host { path: HOST_NAME.into(), source })?;
    UnitId::new(&name).map_err(Fatal::Nameless)
}

#[cfg(test)]
mod tests {
    use super::{EXIT_STATUS, Options};
    use bundle::Consent;
    use clap::Parser;
    use diagnostics::Exit;
    use std::io::Write;

    #[test]
    fn an_option_wins_over_the_updaters_config() {
        let mut file = tempfile::NamedTempFile::new().unwrap();
        writeln!(file, "unit = \"stairs\"\nstore = \"/a\"\nkeys = \"/b\"").unwrap();
        let path = file.path().to_str().unwrap();
        let options = ["dreams-update", "/media", "--config", path, "--unit", "lobby", "--store", "/c"];
        let order = Options::parse_from(options).order().unwrap();
        assert_eq!((order.unit.as_str(), order.consent), ("lobby", Consent::Newer));
        let config = order.config;
        assert_eq!((config.store.to_str(), config.keys.to_str()), (Some("/c"), Some("/b")));
        assert_eq!(
            Options::parse_from(["dreams-update", "/media", "--config", path]).order().unwrap().unit.as_str(),
            "stairs"
        );
        assert!(Options::try_parse_from(["dreams-update", "/media", "--unit", "The Lobby"]).is_err());
        let earlier =
            Options::parse_from(["dreams-update", "/media", "--card", "a", "--unit", "lobby"]).order().unwrap();
        assert_eq!(earlier.notice.as_deref(), Some(std::path::Path::new("a")), "the option has its earlier name too");
    }

    #[test]
    fn what_another_version_has_kept_takes_nothing_else_away_from_an_update() {
        let folder = tempfile::tempdir().unwrap();
        let [config, owner] = ["update.toml", "dreams.toml"].map(|name| folder.path().join(name));
        std::fs::write(&config, format!("owner = '{}'\n", owner.display())).unwrap();
        let key = "RWQy3+khO/aeoan0+vYoGE2vsmEBxY8VExI8+6bTi1Y6xEJXDYvODn+o";
        let later = "colour = 7\nurl = 'ipfs://flocks'\nreport_to = { a = 7 }\nreport_votes = true\n[later]\na = 1\n";
        let text = format!("unit = 'attic'\nproxy = 'http://proxy:1'\nkeys = ['{key}', 'ed448:7']\n{later}");
        std::fs::write(&owner, text).unwrap();
        let options = ["dreams-update", "/media", "--config", config.to_str().unwrap()];
        let order = Options::parse_from(options).order().unwrap();
        assert_eq!((order.unit.as_str(), order.owners_keys.len()), ("attic", 1));
        assert_eq!((order.config.proxy.as_deref(), order.config.report_to), (Some("http://proxy:1"), None));
    }

    #[test]
    fn the_updaters_help_names_every_exit_code() {
        for exit in [Exit::Fine, Exit::No, Exit::Malformed, Exit::Unreadable] {
            assert!(EXIT_STATUS.contains(&format!("\n  {}  ", exit as u8)));
        }
        assert_eq!(EXIT_STATUS.lines().count(), 5);
    }
}
