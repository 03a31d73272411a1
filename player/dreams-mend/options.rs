//! The command line of `dreams-mend`.
//!
//! Owns the options and their help. Never acts on them.

use bundle::Version;
use clap::{Parser, ValueEnum};
use std::path::PathBuf;

/// The end of the help. `diagnostics::Exit` has the same four codes.
pub(crate) const EXIT_STATUS: &str = "\
Exit status:
  0  everything is whole, or whole again
  1  something is damaged, and there is nothing to mend it from
  2  the command line is wrong
  3  a file or a device could not be read or written; another attempt goes on from there";

/// How much is looked through.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Look {
    /// What the firmware starts, on both boot partitions
    Boot,
    /// That, and every byte of both slots
    All,
}

/// Look through what this unit starts from, and mend what is damaged from what is whole
#[derive(Debug, Parser)]
#[command(name = "dreams-mend", version, after_help = EXIT_STATUS)]
pub(crate) struct Options {
    /// How much is looked through
    #[arg(value_enum)]
    pub(crate) look: Look,
    /// The folder of the boot partition to which new systems are written
    #[arg(long, value_name = "DIR")]
    pub(crate) boot: PathBuf,
    /// The folder of the spare boot partition, where there is one
    #[arg(long, value_name = "DIR")]
    pub(crate) spare: Option<PathBuf>,
    /// A slot; there are two
    #[arg(long, value_name = "DEVICE")]
    pub(crate) slot: Vec<PathBuf>,
    /// A folder with the boot loader as it lies on a boot partition
    #[arg(long, value_name = "DIR")]
    pub(crate) loader: PathBuf,
    /// The version of the system that runs, which is a good one
    #[arg(long, value_name = "VERSION", value_parser = Version::parse)]
    pub(crate) running: Version,
    /// Write a notice for the picture to this file, if something was damaged, or a newer system was left
    #[arg(long, alias = "card", value_name = "FILE")]
    pub(crate) notice: Option<PathBuf>,
    /// Remember in this file which newer system this unit has left, and why
    #[arg(long, value_name = "FILE")]
    pub(crate) rollback: Option<PathBuf>,
    /// Answer with one JSON document
    #[arg(long)]
    pub(crate) json: bool,
}

#[cfg(test)]
mod tests {
    use super::{EXIT_STATUS, Options};
    use clap::Parser;
    use diagnostics::Exit;
    use std::path::Path;

    #[test]
    fn the_option_for_the_notice_has_its_earlier_name_too() {
        let words = ["dreams-mend", "boot", "--boot", "b", "--loader", "l", "--running", "0.1.0", "--card", "n"];
        assert_eq!(Options::parse_from(words).notice.as_deref(), Some(Path::new("n")));
    }

    #[test]
    fn the_help_names_every_exit_code() {
        for exit in [Exit::Fine, Exit::No, Exit::Malformed, Exit::Unreadable] {
            assert!(EXIT_STATUS.contains(&format!("\n  {}  ", exit as u8)));
        }
        assert_eq!(EXIT_STATUS.lines().count(), 5);
    }
}
