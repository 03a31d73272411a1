//! The config of the updater: every setting, its default and its range.
//!
//! Owns [`Config`]. Never acts on it. Every key explains itself in `config/update.toml`, which a test holds equal to
//! [`Config::default`].

use crate::schedule::Window;
use bundle::UnitId;
use player::LogLevel;
use player::clock::{SYNCHRONISED, SYSTEM};
use serde::Deserialize;
use settings::config_file::unit;
use std::ops::RangeInclusive;
use std::path::PathBuf;

/// Minutes between two looks, about.
pub(crate) const EVERY_MINUTES: RangeInclusive<u64> = 1..=60 * 24 * 31;
/// Bytes a second, in KiB, that an update may take; 0 for no limit.
pub(crate) const BANDWIDTH_KIB: RangeInclusive<u64> = 0..=1 << 24;
/// Room that stays free, in MiB.
pub(crate) const RESERVE_MIB: RangeInclusive<u64> = 0..=1 << 20;

/// Every setting of the updater, as `config/update.toml` explains them.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct Config {
    pub(crate) store: PathBuf,
    pub(crate) keys: PathBuf,
    pub(crate) system_keys: PathBuf,
    #[serde(deserialize_with = "unit")]
    pub(crate) unit: Option<UnitId>,
    pub(crate) owner: PathBuf,
    pub(crate) system: PathBuf,
    pub(crate) synchronised: PathBuf,
    pub(crate) url: Option<String>,
    #[serde(deserialize_with = "every_minutes")]
    pub(crate) every_minutes: u64,
    pub(crate) window: Option<Window>,
    pub(crate) proxy: Option<String>,
    pub(crate) authorities: PathBuf,
    #[serde(deserialize_with = "bandwidth_kib")]
    pub(crate) bandwidth_kib: u64,
    #[serde(deserialize_with = "reserve_mib")]
    pub(crate) reserve_mib: u64,
    pub(crate) report_to: Option<String>,
    pub(crate) votes: Option<PathBuf>,
    pub(crate) status: String,
    pub(crate) machine: PathBuf,
    pub(crate) log: LogLevel,
}

impl Default for Config {
    fn default() -> Self {
        Self {
            store: "/var/lib/dreams/store".into(),
            keys: "/etc/dreams/keys".into(),
            system_keys: "/etc/dreams/system-keys".into(),
            unit: None,
            owner: "/var/lib/dreams/owner/dreams.toml".into(),
            system: SYSTEM.into(),
            synchronised: SYNCHRONISED.into(),
            url: None,
            every_minutes: 360,
            window: None,
            proxy: None,
            authorities: "/etc/ssl/certs/ca-certificates.crt".into(),
            bandwidth_kib: 0,
            reserve_mib: 256,
            report_to: None,
            votes: None,
            status: "127.0.0.1:7180".to_owned(),
            machine: "/".into(),
            log: LogLevel(tracing::Level::INFO),
        }
    }
}

settings::ranged! {
    every_minutes -> u64: EVERY_MINUTES;
    bandwidth_kib -> u64: BANDWIDTH_KIB;
    reserve_mib -> u64: RESERVE_MIB;
}

#[cfg(test)]
mod tests {
    use super::Config;
    use settings::config_file::parse;
    use std::path::Path;

    const SAMPLE: &str = include_str!("../../config/update.toml");

    fn read(text: &str) -> Result<Config, String> {
        parse(Path::new("update.toml"), text).map_err(|error| error.to_string())
    }

    /// The keys that the sample explains, also those it leaves out by a leading `# `.
    fn keys_of_the_sample() -> Vec<String> {
        let key = |line: &str| {
            let (key, _) = line.trim_start_matches("# ").split_once(" = ")?;
            key.chars().all(|c| c.is_ascii_lowercase() || c == '_').then(|| key.to_owned())
        };
        SAMPLE.lines().filter_map(key).collect()
    }

    #[test]
    fn the_updaters_sample_is_its_default_and_explains_every_key_and_no_other() {
        assert_eq!(read(SAMPLE).unwrap(), Config::default());
        assert_eq!(read("").unwrap(), Config::default());
        let refused = read("no_such_key = 1").unwrap_err();
        let known = refused.split("expected one of ").nth(1).unwrap().split(", ");
        let known: Vec<_> = known.map(|key| key.trim_matches('`').to_owned()).collect();
        assert_eq!(keys_of_the_sample(), known);
        assert!(known.len() <= 20, "{} keys are too many to explain to an installer", known.len());
        let uncommented: String = SAMPLE.lines().map(|line| line.trim_start_matches("# ").to_owned() + "\n").collect();
        let left_out = |key: &str| uncommented.lines().find(|line| line.starts_with(&format!("{key} = "))).unwrap();
        assert!(read(left_out("unit")).unwrap().unit.is_some());
        assert!(read(left_out("url")).unwrap().url.is_some());
        assert!(read(left_out("window")).unwrap().window.is_some());
        assert!(read(left_out("proxy")).unwrap().proxy.is_some());
        assert!(read(left_out("report_to")).unwrap().report_to.is_some());
        let players = include_str!("../../config/player.toml");
        let status = format!("status = \"{}\"", Config::default().status);
        assert!(players.lines().any(|line| line == status), "the player's status page is where it is looked for");
    }

    #[test]
    fn a_value_out_of_range_or_a_name_that_is_none_is_refused_with_its_line() {
        let said = read("\nreserve_mib = -1\n").unwrap_err();
        assert!(said.starts_with("`update.toml` line 2, key `reserve_mib`: "), "{said}");
        assert!(said.ends_with("`-1`, expected a number from 0 to 1048576"), "{said}");
        let said = read("unit = \"The Lobby\"").unwrap_err();
        assert!(said.contains("key `unit`") && said.contains("found `The Lobby`"), "{said}");
    }
}
