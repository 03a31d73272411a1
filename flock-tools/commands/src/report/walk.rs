//! A day of the walk, and the return times of sheep.
//!
//! Owns the timing of visits. The walk is the player's own.
//!
//! Start at [`WalkSample::of`].

use std::sync::Arc;

use flock::{Flock, SheepIx, Simulation, Step, Walk};

/// Seconds in a day and in a minute.
const DAY_S: f64 = 86_400.0;
const MINUTE_S: f64 = 60.0;
/// The most visits that a page shows: the eye tells no more colours apart.
const MOST_SHOWN: usize = 20_000;
/// Steps from which return times are measured; a week of 50-second steps has 12,096.
const STEPS: usize = 12_000;

/// The beginning of a walk.
#[derive(Debug, PartialEq)]
pub(super) struct WalkSample {
    /// The sheep visited in the first 24 hours, by their ordinals in the whole flock.
    pub(super) day: Vec<usize>,
    /// Whether these are the visits of 24 hours; else they are of less, because a page shows no more.
    pub(super) is_whole_day: bool,
    /// The return times of every sheep of the whole flock.
    pub(super) returns: Vec<Option<Spread>>,
    /// Its length in minutes.
    pub(super) minutes: f64,
    /// The length of the longest run of transitions that came twice, in steps.
    pub(super) longest_repeat: usize,
}

/// The spread of return times, in minutes.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub(super) struct Spread {
    /// The soonest.
    pub(super) soonest: f64,
    /// The one in the middle.
    pub(super) median: f64,
    /// The longest.
    pub(super) longest: f64,
}

impl WalkSample {
    /// The walk of `flock` that begins with `seed`. `None` if there is no cycle to walk.
    pub(super) fn of(flock: &Arc<Flock>, seed: u64) -> Option<Self> {
        let mut walk = Walk::start(Arc::clone(flock), seed).filter(|_| flock.is_walkable())?;
        let (start, mut exits) = (walk.place(), Vec::new());
        let graph = flock.graph();
        let whole: Vec<usize> =
            graph.sheep().filter_map(|sheep| flock.whole().find(graph.id(sheep))).map(SheepIx::index).collect();
        let (mut elapsed_s, mut day, mut is_whole_day) = (0.0, Vec::new(), false);
        let mut last = vec![None; graph.len()];
        let mut returns: Vec<Vec<f64>> = vec![Vec::new(); flock.whole().len()];
        for _ in 0..STEPS.max(MOST_SHOWN) {
            let here = walk.place();
            let showing = elapsed_s < DAY_S && day.len() < MOST_SHOWN;
            is_whole_day |= elapsed_s >= DAY_S && day.len() < MOST_SHOWN;
            if !showing && walk.steps() >= STEPS as u64 {
                break;
            }
            if showing {
                day.push(whole[here.index()]);
            }
            if let Some(before) = last[here.index()].replace(elapsed_s) {
                returns[whole[here.index()]].push((elapsed_s - before) / MINUTE_S);
            }
            let Some(Step { exit, from, .. }) = walk.step() else { break };
            exits.push(exit);
            elapsed_s += flock.visit_seconds(from) + flock.seconds(&flock.transition(exit).clip);
        }
        Some(Self {
            day,
            is_whole_day,
            returns: returns.into_iter().map(Spread::of).collect(),
            minutes: elapsed_s / MINUTE_S,
            longest_repeat: Simulation::of(flock, start, &exits).longest_repeat,
        })
    }
}

impl Spread {
    fn of(mut minutes: Vec<f64>) -> Option<Self> {
        minutes.sort_by(f64::total_cmp);
        let (soonest, longest) = (*minutes.first()?, *minutes.last()?);
        Some(Self { soonest, median: minutes[minutes.len() / 2], longest })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use flock::{ClipKind, Itinerary, Manifest};
    use std::fmt::Write as _;
    use std::path::Path;

    /// Three sheep in a triangle that leads both ways; a fourth, to which no sheep leads, comes first by its id.
    fn flock() -> Arc<Flock> {
        let mut text = "format = 1\nname = \"x\"\nsize = [64, 64]\nfps = [30, 1]\n[[sheep]]\nid = \"a\"\n".to_owned();
        for (at, id) in ["b", "c", "d"].iter().enumerate() {
            writeln!(text, "[[sheep]]\nid = \"{id}\"\nframes = {}\nclip = \"{id}.mp4\"", 300 * (at + 1)).unwrap();
        }
        for (from, to) in ["bc", "bd", "cb", "cd", "db", "dc", "ab"].iter().map(|pair| pair.split_at(1)) {
            let clip = format!("frames = 900\nclip = \"{from}{to}.mp4\"");
            writeln!(text, "[[transition]]\nfrom = \"{from}\"\nto = \"{to}\"\n{clip}").unwrap();
        }
        Arc::new(Flock::new(Manifest::parse(&text, Path::new("flock.toml")).unwrap()))
    }

    #[test]
    fn the_day_is_the_path_that_the_player_takes() {
        let flock = flock();
        let walked = WalkSample::of(&flock, 5).unwrap();
        let mut path = Itinerary::start(Arc::clone(&flock), 5);
        let mut loops = std::iter::from_fn(|| path.next_clip()).filter_map(|clip| match clip.what {
            ClipKind::Loop { sheep } => Some(sheep),
            ClipKind::Transition { .. } => None,
        });
        for &shown in &walked.day {
            let id = flock.whole().sheep().nth(shown).map(|sheep| flock.whole().id(sheep).clone());
            assert_eq!(loops.next(), id);
        }
    }

    #[test]
    fn a_walk_without_a_choice_repeats_itself_to_its_end_and_another_does_not() {
        let walked = WalkSample::of(&flock(), 1).unwrap();
        assert!(walked.longest_repeat < 100, "{}", walked.longest_repeat);
        let pair = "format = 1\nname = \"x\"\nsize = [64, 64]\nfps = [30, 1]\n[[sheep]]\nid = \"a\"\n[[transition]]\n\
                    from = \"a\"\nto = \"a\"\nframes = 1800\nclip = \"aa.mp4\"\n";
        let one = Arc::new(Flock::new(Manifest::parse(pair, Path::new("flock.toml")).unwrap()));
        let walked = WalkSample::of(&one, 1).unwrap();
        assert_eq!((walked.longest_repeat, walked.minutes), (STEPS - 1, STEPS as f64));
    }

    #[test]
    fn a_day_has_as_many_visits_as_its_clips_leave_room_for() {
        // A step takes 30 s for the transition and 10, 20 or 30 s for the loop: 50 s in the mean.
        let walked = WalkSample::of(&flock(), 1).unwrap();
        assert!((1726..=1731).contains(&walked.day.len()) && walked.is_whole_day, "{}", walked.day.len());
        assert_eq!(walked.returns[0], None, "nobody leads to the first");
        let spread = walked.returns[1].unwrap();
        assert!(spread.soonest >= 80.0 / 60.0 && spread.soonest <= spread.median && spread.median < spread.longest);
    }
}
