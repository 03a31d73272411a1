//! Makes bundles: flocks, signed and laid into folders, as sticks and servers have them.
//!
//! Owns the keys of the claims' artists. The clips may be rubbish: an updater does not look inside.
//!
//! Start at [`BundleMaker::bundle`].

use bundle::{Folder, KeyId, Letter, SecretKey, Statement};
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use tempfile::TempDir;

#[path = "../crates/bundle/tests/it/folders.rs"]
mod folders;

/// The files of a flock, by path.
pub type Files = BTreeMap<String, Vec<u8>>;

/// Signs bundles; it has a folder of the keys that units trust.
pub struct BundleMaker {
    folder: TempDir,
    artist: SecretKey,
    stranger: SecretKey,
}

impl BundleMaker {
    /// One with keys of its own; units trust the artist's.
    pub fn with_new_keys() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let key = |name: &str| SecretKey::create(&folder.path().join(name), "").unwrap();
        let (artist, stranger) = (key("artist"), key("stranger"));
        let trusted = folder.path().join("trusted");
        fs::create_dir(&trusted).unwrap();
        fs::write(trusted.join("artist.pub"), artist.public().to_text()).unwrap();
        Self { folder, artist, stranger }
    }

    /// The folder of trusted keys.
    pub fn keys(&self) -> PathBuf {
        self.folder.path().join("trusted")
    }

    /// Lays a bundle of `files` into `folder`, signed by the artist, for `units`, or for all if there are none.
    pub fn bundle(&self, folder: &Path, files: &Files, units: &[&str], sequence: u64) {
        folders::lay(&self.artist, folder, files, units, sequence);
    }

    /// The same, signed by somebody whom no unit knows.
    pub fn forgery(&self, folder: &Path, files: &Files, units: &[&str], sequence: u64) {
        folders::lay(&self.stranger, folder, files, units, sequence);
    }

    /// The seal that says `letter`, signed by the artist.
    pub fn sign(&self, letter: &Letter) -> Vec<u8> {
        letter.sign(&self.artist).unwrap()
    }

    /// Lays out the artist's word that the stranger may be trusted.
    pub fn vouch(&self, folder: &Path) {
        self.say(folder, &Statement::Trust(self.stranger.public()));
    }

    /// Lays out the artist's word that the stranger, whom she has taken in, is called back.
    pub fn call_back(&self, folder: &Path) {
        self.say(folder, &Statement::Revoke(self.stranger()));
    }

    /// What the stranger's key is called.
    pub fn stranger(&self) -> KeyId {
        self.stranger.public().id()
    }

    fn say(&self, folder: &Path, said: &Statement) {
        let word = said.sign(&self.artist).unwrap();
        Folder::create(folder).unwrap().add_statements(&[word]).unwrap();
    }
}

/// A flock of so many sheep, each with a loop of `bytes` bytes of rubbish; those below `edition` differ from edition to
/// edition.
pub fn rubbish(sheep: usize, bytes: usize, edition: usize) -> Files {
    let mut toml = "format = 1\nname = \"aurora\"\nsize = [64, 64]\nfps = [30, 1]\n".to_owned();
    let mut files = Files::new();
    for at in 0..sheep {
        let clip = format!("loops/{at}.mp4");
        write!(toml, "[[sheep]]\nid = \"{at}\"\nframes = 9\nclip = \"{clip}\"\n").unwrap();
        let seed = format!("clip {at} of edition {}", if at < edition { edition } else { 0 });
        let mut content = vec![0; bytes];
        blake3::Hasher::new().update(seed.as_bytes()).finalize_xof().fill(&mut content);
        files.insert(clip, content);
    }
    files.insert("flock.toml".to_owned(), toml.into_bytes());
    files
}

/// Every file beneath `folder`.
///
/// # Errors
/// What the disk says.
pub fn files_in(folder: &Path) -> io::Result<Files> {
    folders::files_in(folder)
}
