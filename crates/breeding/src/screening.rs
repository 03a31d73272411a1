//! What will be liked, guessed from what was.
//!
//! Owns the model by which candidates are screened: a kernel regression on figures. Never draws by chance.
//!
//! Start at [`Liking::of`].

use crate::census::{Census, is_judged};
use crate::pool::{Pool, Sheep};
use crate::rating::Tally;
use crate::traits::{Point, median};

/// So many of those that died last are looked at beside the living.
pub(crate) const MOST_DEAD: usize = 400;
/// With fewer judged sheep nothing is screened.
pub(crate) const LEAST_JUDGED: usize = 30;
/// The width of the kernel is the median distance to this neighbour.
const NEIGHBOUR: usize = 5;

/// The model.
#[derive(Clone, Debug)]
pub struct Liking {
    known: Vec<(Point, Tally)>,
    width: f64,
}

impl Liking {
    /// What follows from the votes and marks of a pool; `None` if too few sheep are judged.
    pub fn of(pool: &Pool, census: &Census) -> Option<Liking> {
        let share = pool.artist_share();
        let known = |sheep: &Sheep| (census.point(&sheep.born.figures), census.liking(sheep, share));
        let mut all: Vec<_> = pool.living().map(known).collect();
        all.extend(pool.dead().into_iter().take(MOST_DEAD).map(known));
        all.retain(|(_, tally)| tally.expected > 0.0);
        let judged = all.iter().filter(|(_, tally)| is_judged(*tally)).count();
        let width = width(&all.iter().map(|(point, _)| point).collect::<Vec<_>>());
        (judged >= LEAST_JUDGED && width > 0.0).then_some(Liking { known: all, width })
    }

    /// How a sheep with these figures would be rated: votes as a multiple of what is expected, of sheep like it.
    pub fn guess(&self, point: &Point) -> f64 {
        let mut sum = Tally::default();
        for (known, tally) in &self.known {
            sum = sum.with(tally.times(likeness(point, known, self.width)));
        }
        sum.rating()
    }
}

/// How like two sheep are, 0 to 1: a Gaussian of their distance.
pub(crate) fn likeness(a: &Point, b: &Point, width: f64) -> f64 {
    let reach = a.distance_squared(b) / (2.0 * width * width);
    // Less than a millionth is nothing, and costs nothing.
    if reach > 14.0 { 0.0 } else { libm::exp(-reach) }
}

/// The median distance to the fifth neighbour; 0 if there are not so many.
pub(crate) fn width(points: &[&Point]) -> f64 {
    let neighbour = |(at, point): (usize, &&Point)| {
        let others = points.iter().enumerate().filter(|(other, _)| *other != at);
        let mut squares: Vec<f64> = others.map(|(_, other)| point.distance_squared(other)).collect();
        let last = NEIGHBOUR.checked_sub(1).filter(|last| *last < squares.len())?;
        Some(libm::sqrt(*squares.select_nth_unstable_by(last, f64::total_cmp).1))
    };
    median(&points.iter().enumerate().filter_map(neighbour).collect::<Vec<_>>())
}
