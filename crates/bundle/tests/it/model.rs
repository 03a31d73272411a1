//! A disk that forgets: nothing survives its power cut but what was synced.
//!
//! Names are made, moved and taken away by operations that are durable once a folder that they touch was synced; of the
//! others any subset survives. A file's bytes are durable once the file was synced; of the bytes behind that, any
//! beginning survives, or rubbish. A rename happens as a whole or not at all. Harsher than any file system we know.

use bundle::{Disk, Protection};
use durable::{Append, Storage};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use std::collections::BTreeMap;
use std::io::{self, Cursor, Read, Write};
use std::sync::{Arc, Mutex, MutexGuard};

/// A disk. Clones are the same disk.
#[derive(Clone)]
pub(crate) struct ModelDisk(Arc<Mutex<World>>);

/// What happens at one operation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Trouble {
    /// The machine dies: this and every later operation fails, and changes nothing.
    Death,
    /// This one operation fails with this kind of error; the others work.
    Once(io::ErrorKind),
}

#[derive(Clone)]
enum Node {
    Folder,
    File(u64),
    Link(String),
}

#[derive(Clone, Default)]
struct Inode {
    bytes: Vec<u8>,
    /// What of them a power cut leaves.
    durable: Vec<u8>,
}

#[derive(Clone)]
enum Change {
    Make(String, Node),
    Rename(String, String),
    Remove(String),
}

#[derive(Default)]
struct World {
    names: BTreeMap<String, Node>,
    /// The names as they were when the log below began.
    base: BTreeMap<String, Node>,
    log: Vec<(Change, bool)>,
    inodes: BTreeMap<u64, Inode>,
    /// Operations so far.
    count: u64,
    trouble: Option<(u64, Trouble)>,
    room: u64,
}

impl ModelDisk {
    /// An empty one, on which `trouble` happens at the operation of that number, from 0.
    pub(crate) fn new(trouble: Option<(u64, Trouble)>) -> Self {
        let names = BTreeMap::from([(String::new(), Node::Folder)]);
        let world = World { base: names.clone(), names, trouble, room: 1 << 40, ..World::default() };
        Self(Arc::new(Mutex::new(world)))
    }

    /// How many operations there were.
    pub(crate) fn operations(&self) -> u64 {
        self.world().count
    }

    /// The disk after the process was killed: nothing is lost.
    pub(crate) fn after_a_kill(&self) -> Self {
        let world = self.world();
        let (names, inodes) = (world.names.clone(), world.inodes.clone());
        drop(world);
        Self(Arc::new(Mutex::new(World { base: names.clone(), names, inodes, room: 1 << 40, ..World::default() })))
    }

    /// The same disk, left alone since, on which `trouble` happens at the operation of that number, from 0.
    pub(crate) fn with(&self, trouble: Option<(u64, Trouble)>) -> Self {
        let disk = self.after_a_kill();
        disk.world().trouble = trouble;
        disk
    }

    /// Changes the first byte of the file at `path`, under all its names.
    pub(crate) fn rot(&self, path: &str) {
        let mut world = self.world();
        let inode = world.inode(path).unwrap();
        let inode = world.inodes.get_mut(&inode).unwrap();
        inode.bytes[0] ^= 1;
        inode.durable[0] ^= 1;
    }

    /// The disk after a power cut, one of the many that it may be.
    pub(crate) fn after_a_power_cut(&self, seed: u64) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut chance = |percent: u32| random.next_u32() % 100 < percent;
        let keep = [0, 10, 50, 90, 100][(seed % 5) as usize];
        let world = self.world();
        let mut names = world.base.clone();
        for (change, durable) in &world.log {
            if *durable || chance(keep) {
                apply(&mut names, change);
            }
        }
        let mut inodes = world.inodes.clone();
        for inode in inodes.values_mut() {
            let unsynced = inode.bytes.len().saturating_sub(inode.durable.len());
            let more = if unsynced == 0 { 0 } else { random.next_u32() as usize % (unsynced + 1) };
            let mut left = inode.durable.clone();
            let tail: Vec<u8> = inode.bytes.iter().skip(left.len()).take(more).copied().collect();
            let rubbish = random.next_u32().is_multiple_of(2);
            left.extend(tail.iter().map(|byte| if rubbish { 0 } else { *byte }));
            *inode = Inode { durable: left.clone(), bytes: left };
        }
        drop(world);
        Self(Arc::new(Mutex::new(World { base: names.clone(), names, inodes, room: 1 << 40, ..World::default() })))
    }

    /// Every file beneath the folder, by its path there, through the links on the way; `None` if it is not there.
    pub(crate) fn tree(&self, folder: &str) -> Option<BTreeMap<String, Vec<u8>>> {
        let world = self.world();
        let folder = match world.names.get(folder)? {
            Node::Link(target) => target.clone(),
            Node::Folder | Node::File(_) => folder.to_owned(),
        };
        world.names.get(&folder)?;
        let beneath = format!("{folder}/");
        let mut files = BTreeMap::new();
        for (path, node) in &world.names {
            if let (Some(path), Node::File(inode)) = (path.strip_prefix(&beneath), node) {
                files.insert(path.to_owned(), world.inodes[inode].bytes.clone());
            }
        }
        Some(files)
    }

    fn world(&self) -> MutexGuard<'_, World> {
        self.0.lock().unwrap()
    }

    /// One more operation, which may be the troubled one.
    fn step(&self) -> io::Result<MutexGuard<'_, World>> {
        let mut world = self.world();
        let now = world.count;
        world.count += 1;
        match world.trouble {
            Some((at, Trouble::Death)) if now >= at => Err(io::Error::other("the machine is dead")),
            Some((at, Trouble::Once(kind))) if now == at => Err(kind.into()),
            Some(_) | None => Ok(world),
        }
    }
}

impl World {
    fn change(&mut self, change: Change) {
        apply(&mut self.names, &change);
        self.log.push((change, false));
    }

    /// Makes one change durable, and with a rename whatever gave the file its name before.
    fn keep(&mut self, at: usize) {
        self.log[at].1 = true;
        let Change::Rename(from, _) = self.log[at].0.clone() else { return };
        let named = |change: &Change| match change {
            Change::Make(name, _) | Change::Rename(_, name) => *name == from,
            Change::Remove(_) => false,
        };
        if let Some(before) = self.log[..at].iter().rposition(|(change, _)| named(change)) {
            self.keep(before);
        }
    }

    fn node(&self, path: &str) -> io::Result<&Node> {
        self.names.get(path).ok_or_else(|| io::ErrorKind::NotFound.into())
    }

    fn inode(&self, path: &str) -> io::Result<u64> {
        match self.node(path)? {
            Node::File(inode) => Ok(*inode),
            Node::Folder | Node::Link(_) => Err(io::ErrorKind::InvalidData.into()),
        }
    }

    fn free(&self, path: &str) -> io::Result<()> {
        if self.names.contains_key(path) {
            return Err(io::ErrorKind::AlreadyExists.into());
        }
        matches!(self.node(parent(path))?, Node::Folder)
            .then_some(())
            .ok_or_else(|| io::ErrorKind::NotADirectory.into())
    }
}

impl Storage for ModelDisk {
    fn read(&self, path: &str, limit: u64) -> io::Result<Vec<u8>> {
        let world = self.step()?;
        let bytes = world.inodes[&world.inode(path)?].bytes.clone();
        if bytes.len() as u64 > limit { Err(io::ErrorKind::FileTooLarge.into()) } else { Ok(bytes) }
    }

    fn append(&self, path: &str) -> io::Result<Box<dyn Append + '_>> {
        let mut world = self.step()?;
        let inode = match world.inode(path) {
            Ok(inode) => inode,
            Err(error) if error.kind() == io::ErrorKind::NotFound => {
                world.free(path)?;
                let inode = world.inodes.len() as u64;
                world.inodes.insert(inode, Inode::default());
                world.change(Change::Make(path.to_owned(), Node::File(inode)));
                inode
            }
            Err(error) => return Err(error),
        };
        Ok(Box::new(File { disk: self.clone(), inode }))
    }

    fn rename(&self, from: &str, to: &str) -> io::Result<()> {
        let mut world = self.step()?;
        world.node(from)?;
        assert!(matches!(world.node(parent(to))?, Node::Folder), "`{to}` has a folder to lie in");
        world.change(Change::Rename(from.to_owned(), to.to_owned()));
        Ok(())
    }

    fn remove(&self, path: &str) -> io::Result<()> {
        let mut world = self.step()?;
        match world.names.get(path) {
            None => Ok(()),
            Some(Node::Folder) => Err(io::ErrorKind::IsADirectory.into()),
            Some(Node::File(_) | Node::Link(_)) => {
                world.change(Change::Remove(path.to_owned()));
                Ok(())
            }
        }
    }

    fn sync_folder(&self, path: &str) -> io::Result<()> {
        let mut world = self.step()?;
        assert!(matches!(world.node(path)?, Node::Folder), "`{path}` is a folder");
        for at in 0..world.log.len() {
            let touches = match &world.log[at].0 {
                Change::Make(name, _) | Change::Remove(name) => parent(name) == path,
                Change::Rename(from, to) => parent(from) == path || parent(to) == path,
            };
            if touches {
                world.keep(at);
            }
        }
        Ok(())
    }
}

impl Disk for ModelDisk {
    fn open(&self, path: &str) -> io::Result<Box<dyn Read + '_>> {
        let world = self.step()?;
        Ok(Box::new(Cursor::new(world.inodes[&world.inode(path)?].bytes.clone())))
    }

    fn length(&self, path: &str) -> io::Result<Option<u64>> {
        let world = self.step()?;
        match world.inode(path) {
            Ok(inode) => Ok(Some(world.inodes[&inode].bytes.len() as u64)),
            Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
            Err(error) => Err(error),
        }
    }

    fn list(&self, folder: &str) -> io::Result<Vec<String>> {
        let world = self.step()?;
        let inside = |path: &&String| !path.is_empty() && parent(path) == folder;
        Ok(world.names.keys().filter(inside).map(|path| path.rsplit('/').next().unwrap().to_owned()).collect())
    }

    fn make_folder(&self, path: &str) -> io::Result<()> {
        let mut world = self.step()?;
        if matches!(world.names.get(path), Some(Node::Folder)) {
            return Ok(());
        }
        world.free(path)?;
        world.change(Change::Make(path.to_owned(), Node::Folder));
        Ok(())
    }

    fn link(&self, from: &str, to: &str) -> io::Result<()> {
        let mut world = self.step()?;
        let inode = world.inode(from)?;
        world.free(to)?;
        world.change(Change::Make(to.to_owned(), Node::File(inode)));
        Ok(())
    }

    fn remove_folder(&self, path: &str) -> io::Result<()> {
        let mut world = self.step()?;
        if world.names.keys().any(|other| other != path && parent(other) == path && !other.is_empty()) {
            return Err(io::ErrorKind::DirectoryNotEmpty.into());
        }
        if world.names.contains_key(path) {
            world.change(Change::Remove(path.to_owned()));
        }
        Ok(())
    }

    fn symlink(&self, path: &str, target: &str) -> io::Result<()> {
        let mut world = self.step()?;
        world.free(path)?;
        world.change(Change::Make(path.to_owned(), Node::Link(target.to_owned())));
        Ok(())
    }

    fn read_link(&self, path: &str) -> io::Result<Option<String>> {
        let world = self.step()?;
        Ok(match world.names.get(path) {
            Some(Node::Link(target)) => Some(target.clone()),
            Some(Node::File(_) | Node::Folder) | None => None,
        })
    }

    fn make_read_only(&self, path: &str) -> io::Result<Protection> {
        let mut world = self.step()?;
        let inode = world.inode(path)?;
        let inode = world.inodes.get_mut(&inode).unwrap();
        inode.durable.clone_from(&inode.bytes);
        Ok(Protection::ReadOnly)
    }

    fn free_bytes(&self) -> io::Result<u64> {
        Ok(self.step()?.room)
    }

    fn lock_state(&self) -> io::Result<Option<std::fs::File>> {
        Ok(None)
    }

    fn is_in_use(&self, _folder: &str) -> io::Result<bool> {
        Ok(false)
    }
}

/// A file that grows.
struct File {
    disk: ModelDisk,
    inode: u64,
}

impl Write for File {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let mut world = self.disk.step()?;
        // Short writes are the rule.
        let count = bytes.len().div_ceil(2);
        world.inodes.get_mut(&self.inode).unwrap().bytes.extend_from_slice(&bytes[..count]);
        Ok(count)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Append for File {
    fn sync(&mut self) -> io::Result<()> {
        let mut world = self.disk.step()?;
        let inode = world.inodes.get_mut(&self.inode).unwrap();
        inode.durable.clone_from(&inode.bytes);
        Ok(())
    }
}

/// Makes the change, as far as it can be made: what it builds upon may be lost.
fn apply(names: &mut BTreeMap<String, Node>, change: &Change) {
    let there = |names: &BTreeMap<String, Node>, path: &str| matches!(names.get(parent(path)), Some(Node::Folder));
    match change {
        Change::Make(path, node) => {
            if there(names, path) {
                names.insert(path.clone(), node.clone());
            }
        }
        Change::Rename(from, to) => {
            if there(names, to)
                && let Some(node) = names.remove(from)
            {
                names.insert(to.clone(), node);
            }
        }
        Change::Remove(path) => {
            names.remove(path);
        }
    }
}

fn parent(path: &str) -> &str {
    path.rsplit_once('/').map_or("", |(folder, _)| folder)
}
