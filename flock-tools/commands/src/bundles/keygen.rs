//! `dreams keygen`: keys that sign, and statements of one key about another.
//!
//! Owns the command. The form of a key is minisign's; the bundle crate writes it. Never signs a bundle: `pack` does.

use std::collections::BTreeSet;
use std::fs::OpenOptions;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use bundle::{KeyId, PublicKey, SecretKey, Statement, limits};
use operations::program::{Exit, Fatal, print};

use super::{key_fatal, passphrase};

/// The ending of the public key's file.
const PUBLIC: &str = "pub";
/// The ending of a statement by which one key takes in another.
const TRUSTED: &str = "trusted";
/// The ending of a statement by which a key is called back.
const REVOKED: &str = "revoked";

/// Make a key that signs bundles; have an old key take in a new one, or call one back
///
/// The secret key is written to FILE, locked by a passphrase and readable by you alone. The public key is written
/// beside it, with the ending `.pub`: units are given that one. Both have the form of minisign. With --signed-by, the
/// old key vouches for the new one in a statement with the ending `.trusted`. With --revoke, a key is called back by
/// itself, or by a key that took it in, in a statement with the ending `.revoked`. `dreams pack --statement` sends
/// statements to the units.
///
/// The keys that a key took in stay trusted when it is called back: that is right for an old key that is replaced. A
/// thief of a key may have had it take in other keys: with --stolen all keys that it took in are called back too,
/// except those that --keep names. `docs/sending.md` has the steps after a theft.
#[derive(Debug, clap::Args)]
#[command(after_help = "Exit status:
  0  the key, or the statement, is written
  1  the key that signs does not open, or others can read it; or the passphrase is empty
  2  the command line is wrong, or a file is no key
  3  a file could not be read or written, or is there already")]
pub struct Args {
    /// The new secret key's file
    #[arg(required_unless_present = "revoke", conflicts_with = "revoke")]
    file: Option<PathBuf>,
    /// The secret key that vouches for the new one, or calls one back
    #[arg(long, value_name = "KEY")]
    signed_by: Option<PathBuf>,
    /// Call back the key in this public key's file
    #[arg(long, value_name = "PUB", requires = "signed_by")]
    revoke: Option<PathBuf>,
    /// It was stolen: call back all keys that it took in, too
    #[arg(long, requires = "revoke", conflicts_with = "file")]
    stolen: bool,
    /// A key that it took in and that stays trusted, by its public key's file; may be repeated
    #[arg(long, value_name = "PUB", requires = "stolen", conflicts_with = "file")]
    keep: Vec<PathBuf>,
    /// Take the new key's passphrase from the first line of this file
    #[arg(long, value_name = "FILE", conflicts_with = "revoke")]
    passphrase_file: Option<PathBuf>,
    /// Take the passphrase of the key that signs from the first line of this file
    #[arg(long, value_name = "FILE", requires = "signed_by")]
    signer_passphrase_file: Option<PathBuf>,
    /// Answer with one JSON document
    #[arg(long)]
    json: bool,
}

/// More keys are to stay than a statement can hold.
#[derive(Debug, thiserror::Error)]
#[error("--keep names {kept} keys, at most {} are allowed", limits::KEPT)]
struct TooManyKept {
    kept: usize,
}

/// The answer with `--json`.
#[derive(Default, serde::Serialize)]
struct Answer {
    id: Option<KeyId>,
    #[serde(skip_serializing_if = "Option::is_none")]
    secret: Option<PathBuf>,
    #[serde(skip_serializing_if = "Option::is_none")]
    public: Option<PathBuf>,
    #[serde(skip_serializing_if = "Option::is_none")]
    statement: Option<PathBuf>,
}

/// Runs the command.
pub fn run(args: &Args) -> Result<Exit, Fatal> {
    let signer = || match &args.signed_by {
        Some(key) => passphrase::open_key(key, args.signer_passphrase_file.as_deref()).map(Some),
        None => Ok(None),
    };
    let answer = match (&args.file, &args.revoke) {
        (Some(file), _) => make(file, args.passphrase_file.as_deref(), signer()?.as_ref())?,
        (None, Some(public)) => {
            let id = PublicKey::read(public).map_err(key_fatal)?.id();
            let statements = revocation(args, id)?;
            let statement = signer()?.map(|key| write_statements(&statements, &key, public, REVOKED));
            Answer { id: Some(id), statement: statement.transpose()?, ..Answer::default() }
        }
        (None, None) => Answer::default(),
    };
    if args.json {
        print::json(&answer)?;
    } else {
        let id = answer.id.map(|id| format!("key         {id}"));
        let line = |what: &str, path: &PathBuf| format!("{what:<12}{}", path.display());
        let files = [("secret key", &answer.secret), ("public key", &answer.public), ("statement", &answer.statement)];
        let files = files.iter().filter_map(|(what, path)| path.as_ref().map(|path| line(what, path)));
        print::lines(id.into_iter().chain(files))?;
    }
    Ok(Exit::Fine)
}

/// A new key in `file`, which `signer` vouches for.
fn make(file: &Path, passphrase_file: Option<&Path>, signer: Option<&SecretKey>) -> Result<Answer, Fatal> {
    let (public, trusted) = (file.with_extension(PUBLIC), file.with_extension(TRUSTED));
    let others = [&*public, &*trusted];
    // Before the artist is asked for a passphrase.
    let there = others.into_iter().chain([file]).find(|path| path.exists());
    if let Some(taken) = there.or(others.contains(&file).then_some(file)) {
        return Err(Fatal::write(taken, io::ErrorKind::AlreadyExists.into()));
    }
    let passphrase = passphrase::new(file, passphrase_file)?;
    let key = SecretKey::create(file, &passphrase).map_err(key_fatal)?.public();
    write(&public, key.to_text().as_bytes())?;
    let statement = signer.map(|signer| write_statements(&[Statement::Trust(key.clone())], signer, file, TRUSTED));
    let (id, secret) = (Some(key.id()), Some(file.to_owned()));
    Ok(Answer { id, secret, public: Some(public), statement: statement.transpose()? })
}

/// The statements that call back the key `id`. Units with older systems read the first of two only.
fn revocation(args: &Args, id: KeyId) -> Result<Vec<Statement>, Fatal> {
    let mut statements = vec![Statement::Revoke(id)];
    if args.stolen {
        let kept: BTreeSet<PublicKey> =
            args.keep.iter().map(|path| PublicKey::read(path)).collect::<Result<_, _>>().map_err(key_fatal)?;
        if kept.len() > limits::KEPT {
            return Err(Fatal::new(Exit::Malformed, TooManyKept { kept: kept.len() }));
        }
        statements.push(Statement::Stolen(id, kept));
    }
    Ok(statements)
}

/// Signs `statements` with `key`, in a file named after `about`.
fn write_statements(statements: &[Statement], key: &SecretKey, about: &Path, ending: &str) -> Result<PathBuf, Fatal> {
    let path = about.with_extension(ending);
    let signed = statements.iter().map(|statement| statement.sign(key)).collect::<Result<Vec<_>, _>>();
    write(&path, &signed.map_err(key_fatal)?.concat())?;
    Ok(path)
}

/// Writes a new file.
fn write(path: &Path, bytes: &[u8]) -> Result<(), Fatal> {
    let write = || -> io::Result<()> {
        let mut file = OpenOptions::new().write(true).create_new(true).open(path)?;
        file.write_all(bytes)?;
        file.sync_all()
    };
    write().map_err(|source| Fatal::write(path, source))
}
