//! A unit with its store and a stick, and `dreams-update` on them.
//!
//! Owns the folder of all that, and what an update leaves there. Never plays: that is [`crate::player_run`].
//!
//! Start at [`Unit::new`].

use crate::bundle_maker::{BundleMaker, Files, files_in};
use crate::programs::{self, json, output};
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use tempfile::TempDir;

/// A unit called `lobby`, with its store and a stick.
pub struct Unit {
    folder: TempDir,
    pub maker: BundleMaker,
}

impl Unit {
    /// A unit without a flock.
    pub fn new() -> Self {
        let folder = tempfile::tempdir_in(programs::claims_folder()).unwrap();
        fs::create_dir(folder.path().join("stick")).unwrap();
        Self { folder, maker: BundleMaker::with_new_keys() }
    }

    /// The folder of everything else.
    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// The stick.
    pub fn stick(&self) -> PathBuf {
        self.path("stick")
    }

    /// `dreams-update SOURCE`, or without one, with a notice and a JSON answer.
    pub fn update_from(&self, source: Option<&Path>) -> Command {
        let mut command = Command::new(programs::updater());
        command.args(["--json", "--unit", "lobby"]).args(source);
        for (option, value) in [("--store", "store"), ("--notice", "notice")] {
            command.arg(option).arg(self.path(value));
        }
        command.arg("--keys").arg(self.maker.keys());
        command
    }

    /// Updates from the stick.
    pub fn update(&self, options: &[&str]) -> Output {
        output(self.update_from(Some(&self.stick())).args(options))
    }

    /// Updates from the stick, which must succeed; returns the answer.
    pub fn updated(&self, options: &[&str]) -> Value {
        let said = self.update(options);
        assert_eq!(said.status.code(), Some(0), "{}", String::from_utf8_lossy(&said.stderr));
        json(&said)
    }

    /// The notice.
    pub fn notice(&self) -> Option<String> {
        let text = fs::read_to_string(self.path("notice")).ok()?;
        let notice: Value = serde_json::from_str(&text).unwrap();
        Some(notice["text"].as_str().unwrap().to_owned())
    }

    /// The installed flock, as the player finds it.
    pub fn playing(&self) -> Option<Files> {
        let current = self.path("store").join(bundle::CURRENT);
        current.exists().then(|| files_in(&current).unwrap())
    }
}
