//! What went wrong while playing, each cause told once.
//!
//! Owns the list of faults. A fault never stops the picture; whatever stops it is `report::Fatal`. Telling goes
//! through the scribe, so any thread may report without waiting for a disk.

use crate::recording::recorder::{Note, Scribe};
use std::collections::BTreeSet;
use std::sync::{Arc, Mutex, PoisonError};

/// What kind of thing went wrong, spelled as `flock check` spells it where that knows it too.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Kind {
    /// No clip of the flock can be played.
    Barren,
    /// A clip does not decode cleanly, or has fewer frames than it should.
    DamagedClip,
    /// A clip cannot be opened.
    MissingClip,
    /// The walk's place cannot be kept.
    Place,
    /// The screen went away, or repaired itself.
    Screen,
    /// A clip has not the flock's form.
    WrongClip,
}

impl Kind {
    /// Its name in the trace and on the status page.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Barren => "barren",
            Self::DamagedClip => "damaged-clip",
            Self::MissingClip => "missing-clip",
            Self::Place => "place",
            Self::Screen => "screen",
            Self::WrongClip => "wrong-clip",
        }
    }
}

/// One fault, as it was told.
#[derive(Clone, Debug)]
pub(crate) struct Fault {
    pub(crate) kind: Kind,
    pub(crate) message: String,
    /// It was told in these words before: another occurrence, no news.
    pub(crate) is_repeated: bool,
}

/// The faults of a run; clones share the list.
#[derive(Clone, Debug)]
pub(crate) struct Faults {
    scribe: Scribe,
    told: Arc<Mutex<Told>>,
}

#[derive(Debug, Default)]
struct Told {
    causes: BTreeSet<(Kind, String)>,
    words: BTreeSet<(Kind, String)>,
    count: u64,
    latest: Vec<Fault>,
}

/// How many faults the status page shows.
const LATEST: usize = 20;

impl Faults {
    /// No faults so far.
    pub(crate) fn new(scribe: Scribe) -> Self {
        Self { scribe, told: Arc::default() }
    }

    /// Tells that something went wrong with `subject`, unless that was told before.
    pub(crate) fn once(&self, kind: Kind, subject: &str, message: String) {
        let is_new = self.lock().causes.insert((kind, subject.to_owned()));
        if is_new {
            self.tell(kind, message);
        }
    }

    /// Another flock is played: what was told of the clips of the one before may be told again.
    pub(crate) fn renew(&self) {
        self.lock().causes.clear();
    }

    /// Tells that something went wrong, as often as it does. It is news only the first time.
    pub(crate) fn tell(&self, kind: Kind, message: String) {
        let mut told = self.lock();
        told.count += 1;
        let is_repeated = !told.words.insert((kind, message.clone()));
        let fault = Fault { kind, message, is_repeated };
        if told.latest.len() == LATEST {
            told.latest.remove(0);
        }
        told.latest.push(fault.clone());
        drop(told);
        self.scribe.note(Note::Fault(fault));
    }

    /// How many faults were told.
    pub(crate) fn count(&self) -> u64 {
        self.lock().count
    }

    /// The latest faults, oldest first.
    pub(crate) fn latest(&self) -> Vec<Fault> {
        self.lock().latest.clone()
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, Told> {
        self.told.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::{Faults, Kind};
    use crate::recording::recorder::{Note, Scribe};

    #[test]
    fn a_cause_is_told_once_and_an_occurrence_each_time() {
        let (scribe, notes) = Scribe::on_a_shelf();
        let faults = Faults::new(scribe);
        for _ in 0..3 {
            faults.once(Kind::MissingClip, "a.mp4", "cannot open `a.mp4`".to_owned());
            faults.tell(Kind::Screen, "unplugged".to_owned());
        }
        faults.once(Kind::DamagedClip, "a.mp4", "`a.mp4` is damaged".to_owned());
        assert_eq!(faults.count(), 5);
        assert_eq!(faults.latest().len(), 5);
        let told: Vec<_> = notes.try_iter().collect();
        assert_eq!(told.iter().filter(|note| matches!(note, Note::Fault(_))).count(), 5);
        let news = told.iter().filter(|note| matches!(note, Note::Fault(fault) if !fault.is_repeated)).count();
        assert_eq!(news, 3, "a screen that goes again is no news");
    }
}
