//! What must hold whatever bytes a bundle is made of.
//!
//! Owns the functions that a fuzzer drives, and that `crates/bundle/tests/it/corpus.rs` drives over the corpus. Each
//! panics if something is accepted that should not be, or is read otherwise than it was written, and tells whether it
//! was accepted. Never looks at how the reading is done.
//!
//! Start at [`seal`].
#![allow(dead_code, clippy::unwrap_used, reason = "every target uses some of it, and fails by panicking")]

use std::collections::{BTreeMap, BTreeSet};
use std::io::{self, Cursor, Read};
use std::sync::OnceLock;

use bundle::{
    Addressees, ObjectId, PublicKey, Refusal, SealBody, SecretKey, Sequence, Source, Trust, UnitId, UnverifiedSeal,
    UnverifiedSettings, VerifiedBundle, limits, statements,
};

use crate::folders;

/// The comment that minisign writes in front of a signature.
const UNTRUSTED: &str = "signature from minisign secret key";

/// A key that signs whatever it is given, without the care that ours takes.
fn careless() -> &'static minisign::KeyPair {
    static KEY: OnceLock<minisign::KeyPair> = OnceLock::new();
    KEY.get_or_init(|| minisign::KeyPair::generate_unencrypted_keypair().unwrap())
}

/// Trusts the careless key.
fn trusting() -> Trust {
    Trust::of([PublicKey::parse(&careless().pk.to_base64()).unwrap()])
}

/// A key of ours.
fn artist() -> &'static SecretKey {
    static KEY: OnceLock<SecretKey> = OnceLock::new();
    KEY.get_or_init(|| {
        let folder = tempfile::tempdir().unwrap();
        SecretKey::create(&folder.path().join("artist.key"), "velvet").unwrap()
    })
}

/// `text`, whatever it is, under a good signature.
fn signed(text: &[u8]) -> Vec<u8> {
    let signature = minisign::sign(None, &careless().sk, Cursor::new(text), Some("fuzz"), Some(UNTRUSTED)).unwrap();
    [signature.to_string().trim_end().as_bytes(), b"\n", text].concat()
}

/// What stands below the four lines of a signature.
fn below_signature(signed: &[u8]) -> &[u8] {
    let ends: Vec<usize> = (0..signed.len()).filter(|at| signed[*at] == b'\n').collect();
    &signed[ends[3] + 1..]
}

/// A seal. As it is, nobody trusted has signed it; under a good signature it is refused, or says just what it says.
pub(crate) fn seal(data: &[u8]) -> bool {
    assert!(UnverifiedSeal::new(data).verify(&trusting()).is_err(), "accepted without a signature");
    let Ok(seal) = UnverifiedSeal::new(signed(data)).verify(&trusting()) else { return false };
    assert_eq!(below_signature(&seal.letter().sign(artist()).unwrap()), data, "read otherwise than it was written");
    true
}

/// Signed settings, in the same way.
pub(crate) fn settings(data: &[u8]) -> bool {
    assert!(UnverifiedSettings::new(data).verify(&trusting()).is_err(), "accepted without a signature");
    let Ok(settings) = UnverifiedSettings::new(signed(data)).verify(&trusting()) else { return false };
    assert_eq!(below_signature(&settings.body().sign(artist()).unwrap()), data, "read otherwise than it was written");
    assert!(settings.body().text.len() as u64 <= limits::SETTINGS);
    true
}

/// A list of files, as the artist signed it: refused, or read just as it is written, and safe to follow.
pub(crate) fn contents(data: &[u8]) -> bool {
    let id = ObjectId::of(data);
    let letter = SealBody {
        flock: "fuzz".to_owned(),
        addressees: Addressees::Anyone,
        sequence: Sequence(1),
        created: "2026-03-01T12:00:00Z".to_owned(),
        contents: id,
        contents_size: data.len() as u64,
        statements: None,
    };
    let Ok(bytes) = letter.sign(artist()) else { return false };
    let seal = UnverifiedSeal::new(bytes).verify(&Trust::of([artist().public()])).unwrap();
    let Ok(bundle) = seal.open(data.to_vec()) else { return false };
    let files = bundle.contents().files();
    assert_eq!(bundle.contents().to_text().as_bytes(), data, "read otherwise than it was written");
    assert!(files.len() <= limits::FILES && files.iter().all(|file| file.size <= limits::FILE));
    let paths: BTreeSet<&str> = files.iter().map(|file| file.path.as_str()).collect();
    assert_eq!(paths.len(), files.len(), "a path stands twice");
    for path in &paths {
        assert!(path.split('/').all(|part| !matches!(part, "" | "." | "..")), "`{path}` leads astray");
        assert!(!path.contains(['\\', '\0', '\n']) && path.len() <= limits::PATH, "`{path}` leads astray");
        let folders = path.match_indices('/').map(|(at, _)| &path[..at]);
        assert!(folders.into_iter().all(|folder| !paths.contains(folder)), "`{path}` lies in a file");
    }
    true
}

/// Statements about keys. As they are, nobody has said them; under a good signature each is refused, or changes one
/// key's standing at most.
pub(crate) fn statement(data: &[u8]) -> bool {
    let mut trust = trusting();
    let before = trust.clone();
    let said = statements(data);
    assert!(data.starts_with(&said.concat()));
    for statement in said {
        assert!(trust.learn(statement).is_err() && trust == before, "learned without a signature");
    }
    let learned = trust.learn(&signed(data)).is_ok();
    if learned {
        assert!((0..=2).contains(&trust.keys().count()));
    } else {
        assert_eq!(trust, before, "a statement that was refused was learned");
    }
    learned
}

/// A whole bundle that somebody had in their hands: `data` says what they did to it, four bytes for each deed: which
/// file, what, where. A unit takes it only if it is again what it was.
pub(crate) fn bundle(data: &[u8]) -> bool {
    let good = wares();
    let mut tampered = Stall(good.0.clone());
    let paths: Vec<String> = good.0.keys().cloned().collect();
    for deed in data.chunks_exact(4) {
        let path = &paths[usize::from(deed[0]) % paths.len()];
        let other = good.0[&paths[usize::from(deed[3]) % paths.len()]].clone();
        let Some(ware) = tampered.0.get_mut(path) else { continue };
        let at = usize::from(u16::from_le_bytes([deed[2], deed[3]])) % (ware.len() + 1);
        match deed[1] % 6 {
            0 if at < ware.len() => ware[at] ^= deed[3] | 1,
            1 => ware.truncate(at),
            2 => ware.insert(at, deed[3]),
            3 => *ware = other,
            4 => *ware = [&ware[..at], b"\n", &ware[at..]].concat(),
            5 => {
                tampered.0.remove(path);
            }
            _ => {}
        }
    }
    let taken = take(&mut tampered);
    if let Ok(files) = &taken {
        assert_eq!(*files, take(&mut wares().clone()).unwrap(), "accepted after {data:?}");
    }
    taken.is_ok()
}

/// What lies on a stick, by path.
#[derive(Clone)]
struct Stall(BTreeMap<String, Vec<u8>>);

/// A good bundle.
fn wares() -> &'static Stall {
    static WARES: OnceLock<Stall> = OnceLock::new();
    WARES.get_or_init(|| {
        let toml = b"format = 1\nname = \"fuzz\"\nsize = [64, 64]\nfps = [30, 1]\n\
                     [[sheep]]\nid = \"a\"\nframes = 9\nclip = \"a.mp4\"\n";
        let files = [("flock.toml".to_owned(), toml.to_vec()), ("a.mp4".to_owned(), b"a clip ".repeat(9))];
        let folder = tempfile::tempdir().unwrap();
        folders::lay(artist(), folder.path(), &files.into(), &["lobby"], 7);
        Stall(folders::files_in(folder.path()).unwrap())
    })
}

/// What a unit takes in: the bytes of every file, each of which was checked.
fn take(stall: &mut Stall) -> Result<BTreeMap<String, Vec<u8>>, Refusal> {
    let lobby = UnitId::new("lobby").unwrap();
    let trust = Trust::of([artist().public()]);
    let bundle: VerifiedBundle = UnverifiedSeal::open(stall, &lobby)?.verify(&trust)?.fetch(stall)?;
    let mut files = BTreeMap::new();
    for file in bundle.contents().files() {
        let part = bundle::Part::Object(file.id);
        let mut bytes = Vec::new();
        let read = stall
            .object(&file.id, file.size, 0)
            .and_then(|reader| reader.take(file.size + 1).read_to_end(&mut bytes))
            .map_err(|source| Refusal::Read { part: part.clone(), source });
        read?;
        let found = ObjectId::of(&bytes);
        if found != file.id {
            return Err(Refusal::Damaged { part, expected: file.id, found });
        }
        files.insert(file.path.to_string(), bytes);
    }
    bundle.flock(&files[flock_toml(&bundle)])?;
    Ok(files)
}

fn flock_toml(bundle: &VerifiedBundle) -> &str {
    let found = bundle.contents().files().iter().find(|file| file.path.as_str() == "flock.toml");
    found.expect("a list without a flock.toml is refused").path.as_str()
}

impl Source for Stall {
    fn small(&mut self, path: &str, _limit: u64) -> io::Result<Box<dyn Read + '_>> {
        let bytes = self.0.get(path).ok_or(io::ErrorKind::NotFound)?;
        Ok(Box::new(&bytes[..]))
    }

    fn object(&mut self, id: &ObjectId, _size: u64, from: u64) -> io::Result<Box<dyn Read + '_>> {
        let bytes = self.0.get(&id.path()).ok_or(io::ErrorKind::NotFound)?;
        let from = usize::try_from(from).unwrap_or(usize::MAX).min(bytes.len());
        Ok(Box::new(&bytes[from..]))
    }
}
