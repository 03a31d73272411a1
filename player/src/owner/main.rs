//! `dreams-owner`: takes in what the owner of a unit has set.
//!
//! Owns the order: read the owner's file, keep it if it is right, tell people if it is not, and tell the network and
//! the host name's service what the one that was kept says of them. What may be set is `player::owner`. Never changes the owner's file.
//!
//! Start at [`take_in`].
#![forbid(unsafe_code)]

use clap::Parser;
use player::config_file::ConfigError;
use player::ending::{Exit, chain, fail};
use player::notice::{Lasting, Notice};
use player::owner::{FILE_NAME, Owner, text_of};
use std::fs::{self, File};
use std::io::{self, ErrorKind, Write as _};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// What every command of the house says at the end of its help. `player::ending::Exit` has the same four.
const EXIT_STATUS: &str = "\
Exit status:
  0  the owner's settings are kept, or there are none
  1  never
  2  the command line or the owner's file is wrong: the last good settings stay
  3  a file could not be read or written";

/// Take in what the owner of a unit has set in `dreams.toml`
#[derive(Debug, Parser)]
#[command(name = "dreams-owner", version, after_help = EXIT_STATUS)]
struct Options {
    /// The folder with the owner's `dreams.toml`
    folder: PathBuf,
    /// Where the last good settings are kept
    #[arg(long, value_name = "FILE")]
    keep: PathBuf,
    /// Where the network manager is told what they say of it
    #[arg(long, value_name = "FILE")]
    network: PathBuf,
    /// Where the unit's host name is kept, if the owner has set one
    #[arg(long, value_name = "FILE")]
    name: PathBuf,
    /// Where people are told: what is wrong is told beside it, until it is right
    #[arg(long, value_name = "FILE")]
    card: PathBuf,
}

/// Why the settings were not taken in.
#[derive(Debug, thiserror::Error)]
enum Fatal {
    #[error(transparent)]
    Settings(#[from] ConfigError),
    #[error("cannot write `{path}`", path = path.display())]
    Write { path: PathBuf, source: io::Error },
}

fn main() -> ExitCode {
    let options = Options::parse();
    let taken = take_in(&options);
    let told = taken.inspect(|()| take_back(&options.card)).inspect_err(|fatal| warn_people(fatal, &options.card));
    let exit = told.and(tell_network(&options)).map_or_else(|fatal| ended(&fatal), |()| Exit::Fine);
    ExitCode::from(exit as u8)
}

/// Keeps what the owner has set, if it is right. Where there is no file, what was kept stays.
fn take_in(options: &Options) -> Result<(), Fatal> {
    let path = options.folder.join(FILE_NAME);
    let text = match text_of(&path) {
        Err(ConfigError::Read { source, .. }) if source.kind() == ErrorKind::NotFound => return Ok(()),
        text => text?,
    };
    Owner::parse(Path::new(FILE_NAME), &text)?;
    if fs::read_to_string(&options.keep).is_ok_and(|kept| kept == text) {
        return Ok(());
    }
    replace(&options.keep, &text)
}

/// Tells the network manager, and the service that sets the host name, what the kept settings say of it.
fn tell_network(options: &Options) -> Result<(), Fatal> {
    let owner = Owner::kept(&options.keep);
    tell(&options.network, owner.network())?;
    tell(&options.name, owner.host_name().map(|name| name + "\n"))
}

/// Has the file at `path` hold `text` and no other; or not be there, if there is no text.
fn tell(path: &Path, text: Option<String>) -> Result<(), Fatal> {
    match text {
        Some(text) => replace(path, &text),
        None => match fs::remove_file(path) {
            Err(source) if source.kind() != ErrorKind::NotFound => Err(Fatal::Write { path: path.to_owned(), source }),
            Ok(()) | Err(_) => Ok(()),
        },
    }
}

/// Writes `text` to `path`, whole or not at all, whatever happens to the machine.
fn replace(path: &Path, text: &str) -> Result<(), Fatal> {
    let write = || {
        let temporary = PathBuf::from(format!("{}.new", path.display()));
        let mut file = File::create(&temporary)?;
        file.write_all(text.as_bytes())?;
        file.sync_all()?;
        fs::rename(&temporary, path)?;
        File::open(path.parent().unwrap_or(Path::new(".")))?.sync_all()
    };
    write().map_err(|source| Fatal::Write { path: path.to_owned(), source })
}

/// Tells people in front of the picture what is wrong with their file.
fn warn_people(fatal: &Fatal, card: &Path) {
    let text = match fatal {
        Fatal::Settings(ConfigError::Malformed { line, key, .. }) => {
            format!("{FILE_NAME} is wrong in line {line}, at {key}. The settings before it stay.")
        }
        Fatal::Settings(ConfigError::Read { .. }) => {
            format!("{FILE_NAME} cannot be read. The settings before it stay.")
        }
        Fatal::Write { .. } => "The memory of this frame does not take the settings. The picture goes on.".to_owned(),
    };
    if let Err(error) = (Notice { text, thousandths: None }).tell(&Lasting::Settings.path(card)) {
        fail(&error, "nobody in front of the picture is told");
    }
}

/// What was told of the file is no longer true.
fn take_back(card: &Path) {
    if let Err(error) = Lasting::Settings.take_back(card) {
        fail(&error, "people in front of the picture are still told what is no longer wrong");
    }
}

/// Tells on standard error why it ends.
fn ended(fatal: &Fatal) -> Exit {
    match fatal {
        Fatal::Settings(ConfigError::Malformed { .. }) => {
            fail(fatal, "every key is explained in `config/dreams.toml`");
            Exit::Wrong
        }
        Fatal::Settings(ConfigError::Read { .. }) | Fatal::Write { .. } => {
            fail(fatal, &format!("what was kept before stays: {}", chain(fatal)));
            Exit::Unread
        }
    }
}
