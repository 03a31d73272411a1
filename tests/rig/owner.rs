//! An owner's partition, and `dreams-owner` on it.
//!
//! Owns the folder of both, and what a unit keeps of the settings.
//!
//! Start at [`Settings::set`].

use crate::programs::{self, claims_folder, output};
use std::fs;
use std::path::PathBuf;
use std::process::Command;
use tempfile::TempDir;

/// An owner's partition, and what a unit keeps of it.
pub struct Settings {
    scratch: TempDir,
}

impl Settings {
    pub fn new() -> Self {
        let scratch = tempfile::tempdir_in(claims_folder()).unwrap();
        fs::create_dir(scratch.path().join("partition")).unwrap();
        Self { scratch }
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.scratch.path().join(name)
    }

    /// `dreams-owner` on the partition.
    pub fn taking(&self) -> Command {
        let mut owner = Command::new(programs::owner());
        owner.arg("take-in").arg(self.path("partition")).arg("--keep").arg(self.path("kept"));
        owner.arg("--network").arg(self.path("")).arg("--name").arg(self.path("name"));
        owner.arg("--wifi").arg(self.path("wifi.conf")).arg("--votes").arg(self.path("votes.toml"));
        owner.arg("--notice").arg(self.path("notice"));
        owner
    }

    /// The exit code and the output of `dreams-owner` for an owner's file `text`.
    pub fn set(&self, text: &str) -> (Option<i32>, String) {
        fs::write(self.path("partition/dreams.toml"), text).unwrap();
        let said = output(&mut self.taking());
        (said.status.code(), String::from_utf8(said.stderr).unwrap())
    }

    pub fn read(&self, name: &str) -> Option<String> {
        fs::read_to_string(self.path(name)).ok()
    }

    /// What the notice on a mistake in the settings says.
    pub fn told(&self) -> Option<String> {
        let notice: serde_json::Value = serde_json::from_str(&self.read("notice.settings")?).unwrap();
        Some(notice["text"].as_str().unwrap().to_owned())
    }
}
