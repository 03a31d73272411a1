//! The greatest flow, found in the plainest way.
//!
//! Owns a second opinion on what a flock's transitions can carry: augmenting paths by breadth-first search over a table
//! of all pairs, in whole numbers. Shares nothing with the balance, which it judges.

use std::collections::VecDeque;

use flock::{Flock, SheepIx};

/// All wants together.
const WHOLE: f64 = (1u128 << 90) as f64;

/// What share of `wants`, by the sheep of what `flock` plays, its transitions can carry: the greatest flow from every
/// sheep as it is left to every sheep as it is entered. A sheep whose want is 0 may be visited as often as it takes.
pub(crate) fn carried(flock: &Flock, wants: &[f64]) -> f64 {
    let n = wants.len();
    let (source, sink) = (2 * n, 2 * n + 1);
    let mut room = vec![vec![0i128; 2 * n + 2]; 2 * n + 2];
    for (at, want) in wants.iter().enumerate() {
        let units = if *want > 0.0 { (want * WHOLE) as i128 } else { WHOLE as i128 };
        (room[source][at], room[n + at][sink]) = (units, units);
        if *want == 0.0 {
            room[at][n + at] = i128::MAX / 4;
        }
    }
    let graph = flock.graph();
    for from in graph.sheep() {
        graph.exits(from).for_each(|exit| room[from.index()][n + graph.target(exit).index()] = i128::MAX / 4);
    }
    let mut carried = 0i128;
    while let Some(before) = path(&room, source, sink) {
        let steps = || std::iter::successors(Some(sink), |&at| Some(before[at])).take_while(|&at| at != source);
        let amount = steps().map(|at| room[before[at]][at]).min().unwrap();
        for at in steps() {
            room[before[at]][at] -= amount;
            room[at][before[at]] += amount;
        }
        carried += amount;
    }
    let free = wants.iter().filter(|want| **want == 0.0).count() as i128;
    (carried - free * WHOLE as i128) as f64 / WHOLE
}

/// For every node on the shortest way from `source` to `sink`, the one before it.
fn path(room: &[Vec<i128>], source: usize, sink: usize) -> Option<Vec<usize>> {
    let mut before = vec![usize::MAX; room.len()];
    before[source] = source;
    let mut open = VecDeque::from([source]);
    while let Some(at) = open.pop_front() {
        for to in 0..room.len() {
            if room[at][to] > 0 && before[to] == usize::MAX {
                before[to] = at;
                open.push_back(to);
            }
        }
    }
    (before[sink] != usize::MAX).then_some(before)
}

/// The sheep that those of `set` lead to.
pub(crate) fn followers(flock: &Flock, set: &[SheepIx]) -> Vec<SheepIx> {
    let graph = flock.graph();
    let mut all: Vec<SheepIx> = set.iter().flat_map(|&from| graph.exits(from).map(|exit| graph.target(exit))).collect();
    all.sort();
    all.dedup();
    all
}
