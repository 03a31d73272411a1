//! Passphrases, which open secret keys.
//!
//! Owns where one comes from: the terminal, without echo, or the first line of a file that only its owner can read. Never
//! stores one, and takes none from the command line or the environment, where other users could see it.
//!
//! Start at [`open_key`].

use std::fs::{self, File};
use std::io::{self, Read};
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

use bundle::SecretKey;
use operations::program::{Exit, Fatal};

use super::key_fatal;

/// The most bytes of a file with a passphrase that are read.
const LONGEST: u64 = 4 << 10;
/// The permission bits of group and others, which must be off.
const OTHERS: u32 = 0o077;

/// Why there is no passphrase.
#[derive(Debug, thiserror::Error)]
enum PassphraseError {
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

/// The secret key in the file `path`, opened with the passphrase in `file`, or else with one from the terminal.
pub(super) fn open_key(path: &Path, file: Option<&Path>) -> Result<SecretKey, Fatal> {
    let from_file = file.map(read).transpose()?;
    let mut failed = None;
    let ask = || match from_file {
        Some(passphrase) => Ok(passphrase),
        None => ask(path, "Passphrase of").or_else(|error| {
            failed = Some(error);
            Ok(String::new())
        }),
    };
    let read = SecretKey::read(path, ask);
    if let Some(error) = failed {
        return Err(error);
    }
    read.map_err(key_fatal)
}

/// A passphrase for the new key at `path`: that in `file`, or else one that is typed twice.
pub(super) fn new(path: &Path, file: Option<&Path>) -> Result<String, Fatal> {
    let passphrase = file.map_or_else(|| ask(path, "New passphrase of"), read)?;
    if file.is_none() && ask(path, "Once more, the passphrase of")? != passphrase {
        return Err(Fatal::new(Exit::No, PassphraseError::Differ));
    }
    if passphrase.is_empty() {
        return Err(Fatal::new(Exit::No, PassphraseError::Empty { key: path.to_owned() }));
    }
    Ok(passphrase)
}

fn ask(key: &Path, what: &str) -> Result<String, Fatal> {
    rpassword::prompt_password(format!("{what} {}: ", key.display())).map_err(|source| {
        let error = PassphraseError::Terminal { key: key.to_owned(), source };
        Fatal::new(Exit::Unreadable, error).hint("--passphrase-file takes it from a file")
    })
}

/// The first line of `file`, which others must not be able to read. The permissions of a pipe are not checked.
fn read(file: &Path) -> Result<String, Fatal> {
    let unread = |source| Fatal::new(Exit::Unreadable, PassphraseError::Read { path: file.to_owned(), source });
    let status = fs::metadata(file).map_err(unread)?;
    let mode = status.mode() & 0o7777;
    if status.is_file() && mode & OTHERS != 0 {
        let open = PassphraseError::Open { path: file.to_owned(), mode };
        return Err(Fatal::new(Exit::No, open).hint(format!("chmod 600 {}", file.display())));
    }
    let mut text = String::new();
    File::open(file).and_then(|file| file.take(LONGEST).read_to_string(&mut text)).map_err(unread)?;
    Ok(text.lines().next().unwrap_or_default().to_owned())
}
