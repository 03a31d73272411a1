//! What a unit knows of its flocks: which one plays, which one is on trial, which sequences it has seen.
//!
//! Owns every decision about generations, as pure functions of the state; whoever calls them writes the state down and
//! makes the disk follow. The *floor* of a key is the highest sequence that has won its trial: nothing of that key that
//! is not higher is let in again, but for the number of the floor itself once the disk has lost what it was: a unit
//! takes back the flock that it had. A lost trial raises no floor, so that the artist may send the same number again,
//! mended. Likewise the last that has won says for whom it was: a unit that was addressed by its name takes nothing any
//! more that is for everybody.
//!
//! A unit may fall back to an older program at any time: fields are only ever added, and what a program does not know it
//! keeps and writes down again as it found it.
//!
//! | state | event | becomes |
//! |---|---|---|
//! | good `g` | installed `t` | good `g`, trial `t`; what was before `g` goes |
//! | good `g`, trial `t` | installed `u` | good `g`, trial `u`; `t` goes, unjudged |
//! | good `g`, trial `t` | shown, for the [`JOINS`]th time | won |
//! | good `g`, trial `t` | started, for more than the [`STARTS`]th time in vain | lost |
//! | good `g`, trial `t` | won | good `t`, before `g`; the floor of its key rises |
//! | good `g`, trial `t` | lost | good `g`; `t` is marked bad and goes |
//! | trial `t` | lost | nothing: the player falls back to its own |
//!
//! Start at [`State::admit`].

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::key::KeyId;
use crate::names::{Addressees, ObjectId, Sequence, UnitId};
use crate::refused::Refused;
use crate::seal::Seal;

/// How often a trial may be begun in vain: a unit that died of a flock so often will not live with it.
pub const STARTS: u32 = 3;
/// The joins on the glass that win a trial, over however many starts.
pub const JOINS: u32 = 20;
/// How many bad bundles are remembered.
const BAD: usize = 64;

/// What a newer program has written, by its name.
pub type Unknown = BTreeMap<String, Value>;

/// One installed flock.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Generation {
    /// Counts the installations of this unit; names its folder.
    pub number: u64,
    /// What the artist calls the flock.
    pub flock: String,
    /// Who signed it.
    pub signer: KeyId,
    /// Its number among the bundles of that key.
    pub sequence: Sequence,
    /// The digest of its seal.
    pub seal: ObjectId,
    /// For whom it is; `None` where a program has written it that did not ask.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub addressees: Option<Addressees>,
    /// What a newer program knows of it.
    #[serde(flatten)]
    pub unknown: Unknown,
}

/// A generation that has to prove itself.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Trial {
    /// Which.
    pub generation: Generation,
    /// How often the unit has begun to play it since it last got as far as a join.
    pub starts: u32,
    /// The joins of it that were on the glass. A program that does not know them reads a trial without any.
    #[serde(default, skip_serializing_if = "is_none")]
    pub joins: u32,
    /// What a newer program knows of it.
    #[serde(flatten)]
    pub unknown: Unknown,
}

/// What a unit knows of its flocks.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct State {
    /// The highest sequence of each key that has won a trial here.
    pub floors: BTreeMap<KeyId, Sequence>,
    /// The last generation that has won its trial.
    pub good: Option<Generation>,
    /// The one that played before it, kept as a reserve.
    pub before: Option<Generation>,
    /// The one on trial; it plays.
    pub trial: Option<Trial>,
    /// The digests of seals that have lost a trial, oldest first.
    pub bad: Vec<ObjectId>,
    /// What keys said about keys, in the order in which it was learned.
    pub statements: Vec<String>,
    /// The number of the newest generation there ever was.
    pub newest: u64,
    /// For whom the last one was that has won its trial. It outlives that one: what is lost from the disk was still
    /// meant for this unit.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub addressees: Option<Addressees>,
    /// What a newer program knows.
    #[serde(flatten)]
    pub unknown: Unknown,
}

/// What the owner allows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Consent {
    /// Newer bundles only.
    Newer,
    /// This bundle, older or marked bad as it may be. To be given on the unit itself, by its owner.
    Any,
}

/// What becomes of a bundle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Admission {
    /// It is kept for when the one on trial is lost. What the store lacks of it may be fetched.
    Kept,
    /// It is to be installed.
    New,
    /// It is on trial already.
    OnTrial,
    /// It plays already.
    Plays,
}

/// How a trial stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// It was begun too often and is lost.
    Lost,
    /// It goes on.
    Open,
    /// It was shown often enough and is won.
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
    /// [`Refused::ForEverybody`], [`Refused::ForOthers`], [`Refused::MarkedBad`] or [`Refused::Older`].
    pub fn admit(&self, seal: &Seal, unit: &UnitId, consent: Consent) -> Result<Admission, Refused> {
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
            return Err(Refused::MarkedBad { sequence: letter.sequence });
        }
        let on_trial = self.trial.as_ref().filter(|trial| trial.generation.signer == signer);
        let floor = self.floors.get(&signer).copied().max(on_trial.map(|trial| trial.generation.sequence));
        let is_kept = |floor| self.kept().any(|kept| (kept.signer, kept.sequence) == (signer, floor));
        match floor {
            Some(floor) if letter.sequence < floor || letter.sequence == floor && is_kept(floor) => {
                Err(Refused::Older { sequence: letter.sequence, floor, signer })
            }
            Some(_) | None => Ok(Admission::New),
        }
    }

    /// For whom the last bundle was: the one on trial, else the last that won one.
    fn last_addressees(&self) -> Option<&Addressees> {
        let on_trial = self.trial.as_ref().and_then(|trial| trial.generation.addressees.as_ref());
        on_trial.or(self.addressees.as_ref())
    }

    /// What `seal_of` says for whom the generations are of which a program has written nothing about that. What plays
    /// is the last of them.
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

    /// The new generation is installed: it goes on trial.
    #[must_use]
    pub fn installed(mut self, generation: Generation) -> Self {
        self.newest = self.newest.max(generation.number);
        self.before = None;
        self.trial = Some(Trial { generation, starts: 0, joins: 0, unknown: Unknown::new() });
        self
    }

    /// The unit begins to play the one on trial.
    #[must_use]
    pub fn started(mut self) -> (Self, Verdict) {
        match &mut self.trial {
            Some(trial) if trial.starts >= STARTS => (self.lost(), Verdict::Lost),
            Some(trial) => {
                trial.starts += 1;
                (self, Verdict::Open)
            }
            None => (self, Verdict::Open),
        }
    }

    /// The last start is not held against the one on trial: nobody could have seen it, or it ended as it was told to.
    #[must_use]
    pub fn excused(mut self) -> Self {
        if let Some(trial) = &mut self.trial {
            trial.starts = trial.starts.saturating_sub(1);
        }
        self
    }

    /// A clip of the one on trial was on the glass to its end. What ends a machine in the midst of a clip is met there
    /// again by the next start, which then gets no further: so the starts before are not held against it.
    #[must_use]
    pub fn shown(mut self) -> (Self, Verdict) {
        let Some(trial) = &mut self.trial else { return (self, Verdict::Open) };
        trial.starts = 0;
        trial.joins += 1;
        if trial.joins < JOINS { (self, Verdict::Open) } else { (self.won(), Verdict::Won) }
    }

    /// The one on trial has proved itself.
    #[must_use]
    pub fn won(mut self) -> Self {
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
    pub fn lost(mut self) -> Self {
        if let Some(Trial { generation, .. }) = self.trial.take() {
            self.bad.retain(|bad| *bad != generation.seal);
            self.bad.push(generation.seal);
            let surplus = self.bad.len().saturating_sub(BAD);
            self.bad.drain(..surplus);
        }
        self
    }

    /// The good one turned out to be beyond repair: the one before it plays.
    #[must_use]
    pub fn good_is_gone(mut self) -> Self {
        self.good = self.before.take();
        self
    }

    /// What plays is gone from the disk, and nobody is to blame.
    #[must_use]
    pub fn vanished(mut self) -> Self {
        if self.trial.take().is_none() { self.good_is_gone() } else { self }
    }

    /// Nothing older than the good one is kept any longer.
    #[must_use]
    pub fn without_reserve(mut self) -> Self {
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
