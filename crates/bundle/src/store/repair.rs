//! Replacement of damaged objects, without a moment in which a flock lacks a file.
//!
//! Owns the quarantine: damaged or unreadable objects are renamed into a separate folder, while the flocks keep their
//! hard links. A quarantined object counts as missing, so that it is fetched again; then it replaces the old one in
//! every flock by a rename, and the quarantine is emptied last. `upkeep.rs` finds damaged objects.
//!
//! Start at [`Store::repair`](crate::Store::repair).
#![allow(clippy::missing_errors_doc, reason = "a function that does not say otherwise fails with `StoreError::Disk`")]

use std::collections::BTreeSet;
use std::io;

use durable::parent;

use crate::contents::VerifiedBundle;
use crate::names::ObjectId;
use crate::store::disk::Disk;
use crate::store::install::link_all;
use crate::store::plan::FetchItem;
use crate::store::state::Generation;
use crate::store::{Store, StoreError, at, flock_folder, generation_folder};

/// The path of a quarantined object.
pub(crate) const QUARANTINE: &str = "aside";

impl Store {
    /// Quarantines an object: from now on it counts as missing. Every flock keeps the file.
    pub(crate) fn quarantine(&self, id: &ObjectId) -> Result<(), StoreError> {
        let (object, quarantined) = (id.path(), quarantined(id));
        let put = || -> io::Result<()> {
            self.disk.rename(&object, &quarantined)?;
            self.disk.sync_folder(QUARANTINE)?;
            self.disk.sync_folder(parent(&object))
        };
        put().map_err(at("quarantine", &object))
    }

    /// Restores a quarantined object that turns out to be intact, for example after a temporary read error; returns
    /// whether it was.
    pub fn restore(&self, wanted: &FetchItem) -> Result<bool, StoreError> {
        let (object, quarantined) = (wanted.id.path(), quarantined(&wanted.id));
        if !matches!(self.read_through(&quarantined, &mut |_| true), Ok(Some(read)) if read == wanted.id) {
            return Ok(false);
        }
        let back = || -> io::Result<()> {
            self.disk.rename(&quarantined, &object)?;
            self.disk.sync_folder(parent(&object))?;
            self.disk.sync_folder(QUARANTINE)
        };
        back().map_err(at("restore", &object))?;
        Ok(true)
    }

    /// Links refetched objects into the generations that lack them, replacing the quarantined ones.
    pub fn repair(&self) -> Result<(), StoreError> {
        let mut replaced = BTreeSet::new();
        for name in self.disk.list(QUARANTINE).map_err(at("list", QUARANTINE))? {
            let Ok(id) = ObjectId::parse(&name) else { continue };
            let object = id.path();
            if self.disk.length(&object).map_err(at("look at", &object))?.is_some() {
                replaced.insert(id);
            }
        }
        for generation in self.state.kept() {
            let bundle = self.bundle(generation)?;
            self.link_again(generation, &bundle)?;
            let folder = generation_folder(generation.number);
            swap_all(&*self.disk, &bundle, generation, &replaced).map_err(at("mend", &folder))?;
        }
        for id in &replaced {
            let quarantined = quarantined(id);
            self.remove_tree(&quarantined)?;
        }
        if replaced.is_empty() { Ok(()) } else { self.disk.sync_folder(QUARANTINE).map_err(at("sync", QUARANTINE)) }
    }

    /// Links the files that a generation lacks and the store has.
    pub(crate) fn link_again(&self, generation: &Generation, bundle: &VerifiedBundle) -> Result<(), StoreError> {
        let folder = flock_folder(generation.number);
        link_all(&*self.disk, bundle.contents(), &folder).map_err(at("mend", &folder))
    }
}

/// The path of a quarantined object.
pub(crate) fn quarantined(id: &ObjectId) -> String {
    format!("{QUARANTINE}/{id}")
}

/// Replaces every file of the generation whose object is in `replaced`, and syncs the new links.
fn swap_all(
    disk: &dyn Disk,
    bundle: &VerifiedBundle,
    generation: &Generation,
    replaced: &BTreeSet<ObjectId>,
) -> io::Result<()> {
    let new = format!("{}/new", generation_folder(generation.number));
    let flock = flock_folder(generation.number);
    let mut folders = BTreeSet::new();
    for file in bundle.contents().files().iter().filter(|file| replaced.contains(&file.id)) {
        let name = format!("{flock}/{}", file.path);
        disk.remove(&new)?;
        disk.link(&file.id.path(), &new)?;
        disk.rename(&new, &name)?;
        // If both names are the same file already, `rename` does nothing and both names stay.
        disk.remove(&new)?;
        folders.insert(parent(&name).to_owned());
    }
    folders.iter().try_for_each(|folder| disk.sync_folder(folder))
}
