//! Makes bundles, signed, in folders like those on sticks and servers.
//!
//! Owns the keys that sign in the claims. Clips are random bytes: an updater does not decode them.
//!
//! Start at [`BundleMaker::bundle`].

use bundle::{Folder, KeyId, SealBody, SecretKey, Statement};
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use tempfile::TempDir;

#[path = "../../crates/bundle/tests/it/folders.rs"]
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
    /// One with new keys; units trust the artist's.
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

    /// Writes a bundle of `files` to `folder`, signed by the artist, for `units`, or for all units if there are none.
    pub fn bundle(&self, folder: &Path, files: &Files, units: &[&str], sequence: u64) {
        folders::lay(&self.artist, folder, files, units, sequence);
    }

    /// The same, signed by a key that units do not know.
    pub fn forgery(&self, folder: &Path, files: &Files, units: &[&str], sequence: u64) {
        folders::lay(&self.stranger, folder, files, units, sequence);
    }

    /// The seal with the text `letter`, signed by the artist.
    pub fn sign(&self, letter: &SealBody) -> Vec<u8> {
        letter.sign(&self.artist).unwrap()
    }

    /// Adds the artist's statement that the stranger's key may be trusted.
    pub fn vouch(&self, folder: &Path) {
        self.say(folder, &Statement::Trust(self.stranger.public()));
    }

    /// Adds the artist's statement that revokes the stranger's key.
    pub fn call_back(&self, folder: &Path) {
        self.say(folder, &Statement::Revoke(self.stranger()));
    }

    /// The id of the stranger's key.
    pub fn stranger(&self) -> KeyId {
        self.stranger.public().id()
    }

    fn say(&self, folder: &Path, said: &Statement) {
        let word = said.sign(&self.artist).unwrap();
        Folder::create(folder).unwrap().add_statements(&[word]).unwrap();
    }
}

/// A flock of `sheep` sheep, each with a loop of `bytes` random bytes; those with a number below `edition` differ from
/// edition to edition.
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

/// Every file below `folder`.
///
/// # Errors
/// The error of the file system.
pub fn files_in(folder: &Path) -> io::Result<Files> {
    folders::files_in(folder)
}
