//! What a walk remembers, and the place in a path that a unit saves at every join.
//!
//! Owns the saved form: version 1, little-endian, counts as LEB128. Sheep and transitions are saved by id, so that a
//! place outlives its flock (`carry.rs`). Never checks for torn writes: the player adds its checksum.
//!
//! Start at [`Place`].

use std::sync::Arc;

use super::ledger::Ledger;
use super::runs::{Recent, WINDOW};
use crate::flock::Flock;
use crate::graph::{Exit, Graph, SheepIx};
use crate::manifest::{NameError, SheepId};

/// The last visit of a sheep that was never visited.
pub(crate) const NEVER: u64 = u64::MAX;
/// Most steps: up to there every count is exact as a float, and credits are what they should be. A unit needs more than
/// ten thousand million years for them.
const MOST_STEPS: u64 = 1 << 53;
/// What a saved place starts with; the last byte is the version.
const MAGIC: &[u8; 8] = b"dreams\0\x01";

/// What a walk remembers, by the ordinals of its graph.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Memory {
    pub(crate) seed: u64,
    /// Steps taken; the present visit is visit number `step`, from 0.
    pub(crate) step: u64,
    pub(crate) place: SheepIx,
    pub(crate) ledger: Ledger,
    /// The last visit of each sheep, or [`NEVER`].
    pub(crate) last: Vec<u64>,
    /// The step from which on visits are due: 0, or that at which the flock changed.
    pub(crate) since: u64,
    /// Visits of each sheep before `since`.
    pub(crate) before: Vec<u64>,
    pub(crate) recent: Recent,
}

/// What ordinals stand for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Keys {
    pub(crate) hash: [u8; 32],
    pub(crate) sheep: Vec<SheepId>,
    pub(crate) exits: Vec<(SheepIx, SheepIx)>,
}

/// Whether the visit goes on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Next {
    /// The loop, which was played so often in this visit.
    Visit {
        /// Loops shown so far.
        played: u32,
    },
    /// A step.
    Leave,
}

/// A place in a path, from which it goes on exactly as if it had never been left.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    pub(crate) keys: Arc<Keys>,
    pub(crate) memory: Arc<Memory>,
    pub(crate) next: Next,
}

/// Why a place is of no use.
#[derive(Debug, PartialEq, Eq, thiserror::Error)]
pub enum PlaceError {
    /// The flock at hand has none of the place's sheep.
    #[error("the saved place is of another flock: of its {saved} sheep none is among the {found} at hand")]
    Foreign {
        /// Sheep of the place.
        saved: usize,
        /// Sheep of the flock.
        found: usize,
    },
    /// The bytes are no place of this version.
    #[error("the saved place is not of version 1: it starts with {found:02x?}")]
    Format {
        /// The first bytes, up to 8.
        found: Vec<u8>,
    },
    /// A number or name in it cannot be.
    #[error("the saved place is damaged at byte {at} of {length}: {what}")]
    Damaged {
        /// Where reading stopped.
        at: usize,
        /// How many bytes there are.
        length: usize,
        /// What cannot be.
        what: String,
    },
}

impl Memory {
    /// Nothing remembered but the first visit.
    pub(crate) fn new(graph: &Graph, seed: u64, place: SheepIx) -> Self {
        let mut last = vec![NEVER; graph.len()];
        last[place.index()] = 0;
        let (ledger, before) = (Ledger::new(graph), vec![0; graph.len()]);
        Self { seed, step: 0, place, ledger, last, since: 0, before, recent: Recent::new() }
    }
}

impl Keys {
    /// The keys of the part of `flock` that is walked.
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
    pub fn to_bytes(&self) -> Vec<u8> {
        let (keys, memory) = (&self.keys, &self.memory);
        let mut out = MAGIC.to_vec();
        out.extend_from_slice(&keys.hash);
        out.extend_from_slice(&memory.seed.to_le_bytes());
        for number in [memory.step, memory.since, u64::from(memory.place.0)] {
            write(&mut out, number);
        }
        match self.next {
            Next::Leave => write(&mut out, 0),
            Next::Visit { played } => write(&mut out, u64::from(played) + 1),
        }
        write(&mut out, keys.sheep.len() as u64);
        for (at, id) in keys.sheep.iter().enumerate() {
            write(&mut out, id.as_str().len() as u64);
            out.extend_from_slice(id.as_str().as_bytes());
            // 0 for never, else 1 and more: small numbers are short.
            write(&mut out, if memory.last[at] == NEVER { 0 } else { memory.step - memory.last[at] + 1 });
            write(&mut out, memory.before[at]);
        }
        write(&mut out, keys.exits.len() as u64);
        for (&(from, to), &taken) in keys.exits.iter().zip(memory.ledger.counts()) {
            for number in [u64::from(from.0), u64::from(to.0), taken] {
                write(&mut out, number);
            }
        }
        write(&mut out, memory.recent.len() as u64);
        for exit in &memory.recent {
            write(&mut out, u64::from(exit.0));
        }
        out
    }

    /// Reads what [`Self::to_bytes`] wrote.
    ///
    /// # Errors
    /// [`PlaceError::Format`] or [`PlaceError::Damaged`]; never a panic, whatever the bytes.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, PlaceError> {
        if !bytes.starts_with(MAGIC) {
            return Err(PlaceError::Format { found: bytes[..bytes.len().min(MAGIC.len())].to_vec() });
        }
        let mut reader = Reader { bytes, at: MAGIC.len() };
        let hash = reader.array()?;
        let seed = u64::from_le_bytes(reader.array()?);
        let step = reader.upto("steps", MOST_STEPS)?;
        let since = reader.upto("the change of flocks", step)?;
        let place = reader.upto("the place", u64::from(u32::MAX))? as u32;
        let next = match reader.upto("loops played", u64::from(u32::MAX))? as u32 {
            0 => Next::Leave,
            count => Next::Visit { played: count - 1 },
        };
        let (mut sheep, mut last, mut before) = (Vec::new(), Vec::new(), Vec::new());
        for _ in 0..reader.count()? {
            sheep.push(reader.id()?);
            last.push(match reader.upto("a last visit", step + 1)? {
                0 => NEVER,
                ago => step - (ago - 1),
            });
            before.push(reader.upto("earlier visits", step + 1)?);
        }
        let most = (sheep.len() as u64).checked_sub(1).ok_or_else(|| reader.damaged("no sheep"))?;
        if u64::from(place) > most {
            return Err(reader.damaged("the place is no sheep"));
        }
        let (mut exits, mut taken, mut left) = (Vec::new(), Vec::new(), step);
        for _ in 0..reader.count()? {
            let (from, to) = (reader.upto("a sheep", most)? as u32, reader.upto("a sheep", most)? as u32);
            exits.push((SheepIx(from), SheepIx(to)));
            taken.push(reader.upto("times taken", left)?);
            left -= taken[taken.len() - 1];
        }
        let mut recent = Recent::new();
        for _ in 0..reader.upto("recent steps", WINDOW as u64)? {
            let beyond = exits.len() as u64;
            let exit = reader.upto("a transition", beyond)?;
            if exit == beyond {
                return Err(reader.damaged("a recent step is no transition"));
            }
            recent.push_back(Exit(exit as u32));
        }
        if reader.at != bytes.len() {
            return Err(reader.damaged("bytes are left over"));
        }
        let ledger = Ledger::with(taken);
        let memory = Memory { seed, step, place: SheepIx(place), ledger, last, since, before, recent };
        Ok(Self { keys: Arc::new(Keys { hash, sheep, exits }), memory: Arc::new(memory), next })
    }
}

fn write(out: &mut Vec<u8>, mut number: u64) {
    while number >= 0x80 {
        out.push(number as u8 | 0x80);
        number >>= 7;
    }
    out.push(number as u8);
}

struct Reader<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl Reader<'_> {
    fn damaged(&self, what: impl Into<String>) -> PlaceError {
        PlaceError::Damaged { at: self.at, length: self.bytes.len(), what: what.into() }
    }

    fn take(&mut self, count: usize) -> Result<&[u8], PlaceError> {
        let end = self.at.checked_add(count).filter(|&end| end <= self.bytes.len());
        let end = end.ok_or_else(|| self.damaged("it ends too early"))?;
        let taken = &self.bytes[self.at..end];
        self.at = end;
        Ok(taken)
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N], PlaceError> {
        Ok(self.take(N)?.try_into().expect("`take` gives as many bytes as asked"))
    }

    fn upto(&mut self, what: &str, most: u64) -> Result<u64, PlaceError> {
        let mut number = 0u64;
        for shift in (0..64).step_by(7) {
            let [byte] = self.array()?;
            number |= u64::from(byte & 0x7f) << shift;
            if byte & 0x80 == 0 {
                break;
            }
        }
        if number <= most { Ok(number) } else { Err(self.damaged(format!("{what}: {number}, at most {most}"))) }
    }

    /// A number of things that take at least a byte each.
    fn count(&mut self) -> Result<u64, PlaceError> {
        let most = self.bytes.len() as u64;
        self.upto("a number of entries", most)
    }

    fn id(&mut self) -> Result<SheepId, PlaceError> {
        let length = self.upto("the length of an id", 64)? as usize;
        let text = String::from_utf8_lossy(self.take(length)?).into_owned();
        SheepId::new(&text).map_err(|error: NameError| self.damaged(error.to_string()))
    }
}
