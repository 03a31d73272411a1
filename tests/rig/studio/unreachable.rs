//! A flock in which not every sheep can be reached, and `dreams prune` on it.
//!
//! Owns that flock.

use super::sheep::ring;
use crate::programs::{self, succeed};
use serde_json::Value;
use std::fmt::Write;
use std::fs;
use std::path::Path;
use std::process::Command;
use tempfile::TempDir;

/// A flock of a ring of six, and of two sheep that lead into it and are never reached.
pub fn flock() -> TempDir {
    let folder = ring("meadow", 6, 1);
    let mut text = fs::read_to_string(folder.path().join("flock.toml")).unwrap();
    for (id, to) in [("x0", "x1"), ("x1", "s0")] {
        write!(text, "\n[[sheep]]\nid = \"{id}\"\nframes = 768\nclip = \"loops/{id}.mp4\"\n").unwrap();
        write!(text, "\n[[transition]]\nfrom = \"{id}\"\nto = \"{to}\"\nframes = 384\nclip = \"t/{id}.mp4\"\n")
            .unwrap();
    }
    fs::write(folder.path().join("flock.toml"), text).unwrap();
    folder
}

/// The answer of `dreams prune`.
pub fn prune(folder: &Path, options: &[&str]) -> Value {
    let said = succeed(Command::new(programs::dreams()).arg("prune").arg(folder).arg("--json").args(options));
    serde_json::from_slice(&said).unwrap()
}
