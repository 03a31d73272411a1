//! Claims about the code itself.
//!
//! Owns the rules: which crate and folder depends on which, how a file is written, that facts written twice agree,
//! which licences are allowed, what the unit files promise. Never runs our programs.
//!
//! Start at [`layers`] and [`folders`] for the arrows, at [`sources`] for the rules that every file keeps.

mod disk;
mod facts;
mod folders;
mod layers;
mod layout;
mod licences;
mod packages;
pub(crate) mod page;
mod sources;
mod tiers;
mod tokens;
mod tracked;
mod units;
mod uses;

use std::fs;
use std::path::{Path, PathBuf};

use cargo_metadata::{Metadata, MetadataCommand};

/// The root of the repository.
fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("the package of the claims lies in the repository")
}

/// The text of the file at `path`, relative to the root of the repository.
fn read(path: &str) -> String {
    fs::read_to_string(root().join(path)).unwrap_or_else(|error| panic!("cannot read `{path}`: {error}"))
}

/// Every file of the repository whose name ends in `ending`, by its path, with its text; sorted.
fn files(ending: &str) -> Vec<(String, String)> {
    let mut found = Vec::new();
    collect(root(), ending, &mut found);
    found.sort();
    found
}

fn collect(folder: &Path, ending: &str, found: &mut Vec<(String, String)>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path: PathBuf = entry.unwrap().path();
        let name = path.file_name().unwrap().to_str().expect("our file names are UTF-8");
        if path.is_dir() && name != "target" && name != ".git" {
            collect(&path, ending, found);
        } else if path.is_file() && name.ends_with(ending) {
            let relative = path.strip_prefix(root()).unwrap().to_str().unwrap().to_owned();
            found.push((relative, fs::read_to_string(&path).unwrap()));
        }
    }
}

/// Our packages as cargo knows them; with `dependencies`, also everything that they depend on for this machine.
fn metadata(dependencies: bool) -> Metadata {
    let mut options = vec!["--locked".to_owned()];
    if dependencies {
        options.push("--all-features".to_owned());
        options.push(format!("--filter-platform={}-unknown-linux-gnu", std::env::consts::ARCH));
    } else {
        options.push("--no-deps".to_owned());
    }
    MetadataCommand::new().manifest_path(root().join("Cargo.toml")).other_options(options).exec().unwrap()
}

/// The lines of the Markdown section under `heading`, up to the next heading of any level.
fn section<'text>(document: &'text str, heading: &str) -> Vec<&'text str> {
    let mut lines = document.lines();
    lines.find(|line| *line == heading).unwrap_or_else(|| panic!("no section `{heading}`"));
    lines.take_while(|line| !line.starts_with('#')).collect()
}

/// The words of `line` in backticks.
fn quoted(line: &str) -> Vec<&str> {
    line.split('`').skip(1).step_by(2).collect()
}
