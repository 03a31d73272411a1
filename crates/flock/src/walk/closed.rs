//! What may not be shown for the rest of a run.
//!
//! Owns the strikes: bad transitions, bad loops, and the sheep from which there is no way on around them. Never
//! remembered: after a restart every clip has another chance.

use crate::flock::Flock;
use crate::graph::{Exit, SheepIx};
use crate::manifest::ClipPath;

/// Struck clips, by the ordinals of a flock. Empty until the first strike.
#[derive(Clone, Debug, Default)]
pub(crate) struct Closed {
    loops: Vec<bool>,
    exits: Vec<bool>,
}

impl Closed {
    /// Strikes every loop and transition that `clip` serves, and the transitions into sheep without a way on.
    pub(crate) fn strike(&mut self, flock: &Flock, clip: &ClipPath) {
        let graph = flock.graph();
        self.loops.resize(graph.len(), false);
        self.exits.resize(graph.exit_count(), false);
        for sheep in graph.sheep() {
            self.loops[sheep.index()] |= flock.loop_of(sheep).is_some_and(|own| own.path == *clip);
            for exit in graph.exits(sheep) {
                self.exits[exit.index()] |= flock.transition(exit).clip.path == *clip;
            }
        }
        self.close_traps(flock);
    }

    /// Whether `exit` may be taken.
    pub(crate) fn is_open(&self, exit: Exit) -> bool {
        self.exits.get(exit.index()).is_none_or(|struck| !struck)
    }

    /// Whether the loop of `sheep`, if it has one, may be shown.
    pub(crate) fn shows_loop(&self, sheep: SheepIx) -> bool {
        self.loops.get(sheep.index()).is_none_or(|struck| !struck)
    }

    /// Closes the ways into sheep that cannot be left for ever, as long as there are sheep that can.
    fn close_traps(&mut self, flock: &Flock) {
        let graph = flock.graph();
        let mut alive = vec![true; graph.len()];
        loop {
            let leads_on = |exit: Exit| self.is_open(exit) && alive[graph.target(exit).index()];
            let ended: Vec<_> =
                graph.sheep().filter(|&sheep| alive[sheep.index()] && !graph.exits(sheep).any(leads_on)).collect();
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
