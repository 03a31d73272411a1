//! Keeping the store small and whole.
//!
//! Owns what may go, and what is wrong with what stays: a damaged file is taken out of every generation, so that the
//! player walks around it, until it has been fetched again. Never fetches.
//!
//! Start at [`Store::collect`](crate::Store::collect) and [`Store::scrub`](crate::Store::scrub).

use std::collections::{BTreeMap, BTreeSet};
use std::io::{self, Read};

use crate::contents::{Contents, FileEntry, Verified};
use crate::names::{ObjectId, plain};
use crate::store::install::link_all;
use crate::store::plan::Wanted;
use crate::store::state::Generation;
use crate::store::{GENERATIONS, INCOMING, Store, StoreError, at, flock_folder};
use crate::system::System;

/// How much is read between two looks at the pace.
const CHUNK: usize = 256 << 10;

/// What a look at every byte found.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Scrubbed {
    /// Objects that were read and are whole.
    pub whole: usize,
    /// What has to be fetched again; it was taken out of the generations.
    pub damaged: Vec<Wanted>,
    /// Generations of which nobody knows any more what they consist of.
    pub unlisted: Vec<Generation>,
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
        for name in self.disk.list(INCOMING).map_err(at("list", INCOMING))? {
            if ObjectId::parse(&name).is_ok_and(|id| !coming.contains(&id)) {
                let path = format!("{INCOMING}/{name}");
                self.disk.remove(&path).map_err(at("remove", &path))?;
            }
        }
        Ok(())
    }

    /// Reads every byte of every generation that is kept, and takes out what is damaged. `pace` is told of the bytes as
    /// they are read, may take its time, and ends the scrub by saying `false`.
    ///
    /// # Errors
    /// [`StoreError::Disk`] if what is damaged cannot be taken out.
    pub fn scrub(&self, mut pace: impl FnMut(u64) -> bool) -> Result<Scrubbed, StoreError> {
        let mut found = Scrubbed::default();
        let mut objects: BTreeMap<ObjectId, (FileEntry, Vec<String>)> = BTreeMap::new();
        for generation in self.state.kept() {
            let Ok(bundle) = self.bundle(generation) else {
                found.unlisted.push(generation.clone());
                continue;
            };
            for file in bundle.contents().files() {
                let (_, names) = objects.entry(file.id).or_insert_with(|| (file.clone(), Vec::new()));
                names.push(format!("{}/{}", flock_folder(generation.number), file.path));
            }
        }
        for (id, (file, names)) in objects {
            match self.read_through(&id.path(), &mut pace) {
                Ok(None) => return Ok(found),
                Ok(Some(read)) if read == id => found.whole += 1,
                Ok(Some(_)) | Err(_) => {
                    for name in names.iter().chain([&id.path()]) {
                        self.disk.remove(name).map_err(at("take out", name))?;
                    }
                    found.damaged.push(Wanted { id, size: file.size, have: 0, path: file.path });
                }
            }
        }
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

    /// Puts what was fetched again back into the generations that lacked it.
    ///
    /// # Errors
    /// [`StoreError`].
    pub fn mend(&self) -> Result<(), StoreError> {
        for generation in self.state.kept() {
            self.link_again(generation, &self.bundle(generation)?)?;
        }
        Ok(())
    }

    /// Links what a generation lacks and the store has.
    pub(crate) fn link_again(&self, generation: &Generation, bundle: &Verified) -> Result<(), StoreError> {
        let folder = flock_folder(generation.number);
        link_all(&*self.disk, bundle.contents(), &folder).map_err(at("mend", &folder))
    }

    /// The digest of a file; `None` if `pace` said to stop.
    fn read_through(&self, path: &str, pace: &mut impl FnMut(u64) -> bool) -> io::Result<Option<ObjectId>> {
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
