//! Secret keys: how an artist signs.
//!
//! Creates keys, reads and writes their files (minisign's format, encrypted with a passphrase through scrypt), and
//! signs. Trying a passphrase costs as much as with minisign: a gigabyte for some seconds. A file that others can read
//! is refused. The caller asks for the passphrase. Units do not use this module.
//!
//! Start at [`SecretKey::read`].

use std::fmt;
use std::fs::{self, File, OpenOptions};
use std::io::{self, Cursor, Read, Write};
use std::ops::Range;
use std::os::unix::fs::{MetadataExt, OpenOptionsExt};
use std::path::Path;

use minisign::{KeyPair, SecretKeyBox};

use crate::key::{KeyError, PublicKey};
use crate::limits;
use crate::signed::UNTRUSTED_COMMENT;

/// Mode bits that a secret key's file must not have.
const GROUP_AND_OTHERS: u32 = 0o077;

/// Offsets in a decoded secret key: the KDF's name, salt and limits, and the encrypted part.
const KDF: Range<usize> = 2..4;
const SALT: Range<usize> = 6..38;
const OPSLIMIT: Range<usize> = 38..46;
const MEMLIMIT: Range<usize> = 46..54;
const LOCKED: Range<usize> = 54..158;
/// scrypt.
const SCRYPT: [u8; 2] = *b"Sc";

/// The cost of the KDF.
struct Cost {
    /// As in files: salsa20 cores, and bytes.
    opslimit: u64,
    memlimit: u64,
    /// The logarithm of scrypt's N that this means; r is 8 and p is 1.
    log_n: u8,
}

/// The cost of the minisign tool.
const FULL: Cost = Cost { opslimit: 1 << 25, memlimit: 1 << 30, log_n: 20 };
/// For the empty passphrase, which no cost protects.
const NONE: Cost = Cost { opslimit: 1 << 20, memlimit: 1 << 25, log_n: 15 };

/// A secret key. `Debug` prints its id only.
pub struct SecretKey {
    secret: minisign::SecretKey,
    public: PublicKey,
}

impl SecretKey {
    /// Creates a new key and writes it to `path`, encrypted with `passphrase` and readable by its owner only.
    ///
    /// # Errors
    /// [`KeyError::Write`] if there is such a file already, or it cannot be written; [`KeyError::Sign`] if the
    /// system gives no randomness.
    pub fn create(path: &Path, passphrase: &str) -> Result<Self, KeyError> {
        let KeyPair { pk, sk } = KeyPair::generate_unencrypted_keypair().map_err(|e| sign(&e))?;
        let public = public(path, &pk)?;
        let text = locked(&sk, passphrase)?
            .to_box(Some(&format!("minisign encrypted secret key {}", public.id())))
            .map_err(|e| sign(&e))?;
        let write = || -> io::Result<()> {
            let mut file = OpenOptions::new().write(true).create_new(true).mode(0o600).open(path)?;
            file.write_all(&text.to_bytes())?;
            file.sync_all()
        };
        write().map_err(|source| KeyError::Write { path: path.to_owned(), source })?;
        // Check that the written key can be decrypted.
        Self::read(path, || Ok(passphrase.to_owned()))
    }

    /// Reads the key in the file `path` and decrypts it with the passphrase from `ask`.
    ///
    /// # Errors
    /// [`KeyError`]: above all if others could read the file, in which case nobody is asked.
    pub fn read(path: &Path, ask: impl FnOnce() -> Result<String, KeyError>) -> Result<Self, KeyError> {
        let unread = |source| KeyError::Read { path: path.to_owned(), source };
        let malformed = || KeyError::Malformed { path: path.to_owned(), kind: "locked secret key" };
        let mode = fs::metadata(path).map_err(unread)?.mode() & 0o7777;
        if mode & GROUP_AND_OTHERS != 0 {
            // A public key given by mistake may be readable by others.
            let is_public = PublicKey::read(path).is_ok();
            return Err(if is_public { malformed() } else { KeyError::Open { path: path.to_owned(), mode } });
        }
        let bytes = durable::read_plain(path, limits::SECRET_KEY).map_err(unread)?;
        let text = String::from_utf8(bytes).map_err(|_| malformed())?;
        let locked = SecretKeyBox::from_string(&text).map_err(|_| malformed())?;
        let passphrase = ask()?;
        let secret = minisign::SecretKey::from_box(locked, Some(passphrase)).map_err(|error| {
            if matches!(error.kind(), minisign::ErrorKind::Verify) {
                KeyError::Locked { path: path.to_owned() }
            } else {
                malformed()
            }
        })?;
        let pk = minisign::PublicKey::from_secret_key(&secret).map_err(|e| sign(&e))?;
        Ok(Self { secret, public: public(path, &pk)? })
    }

    /// The public key for its signatures.
    pub fn public(&self) -> PublicKey {
        self.public.clone()
    }

    /// `text`, signed: four lines of signature, then the text. `comment` is covered by the signature.
    /// Errors: [`KeyError::Sign`] if there is no randomness.
    pub(crate) fn sign(&self, comment: &str, text: &str) -> Result<Vec<u8>, KeyError> {
        let signature = minisign::sign(None, &self.secret, Cursor::new(text), Some(comment), Some(UNTRUSTED_COMMENT))
            .map_err(|e| sign(&e))?;
        Ok(format!("{}\n{text}", signature.to_string().trim_end()).into_bytes())
    }
}

impl fmt::Debug for SecretKey {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("SecretKey").field("id", &self.public.id()).finish_non_exhaustive()
    }
}

/// The secret key, encrypted with the passphrase, as in its file.
fn locked(secret: &minisign::SecretKey, passphrase: &str) -> Result<minisign::SecretKey, KeyError> {
    let failed = |why: String| KeyError::Sign { why };
    let cost = if passphrase.is_empty() { NONE } else { FULL };
    let mut bytes = secret.to_bytes();
    bytes[KDF].copy_from_slice(&SCRYPT);
    bytes[OPSLIMIT].copy_from_slice(&cost.opslimit.to_le_bytes());
    bytes[MEMLIMIT].copy_from_slice(&cost.memlimit.to_le_bytes());
    let random = File::open("/dev/urandom").and_then(|mut random| random.read_exact(&mut bytes[SALT]));
    random.map_err(|error| failed(error.to_string()))?;
    let params = scrypt::Params::new(cost.log_n, 8, 1, scrypt::Params::RECOMMENDED_LEN);
    let mut stream = [0; LOCKED.end - LOCKED.start];
    scrypt::scrypt(passphrase.as_bytes(), &bytes[SALT], &params.expect("they are in range"), &mut stream)
        .expect("its length is one that scrypt gives");
    for (byte, key) in bytes[LOCKED].iter_mut().zip(stream) {
        *byte ^= key;
    }
    minisign::SecretKey::from_bytes(&bytes).map_err(|e| sign(&e))
}

fn public(path: &Path, key: &minisign::PublicKey) -> Result<PublicKey, KeyError> {
    PublicKey::parse(&key.to_base64())
        .ok_or_else(|| KeyError::Malformed { path: path.to_owned(), kind: "locked secret key" })
}

fn sign(error: &minisign::PError) -> KeyError {
    KeyError::Sign { why: error.to_string() }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use ct_codecs::{Base64, Decoder};
    use std::fs::Permissions;
    use std::os::unix::fs::PermissionsExt;

    /// A file of an older `dreams keygen`, with a lower cost: of the key 7F6F7B501F4A54A9.
    const OLD: &str = include_str!("../../../tests/fixtures/keys/artist.key");

    /// A key without a file, for tests: encryption with scrypt is slow.
    fn bare() -> SecretKey {
        let KeyPair { pk, sk } = KeyPair::generate_unencrypted_keypair().unwrap();
        SecretKey { secret: sk, public: PublicKey::parse(&pk.to_base64()).unwrap() }
    }

    /// The artist, the same within a test run.
    pub(crate) fn artist() -> &'static SecretKey {
        static ARTIST: std::sync::OnceLock<SecretKey> = std::sync::OnceLock::new();
        ARTIST.get_or_init(bare)
    }

    /// Somebody else each time.
    pub(crate) fn stranger() -> SecretKey {
        bare()
    }

    #[test]
    fn a_key_opens_with_its_passphrase_and_no_other() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("artist.key");
        let made = SecretKey::create(&path, "velvet").unwrap();
        let read = SecretKey::read(&path, || Ok("velvet".to_owned())).unwrap();
        assert_eq!(made.public(), read.public());
        assert!(matches!(SecretKey::read(&path, || Ok("Velvet".to_owned())), Err(KeyError::Locked { .. })));
        assert!(matches!(SecretKey::create(&path, "x"), Err(KeyError::Write { .. })), "no key is overwritten");
        let secret = fs::read_to_string(&path).unwrap();
        let bytes = Base64::decode_to_vec(secret.lines().nth(1).unwrap(), None).unwrap();
        let limits = [OPSLIMIT, MEMLIMIT].map(|at| u64::from_le_bytes(bytes[at].try_into().unwrap()));
        assert_eq!(limits, [33_554_432, 1_073_741_824], "a guess costs what the minisign tool has it cost");
        assert!(!format!("{made:?}").contains(secret.lines().nth(1).unwrap()));
    }

    #[test]
    fn a_key_that_was_locked_at_less_cost_before_is_read() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("old.key");
        fs::write(&path, OLD).unwrap();
        fs::set_permissions(&path, Permissions::from_mode(0o600)).unwrap();
        let read = SecretKey::read(&path, || Ok("velvet".to_owned())).unwrap();
        assert_eq!(read.public().id().to_string(), "7F6F7B501F4A54A9");
    }

    #[test]
    fn a_key_that_others_can_read_is_refused_before_anybody_is_asked() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("artist.key");
        fs::write(&path, "whatever").unwrap();
        for mode in [0o644, 0o640, 0o604, 0o620, 0o601] {
            fs::set_permissions(&path, Permissions::from_mode(mode)).unwrap();
            let refused = SecretKey::read(&path, || panic!("asked")).unwrap_err();
            assert!(matches!(refused, KeyError::Open { mode: found, .. } if found == mode), "{refused}");
        }
        fs::write(&path, artist().public().to_text()).unwrap();
        let refused = SecretKey::read(&path, || panic!("asked")).unwrap_err();
        assert!(matches!(refused, KeyError::Malformed { .. }), "a public key is no secret: {refused}");
    }
}
