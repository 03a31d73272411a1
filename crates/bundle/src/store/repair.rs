//! From what is damaged to what is whole, without a moment in which a flock lacks a file.
//!
//! Owns what was put aside: objects that are damaged, or that the disk did not give, under their names in a folder of
//! their own. The flocks keep them meanwhile, under their second names. An object that was put aside is missing, so that
//! it is fetched again; then it takes the place of the other in every flock, in one step for each, and only then nothing
//! is put aside any more. Never decides what is damaged: `upkeep.rs` does.
//!
//! Start at [`Store::mend`](crate::Store::mend).

use std::collections::BTreeSet;
use std::io;

use crate::contents::Verified;
use crate::names::ObjectId;
use crate::store::disk::{Disk, folder_of};
use crate::store::install::link_all;
use crate::store::plan::Wanted;
use crate::store::state::Generation;
use crate::store::{Store, StoreError, at, flock_folder, generation_folder};

/// Where an object lies that was put aside.
pub(crate) const ASIDE: &str = "aside";

impl Store {
    /// Puts an object aside: from now on it is missing. Every flock keeps the file.
    pub(crate) fn put_aside(&self, id: &ObjectId) -> Result<(), StoreError> {
        let (object, aside) = (id.path(), aside(id));
        let put = || -> io::Result<()> {
            self.disk.rename(&object, &aside)?;
            self.disk.sync_folder(ASIDE)?;
            self.disk.sync_folder(folder_of(&object))
        };
        put().map_err(at("put aside", &object))
    }

    /// Whether an object that was put aside is whole after all, as when the disk did not give it for a moment: it is back
    /// then.
    ///
    /// # Errors
    /// [`StoreError::Disk`].
    pub fn reclaim(&self, wanted: &Wanted) -> Result<bool, StoreError> {
        let (object, aside) = (wanted.id.path(), aside(&wanted.id));
        if !matches!(self.read_through(&aside, &mut |_| true), Ok(Some(read)) if read == wanted.id) {
            return Ok(false);
        }
        let back = || -> io::Result<()> {
            self.disk.rename(&aside, &object)?;
            self.disk.sync_folder(folder_of(&object))?;
            self.disk.sync_folder(ASIDE)
        };
        back().map_err(at("put back", &object))?;
        Ok(true)
    }

    /// Puts what was fetched again into the generations that lack it, and into the place of what was put aside.
    ///
    /// # Errors
    /// [`StoreError`].
    pub fn mend(&self) -> Result<(), StoreError> {
        let mut replaced = BTreeSet::new();
        for name in self.disk.list(ASIDE).map_err(at("list", ASIDE))? {
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
            let aside = aside(id);
            self.disk.remove(&aside).map_err(at("remove", &aside))?;
        }
        if replaced.is_empty() { Ok(()) } else { self.disk.sync_folder(ASIDE).map_err(at("sync", ASIDE)) }
    }

    /// Links what a generation lacks and the store has.
    pub(crate) fn link_again(&self, generation: &Generation, bundle: &Verified) -> Result<(), StoreError> {
        let folder = flock_folder(generation.number);
        link_all(&*self.disk, bundle.contents(), &folder).map_err(at("mend", &folder))
    }
}

/// Where an object lies that was put aside.
pub(crate) fn aside(id: &ObjectId) -> String {
    format!("{ASIDE}/{id}")
}

/// Has every file of the generation whose object was `replaced` be that object, and syncs what is new.
fn swap_all(
    disk: &dyn Disk,
    bundle: &Verified,
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
        // Where both were the same file already, a rename leaves both names.
        disk.remove(&new)?;
        folders.insert(folder_of(&name).to_owned());
    }
    folders.iter().try_for_each(|folder| disk.sync_folder(folder))
}
