//! The JSON document in the page.
//!
//! Owns its form; the code in `sheet/` draws it. Never measures: the figures come from shares, balance and joins.
//!
//! Start at [`Facts::of`].

use std::collections::HashMap;

use flock::{Fault, Flock, FlockShares, Measure, SheepIx};
use operations::portrait::colour::Colour;
use operations::portrait::layout::places;
use operations::portrait::picture::Picture;

use super::balance::BalancedShares;
use super::credits::CreditFacts;
use super::joins::Joins;
use super::suggestions::SuggestionList;
use super::walk::{Spread, WalkSample};

/// The document of a page. Sheep are named by their index in `sheep`.
#[derive(Debug, serde::Serialize)]
pub(super) struct Facts<'f> {
    pub(super) name: &'f str,
    pub(super) size: (u32, u32),
    /// Numerator and denominator.
    pub(super) fps: (u32, u32),
    /// The measure of shares and wants: `visits` or `time`.
    pub(super) by: Measure,
    /// The worst of share/want and want/share in this measure; `None` if a sheep is never shown.
    pub(super) worst_ratio: Option<f64>,
    pub(super) figures: Figures,
    pub(super) faults: &'f [Fault],
    /// In the order of their ids.
    pub(super) sheep: Vec<SheepFacts<'f>>,
    /// From, to, the fraction of all steps that take it, its frames.
    pub(super) transitions: Vec<(usize, usize, f64, u32)>,
    pub(super) day: Option<Day>,
    pub(super) balanced: Option<BalancedShares>,
    pub(super) suggested: Option<SuggestionList>,
    pub(super) joins: Option<Joins>,
    pub(super) credits: Option<CreditFacts>,
}

/// The figures of the whole flock.
#[derive(Clone, Copy, Debug, serde::Serialize)]
pub(super) struct Figures {
    pub(super) sheep: usize,
    pub(super) transitions: usize,
    /// The worst of visits/want and want/visits; `None` if a sheep is never shown.
    pub(super) worst_ratio: Option<f64>,
    /// The same of time and the wants of all sheep with a loop.
    pub(super) worst_time_ratio: Option<f64>,
    /// Of the visits, and of as many sheep that are shown equally often.
    pub(super) entropy_bits: f64,
    pub(super) most_bits: f64,
    /// The mean time from one visit's start to the next one's.
    pub(super) step_minutes: f64,
    /// The sum of the lengths of all clips.
    pub(super) material_seconds: f64,
    /// The number of clips that the manifest names, and of those that are there; `None` if that was not checked.
    pub(super) clips: usize,
    pub(super) clips_there: Option<usize>,
    pub(super) pictures: usize,
}

#[derive(Debug, serde::Serialize)]
pub(super) struct SheepFacts<'f> {
    pub(super) id: &'f str,
    /// Its position, from -1 to 1 along each axis; up is positive.
    pub(super) x: f64,
    pub(super) y: f64,
    /// Its share and its want, in the measure of the page.
    pub(super) visits: f64,
    pub(super) want: f64,
    pub(super) minutes_a_day: f64,
    pub(super) return_minutes: Option<f64>,
    pub(super) returns: Option<Spread>,
    /// Frames of a visit, repeats included; 0 without a loop.
    pub(super) frames: u64,
    pub(super) repeat: u32,
    pub(super) colour: String,
    pub(super) picture: Option<&'f str>,
}

#[derive(Debug, serde::Serialize)]
pub(super) struct Day {
    /// As text: it may be larger than the numbers of the page's language.
    pub(super) seed: String,
    /// The sheep visited, one after another.
    pub(super) visits: Vec<usize>,
    /// Whether these are the visits of 24 hours; else of less.
    pub(super) whole: bool,
    /// The length of the walk from which return times and repeats are measured.
    pub(super) minutes: f64,
    /// The mean length of as many steps as the longest run of transitions has that came twice in it.
    pub(super) repeat_minutes: f64,
}

/// All that a page is made of.
pub(super) struct PageSources<'f> {
    pub(super) flock: &'f Flock,
    pub(super) by: Measure,
    /// The seed of the walk, and the walk.
    pub(super) seed: u64,
    pub(super) walked: Option<WalkSample>,
    pub(super) balanced: Option<BalancedShares>,
    pub(super) suggested: Option<SuggestionList>,
    pub(super) joins: Option<Joins>,
    pub(super) credits: Option<CreditFacts>,
    /// One for each sheep of the whole flock, or none at all.
    pub(super) pictures: &'f [Option<Picture>],
    pub(super) clips_there: Option<usize>,
}

impl<'f> Facts<'f> {
    /// Builds the data of the page from `sources`.
    pub(super) fn of(sources: PageSources<'f>) -> Self {
        let PageSources { flock, by, seed, walked, balanced, suggested, joins, credits, pictures, clips_there } =
            sources;
        let manifest = flock.manifest();
        let shares = FlockShares::of(flock);
        let transitions = transitions(flock, shares.as_ref());
        let figures = Figures::of(flock, shares.as_ref(), clips_there, pictures.iter().flatten().count());
        let (day, returns) = walked.map_or((None, Vec::new()), |walked| {
            let WalkSample { day: visits, is_whole_day: whole, returns, minutes, longest_repeat } = walked;
            let repeat_minutes = longest_repeat as f64 * figures.step_minutes;
            (Some(Day { seed: seed.to_string(), visits, whole, minutes, repeat_minutes }), returns)
        });
        Self {
            name: &manifest.name,
            size: manifest.size,
            fps: (manifest.fps.num(), manifest.fps.den()),
            by,
            worst_ratio: shares.as_ref().and_then(|shares| shares.worst(by)),
            figures,
            faults: flock.faults(),
            sheep: sheep(flock, by, shares.as_ref(), &returns, pictures),
            transitions,
            day,
            balanced,
            suggested,
            joins,
            credits,
        }
    }
}

impl Figures {
    /// The figures of `flock`, of whose clips so many are there, and which has so many pictures.
    pub(super) fn of(
        flock: &Flock,
        shares: Option<&FlockShares<'_>>,
        clips_there: Option<usize>,
        pictures: usize,
    ) -> Self {
        let (whole, clips) = (flock.whole(), distinct_clips(flock));
        let frames: u64 = clips.values().map(|&frames| u64::from(frames)).sum();
        let fps = flock.manifest().fps;
        Self {
            sheep: whole.len(),
            transitions: whole.exit_count(),
            worst_ratio: shares.and_then(|shares| shares.worst_ratio),
            worst_time_ratio: shares.and_then(|shares| shares.worst_time_ratio),
            entropy_bits: shares.map_or(0.0, |shares| shares.entropy_bits),
            most_bits: (whole.len().max(1) as f64).log2(),
            step_minutes: shares.map_or(0.0, |shares| shares.step_minutes),
            material_seconds: frames as f64 * f64::from(fps.den()) / f64::from(fps.num()),
            clips: clips.len(),
            clips_there,
            pictures,
        }
    }
}

fn sheep<'f>(
    flock: &'f Flock,
    by: Measure,
    shares: Option<&FlockShares<'f>>,
    returns: &[Option<Spread>],
    pictures: &'f [Option<Picture>],
) -> Vec<SheepFacts<'f>> {
    let whole = flock.whole();
    let ids: Vec<&str> = whole.sheep().map(|sheep| whole.id(sheep).as_str()).collect();
    let leads = |sheep| whole.exits(sheep).map(move |exit| (sheep, whole.target(exit)));
    let pairs: Vec<_> = whole.sheep().flat_map(leads).map(|(from, to)| (from.index(), to.index())).collect();
    let places = places(&ids, &pairs);
    let want = |sheep: SheepIx| flock.manifest().sheep[whole.sheep_in_manifest(sheep)].want;
    let wants: f64 = whole.sheep().map(want).sum();
    // Without shares there is no loop either, so that nothing is wanted of the time.
    let unplayed_want = |sheep| if by == Measure::Visits { want(sheep) / wants } else { 0.0 };
    let of = |sheep: SheepIx| {
        let at = sheep.index();
        let written = &flock.manifest().sheep[whole.sheep_in_manifest(sheep)];
        let share = shares.map(|shares| &shares.sheep[at]);
        let picture = pictures.get(at).and_then(Option::as_ref);
        let turn = written.clip.as_ref().map_or(0, |clip| u64::from(clip.frames.0));
        SheepFacts {
            id: ids[at],
            x: rounded(places[at][0], 1e4),
            y: rounded(places[at][1], 1e4),
            visits: share.map_or(0.0, |share| rounded(share.share_and_want(by).0, 1e12)),
            want: rounded(share.map_or_else(|| unplayed_want(sheep), |share| share.share_and_want(by).1), 1e12),
            minutes_a_day: share.map_or(0.0, |share| rounded(share.minutes_a_day, 1e4)),
            return_minutes: share.and_then(|share| share.return_minutes).map(|minutes| rounded(minutes, 1e4)),
            returns: returns.get(at).copied().flatten().map(Spread::rounded),
            frames: turn * u64::from(written.repeat),
            repeat: written.repeat,
            colour: picture.map_or_else(|| Colour::of_id(ids[at]), |picture| picture.colour).to_string(),
            picture: picture.map(|picture| picture.url.as_str()),
        }
    };
    whole.sheep().map(of).collect()
}

fn transitions(flock: &Flock, shares: Option<&FlockShares<'_>>) -> Vec<(usize, usize, f64, u32)> {
    let whole = flock.whole();
    let leads = whole.sheep().flat_map(|from| whole.exits(from).map(move |exit| (from, exit)));
    let facts = leads.enumerate().map(|(at, (from, exit))| {
        let visits = shares.map_or(0.0, |shares| shares.transitions[at].visits);
        let written = &flock.manifest().transitions[whole.transition_in_manifest(exit)];
        (from.index(), whole.target(exit).index(), rounded(visits, 1e12), written.clip.frames.0)
    });
    facts.collect()
}

/// The distinct clips of the flock by their paths, with their frames.
pub(super) fn distinct_clips(flock: &Flock) -> HashMap<&str, u32> {
    flock.manifest().clips().map(|clip| (clip.path.as_str(), clip.frames.0)).collect()
}

impl Spread {
    fn rounded(self) -> Self {
        let Self { soonest, median, longest } = self;
        Self { soonest: rounded(soonest, 1e3), median: rounded(median, 1e3), longest: rounded(longest, 1e3) }
    }
}

/// Rounded to the digits that a page needs.
pub(super) fn rounded(number: f64, parts: f64) -> f64 {
    (number * parts).round() / parts
}
