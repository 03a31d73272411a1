//! `dreams report` of a flock that is written for it.
//!
//! Owns the manifests and the page's file. A browser opens it in `slow/tools/report.rs`.
//!
//! Start at [`report`] and [`bare`].

use crate::programs::{self, output};
use std::collections::HashSet;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// What `dreams` answers with `args` about the flock in `folder`.
pub fn dreams(args: &[&str], folder: &Path) -> Output {
    output(Command::new(programs::dreams()).args(args).arg(folder))
}

/// Makes the report of the flock in `folder`, which must end with `status`; returns the page's file.
pub fn report(folder: &Path, status: i32) -> (tempfile::TempDir, PathBuf) {
    let scratch = tempfile::tempdir().unwrap();
    let page = scratch.path().join("a page.html");
    let said = dreams(&["report", "--out", page.to_str().unwrap()], folder);
    assert_eq!(said.status.code(), Some(status), "{}", String::from_utf8_lossy(&said.stderr));
    (scratch, page)
}

/// A folder with this manifest only.
pub fn written(manifest: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("flock.toml"), manifest).unwrap();
    folder
}

/// A manifest without clips: `n` sheep in a ring, each with `chords` more transitions.
pub fn bare(n: usize, chords: usize) -> String {
    let mut text = "format = 1\nname = \"bare\"\nsize = [1280, 720]\nfps = [30, 1]\n".to_owned();
    for sheep in 0..n {
        writeln!(text, "[[sheep]]\nid = \"s.{sheep}\"\nframes = 768\nclip = \"s{sheep}.mp4\"").unwrap();
        for to in (0..=chords).map(|chord| (sheep + 1 + chord * (7 + sheep % 5)) % n).collect::<HashSet<_>>() {
            let ends = format!("from = \"s.{sheep}\"\nto = \"s.{to}\"");
            writeln!(text, "[[transition]]\n{ends}\nframes = 384\nclip = \"t{sheep}-{to}.mp4\"").unwrap();
        }
    }
    text
}
