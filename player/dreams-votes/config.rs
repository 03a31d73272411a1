//! The config of `dreams-votes`: every setting and its default.
//!
//! Owns [`Config`]. Never acts on it. Every key explains itself in `config/votes.toml`, which a test holds equal to
//! [`Config::default`].

use player::{LogLevel, MarkSocket};
use serde::Deserialize;
use settings::button::{self, VOTES_FOLDER};
use settings::{ButtonDevice, Key};
use std::path::PathBuf;

/// Every setting, as `config/votes.toml` explains them.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct Config {
    pub(crate) owner: PathBuf,
    pub(crate) device: Option<ButtonDevice>,
    pub(crate) up: Key,
    #[serde(deserialize_with = "button::one")]
    pub(crate) down: Option<Key>,
    pub(crate) presence: Option<PathBuf>,
    pub(crate) acknowledge: MarkSocket,
    pub(crate) noise: bool,
    pub(crate) store: PathBuf,
    pub(crate) status: String,
    pub(crate) log: LogLevel,
}

impl Default for Config {
    fn default() -> Self {
        Self {
            owner: "/var/lib/dreams/owner/votes.toml".into(),
            device: None,
            up: Key::ANY,
            down: None,
            presence: None,
            acknowledge: MarkSocket::default(),
            noise: false,
            store: VOTES_FOLDER.into(),
            status: "127.0.0.1:7180".to_owned(),
            log: LogLevel(tracing::Level::INFO),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Config;
    use settings::config_file::parse;
    use std::path::Path;

    const SAMPLE: &str = include_str!("../../config/votes.toml");

    fn read(text: &str) -> Result<Config, String> {
        parse(Path::new("votes.toml"), text).map_err(|error| error.to_string())
    }

    #[test]
    fn the_sample_of_the_votes_is_its_default_and_explains_every_key_and_no_other() {
        assert_eq!(read(SAMPLE).unwrap(), Config::default());
        let key = |line: &str| {
            let (key, _) = line.trim_start_matches("# ").split_once(" = ")?;
            key.chars().all(|c| c.is_ascii_lowercase() || c == '_').then(|| key.to_owned())
        };
        let explained: Vec<_> = SAMPLE.lines().filter_map(key).collect();
        let refused = read("colour = 1").unwrap_err();
        let known = refused.split("expected one of ").nth(1).unwrap().split(", ");
        assert_eq!(explained, known.map(|key| key.trim_matches('`').to_owned()).collect::<Vec<_>>());
        let all = ["device", "down", "presence"].iter().fold(SAMPLE.to_owned(), |text, key| {
            assert!(text.contains(&format!("\n# {key} = ")), "{key}");
            text.replace(&format!("\n# {key} = "), &format!("\n{key} = "))
        });
        let config = read(&all).unwrap();
        assert!(config.device.is_some() && config.down.is_some() && config.presence.is_some());
    }

    #[test]
    fn what_the_owner_says_of_votes_is_read_where_it_is_written() {
        let unit = include_str!("../../systemd/dreams-owner@.service");
        let option = format!(" --votes {} ", Config::default().owner.display());
        assert!(unit.contains(&option), "`{option}` is no part of the service");
    }
}
