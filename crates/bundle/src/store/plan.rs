//! What a unit has to fetch.
//!
//! Owns the difference between what a bundle lists and what is there: by content, so that what two flocks share is
//! never fetched again. Pure: what is there comes in as an argument.
//!
//! Start at [`plan`].

use crate::contents::{Contents, FileEntry};
use crate::names::{FilePath, ObjectId};

/// What a file system takes in pieces of: sizes are rounded up to it.
const BLOCK: u64 = 4096;
/// One page of fs-verity's hashes for so many of content.
const VERITY_FAN: u64 = 127;

/// How much of an object is there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Held {
    /// Nothing.
    Nothing,
    /// So many bytes from its beginning, not checked.
    Part(u64),
    /// All of it, checked.
    Whole,
}

/// An object that is to be fetched.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Wanted {
    /// Which.
    pub id: ObjectId,
    /// Its size in bytes.
    pub size: u64,
    /// How much of it is there, from its beginning.
    pub have: u64,
    /// One of the paths that it has in the flock: what people know it by.
    pub path: FilePath,
}

/// What has to be fetched for a bundle, `flock.toml` first, then in the order of the paths.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Plan {
    /// The objects, each once.
    pub wanted: Vec<Wanted>,
    /// How many objects the bundle has, those that are there included.
    pub objects: usize,
    /// How many bytes they have.
    pub bytes: u64,
}

/// Room that is not there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shortfall {
    /// What the plan and the reserve need, in bytes.
    pub needed: u64,
    /// What there is.
    pub room: u64,
}

/// Plans to fetch the objects of `contents` of which `held` tells that they are not whole.
///
/// # Errors
/// The first one of `held`.
pub fn plan<E>(contents: &Contents, held: impl FnMut(&FileEntry) -> Result<Held, E>) -> Result<Plan, E> {
    plan_of(contents.objects(), held)
}

/// The same, of these `files`, none of which is there twice.
pub(crate) fn plan_of<'f, E>(
    files: impl IntoIterator<Item = &'f FileEntry>,
    mut held: impl FnMut(&FileEntry) -> Result<Held, E>,
) -> Result<Plan, E> {
    let mut plan = Plan::default();
    for file in files {
        plan.objects += 1;
        plan.bytes += file.size;
        let have = match held(file)? {
            Held::Whole => continue,
            // More than there can be was never ours.
            Held::Part(have) if have <= file.size => have,
            Held::Part(_) | Held::Nothing => 0,
        };
        plan.wanted.push(Wanted { id: file.id, size: file.size, have, path: file.path.clone() });
    }
    Ok(plan)
}

impl Plan {
    /// How many bytes are to be fetched.
    pub fn to_fetch(&self) -> u64 {
        self.wanted.iter().map(|wanted| wanted.size - wanted.have).sum()
    }

    /// How many bytes of the disk that will take, with all that belongs to a file.
    pub fn to_store(&self) -> u64 {
        let stored = |wanted: &Wanted| {
            let blocks = (wanted.size - wanted.have).div_ceil(BLOCK);
            (blocks + wanted.size.div_ceil(BLOCK * VERITY_FAN) + 1) * BLOCK
        };
        self.wanted.iter().map(stored).sum()
    }

    /// What is missing if `room` bytes are free, of which `reserve` must stay so; `None` if it fits.
    pub fn shortfall(&self, room: u64, reserve: u64) -> Option<Shortfall> {
        if self.wanted.is_empty() {
            return None;
        }
        let needed = self.to_store().saturating_add(reserve);
        (needed > room).then_some(Shortfall { needed, room })
    }
}
