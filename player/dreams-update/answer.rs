//! The answer of an update run.
//!
//! Owns the fields of the JSON document and the line that says the same. Never decides anything.

use crate::astray::Astray;
use bundle::{Generation, Version};
use serde::Serialize;
use std::fmt;

/// How an update ended that did not fail.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Outcome {
    /// A new generation is on trial.
    Installed,
    /// What the source has plays already.
    NoNews,
    /// The source has no bundle for this unit.
    NoBundle,
    /// It is not yet time to look, or there is nowhere to look.
    NotNow,
}

/// What became of a system that the source has.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum SystemOutcome {
    /// This version is here, and is written next.
    Staged(Version),
    /// It runs, or a newer one does; or it had its chance.
    NoNews,
    /// The source has none, or this unit takes none.
    None,
    /// This version lies in the other slot, and is started next.
    Written(Version),
}

/// What was done.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub(crate) struct Answer {
    pub(crate) outcome: Outcome,
    pub(crate) system: SystemOutcome,
    /// The flock that plays now, and its number among those of its key; none on a unit without a flock.
    pub(crate) flock: Option<String>,
    pub(crate) sequence: Option<u64>,
    pub(crate) generation: Option<u64>,
    /// Objects that were fetched, and how many bytes were read for them.
    pub(crate) fetched: usize,
    pub(crate) fetched_bytes: u64,
    /// Objects that were damaged or gone, and were fetched again.
    pub(crate) mended: usize,
    /// Objects that are damaged or gone, and that the source did not have.
    pub(crate) missing: usize,
    /// What the source has instead of a bundle, if people have laid it out wrongly.
    pub(crate) astray: Option<Astray>,
}

impl Answer {
    /// An answer about the generation that plays.
    pub(crate) fn of(outcome: Outcome, playing: Option<&Generation>) -> Self {
        Self {
            outcome,
            system: SystemOutcome::None,
            flock: playing.map(|playing| playing.flock.clone()),
            sequence: playing.map(|playing| playing.sequence.0),
            generation: playing.map(|playing| playing.number),
            fetched: 0,
            fetched_bytes: 0,
            mended: 0,
            missing: 0,
            astray: None,
        }
    }
}

impl fmt::Display for Answer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (flock, sequence) = (self.flock.as_deref().unwrap_or("no flock"), self.sequence.unwrap_or_default());
        match self.outcome {
            Outcome::Installed => write!(f, "installed `{flock}` {sequence}")?,
            Outcome::NoNews => write!(f, "no news: `{flock}` {sequence} plays")?,
            Outcome::NoBundle => write!(f, "no bundle there")?,
            Outcome::NotNow => write!(f, "nothing was looked for")?,
        }
        match &self.astray {
            Some(Astray::Below(_)) => write!(f, ": it is one folder down")?,
            Some(Astray::Unsigned) => write!(f, ": the flock is not signed")?,
            None => {}
        }
        match &self.system {
            SystemOutcome::Staged(version) => write!(f, ", system {version} is here")?,
            SystemOutcome::NoNews => write!(f, ", no news of the system")?,
            SystemOutcome::None => {}
            SystemOutcome::Written(version) => write!(f, ", system {version} is started next")?,
        }
        if self.fetched > 0 {
            write!(f, ", {} files fetched, {} bytes", self.fetched, self.fetched_bytes)?;
        }
        if self.mended > 0 {
            write!(f, ", {} of them mended", self.mended)?;
        }
        if self.missing > 0 {
            write!(f, ", {} files are missing", self.missing)?;
        }
        Ok(())
    }
}
