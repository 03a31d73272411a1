//! From objects to a generation.
//!
//! Owns the order: all files of the generation are synced before the state names it, and the state is synced before the
//! link. The generation that plays is not changed.
//!
//! Start at [`Store::install`](crate::Store::install).

use std::collections::BTreeSet;
use std::io;

use durable::{parent, read_all};

use crate::contents::{Contents, VerifiedBundle};
use crate::limits;
use crate::refusal::Refusal;
use crate::store::disk::{Disk, remove_tree};
use crate::store::state::{Generation, Unknown};
use crate::store::{GENERATIONS, Store, StoreError, at, flock_folder, generation_folder};

impl Store {
    /// Reads the bundle's flock, whose `flock.toml` must have been fetched, and checks that the bundle has all its
    /// files. To be called before the clips are fetched.
    ///
    /// # Errors
    /// [`StoreError::Refused`] if it is invalid, [`StoreError::Disk`] if it cannot be read.
    pub fn flock(&self, bundle: &VerifiedBundle) -> Result<flock::Manifest, StoreError> {
        let missing = || Refusal::MissingFile { path: flock::FILE_NAME.to_owned() };
        let toml = bundle.contents().file(flock::FILE_NAME).ok_or_else(|| StoreError::Refused(missing()))?;
        let path = toml.id.path();
        let read = self.disk.open(&path).and_then(|file| read_all(file, limits::FLOCK_TOML));
        bundle.flock(&read.map_err(at("read", &path))?).map_err(StoreError::Refused)
    }

    /// Installs the bundle, all of whose objects must have been fetched, as a new generation on trial, which plays from
    /// now on. When this returns, it survives a power cut.
    ///
    /// # Errors
    /// [`StoreError::Missing`], [`StoreError::Refused`] if the flock is invalid, [`StoreError::Disk`]. The generation
    /// that plays stays.
    pub fn install(&mut self, bundle: &VerifiedBundle) -> Result<Generation, StoreError> {
        let plan = self.plan(bundle)?;
        if !plan.wanted.is_empty() {
            return Err(StoreError::Missing { missing: plan.wanted.len(), objects: plan.objects });
        }
        self.flock(bundle)?;
        let (seal, number) = (bundle.seal(), self.state.next_number());
        let folder = generation_folder(number);
        self.remove_tree(&folder)?;
        self.build(bundle, number).map_err(at("build", &folder))?;
        let letter = seal.letter();
        let (flock, sequence) = (letter.flock.clone(), letter.sequence);
        let (signer, seal) = (seal.signer(), seal.id());
        let addressees = Some(letter.addressees.clone());
        let generation = Generation { number, flock, signer, sequence, seal, addressees, unknown: Unknown::new() };
        self.change(|state| state.install_trial(generation.clone()))?;
        Ok(generation)
    }

    /// The verified bundle of a kept generation.
    ///
    /// # Errors
    /// [`StoreError::Disk`], or [`StoreError::Generation`] if it is damaged.
    pub fn bundle(&self, generation: &Generation) -> Result<VerifiedBundle, StoreError> {
        let folder = generation_folder(generation.number);
        let read = |name: &str, limit| {
            let path = format!("{folder}/{name}");
            self.disk.read(&path, limit).map_err(at("read", &path))
        };
        let damaged = |source| StoreError::Generation { number: generation.number, source };
        let seal = crate::seal::Seal::kept(read("seal", limits::SEAL)?, generation.signer, generation.seal);
        let contents = read("contents", limits::CONTENTS)?;
        seal.and_then(|seal| seal.open(contents)).map_err(damaged)
    }

    /// Removes a folder with its contents, if it exists.
    pub(crate) fn remove_tree(&self, path: &str) -> Result<(), StoreError> {
        remove_tree(&*self.disk, path).map_err(at("remove", path))
    }

    fn build(&self, bundle: &VerifiedBundle, number: u64) -> io::Result<()> {
        let (disk, folder) = (&*self.disk, generation_folder(number));
        disk.make_folder(&folder)?;
        let said = self.state.statements.concat();
        let papers =
            [("seal", bundle.seal().bytes()), ("contents", bundle.contents_bytes()), ("statements", said.as_bytes())];
        for (name, bytes) in papers {
            let mut file = disk.append(&format!("{folder}/{name}"))?;
            file.write_all(bytes)?;
            file.sync()?;
        }
        let flock = flock_folder(number);
        link_all(disk, bundle.contents(), &flock)?;
        for object_folder in object_folders(bundle.contents()) {
            disk.sync_folder(&object_folder)?;
        }
        disk.sync_folder("objects")?;
        disk.sync_folder(&folder)?;
        disk.sync_folder(GENERATIONS)
    }
}

/// Links the missing files of `contents` into the folder `flock`, and syncs them. Missing objects are left out.
pub(crate) fn link_all(disk: &dyn Disk, contents: &Contents, flock: &str) -> io::Result<()> {
    let mut folders = BTreeSet::from([flock.to_owned()]);
    for file in contents.files() {
        folders.extend(file.path.folders().map(|folder| format!("{flock}/{folder}")));
    }
    // A folder sorts before its contents.
    for folder in &folders {
        disk.make_folder(folder)?;
    }
    let mut is_new = false;
    for file in contents.files() {
        let (object, name) = (file.id.path(), format!("{flock}/{}", file.path));
        if disk.length(&name)?.is_none() && disk.length(&object)? == Some(file.size) {
            disk.link(&object, &name)?;
            is_new = true;
        }
    }
    if is_new { folders.iter().rev().try_for_each(|folder| disk.sync_folder(folder)) } else { Ok(()) }
}

/// The folders of the objects of `contents`.
fn object_folders(contents: &Contents) -> BTreeSet<String> {
    contents.files().iter().map(|file| parent(&file.id.path()).to_owned()).collect()
}
