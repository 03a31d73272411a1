//! The place of a unit in its walk, as seen on the screen.
//!
//! Owns the place by the looks, and how far from it the walk may continue after the player or the power was gone: one
//! clip. `dreams walk` prints the walk.
//!
//! Start at [`Path::told`], [`Path::saw`] and [`Path::came_back_with`].

use crate::machine::light_flock;
use crate::machine::picture::Look;
use crate::machine::reference_frames::Place;
use claims::programs::{self, succeed};
use serde_json::Value;
use std::process::Command;

/// More steps of the walk than any claim takes.
const STEPS: &str = "2000";
/// The first frames of clips that begin at the same sheep are equal, and do not tell the clips apart.
const ALIKE: usize = 6;
/// The most clips that a walk advances between two looks.
const UNSEEN: usize = 12;

/// The clips of a flock in the order of its walk.
#[derive(Clone, Debug)]
struct Walk {
    flock: String,
    clips: Vec<String>,
}

/// The place of a unit in its walk.
#[derive(Clone, Debug)]
pub(crate) struct Path {
    /// Of the flock that plays, and of one that may replace it.
    walks: Vec<Walk>,
    /// Which of them plays.
    walk: usize,
    /// Which of its clips is shown.
    at: usize,
    /// Which frame of that.
    frame: usize,
}

impl Walk {
    fn of(flock: &str, folder: &std::path::Path, seed: u64) -> Self {
        let mut walk = Command::new(programs::dreams());
        walk.arg("walk").arg(folder).args(["--seed", &seed.to_string(), "--steps", STEPS]);
        let clips = String::from_utf8(succeed(&mut walk)).unwrap().lines().map(str::to_owned).collect();
        Self { flock: flock.to_owned(), clips }
    }

    fn find(&self, clip: &str, mut places: impl Iterator<Item = usize>) -> Option<usize> {
        places.find(|at| self.clips.get(*at).is_some_and(|found| found == clip))
    }
}

impl Path {
    /// The place by the unit's `status`, in the built-in flock.
    pub(crate) fn told(status: &str) -> Self {
        let status = &status[status.find('{').expect("the player can be asked")..];
        let status: Value = serde_json::from_str(status).unwrap();
        let number = |of: &str| status["path"][of].as_u64().unwrap_or_else(|| panic!("a path in {status}"));
        let (seed, step) = (number("seed"), number("step") as usize);
        let name = status["flock"].as_str().unwrap();
        let walk = Walk::of(name, &light_flock(), seed);
        let mut steps = walk.clips.iter().enumerate().filter(|(_, clip)| clip.starts_with("transitions/"));
        let at = step.checked_sub(1).and_then(|before| steps.nth(before)).map_or(0, |(at, _)| at);
        Self { walks: vec![walk], walk: 0, at, frame: 0 }
    }

    /// Allows a change to the flock in `folder`, whose walk is the same with every seed.
    pub(crate) fn may_go_to(&mut self, flock: &str, folder: &std::path::Path) {
        self.walks.push(Walk::of(flock, folder, 0));
    }

    /// The clip that is shown.
    pub(crate) fn clip(&self) -> &str {
        self.walks[self.walk].clips.get(self.at).map_or("?", |clip| clip)
    }

    /// Advances by a look at a screen that always showed the picture.
    pub(crate) fn saw(&mut self, look: &Look) {
        let Some(place) = telling(look) else { return };
        if !self.has_gone(place) {
            let same = usize::from(*place.clip == *self.clip() && place.frame < self.frame);
            let ahead = self.walks[self.walk].find(&place.clip, self.at + same..self.at + UNSEEN);
            self.at = ahead.unwrap_or_else(|| panic!("{place:?} is not ahead of {self}"));
        }
        self.frame = place.frame;
    }

    /// Advances by the looks at a picture that has come back; the first one that tells a place must be near the last
    /// place. Returns whether there is one.
    pub(crate) fn came_back_with(&mut self, looks: &[Look]) -> bool {
        let mut telling = looks.iter().enumerate().filter_map(|(at, look)| Some((at, telling(look)?)));
        let Some((first, place)) = telling.next() else { return false };
        if !self.has_gone(place) {
            let walk = &self.walks[self.walk];
            // A clip that is shown twice: the look may have been taken in the first or the second round.
            let rounds = usize::from(walk.clips[self.at] == walk.clips[self.at + 1]);
            let near = [self.at, self.at + 1, self.at.saturating_sub(1), self.at + 1 + rounds];
            let found = walk.find(&place.clip, near.into_iter());
            self.at = found.unwrap_or_else(|| panic!("the path was at {self}, and goes on with {place:?}"));
        }
        self.frame = place.frame;
        looks[first + 1..].iter().for_each(|look| self.saw(look));
        true
    }

    /// Whether the unit has changed to another flock, at any place in it. The place in the flock before is then
    /// forgotten.
    fn has_gone(&mut self, place: &Place) -> bool {
        let before = self.walk;
        let walk = self.walks.iter().position(|walk| walk.flock == *place.flock);
        self.walk = walk.unwrap_or_else(|| panic!("{place:?} hangs where {self} was"));
        if self.walk != before {
            self.walks[before].clips.clear();
            self.at = self.walks[self.walk].find(&place.clip, 0..UNSEEN).unwrap_or(0);
        }
        self.walk != before || self.walks[self.walk].clips.is_empty()
    }
}

/// The place by one look.
fn telling(look: &Look) -> Option<&Place> {
    look.place.as_ref().filter(|place| place.frame >= ALIKE)
}

impl std::fmt::Display for Path {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let clips = &self.walks[self.walk].clips;
        let around: Vec<_> = clips.iter().skip(self.at.saturating_sub(1)).take(4).collect();
        write!(f, "frame {} of `{}` among {around:?}", self.frame, self.clip())
    }
}

#[cfg(test)]
mod tests {
    use super::{Path, Walk};
    use crate::machine::picture::Look;
    use crate::machine::reference_frames::Place;
    use std::time::Duration;

    fn path() -> Path {
        let walk = ["a", "a", "a=b", "b", "b", "b=c", "c", "c", "c=a", "a", "a"];
        let clips = walk.into_iter().cycle().take(40).map(str::to_owned).collect();
        Path { walks: vec![Walk { flock: "demo".to_owned(), clips }], walk: 0, at: 0, frame: 0 }
    }

    fn look(clip: &str, frame: usize) -> Look {
        let place = Place { flock: "demo".into(), clip: clip.into(), frame, has_notice: false, has_mark: false };
        Look { at: Duration::ZERO, place: Some(place), other: None }
    }

    #[test]
    fn what_is_seen_moves_on_and_a_path_may_come_back_one_clip_away() {
        let mut path = path();
        for (clip, frame, at) in [("a", 9, 0), ("a", 50, 0), ("a", 8, 1), ("b", 0, 1), ("a=b", 30, 2), ("b", 20, 3)] {
            path.saw(&look(clip, frame));
            assert_eq!(path.at, at, "{clip} {frame}");
        }
        for (clip, at) in [("b", 3), ("a=b", 2), ("b=c", 5)] {
            let mut back = path.clone();
            assert!(back.came_back_with(&[look("c", 2), look(clip, 7)]));
            assert_eq!((back.at, back.clip()), (at, clip));
        }
    }

    #[test]
    #[should_panic(expected = "the path was at")]
    fn a_path_that_begins_anew_is_seen() {
        let mut path = path();
        path.saw(&look("b", 20));
        path.came_back_with(&[look("a", 7)]);
    }
}
