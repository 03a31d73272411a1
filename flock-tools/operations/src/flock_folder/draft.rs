//! A flock's manifest, locked while one command edits it, with the exit statuses of what may fail.
//!
//! Owns the statuses; `flock::Draft` has the lock and the check before saving. The commands decide what to edit, on
//! [`flock::Draft::edit`].
//!
//! Start at [`Draft::lock`].

use std::ops::{Deref, DerefMut};
use std::path::Path;

use flock::DraftError;

use crate::flock_folder::open;
use crate::program::{Exit, Fatal};

/// The manifest of a flock, locked by one command.
#[derive(Debug)]
pub struct Draft(flock::Draft);

impl Draft {
    /// Locks the manifest of the flock in `folder`; waits while another command has it. It may be without sheep.
    pub fn lock(folder: &Path) -> Result<Self, Fatal> {
        flock::Draft::lock(folder).map(Self).map_err(open::manifest_fatal)
    }

    /// Saves the manifest as edited.
    pub fn save(self) -> Result<(), Fatal> {
        self.0.save().map_err(fatal)
    }

    /// Saves the manifest as edited, and keeps it locked for more edits.
    pub fn save_and_go_on(&mut self) -> Result<(), Fatal> {
        self.0.save_and_go_on().map_err(fatal)
    }
}

impl Deref for Draft {
    type Target = flock::Draft;

    fn deref(&self) -> &flock::Draft {
        &self.0
    }
}

impl DerefMut for Draft {
    fn deref_mut(&mut self) -> &mut flock::Draft {
        &mut self.0
    }
}

fn fatal(error: DraftError) -> Fatal {
    match error {
        DraftError::Save { path, source } => Fatal::file("save", &path, source),
        mismatch @ DraftError::Mismatch { .. } => Fatal::new(Exit::Unreadable, mismatch),
    }
}
