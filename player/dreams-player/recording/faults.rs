//! What went wrong while playing, each cause logged once.
//!
//! Owns the list of faults. A fault never stops the picture; what stops it is `fatal::Fatal`. Whoever is given a fault
//! must not wait for a disk: any thread may meet one.

use player::hold;
use std::collections::BTreeSet;
use std::sync::{Arc, Mutex};

/// What kind of thing went wrong, spelled as `dreams check` spells it where that knows it too.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Kind {
    /// No clip of the flock can be played.
    Barren,
    /// A clip does not decode cleanly, or has fewer frames than it should.
    DamagedClip,
    /// A clip cannot be opened.
    MissingClip,
    /// The walk's place cannot be saved.
    Place,
    /// The screen went away, or repaired itself.
    Screen,
    /// Frames are late all the time.
    TooSlow,
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
            Self::TooSlow => "too-slow",
            Self::WrongClip => "wrong-clip",
        }
    }
}

/// One fault.
#[derive(Clone, Debug)]
pub(crate) struct Fault {
    pub(crate) kind: Kind,
    pub(crate) message: String,
    /// The same message came before: another occurrence, nothing new.
    pub(crate) is_repeated: bool,
}

/// The faults of a run; clones share the list.
#[derive(Clone)]
pub(crate) struct Faults {
    /// Writes a fault down.
    tell: Arc<dyn Fn(Fault) + Send + Sync>,
    told: Arc<Mutex<FaultList>>,
}

#[derive(Debug, Default)]
struct FaultList {
    causes: BTreeSet<(Kind, String)>,
    words: BTreeSet<(Kind, String)>,
    count: u64,
    latest: Vec<Fault>,
}

/// How many faults the status page shows.
const LATEST: usize = 20;

impl Faults {
    /// No faults so far; each is given to `tell`.
    pub(crate) fn new(tell: impl Fn(Fault) + Send + Sync + 'static) -> Self {
        Self { tell: Arc::new(tell), told: Arc::default() }
    }

    /// Adds a fault of `subject`, unless it has one of this kind already.
    pub(crate) fn once(&self, kind: Kind, subject: &str, message: String) {
        let is_new = hold(&self.told).causes.insert((kind, subject.to_owned()));
        if is_new {
            self.tell(kind, message);
        }
    }

    /// Another flock is played: faults of the clips of the one before may be added again.
    pub(crate) fn renew(&self) {
        hold(&self.told).causes.clear();
    }

    /// Adds a fault, as often as it occurs.
    pub(crate) fn tell(&self, kind: Kind, message: String) {
        let mut told = hold(&self.told);
        told.count += 1;
        let is_repeated = !told.words.insert((kind, message.clone()));
        let fault = Fault { kind, message, is_repeated };
        if told.latest.len() == LATEST {
            told.latest.remove(0);
        }
        told.latest.push(fault.clone());
        drop(told);
        (self.tell)(fault);
    }

    /// How many faults there were.
    pub(crate) fn count(&self) -> u64 {
        hold(&self.told).count
    }

    /// The latest faults, oldest first.
    pub(crate) fn latest(&self) -> Vec<Fault> {
        hold(&self.told).latest.clone()
    }
}

#[cfg(test)]
mod tests {
    use super::{Faults, Kind};
    use std::sync::mpsc::channel;

    #[test]
    fn a_cause_is_told_once_and_an_occurrence_each_time() {
        let (tell, told) = channel();
        let faults = Faults::new(move |fault| tell.send(fault).unwrap());
        for _ in 0..3 {
            faults.once(Kind::MissingClip, "a.mp4", "cannot open `a.mp4`".to_owned());
            faults.tell(Kind::Screen, "unplugged".to_owned());
        }
        faults.once(Kind::DamagedClip, "a.mp4", "`a.mp4` is damaged".to_owned());
        assert_eq!(faults.count(), 5);
        assert_eq!(faults.latest().len(), 5);
        let told: Vec<_> = told.try_iter().collect();
        assert_eq!(told.len(), 5);
        let news = told.iter().filter(|fault| !fault.is_repeated).count();
        assert_eq!(news, 3, "a screen that goes again is no news");
    }
}
