//! The state of a unit's flocks: the current generation, its trial, and the sequences seen.
//!
//! Owns every decision about generations, as pure functions of the state; the caller saves the state and updates the
//! disk. The *floor* of a key is the highest sequence that was accepted after its trial. Bundles of that key must have
//! a higher one, except that the floor itself is admitted again if the disk has lost that generation. A rejected trial
//! does not raise the floor, so that the artist may send a corrected bundle with the same number. The addressees of the
//! last accepted bundle are kept, too: a unit that was addressed by name admits no bundles for all units any more.
//!
//! A unit may go back to an older program at any time: fields are only added, and a program keeps unknown fields unchanged.
//!
//! | state | event | becomes |
//! |---|---|---|
//! | good `g` | installed `t` | good `g`, trial `t`; the one before `g` is dropped |
//! | good `g`, trial `t` | installed `u` | good `g`, trial `u`; `t` is dropped without a verdict |
//! | good `g`, trial `t` | shown for the [`JOINS`]th time | accepted |
//! | good `g`, trial `t` | started more than [`STARTS`] times without a clip | rejected |
//! | good `g`, trial `t` | accepted | good `t`, before `g`; the floor of its key rises |
//! | good `g`, trial `t` | rejected | good `g`; `t` is marked bad and dropped |
//! | trial `t` | rejected | nothing: the player shows its built-in flock |
//!
//! Start at [`State::admit`].

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::key::KeyId;
use crate::names::{Addressees, ObjectId, Sequence, UnitId};
use crate::refusal::Refusal;
use crate::seal::Seal;

/// Starts of a trial without a completed clip after which it is rejected: the flock probably crashes the unit.
pub const STARTS: u32 = 3;
/// Joins after which a trial is accepted, over any number of starts.
pub const JOINS: u32 = 20;
/// How many bad bundles are remembered.
const BAD: usize = 64;

/// Unknown fields of a newer program, by name.
pub type Unknown = BTreeMap<String, Value>;

/// One installed flock.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Generation {
    /// The number of the installation on this unit, and the name of its folder.
    pub number: u64,
    /// The flock's name.
    pub flock: String,
    /// Who signed it.
    pub signer: KeyId,
    /// Its sequence number.
    pub sequence: Sequence,
    /// The digest of its seal.
    pub seal: ObjectId,
    /// Its addressees; `None` if an older program wrote it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub addressees: Option<Addressees>,
    /// Unknown fields of a newer program.
    #[serde(flatten)]
    pub unknown: Unknown,
}

/// A generation on trial.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Trial {
    /// Which.
    pub generation: Generation,
    /// Starts since its last join.
    pub starts: u32,
    /// Its joins that were shown. Missing in the state of older programs.
    #[serde(default, skip_serializing_if = "is_none")]
    pub joins: u32,
    /// Unknown fields of a newer program.
    #[serde(flatten)]
    pub unknown: Unknown,
}

/// The state of a unit's flocks.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct State {
    /// The highest accepted sequence of each key.
    pub floors: BTreeMap<KeyId, Sequence>,
    /// The last accepted generation.
    pub good: Option<Generation>,
    /// The one that played before it, kept as a reserve.
    pub before: Option<Generation>,
    /// The one on trial; it plays.
    pub trial: Option<Trial>,
    /// The digests of rejected seals, oldest first.
    pub bad: Vec<ObjectId>,
    /// The learned statements about keys, in order.
    pub statements: Vec<String>,
    /// The number of the newest generation so far.
    pub newest: u64,
    /// The addressees of the last accepted generation. They are kept even if that generation is lost from the disk.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub addressees: Option<Addressees>,
    /// Unknown fields of a newer program.
    #[serde(flatten)]
    pub unknown: Unknown,
}

/// The owner's consent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Consent {
    /// Newer bundles only.
    Newer,
    /// Admits an older bundle, or one marked bad. Only the owner gives it, on the unit itself.
    Any,
}

/// The decision on a bundle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Admission {
    /// It is kept in case the trial is rejected. Its missing objects may be fetched.
    Kept,
    /// It is to be installed.
    New,
    /// It is on trial already.
    OnTrial,
    /// It plays already.
    Plays,
}

/// The result of a trial.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// Rejected, after too many starts.
    Lost,
    /// It goes on.
    Open,
    /// Accepted, after enough clips.
    Won,
}

impl State {
    /// The generation that plays: the one on trial, else the good one.
    pub fn playing(&self) -> Option<&Generation> {
        self.trial.as_ref().map(|trial| &trial.generation).or(self.good.as_ref())
    }

    /// The generations whose files must stay.
    pub fn kept(&self) -> impl Iterator<Item = &Generation> {
        let trial = self.trial.as_ref().map(|trial| &trial.generation);
        trial.into_iter().chain(&self.good).chain(&self.before)
    }

    /// Whether the bundle behind `seal` may be installed on `unit`.
    ///
    /// # Errors
    /// [`Refusal::ForEverybody`], [`Refusal::ForOthers`], [`Refusal::MarkedBad`] or [`Refusal::Older`].
    pub fn admit(&self, seal: &Seal, unit: &UnitId, consent: Consent) -> Result<Admission, Refusal> {
        let (letter, id, signer) = (seal.letter(), seal.id(), seal.signer());
        letter.addressees.admit(unit, None)?;
        let is = |generation: &Generation| generation.seal == id;
        if let Some(trial) = &self.trial {
            if is(&trial.generation) {
                return Ok(Admission::OnTrial);
            }
        } else if self.good.as_ref().is_some_and(is) {
            return Ok(Admission::Plays);
        }
        if consent == Consent::Any {
            return Ok(Admission::New);
        }
        if self.good.as_ref().is_some_and(is) {
            return Ok(Admission::Kept);
        }
        letter.addressees.admit(unit, self.last_addressees())?;
        if self.bad.contains(&id) {
            return Err(Refusal::MarkedBad { sequence: letter.sequence });
        }
        let on_trial = self.trial.as_ref().filter(|trial| trial.generation.signer == signer);
        let floor = self.floors.get(&signer).copied().max(on_trial.map(|trial| trial.generation.sequence));
        let is_kept = |floor| self.kept().any(|kept| (kept.signer, kept.sequence) == (signer, floor));
        match floor {
            Some(floor) if letter.sequence < floor || letter.sequence == floor && is_kept(floor) => {
                Err(Refusal::Older { sequence: letter.sequence, floor, signer })
            }
            Some(_) | None => Ok(Admission::New),
        }
    }

    /// The addressees of the last bundle: the one on trial, else the last accepted one.
    fn last_addressees(&self) -> Option<&Addressees> {
        let on_trial = self.trial.as_ref().and_then(|trial| trial.generation.addressees.as_ref());
        on_trial.or(self.addressees.as_ref())
    }

    /// Fills in missing addressees of generations from `seal_of`; the one that plays comes last.
    #[must_use]
    pub fn addressed(mut self, seal_of: impl Fn(&Generation) -> Option<Addressees>) -> Self {
        let trial = self.trial.as_mut().map(|trial| &mut trial.generation);
        for generation in trial.into_iter().chain(&mut self.before) {
            generation.addressees = generation.addressees.take().or_else(|| seal_of(generation));
        }
        if let Some(good) = self.good.as_mut().filter(|good| good.addressees.is_none()) {
            good.addressees = seal_of(good);
            self.addressees = good.addressees.clone().or(self.addressees.take());
        }
        self
    }

    /// The number that the next generation gets.
    pub fn next_number(&self) -> u64 {
        self.newest + 1
    }

    /// A new generation is installed, and goes on trial.
    #[must_use]
    pub fn install_trial(mut self, generation: Generation) -> Self {
        self.newest = self.newest.max(generation.number);
        self.before = None;
        self.trial = Some(Trial { generation, starts: 0, joins: 0, unknown: Unknown::new() });
        self
    }

    /// The unit starts to play the generation on trial.
    #[must_use]
    pub fn record_start(mut self) -> (Self, Verdict) {
        match &mut self.trial {
            Some(trial) if trial.starts >= STARTS => (self.reject(), Verdict::Lost),
            Some(trial) => {
                trial.starts += 1;
                (self, Verdict::Open)
            }
            None => (self, Verdict::Open),
        }
    }

    /// The last start does not count: the picture was not visible, or the player was stopped regularly.
    #[must_use]
    pub fn excuse_start(mut self) -> Self {
        if let Some(trial) = &mut self.trial {
            trial.starts = trial.starts.saturating_sub(1);
        }
        self
    }

    /// A clip of the generation on trial was shown to its end. Earlier starts no longer count: a crash in a certain
    /// clip would happen again at the next start.
    #[must_use]
    pub fn record_clip(mut self) -> (Self, Verdict) {
        let Some(trial) = &mut self.trial else { return (self, Verdict::Open) };
        trial.starts = 0;
        trial.joins += 1;
        if trial.joins < JOINS { (self, Verdict::Open) } else { (self.accept(), Verdict::Won) }
    }

    /// The generation on trial is accepted.
    #[must_use]
    pub fn accept(mut self) -> Self {
        if let Some(Trial { generation, .. }) = self.trial.take() {
            let floor = self.floors.entry(generation.signer).or_insert(generation.sequence);
            *floor = generation.sequence.max(*floor);
            self.addressees = generation.addressees.clone().or(self.addressees.take());
            self.before = self.good.replace(generation);
        }
        self
    }

    /// The one on trial does not play.
    #[must_use]
    pub fn reject(mut self) -> Self {
        if let Some(Trial { generation, .. }) = self.trial.take() {
            self.bad.retain(|bad| *bad != generation.seal);
            self.bad.push(generation.seal);
            let surplus = self.bad.len().saturating_sub(BAD);
            self.bad.drain(..surplus);
        }
        self
    }

    /// The good generation cannot be repaired: the one before it plays.
    #[must_use]
    pub fn drop_good(mut self) -> Self {
        self.good = self.before.take();
        self
    }

    /// The generation that plays is missing on the disk; it is not marked bad.
    #[must_use]
    pub fn drop_playing(mut self) -> Self {
        if self.trial.take().is_none() { self.drop_good() } else { self }
    }

    /// The generation before the good one is no longer kept.
    #[must_use]
    pub fn drop_before(mut self) -> Self {
        self.before = None;
        self
    }
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde hands it over so")]
fn is_none(count: &u32) -> bool {
    *count == 0
}

#[cfg(test)]
mod tests;
