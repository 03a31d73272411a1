//! From objects to a generation.
//!
//! Owns the order: everything that the generation consists of is on the disk before the state speaks of it, and the
//! state before the link. Never touches the generation that plays.
//!
//! Start at [`Store::install`](crate::Store::install).

use std::collections::BTreeSet;
use std::io;

use crate::beneath::read_all;
use crate::contents::{Contents, Verified};
use crate::limits;
use crate::refused::Refused;
use crate::store::disk::{Disk, folder_of};
use crate::store::state::{Generation, Unknown};
use crate::store::{GENERATIONS, Store, StoreError, at, flock_folder, generation_folder};

impl Store {
    /// Reads the flock of the bundle, whose `flock.toml` must have been taken in, and checks that the bundle carries
    /// all that it names. Worth doing before the clips are fetched.
    ///
    /// # Errors
    /// [`StoreError::Refused`] if no player could play it, [`StoreError::Disk`] if it cannot be read.
    pub fn flock(&self, bundle: &Verified) -> Result<flock::Manifest, StoreError> {
        let missing = || Refused::MissingFile { path: flock::FILE_NAME.to_owned() };
        let toml = bundle.contents().file(flock::FILE_NAME).ok_or_else(|| StoreError::Refused(missing()))?;
        let path = toml.id.path();
        let read = self.disk.open(&path).and_then(|file| read_all(file, limits::FLOCK_TOML));
        bundle.flock(&read.map_err(at("read", &path))?).map_err(StoreError::Refused)
    }

    /// Makes a generation of the bundle, all of whose objects must have been taken in, and puts it on trial: from now
    /// on it is what plays. When this returns, no power cut undoes it.
    ///
    /// # Errors
    /// [`StoreError::Missing`], [`StoreError::Refused`] if it is no flock, [`StoreError::Disk`]. What plays is what
    /// played before.
    pub fn install(&mut self, bundle: &Verified) -> Result<Generation, StoreError> {
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
        self.change(|state| state.installed(generation.clone()))?;
        Ok(generation)
    }

    /// What the store knows of a generation that it keeps.
    ///
    /// # Errors
    /// [`StoreError::Disk`], or [`StoreError::Generation`] if it is damaged.
    pub fn bundle(&self, generation: &Generation) -> Result<Verified, StoreError> {
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

    /// Removes a folder and what is in it, as far as it is there.
    pub(crate) fn remove_tree(&self, path: &str) -> Result<(), StoreError> {
        remove_tree(&*self.disk, path).map_err(at("remove", path))
    }

    fn build(&self, bundle: &Verified, number: u64) -> io::Result<()> {
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

/// Links every file of `contents` that is not there into the folder `flock`, and syncs what is new. Objects that are
/// missing are left out.
pub(crate) fn link_all(disk: &dyn Disk, contents: &Contents, flock: &str) -> io::Result<()> {
    let mut folders = BTreeSet::from([flock.to_owned()]);
    for file in contents.files() {
        folders.extend(file.path.folders().map(|folder| format!("{flock}/{folder}")));
    }
    // A folder sorts before what lies in it.
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

/// The folders that the objects of `contents` lie in.
fn object_folders(contents: &Contents) -> BTreeSet<String> {
    contents.files().iter().map(|file| folder_of(&file.id.path()).to_owned()).collect()
}

fn remove_tree(disk: &dyn Disk, path: &str) -> io::Result<()> {
    match disk.remove(path) {
        Err(error) if error.kind() == io::ErrorKind::IsADirectory => {
            for name in disk.list(path)? {
                remove_tree(disk, &format!("{path}/{name}"))?;
            }
            disk.remove_folder(path)
        }
        removed => removed,
    }
}
