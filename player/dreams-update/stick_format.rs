//! How sticks are formatted that a unit does not read.
//!
//! Owns their names, for udev and for people. The udev rule starts the updater with them.

use clap::ValueEnum;
use std::fmt;

/// A file system of Windows or of a Mac, by udev's `ID_FS_TYPE`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum StickFormat {
    /// Apple's, since 2017.
    Apfs,
    /// Apple's first.
    Hfs,
    /// Apple's, before APFS.
    Hfsplus,
    /// Microsoft's.
    Ntfs,
}

impl fmt::Display for StickFormat {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Apfs => "APFS",
            Self::Hfs => "HFS",
            Self::Hfsplus => "HFS+",
            Self::Ntfs => "NTFS",
        })
    }
}
