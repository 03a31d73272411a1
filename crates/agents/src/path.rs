//! Paths through the globe.
//!
//! Owns where an agent is at a moment of its loop, and how fast: whole screens down, harmonics to the side, whole turns.
//! All of it follows from a seed and the agent's number. Never knows how an agent looks.
//!
//! Start at [`Path::at`].

use std::f64::consts::TAU;

use species::Rng;

/// A way that closes after one turn of the phase.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Path {
    start: Place,
    /// Screens down, 1 to 3.
    falls: f64,
    /// Turns about itself, -1, 0 or 1.
    spins: f64,
    /// Three harmonics to the side: how far, and at which phase.
    sway: [[f64; 2]; 3],
    /// One of the angle: how far in turns, and at which phase.
    tilt: [f64; 2],
    /// 0 is far, 1 near.
    pub(crate) depth: f64,
}

/// Where something is, or how far it comes in a unit of time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Place {
    /// In widths of the picture from its left.
    pub(crate) x: f64,
    /// In screens fallen, the margin included.
    pub(crate) fallen: f64,
    /// In turns, clockwise.
    pub(crate) turned: f64,
}

/// Agents and motes take paths of their own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    Agent,
    Mote,
}

impl Path {
    /// The path of the one with this number, which sets out from a part of the width and of a screen.
    pub(crate) fn of(drift: u32, kind: Kind, number: usize, [x, fallen]: [f64; 2]) -> Path {
        let stream = 2 * number as u64 + u64::from(kind == Kind::Mote);
        let (mut rng, mut all) = (Rng::stream(u64::from(drift), 16 + stream), Rng::stream(u64::from(drift), 0));
        // The sequence of the golden ratio: depths keep apart from each other.
        let depth = (all.unit() + (number as f64 + 1.0) * 0.618_033_989).fract();
        let depth = if kind == Kind::Agent { depth } else { rng.unit() };
        // An agent that fell faster would flicker. Near motes are out of focus, and may.
        let falls = if kind == Kind::Agent || depth < 0.85 {
            1.0
        } else if depth < 0.97 {
            2.0
        } else {
            3.0
        };
        let part = |least: f64, rng: &mut Rng| [least * (0.4 + 0.6 * rng.unit()), rng.unit()];
        let sway = [0.032, 0.008, 0.004].map(|far| part(far * (0.5 + depth), &mut rng));
        let tilt = part(0.045, &mut rng);
        let turned = rng.unit();
        let spins = [-1.0, 0.0, 0.0, 0.0, 0.0, 1.0][(rng.unit() * 6.0) as usize];
        Path { start: Place { x: 0.05 + 0.9 * x, fallen, turned }, falls, spins, sway, tilt, depth }
    }

    /// Where it is at `phase`, in turns of the loop.
    pub(crate) fn at(&self, phase: f64) -> Place {
        let wave = |[far, from]: [f64; 2], times: f64| far * libm::sin(TAU * (times * phase + from));
        let sway = self.sway;
        Place {
            x: self.start.x + wave(sway[0], 1.0) + wave(sway[1], 2.0) + wave(sway[2], 3.0),
            fallen: self.start.fallen + self.falls * phase,
            turned: self.start.turned + self.spins * phase + wave(self.tilt, 1.0),
        }
    }

    /// How far it comes in one turn of the loop at the speed that it has at `phase`.
    pub(crate) fn speed(&self, phase: f64) -> Place {
        let wave = |[far, from]: [f64; 2], times: f64| far * TAU * times * libm::cos(TAU * (times * phase + from));
        let sway = self.sway;
        Place {
            x: wave(sway[0], 1.0) + wave(sway[1], 2.0) + wave(sway[2], 3.0),
            fallen: self.falls,
            turned: self.spins + wave(self.tilt, 1.0),
        }
    }
}

/// So many places of 0 to 1 across and down, where what leaves at the bottom comes in at the top. Each is the farthest from
/// those before it of some that are tried, so that more of them do not move the first.
///
/// # Source
/// Don P. Mitchell, *Spectrally Optimal Sampling for Distribution Ray Tracing*, SIGGRAPH 1991: the best candidate.
pub(crate) fn apart(drift: u32, kind: Kind, many: usize) -> Vec<[f64; 2]> {
    let mut rng = Rng::stream(u64::from(drift), 1 + u64::from(kind == Kind::Mote));
    let mut places: Vec<[f64; 2]> = Vec::with_capacity(many);
    let tries = if kind == Kind::Agent { 12 } else { 1 };
    for _ in 0..many {
        let mut best = ([0.0; 2], -1.0);
        for _ in 0..tries {
            let place = [rng.unit(), rng.unit()];
            let square = |other: &[f64; 2]| {
                let (across, down) = (1.6 * (place[0] - other[0]), (place[1] - other[1]).abs());
                across * across + down.min(1.0 - down).powi(2)
            };
            let nearest = places.iter().map(square).fold(f64::MAX, f64::min);
            if nearest > best.1 {
                best = (place, nearest);
            }
        }
        places.push(best.0);
    }
    places
}

/// The cubic with these values and speeds at 0 and 1.
pub(crate) fn cubic([from, to]: [f64; 2], [away, home]: [f64; 2], part: f64) -> f64 {
    let way = to - from;
    let (square, bend) = (3.0 * way - 2.0 * away - home, away + home - 2.0 * way);
    from + part * (away + part * (square + part * bend))
}

/// `to` and as many whole numbers as bring it nearest to where the speeds lead, or `ahead` of that.
pub(crate) fn unwound([from, to]: [f64; 2], [away, home]: [f64; 2], ahead: f64) -> f64 {
    let led = from + f64::midpoint(away, home) + ahead;
    to + (led - to).round()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_path_closes_and_its_speed_is_that_of_its_places() {
        for (number, start) in apart(7, Kind::Agent, 25).into_iter().enumerate() {
            let path = Path::of(7, Kind::Agent, number, start);
            let [from, to] = [0.0, 1.0].map(|phase| path.at(phase));
            let whole = [to.fallen - from.fallen, to.turned - from.turned];
            assert!((to.x - from.x).abs() < 1e-9 && whole.iter().all(|way| (way - way.round()).abs() < 1e-9));
            assert!((1.0..=3.0).contains(&whole[0].round()) && whole[1].abs() < 1.5);
            let (low, high, speed) = (path.at(0.3 - 1e-5), path.at(0.3 + 1e-5), path.speed(0.3));
            let close = |low: f64, high: f64, speed: f64| ((high - low) / 2e-5 - speed).abs() < 1e-4;
            assert!(close(low.x, high.x, speed.x) && close(low.turned, high.turned, speed.turned));
        }
    }

    #[test]
    fn a_cubic_has_the_values_and_the_speeds_that_it_is_given() {
        let at = |part| cubic([1.0, 5.0], [2.0, -3.0], part);
        assert_eq!([at(0.0), at(1.0)], [1.0, 5.0]);
        assert!(
            ((at(1e-6) - at(0.0)) * 1e6 - 2.0).abs() < 1e-4 && ((at(1.0) - at(1.0 - 1e-6)) * 1e6 + 3.0).abs() < 1e-4
        );
        assert_eq!(unwound([0.25, 0.5], [2.0, 2.0], 0.0), 2.5);
    }
}
