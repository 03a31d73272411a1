//! The balance on thousands of flocks of every shape: it ends, in numbers, and does what it says.
//!
//! Owns the claims that hold for every flock without faults. The flocks are made in `graphs.rs`, judged by `flow.rs`.

mod flow;
mod graphs;

use std::env;
use std::num::NonZeroUsize;
use std::panic::{self, AssertUnwindSafe};
use std::sync::LazyLock;
use std::thread;

use flock::{
    Balance, Clip, ClipPath, Edit, Flock, FlockShares, Manifest, Measure, SheepIx, Suggestions, Terms, Transition,
};
use graphs::Chance;

/// How many flocks are tried: `FLOCKS`, or so many as before each commit.
static FLOCKS: LazyLock<u64> = LazyLock::new(|| env::var("FLOCKS").map_or(2_000, |number| number.parse().unwrap()));
const FAIREST: Terms = Terms { fairness: f64::INFINITY, floor: 0.0, afresh: false, by: Measure::Visits };
/// How near a want that can be reached is reached, as a part of it.
const REACHED: f64 = 1e-6;

/// Tries `claim` on every flock, on all cores; each that breaks it is told on stderr.
fn every_flock(claim: impl Fn(u64, &Flock) + Sync) {
    let cores = thread::available_parallelism().map_or(1, NonZeroUsize::get) as u64;
    let holds = |at: &u64| panic::catch_unwind(AssertUnwindSafe(|| claim(*at, &graphs::flock(*at)))).is_ok();
    let holds = &holds;
    let broken: Vec<u64> = thread::scope(|scope| {
        let part = |core: u64| (core..*FLOCKS).step_by(cores as usize).filter(|at| !holds(at)).collect::<Vec<_>>();
        let parts: Vec<_> = (0..cores).map(|core| scope.spawn(move || part(core))).collect();
        parts.into_iter().flat_map(|part| part.join().unwrap()).collect()
    });
    assert!(broken.is_empty(), "{} flocks break it: {:?}", broken.len(), &broken[..broken.len().min(20)]);
}

/// Terms of every kind.
fn terms(number: u64) -> Terms {
    let mut chance = Chance::new(number ^ 0x5eed);
    let fairness = chance.of(&[1e-3, 0.1, 1.0, 3.0, 3.0, 3.0, 30.0, 1e3, 1e6, f64::INFINITY]);
    let floor = chance.of(&[0.0, 1e-3, 1.0, 12.0, 12.0, 12.0, 500.0, 1e5, 1e9]);
    Terms { fairness, floor, afresh: chance.below(8) == 0, by: chance.of(&[Measure::Visits, Measure::Time]) }
}

/// What one step makes of the visits under the weights that were found.
fn step(flock: &Flock, balance: &Balance) -> Vec<f64> {
    let graph = flock.graph();
    let mut after = vec![0.0; graph.len()];
    let mut weights = balance.weights.iter().map(|weight| weight.weight);
    for from in graph.sheep() {
        let own: Vec<f64> = weights.by_ref().take(graph.exits(from).len()).collect();
        let total: f64 = own.iter().sum();
        for (exit, weight) in graph.exits(from).zip(own) {
            after[graph.target(exit).index()] += balance.sheep[from.index()].visits * weight / total;
        }
    }
    after
}

#[test]
fn a_balance_ends_in_weights_and_in_the_visits_that_they_give() {
    every_flock(|number, flock| {
        for terms in [terms(number), FAIREST] {
            let balance = Balance::of(flock, terms).unwrap();
            let told = || format!("flock {number}, {terms:?}");
            assert!(
                balance.weights.iter().all(|weight| weight.weight.is_normal() && weight.weight > 0.0),
                "{}",
                told()
            );
            assert!(balance.sheep.iter().all(|sheep| (0.0..=1.0).contains(&sheep.visits)), "{}", told());
            let worst = balance.worst_ratio.unwrap_or_else(|| panic!("a sheep is never shown: {}", told()));
            assert!(worst >= 1.0 && worst.is_finite() && balance.least_plays.is_finite(), "{worst}: {}", told());
            assert!((0.0..1.0).contains(&balance.deficiency), "{}: {}", balance.deficiency, told());
            assert_eq!(balance.reachable, balance.bottleneck.is_none(), "{}", told());
            let moved: f64 = step(flock, &balance)
                .iter()
                .zip(&balance.sheep)
                .map(|(after, sheep)| (after - sheep.visits).abs())
                .sum();
            assert!(moved < 1e-12, "visits move by {moved}: {}", told());
        }
    });
}

#[test]
fn wants_that_some_weights_reach_are_reached_and_all_others_are_proved_not_to_be() {
    every_flock(|number, flock| {
        let balance = Balance::of(flock, FAIREST).unwrap();
        let wants: Vec<f64> = balance.sheep.iter().map(|sheep| sheep.want).collect();
        if balance.reachable {
            let carried = flow::carried(flock, &wants);
            assert!(carried > 1.0 - 1e-8, "flock {number}: only {carried} can be carried");
            let off = balance.sheep.iter().map(|sheep| (sheep.visits / sheep.want - 1.0).abs()).fold(0.0, f64::max);
            assert!(off <= REACHED, "flock {number}: a sheep is {off} off its want");
            return;
        }
        is_proved(number, flock, &balance, &wants);
    });
}

/// No weights reach `wants`: what some sheep want is more than what all want that they lead to, by just the deficiency.
fn is_proved(number: u64, flock: &Flock, balance: &Balance, wants: &[f64]) {
    let carried = flow::carried(flock, wants);
    assert!((1.0 - carried - balance.deficiency).abs() < 1e-9, "flock {number}: {carried} {}", balance.deficiency);
    let proof = balance.bottleneck.as_ref().unwrap();
    let ix = |ids: &[flock::SheepId]| ids.iter().map(|id| flock.graph().find(id).unwrap()).collect::<Vec<_>>();
    let (stuck, followers) = (ix(&proof.sheep), ix(&proof.followers));
    assert_eq!(flow::followers(flock, &stuck), followers, "flock {number}");
    let want = |set: &[SheepIx]| set.iter().map(|sheep| wants[sheep.index()]).sum::<f64>();
    let missing = want(&stuck) - want(&followers);
    assert!(missing > 0.0 && (missing - balance.deficiency).abs() < 1e-9, "flock {number}: {missing}");
}

/// The flock number `number`, which wants as much time of each sheep as its wants are visits: half of all can be balanced
/// by time for certain.
fn timed(flock: &Flock) -> Flock {
    let mut manifest = flock.manifest().clone();
    for sheep in &mut manifest.sheep {
        let frames = sheep.clip.as_ref().map_or(1, |clip| clip.frames.0);
        sheep.want = (sheep.want * f64::from(frames * sheep.repeat)).min(1e300);
    }
    Flock::new(manifest)
}

#[test]
fn times_that_some_weights_reach_are_reached_and_all_others_are_proved_not_to_be() {
    every_flock(|number, flock| {
        // One in four: the search is the same as by visits.
        if number % 4 > 0 || flock.manifest().sheep.iter().all(|sheep| sheep.clip.is_none()) {
            return;
        }
        let flock = &timed(flock);
        let balance = Balance::of(flock, Terms { by: Measure::Time, ..FAIREST }).unwrap();
        let wants: Vec<f64> = balance.sheep.iter().map(|sheep| sheep.wanted_visits).collect();
        assert!((wants.iter().sum::<f64>() - 1.0).abs() < 1e-9, "flock {number}");
        if balance.reachable {
            let carried = flow::carried(flock, &wants);
            assert!(carried > 1.0 - 1e-8, "flock {number}: only {carried} can be carried");
            let written = Flock::new(rewritten(flock.manifest(), &balance));
            let told = FlockShares::of(&written).unwrap();
            let off = |(told, sheep): (&flock::SheepShare, &flock::SheepBalance)| {
                if sheep.time_want > 0.0 { (told.time / sheep.time_want - 1.0).abs() } else { told.time }
            };
            let off = told.sheep.iter().zip(&balance.sheep).map(off).fold(0.0, f64::max);
            assert!(off <= REACHED, "flock {number}: a sheep is {off} off the time that is wanted of it");
            return;
        }
        is_proved(number, flock, &balance, &wants);
    });
}

#[test]
fn what_is_balanced_and_written_is_balanced() {
    every_flock(|number, flock| {
        let afresh = terms(number);
        for terms in [Terms { afresh: true, ..afresh }, FAIREST] {
            let first = Balance::of(flock, terms).unwrap();
            if !terms.afresh && !first.reachable {
                continue;
            }
            let written = Flock::new(rewritten(flock.manifest(), &first));
            let second = Balance::of(&written, terms).unwrap();
            assert_eq!(first.weights, second.weights, "flock {number}, {terms:?}");
        }
    });
}

#[test]
fn suggestions_keep_their_word() {
    every_flock(|number, flock| {
        // One in ten: each has several balances to find.
        if number % 10 > 0 {
            return;
        }
        let terms = terms(number);
        let suggestions = Suggestions::of(flock, terms, 2).unwrap();
        let mut added = flock.manifest().clone();
        for new in &suggestions.add {
            assert_ne!(new.from, new.to, "flock {number}");
            let path = ClipPath::new("new").unwrap();
            let clip = Clip { path, frames: new.frames, hash: None };
            added.transitions.push(Transition { from: new.from.clone(), to: new.to.clone(), clip, weight: new.weight });
            let after = Flock::new(added.clone());
            assert!(after.faults().is_empty(), "flock {number}: the transition is new");
            let balance = Balance::of(&after, terms).unwrap();
            let told = (new.worst_ratio, new.worst_time_ratio);
            assert_eq!((balance.worst_ratio, balance.worst_time_ratio), told, "flock {number}");
        }
        let mut removed = flock.manifest().clone();
        for old in &suggestions.remove {
            removed.transitions.retain(|transition| (&transition.from, &transition.to) != (&old.from, &old.to));
            let after = Flock::new(removed.clone());
            assert!(after.faults().is_empty(), "flock {number}: all sheep are still played");
            assert_eq!(Balance::of(&after, terms).unwrap().worst_ratio, old.worst_ratio, "flock {number}");
        }
    });
}

/// `manifest` with the weights of `balance`.
fn rewritten(manifest: &Manifest, balance: &Balance) -> Manifest {
    let mut edit = Edit::blank(&manifest.name, manifest.size, manifest.fps);
    manifest.sheep.iter().for_each(|sheep| edit.add_sheep(sheep.clone()).unwrap());
    manifest.transitions.iter().for_each(|transition| edit.add_transition(transition.clone()).unwrap());
    balance.weights.iter().for_each(|weight| edit.set_weight(&weight.from, &weight.to, weight.weight).unwrap());
    Edit::parse(edit.text(), "flock.toml".as_ref()).unwrap().manifest().clone()
}
