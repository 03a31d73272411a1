//! Takes in what the owner of a unit has set.
//!
//! Owns the order: read the owner's file, keep it if it is right, tell people if it is not, and tell the network, the
//! radio, the host name's service and the counter of votes what it says of them. Never changes the owner's file, and never keeps a password
//! where others read.
//!
//! Start at [`run`].

use crate::sentences;
use clap::Args;
use diagnostics::{Exit, chain, print_error};
use player::{Lasting, Notice};
use settings::kept::{Kept, resolved_path};
use settings::owner::FILE_NAME;
use settings::owners_text::{NoText, OwnersText};
use settings::wifi::without_password;
use settings::{ConfigError, Owner};
use std::fs;
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

/// Who may read a file: all, the user and its group, or the user alone.
const ALL: u32 = 0o644;
const GROUP: u32 = 0o640;
const NOBODY_ELSE: u32 = 0o600;

/// Take in what stands in the owner's file
#[derive(Debug, Args)]
#[command(after_help = super::EXIT_STATUS)]
pub(crate) struct Options {
    /// The folder with the owner's `dreams.toml`
    folder: PathBuf,
    /// Where the last good settings are kept, without the password of a Wi-Fi; beside it, in a file of this name with
    /// `.kept`, as the other programs read them
    #[arg(long, value_name = "FILE")]
    keep: PathBuf,
    /// The folder for the settings of the network manager
    #[arg(long, value_name = "FOLDER")]
    network: PathBuf,
    /// Where the unit's host name is kept, if the owner has set one
    #[arg(long, value_name = "FILE")]
    name: PathBuf,
    /// Where the Wi-Fi is kept, with its password; beside it, with `.pem`, the certificates of its authorities
    #[arg(long, value_name = "FILE")]
    wifi: PathBuf,
    /// Where the settings of votes are kept, for their own user
    #[arg(long, value_name = "FILE")]
    votes: Option<PathBuf>,
    /// Where notices are written: what is wrong is told beside it, until it is right
    #[arg(long, alias = "card", value_name = "FILE")]
    notice: PathBuf,
}

/// Why the settings were not taken in.
#[derive(Debug, thiserror::Error)]
enum Fatal {
    #[error("`{name}` is not read: the file is called `{FILE_NAME}`")]
    Misnamed { name: String, is_beside: bool },
    #[error(transparent)]
    Settings(#[from] ConfigError),
    #[error("`{FILE_NAME}`: {0}")]
    Text(NoText),
    #[error("cannot write `{path}`", path = path.display())]
    Write { path: PathBuf, source: io::Error },
}

/// Takes the settings in; writes what is wrong with them to a notice and to standard error.
pub(crate) fn run(options: &Options) -> Exit {
    let taken = take_in(options);
    let told = taken.inspect(|()| take_back(&options.notice)).inspect_err(|fatal| warn_people(fatal, &options.notice));
    told.and(tell_others(options)).map_or_else(|fatal| ended(&fatal), |()| Exit::Fine)
}

/// Keeps what the owner has set, if it is right. Where there is no file, what was kept stays.
fn take_in(options: &Options) -> Result<(), Fatal> {
    let unread = |source| ConfigError::Read { path: options.folder.join(FILE_NAME), source };
    let OwnersText { text, misnamed } = OwnersText::read(&options.folder).map_err(unread)?;
    let text = text.transpose().map_err(Fatal::Text)?;
    text.as_deref().map_or(Ok(()), |text| keep(options, text))?;
    misnamed.map_or(Ok(()), |name| Err(Fatal::Misnamed { name, is_beside: text.is_some() }))
}

/// Keeps the settings in the owner's file `text`.
fn keep(options: &Options, text: &str) -> Result<(), Fatal> {
    let owner = Owner::parse(Path::new(FILE_NAME), text)?;
    // Only here is the password known: what is kept of the rest is for others to read.
    let (wifi, authorities) = (owner.wifi(), options.wifi.with_extension("pem"));
    let certificates = wifi.as_ref().and_then(|wifi| Some(wifi.enterprise.as_ref()?.authorities.pem()));
    tell(&authorities, certificates.as_deref(), ALL)?;
    tell(&options.wifi, wifi.map(|wifi| wifi.settings(&authorities)).as_deref(), NOBODY_ELSE)?;
    let Kept { first, resolved } = Kept::of(&without_password(text));
    // The first is enough for whoever reads before the second is there, or without it.
    tell(&options.keep, Some(&first), GROUP)?;
    tell(&resolved_path(&options.keep), Some(&resolved), GROUP)
}

/// Tells the network manager, the service that sets the host name, and the counter of votes, what the kept settings say of
/// it.
fn tell_others(options: &Options) -> Result<(), Fatal> {
    let owner = Owner::kept(&options.keep);
    tell(&options.network.join("wired.conf"), owner.wired().as_deref(), ALL)?;
    tell(&options.network.join("wireless.conf"), owner.wireless().as_deref(), ALL)?;
    if let Some(votes) = &options.votes {
        tell(votes, owner.votes().as_deref(), ALL)?;
    }
    tell(&options.name, owner.host_name().map(|name| name + "\n").as_deref(), ALL)
}

/// Whether the plain file at `path` holds just `text`.
pub(crate) fn is_there(path: &Path, text: &str) -> bool {
    durable::read_plain(path, text.len() as u64).is_ok_and(|there| there == text.as_bytes())
}

/// Makes the file at `path` hold `text`, with the rights of `mode`; or removes it, if there is no text. One that is so
/// already stays as it is.
fn tell(path: &Path, text: Option<&str>, mode: u32) -> Result<(), Fatal> {
    let unwritten = |source| Fatal::Write { path: path.to_owned(), source };
    match text {
        Some(text) if is_there(path, text) => Ok(()),
        Some(text) => durable::write_with_mode(path, text.as_bytes(), mode).map_err(unwritten),
        None => match fs::remove_file(path) {
            Err(source) if source.kind() != ErrorKind::NotFound => Err(unwritten(source)),
            Ok(()) | Err(_) => Ok(()),
        },
    }
}

/// Writes the notice that says what is wrong with the owner's file. It stays until that is put right; what nobody can put
/// right there leaves after its time.
fn warn_people(fatal: &Fatal, notice: &Path) {
    let lasting = Lasting::Settings.path(notice);
    let (path, text) = match fatal {
        Fatal::Misnamed { name, is_beside } => (&*lasting, sentences::of_misnamed(name, *is_beside)),
        Fatal::Settings(error) if is_of_the_disk(error) => (notice, sentences::of_settings(error)),
        Fatal::Settings(error) => (&*lasting, sentences::of_settings(error)),
        Fatal::Text(found) => (&*lasting, sentences::of_no_text(*found)),
        Fatal::Write { .. } => (notice, sentences::NO_MEMORY.to_owned()),
    };
    if path == notice {
        take_back(notice);
    }
    show(path, &text);
}

/// Writes a notice.
pub(crate) fn show(path: &Path, text: &str) {
    if let Err(error) = (Notice { text: text.to_owned(), thousandths: None }).tell(path) {
        print_error(&error, Some("cannot write the notice over the picture"));
    }
}

/// Whether the file could not be read for a reason that is not in the file.
fn is_of_the_disk(error: &ConfigError) -> bool {
    matches!(error, ConfigError::Read { source, .. } if source.kind() != ErrorKind::FileTooLarge)
}

/// Removes the notice that stays.
fn take_back(notice: &Path) {
    if let Err(error) = Lasting::Settings.take_back(notice) {
        print_error(&error, Some("cannot remove the notice over the picture"));
    }
}

/// Writes to standard error why it ends.
fn ended(fatal: &Fatal) -> Exit {
    match fatal {
        Fatal::Misnamed { .. } | Fatal::Settings(ConfigError::Malformed { .. }) | Fatal::Text(_) => {
            print_error(fatal, Some("every key is explained in `config/dreams.toml`"));
            Exit::Malformed
        }
        Fatal::Settings(ConfigError::Read { .. }) | Fatal::Write { .. } => {
            print_error(fatal, Some(&format!("what was kept before stays: {}", chain(fatal))));
            Exit::Unreadable
        }
    }
}
