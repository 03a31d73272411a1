//! Garbage collection and verification of the store.
//!
//! Removes what is unused, and verifies the rest. Flocks lose no file: a damaged or unreadable object is quarantined,
//! so that it is fetched again, and its clip stays in the flock until then. The replacement is in `repair.rs`.
//!
//! Start at [`Store::collect`](crate::Store::collect) and [`Store::scrub`](crate::Store::scrub).
#![allow(clippy::missing_errors_doc, reason = "a function that does not say otherwise fails with `StoreError::Disk`")]

use std::collections::{BTreeMap, BTreeSet};
use std::io::{self, Read};

use crate::contents::{Contents, FileEntry, VerifiedBundle};
use crate::limits;
use crate::names::{ObjectId, parse_plain};
use crate::store::plan::FetchItem;
use crate::store::repair::QUARANTINE;
use crate::store::state::Generation;
use crate::store::{GENERATIONS, INCOMING, Store, StoreError, at};
use crate::system::System;

/// Bytes read between two calls of `pace`.
const CHUNK: usize = 256 << 10;

/// The result of verifying every object.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Scrub {
    /// Objects that were read and are whole.
    pub whole: usize,
    /// Objects with a wrong digest, to be fetched again.
    pub damaged: Vec<FetchItem>,
    /// Objects that could not be read, to be fetched again unless a later read succeeds.
    pub unread: Vec<UnreadableObject>,
    /// [`limits::UNREAD`] objects could not be read: the disk is failing. The scrub ended there, without quarantine.
    pub is_failing: bool,
    /// Generations whose list of files is lost.
    pub unlisted: Vec<Generation>,
}

/// An object that could not be read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UnreadableObject {
    /// Which.
    pub wanted: FetchItem,
    /// The disk's error.
    pub why: String,
}

impl Store {
    /// Removes what is not needed by a kept generation, the player, the bundle that is being fetched, or a staged system.
    ///
    /// # Errors
    /// [`StoreError`]; nothing that is needed was removed.
    pub fn collect(&self, fetching: Option<&VerifiedBundle>) -> Result<(), StoreError> {
        let kept: BTreeSet<u64> = self.state.kept().map(|generation| generation.number).collect();
        for name in self.disk.list(GENERATIONS).map_err(at("list", GENERATIONS))? {
            if parse_plain(&name).is_none_or(|number| !kept.contains(&number)) {
                let path = format!("{GENERATIONS}/{name}");
                // A generation that is still played is removed after the player has switched.
                if !self.disk.is_in_use(&path).map_err(at("look at", &path))? {
                    self.remove_tree(&path)?;
                }
            }
        }
        let mut needed: BTreeSet<ObjectId> = BTreeSet::new();
        let mut need = |contents: &Contents| needed.extend(contents.files().iter().map(|file| file.id));
        for generation in self.state.kept() {
            // Without the list of a generation, everything may be needed.
            need(self.bundle(generation)?.contents());
        }
        if let Some(bundle) = fetching {
            need(bundle.contents());
        }
        needed.extend(self.staged()?.iter().flat_map(System::halves).map(|half| half.id));
        for folder in self.disk.list("objects").map_err(at("list", "objects"))? {
            let folder = format!("objects/{folder}");
            for name in self.disk.list(&folder).map_err(at("list", &folder))? {
                let path = format!("{folder}/{name}");
                let id = ObjectId::parse(&format!("{}{name}", &folder["objects/".len()..]));
                if id.is_ok_and(|id| !needed.contains(&id)) {
                    self.remove_tree(&path)?;
                }
            }
        }
        let coming: BTreeSet<ObjectId> =
            fetching.iter().flat_map(|bundle| bundle.contents().files().iter().map(|file| file.id)).collect();
        for (folder, wanted) in [(INCOMING, &coming), (QUARANTINE, &needed)] {
            for name in self.disk.list(folder).map_err(at("list", folder))? {
                if ObjectId::parse(&name).is_ok_and(|id| !wanted.contains(&id)) {
                    let path = format!("{folder}/{name}");
                    self.remove_tree(&path)?;
                }
            }
        }
        Ok(())
    }

    /// Reads every byte of every kept generation, and quarantines objects that are damaged or unreadable. `pace` is
    /// called with the number of bytes read; it may block, and ends the scrub by returning `false`.
    ///
    /// # Errors
    /// [`StoreError::Disk`] if an object cannot be quarantined.
    pub fn scrub(&self, mut pace: impl FnMut(u64) -> bool) -> Result<Scrub, StoreError> {
        let mut found = Scrub::default();
        let mut objects: BTreeMap<ObjectId, FileEntry> = BTreeMap::new();
        for generation in self.state.kept() {
            match self.bundle(generation) {
                Ok(bundle) => objects.extend(bundle.contents().files().iter().map(|file| (file.id, file.clone()))),
                Err(_) => found.unlisted.push(generation.clone()),
            }
        }
        for (id, file) in objects {
            let wanted = || FetchItem { id, size: file.size, have: 0, path: file.path.clone() };
            match self.read_through(&id.path(), &mut pace) {
                Ok(None) => break,
                Ok(Some(read)) if read == id => found.whole += 1,
                Ok(Some(_)) => found.damaged.push(wanted()),
                // [`Store::missing`] lists an object that is missing, or that has something else in its place.
                Err(_) if self.disk.length(&id.path()).is_ok_and(|length| length.is_none()) => {}
                Err(error) => found.unread.push(UnreadableObject { wanted: wanted(), why: error.to_string() }),
            }
            found.is_failing = found.unread.len() >= limits::UNREAD;
            if found.is_failing {
                break;
            }
        }
        let unread = found.unread.iter().map(|unread| &unread.wanted).filter(|_| !found.is_failing);
        found.damaged.iter().chain(unread).try_for_each(|wanted| self.quarantine(&wanted.id))?;
        Ok(found)
    }

    /// The missing objects of the kept generations, by names and sizes only: cheap enough for every start.
    pub fn missing(&self) -> Result<Vec<FetchItem>, StoreError> {
        let mut missing: BTreeMap<ObjectId, FetchItem> = BTreeMap::new();
        for generation in self.state.kept() {
            let plan = self.plan(&self.bundle(generation)?)?;
            missing.extend(plan.wanted.into_iter().map(|wanted| (wanted.id, wanted)));
        }
        Ok(missing.into_values().collect())
    }

    /// The digest of a file; `None` if `pace` said to stop.
    pub(crate) fn read_through(&self, path: &str, pace: &mut impl FnMut(u64) -> bool) -> io::Result<Option<ObjectId>> {
        let mut file = self.disk.open(path)?;
        let (mut hasher, mut chunk) = (blake3::Hasher::new(), vec![0; CHUNK]);
        loop {
            let count = match file.read(&mut chunk) {
                Err(error) if error.kind() == io::ErrorKind::Interrupted => continue,
                count => count?,
            };
            if count == 0 {
                return Ok(Some(ObjectId::new(*hasher.finalize().as_bytes())));
            }
            hasher.update(&chunk[..count]);
            if !pace(count as u64) {
                return Ok(None);
            }
        }
    }
}
