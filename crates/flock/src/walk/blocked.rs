//! The clips that are left out for the rest of a run.
//!
//! Owns the blocked transitions and loops, and the sheep that could not be left without them. It is not saved: after a
//! restart every clip is tried again.

use crate::flock::Flock;
use crate::graph::{Exit, SheepIx};
use crate::manifest::ClipPath;

/// Blocked clips, by the ordinals of a flock. Empty until the first one.
#[derive(Clone, Debug, Default)]
pub(crate) struct BlockedClips {
    loops: Vec<bool>,
    exits: Vec<bool>,
}

impl BlockedClips {
    /// Blocks every loop and transition that uses `clip`, and the transitions into sheep without an exit.
    pub(crate) fn block(&mut self, flock: &Flock, clip: &ClipPath) {
        let graph = flock.graph();
        self.loops.resize(graph.len(), false);
        self.exits.resize(graph.exit_count(), false);
        for sheep in graph.sheep() {
            self.loops[sheep.index()] |= flock.loop_of(sheep).is_some_and(|own| own.path == *clip);
            for exit in graph.exits(sheep) {
                self.exits[exit.index()] |= flock.transition(exit).clip.path == *clip;
            }
        }
        self.block_dead_ends(flock);
    }

    /// Whether `exit` may be taken.
    pub(crate) fn is_unblocked(&self, exit: Exit) -> bool {
        self.exits.get(exit.index()).is_none_or(|blocked| !blocked)
    }

    /// Whether the loop of `sheep`, if it has one, may be shown.
    pub(crate) fn shows_loop(&self, sheep: SheepIx) -> bool {
        self.loops.get(sheep.index()).is_none_or(|blocked| !blocked)
    }

    /// Blocks the transitions into dead ends, as long as there are sheep that are none.
    fn block_dead_ends(&mut self, flock: &Flock) {
        let graph = flock.graph();
        let mut alive = vec![true; graph.len()];
        loop {
            let has_exit = |exit: Exit| self.is_unblocked(exit) && alive[graph.target(exit).index()];
            let ended: Vec<_> =
                graph.sheep().filter(|&sheep| alive[sheep.index()] && !graph.exits(sheep).any(has_exit)).collect();
            if ended.is_empty() {
                break;
            }
            for sheep in ended {
                alive[sheep.index()] = false;
            }
        }
        for sheep in graph.sheep().filter(|sheep| alive[sheep.index()]) {
            for exit in graph.exits(sheep) {
                self.exits[exit.index()] |= !alive[graph.target(exit).index()];
            }
        }
    }
}
