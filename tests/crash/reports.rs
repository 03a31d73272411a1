//! The steps of a scenario, and how many were reported.
//!
//! Owns the scripts. A step is reported when its program has ended well. A reported step must hold after every later
//! cut; a step that was not completed may hold or not.
//!
//! Start at [`Script`] and [`Progress`].

/// A step of a scenario.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Step {
    /// The next edition of the flock was installed.
    Edition,
    /// A scrub found the damaged clip, and it was fetched again.
    Mended,
    /// The owner's edited file was applied.
    Owner,
    /// A key was revoked.
    Revoked,
    /// A clip of the installed flock was damaged.
    Rotten,
}

/// The steps of a scenario.
pub(crate) type Script = &'static [Step];

/// Updates only.
pub(crate) const UPDATES: Script = &[Step::Edition, Step::Edition];
/// Updates and maintenance.
pub(crate) const UPKEEP: Script =
    &[Step::Owner, Step::Rotten, Step::Mended, Step::Revoked, Step::Edition, Step::Owner, Step::Edition];
/// Edits of the owner's file only.
pub(crate) const EDITS: Script = &[Step::Owner, Step::Owner];

/// How far a scenario has come.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Progress {
    script: Script,
    told: usize,
}

impl Progress {
    /// After `told` reports.
    pub(crate) fn far(script: Script, told: usize) -> Self {
        Self { script, told }
    }

    /// How many steps of this kind were reported.
    pub(crate) fn many(self, step: Step) -> usize {
        self.script[..self.told].iter().filter(|told| **told == step).count()
    }

    /// Whether such a step may be in progress.
    pub(crate) fn is_at(self, step: Step) -> bool {
        self.script.get(self.told) == Some(&step)
    }

    /// Whether a clip of the flock may be damaged.
    pub(crate) fn may_rot(self) -> bool {
        self.is_at(Step::Rotten) || self.many(Step::Rotten) > self.many(Step::Mended)
    }
}
