//! Signed settings on a stick.
//!
//! Owns the order: the signature by a key of the image that was not revoked, the unit's name, the number, and then the
//! owner's file, read as strictly as on the owner's partition. Keys that only the owner's file has added do not count:
//! whoever may send flocks need not be somebody who may move the unit to another network. What is right waits for the
//! owner's partition, in [`Inbox`]. Never writes to the stick or to the partition: `install.rs` does the latter.
//!
//! Start at [`run`].

use crate::inbox::{Arrived, Inbox};
use crate::sentences;
use crate::take_in::show;
use bundle::{
    Folder, FolderError, KeyError, KeyId, NameError, Refusal, Sequence, StoreError, Trust, UnitId, UnverifiedSettings,
    few, with_learned,
};
use clap::Args;
use diagnostics::{Exit, print_error};
use player::host_name;
use serde::Deserialize;
use settings::owner::FILE_NAME;
use settings::owners_text::{NoText, decoded};
use settings::{ConfigError, Owner, config_file};
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

/// Take the settings for this unit from a stick: signed by a key of its image, and newer than those before
#[derive(Debug, Args)]
#[command(after_help = super::EXIT_STATUS)]
pub(crate) struct Options {
    /// The folder of the stick
    stick: PathBuf,
    /// The settings of the updater: which keys count, where the store is, and what the unit is called
    #[arg(long, value_name = "FILE")]
    config: PathBuf,
    /// Where the last good settings are kept
    #[arg(long, value_name = "FILE")]
    keep: PathBuf,
    /// The folder in which settings wait for the owner's partition
    #[arg(long, value_name = "FOLDER")]
    inbox: PathBuf,
    /// Where notices are written
    #[arg(long, value_name = "FILE")]
    notice: PathBuf,
}

/// What this program needs of the updater's config. The updater reads the file strictly.
#[derive(Debug, Deserialize)]
#[serde(default)]
struct Config {
    keys: PathBuf,
    store: PathBuf,
    #[serde(deserialize_with = "config_file::unit")]
    unit: Option<UnitId>,
}

impl Default for Config {
    fn default() -> Self {
        Self { keys: "/etc/dreams/keys".into(), store: "/var/lib/dreams/store".into(), unit: None }
    }
}

/// How a stick was read to its end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Outcome {
    /// It has no settings.
    Nothing,
    /// This unit has had them.
    Known,
    /// They wait for the owner's partition.
    Arrived,
}

/// Why no settings were taken from a stick. What was kept before stays.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Fatal {
    #[error(transparent)]
    Config(ConfigError),
    #[error("the settings on the stick are for `{}`, this unit is `{unit}`", few(.units))]
    ForOthers { units: Vec<UnitId>, unit: UnitId },
    #[error("cannot read the host name")]
    Host(#[source] io::Error),
    #[error("cannot read or write the settings that wait in `{path}`", path = path.display())]
    Inbox { path: PathBuf, source: io::Error },
    #[error("cannot read the keys that this unit trusts")]
    Keys(#[source] KeyError),
    #[error("the settings on the stick are wrong")]
    Malformed(#[source] ConfigError),
    #[error("this unit has no name that settings could be signed for")]
    Nameless(#[source] NameError),
    #[error("the settings on the stick are no text that settings can be: {0}")]
    NoText(NoText),
    #[error("the settings have sequence {sequence}, but this unit has already had {last} of key {signer}")]
    Older { sequence: Sequence, last: Sequence, signer: KeyId },
    #[error("the settings on the stick are refused")]
    Refused(#[source] Refusal),
    #[error("cannot read the stick")]
    Stick(#[source] FolderError),
    #[error("cannot read what this unit knows of revoked keys")]
    Store(#[source] StoreError),
}

/// Reads the stick, and writes a notice about settings that do not come on from here.
pub(crate) fn run(options: &Options) -> Exit {
    let ended = arrive(options);
    let said = match &ended {
        Ok(Outcome::Arrived | Outcome::Nothing) => None,
        Ok(Outcome::Known) => Some(sentences::KNOWN.to_owned()),
        Err(fatal) => Some(sentences::of_stick(fatal)),
    };
    if let Some(said) = said {
        show(&options.notice, &said);
    }
    ended.map_or_else(|fatal| refused(&fatal), |_| Exit::Fine)
}

/// Has the settings of the stick wait, if they are for this unit, right and new.
fn arrive(options: &Options) -> Result<Outcome, Fatal> {
    let mut stick = Folder::open(&options.stick).map_err(Fatal::Stick)?;
    let there = stick.settings().map_err(Fatal::Stick)?;
    if there.is_empty() {
        return Ok(Outcome::Nothing);
    }
    let config: Config = config_file::load(&options.config).map_err(Fatal::Config)?;
    let unit = unit(&options.keep, &config)?;
    let Some(unverified) = UnverifiedSettings::open(&mut stick, &unit).map_err(Fatal::Refused)? else {
        return Err(Fatal::ForOthers { units: there.into_iter().flatten().collect(), unit });
    };
    let signed = unverified.verify(&trust(&config)?).map_err(Fatal::Refused)?;
    let (signer, body) = (signed.signer(), signed.body());
    body.addressees.admit(&unit, None).map_err(Fatal::Refused)?;
    let failed = |source| Fatal::Inbox { path: options.inbox.clone(), source };
    let inbox = Inbox::open(&options.inbox).map_err(failed)?;
    let sequence = body.sequence;
    match inbox.last(signer).map_err(failed)? {
        Some(last) if last == sequence => return Ok(Outcome::Known),
        Some(last) if last > sequence => return Err(Fatal::Older { sequence, last, signer }),
        Some(_) | None => {}
    }
    let text = decoded(body.text.as_bytes()).map_err(Fatal::NoText)?;
    Owner::parse(Path::new(FILE_NAME), &text).map_err(Fatal::Malformed)?;
    inbox.put(&Arrived { signer, sequence, text }).map_err(failed)?;
    Ok(Outcome::Arrived)
}

/// What this unit is called: by its owner, by its config, or by itself.
fn unit(keep: &Path, config: &Config) -> Result<UnitId, Fatal> {
    if let Some(unit) = Owner::kept(keep).unit.or_else(|| config.unit.clone()) {
        return Ok(unit);
    }
    UnitId::new(&host_name().map_err(Fatal::Host)?).map_err(Fatal::Nameless)
}

/// The keys whose settings count: those of the image, with what the store has learned of them.
fn trust(config: &Config) -> Result<Trust, Fatal> {
    let pinned = match Trust::read(&config.keys) {
        Err(KeyError::Read { source, .. }) if source.kind() == ErrorKind::NotFound => Trust::default(),
        read => read.map_err(Fatal::Keys)?,
    };
    with_learned(&pinned, &config.store).map_err(Fatal::Store)
}

/// Writes to standard error why it ends.
fn refused(fatal: &Fatal) -> Exit {
    print_error(fatal, Some("what was kept before stays"));
    match fatal {
        Fatal::Refused(refused) if refused.is_io() => Exit::Unreadable,
        Fatal::ForOthers { .. } | Fatal::Older { .. } | Fatal::Refused(_) => Exit::No,
        Fatal::Config(ConfigError::Malformed { .. })
        | Fatal::Keys(_)
        | Fatal::Malformed(_)
        | Fatal::Nameless(_)
        | Fatal::NoText(_) => Exit::Malformed,
        Fatal::Config(ConfigError::Read { .. })
        | Fatal::Host(_)
        | Fatal::Inbox { .. }
        | Fatal::Stick(_)
        | Fatal::Store(_) => Exit::Unreadable,
    }
}

#[cfg(test)]
mod tests {
    use super::Config;
    use settings::config_file::parse;
    use std::path::Path;

    #[test]
    fn the_updaters_config_has_the_same_defaults_here() {
        let sample: Config = parse(Path::new("update.toml"), include_str!("../../config/update.toml")).unwrap();
        let Config { keys, store, unit } = Config::default();
        assert_eq!((sample.keys, sample.store, sample.unit), (keys, store, unit));
    }
}
