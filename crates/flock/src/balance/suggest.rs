//! The transitions whose adding, and those whose removal, improve the balance most.
//!
//! Owns the choice, one at a time: each suggestion is found with the previous ones applied, and its effect is the
//! result of `dreams balance` after it. The tools add the cost of rendering.
//!
//! Start at [`Suggestions::of`]; `sketch.rs` estimates the effect of a change.
//!
//! # Source
//! Candidates are the pairs with the highest prices of leaving plus entering (the gain of the first flow along a new
//! transition, by duality), and those whose first flow lowers the worst ratios most (by the adjoint of the Newton
//! system). The best few are tried. Each search goes on from the balance that the one before it ended in.

use std::borrow::Cow;
use std::panic::resume_unwind;
use std::thread;

use timing::FrameCount;

use super::sketch::{Change, Sketch, TRIES};
use super::terms::Terms;
use super::weights::rounded;
use super::{Balance, join};
use crate::flock::{Flock, Measure};
use crate::graph::SheepIx;
use crate::manifest::{Clip, ClipPath, SheepId, Transition};

/// The smallest relative improvement that counts.
const GAIN: f64 = 1e-6;

/// Up to so many transitions both searches go on at once. Each takes some 200 bytes of memory a transition.
const AT_ONCE: usize = 50_000;

/// Suggested changes of a flock's transitions.
#[derive(Clone, Debug, PartialEq)]
pub struct Suggestions {
    /// Transitions to add, in this order; each is the best one after those before it.
    pub add: Vec<Suggestion>,
    /// Transitions to remove, in this order, with none added; each is the best one after those before it.
    pub remove: Vec<Suggestion>,
}

/// A transition to add or to remove.
#[derive(Clone, Debug, PartialEq)]
pub struct Suggestion {
    /// Where it starts.
    pub from: SheepId,
    /// Where it ends.
    pub to: SheepId,
    /// The balance's worst ratio once this and all before it are done, if the flock is then balanced on the same terms;
    /// `None` while a sheep is never visited.
    pub worst_ratio: Option<f64>,
    /// The same of time: [`Balance::worst_time_ratio`].
    pub worst_time_ratio: Option<f64>,
    /// How long its clip is: of one to add, as long as the flock's transitions are in the middle.
    pub frames: FrameCount,
    /// The weight that it has, or that it is counted with: that of its sheep's other exits in the mean.
    pub weight: f64,
}

/// Which changes are looked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Direction {
    Add,
    Remove,
}

impl Suggestions {
    /// Up to `count` transitions to add to `flock` and as many to remove, for balances on `terms`. Fewer where no other
    /// improves the balance. `None` if the flock has no cycle to walk.
    ///
    /// Sheep that are not played come first: they are joined to those that are, by as few transitions as we can. No
    /// transition is suggested from a sheep to itself, and no removal after which a sheep would no longer be played.
    pub fn of(flock: &Flock, terms: Terms, count: usize) -> Option<Self> {
        if !flock.is_walkable() {
            return None;
        }
        let sketch = Sketch::of(flock, terms);
        if flock.graph().exit_count() > AT_ONCE {
            let add = sequence(flock, terms, count, Direction::Add, sketch);
            let sketch = Sketch::of(flock, terms);
            return Some(Self { add, remove: sequence(flock, terms, count, Direction::Remove, sketch) });
        }
        let (add, remove) = thread::scope(|scope| {
            let remove = scope.spawn(|| sequence(flock, terms, count, Direction::Remove, sketch.clone()));
            (sequence(flock, terms, count, Direction::Add, sketch.clone()), remove.join())
        });
        Some(Self { add, remove: remove.unwrap_or_else(|panic| resume_unwind(panic)) })
    }
}

impl Suggestion {
    /// The worst ratio in `measure`.
    pub fn worst(&self, measure: Measure) -> Option<f64> {
        measure.of(self.worst_ratio, self.worst_time_ratio)
    }

    /// Up to `count` transitions to add to `flock`, as [`Suggestions::of`] tells them; in half the time.
    pub fn to_add(flock: &Flock, terms: Terms, count: usize) -> Option<Vec<Self>> {
        flock.is_walkable().then(|| sequence(flock, terms, count, Direction::Add, Sketch::of(flock, terms)))
    }
}

/// The best changes of one kind, one after the other; `sketch` is that of `flock`.
fn sequence(flock: &Flock, terms: Terms, count: usize, way: Direction, sketch: Sketch) -> Vec<Suggestion> {
    let mut suggestions = Vec::new();
    let (mut now, mut sketch) = (Cow::Borrowed(flock), sketch);
    while suggestions.len() < count {
        let missing = if way == Direction::Add { join::missing(&now) } else { None };
        let found = match missing {
            Some((from, to)) => {
                changed(&now, way, from, to).map(|(change, next)| (change, Sketch::of(&next, terms), next))
            }
            None => best(&now, way, &sketch),
        };
        let Some((suggestion, outline, next)) = found else { break };
        // What was before goes first: there may not be enough memory for both.
        (now, sketch) = (Cow::Owned(next), outline);
        let [worst_ratio, worst_time_ratio] = Balance::worst_ratios_near(&now, terms, sketch.circulation());
        suggestions.push(Suggestion { worst_ratio, worst_time_ratio, ..suggestion });
    }
    suggestions
}

/// The change that makes the part of `flock` that is played better than any other that was tried.
fn best(flock: &Flock, way: Direction, sketch: &Sketch) -> Option<(Suggestion, Sketch, Flock)> {
    let better = |(_, after): &(Change, Sketch)| after.badness() < (1.0 - GAIN) * sketch.badness();
    let (change, outline) = TRIES.iter().find_map(|&tries| {
        let changes = match way {
            Direction::Add => sketch.additions(tries),
            Direction::Remove => sketch.removals(tries),
        };
        sketch.best(changes).filter(better)
    })?;
    let (Change::Add { from, to } | Change::Remove { from, to }) = change;
    let id = |at: usize| flock.id(SheepIx(at as u32)).clone();
    let (suggestion, next) = changed(flock, way, id(from), id(to))?;
    Some((suggestion, outline, next))
}

/// `flock` after a change, and the change as it is told but for its effect.
fn changed(flock: &Flock, way: Direction, from: SheepId, to: SheepId) -> Option<(Suggestion, Flock)> {
    let whole = flock.whole();
    let (frames, weight, next) = match way {
        Direction::Add => {
            let (frames, weight) = (usual_frames(flock), usual_weight(flock, &from));
            let path = ClipPath::new("transition").expect("a plain name");
            let clip = Clip { path, frames, hash: None };
            let next = flock.with_transition(Transition { from: from.clone(), to: to.clone(), clip, weight });
            (frames, weight, next)
        }
        Direction::Remove => {
            let exit = whole.between(whole.find(&from)?, whole.find(&to)?)?;
            let gone = flock.written(whole.transition_in_manifest(exit));
            (gone.clip.frames, gone.weight, flock.without_transition(exit))
        }
    };
    Some((Suggestion { from, to, worst_ratio: None, worst_time_ratio: None, frames, weight }, next))
}

/// The length of the transition in the middle.
fn usual_frames(flock: &Flock) -> FrameCount {
    let mut frames: Vec<u32> = flock.transitions().map(|transition| transition.clip.frames.0).collect();
    frames.sort_unstable();
    FrameCount(frames.get(frames.len() / 2).copied().unwrap_or(1))
}

/// The weight of the exits of `from` in the mean, to two digits; 1 if it has none.
fn usual_weight(flock: &Flock, from: &SheepId) -> f64 {
    let own: Vec<f64> = flock.transitions().filter(|t| t.from == *from).map(|t| t.weight).collect();
    let mean = own.iter().map(|weight| weight / own.len() as f64).sum::<f64>();
    if own.is_empty() { 1.0 } else { rounded(mean, 2) }
}
