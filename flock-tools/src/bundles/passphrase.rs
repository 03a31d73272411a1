//! Passphrases: what opens a secret key.
//!
//! Owns where one comes from: the terminal, unseen, or the first line of a file that nobody else can read. Never keeps
//! one, and takes none from the command line or the environment, where others could see it.
//!
//! Start at [`known`].

use std::fs::{self, File};
use std::io::{self, Read};
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

use bundle::SecretKey;

use super::unusable;
use crate::program::{Exit, Fatal};

/// Bytes of a file with a passphrase.
const LONGEST: u64 = 4 << 10;
/// What others must not be able to do with it.
const OTHERS: u32 = 0o077;

/// Why there is no passphrase.
#[derive(Debug, thiserror::Error)]
enum Unasked {
    #[error("the two passphrases differ")]
    Differ,
    #[error("the passphrase of key `{key}` is empty")]
    Empty { key: PathBuf },
    #[error("the passphrase in `{path}` can be read by others (mode {mode:04o}, wanted 0600)")]
    Open { path: PathBuf, mode: u32 },
    #[error("cannot read the passphrase in `{path}`")]
    Read { path: PathBuf, source: io::Error },
    #[error("cannot ask for the passphrase of key `{key}`")]
    Terminal { key: PathBuf, source: io::Error },
}

/// The secret key in the file `path`, opened with the passphrase in `file`, or else with one that is asked for.
pub(super) fn known(path: &Path, file: Option<&Path>) -> Result<SecretKey, Fatal> {
    let from_file = file.map(read).transpose()?;
    let mut unasked = None;
    let ask = || match from_file {
        Some(passphrase) => Ok(passphrase),
        None => ask(path, "Passphrase of").or_else(|error| {
            unasked = Some(error);
            Ok(String::new())
        }),
    };
    let read = SecretKey::read(path, ask);
    if let Some(error) = unasked {
        return Err(error);
    }
    read.map_err(unusable)
}

/// A passphrase for the key that will lie at `path`: that in `file`, or else one that is asked for twice.
pub(super) fn new(path: &Path, file: Option<&Path>) -> Result<String, Fatal> {
    let passphrase = file.map_or_else(|| ask(path, "New passphrase of"), read)?;
    if file.is_none() && ask(path, "Once more, the passphrase of")? != passphrase {
        return Err(Fatal::new(Exit::No, Unasked::Differ));
    }
    if passphrase.is_empty() {
        return Err(Fatal::new(Exit::No, Unasked::Empty { key: path.to_owned() }));
    }
    Ok(passphrase)
}

fn ask(key: &Path, what: &str) -> Result<String, Fatal> {
    rpassword::prompt_password(format!("{what} {}: ", key.display())).map_err(|source| {
        let unasked = Unasked::Terminal { key: key.to_owned(), source };
        Fatal::new(Exit::Unreadable, unasked).hint("--passphrase-file takes it from a file")
    })
}

/// The first line of `file`, which others may not be able to read. What is no plain file, a pipe, is taken as it is.
fn read(file: &Path) -> Result<String, Fatal> {
    let unread = |source| Fatal::new(Exit::Unreadable, Unasked::Read { path: file.to_owned(), source });
    let status = fs::metadata(file).map_err(unread)?;
    let mode = status.mode() & 0o7777;
    if status.is_file() && mode & OTHERS != 0 {
        let open = Unasked::Open { path: file.to_owned(), mode };
        return Err(Fatal::new(Exit::No, open).hint(format!("chmod 600 {}", file.display())));
    }
    let mut text = String::new();
    File::open(file).and_then(|file| file.take(LONGEST).read_to_string(&mut text)).map_err(unread)?;
    Ok(text.lines().next().unwrap_or_default().to_owned())
}
