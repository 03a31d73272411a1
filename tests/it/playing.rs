//! The player's command line, as claims use it.
//!
//! Owns one run's scratch folder: its state, its trace. Never decides where it runs: here on the virtual screen, or
//! in a guest on a real one.
//!
//! Start at [`Playing::of`].

use crate::programs;
use crate::trace::Trace;
use std::path::{Path, PathBuf};
use std::process::Command;
use tempfile::TempDir;

/// The display of a guest.
pub(crate) const VKMS: &str = "kms:/dev/dri/by-driver/vkms";

/// One run of the player, about to start.
pub(crate) struct Playing {
    scratch: TempDir,
    command: Command,
}

impl Playing {
    /// A run of the player on the flock in `folder`, with a trace and a state folder of its own and no status page.
    pub(crate) fn of(folder: &Path) -> Self {
        let scratch = tempfile::tempdir_in(programs::claims_folder()).unwrap();
        let mut command = Command::new(programs::player());
        command.arg("--flock").arg(folder);
        command.arg("--state").arg(scratch.path().join("state"));
        command.arg("--trace").arg(scratch.path().join("trace"));
        command.args(["--status", "off"]);
        Self { scratch, command }
    }

    /// Adds options.
    pub(crate) fn with(mut self, options: &[&str]) -> Self {
        self.command.args(options);
        self
    }

    /// The command line.
    pub(crate) fn command(&self) -> &Command {
        &self.command
    }

    /// The command line, to start here.
    pub(crate) fn start(&mut self) -> &mut Command {
        &mut self.command
    }

    /// A path in the run's own scratch folder, which vanishes with it.
    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.scratch.path().join(name)
    }

    /// The trace so far.
    pub(crate) fn trace(&self) -> Trace {
        Trace::read(&self.path("trace"))
    }
}
