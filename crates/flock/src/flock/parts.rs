//! The parts into which a flock falls, and the transitions that would join them.
//!
//! Owns the proposal of `dreams prune`: which part to keep, which others there are, and the fewest transitions, called
//! bridges, that bring each of these in. Never edits: the tools do.
//!
//! Start at [`Parts::of`].
//!
//! # Source
//! Eswaran & Tarjan, *Augmentation problems* (1976): a graph is one part once every part without an entry and every part
//! without an exit has one, and one transition can be both.

use std::cmp::Reverse;

use super::Flock;
use crate::graph::{Graph, SheepIx, Structure};
use crate::manifest::SheepId;

/// A flock as its parts. In a part every sheep can be reached from every other.
#[derive(Clone, Debug, PartialEq)]
pub struct Parts {
    /// The sheep to keep, in the order of their ids: the part that is played, unless another one was asked for.
    pub kept: Vec<SheepId>,
    /// The first sheep of every other part that has a cycle and as many sheep.
    pub ties: Vec<SheepId>,
    /// The other parts, the largest first.
    pub others: Vec<Part>,
    /// The fewest bridges that bring all other parts in.
    pub fewest: usize,
}

/// A part that is not kept, and what would bring it in.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// Its sheep, in the order of their ids.
    pub sheep: Vec<SheepId>,
    /// The bridge from the kept part; `None` if a way leads from there already.
    pub entry: Option<Bridge>,
    /// The bridge to the kept part; `None` if a way leads there already.
    pub exit: Option<Bridge>,
}

/// A transition that the flock lacks.
#[derive(Clone, Debug, PartialEq)]
pub struct Bridge {
    /// Where it starts.
    pub from: SheepId,
    /// Where it ends.
    pub to: SheepId,
    /// Whether both have a genome, so that it can be rendered.
    pub can_be_rendered: bool,
}

/// Which parts of a flock lead to one of them, and which are led to, by their numbers in the structure.
struct Ways {
    leads: Vec<bool>,
    reached: Vec<bool>,
}

impl Parts {
    /// The parts of `flock`; the part with the sheep `with` is kept, or the one that is played. `None` if that has no
    /// cycle.
    pub fn of(flock: &Flock, with: Option<&SheepId>) -> Option<Self> {
        let whole = flock.whole();
        let structure = Structure::of(whole);
        let is_chosen = |class: &&Vec<SheepIx>| with.is_none_or(|id| class.iter().any(|&at| whole.id(at) == id));
        let kept = structure.playable().iter().find(is_chosen)?;
        let number = structure.class_of(kept[0]);
        let ties = structure.playable().iter().filter(|class| class.len() == kept.len() && class[0] != kept[0]);
        let mut others = vec![Vec::new(); structure.class_count()];
        for at in whole.sheep().filter(|&at| structure.class_of(at) != number) {
            others[structure.class_of(at)].push(at);
        }
        let ways = Ways::of(whole, &structure, number);
        let [most, least] = [true, false].map(|most| end(flock, kept, most));
        let bridge = |from: SheepIx, to: SheepIx| Bridge {
            from: whole.id(from).clone(),
            to: whole.id(to).clone(),
            can_be_rendered: has_genome(flock, from) && has_genome(flock, to),
        };
        let ids = |sheep: &[SheepIx]| sheep.iter().map(|&at| whole.id(at).clone()).collect::<Vec<_>>();
        let of = |(class, sheep): (usize, &Vec<SheepIx>)| {
            let own = sheep.iter().copied().find(|&at| has_genome(flock, at)).or(sheep.first().copied())?;
            let entry = (!ways.reached[class]).then(|| bridge(most, own));
            let exit = (!ways.leads[class]).then(|| bridge(own, least));
            Some(Part { sheep: ids(sheep), entry, exit })
        };
        let mut parts: Vec<Part> = others.iter().enumerate().filter_map(of).collect();
        parts.sort_by(|a, b| (Reverse(a.sheep.len()), &a.sheep[0]).cmp(&(Reverse(b.sheep.len()), &b.sheep[0])));
        let ties = ties.map(|class| whole.id(class[0]).clone()).collect();
        Some(Self { kept: ids(kept), ties, others: parts, fewest: fewest(whole, &structure) })
    }
}

impl Ways {
    /// The ways to and from the part `number`.
    fn of(graph: &Graph, structure: &Structure, number: usize) -> Self {
        let part = |at: SheepIx| structure.class_of(at);
        // Every transition between two parts leads to the lower number.
        let mut order: Vec<SheepIx> = graph.sheep().collect();
        order.sort_by_key(|&at| part(at));
        let mut ways =
            Self { leads: vec![false; structure.class_count()], reached: vec![false; structure.class_count()] };
        (ways.leads[number], ways.reached[number]) = (true, true);
        for &at in &order {
            ways.leads[part(at)] |= graph.exits(at).any(|exit| ways.leads[part(graph.target(exit))]);
        }
        for &at in order.iter().rev().filter(|&&at| part(at) <= number) {
            if ways.reached[part(at)] {
                graph.exits(at).for_each(|exit| ways.reached[part(graph.target(exit))] = true);
            }
        }
        ways
    }
}

impl Flock {
    /// Whether each sheep of the whole flock can be reached from the part that is played; those of it can.
    pub fn reached(&self) -> Vec<bool> {
        let whole = self.whole();
        let structure = Structure::of(whole);
        let Some(played) = structure.playable().first() else { return vec![false; whole.len()] };
        let ways = Ways::of(whole, &structure, structure.class_of(played[0]));
        whole.sheep().map(|at| ways.reached[structure.class_of(at)]).collect()
    }
}

/// The sheep of `part` where a bridge starts or ends: that which is shown most for its want, or least; one with a genome
/// if there is one.
fn end(flock: &Flock, part: &[SheepIx], most: bool) -> SheepIx {
    let share = |at: SheepIx| flock.graph().find(flock.whole().id(at)).map_or(0.0, |at| flock.share(at));
    let ratio = |at: SheepIx| share(at) / flock.manifest().sheep[flock.whole().sheep_in_manifest(at)].want;
    let sign = if most { -1.0 } else { 1.0 };
    let by_ratio = |a: &SheepIx, b: &SheepIx| (sign * ratio(*a)).total_cmp(&(sign * ratio(*b)));
    let rendered = part.iter().copied().filter(|&at| has_genome(flock, at)).min_by(by_ratio);
    rendered.or_else(|| part.iter().copied().min_by(by_ratio)).unwrap_or(part[0])
}

/// Whether a sheep of the whole flock has a genome.
fn has_genome(flock: &Flock, at: SheepIx) -> bool {
    flock.manifest().sheep[flock.whole().sheep_in_manifest(at)].genome.is_some()
}

/// How many transitions it takes at least until `graph` is one part.
fn fewest(graph: &Graph, structure: &Structure) -> usize {
    let count = structure.class_count();
    let (mut has_entry, mut has_exit) = (vec![false; count], vec![false; count]);
    for from in graph.sheep() {
        for to in graph.exits(from).map(|exit| graph.target(exit)) {
            let (from, to) = (structure.class_of(from), structure.class_of(to));
            has_exit[from] |= from != to;
            has_entry[to] |= from != to;
        }
    }
    let without = |has: &[bool]| has.iter().filter(|has| !**has).count();
    if count > 1 { without(&has_entry).max(without(&has_exit)) } else { 0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::edit::Edit;
    use crate::graph::tests::manifest;
    use crate::manifest::{Manifest, Transition};
    use proptest::prelude::*;
    use std::collections::BTreeSet;

    fn id(at: usize) -> SheepId {
        SheepId::new(&format!("s{at}")).unwrap()
    }

    /// `manifest` as it is when only the sheep `kept` are, edited in its text.
    fn pruned(manifest: &Manifest, kept: &[SheepId]) -> Manifest {
        let mut edit = Edit::blank(&manifest.name, manifest.size, manifest.fps);
        manifest.sheep.iter().for_each(|sheep| edit.add_sheep(sheep.clone()).unwrap());
        manifest.transitions.iter().for_each(|transition| edit.add_transition(transition.clone()).unwrap());
        let mut edit = Edit::parse(edit.text(), "flock.toml".as_ref()).unwrap();
        edit.keep_only(&kept.iter().cloned().collect());
        Edit::parse(edit.text(), "flock.toml".as_ref()).unwrap().manifest().clone()
    }

    fn with(manifest: &Manifest, bridges: impl IntoIterator<Item = Bridge>) -> Flock {
        let mut manifest = manifest.clone();
        let clip = manifest.transitions[0].clip.clone();
        let new = |Bridge { from, to, .. }: Bridge| Transition { from, to, clip: clip.clone(), weight: 1.0 };
        manifest.transitions.extend(bridges.into_iter().map(new));
        Flock::new(manifest)
    }

    #[test]
    fn a_part_needs_a_bridge_only_where_no_way_leads() {
        // A pair that is kept; a way out of it and a way into it; a part by itself, which two transitions join to both.
        let arcs = [(0, 1, 1.0), (1, 0, 1.0), (1, 2, 1.0), (2, 3, 1.0), (4, 5, 1.0), (5, 0, 1.0), (6, 6, 1.0)];
        let mut flock = manifest(7, &arcs);
        flock.sheep[1].genome = flock.sheep[1].clip.as_ref().map(|clip| clip.path.clone());
        flock.sheep[6].genome = flock.sheep[1].genome.clone();
        let parts = Parts::of(&Flock::new(flock), None).unwrap();
        let needs = |at: usize| {
            let part = parts.others.iter().find(|part| part.sheep == [id(at)]).unwrap();
            let told = |bridge: &Bridge| format!("{}>{} {}", bridge.from, bridge.to, bridge.can_be_rendered);
            (part.entry.as_ref().map(told), part.exit.as_ref().map(told))
        };
        assert_eq!((parts.kept.as_slice(), parts.ties.len(), parts.fewest), ([id(0), id(1)].as_slice(), 0, 2));
        assert_eq!(needs(3), (None, Some("s3>s1 false".to_owned())));
        assert_eq!(needs(4), (Some("s1>s4 false".to_owned()), None));
        assert_eq!(needs(6), (Some("s1>s6 true".to_owned()), Some("s6>s1 true".to_owned())));
    }

    #[test]
    fn of_parts_that_are_as_large_any_may_be_kept_and_the_others_are_told() {
        let flock = Flock::new(manifest(5, &[(0, 1, 1.0), (1, 0, 1.0), (2, 3, 1.0), (3, 2, 1.0), (3, 4, 1.0)]));
        let parts = Parts::of(&flock, None).unwrap();
        assert_eq!((parts.kept, parts.ties), (vec![id(0), id(1)], vec![id(2)]));
        let parts = Parts::of(&flock, Some(&id(3))).unwrap();
        assert_eq!((parts.kept, parts.ties), (vec![id(2), id(3)], vec![id(0)]));
        assert_eq!(Parts::of(&flock, Some(&id(4))), None, "a part without a cycle cannot be walked");
    }

    proptest! {
        #[test]
        fn what_is_kept_has_no_fault_and_every_other_part_comes_in_by_its_bridges(
            arcs in prop::collection::btree_set((0usize..9, 0usize..9), 1..22),
        ) {
            let arcs: Vec<_> = arcs.into_iter().map(|(a, b)| (a, b, 1.0)).collect();
            let flock = Flock::new(manifest(9, &arcs));
            let Some(parts) = Parts::of(&flock, None) else {
                prop_assert!(!flock.is_walkable());
                return Ok(());
            };
            let kept = Flock::new(pruned(flock.manifest(), &parts.kept));
            prop_assert_eq!(kept.faults(), []);
            let all: BTreeSet<&SheepId> = parts.kept.iter().chain(parts.others.iter().flat_map(|p| &p.sheep)).collect();
            prop_assert_eq!(all.len(), 9);
            prop_assert_eq!(parts.fewest == 0, parts.others.is_empty());
            for part in &parts.others {
                let bridges = part.entry.iter().chain(&part.exit).cloned();
                let joined = with(flock.manifest(), bridges);
                let shown = |id: &SheepId| joined.graph().find(id).is_some();
                prop_assert!(parts.kept.iter().chain(&part.sheep).all(shown), "{:?}", part);
                prop_assert!(part.entry.is_some() || part.exit.is_some());
            }
            let every = parts.others.iter().flat_map(|part| part.entry.iter().chain(&part.exit)).cloned();
            let joined = with(flock.manifest(), every);
            prop_assert_eq!(joined.graph().len(), 9);
        }
    }
}
