//! The JSON document in the page of a large flock.
//!
//! Owns its form: a flock of more sheep than a drawing has room for is told in sums, with the sheep that are furthest from
//! their wants, and with few bytes for each of the others, which a reader may search. Never measures.
//!
//! Start at [`LargeFacts::of`].

use flock::{Balance, Fault, Flock, FlockShares, Measure, SheepIx, SheepShare, Terms};
use operations::portrait::picture::Picture;

use super::balance::{BottleneckFacts, bottleneck};
use super::credits::CreditFacts;
use super::facts::{Figures, rounded};
use super::joins::Joins;
use super::packed::{self, Column};
use super::suggestions::SuggestionList;

/// The most sheep of a page that shows each of them.
pub(super) const MOST_DRAWN: usize = 2000;
/// How many of the sheep that are furthest from their wants are listed.
const WORST: usize = 50;
/// The most faults that are listed.
const MOST_FAULTS: usize = 50;
/// Bars on either side of the middle one, in the histogram of ratios.
const BARS: usize = 30;
/// Ratios of visits and want beyond the outermost bars are in these; as powers of two, the nearest and the farthest.
const REACH: (f64, f64) = (0.5, 6.0);

/// The document of a page. Sheep are named by their index in the order of their ids.
#[derive(Debug, serde::Serialize)]
pub(super) struct LargeFacts<'f> {
    pub(super) name: &'f str,
    size: (u32, u32),
    /// Numerator and denominator.
    fps: (u32, u32),
    /// The measure of shares and wants: `visits` or `time`.
    by: Measure,
    /// The worst of share/want and want/share in this measure; `None` if a sheep is never shown.
    worst_ratio: Option<f64>,
    pub(super) figures: Figures,
    /// The first ones, and the number of the others.
    faults: &'f [Fault],
    more_faults: usize,
    /// Whether there is a cycle to walk.
    day: bool,
    /// As [`packed::ids`] packs them.
    ids: String,
    /// Fractions of all visits, whatever the measure: the page finds the time from them and `frames`.
    visits: Column,
    /// In the measure of the page.
    want: Column,
    /// Frames of a visit, repeats included; 0 without a loop.
    frames: Column,
    leads_to: Column,
    comes_from: Column,
    ratios: Ratios,
    worst: Vec<WorstSheep<'f>>,
    balanced: Option<BalanceFacts>,
    suggested: Option<SuggestionList>,
    joins: Option<Joins>,
    credits: Option<CreditFacts>,
}

/// How many sheep have which ratio of share and want; those of which nothing is wanted are not counted.
#[derive(Debug, serde::Serialize)]
struct Ratios {
    /// The ratio of the outermost bars, as a power of two.
    reach: f64,
    /// From the most seldom to the most often; those that are never shown are in none.
    written: Vec<u32>,
    /// The same with balanced weights.
    balanced: Option<Vec<u32>>,
    never: usize,
}

/// What the weights of `dreams balance` would bring, with its default terms but for the measure.
#[derive(Debug, serde::Serialize)]
struct BalanceFacts {
    /// The worst of share/want and want/share; `None` if a sheep is never shown.
    worst_ratio: Option<f64>,
    bottleneck: Option<BottleneckFacts>,
}

/// A sheep that is far from its want, in all digits.
#[derive(Debug, serde::Serialize)]
struct WorstSheep<'f> {
    at: usize,
    /// As in the columns.
    visits: f64,
    want: f64,
    picture: Option<&'f str>,
}

/// All that a page is made of.
pub(super) struct LargeSources<'f> {
    pub(super) flock: &'f Flock,
    /// Of the balance.
    pub(super) terms: Terms,
    /// Its shares; `None` if it has neither a cycle nor a loop.
    pub(super) shares: Option<&'f FlockShares<'f>>,
    pub(super) suggested: Option<SuggestionList>,
    pub(super) joins: Option<Joins>,
    pub(super) credits: Option<CreditFacts>,
    /// Of the sheep that [`worst`] names, in its order; or none at all.
    pub(super) pictures: &'f [Option<Picture>],
    pub(super) clips_there: Option<usize>,
}

impl<'f> LargeFacts<'f> {
    /// Builds the data of the page from `sources`.
    pub(super) fn of(sources: LargeSources<'f>) -> Self {
        let LargeSources { flock, terms, shares, suggested, joins, credits, pictures, clips_there } = sources;
        let (manifest, whole, by) = (flock.manifest(), flock.whole(), terms.by);
        let sheep = shares.map_or(&[][..], |shares| &shares.sheep);
        let column = |of: &dyn Fn(SheepIx) -> f64| Column::of(&whole.sheep().map(of).collect::<Vec<f64>>());
        let mut entries = vec![0.0; whole.len()];
        for exit in whole.sheep().flat_map(|sheep| whole.exits(sheep)) {
            entries[whole.target(exit).index()] += 1.0;
        }
        let balance = Balance::of(flock, terms);
        let faults = flock.faults();
        let listed = &faults[..faults.len().min(MOST_FAULTS)];
        Self {
            name: &manifest.name,
            size: manifest.size,
            fps: (manifest.fps.num(), manifest.fps.den()),
            by,
            worst_ratio: shares.and_then(|shares| shares.worst(by)),
            figures: Figures::of(flock, shares, clips_there, pictures.iter().flatten().count()),
            faults: listed,
            more_faults: faults.len() - listed.len(),
            day: flock.is_walkable(),
            ids: packed::ids(whole.sheep().map(|sheep| whole.id(sheep).as_str())),
            visits: column(&|at| sheep.get(at.index()).map_or(0.0, |share| share.visits)),
            want: column(&|at| sheep.get(at.index()).map_or(0.0, |share| share.share_and_want(by).1)),
            frames: column(&|at| visit_frames(flock, at)),
            leads_to: column(&|at| whole.exits(at).len() as f64),
            comes_from: Column::of(&entries),
            ratios: Ratios::of(sheep, balance.as_ref(), by),
            worst: worst_sheep(sheep, by, pictures),
            balanced: balance
                .map(|balance| BalanceFacts { worst_ratio: balance.worst(), bottleneck: bottleneck(&balance) }),
            suggested,
            joins,
            credits,
        }
    }
}

/// The places of the sheep that are furthest from their wants, the furthest first.
pub(super) fn worst(sheep: &[SheepShare<'_>], by: Measure) -> Vec<usize> {
    let mut places: Vec<usize> = (0..sheep.len()).collect();
    // Of many that are never shown, those that are wanted most.
    let far = |at: usize| (sheep[at].off(by), sheep[at].share_and_want(by).1);
    places.sort_by(|&a, &b| far(b).0.total_cmp(&far(a).0).then(far(b).1.total_cmp(&far(a).1)));
    places.truncate(WORST);
    places
}

fn worst_sheep<'f>(sheep: &[SheepShare<'_>], by: Measure, pictures: &'f [Option<Picture>]) -> Vec<WorstSheep<'f>> {
    let of = |(order, at): (usize, usize)| {
        let picture = pictures.get(order).and_then(Option::as_ref);
        WorstSheep {
            at,
            visits: rounded(sheep[at].visits, 1e12),
            want: rounded(sheep[at].share_and_want(by).1, 1e12),
            picture: picture.map(|picture| picture.url.as_str()),
        }
    };
    worst(sheep, by).into_iter().enumerate().map(of).collect()
}

/// Frames of a visit of `sheep`, repeats included; 0 without a loop.
fn visit_frames(flock: &Flock, sheep: SheepIx) -> f64 {
    let written = &flock.manifest().sheep[flock.whole().sheep_in_manifest(sheep)];
    written.clip.as_ref().map_or(0.0, |clip| f64::from(clip.frames.0) * f64::from(written.repeat))
}

impl Ratios {
    /// The ratios of `sheep`, and those with the weights of `balance`.
    fn of(sheep: &[SheepShare<'_>], balance: Option<&Balance>, by: Measure) -> Self {
        let powers = |ratios: &mut dyn Iterator<Item = f64>| -> Vec<f64> {
            // Of a sheep without a loop no time is wanted: its ratio is no number.
            ratios.filter(|ratio| *ratio > 0.0).map(f64::log2).collect()
        };
        let ratio = |(share, want): (f64, f64)| share / want;
        let written = powers(&mut sheep.iter().map(|one| ratio(one.share_and_want(by))));
        let balanced =
            balance.map(|balance| powers(&mut balance.sheep.iter().map(|one| ratio(one.share_and_want(by)))));
        let all = written.iter().chain(balanced.iter().flatten());
        let reach = all.map(|power| power.abs()).fold(REACH.0, f64::max).min(REACH.1);
        let counted = |powers: Vec<f64>| {
            let mut counts = vec![0; 2 * BARS + 1];
            for power in powers {
                let bar = (power / reach * BARS as f64).round().clamp(-(BARS as f64), BARS as f64);
                counts[(bar + BARS as f64) as usize] += 1;
            }
            counts
        };
        let wanted = sheep.iter().filter(|one| one.share_and_want(by).1 > 0.0).count();
        let never = wanted - written.len();
        Self { reach: rounded(reach, 1e4), written: counted(written), balanced: balanced.map(counted), never }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use flock::SheepId;

    fn shares(ids: &[SheepId], visits: impl Fn(usize) -> f64) -> Vec<SheepShare<'_>> {
        let want = 1.0 / ids.len() as f64;
        let share = |(at, id)| {
            let (visits, time, time_want) = (visits(at), 0.0, 0.0);
            SheepShare { id, visits, time, want, time_want, return_minutes: None, minutes_a_day: 0.0 }
        };
        ids.iter().enumerate().map(share).collect()
    }

    #[test]
    fn the_furthest_come_first_and_those_that_are_never_shown_before_all() {
        let ids: Vec<SheepId> = (0..70).map(|at| SheepId::new(&format!("s{at}")).unwrap()).collect();
        let sheep = shares(&ids, |at| if at == 33 { 0.0 } else { 2f64.powi(at as i32 - 40) / 70.0 });
        let worst = worst(&sheep, Measure::Visits);
        assert_eq!((worst.len(), &worst[..4]), (WORST, &[33, 0, 1, 2][..]));
        assert!(worst.contains(&69) && !worst.contains(&40));
    }

    #[test]
    fn every_sheep_that_is_shown_is_in_a_bar_and_an_even_one_in_the_middle() {
        let ids: Vec<SheepId> = (0..9).map(|at| SheepId::new(&format!("s{at}")).unwrap()).collect();
        let sheep = shares(&ids, |at| [0.0, 1e-9, 0.25, 1.0, 1.0, 1.0, 4.0, 1e9, 0.0][at] / 9.0);
        let ratios = Ratios::of(&sheep, None, Measure::Visits);
        assert_eq!((ratios.never, ratios.reach, ratios.written.iter().sum::<u32>()), (2, 6.0, 7));
        assert_eq!((ratios.written[0], ratios.written[BARS], ratios.written[2 * BARS]), (1, 3, 1));
        assert_eq!((ratios.written[BARS - 10], ratios.written[BARS + 10]), (1, 1));
    }
}
