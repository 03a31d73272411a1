//! A flock that clips are imported into, and the folder that they are imported from.
//!
//! Owns both folders, the import as a command, and clips that ffmpeg makes for it. The claims on imports are in `import.rs`
//! and `import_choices.rs`.
//!
//! Start at [`ImportFolders::new`].

use claims::programs::{self, json, output, succeed};
use serde_json::Value;
use std::fs;
use std::path::PathBuf;
use std::process::Command;

/// A flock, and a folder beside it with what is imported.
pub(crate) struct ImportFolders {
    pub(crate) scratch: tempfile::TempDir,
}

impl ImportFolders {
    /// An empty flock with clips of `size` at 30 frames per second.
    pub(crate) fn new(size: &str) -> Self {
        let folders = Self { scratch: tempfile::tempdir().unwrap() };
        fs::create_dir(folders.inbox()).unwrap();
        folders.start(size);
        folders
    }

    /// Begins the flock, which is not there.
    pub(crate) fn start(&self, size: &str) {
        succeed(Command::new(programs::dreams()).arg("new").arg(self.flock()).args(["--size", size, "--fps", "30"]));
    }

    pub(crate) fn flock(&self) -> PathBuf {
        self.scratch.path().join("aurora")
    }

    pub(crate) fn inbox(&self) -> PathBuf {
        self.scratch.path().join("inbox")
    }

    pub(crate) fn manifest(&self) -> String {
        fs::read_to_string(self.flock().join("flock.toml")).unwrap()
    }

    /// `dreams import FLOCK WORDS...`, in the folder `inbox`.
    pub(crate) fn import(&self, words: &[&str]) -> Command {
        let mut import = Command::new(programs::dreams());
        import.arg("import").arg(self.flock()).args(words).current_dir(self.inbox());
        import
    }

    /// Its answer; it must end with `code`.
    pub(crate) fn answer(&self, code: i32, words: &[&str]) -> Value {
        self.answer_and_notes(code, words).0
    }

    /// The same, and what it says on standard error.
    pub(crate) fn answer_and_notes(&self, code: i32, words: &[&str]) -> (Value, String) {
        let said = output(self.import(words).arg("--json"));
        let error = String::from_utf8_lossy(&said.stderr).into_owned();
        assert_eq!(said.status.code(), Some(code), "{words:?}: {error}{}", String::from_utf8_lossy(&said.stdout));
        (json(&said), error)
    }

    /// Makes `name` in the inbox: `frames` frames of the pictures of the filter `source`.
    pub(crate) fn film(&self, name: &str, source: &str, frames: usize, settings: &[&str]) -> PathBuf {
        let path = self.inbox().join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        let mut ffmpeg = Command::new("ffmpeg");
        ffmpeg.args(["-v", "error", "-nostdin", "-y", "-f", "lavfi", "-i", source, "-frames:v", &frames.to_string()]);
        succeed(ffmpeg.args(settings).arg(&path));
        path
    }

    /// The faults of clips by `dreams check`.
    pub(crate) fn clip_faults(&self) -> Vec<Value> {
        let said = output(Command::new(programs::dreams()).arg("check").arg(self.flock()).arg("--json"));
        if !self.manifest().contains("[[sheep]]") {
            return Vec::new();
        }
        let faults = json(&said)["faults"].as_array().unwrap().clone();
        faults.into_iter().filter(|fault| fault["clip"].is_string()).collect()
    }
}
