//! Claims about the walk itself: whatever happens to it, it chooses from what its ledger allows.
//!
//! Owns random graphs, and what may happen to a walk on them. How even a walk is, is claimed in `tests/claims.rs`.

use std::sync::Arc;

use proptest::prelude::*;

use super::Walk;
use crate::flock::Flock;
use crate::graph::Exit;
use crate::graph::tests::manifest;
use crate::walk::blocked::BlockedClips;
use crate::walk::carry_over::carry_over;
use crate::walk::ledger::tests::keeps_the_bound;
use crate::walk::memory::{Keys, Next, Place};

/// Transitions among sheep, with their weights.
type Arcs = Vec<(usize, usize, f64)>;

/// What happens to a walk between two of its steps.
#[derive(Clone, Debug)]
enum Event {
    /// The clip of a transition turns out bad; the number counts around.
    BlockedClips(usize),
    /// Every clip gets another chance.
    Opened,
    /// The walk is saved, read back and goes on.
    Restarted,
    /// Another flock takes over.
    Changed(usize, Arcs),
}

fn arcs() -> impl Strategy<Value = (usize, Arcs)> {
    let weight = prop_oneof![8 => 0.001f64..50.0, 1 => Just(f64::MAX), 1 => Just(f64::MIN_POSITIVE)];
    let more = prop::collection::vec((0usize..12, 0usize..12, weight), 0..60);
    (1usize..12, any::<bool>(), more).prop_map(|(sheep, ring, more)| {
        let ring = (0..sheep).filter(|_| ring).map(|at| (at, (at + 1) % sheep, 1.0));
        (sheep, ring.chain(more.into_iter().map(|(a, b, weight)| (a % sheep, b % sheep, weight))).collect())
    })
}

fn event() -> impl Strategy<Value = Event> {
    prop_oneof![
        4 => any::<usize>().prop_map(Event::BlockedClips),
        1 => Just(Event::Opened),
        2 => Just(Event::Restarted),
        2 => arcs().prop_map(|(sheep, arcs)| Event::Changed(sheep, arcs)),
    ]
}

/// A walk, and what is closed to it.
struct Trip {
    flock: Arc<Flock>,
    walk: Walk,
    blocked: BlockedClips,
    seed: u64,
}

impl Trip {
    /// `None` if nothing of the flock can be shown.
    fn start(flock: Flock, seed: u64) -> Option<Self> {
        let flock = Arc::new(flock);
        let walk = Walk::start(Arc::clone(&flock), seed)?;
        Some(Self { flock, walk, blocked: BlockedClips::default(), seed })
    }

    /// Takes a step, which must be one that the ledger allowed. `false` if there is no way.
    fn step(&mut self) -> Result<bool, TestCaseError> {
        let (graph, before, from) = (self.flock.graph(), self.walk.memory().ledger.clone(), self.walk.place());
        let Some(step) = self.walk.step_around(&self.blocked) else {
            prop_assert!(
                graph.exits(from).all(|exit| !self.blocked.is_unblocked(exit)),
                "a way was open from {from:?}"
            );
            return Ok(false);
        };
        let ledger = &self.walk.memory().ledger;
        let counted: Vec<Exit> = graph.exits(from).filter(|&exit| ledger.taken(exit) > before.taken(exit)).collect();
        let [turn] = counted[..] else { panic!("one exit is counted, found {counted:?}") };
        prop_assert!(before.allowed(graph, from).any(|(exit, _)| exit == turn), "{turn:?} was not allowed");
        prop_assert!(self.blocked.is_unblocked(step.exit) && (step.exit == turn || !self.blocked.is_unblocked(turn)));
        prop_assert!(keeps_the_bound(ledger, graph, from), "{from:?} after {step:?}");
        Ok(true)
    }

    fn meet(self, event: Event) -> Option<Self> {
        let (flock, walk) = (Arc::clone(&self.flock), self.walk);
        let place =
            Place { keys: Arc::new(Keys::of(&flock)), memory: Arc::new(walk.memory().clone()), next: Next::Leave };
        let mut blocked = self.blocked;
        match event {
            Event::BlockedClips(number) => {
                if let Some(at) = number.checked_rem(flock.graph().exit_count()) {
                    blocked.block(&flock, &flock.transition(Exit(at as u32)).clip.path);
                }
                Some(Self { walk, blocked, ..self })
            }
            Event::Opened => Some(Self { walk, blocked: BlockedClips::default(), ..self }),
            Event::Restarted => {
                let read = Place::from_bytes(&place.to_bytes()).expect("it was just written");
                assert_eq!(read, place);
                Some(Self { walk: Walk::with(flock, (*read.memory).clone()), blocked: BlockedClips::default(), ..self })
            }
            Event::Changed(sheep, arcs) => {
                let flock = Flock::new(manifest(sheep, &arcs));
                match carry_over(&place, &flock, &Arc::new(Keys::of(&flock))) {
                    Ok(place) => {
                        let flock = Arc::new(flock);
                        let walk = Walk::with(Arc::clone(&flock), (*place.memory).clone());
                        Some(Self { flock, walk, blocked: BlockedClips::default(), seed: self.seed })
                    }
                    Err(_) => Self::start(flock, self.seed),
                }
            }
        }
    }
}

proptest! {
    #[test]
    fn whatever_happens_the_walk_chooses_from_what_is_allowed_and_keeps_the_credit_bound(
        (sheep, arcs) in arcs(),
        seed: u64,
        events in prop::collection::vec((1usize..1000, event()), 1..8),
    ) {
        let mut trip = Trip::start(Flock::new(manifest(sheep, &arcs)), seed);
        for (steps, event) in events {
            let Some(mut walked) = trip.take() else { break };
            let (graph, ledger) = (walked.flock.graph(), &walked.walk.memory().ledger);
            prop_assert!(graph.sheep().all(|sheep| keeps_the_bound(ledger, graph, sheep)));
            for _ in 0..steps {
                if !walked.step()? {
                    break;
                }
            }
            trip = walked.meet(event);
        }
    }
}
