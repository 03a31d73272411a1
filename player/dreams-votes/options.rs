//! The command line of `dreams-votes`.
//!
//! Owns the options and their help. The settings are in `config.rs`.

use crate::config::Config;
use clap::Parser;
use player::MarkSocket;
use settings::{ButtonDevice, ConfigError, Key, Owner, config_file};
use std::path::PathBuf;

/// The end of the help. `diagnostics::Exit` has the same four codes.
const EXIT_STATUS: &str = "\
Exit status:
  0  the run ended as asked: by a signal, or there is no device to read
  1  the answer is no: there are no votes to show
  2  the command line or the config is wrong
  3  the store could not be read or written";

/// Count the votes of the people before the wall: a press of a button is one for the sheep that was seen
#[derive(Debug, Parser)]
#[command(name = "dreams-votes", version, after_help = EXIT_STATUS)]
pub(crate) struct Options {
    /// Read settings from this file
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
    /// Count nothing: print exactly what would be sent
    #[arg(long)]
    pub(crate) show: bool,
    /// Count nothing: write the same to `votes.json` in this folder, if there are votes
    #[arg(long, value_name = "FOLDER", conflicts_with = "show")]
    pub(crate) copy_to: Option<PathBuf>,
    /// Read this store of votes
    #[arg(long, value_name = "FOLDER")]
    store: Option<PathBuf>,
}

impl Options {
    /// The settings: the defaults, then the config, then what the owner has set, then the options. An owner's button
    /// comes with its keys: the config's are those of another.
    /// Errors: [`ConfigError`], if there is a config and it is refused.
    pub(crate) fn settings(&self) -> Result<Config, ConfigError> {
        let config = self.config.as_deref().map(config_file::load::<Config>).transpose()?.unwrap_or_default();
        let owner = Owner::kept(&config.owner);
        let (device, up, down) = match owner.button {
            Some(device) => (Some(device), owner.button_up.unwrap_or(Key::ANY), owner.button_down),
            None => (config.device, config.up, config.down),
        };
        let presence = match owner.presence {
            Some(ButtonDevice::At(path)) => Some(path),
            Some(ButtonDevice::Any) | None => config.presence,
        };
        let acknowledge = if owner.acknowledge == Some(false) { MarkSocket(None) } else { config.acknowledge };
        let noise = owner.vote_noise.unwrap_or(config.noise);
        let store = self.store.clone().unwrap_or(config.store);
        Ok(Config { device, up, down, presence, acknowledge, noise, store, ..config })
    }
}

#[cfg(test)]
mod tests {
    use super::{EXIT_STATUS, Options};
    use crate::config::Config;
    use clap::Parser;
    use diagnostics::Exit;
    use player::MarkSocket;
    use settings::{ButtonDevice, Key};
    use std::fs;
    use std::path::PathBuf;

    #[test]
    fn the_help_on_votes_names_every_exit_code() {
        for exit in [Exit::Fine, Exit::No, Exit::Malformed, Exit::Unreadable] {
            assert!(EXIT_STATUS.contains(&format!("\n  {}  ", exit as u8)));
        }
        assert_eq!(EXIT_STATUS.lines().count(), 5);
    }

    #[test]
    fn an_owners_button_wins_over_the_configs_with_all_its_keys() {
        let folder = tempfile::tempdir().unwrap();
        let [config, owner] = ["votes.toml", "dreams.toml"].map(|name| folder.path().join(name));
        fs::write(&config, format!("owner = '{}'\ndevice = '/dev/pedal'\nup = 1\ndown = 2\n", owner.display()))
            .unwrap();
        let settings = |text: &str| {
            fs::write(&owner, text).unwrap();
            let Config { device, up, down, noise, .. } =
                Options::parse_from(["dreams-votes", "--config", config.to_str().unwrap()]).settings().unwrap();
            (device.unwrap(), up, down, noise)
        };
        let pedal = (ButtonDevice::At("/dev/pedal".into()), Key(Some(1)), Some(Key(Some(2))), false);
        assert_eq!(settings("unit = 'lobby'"), pedal);
        assert_eq!(settings("button = 'any'"), (ButtonDevice::Any, Key::ANY, None, false));
        let all = "button = '/dev/remote'\nbutton_up = 3\nbutton_down = 4\nvote_noise = true";
        let remote = (ButtonDevice::At("/dev/remote".into()), Key(Some(3)), Some(Key(Some(4))), true);
        assert_eq!(settings(all), remote);
        let later = format!("{all}\nacknowledge = 'green'\ncolour = 7\n[later]\na = 1");
        assert_eq!(settings(&later), remote, "what another version has added or changed takes nothing else away");
    }

    #[test]
    fn an_owner_can_name_a_sensor_and_leave_out_the_mark() {
        let folder = tempfile::tempdir().unwrap();
        let [config, owner] = ["votes.toml", "dreams.toml"].map(|name| folder.path().join(name));
        let config_text = format!("owner = '{}'\npresence = '/dev/mat'\n", owner.display());
        fs::write(&config, config_text).unwrap();
        let settings = |text: &str| {
            fs::write(&owner, text).unwrap();
            let Config { device, presence, acknowledge, .. } =
                Options::parse_from(["dreams-votes", "--config", config.to_str().unwrap()]).settings().unwrap();
            (device.is_some(), presence.unwrap(), acknowledge)
        };
        let [mat, sensor] = ["/dev/mat", "/dev/sensor"].map(PathBuf::from);
        assert_eq!(settings("button = 'any'"), (true, mat.clone(), MarkSocket::default()));
        assert_eq!(settings("button = 'any'\nacknowledge = true"), (true, mat.clone(), MarkSocket::default()));
        assert_eq!(settings("button = 'any'\nacknowledge = false"), (true, mat, MarkSocket(None)));
        assert_eq!(settings("presence = '/dev/sensor'"), (false, sensor, MarkSocket::default()));
    }
}
