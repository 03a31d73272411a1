//! What is wrong with a flock.
//!
//! Owns the kinds of faults, and finds those in the manifest. `dreams check` adds those of clips.
//!
//! Start at [`Flock::faults`](super::Flock::faults).

use std::collections::HashSet;
use std::hash::Hash;

use crate::graph::{Graph, SheepIx, Structure};
use crate::manifest::{ClipPath, Manifest, SheepId};

/// The kind of a fault, by its name in `dreams check --json`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum FaultKind {
    /// A clip's hash differs, or it does not decode cleanly.
    DamagedClip,
    /// A sheep without an exit, or without a way back.
    DeadEnd,
    /// A sheep named twice.
    DuplicateSheep,
    /// More than one transition for an ordered pair.
    DuplicateTransition,
    /// A join that does not meet.
    Jump,
    /// Too large for a unit's memory.
    Large,
    /// A clip that is missing or not readable.
    MissingClip,
    /// A part with cycles of its own that the walk never plays.
    Split,
    /// A sheep that the walk cannot come to.
    Unreachable,
    /// A genome that asks for what is not drawn, of a sheep with a clip that is yet to be rendered.
    UndrawnGenome,
    /// A transition from or to a sheep that is not in the flock.
    UnknownSheep,
    /// A clip of another form, size, rate or frame count.
    WrongClip,
}

/// One fault.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Fault {
    /// What kind.
    pub kind: FaultKind,
    /// The sheep, where it is one sheep's fault.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sheep: Option<SheepId>,
    /// Where the transition starts, where it is a transition's fault.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub from: Option<SheepId>,
    /// Where the transition ends.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub to: Option<SheepId>,
    /// The clip, where it is a clip's fault.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub clip: Option<ClipPath>,
    /// A sentence for people.
    pub message: String,
}

impl Fault {
    fn of_sheep(kind: FaultKind, sheep: &SheepId, message: String) -> Self {
        Self { kind, sheep: Some(sheep.clone()), from: None, to: None, clip: None, message }
    }

    fn of_transition(kind: FaultKind, from: &SheepId, to: &SheepId, message: String) -> Self {
        Self { kind, sheep: None, from: Some(from.clone()), to: Some(to.clone()), clip: None, message }
    }
}

/// Every fault of the manifest: names first, then the graph.
pub(crate) fn faults(manifest: &Manifest, graph: &Graph, structure: &Structure) -> Vec<Fault> {
    let mut found = Vec::new();
    // The graph has each name once: a search is needed only if it has fewer entries than the manifest.
    if graph.len() < manifest.sheep.len() || graph.exit_count() < manifest.transitions.len() {
        found.extend(named_twice(manifest));
        found.extend(unknown(manifest));
    }
    found.extend(unplayed(graph, structure));
    found
}

/// The played sheep with a single exit: what follows them is always the same. Not a fault, but of interest to the artist.
pub fn forced_repeats(graph: &Graph) -> Vec<SheepId> {
    let single = graph.sheep().filter(|&sheep| graph.exits(sheep).len() == 1);
    single.map(|sheep| graph.id(sheep).clone()).collect()
}

/// The items whose key came before.
fn again<T, K: Eq + Hash>(items: &[T], key: impl Fn(&T) -> K) -> Vec<&T> {
    let mut seen = HashSet::new();
    items.iter().filter(|&item| !seen.insert(key(item))).collect()
}

fn named_twice(manifest: &Manifest) -> Vec<Fault> {
    let sheep = again(&manifest.sheep, |sheep| sheep.id.clone()).into_iter().map(|sheep| {
        let message = format!("sheep `{}` is defined more than once; the first definition counts", sheep.id);
        Fault::of_sheep(FaultKind::DuplicateSheep, &sheep.id, message)
    });
    let transitions = again(&manifest.transitions, |t| (t.from.clone(), t.to.clone())).into_iter().map(|t| {
        let message =
            format!("transition `{}` to `{}` is defined more than once; the first definition counts", t.from, t.to);
        Fault::of_transition(FaultKind::DuplicateTransition, &t.from, &t.to, message)
    });
    sheep.chain(transitions).collect()
}

fn unknown(manifest: &Manifest) -> Vec<Fault> {
    let known: HashSet<&SheepId> = manifest.sheep.iter().map(|sheep| &sheep.id).collect();
    let mut found = Vec::new();
    for t in &manifest.transitions {
        for id in [&t.from, &t.to].into_iter().filter(|id| !known.contains(id)) {
            let message =
                format!("transition `{}` to `{}` names sheep `{id}`, which is not in the flock", t.from, t.to);
            let fault = Fault::of_transition(FaultKind::UnknownSheep, &t.from, &t.to, message);
            found.push(Fault { sheep: Some(id.clone()), ..fault });
        }
    }
    found
}

/// Every sheep that the walk does not play, and why.
fn unplayed(graph: &Graph, structure: &Structure) -> Vec<Fault> {
    let classes = structure.playable();
    let mut of_class = vec![None; graph.len()];
    for (number, class) in classes.iter().enumerate() {
        for sheep in class {
            of_class[sheep.index()] = Some(number);
        }
    }
    let reached = reached(graph, classes.first().map_or(&[], Vec::as_slice));
    let mut found = Vec::new();
    for sheep in graph.sheep().filter(|sheep| of_class[sheep.index()].is_none()) {
        let id = graph.id(sheep);
        let ends = graph.exits(sheep).len() == 0;
        if ends {
            let message = format!("sheep `{id}` has no transition that leaves it");
            found.push(Fault::of_sheep(FaultKind::DeadEnd, id, message));
        } else if reached[sheep.index()] {
            let message = format!("sheep `{id}` has no way back to the part that is played");
            found.push(Fault::of_sheep(FaultKind::DeadEnd, id, message));
        }
        if !reached[sheep.index()] && !classes.is_empty() {
            let message = format!("sheep `{id}` cannot be reached from the part that is played");
            found.push(Fault::of_sheep(FaultKind::Unreachable, id, message));
        }
    }
    for class in classes.iter().skip(1) {
        let id = graph.id(class[0]);
        let message = format!(
            "the flock falls apart: {} sheep with `{id}` and {} sheep with `{}` close on themselves, and only the latter \
             are played",
            class.len(),
            classes[0].len(),
            graph.id(classes[0][0])
        );
        found.push(Fault::of_sheep(FaultKind::Split, id, message));
    }
    found
}

/// The sheep that can be reached from `start`.
fn reached(graph: &Graph, start: &[SheepIx]) -> Vec<bool> {
    let mut reached = vec![false; graph.len()];
    let mut open = start.to_vec();
    while let Some(sheep) = open.pop() {
        if !std::mem::replace(&mut reached[sheep.index()], true) {
            open.extend(graph.exits(sheep).map(|exit| graph.target(exit)).filter(|to| !reached[to.index()]));
        }
    }
    reached
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::graph::tests::manifest;
    use proptest::prelude::*;

    fn told(manifest: &Manifest) -> Vec<Fault> {
        let graph = Graph::new(manifest);
        faults(manifest, &graph, &Structure::of(&graph))
    }

    fn found(manifest: &Manifest) -> Vec<(FaultKind, String)> {
        let who = |fault: &Fault| fault.sheep.as_ref().or(fault.from.as_ref()).map(ToString::to_string);
        told(manifest).iter().map(|fault| (fault.kind, who(fault).unwrap_or_default())).collect()
    }

    fn pair() -> Vec<(usize, usize, f64)> {
        vec![(0, 1, 1.0), (1, 0, 1.0)]
    }

    #[test]
    fn a_sound_flock_has_no_faults() {
        assert_eq!(found(&manifest(2, &pair())), []);
        assert_eq!(found(&manifest(1, &[(0, 0, 1.0)])), []);
    }

    #[test]
    fn each_fault_of_the_graph_is_named_with_its_sheep() {
        let with = |n: usize, more: &[(usize, usize, f64)]| found(&manifest(n, &[&pair()[..], more].concat()));
        let s = |at: usize| format!("s{at}");
        assert_eq!(with(3, &[(1, 2, 1.0)]), [(FaultKind::DeadEnd, s(2))]);
        assert_eq!(with(3, &[(2, 1, 1.0)]), [(FaultKind::Unreachable, s(2))]);
        assert_eq!(with(3, &[]), [(FaultKind::DeadEnd, s(2)), (FaultKind::Unreachable, s(2))]);
        assert_eq!(with(4, &[(1, 2, 1.0), (2, 3, 1.0)]), [(FaultKind::DeadEnd, s(2)), (FaultKind::DeadEnd, s(3))]);
        assert_eq!(with(4, &[(2, 3, 1.0), (3, 2, 1.0)]), [(FaultKind::Split, s(2))]);
        assert_eq!(with(3, &[(1, 2, 1.0), (2, 2, 1.0)]), [(FaultKind::Split, s(2))]);
        assert_eq!(found(&manifest(2, &[(0, 1, 1.0)])), [(FaultKind::DeadEnd, s(1))]);
    }

    #[test]
    fn names_that_stand_twice_or_nowhere_are_told() {
        let mut flock = manifest(2, &[&pair()[..], &[(0, 1, 2.0)]].concat());
        flock.sheep.push(flock.sheep[0].clone());
        flock.transitions[0].to = SheepId::new("nobody").unwrap();
        let kinds: Vec<_> = found(&flock);
        assert_eq!(
            kinds,
            [(FaultKind::DuplicateSheep, "s0".to_owned()), (FaultKind::UnknownSheep, "nobody".to_owned()),]
        );
        flock.transitions[0].to = SheepId::new("s1").unwrap();
        assert_eq!(found(&flock)[1], (FaultKind::DuplicateTransition, "s0".to_owned()));
    }

    proptest! {
        #[test]
        fn a_flock_is_without_faults_exactly_if_it_is_one_class_with_a_cycle(
            arcs in prop::collection::btree_set((0usize..6, 0usize..6), 0..16),
        ) {
            let arcs: Vec<_> = arcs.into_iter().map(|(a, b)| (a, b, 1.0)).collect();
            let flock = manifest(6, &arcs);
            let structure = Structure::of(&Graph::new(&flock));
            let classes = structure.playable();
            prop_assert_eq!(told(&flock).is_empty(), classes.len() == 1 && classes[0].len() == 6);
        }
    }
}
