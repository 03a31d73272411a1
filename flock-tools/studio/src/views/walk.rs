//! The walk of a seed, clip by clip, for the page's player.
//!
//! Owns the list of clips with their places on the time line, and what comes too often or too soon in it. The order is that
//! of the flock crate, so that it is what `dreams walk` prints and a unit plays. Never opens a clip.
//!
//! Start at [`Walked::of`].

use std::collections::BTreeMap;
use std::sync::Arc;

use flock::{ClipKind, Flock, FlockShares, Itinerary, Place, SheepId};

/// A sheep comes too often if it has more than so many times the visits that are wanted of it, ...
const OFTEN: f64 = 1.25;
/// ... and so many visits at least: fewer are chance.
const LEAST_VISITS: usize = 3;
/// It comes back too soon if that took less than this part of the time between visits that its want asks for.
const SOON: f64 = 0.25;

/// Some steps of a walk.
#[derive(Debug, serde::Serialize)]
pub(crate) struct Walked {
    pub(crate) seed: u64,
    pub(crate) clips: Vec<WalkedClip>,
    /// The worst first.
    pub(crate) too_often: Vec<TooOften>,
    /// In the order of the walk.
    pub(crate) too_soon: Vec<TooSoon>,
}

/// A clip of the walk.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub(crate) struct WalkedClip {
    /// `loop` or `transition`.
    pub(crate) kind: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) sheep: Option<SheepId>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) from: Option<SheepId>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) to: Option<SheepId>,
    pub(crate) frames: u32,
    /// Frames before this clip.
    pub(crate) start_frame: u64,
    /// The key of its fragments; `null` if the clip is not there.
    pub(crate) fragments: Option<String>,
    /// The key of its moving preview; `null` if there is none.
    pub(crate) preview: Option<String>,
}

/// A sheep that the walk shows too often.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub(crate) struct TooOften {
    pub(crate) id: SheepId,
    /// How often it comes in these steps.
    pub(crate) times: usize,
    /// Parts of the visits of these steps.
    pub(crate) share: f64,
    pub(crate) wanted: f64,
}

/// A visit that comes too soon after the one before.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub(crate) struct TooSoon {
    pub(crate) id: SheepId,
    /// The place in the list of clips at which it is back.
    pub(crate) clip: usize,
    /// Seconds since the start of the visit before, and those that its want asks for.
    pub(crate) after_s: f64,
    pub(crate) usual_s: f64,
}

/// The start of a visit.
struct Visit {
    id: SheepId,
    /// The number of clips, and of frames, before it.
    clip: usize,
    start_frame: u64,
}

impl Walked {
    /// `steps` steps of the walk of `flock` from `seed`, or from the first time that it comes to `start`; without keys.
    /// `None` if nothing can be shown, or if the walk does not come to `start`.
    pub(crate) fn of(flock: &Arc<Flock>, seed: u64, steps: usize, start: Option<&SheepId>) -> Option<Self> {
        let mut path = Itinerary::start(Arc::clone(flock), seed);
        if let Some(start) = start {
            path = arrived(path, start)?;
        }
        let (mut clips, mut visits, mut frame, mut left) = (Vec::new(), Vec::<Visit>::new(), 0_u64, steps);
        while let Some(clip) = path.next_clip() {
            let (kind, sheep, from, to) = match clip.what {
                ClipKind::Loop { sheep } => {
                    if clips.is_empty() {
                        visits.push(Visit { id: sheep.clone(), clip: 0, start_frame: 0 });
                    }
                    ("loop", Some(sheep), None, None)
                }
                ClipKind::Transition { from, to } => {
                    if left == 0 {
                        break;
                    }
                    left -= 1;
                    let start_frame = frame + u64::from(clip.frames.0);
                    visits.push(Visit { id: to.clone(), clip: clips.len() + 1, start_frame });
                    ("transition", None, Some(from), Some(to))
                }
            };
            let (frames, fragments, preview) = (clip.frames.0, None, None);
            clips.push(WalkedClip { kind, sheep, from, to, frames, start_frame: frame, fragments, preview });
            frame += u64::from(frames);
            if !flock.is_walkable() {
                break;
            }
        }
        let (too_often, too_soon) = judged(flock, &visits);
        (!clips.is_empty()).then_some(Self { seed, clips, too_often, too_soon })
    }
}

/// The walk at the beginning of its first visit of `start`; the same steps for the same seed.
fn arrived(mut path: Itinerary, start: &SheepId) -> Option<Itinerary> {
    /// A sheep that is shown at all comes within so many visits of every sheep.
    const MOST: usize = 200;
    let flock = Arc::clone(path.flock());
    let most = MOST * flock.graph().len().max(1);
    flock.graph().find(start)?;
    let is_there = |clip: &ClipKind| matches!(clip, ClipKind::Loop { sheep } if sheep == start);
    let leaves = |clip: &ClipKind| matches!(clip, ClipKind::Transition { from, .. } if from == start);
    let mut last: Option<Place> = None;
    for _ in 0..most {
        let leg = path.next_leg()?;
        if is_there(&leg.clip.what) || leaves(&leg.clip.what) {
            return Itinerary::resume(flock, &leg.place).ok();
        }
        last = Some(leg.place);
    }
    last.and_then(|place| Itinerary::resume(flock, &place).ok())
}

/// What comes too often, and what too soon.
fn judged(flock: &Flock, visits: &[Visit]) -> (Vec<TooOften>, Vec<TooSoon>) {
    let Some(shares) = FlockShares::of(flock).filter(|_| flock.is_walkable()) else {
        return (Vec::new(), Vec::new());
    };
    let wants: BTreeMap<&SheepId, f64> = shares.sheep.iter().map(|sheep| (sheep.id, sheep.want)).collect();
    let wanted = |id: &SheepId| wants.get(id).copied().unwrap_or(0.0);
    let fps = flock.manifest().fps;
    let seconds = |frames: u64| frames as f64 * f64::from(fps.den()) / f64::from(fps.num());
    let mut counts: BTreeMap<&SheepId, usize> = BTreeMap::new();
    let mut last: BTreeMap<&SheepId, u64> = BTreeMap::new();
    let mut too_soon = Vec::new();
    for Visit { id, clip, start_frame } in visits {
        *counts.entry(id).or_default() += 1;
        let usual_s = 60.0 * shares.step_minutes / wanted(id);
        if let Some(before) = last.insert(id, *start_frame) {
            let after_s = seconds(start_frame - before);
            if after_s < SOON * usual_s {
                too_soon.push(TooSoon { id: id.clone(), clip: *clip, after_s, usual_s });
            }
        }
    }
    let mut too_often: Vec<TooOften> = counts
        .into_iter()
        .map(|(id, count)| TooOften {
            id: id.clone(),
            times: count,
            share: count as f64 / visits.len() as f64,
            wanted: wanted(id),
        })
        .filter(|own| own.times >= LEAST_VISITS && own.share > OFTEN * own.wanted)
        .collect();
    too_often.sort_by(|a, b| (b.share / b.wanted).total_cmp(&(a.share / a.wanted)));
    (too_often, too_soon)
}

#[cfg(test)]
mod tests {
    use super::*;
    use flock::Manifest;
    use std::fmt::Write;
    use std::path::Path;

    /// Sheep a to d, each linked to both neighbours in a ring; `a` is wanted so much.
    fn flock(want: f64) -> Arc<Flock> {
        let mut text = "format = 1\nname = \"x\"\nsize = [64, 64]\nfps = [30, 1]\n".to_owned();
        for id in ["a", "b", "c", "d"] {
            write!(text, "[[sheep]]\nid = \"{id}\"\nframes = 60\nclip = \"{id}.mp4\"\n").unwrap();
            if id == "a" {
                write!(text, "want = {want:?}\nrepeat = 2\n").unwrap();
            }
        }
        for pair in ["ab", "bc", "cd", "da", "ba", "cb", "dc", "ad"] {
            let (from, to) = pair.split_at(1);
            write!(text, "[[transition]]\nfrom = \"{from}\"\nto = \"{to}\"\nframes = 90\nclip = \"{pair}.mp4\"\n")
                .unwrap();
        }
        Arc::new(Flock::new(Manifest::parse(&text, Path::new("flock.toml")).unwrap()))
    }

    #[test]
    fn the_page_plays_the_clips_of_the_units_walk_each_at_its_frame() {
        let walked = Walked::of(&flock(1.0), 7, 20, None).unwrap();
        let mut path = Itinerary::start(flock(1.0), 7);
        let mut frame = 0;
        for clip in &walked.clips {
            let own = path.next_clip().unwrap();
            assert_eq!((clip.start_frame, clip.frames), (frame, own.frames.0));
            let what = match own.what {
                ClipKind::Loop { sheep } => ("loop", Some(sheep), None, None),
                ClipKind::Transition { from, to } => ("transition", None, Some(from), Some(to)),
            };
            assert_eq!((clip.kind, clip.sheep.clone(), clip.from.clone(), clip.to.clone()), what);
            frame += u64::from(clip.frames);
        }
        let steps = walked.clips.iter().filter(|clip| clip.kind == "transition").count();
        assert_eq!((steps, walked.clips.last().unwrap().kind), (20, "loop"));
    }

    #[test]
    fn a_walk_from_a_sheep_begins_with_its_loop() {
        for id in ["a", "b", "c", "d"] {
            let id = SheepId::new(id).unwrap();
            let walked = Walked::of(&flock(1.0), 3, 4, Some(&id)).unwrap();
            assert_eq!((walked.clips[0].sheep.as_ref(), walked.clips[0].start_frame), (Some(&id), 0));
        }
        assert!(Walked::of(&flock(1.0), 3, 4, Some(&SheepId::new("x").unwrap())).is_none());
    }

    #[test]
    fn a_sheep_that_is_wanted_less_than_it_comes_is_named() {
        let walked = Walked::of(&flock(0.2), 1, 100, None).unwrap();
        assert_eq!(walked.too_often[0].id.as_str(), "a");
        assert!(walked.too_often[0].share > 0.2 && walked.too_often[0].wanted < 0.07, "{:?}", walked.too_often);
        assert!(walked.too_soon.iter().any(|visit| visit.id.as_str() == "a"), "{:?}", walked.too_soon);
        let even = Walked::of(&flock(1.0), 1, 100, None).unwrap();
        assert!(even.too_often.iter().all(|own| own.id.as_str() != "a"), "{:?}", even.too_often);
    }
}
