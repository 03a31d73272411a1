//! Whether the wants can be reached with any weights, and the bottleneck if not.
//!
//! Owns the integer maximum flow from sheep as sources to sheep as targets, and the minimum cut that proves it. Weights
//! do not matter: reachability depends only on transitions and wants.
//!
//! # Source
//! Gale (1957): the wants can be met exactly if no set of sheep is wanted more than all its followers together. The
//! flow is Dinic's (1970), with the distances measured from the sink.

use std::collections::VecDeque;

use super::bypass::Bypassed;
use super::exact;
use super::network::Network;
use crate::graph::classes;

/// The sum of all wants in units of the flow: an `f64` want down to 2^-47 of the sum is exact.
const WHOLE: f64 = (1u128 << 100) as f64;
/// Wants count as reachable within this relative error, which is that of their floating-point numbers.
pub(super) const GIVE: i128 = 1_000_000_000;
/// Not reached by the search.
const FAR: u32 = u32::MAX;

/// What the flock's transitions can carry.
#[derive(Clone, Debug)]
pub(super) struct Reach {
    /// The share of the wants that no weights can meet; exactly 0 if it is only rounding.
    pub(super) deficiency: f64,
    /// Sheep that are wanted more than all sheep that they lead to: the minimum cut. Empty if the deficiency is 0.
    pub(super) bottleneck: Vec<usize>,
    /// Whether each transition can carry anything at all when the wants are met exactly. All of them if they can't be.
    pub(super) carries: Vec<bool>,
}

/// A flow from rows (sheep as they are left) to columns (sheep as they are entered).
pub(super) struct Transport<'n> {
    network: &'n Network,
    /// Transitions sorted by where they end, and where each sheep's start.
    entries: Vec<u32>,
    first_entry: Vec<u32>,
    pub(super) flow: Vec<i128>,
    /// What each transition can carry at most, where there are limits.
    limits: Option<Vec<i128>>,
    /// The remaining supply of rows and demand of columns.
    unsent: Vec<i128>,
    room: Vec<i128>,
    /// Steps to a column with room, rows first.
    distance: Vec<u32>,
    /// Where the search in each node goes on.
    next: Vec<u32>,
}

impl Reach {
    /// What the transitions of `network` can carry of its wants. `hint` is a circulation: the search starts there.
    pub(super) fn of(network: &Network, hint: &[f64]) -> Self {
        let n = network.len();
        // What is not needed of a sheep of which nothing is wanted passes it by.
        let is_free = |sheep| network.is_free(sheep);
        let wide = (0..n).any(is_free).then(|| Bypassed::of(network, is_free));
        let (all, start) = match &wide {
            Some(wide) => (&wide.network, Some(wide.widened(network, hint, 0.0))),
            None => (network, None),
        };
        let wants = all.want.iter().map(|&want| units(want)).collect();
        let mut transport = Transport::new(all, wants, None, start.as_deref().unwrap_or(hint));
        let missing = transport.fill();
        let bottleneck = transport.stuck();
        let mut reachable = missing == 0;
        if !reachable && missing <= WHOLE as i128 / GIVE && exact::is_there(network, hint) {
            for sheep in 0..n {
                transport.room[sheep] += units(network.want[sheep]) / GIVE;
            }
            reachable = transport.fill() == 0;
        }
        if reachable {
            let all = transport.carriers();
            let carries = if let Some(wide) = &wide { playable(network, wide.own(&all)) } else { all };
            return Self { deficiency: 0.0, bottleneck: Vec::new(), carries };
        }
        let wanted = if wide.is_some() { network.wanted() } else { 1.0 };
        Self { deficiency: missing as f64 / WHOLE / wanted, bottleneck, carries: vec![true; network.arcs()] }
    }
}

/// `carries`, but for sheep that would no longer be entered or left: nothing is wanted of them, and the search takes all
/// their transitions.
fn playable(network: &Network, mut carries: Vec<bool>) -> Vec<bool> {
    let n = network.len();
    let mut taken = vec![[false; 2]; n];
    for arc in (0..network.arcs()).filter(|&arc| carries[arc]) {
        let (from, to) = network.ends(arc);
        (taken[from][0], taken[to][1]) = (true, true);
    }
    for (arc, carries) in carries.iter_mut().enumerate() {
        let (from, to) = network.ends(arc);
        *carries |= [from, to].iter().any(|&sheep| taken[sheep] != [true, true]);
    }
    carries
}

/// A share in whole units.
pub(super) fn units(share: f64) -> i128 {
    (share * WHOLE) as i128
}

impl<'n> Transport<'n> {
    /// Nothing but what `hint` sends, of `wants` from every row and to every column, along transitions with `limits` if any.
    pub(super) fn new(network: &'n Network, wants: Vec<i128>, limits: Option<Vec<i128>>, hint: &[f64]) -> Self {
        let n = network.len();
        let mut first_entry = vec![0; n + 1];
        for &to in &network.to {
            first_entry[to as usize + 1] += 1;
        }
        for at in 1..=n {
            first_entry[at] += first_entry[at - 1];
        }
        let mut next = first_entry.clone();
        let mut entries = vec![0; network.arcs()];
        for arc in 0..network.arcs() {
            let at = &mut next[network.to[arc] as usize];
            entries[*at as usize] = arc as u32;
            *at += 1;
        }
        let mut transport = Self {
            network,
            entries,
            first_entry,
            flow: vec![0; network.arcs()],
            limits,
            unsent: wants.clone(),
            room: wants,
            distance: vec![FAR; 2 * n],
            next: vec![0; 2 * n],
        };
        transport.start(hint);
        transport
    }

    /// Sends what the hint sends as far as both ends allow, then whatever still goes directly.
    fn start(&mut self, hint: &[f64]) {
        let n = self.network.len();
        let (mut sent, mut taken) = (vec![0.0; n], vec![0.0; n]);
        for (arc, &flow) in hint.iter().enumerate() {
            let (from, to) = self.network.ends(arc);
            sent[from] += flow;
            taken[to] += flow;
        }
        let want = &self.network.want;
        for (arc, &flow) in hint.iter().enumerate() {
            let (from, to) = self.network.ends(arc);
            let fits = (want[from] / sent[from]).min(want[to] / taken[to]);
            self.send(arc, units((flow * fits).clamp(0.0, 1.0)));
        }
        for arc in 0..self.network.arcs() {
            self.send(arc, i128::MAX);
        }
    }

    fn limit(&self, arc: usize) -> i128 {
        self.limits.as_ref().map_or(i128::MAX, |limits| limits[arc])
    }

    /// Sends up to `amount` along one transition.
    fn send(&mut self, arc: usize, amount: i128) {
        let (from, to) = self.network.ends(arc);
        let amount = amount.min(self.limit(arc) - self.flow[arc]).min(self.unsent[from]).min(self.room[to]);
        self.flow[arc] += amount;
        self.unsent[from] -= amount;
        self.room[to] -= amount;
    }

    /// Sends all that can be sent; returns what cannot.
    pub(super) fn fill(&mut self) -> i128 {
        let n = self.network.len();
        while self.measure() {
            for row in 0..n {
                self.next[row] = self.network.first[row];
                self.next[n + row] = self.first_entry[row];
            }
            let mut path = Vec::new();
            for row in 0..n {
                while self.unsent[row] > 0 && self.distance[row] != FAR && self.trace(row, &mut path) {
                    self.augment(row, &path);
                }
            }
        }
        self.unsent.iter().sum()
    }

    /// Computes the distance of every node from a column with remaining demand; whether a row with supply reaches one.
    fn measure(&mut self) -> bool {
        let n = self.network.len();
        self.distance.fill(FAR);
        let mut open = VecDeque::new();
        for column in (0..n).filter(|&column| self.room[column] > 0) {
            self.distance[n + column] = 0;
            open.push_back(n + column);
        }
        let (mut found, mut deepest) = (false, FAR);
        while let Some(node) = open.pop_front() {
            let beyond = self.distance[node] + 1;
            if beyond > deepest {
                break;
            }
            if node >= n {
                for at in self.first_entry[node - n]..self.first_entry[node - n + 1] {
                    let arc = self.entries[at as usize] as usize;
                    let row = self.network.from[arc] as usize;
                    if self.distance[row] == FAR && self.flow[arc] < self.limit(arc) {
                        self.distance[row] = beyond;
                        open.push_back(row);
                        if self.unsent[row] > 0 {
                            (found, deepest) = (true, beyond);
                        }
                    }
                }
            } else {
                for arc in self.network.exits(node) {
                    let column = n + self.network.to[arc] as usize;
                    if self.flow[arc] > 0 && self.distance[column] == FAR {
                        self.distance[column] = beyond;
                        open.push_back(column);
                    }
                }
            }
        }
        found
    }

    /// Searches an augmenting path from `row` to a column with remaining demand, along falling distances, with forward
    /// and backward edges alternating.
    fn trace(&mut self, row: usize, path: &mut Vec<u32>) -> bool {
        let n = self.network.len();
        path.clear();
        let mut node = row;
        loop {
            let nearer = self.distance[node].wrapping_sub(1);
            let mut step = None;
            if node < n {
                while self.next[node] < self.network.first[node + 1] {
                    let arc = self.next[node];
                    let column = n + self.network.to[arc as usize] as usize;
                    if self.distance[column] == nearer && self.flow[arc as usize] < self.limit(arc as usize) {
                        step = Some((arc, column));
                        break;
                    }
                    self.next[node] += 1;
                }
            } else {
                if self.room[node - n] > 0 {
                    return true;
                }
                while self.next[node] < self.first_entry[node - n + 1] {
                    let arc = self.entries[self.next[node] as usize];
                    let back = self.network.from[arc as usize] as usize;
                    if self.flow[arc as usize] > 0 && self.distance[back] == nearer {
                        step = Some((arc, back));
                        break;
                    }
                    self.next[node] += 1;
                }
            }
            if let Some((arc, to)) = step {
                path.push(arc);
                node = to;
                continue;
            }
            self.distance[node] = FAR;
            let Some(arc) = path.pop() else { return false };
            let (from, to) = self.network.ends(arc as usize);
            node = if node >= n { from } else { n + to };
            self.next[node] += 1;
        }
    }

    /// Sends as much as `path` from `row` can bear.
    fn augment(&mut self, row: usize, path: &[u32]) {
        let bears = |(step, &arc): (usize, &u32)| {
            let (flow, limit) = (self.flow[arc as usize], self.limit(arc as usize));
            if step % 2 == 0 { limit - flow } else { flow }
        };
        let last = self.network.ends(path[path.len() - 1] as usize).1;
        let amount = path.iter().enumerate().map(bears).fold(self.unsent[row].min(self.room[last]), i128::min);
        for (step, &arc) in path.iter().enumerate() {
            self.flow[arc as usize] += if step % 2 == 0 { amount } else { -amount };
        }
        self.unsent[row] -= amount;
        self.room[last] -= amount;
    }

    /// The rows that have something left to send, and all from which these could take back what they send: what they
    /// want is more than all columns that they lead to can take.
    fn stuck(&self) -> Vec<usize> {
        let n = self.network.len();
        let mut stuck: Vec<bool> = self.unsent.iter().map(|&unsent| unsent > 0).collect();
        let mut open: Vec<usize> = (0..n).filter(|&row| stuck[row]).collect();
        let mut met = vec![false; n];
        while let Some(row) = open.pop() {
            for arc in self.network.exits(row) {
                let column = self.network.to[arc] as usize;
                if std::mem::replace(&mut met[column], true) {
                    continue;
                }
                for &entry in &self.entries[self.first_entry[column] as usize..self.first_entry[column + 1] as usize] {
                    let back = self.network.from[entry as usize] as usize;
                    if self.flow[entry as usize] > 0 && !std::mem::replace(&mut stuck[back], true) {
                        open.push(back);
                    }
                }
            }
        }
        (0..n).filter(|&row| stuck[row]).collect()
    }

    /// Whether each transition carries something, or could: then a cycle of transitions taken and taken back leads
    /// through it. What is no more than the give of its ends is nothing.
    fn carriers(&self) -> Vec<bool> {
        let n = self.network.len();
        let real = |arc: usize| {
            let (from, to) = self.network.ends(arc);
            self.flow[arc] > 2 * units(self.network.want[from].min(self.network.want[to])) / GIVE
        };
        let class = self.residual_classes(&real);
        (0..self.network.arcs())
            .map(|arc| {
                let (from, to) = self.network.ends(arc);
                real(arc) || class[from] == class[n + to]
            })
            .collect()
    }

    /// The strongly connected classes of rows and columns: from a row along all its transitions, from a column back
    /// along those that carry something.
    fn residual_classes(&self, real: &impl Fn(usize) -> bool) -> Vec<u32> {
        let n = self.network.len();
        let mut first = self.network.first.clone();
        let mut target: Vec<u32> = self.network.to.iter().map(|to| n as u32 + to).collect();
        for column in 0..n {
            let entries = &self.entries[self.first_entry[column] as usize..self.first_entry[column + 1] as usize];
            let taken = entries.iter().filter(|&&arc| real(arc as usize));
            target.extend(taken.map(|&arc| self.network.from[arc as usize]));
            first.push(target.len() as u32);
        }
        classes(&first, |at| target[at] as usize)
    }
}
