//! The command line of `dreams-install`.
//!
//! Owns the options and their help. Never acts on them.

use crate::copying::Sum;
use clap::{Parser, ValueEnum};
use std::array;
use std::path::PathBuf;

/// The end of the help. `diagnostics::Exit` has the same four codes.
pub(crate) const EXIT_STATUS: &str = "\
Exit status:
  0  the unit is on the disk, and the stick was removed
  1  not used
  2  the command line is wrong, or the stick is none that installs
  3  a file or a device could not be read, or no screen be opened";

/// Which screen the pages are shown on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum ScreenKind {
    /// A display
    Kms,
    /// None: one in memory
    Virtual,
}

/// Install the unit of this stick on a disk of this computer, after a press of Enter
///
/// The pages are shown on the display, and printed on standard output. Without a press of Enter on a page that names the
/// disk, nothing is written.
#[derive(Debug, Parser)]
#[command(name = "dreams-install", version, after_help = EXIT_STATUS)]
pub(crate) struct Options {
    /// The stick that this system runs from, by the kernel's name of it: as `sda`
    #[arg(long, value_name = "NAME")]
    pub(crate) stick: String,
    /// The SHA-256 of what is written, without the owner's settings: 64 hexadecimal digits
    #[arg(long, value_name = "SHA256", value_parser = sum)]
    pub(crate) sum: Sum,
    /// Start the machine again when the unit is on the disk and the stick was removed; otherwise the program just ends
    #[arg(long)]
    pub(crate) restart: bool,
    /// Which screen the pages are shown on
    #[arg(long, value_enum, default_value = "kms")]
    pub(crate) screen: ScreenKind,
    /// The folder in which `sys` and `dev` are
    #[arg(long, value_name = "DIR", default_value = "/")]
    pub(crate) root: PathBuf,
}

/// Reads a sum.
fn sum(text: &str) -> Result<Sum, String> {
    let digits: Vec<u8> = text.chars().filter_map(|digit| digit.to_digit(16)).map(|digit| digit as u8).collect();
    if text.len() != 64 || digits.len() != 64 {
        return Err("a SHA-256 has 64 hexadecimal digits".to_owned());
    }
    Ok(array::from_fn(|byte| digits[2 * byte] << 4 | digits[2 * byte + 1]))
}

#[cfg(test)]
mod tests {
    use super::{EXIT_STATUS, sum};
    use diagnostics::Exit;

    #[test]
    fn a_sum_has_sixty_four_digits() {
        assert_eq!(sum(&"0a".repeat(32)), Ok([10; 32]));
        for wrong in ["", "0a", &"0a".repeat(33), &"0g".repeat(32), &"\u{e9}".repeat(32)] {
            assert!(sum(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn the_help_names_every_exit_code() {
        for exit in [Exit::Fine, Exit::No, Exit::Malformed, Exit::Unreadable] {
            assert!(EXIT_STATUS.contains(&format!("\n  {}  ", exit as u8)));
        }
        assert_eq!(EXIT_STATUS.lines().count(), 5);
    }
}
