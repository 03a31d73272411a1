//! The state of a walk, and the place that a unit saves at every join.
//!
//! Owns the saved form, version 1: that of [`Saved`] in the format of `postcard`. Sheep and transitions are saved by
//! id, so that a place outlives its flock (`carry_over.rs`). The player adds a checksum against torn writes.
//!
//! Start at [`Place`].

use std::sync::Arc;

use super::ledger::Ledger;
use super::runs::{Recent, WINDOW};
use crate::flock::Flock;
use crate::graph::{Exit, Graph, SheepIx};
use crate::manifest::SheepId;

/// The last visit of a sheep that was never visited.
pub(crate) const NEVER: u64 = u64::MAX;
/// Most steps: up to there every count is exact as a float. A unit needs more than ten thousand million years for them.
const MAX_STEPS: u64 = 1 << 53;
/// The first bytes of a saved place; the last one is the version.
const MAGIC: &[u8; 8] = b"dreams\0\x01";

/// The state of a walk, by the ordinals of its graph.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Memory {
    pub(crate) seed: u64,
    /// Steps taken; the present visit is visit number `step`, from 0.
    pub(crate) step: u64,
    pub(crate) place: SheepIx,
    pub(crate) ledger: Ledger,
    /// The last visit of each sheep, or [`NEVER`].
    pub(crate) last: Vec<u64>,
    /// The step from which visits are counted against shares: 0, or that of the last change of flocks.
    pub(crate) since: u64,
    /// Visits of each sheep before `since`.
    pub(crate) before: Vec<u64>,
    pub(crate) recent: Recent,
}

/// The ids of ordinals.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Keys {
    pub(crate) hash: [u8; 32],
    pub(crate) sheep: Vec<SheepId>,
    pub(crate) exits: Vec<(SheepIx, SheepIx)>,
}

/// Whether the visit goes on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Next {
    /// The loop, with the number of times it was played in this visit.
    Visit {
        /// Loops shown so far.
        played: u32,
    },
    /// A step.
    Leave,
}

/// A place in a path, from which it resumes exactly.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    pub(crate) keys: Arc<Keys>,
    pub(crate) memory: Arc<Memory>,
    pub(crate) next: Next,
}

/// The serialized form of a place. A change needs another [`MAGIC`].
#[derive(serde::Deserialize, serde::Serialize)]
struct Saved<'a> {
    magic: [u8; 8],
    hash: [u8; 32],
    #[serde(with = "postcard::fixint::le")]
    seed: u64,
    step: u64,
    since: u64,
    place: u32,
    /// 0 to leave, else one more than the loops played.
    next: u32,
    /// Id; 0 for never, else one more than the steps since the last visit; visits before `since`.
    #[serde(borrow)]
    sheep: Vec<(&'a str, u64, u64)>,
    /// From, to, how often taken.
    exits: Vec<(u32, u32, u64)>,
    recent: Vec<u32>,
}

/// Why a place is of no use.
#[derive(Debug, PartialEq, Eq, thiserror::Error)]
pub enum PlaceError {
    /// The flock has none of the place's sheep.
    #[error("the saved place is of another flock: none of its {saved} sheep is among the {found} of this one")]
    Foreign {
        /// Sheep of the place.
        saved: usize,
        /// Sheep of the flock.
        found: usize,
    },
    /// The bytes are not a place of this version.
    #[error("the saved place is not in version 1 of its format: it starts with {found:02x?}")]
    Format {
        /// The first bytes, up to 8.
        found: Vec<u8>,
    },
    /// A number or name in it cannot be.
    #[error("the saved place of {length} bytes is damaged: {what}")]
    Damaged {
        /// How many bytes there are.
        length: usize,
        /// The invalid part.
        what: String,
    },
}

impl Memory {
    /// The state at the first visit.
    pub(crate) fn new(graph: &Graph, seed: u64, place: SheepIx) -> Self {
        let mut last = vec![NEVER; graph.len()];
        last[place.index()] = 0;
        let (ledger, before) = (Ledger::new(graph), vec![0; graph.len()]);
        Self { seed, step: 0, place, ledger, last, since: 0, before, recent: Recent::new() }
    }
}

impl Keys {
    /// The ids of the part of `flock` that is played.
    pub(crate) fn of(flock: &Flock) -> Self {
        let graph = flock.graph();
        let exits = |from| graph.exits(from).map(move |exit| (from, graph.target(exit)));
        Self {
            hash: flock.hash(),
            sheep: graph.sheep().map(|sheep| graph.id(sheep).clone()).collect(),
            exits: graph.sheep().flat_map(exits).collect(),
        }
    }
}

impl Place {
    /// The seed of the path.
    pub fn seed(&self) -> u64 {
        self.memory.seed
    }

    /// Steps taken before.
    pub fn step(&self) -> u64 {
        self.memory.step
    }

    /// The place as bytes.
    ///
    /// # Panics
    /// Serializing to memory cannot fail.
    pub fn to_bytes(&self) -> Vec<u8> {
        let (keys, memory) = (&self.keys, &self.memory);
        let ago = |last: u64| if last == NEVER { 0 } else { memory.step - last + 1 };
        let ids = keys.sheep.iter().map(SheepId::as_str);
        let visits = memory.last.iter().map(|&last| ago(last)).zip(&memory.before);
        let exits = keys.exits.iter().zip(memory.ledger.counts());
        let saved = Saved {
            magic: *MAGIC,
            hash: keys.hash,
            seed: memory.seed,
            step: memory.step,
            since: memory.since,
            place: memory.place.0,
            next: match self.next {
                Next::Leave => 0,
                Next::Visit { played } => played + 1,
            },
            sheep: ids.zip(visits).map(|(id, (ago, &before))| (id, ago, before)).collect(),
            exits: exits.map(|(&(from, to), &taken)| (from.0, to.0, taken)).collect(),
            recent: memory.recent.iter().map(|exit| exit.0).collect(),
        };
        postcard::to_allocvec(&saved).expect("lists of known length are written to memory")
    }

    /// Reads what [`Self::to_bytes`] wrote.
    ///
    /// # Errors
    /// [`PlaceError::Format`] or [`PlaceError::Damaged`]; never a panic, whatever the bytes.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, PlaceError> {
        if !bytes.starts_with(MAGIC) {
            return Err(PlaceError::Format { found: bytes[..bytes.len().min(MAGIC.len())].to_vec() });
        }
        let damaged = |what: String| PlaceError::Damaged { length: bytes.len(), what };
        let (saved, rest): (Saved, _) = postcard::take_from_bytes(bytes).map_err(|error| damaged(error.to_string()))?;
        let upto = |what: &str, number: u64, most: Option<u64>| match most {
            Some(most) if number <= most => Ok(()),
            Some(most) => Err(damaged(format!("{what}: {number}, at most {most}"))),
            None => Err(damaged(format!("{what}: {number}, of none"))),
        };
        let step = saved.step;
        let last_sheep = (saved.sheep.len() as u64).checked_sub(1);
        let last_exit = (saved.exits.len() as u64).checked_sub(1);
        upto("bytes left over", rest.len() as u64, Some(0))?;
        upto("steps", step, Some(MAX_STEPS))?;
        upto("the change of flocks", saved.since, Some(step))?;
        upto("the place", saved.place.into(), last_sheep)?;
        let mut sheep = Vec::with_capacity(saved.sheep.len());
        for &(id, ago, before) in &saved.sheep {
            sheep.push(SheepId::new(id).map_err(|error| damaged(error.to_string()))?);
            upto("a last visit", ago, Some(step + 1))?;
            upto("earlier visits", before, Some(step + 1))?;
        }
        let mut left = step;
        for &(from, to, taken) in &saved.exits {
            upto("a sheep", from.max(to).into(), last_sheep)?;
            upto("times taken", taken, Some(left))?;
            left -= taken;
        }
        upto("recent steps", saved.recent.len() as u64, Some(WINDOW as u64))?;
        for &exit in &saved.recent {
            upto("a transition", exit.into(), last_exit)?;
        }
        let seen = |&(_, ago, _): &(&str, u64, u64)| if ago == 0 { NEVER } else { step + 1 - ago };
        let memory = Memory {
            seed: saved.seed,
            step,
            place: SheepIx(saved.place),
            ledger: Ledger::with(saved.exits.iter().map(|&(.., taken)| taken).collect()),
            last: saved.sheep.iter().map(seen).collect(),
            since: saved.since,
            before: saved.sheep.iter().map(|&(.., before)| before).collect(),
            recent: saved.recent.into_iter().map(Exit).collect(),
        };
        let exits = saved.exits.iter().map(|&(from, to, _)| (SheepIx(from), SheepIx(to))).collect();
        let next = saved.next.checked_sub(1).map_or(Next::Leave, |played| Next::Visit { played });
        let keys = Keys { hash: saved.hash, sheep, exits };
        Ok(Self { keys: Arc::new(keys), memory: Arc::new(memory), next })
    }
}
