//! Sparse elimination of sheep from a chain.
//!
//! Sheep with the fewest paths through them are eliminated first, and every path through one becomes a direct
//! probability, so that the rest is visited in the same proportions. There is no subtraction, so that each share is
//! accurate to the last bits.
//!
//! Start at [`Reduction::of`].

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::chain::{Chain, keep_in_range};
use super::dense;

/// A small chain is solved as a dense matrix if at least this part of it is not 0.
const DENSE_PART: usize = 4;

/// How far a chain is reduced.
#[derive(Clone, Copy, Debug)]
pub(super) struct Limits {
    /// The most paths through a sheep that is eliminated.
    pub(super) ways: usize,
    /// The most new probabilities in total, which limits time and memory.
    pub(super) work: usize,
}

/// A chain without some of its sheep.
#[derive(Debug)]
pub(super) struct Reduction {
    /// The rest.
    pub(super) core: Chain,
    /// Which sheep of the whole chain are left, by their numbers in the core.
    pub(super) kept: Vec<u32>,
    /// Those that are gone, in the order of going.
    gone: Vec<u32>,
    /// Where the visits that each of them got come from: starts in the two tables below, and the end.
    first: Vec<usize>,
    from: Vec<u32>,
    /// Visits of the gone sheep for each of the source's.
    part: Vec<f64>,
}

/// A chain while sheep are being taken out of it.
struct Elimination {
    out: Vec<Vec<(u32, f64)>>,
    into: Vec<Vec<u32>>,
    /// Sheep by the number of paths through them; outdated entries are skipped.
    next: BinaryHeap<Reverse<(usize, u32)>>,
    is_gone: Vec<bool>,
    /// Where a sheep stands in the exits at hand, counted from 1; 0 if it does not.
    mark: Vec<u32>,
    left: usize,
    arcs: usize,
}

impl Reduction {
    /// Takes sheep out of `chain` within `limits`, or until those left are few enough for a full matrix.
    ///
    /// # Source
    /// Grassmann, Taksar & Heyman (1985), in the order of Markowitz (1957).
    pub(super) fn of(chain: &Chain, limits: Limits) -> Self {
        let mut open = Elimination::new(chain);
        let core = Chain::new(0, std::iter::empty);
        let (kept, gone) = (Vec::new(), Vec::new());
        let mut reduction = Self { core, kept, gone, first: vec![0], from: Vec::new(), part: Vec::new() };
        let mut work = 0;
        while let Some((ways, sheep)) = open.next_sheep() {
            work += ways;
            if ways > limits.ways || work > limits.work || open.left == 1 || open.is_full() {
                break;
            }
            open.take_out(sheep, &mut reduction);
        }
        reduction.kept = (0..chain.len() as u32).filter(|&sheep| !open.is_gone[sheep as usize]).collect();
        let mut number = vec![0; chain.len()];
        for (at, &sheep) in (0..).zip(&reduction.kept) {
            number[sheep as usize] = at;
        }
        let exits = |&sheep: &u32| {
            let numbered = |&(to, chance): &(u32, f64)| (number[sheep as usize], number[to as usize], chance);
            open.out[sheep as usize].iter().map(numbered).collect::<Vec<_>>()
        };
        reduction.core = Chain::new(reduction.kept.len(), || reduction.kept.iter().flat_map(exits));
        reduction
    }

    /// The shares of the whole chain for those of its core, not normalised.
    pub(super) fn put_back(&self, core: &[f64]) -> Vec<f64> {
        let mut shares = vec![0.0; self.kept.len() + self.gone.len()];
        for (&sheep, &share) in self.kept.iter().zip(core) {
            shares[sheep as usize] = share;
        }
        for (number, &sheep) in self.gone.iter().enumerate().rev() {
            let row = self.first[number]..self.first[number + 1];
            let of = |at: usize| shares[self.from[at] as usize] * self.part[at];
            shares[sheep as usize] = row.map(of).sum();
            keep_in_range(&mut shares, sheep as usize);
        }
        shares
    }
}

impl Elimination {
    fn new(chain: &Chain) -> Self {
        let n = chain.len();
        let (mut out, mut into) = (vec![Vec::new(); n], vec![Vec::new(); n]);
        for (from, to, chance) in chain.arcs() {
            out[from].push((to as u32, chance));
            into[to].push(from as u32);
        }
        let mut open = Self {
            out,
            into,
            next: BinaryHeap::new(),
            is_gone: vec![false; n],
            mark: vec![0; n],
            left: n,
            arcs: chain.arc_count(),
        };
        open.next = (0..n as u32).map(|sheep| Reverse((open.ways(sheep), sheep))).collect();
        open
    }

    /// The number of paths through `sheep`.
    fn ways(&self, sheep: u32) -> usize {
        self.out[sheep as usize].len() * self.into[sheep as usize].len()
    }

    /// The sheep with the fewest paths through it, and their number.
    fn next_sheep(&mut self) -> Option<(usize, u32)> {
        while let Some(Reverse((ways, sheep))) = self.next.pop() {
            if !self.is_gone[sheep as usize] && ways == self.ways(sheep) {
                return Some((ways, sheep));
            }
        }
        None
    }

    /// Whether what is left is better solved as a full matrix.
    fn is_full(&self) -> bool {
        self.left <= dense::MOST && self.arcs * DENSE_PART > self.left * self.left
    }

    /// Takes `sheep` out and tells `reduction` where its visits came from.
    fn take_out(&mut self, sheep: u32, reduction: &mut Reduction) {
        let exits = std::mem::take(&mut self.out[sheep as usize]);
        let sources = std::mem::take(&mut self.into[sheep as usize]);
        let leaving: f64 = exits.iter().map(|&(_, chance)| chance).sum();
        for &(to, _) in &exits {
            let into = &mut self.into[to as usize];
            let at = into.iter().position(|&from| from == sheep).expect("an exit is known where it leads");
            into.swap_remove(at);
        }
        self.arcs -= exits.len() + sources.len();
        for &from in &sources {
            let at = self.out[from as usize].iter().position(|&(to, _)| to == sheep).expect("and where it starts");
            let part = self.out[from as usize].swap_remove(at).1 / leaving;
            reduction.from.push(from);
            reduction.part.push(part);
            self.pass_on(from, part, &exits);
        }
        reduction.gone.push(sheep);
        reduction.first.push(reduction.from.len());
        self.is_gone[sheep as usize] = true;
        self.left -= 1;
        for at in exits.iter().map(|&(to, _)| to).chain(sources) {
            let ways = self.ways(at);
            self.next.push(Reverse((ways, at)));
        }
    }

    /// Lets `from` go the ways of `exits` itself, with `part` of their chances.
    fn pass_on(&mut self, from: u32, part: f64, exits: &[(u32, f64)]) {
        let out = &mut self.out[from as usize];
        for (at, &(to, _)) in (1..).zip(out.iter()) {
            self.mark[to as usize] = at;
        }
        for &(to, chance) in exits.iter().filter(|&&(to, _)| to != from) {
            match self.mark[to as usize] {
                0 => {
                    out.push((to, part * chance));
                    self.into[to as usize].push(from);
                    self.arcs += 1;
                }
                at => out[at as usize - 1].1 += part * chance,
            }
        }
        for &(to, _) in out.iter() {
            self.mark[to as usize] = 0;
        }
    }
}
