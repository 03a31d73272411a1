//! Both matings of two expressions.
//!
//! Owns how a child comes of two parents. Parents with different roots have nothing in common by the first way; then, and
//! often otherwise, the second is taken. Never judges a picture.
//!
//! Start at [`Genome::crossed`].
//!
//! # Source
//! Sims, *Artificial Evolution for Computer Graphics* (1991), section 4.3.

use ::species::Rng;

use crate::functions::Wants;
use crate::genome::Genome;
use crate::node::Node;

/// The most nodes of a child.
const MOST_NODES: usize = 400;
/// How often a child that is too large is bred again.
const TRIES: usize = 20;
/// How often the first way is taken, where so many nodes are shared.
const FIRST_WAY: f64 = 0.4;
const FIRST_WAY_SHARES: usize = 3;

/// How a child came of its parents.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mating {
    /// Both were walked together; where they differ, either side was taken.
    Walked,
    /// A node of the one was replaced by a node of the other.
    Grafted,
}

impl Genome {
    /// A child of two parents in this one's frame, and how it came about; none where every child
    /// would be too large or too slow.
    pub fn crossed(&self, with: &Genome, rng: &mut Rng) -> Option<(Genome, Mating)> {
        let pair = [&self.picture, &with.picture];
        let walks = shared(pair[0], pair[1]) >= FIRST_WAY_SHARES && rng.unit() < FIRST_WAY;
        let mating = if walks { Mating::Walked } else { Mating::Grafted };
        let child = |_: usize| match mating {
            Mating::Walked => walked(pair[0], pair[1], &mut || rng.unit() < 0.5),
            Mating::Grafted => {
                let into = rng.below(2);
                let (host, guest) = (pair[into], pair[1 - into]);
                let (places, nodes) = (places(host), guest.all());
                let (place, node) = (places[rng.below(places.len())], nodes[rng.below(nodes.len())]);
                host.with(place, node)
            }
        };
        let mut children = (0..TRIES).map(child).map(|picture| Genome { picture, ..self.clone() });
        let child = children.find(|child| child.picture.size() <= MOST_NODES && child.is_sound())?;
        Some((child, mating))
    }
}

/// Both trees walked together: where they differ, the second is taken if `takes_second` says so.
fn walked(a: &Node, b: &Node, takes_second: &mut impl FnMut() -> bool) -> Node {
    match (a, b) {
        (Node::Call(f, left), Node::Call(g, right)) if f == g => {
            Node::Call(f, left.iter().zip(right).map(|(a, b)| walked(a, b, takes_second)).collect())
        }
        _ if a == b => a.clone(),
        _ if takes_second() => b.clone(),
        _ => a.clone(),
    }
}

/// Nodes that are the same when both trees are walked together.
fn shared(a: &Node, b: &Node) -> usize {
    match (a, b) {
        (Node::Call(f, left), Node::Call(g, right)) if f == g => {
            1 + left.iter().zip(right).map(|(a, b)| shared(a, b)).sum::<usize>()
        }
        _ => usize::from(a == b),
    }
}

/// The numbers of all nodes that may be replaced: seeds stay.
fn places(of: &Node) -> Vec<usize> {
    let mut seeds = vec![false];
    let all = of.all();
    // As `all` goes, each node before its arguments: what is known of arguments is put where they will be.
    for at in 0..all.len() {
        let Node::Call(function, arguments) = all[at] else { continue };
        let mut first = at + 1;
        seeds.resize(seeds.len().max(at + all[at].size()), false);
        for (argument, node) in function.arguments.iter().zip(arguments) {
            let is_seed = argument.wants == Wants::Seed || seeds[at];
            seeds[first] = is_seed;
            first += node.size();
        }
    }
    (0..all.len()).filter(|at| !seeds[*at]).collect()
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    fn pair() -> [Node; 2] {
        ["(* (abs x) (mod x y))", "(* (/ y x) (* x -.7))"].map(|text| Node::parse(text).unwrap())
    }

    #[test]
    fn the_papers_pair_has_four_children_and_sixty_one() {
        let [a, b] = pair();
        let mut children = BTreeSet::new();
        for choices in 0..16_u32 {
            let mut choices = (0..4).map(|bit| choices >> bit & 1 == 1);
            children.insert(walked(&a, &b, &mut || choices.next().unwrap()).to_string());
        }
        assert_eq!(children.len(), 4, "{children:?}");
        assert!([&a, &b].iter().all(|parent| children.contains(&parent.to_string())));

        let grafts = |host: &Node, guest: &Node| -> Vec<String> {
            let places = places(host);
            places.iter().flat_map(|at| guest.all().into_iter().map(|node| host.with(*at, node).to_string())).collect()
        };
        let children: BTreeSet<String> = grafts(&a, &b).into_iter().chain(grafts(&b, &a)).collect();
        assert_eq!(children.len(), 61, "{children:?}");
        assert!([&a, &b].iter().all(|parent| children.contains(&parent.to_string())));
    }

    #[test]
    fn chance_brings_every_child_of_the_pair_and_no_other() {
        let [a, b] = pair().map(Genome::from);
        let mut rng = Rng::stream(1, 0);
        let mut grafted = BTreeSet::new();
        for _ in 0..5000 {
            let (child, mating) = a.crossed(&b, &mut rng).unwrap();
            assert_eq!(mating, Mating::Grafted, "only the root is shared");
            grafted.insert(child.picture.to_string());
        }
        assert_eq!(grafted.len(), 61);
    }

    #[test]
    fn parents_with_different_roots_have_nothing_new_by_the_first_way() {
        let (a, b) = (Node::parse("(+ x y)").unwrap(), Node::parse("(- x y)").unwrap());
        for takes in [false, true] {
            let child = walked(&a, &b, &mut || takes);
            assert_eq!(&child, if takes { &b } else { &a });
        }
    }

    #[test]
    fn seeds_are_not_replaced() {
        let node = Node::parse("(+ (bw-noise (* x 2) (+ 3 4)) y)").unwrap();
        assert_eq!(places(&node), [0, 1, 2, 3, 4, 8]);
    }
}
