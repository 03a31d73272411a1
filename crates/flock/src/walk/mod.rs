//! The endless choice of the next transition: a steered credit walk.
//!
//! Owns the steering: the choice among the exits that the ledger allows, random but with bounded deviation from the
//! shares. Randomness is a function of (seed, step) only, so a walk restored from its memory continues exactly.
//! `itinerary.rs` turns steps into clips.
//!
//! Start at [`Walk::step`].

mod blocked;
mod carry_over;
mod itinerary;
mod ledger;
mod memory;
mod runs;
#[cfg(test)]
mod tests;

use std::sync::Arc;

use rand_chacha::ChaCha12Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

use crate::flock::Flock;
use crate::graph::{Exit, Graph, SheepIx};
use blocked::BlockedClips;
pub use itinerary::{ClipKind, ClipRef, Itinerary, Leg, SheepVisits};
use memory::{Memory, NEVER};
pub use memory::{Place, PlaceError};
use runs::Runs;

// The parameters of the walk: constants of the flock format. The formula is from the design's study of walks, 3.3. `KAPPA`
// and `MAX_LATE` are stronger than there (0.05 and 3): on 200 sheep with 4 transitions each a sheep was up to 27 visits off
// its due in a year with those, 4 with these, at 0.32 instead of 0.33 of the mean for the 5th percentile of returns.
/// Steps of look-ahead.
const DEPTH: u32 = 3;
/// Steps after which having seen a sheep has faded to 1/e.
const FADE_STEPS: f64 = 40.0;
/// Temperature: how much more an exit may cost and still be drawn sometimes.
const TEMPERATURE: f64 = 0.05;
/// Pull of a late sheep, per visit that it is late, up to [`MAX_LATE`].
const KAPPA: f64 = 0.2;
/// Late visits that count, either way.
const MAX_LATE: f64 = 10.0;
/// Pull of a late exit, per missing count beyond the first, up to [`MAX_OWED`].
const MU: f64 = 0.2;
/// Takings owed that count.
const MAX_OWED: f64 = 10.0;
/// The weight of a step ahead, relative to the one before it.
const GAMMA: f64 = 0.8;
/// Cost of a step that repeats a run.
const NU: f64 = 0.3;
/// Exits of a smaller probability are not followed when looking ahead.
const MIN_CHANCE: f64 = 1e-3;
/// Most sheep looked at behind one exit, and in one decision.
const BUDGET: u32 = 256;
const BUDGET_OF_DECISION: u32 = 4096;

/// The generator's key is the seed and this.
const KEY: &[u8; 24] = b"dreams in high fidelity\0";
/// Stream of the steps, and of the choice of a first sheep.
const STEPS: u64 = 0;
const STARTS: u64 = 1;
/// 32-bit words of the stream that one step may use: one block.
const WORDS_OF_STEP: u128 = 16;

/// A walk on a flock.
#[derive(Clone, Debug)]
pub struct Walk {
    flock: Arc<Flock>,
    memory: Memory,
    /// Visits of each sheep, the present one included: sums of the ledger's counts.
    visits: Vec<u64>,
    runs: Runs,
    random: Random,
    /// The weight of a visit that was this many steps ago.
    fade: Box<[f64]>,
}

/// One transition.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Step {
    /// The transition taken.
    pub exit: Exit,
    /// Where it left.
    pub from: SheepIx,
    /// Its target: the sheep visited now.
    pub to: SheepIx,
}

impl Walk {
    /// A new walk. Its first sheep is drawn by the shares. `None` if `flock` has nothing to show.
    pub fn start(flock: Arc<Flock>, seed: u64) -> Option<Self> {
        let place = first_sheep(&flock, seed, 0)?;
        let memory = Memory::new(flock.graph(), seed, place);
        Some(Self::with(flock, memory))
    }

    /// The walk that `memory`, which fits `flock`, remembers.
    pub(crate) fn with(flock: Arc<Flock>, memory: Memory) -> Self {
        let graph = flock.graph();
        let mut visits: Vec<u64> = graph.sheep().map(|sheep| memory.ledger.left(graph, sheep)).collect();
        visits[memory.place.index()] += 1;
        let runs = Runs::of(&memory.recent);
        let random = Random::new(memory.seed);
        let fade = (0..16 * FADE_STEPS as u32).map(|gap| libm::exp(-f64::from(gap) / FADE_STEPS)).collect();
        Self { flock, memory, visits, runs, random, fade }
    }

    /// The sheep that is visited now.
    pub fn place(&self) -> SheepIx {
        self.memory.place
    }

    /// Steps taken since the walk began.
    pub fn steps(&self) -> u64 {
        self.memory.step
    }

    /// Visits of `sheep`, the present one included.
    pub fn visits(&self, sheep: SheepIx) -> u64 {
        self.visits[sheep.index()]
    }

    /// Its state.
    pub(crate) fn memory(&self) -> &Memory {
        &self.memory
    }

    /// Takes the next step. `None` if there is no exit.
    pub fn step(&mut self) -> Option<Step> {
        self.step_around(&BlockedClips::default())
    }

    /// Takes the next step without blocked exits. `None`, and nothing is changed, if all are blocked.
    ///
    /// A drawn exit that is blocked is counted as taken, and another one is shown instead: so credits stay bounded
    /// however long a clip is missing, and it does not come repeatedly when it is back.
    pub(crate) fn step_around(&mut self, blocked: &BlockedClips) -> Option<Step> {
        let (from, graph, ledger) = (self.place(), self.flock.graph(), &self.memory.ledger);
        let [first, second] = self.random.at(self.memory.step);
        let turn = draw(&self.odds(ledger.allowed(graph, from)), first)?;
        let exit = if blocked.is_unblocked(turn) {
            turn
        } else {
            let open = ledger.credits(graph, from).filter(|&(exit, _)| blocked.is_unblocked(exit));
            draw(&self.odds(open), second)?
        };
        let to = self.flock.graph().target(exit);
        self.memory.ledger.take(turn);
        self.memory.step += 1;
        self.memory.place = to;
        self.memory.last[to.index()] = self.memory.step;
        self.visits[to.index()] += 1;
        self.runs.push(&mut self.memory.recent, exit);
        Some(Step { exit, from, to })
    }

    /// The odds of exits of this place, given with their credits.
    fn odds(&self, credits: impl Iterator<Item = (Exit, f64)>) -> Vec<(Exit, f64)> {
        let mut odds: Vec<(Exit, f64)> = credits.collect();
        if odds.len() > 1 {
            let graph = self.flock.graph();
            let budget = (BUDGET_OF_DECISION / odds.len() as u32).min(BUDGET);
            let tail = Runs::tail(&self.memory.recent);
            for (exit, credit) in &mut odds {
                *credit = self.price(graph, *exit, *credit, tail, budget);
            }
            let least = odds.iter().map(|&(_, price)| price).fold(f64::INFINITY, f64::min);
            for (exit, price) in &mut odds {
                *price = graph.chance(*exit) * libm::exp((least - *price) / TEMPERATURE);
            }
        }
        odds
    }

    /// The cost of taking `exit` now: `q` of the study.
    fn price(&self, graph: &Graph, exit: Exit, credit: f64, tail: Option<u64>, mut budget: u32) -> f64 {
        let (memory, to) = (&self.memory, graph.target(exit));
        let seen = self.seen(to, memory.step + 1);
        let ahead = GAMMA * self.look(graph, to, memory.step + 2, DEPTH - 1, &mut budget);
        let due = (memory.step - memory.since + 1) as f64 * self.flock.share(to);
        let had = self.visits[to.index()] as f64 - memory.before[to.index()] as f64;
        let late = KAPPA * (due - had).clamp(-MAX_LATE, MAX_LATE);
        let owed = MU * (credit - 1.0).clamp(0.0, MAX_OWED);
        let walked = tail.is_some_and(|tail| self.runs.walked(tail, exit));
        seen + ahead - late - owed + if walked { NU } else { 0.0 }
    }

    /// The lowest cost of a path of `depth` steps from `sheep`, which is reached at `step`.
    fn look(&self, graph: &Graph, sheep: SheepIx, step: u64, depth: u32, budget: &mut u32) -> f64 {
        let mut least = f64::INFINITY;
        for exit in graph.exits(sheep) {
            if graph.chance(exit) < MIN_CHANCE {
                continue;
            }
            if *budget == 0 {
                break;
            }
            *budget -= 1;
            let to = graph.target(exit);
            let mut cost = self.seen(to, step);
            if depth > 1 && cost < least {
                cost += GAMMA * self.look(graph, to, step + 1, depth - 1, budget);
            }
            least = least.min(cost);
        }
        if least.is_finite() { least } else { 0.0 }
    }

    /// How strongly `sheep` is still remembered at `step`: 1 just now, 0 long ago or never.
    fn seen(&self, sheep: SheepIx, step: u64) -> f64 {
        match self.memory.last[sheep.index()] {
            NEVER => 0.0,
            last => usize::try_from(step - last).ok().and_then(|gap| self.fade.get(gap)).copied().unwrap_or(0.0),
        }
    }
}

/// The sheep with which a walk begins at `step`, drawn from the shares.
pub(crate) fn first_sheep(flock: &Flock, seed: u64, step: u64) -> Option<SheepIx> {
    let mut random = Random::new(seed);
    random.0.set_stream(STARTS);
    let [chance, _] = random.at(step);
    let shares: Vec<_> = flock.graph().sheep().map(|sheep| (sheep, flock.share(sheep))).collect();
    draw(&shares, chance)
}

/// The option that `chance`, from 0 up to 1, selects.
fn draw<T: Copy>(odds: &[(T, f64)], chance: f64) -> Option<T> {
    let total: f64 = odds.iter().map(|&(_, odd)| odd).sum();
    let mut left = chance * total;
    for &(option, odd) in odds {
        if left < odd {
            return Some(option);
        }
        left -= odd;
    }
    odds.last().map(|&(option, _)| option)
}

/// Numbers that are a function of (seed, step): `ChaCha12` at a position.
#[derive(Clone, Debug)]
struct Random(ChaCha12Rng);

impl Random {
    fn new(seed: u64) -> Self {
        let mut key = [0; 32];
        key[..8].copy_from_slice(&seed.to_le_bytes());
        key[8..].copy_from_slice(KEY);
        let mut random = ChaCha12Rng::from_seed(key);
        random.set_stream(STEPS);
        Self(random)
    }

    /// Two numbers from 0 up to 1: the highest 53 bits of the step's first two pairs of words.
    fn at(&mut self, step: u64) -> [f64; 2] {
        self.0.set_word_pos(u128::from(step) * WORDS_OF_STEP);
        [(); 2].map(|()| (self.0.next_u64() >> 11) as f64 / (1u64 << 53) as f64)
    }
}
