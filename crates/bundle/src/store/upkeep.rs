//! Keeping the store small, and looking at every byte of it.
//!
//! Owns what may go, and what is wrong with what stays. A look takes nothing away from any flock: an object that is
//! damaged, or that the disk does not give, is put aside, so that it is fetched again; its clip stays in its place until
//! then. How what was fetched takes that place is in `repair.rs`. Never fetches.
//!
//! Start at [`Store::collect`](crate::Store::collect) and [`Store::scrub`](crate::Store::scrub).

use std::collections::{BTreeMap, BTreeSet};
use std::io::{self, ErrorKind, Read};

use crate::contents::{Contents, FileEntry, Verified};
use crate::limits;
use crate::names::{ObjectId, plain};
use crate::store::plan::Wanted;
use crate::store::repair::ASIDE;
use crate::store::state::Generation;
use crate::store::{GENERATIONS, INCOMING, Store, StoreError, at};
use crate::system::System;

/// How much is read between two looks at the pace.
const CHUNK: usize = 256 << 10;

/// What a look at every byte found.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Scrubbed {
    /// Objects that were read and are whole.
    pub whole: usize,
    /// Objects with other bytes than were signed: they have to be fetched again.
    pub damaged: Vec<Wanted>,
    /// Objects that the disk did not give: they have to be fetched again, unless it gives them after all.
    pub unread: Vec<Unread>,
    /// The disk did not give [`limits::UNREAD`] objects: it fails, and not they. The look ended there, and they are left
    /// as they are.
    pub is_failing: bool,
    /// Generations of which nobody knows any more what they consist of.
    pub unlisted: Vec<Generation>,
}

/// An object that could not be read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Unread {
    /// Which.
    pub wanted: Wanted,
    /// What the disk says.
    pub why: String,
}

impl Store {
    /// Removes what no kept generation needs, nor the player now, nor the bundle that is being fetched, nor a staged
    /// system.
    ///
    /// # Errors
    /// [`StoreError`]; nothing that is needed was removed.
    pub fn collect(&self, fetching: Option<&Verified>) -> Result<(), StoreError> {
        let kept: BTreeSet<u64> = self.state.kept().map(|generation| generation.number).collect();
        for name in self.disk.list(GENERATIONS).map_err(at("list", GENERATIONS))? {
            if plain(&name).is_none_or(|number| !kept.contains(&number)) {
                let path = format!("{GENERATIONS}/{name}");
                // What is still on the glass goes when the player has changed over.
                if !self.disk.is_played(&path).map_err(at("look at", &path))? {
                    self.remove_tree(&path)?;
                }
            }
        }
        let mut needed: BTreeSet<ObjectId> = BTreeSet::new();
        let mut need = |contents: &Contents| needed.extend(contents.files().iter().map(|file| file.id));
        for generation in self.state.kept() {
            // Of a generation that nobody can list, everything may be needed.
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
                    self.disk.remove(&path).map_err(at("remove", &path))?;
                }
            }
        }
        let coming: BTreeSet<ObjectId> =
            fetching.iter().flat_map(|bundle| bundle.contents().files().iter().map(|file| file.id)).collect();
        for (folder, wanted) in [(INCOMING, &coming), (ASIDE, &needed)] {
            for name in self.disk.list(folder).map_err(at("list", folder))? {
                if ObjectId::parse(&name).is_ok_and(|id| !wanted.contains(&id)) {
                    let path = format!("{folder}/{name}");
                    self.disk.remove(&path).map_err(at("remove", &path))?;
                }
            }
        }
        Ok(())
    }

    /// Reads every byte of every generation that is kept, and puts aside what is damaged or cannot be read: no file of
    /// any flock is taken away. `pace` is told of the bytes as they are read, may take its time, and ends the scrub by
    /// saying `false`.
    ///
    /// # Errors
    /// [`StoreError::Disk`] if what was found cannot be put aside.
    pub fn scrub(&self, mut pace: impl FnMut(u64) -> bool) -> Result<Scrubbed, StoreError> {
        let mut found = Scrubbed::default();
        let mut objects: BTreeMap<ObjectId, FileEntry> = BTreeMap::new();
        for generation in self.state.kept() {
            match self.bundle(generation) {
                Ok(bundle) => objects.extend(bundle.contents().files().iter().map(|file| (file.id, file.clone()))),
                Err(_) => found.unlisted.push(generation.clone()),
            }
        }
        for (id, file) in objects {
            let wanted = || Wanted { id, size: file.size, have: 0, path: file.path.clone() };
            match self.read_through(&id.path(), &mut pace) {
                Ok(None) => break,
                Ok(Some(read)) if read == id => found.whole += 1,
                Ok(Some(_)) => found.damaged.push(wanted()),
                // Whoever asks what is missing is told of it.
                Err(error) if error.kind() == ErrorKind::NotFound => {}
                Err(error) => found.unread.push(Unread { wanted: wanted(), why: error.to_string() }),
            }
            found.is_failing = found.unread.len() >= limits::UNREAD;
            if found.is_failing {
                break;
            }
        }
        let unread = found.unread.iter().map(|unread| &unread.wanted).filter(|_| !found.is_failing);
        found.damaged.iter().chain(unread).try_for_each(|wanted| self.put_aside(&wanted.id))?;
        Ok(found)
    }

    /// What the kept generations lack, as far as names and sizes tell: cheap enough for every start.
    ///
    /// # Errors
    /// [`StoreError`].
    pub fn missing(&self) -> Result<Vec<Wanted>, StoreError> {
        let mut missing: BTreeMap<ObjectId, Wanted> = BTreeMap::new();
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
