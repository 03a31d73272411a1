//! Visits of a long walk, and the bounds on their random deviation.
//!
//! Owns the bounds of `dreams simulate`. A sheep's own prediction is not used for its bound, so that a wrong prediction
//! does not widen it.
//!
//! The steered walk owes what it did not do, and pays. So the visits of a sheep follow a straight line through time: they
//! start with the walk, soon are so and so many ahead or behind of it, and from then on only sway. The line is fitted to
//! the counts at 64 moments. Its slope is the sheep's share; where it starts is what it is ahead; what the counts sway
//! around it, one standard deviation, is `s`. However long the walk is, it is off by no more than what it is ahead and
//! `t s`: `t` is Student's, as likely to be exceeded as four standard deviations that are known. One visit more is
//! allowed, since visits are whole. (A walk without memory errs anew at every step, and goes astray from any line by the
//! square root of its length: for such a walk these bounds do not hold.)
//!
//! Counts that sway slowly tell `s` badly: where each is much like the one before, 64 of them are worth but a few. If `r`
//! is how much alike two that follow each other are, `n` moments are worth `n (1 - r^2) / (1 + r^2)` (Bartlett 1935, for
//! variances), and `t` has as many degrees of freedom, less the two of the line.
//!
//! A flock that nearly falls apart is walked in spells: for long nothing is shown of one part, and then nothing else. One
//! spell may be a tenth of another, so a few of them tell neither a line nor what sways around it. A sheep that was away
//! between two moments has no bound before its eighth spell. What such sheep had, or should have had, the others have too
//! little or too much of: their bounds are wider by their parts of that.

use crate::graph::SheepIx;
use statrs::distribution::{ContinuousCDF, Normal, StudentsT};

/// The number of moments at which counts are sampled: their deviation is then known to a tenth.
const MOMENTS: u64 = 64;
/// The width of a bound in known standard deviations: one of 16,000 sheep lies outside by chance.
const SIGMAS: f64 = 4.0;
/// Spells of a sheep that comes in spells, before its counts tell anything.
const SPELLS: u32 = 8;

/// Visits of every sheep by the ordinals of its graph.
#[derive(Clone, Debug)]
pub struct Tally {
    visits: Vec<u64>,
    sums: Vec<Sums>,
    spells: Vec<Spells>,
    steps: u64,
    every: u64,
}

/// Sums over moments, whole numbers: differences of them lose nothing.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    visits: i128,
    squares: i128,
    /// Of the visits, each times the number of its moment.
    moments: i128,
    /// At the first moment, and at the latest.
    first: i128,
    last: i128,
    /// Of the squares of what they grew from each moment to the next.
    growths: i128,
}

/// When a sheep was there, as far as the moments tell.
#[derive(Clone, Copy, Debug, Default)]
struct Spells {
    /// Its visits up to the latest moment.
    visits: u64,
    /// How often it came, the first time included.
    count: u32,
    /// Whether it was visited between the latest two moments.
    is_there: bool,
    /// Whether it was once not.
    was_away: bool,
}

impl Tally {
    /// Nothing counted yet, of `sheep` sheep; `steps` visits will come.
    pub fn new(sheep: usize, steps: u64) -> Self {
        let (visits, sums, spells) = (vec![0; sheep], vec![Sums::default(); sheep], vec![Spells::default(); sheep]);
        Self { visits, sums, spells, steps: 0, every: (steps / MOMENTS).max(1) }
    }

    /// Counts a visit of `sheep`.
    pub fn visit(&mut self, sheep: SheepIx) {
        self.visits[sheep.index()] += 1;
        self.steps += 1;
        if self.steps.is_multiple_of(self.every) {
            let moment = i128::from(self.steps / self.every);
            for ((sums, spells), &visits) in self.sums.iter_mut().zip(&mut self.spells).zip(&self.visits) {
                let before = i128::from(spells.visits);
                spells.look(visits);
                sums.look(moment, before, visits.into());
            }
        }
    }

    /// Visits of `sheep` so far.
    pub fn visits(&self, sheep: SheepIx) -> u64 {
        self.visits[sheep.index()]
    }

    /// Visits of all sheep so far.
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// How far the visits of each sheep may be from their due by chance, in visits, if the walk was steered. Infinite where
    /// there were too few moments, or spells, to tell; `share` is what was due to such sheep, as a part of all visits.
    pub fn bounds(&self, share: impl Fn(SheepIx) -> f64) -> Vec<f64> {
        let all = self.steps as f64;
        let sheep = || (0..self.visits.len() as u32).map(SheepIx);
        let untold = sheep().filter(|sheep| !self.spells[sheep.index()].tell());
        let untold: f64 = untold.map(|sheep| (share(sheep) * all).max(self.visits(sheep) as f64)).sum();
        let bound = |sheep: SheepIx| {
            let own = self.spells[sheep.index()].tell().then(|| self.bound(sheep));
            own.map_or(f64::INFINITY, |own| own + untold * self.visits(sheep) as f64 / all)
        };
        sheep().map(bound).collect()
    }

    /// That of `sheep`, whatever others did.
    fn bound(&self, sheep: SheepIx) -> f64 {
        let (n, sums) = (i128::from(self.steps / self.every), self.sums[sheep.index()]);
        if n < 3 {
            return f64::INFINITY;
        }
        // The moments are 1 to n: n squared times their variance, the visits' and what they have in common.
        let of_moments = n * n * (n * n - 1) / 12;
        let of_visits = n * sums.squares - sums.visits * sums.visits;
        let common = n * sums.moments - sums.visits * (n * (n + 1) / 2);
        let left = (of_visits * of_moments - common * common) as f64 / of_moments as f64 / n as f64;
        let ahead = (sums.visits * of_moments - common * (n * (n + 1) / 2)) as f64 / (n * of_moments) as f64;
        let freedom = (sums.worth(n, common as f64 / of_moments as f64, left) - 2.0).max(1.0);
        let sway = (left / (n - 2) as f64).sqrt();
        ahead.abs() + student(freedom) * sway + 1.0
    }
}

impl Sums {
    /// Takes in how many visits there were up to a moment, and up to the one before.
    fn look(&mut self, moment: i128, before: i128, visits: i128) {
        self.visits += visits;
        self.squares += visits * visits;
        self.moments += visits * moment;
        if moment == 1 {
            self.first = visits;
        } else {
            self.growths += (visits - before) * (visits - before);
        }
        self.last = visits;
    }

    /// How many moments that know nothing of each other the `n` moments are worth, whose squared distances from a line of
    /// this `slope` sum up to `left`.
    fn worth(&self, n: i128, slope: f64, left: f64) -> f64 {
        let (steps, grown) = (n - 1, self.last - self.first);
        let mean = grown as f64 / steps as f64;
        // What the distances change from each moment to the next, squared: twice theirs if they know nothing of each other.
        let changes =
            (self.growths * steps - grown * grown) as f64 / steps as f64 + steps as f64 * (slope - mean).powi(2);
        let alike = if left > 0.0 { (1.0 - changes / (2.0 * left)).max(0.0) } else { 0.0 };
        n as f64 * (1.0 - alike * alike) / (1.0 + alike * alike)
    }
}

/// What Student's `t` with so many degrees of freedom exceeds as seldom as a normal deviate exceeds [`SIGMAS`].
fn student(freedom: f64) -> f64 {
    let seldom = Normal::standard().sf(SIGMAS);
    StudentsT::new(0.0, 1.0, freedom).map_or(f64::INFINITY, |t| -t.inverse_cdf(seldom))
}

impl Spells {
    /// Takes in how many visits there were up to a moment.
    fn look(&mut self, visits: u64) {
        let came = visits > self.visits;
        self.count += u32::from(came && !self.is_there);
        self.was_away |= !came;
        (self.is_there, self.visits) = (came, visits);
    }

    /// Whether its counts can tell what they sway.
    fn tell(&self) -> bool {
        !self.was_away || self.count >= SPELLS
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The bound of a sheep whose counts at the 64 moments are `counts`, 1000 steps apart.
    fn bound(counts: impl Fn(u64) -> u64) -> f64 {
        let mut tally = Tally::new(2, 64_000);
        for moment in 1..=64 {
            let due = counts(moment);
            for step in 0..1000 {
                let is_first = tally.visits(SheepIx(0)) < due && step < 999;
                tally.visit(SheepIx(u32::from(!is_first)));
            }
            assert_eq!(tally.visits(SheepIx(0)), due);
        }
        tally.bound(SheepIx(0))
    }

    #[test]
    fn a_steady_sheep_has_a_bound_of_one_visit_and_what_it_is_ahead_widens_it() {
        assert!((bound(|moment| 100 * moment) - 1.0).abs() < 1e-9);
        assert!((bound(|moment| 100 * moment + 7) - 8.0).abs() < 1e-9);
    }

    #[test]
    fn what_a_sheep_sways_widens_its_bound_fourfold_and_a_bit() {
        let sways = bound(|moment| 100 * moment + 6 * (moment % 2));
        // Three to either side of a line that is three ahead; 62 degrees of freedom make four 4.29.
        assert!((sways - (3.0 + 4.29 * 3.0 + 1.0)).abs() < 0.5, "{sways}");
    }

    #[test]
    fn counts_that_sway_slowly_tell_less() {
        // Three to either side again, after every moment; and as far, to and fro once in all.
        let often = bound(|moment| 100 * moment + 6 * (moment % 2));
        let once = bound(|moment| 100 * moment + (4.2 + 4.2 * (moment as f64 / 10.0).sin()) as u64);
        assert!(once > 2.0 * often, "{often} {once}");
    }

    #[test]
    fn student_is_gosset() {
        // By numerical integration of the density.
        for (freedom, t) in [(1.0, 10_050.4), (3.0, 32.616), (10.0, 6.567), (62.0, 4.292)] {
            assert!((student(freedom) / t - 1.0).abs() < 1e-3, "{freedom}: {}", student(freedom));
        }
    }

    #[test]
    fn a_few_steps_tell_nothing() {
        let mut tally = Tally::new(1, 2);
        tally.visit(SheepIx(0));
        tally.visit(SheepIx(0));
        assert!(tally.bound(SheepIx(0)).is_infinite());
    }

    #[test]
    fn a_few_spells_tell_nothing_and_widen_what_others_may_be_off() {
        // Of 64 stretches of 1000 steps the first sheep has `spells` whole ones, far apart.
        let tallied = |spells: u64| {
            let mut tally = Tally::new(2, 64_000);
            for step in 0..64_000u64 {
                let (stretch, each) = (step / 1000, 64 / spells);
                tally.visit(SheepIx(u32::from(stretch % each != 0 || stretch / each >= spells)));
            }
            tally.bounds(|sheep| [0.1, 0.9][sheep.index()])
        };
        let [first, second] = tallied(7)[..] else { panic!("two sheep") };
        // It had 7000 visits, of which the other, with 57 of 64 parts, may have lacked its part.
        assert!(first.is_infinite() && second > 7000.0 * 57.0 / 64.0, "{first} {second}");
        let [first, second] = tallied(8)[..] else { panic!("two sheep") };
        assert!(first < 4000.0 && second < 4000.0, "{first} {second}");
    }
}
