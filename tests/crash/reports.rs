//! What a life reports, and what must hold from then on.
//!
//! Owns the scripts of the lives: which steps there are, and in which order. A step is reported when the program that does it
//! has ended well. What was reported must be there after every cut that follows; what is under way may be there or not.
//!
//! Start at [`Script`] and [`Progress`].

/// A step of a life.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Step {
    /// The next edition of the flock was taken in.
    Edition,
    /// What rotted was found by a look at every byte, and was fetched again.
    Mended,
    /// The owner's edited file was taken in.
    Owner,
    /// A key was called back.
    Revoked,
    /// A clip of the flock that plays has rotted.
    Rotten,
}

/// The steps of a life.
pub(crate) type Script = &'static [Step];

/// A unit that is brought flocks.
pub(crate) const UPDATES: Script = &[Step::Edition, Step::Edition];
/// One that is looked after, too.
pub(crate) const UPKEEP: Script =
    &[Step::Owner, Step::Rotten, Step::Mended, Step::Revoked, Step::Edition, Step::Owner, Step::Edition];
/// One whose owner edits the file, and nothing else.
pub(crate) const EDITS: Script = &[Step::Owner, Step::Owner];

/// How far a life is.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Progress {
    script: Script,
    told: usize,
}

impl Progress {
    /// After so many reports.
    pub(crate) fn far(script: Script, told: usize) -> Self {
        Self { script, told }
    }

    /// How many such steps were reported.
    pub(crate) fn many(self, step: Step) -> usize {
        self.script[..self.told].iter().filter(|told| **told == step).count()
    }

    /// Whether such a step may be under way.
    pub(crate) fn is_at(self, step: Step) -> bool {
        self.script.get(self.told) == Some(&step)
    }

    /// Whether a clip of the flock may be rotten.
    pub(crate) fn may_rot(self) -> bool {
        self.is_at(Step::Rotten) || self.many(Step::Rotten) > self.many(Step::Mended)
    }
}
