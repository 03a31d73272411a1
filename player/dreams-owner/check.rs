//! The check of an owner's file that no unit has yet.
//!
//! Owns the verdict on one file of any name, by the rules that a unit applies to its `dreams.toml`. Never keeps or prints a
//! value.
//!
//! Start at [`run`]; `image-build/build` runs it.

use clap::Args;
use diagnostics::{Exit, print_error};
use settings::owners_text::{NoText, OwnersText};
use settings::{ConfigError, Owner};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Check an owner's file, and print the keys that it sets, one a line
#[derive(Debug, Args)]
#[command(after_help = super::EXIT_STATUS)]
pub(crate) struct Options {
    /// The file, of any name
    file: PathBuf,
}

/// Why a file was refused.
#[derive(Debug, thiserror::Error)]
enum Fatal {
    #[error(transparent)]
    Settings(#[from] ConfigError),
    #[error("`{path}`: {found}", path = path.display())]
    Text { path: PathBuf, found: NoText },
    #[error("cannot write to standard output")]
    Unwritten(#[source] io::Error),
}

/// Checks the file; writes what is wrong with it to standard error.
pub(crate) fn run(options: &Options) -> Exit {
    match keys(&options.file).and_then(|keys| print(&keys)) {
        Ok(()) => Exit::Fine,
        Err(error @ (Fatal::Settings(ConfigError::Read { .. }) | Fatal::Unwritten(_))) => {
            print_error(&error, None);
            Exit::Unreadable
        }
        Err(error @ (Fatal::Settings(ConfigError::Malformed { .. }) | Fatal::Text { .. })) => {
            print_error(&error, Some("`config/dreams.toml` explains every key"));
            Exit::Malformed
        }
    }
}

fn print(keys: &[String]) -> Result<(), Fatal> {
    let mut lines = keys.join("\n");
    if !keys.is_empty() {
        lines.push('\n');
    }
    io::stdout().write_all(lines.as_bytes()).map_err(Fatal::Unwritten)
}

/// The keys that the file at `path` sets, in alphabetical order.
fn keys(path: &Path) -> Result<Vec<String>, Fatal> {
    let unread = |source| ConfigError::Read { path: path.to_owned(), source };
    let text = OwnersText::read_file(path).map_err(unread)?;
    let text = text.map_err(|found| Fatal::Text { path: path.to_owned(), found })?;
    Owner::parse(path, &text)?;
    let table: toml::Table = toml::from_str(&text).expect("the text was parsed a line before");
    Ok(table.into_iter().map(|(key, _)| key).collect())
}
