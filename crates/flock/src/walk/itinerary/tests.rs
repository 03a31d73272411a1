//! Claims about the path: it resumes exactly, goes around bad clips, and outlives its flock.
//!
//! Owns small flocks to walk. Never looks at how even a walk is: `tests/claims.rs` does, on large ones.

use std::sync::Arc;

use proptest::prelude::{ProptestConfig, any, prop, prop_assert_eq, proptest};

use super::{ClipKind, Itinerary, SheepVisits};
use crate::flock::Flock;
use crate::graph::tests::manifest;
use crate::manifest::{ClipPath, Manifest, SheepId};
use crate::walk::memory::{NEVER, Place, PlaceError};

/// A ring of `n` sheep with two chords each.
fn ring(n: usize) -> Manifest {
    let arcs: Vec<_> = (0..n).flat_map(|at| [1, 2, 3].map(|by| (at, (at + by) % n, 1.0 + by as f64))).collect();
    manifest(n, &arcs)
}

fn start(manifest: Manifest, seed: u64) -> Itinerary {
    Itinerary::start(Arc::new(Flock::new(manifest)), seed)
}

fn clips(path: &mut Itinerary, count: usize) -> Vec<String> {
    (0..count).map_while(|_| path.next_clip()).map(|clip| clip.path.to_string()).collect()
}

fn clip(path: &str) -> ClipPath {
    ClipPath::new(path).unwrap()
}

fn saved(place: &Place) -> Place {
    Place::from_bytes(&place.to_bytes()).unwrap()
}

/// A flock with repeats and a sheep without a loop, small enough to be resumed at every leg.
fn mixed(n: usize) -> Manifest {
    let mut flock = ring(n);
    flock.sheep[0].repeat = 3;
    flock.sheep[1].clip = None;
    flock
}

#[test]
fn a_visit_is_its_loops_and_then_a_transition() {
    let clips = clips(&mut start(mixed(5), 3), 400);
    for pair in clips.windows(2) {
        if let Some((_, to)) = pair[0].strip_prefix("transitions/").and_then(|arc| arc.split_once('=')) {
            let after = if to == "1" { "transitions/1=".to_owned() } else { format!("loops/{to}") };
            assert!(pair[1].starts_with(&after), "{pair:?}");
        }
    }
    let visits = clips.windows(2).filter(|pair| pair[0] != "loops/0" && pair[1] == "loops/0").count();
    let loops = clips.iter().filter(|clip| *clip == "loops/0").count();
    assert!(
        visits > 10 && loops.div_ceil(3) >= visits && loops <= 3 * (visits + 1),
        "{loops} loops in {visits} visits"
    );
}

#[test]
fn another_seed_is_another_path() {
    assert_ne!(clips(&mut start(ring(9), 1), 60), clips(&mut start(ring(9), 2), 60));
}

#[test]
fn the_walk_of_a_seed_is_pinned() {
    // A change here changes every unit's path after an update: give the place's format a new version.
    let steps: Vec<_> = clips(&mut start(ring(9), 42), 24).into_iter().filter(|clip| clip.contains('=')).collect();
    assert_eq!(steps, PINNED);
}

/// The first steps of seed 42 on a ring of nine.
const PINNED: [&str; 12] = [
    "transitions/6=8",
    "transitions/8=1",
    "transitions/1=4",
    "transitions/4=5",
    "transitions/5=7",
    "transitions/7=0",
    "transitions/0=2",
    "transitions/2=3",
    "transitions/3=6",
    "transitions/6=8",
    "transitions/8=0",
    "transitions/0=1",
];

#[test]
fn a_place_that_an_older_program_saved_is_read_as_it_was_and_written_the_same() {
    // Saved when the bytes were still put together by hand, in a path that had changed flocks.
    let bytes = include_bytes!("place");
    let place = Place::from_bytes(bytes).unwrap();
    assert_eq!(place.to_bytes(), bytes);
    let mut flock = mixed(10);
    flock.transitions.iter_mut().for_each(|transition| transition.weight += 0.5);
    let mut path = Itinerary::resume(Arc::new(Flock::new(flock)), &place).unwrap();
    let next = ["loops/8", "transitions/8=1", "transitions/1=2", "loops/2", "transitions/2=4", "loops/4"];
    assert_eq!((path.steps(), &clips(&mut path, 6)[..]), (44, &next.map(str::to_owned)[..]));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]
    #[test]
    fn resumed_at_any_leg_it_is_the_uninterrupted_path(seed: u64, sheep in 4usize..12, cut in 0usize..300) {
        let flock = Arc::new(Flock::new(mixed(sheep)));
        let mut through = Itinerary::start(Arc::clone(&flock), seed);
        let whole = clips(&mut through.clone(), 400);
        let mut leg = None;
        for _ in 0..=cut {
            leg = through.next_leg();
        }
        let mut resumed = Itinerary::resume(flock, &saved(&leg.unwrap().place)).unwrap();
        prop_assert_eq!(&clips(&mut resumed, 400 - cut)[..], &whole[cut..]);
    }

    #[test]
    fn any_bytes_are_read_or_refused(mut bytes in prop::collection::vec(any::<u8>(), 0..200), whole: bool) {
        if whole {
            let magic = start(ring(5), 1).next_leg().unwrap().place.to_bytes();
            bytes.splice(..0, magic[..48].iter().copied());
        }
        let _ = Place::from_bytes(&bytes);
    }

    #[test]
    fn a_damaged_place_never_breaks_the_player(at in 0usize..4000, bit in 0u8..8) {
        let mut path = start(ring(6), 5);
        clips(&mut path, 90);
        let mut bytes = path.next_leg().unwrap().place.to_bytes();
        let at = at % bytes.len();
        bytes[at] ^= 1 << bit;
        if let Ok(place) = Place::from_bytes(&bytes)
            && let Ok(mut path) = Itinerary::resume(Arc::clone(path.flock()), &place)
        {
            prop_assert_eq!(clips(&mut path, 50).len(), 50);
        }
    }
}

#[test]
fn the_runs_walked_before_a_restart_are_remembered_beyond_the_window() {
    let mut through = start(ring(4), 8);
    clips(&mut through, 2 * (crate::walk::runs::WINDOW + 100));
    let place = saved(&through.next_leg().unwrap().place);
    let mut resumed = Itinerary::resume(Arc::clone(through.flock()), &place).unwrap();
    resumed.next_clip();
    assert_eq!(clips(&mut resumed, 500), clips(&mut through, 500));
}

#[test]
fn a_place_of_more_steps_than_can_be_counted_exactly_is_damaged() {
    let mut path = start(ring(5), 7);
    clips(&mut path, 50);
    let place = path.place().unwrap();
    let after = |step: u64| {
        let mut memory = (*place.memory).clone();
        let last = |seen: &u64| if *seen == NEVER { NEVER } else { step - (memory.step - seen) };
        memory.last = memory.last.iter().map(last).collect();
        memory.step = step;
        Place::from_bytes(&Place { memory: Arc::new(memory), ..place.clone() }.to_bytes())
    };
    let mut old = Itinerary::resume(Arc::new(Flock::new(ring(5))), &after(1 << 53).unwrap()).unwrap();
    assert_eq!(clips(&mut old, 50).len(), 50);
    for step in [(1 << 53) + 1, u64::MAX - 3] {
        assert!(matches!(after(step), Err(PlaceError::Damaged { .. })), "{step}");
    }
}

#[test]
fn a_struck_transition_is_replaced_by_another_from_the_same_sheep() {
    let mut path = start(ring(9), 4);
    let leg = std::iter::from_fn(|| path.next_leg()).find(|leg| matches!(leg.clip.what, ClipKind::Transition { .. }));
    let bad = leg.unwrap().clip;
    let from = |what: &ClipKind| match what {
        ClipKind::Transition { from, .. } => Some(from.clone()),
        ClipKind::Loop { .. } => None,
    };
    path.block(&bad.path);
    let instead = path.next_leg().unwrap().clip;
    assert_eq!(from(&instead.what), from(&bad.what));
    assert!(!clips(&mut path, 3000).contains(&bad.path.to_string()));
}

#[test]
fn a_struck_loop_is_passed_by() {
    let mut path = start(ring(5), 4);
    path.block(&clip("loops/2"));
    let clips = clips(&mut path, 500);
    assert!(!clips.contains(&"loops/2".to_owned()));
    assert!(clips.iter().any(|clip| clip.ends_with("=2")), "the sheep itself is still visited");
}

#[test]
fn strikes_lead_into_no_trap() {
    // 2 can only be left by one transition; without it the walk must not go there.
    let arcs = [(0, 1, 1.0), (1, 0, 1.0), (1, 2, 1.0), (2, 0, 1.0)];
    let mut path = start(manifest(3, &arcs), 1);
    path.block(&clip("transitions/2=0"));
    let clips = clips(&mut path, 300);
    let after_the_start = clips.iter().skip_while(|clip| *clip == "loops/2");
    assert!(clips[0] == "loops/2" || after_the_start.count() == 300);
    assert!(!clips[1..].contains(&"transitions/1=2".to_owned()));
}

#[test]
fn without_an_exit_the_loop_plays_for_ever_and_without_anything_there_is_no_leg() {
    let mut path = start(manifest(2, &[(0, 1, 1.0), (1, 0, 1.0)]), 1);
    path.block(&clip("transitions/0=1"));
    path.block(&clip("transitions/1=0"));
    let own = path.next_leg().unwrap().clip.path;
    assert!(clips(&mut path, 50).iter().all(|clip| clip == own.as_str()));
    path.block(&own);
    assert!(path.next_leg().is_none());
}

#[test]
fn a_forgiven_path_goes_on_where_it_stands_and_repeats_nothing() {
    let flock = mixed(5);
    let whole = clips(&mut start(flock.clone(), 3), 60);
    for cut in 0..40 {
        let mut path = start(flock.clone(), 3);
        let played: Vec<_> = (0..cut).map(|_| path.next_leg().unwrap().clip.path.to_string()).collect();
        // The storage is gone: every clip is tried, and struck.
        while let Some(leg) = path.next_leg() {
            path.block(&leg.clip.path);
        }
        assert!(!path.has_exit());
        path.unblock();
        assert!(path.has_exit());
        assert_eq!([played, clips(&mut path, 20)].concat(), whole[..cut + 20], "after {cut} clips");
    }
}

#[test]
fn a_flock_of_one_loop_plays_it_for_ever() {
    assert_eq!(clips(&mut start(manifest(1, &[]), 9), 3), ["loops/0"; 3]);
}

#[test]
fn a_clip_that_was_missing_for_long_does_not_come_back_in_a_row() {
    let mut path = start(manifest(3, &[(0, 1, 1.0), (0, 2, 1.0), (1, 0, 1.0), (2, 0, 1.0)]), 6);
    path.block(&clip("transitions/0=1"));
    clips(&mut path, 4000);
    let healed = path.next_leg().unwrap().place;
    let mut path = Itinerary::resume(Arc::clone(path.flock()), &healed).unwrap();
    let taken: Vec<_> = clips(&mut path, 80).into_iter().filter(|clip| clip.starts_with("transitions/0=")).collect();
    let back = taken.iter().filter(|clip| *clip == "transitions/0=1").count();
    assert!((7..=13).contains(&back) && taken.len() == 20, "{back} of {}", taken.len());
}

#[test]
fn a_new_flock_is_entered_where_the_old_one_was_left() {
    let mut path = start(ring(8), 3);
    clips(&mut path, 999);
    let (place, before) = (path.next_leg().unwrap().place, path.visits_by_sheep());
    // Two sheep more, and other weights.
    let mut grown = ring(10);
    grown.transitions.iter_mut().for_each(|transition| transition.weight = 1.0);
    let mut carried = Itinerary::resume(Arc::new(Flock::new(grown)), &saved(&place)).unwrap();
    assert_eq!(carried.steps(), place.step());
    let visits = |visits_by_sheep: &[SheepVisits], id: &str| {
        visits_by_sheep.iter().find(|s| s.id.as_str() == id).unwrap().visits
    };
    let old = |id: &str| visits(&before, id) as i64;
    assert!((visits(&carried.visits_by_sheep(), "s4") as i64 - old("s4")).abs() <= 1);
    assert_eq!(visits(&carried.visits_by_sheep(), "s9"), 0);
    // From here on visits are due by the new shares: the new sheep do not crowd in to catch up on what they missed.
    clips(&mut carried, 400);
    let gained = visits(&carried.visits_by_sheep(), "s9");
    assert!((14..=26).contains(&gained), "{gained} visits of 200");
}

#[test]
fn a_place_whose_sheep_is_gone_starts_at_one_that_is_there() {
    let mut path = start(ring(8), 3);
    let mut small = ring(8);
    let leg = path.next_leg().unwrap();
    let ClipKind::Loop { sheep } = leg.clip.what else { panic!("a path starts with a loop") };
    small.sheep.retain(|other| other.id != sheep);
    let mut carried = Itinerary::resume(Arc::new(Flock::new(small)), &leg.place).unwrap();
    assert_eq!(clips(&mut carried, 100).len(), 100);
}

#[test]
fn a_place_of_an_unrelated_flock_is_refused() {
    let place = start(ring(4), 3).next_leg().unwrap().place;
    let mut other = ring(4);
    for id in other.sheep.iter_mut().map(|sheep| &mut sheep.id) {
        *id = SheepId::new(&format!("other.{id}")).unwrap();
    }
    other.transitions.clear();
    let refused = Itinerary::resume(Arc::new(Flock::new(other)), &place).unwrap_err();
    assert_eq!(refused, PlaceError::Foreign { saved: 4, found: 1 });
}
