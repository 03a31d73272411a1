//! The structure of a graph: its strongly connected classes, which of them can be played, their period.
//!
//! Computes it in time and space linear in the graph. Weights do not matter.
//!
//! Start at [`Structure::of`].

use std::cmp::Reverse;

use super::{Exit, Graph, SheepIx};

/// The strongly connected classes of a graph: two sheep share one exactly if each can be reached from the other.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Structure {
    class: Vec<u32>,
    count: usize,
    playable: Vec<Vec<SheepIx>>,
}

impl Structure {
    /// The structure of `graph`.
    pub fn of(graph: &Graph) -> Self {
        let class = classes(graph.rows(), |exit| graph.target(Exit(exit as u32)).index());
        let count = class.iter().max().map_or(0, |&last| last as usize + 1);
        let mut playable = vec![Vec::new(); count];
        for sheep in graph.sheep() {
            playable[class[sheep.index()] as usize].push(sheep);
        }
        playable.retain(|sheep| sheep.len() > 1 || graph.between(sheep[0], sheep[0]).is_some());
        playable.sort_by_key(|sheep| (Reverse(sheep.len()), sheep[0]));
        Self { class, count, playable }
    }

    /// How many classes there are; 1 if every sheep can be reached from every other.
    pub fn class_count(&self) -> usize {
        self.count
    }

    /// The class of `sheep`, counted from 0 so that every transition between two classes leads to the lower number.
    pub fn class_of(&self, sheep: SheepIx) -> usize {
        self.class[sheep.index()] as usize
    }

    /// The classes that have a cycle, each in the order of ids; the largest first, of equal ones that with the lowest id
    /// first. The walk lives in the first.
    pub fn playable(&self) -> &[Vec<SheepIx>] {
        &self.playable
    }

    /// The period of `graph`, whose structure this is: the greatest common divisor of the lengths of its cycles, in
    /// steps. Above 1 its sheep form this many groups that are visited in turn. 0 if there is no cycle.
    ///
    /// # Source
    /// Denardo, *Periods of connected networks and powers of nonnegative matrices* (1977).
    pub fn period(&self, graph: &Graph) -> u32 {
        let (mut period, mut level, mut open) = (0, vec![None; graph.len()], Vec::new());
        for root in self.playable.iter().map(|class| class[0]) {
            level[root.index()] = Some(0u32);
            open.push(root);
            while let Some(from) = open.pop() {
                let next = level[from.index()].map_or(0, |at| at + 1);
                let inside = graph.exits(from).map(|exit| graph.target(exit));
                for to in inside.filter(|&to| self.class_of(to) == self.class_of(root)) {
                    if let Some(at) = level[to.index()] {
                        period = common(period, next.abs_diff(at));
                    } else {
                        level[to.index()] = Some(next);
                        open.push(to);
                    }
                }
            }
        }
        period
    }
}

/// The greatest common divisor; 0 divides nothing and is divided by all.
fn common(a: u32, b: u32) -> u32 {
    if b == 0 { a } else { common(b, a % b) }
}

/// The class of each node, whose exits start in their table at `first`, counted so that every exit between two classes
/// leads to the lower number.
///
/// # Source
/// Tarjan, *Depth-first search and linear graph algorithms* (1972), without recursion.
pub(crate) fn classes(first: &[u32], target: impl Fn(usize) -> usize) -> Vec<u32> {
    const UNSEEN: u32 = u32::MAX;
    let n = first.len() - 1;
    let (mut seen, mut low, mut class) = (vec![UNSEEN; n], vec![0; n], vec![UNSEEN; n]);
    let (mut stack, mut trail): (Vec<u32>, Vec<(u32, u32)>) = (Vec::new(), Vec::new());
    let (mut count, mut classes) = (0, 0);
    for root in 0..n {
        if seen[root] != UNSEEN {
            continue;
        }
        trail.push((root as u32, first[root]));
        while let Some(top) = trail.last_mut() {
            let (sheep, next) = *top;
            let at = sheep as usize;
            top.1 += 1;
            if next == first[at] && seen[at] == UNSEEN {
                seen[at] = count;
                low[at] = count;
                count += 1;
                stack.push(sheep);
            }
            if next < first[at + 1] {
                let to = target(next as usize);
                if seen[to] == UNSEEN {
                    trail.push((to as u32, first[to]));
                } else if class[to] == UNSEEN {
                    low[at] = low[at].min(seen[to]);
                }
                continue;
            }
            trail.pop();
            if let Some(&(parent, _)) = trail.last() {
                low[parent as usize] = low[parent as usize].min(low[at]);
            }
            if low[at] == seen[at] {
                while let Some(member) = stack.pop() {
                    class[member as usize] = classes;
                    if member == sheep {
                        break;
                    }
                }
                classes += 1;
            }
        }
    }
    class
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::graph::tests::manifest;
    use proptest::prelude::*;

    /// Which sheep reach which, by the definition.
    fn reaches(n: usize, arcs: &[(usize, usize, f64)]) -> Vec<Vec<bool>> {
        let mut reach = vec![vec![false; n]; n];
        for &(from, to, _) in arcs {
            reach[from][to] = true;
        }
        for via in 0..n {
            for from in 0..n {
                for to in 0..n {
                    reach[from][to] |= reach[from][via] && reach[via][to];
                }
            }
        }
        reach
    }

    fn ring(length: usize) -> Vec<(usize, usize, f64)> {
        (0..length).map(|at| (at, (at + 1) % length, 1.0)).collect()
    }

    #[test]
    fn the_largest_class_with_a_cycle_comes_first() {
        let arcs = [(0, 1, 1.0), (1, 0, 1.0), (1, 2, 1.0), (2, 3, 1.0), (3, 4, 1.0), (4, 2, 1.0), (4, 5, 1.0)];
        let structure = Structure::of(&Graph::new(&manifest(6, &arcs)));
        assert_eq!(structure.playable(), [vec![SheepIx(2), SheepIx(3), SheepIx(4)], vec![SheepIx(0), SheepIx(1)]]);
    }

    #[test]
    fn the_beat_is_what_all_cycles_have_in_common() {
        let period = |n: usize, arcs: &[(usize, usize, f64)]| {
            let graph = Graph::new(&manifest(n, arcs));
            Structure::of(&graph).period(&graph)
        };
        assert_eq!(period(6, &ring(6)), 6);
        assert_eq!(period(6, &[ring(6), vec![(1, 0, 1.0)]].concat()), 2);
        assert_eq!(period(6, &[ring(6), vec![(2, 0, 1.0), (3, 0, 1.0)]].concat()), 1);
        assert_eq!(period(1, &[(0, 0, 1.0)]), 1);
        assert_eq!(period(3, &[(0, 1, 1.0), (1, 2, 1.0)]), 0);
        // Two classes that one transition joins, with beats of 2 and 3.
        let joined = [(0, 1, 1.0), (1, 0, 1.0), (1, 2, 1.0), (2, 3, 1.0), (3, 4, 1.0), (4, 2, 1.0)];
        assert_eq!(period(5, &joined), 1);
    }

    proptest! {
        #[test]
        fn two_sheep_share_a_class_exactly_if_each_reaches_the_other(
            arcs in prop::collection::vec((0usize..9, 0usize..9, Just(1.0)), 0..20),
        ) {
            let graph = Graph::new(&manifest(9, &arcs));
            let (class, reach) = (Structure::of(&graph).class, reaches(9, &arcs));
            for a in 0..9 {
                for b in 0..9 {
                    prop_assert_eq!(class[a] == class[b], a == b || (reach[a][b] && reach[b][a]));
                    prop_assert!(class[a] >= class[b] || !reach[a][b]);
                }
            }
        }
    }
}
