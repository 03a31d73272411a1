//! The objects that a unit has to fetch.
//!
//! Owns the difference between a bundle's objects and the present ones, by digest, so that objects shared by flocks are
//! fetched once. Pure: the present objects are an argument.
//!
//! Start at [`plan`].

use crate::contents::{Contents, FileEntry};
use crate::names::{FilePath, ObjectId};

/// The block size of a file system, to which sizes are rounded up.
const BLOCK: u64 = 4096;
/// Content pages for each page of fs-verity hashes.
const VERITY_FAN: u64 = 127;

/// How much of an object is there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Presence {
    /// Nothing.
    Nothing,
    /// This many bytes from its start, not verified.
    Part(u64),
    /// All of it, checked.
    Whole,
}

/// An object that is to be fetched.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FetchItem {
    /// Which.
    pub id: ObjectId,
    /// Its size in bytes.
    pub size: u64,
    /// The bytes present, from its start.
    pub have: u64,
    /// One of its paths in the flock, for messages.
    pub path: FilePath,
}

/// The objects to fetch for a bundle, `flock.toml` first, then in the order of the paths.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct FetchPlan {
    /// The objects, each once.
    pub wanted: Vec<FetchItem>,
    /// The number of all objects of the bundle.
    pub objects: usize,
    /// How many bytes they have.
    pub bytes: u64,
}

/// Room that is not there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shortfall {
    /// The bytes that the plan and the reserve need.
    pub needed: u64,
    /// What there is.
    pub room: u64,
}

/// Plans to fetch the objects of `contents` that are incomplete according to `held`.
///
/// # Errors
/// The first one of `held`.
pub fn plan<E>(contents: &Contents, held: impl FnMut(&FileEntry) -> Result<Presence, E>) -> Result<FetchPlan, E> {
    plan_of(contents.objects(), held)
}

/// The same for `files`, without duplicates.
pub(crate) fn plan_of<'f, E>(
    files: impl IntoIterator<Item = &'f FileEntry>,
    mut held: impl FnMut(&FileEntry) -> Result<Presence, E>,
) -> Result<FetchPlan, E> {
    let mut plan = FetchPlan::default();
    for file in files {
        plan.objects += 1;
        plan.bytes += file.size;
        let have = match held(file)? {
            Presence::Whole => continue,
            // A partial file that is too long is not ours.
            Presence::Part(have) if have <= file.size => have,
            Presence::Part(_) | Presence::Nothing => 0,
        };
        plan.wanted.push(FetchItem { id: file.id, size: file.size, have, path: file.path.clone() });
    }
    Ok(plan)
}

impl FetchPlan {
    /// How many bytes are to be fetched.
    pub fn to_fetch(&self) -> u64 {
        self.wanted.iter().map(|wanted| wanted.size - wanted.have).sum()
    }

    /// The disk space that this takes, in bytes, with the overhead of each file.
    pub fn to_store(&self) -> u64 {
        let stored = |wanted: &FetchItem| {
            let blocks = (wanted.size - wanted.have).div_ceil(BLOCK);
            (blocks + wanted.size.div_ceil(BLOCK * VERITY_FAN) + 1) * BLOCK
        };
        self.wanted.iter().map(stored).sum()
    }

    /// The shortfall if `room` bytes are free, of which `reserve` must stay free; `None` if it fits.
    pub fn shortfall(&self, room: u64, reserve: u64) -> Option<Shortfall> {
        if self.wanted.is_empty() {
            return None;
        }
        let needed = self.to_store().saturating_add(reserve);
        (needed > room).then_some(Shortfall { needed, room })
    }
}
