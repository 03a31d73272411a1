//! The family tree: who descends from whom, in the flock and in its pool.
//!
//! Owns the form of the tree. A sheep of the flock whose genome names parents that nobody has stands in it, its unknown
//! parents do not. Never breeds.
//!
//! Start at [`Tree::of`].

use std::collections::{BTreeMap, BTreeSet};

use ::breeding::{Census, Day, Mark, Pool};
use flock::Manifest;
use operations::credits::FlockCredits;

/// The tree.
#[derive(Debug, Default, serde::Serialize)]
pub(crate) struct Tree {
    /// In the order of their ids.
    pub(crate) nodes: Vec<Node>,
    pub(crate) edges: Vec<Edge>,
}

/// A sheep in the tree.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub(crate) struct Node {
    pub(crate) id: String,
    pub(crate) species: Option<String>,
    pub(crate) alive: bool,
    /// Why it died.
    pub(crate) reason: Option<&'static str>,
    /// Votes for, less those against.
    pub(crate) votes: f64,
    /// How much it is liked: 1 is average.
    pub(crate) rating: f64,
    /// The key of its strip.
    pub(crate) strip: Option<String>,
    pub(crate) in_flock: bool,
}

/// That a child was made of a parent.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub(crate) struct Edge {
    pub(crate) parent: String,
    pub(crate) child: String,
    /// The operator that made it; empty if nothing says it.
    pub(crate) op: String,
}

impl Tree {
    /// The tree of the flock with this manifest and these credits, and of its `pool` as of `today`. With `at`, only the
    /// ancestors and the descendants of this sheep. `species` and `strip` tell of a sheep by its id.
    pub(crate) fn of(
        manifest: &Manifest,
        credits: &FlockCredits,
        pool: Option<(&Pool, Day)>,
        at: Option<&str>,
        species: impl Fn(&str) -> Option<String>,
        strip: impl Fn(&str) -> Option<String>,
    ) -> Self {
        let (mut nodes, mut edges) = (BTreeMap::new(), Vec::new());
        if let Some((pool, today)) = pool {
            add_pool(pool, today, &mut nodes, &mut edges);
        }
        for (sheep, credit) in manifest.sheep.iter().zip(&credits.sheep) {
            let id = sheep.id.as_str().to_owned();
            let is_of_pool = nodes.contains_key(&id);
            let node = nodes.entry(id.clone()).or_insert_with(|| Node::of_flock(&id, species(&id)));
            node.in_flock = true;
            if !is_of_pool {
                let edge = |parent: &String| Edge { parent: parent.clone(), child: id.clone(), op: String::new() };
                edges.extend(credit.parents.iter().map(edge));
            }
        }
        edges.retain(|edge| nodes.contains_key(&edge.parent));
        if let Some(at) = at {
            let family = family(at, &edges);
            nodes.retain(|id, _| family.contains(id));
            edges.retain(|edge| family.contains(&edge.parent) && family.contains(&edge.child));
        }
        let mut nodes: Vec<Node> = nodes.into_values().collect();
        for node in &mut nodes {
            node.strip = strip(&node.id);
        }
        Self { nodes, edges }
    }
}

impl Node {
    fn of_flock(id: &str, species: Option<String>) -> Self {
        let (id, strip, reason) = (id.to_owned(), None, None);
        Self { id, species, alive: true, reason, votes: 0.0, rating: 1.0, strip, in_flock: true }
    }
}

fn add_pool(pool: &Pool, today: Day, nodes: &mut BTreeMap<String, Node>, edges: &mut Vec<Edge>) {
    let census = Census::of(pool, today);
    for sheep in pool.sheep() {
        let id = sheep.born.id.to_string();
        let tally = census.tally(sheep);
        let reason = match (sheep.is_alive(), sheep.mark) {
            (true, _) => None,
            (false, Mark::Reject) => Some("rejected"),
            (false, Mark::Keep | Mark::None) => Some("liked less than the others"),
        };
        edges.extend(sheep.born.parents.iter().map(|parent| Edge {
            parent: parent.to_string(),
            child: id.clone(),
            op: sheep.born.operator.clone(),
        }));
        let node = Node {
            id: id.clone(),
            species: Some(sheep.born.species.clone()),
            alive: sheep.is_alive(),
            reason,
            votes: tally.got,
            rating: tally.rating(),
            strip: None,
            in_flock: false,
        };
        nodes.insert(id, node);
    }
}

/// A sheep, its ancestors and its descendants.
fn family(at: &str, edges: &[Edge]) -> BTreeSet<String> {
    let reach = |of: fn(&Edge) -> (&str, &str)| {
        let mut ways: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
        for (from, to) in edges.iter().map(of) {
            ways.entry(from).or_default().push(to);
        }
        let (mut found, mut next) = (BTreeSet::from([at.to_owned()]), vec![at]);
        while let Some(id) = next.pop() {
            let new = ways.get(id).into_iter().flatten().filter(|to| found.insert((**to).to_owned()));
            next.extend(new.copied().collect::<Vec<_>>());
        }
        found
    };
    let mut family = reach(|edge| (&edge.child, &edge.parent));
    family.extend(reach(|edge| (&edge.parent, &edge.child)));
    family
}

#[cfg(test)]
mod tests {
    use super::*;
    use ::breeding::{Born, Entry, Event, Origin, Settings, Stamp, Traits};
    use std::path::Path;

    /// A pool with these births, each a child of those before it that are named.
    fn pool(births: &[&[usize]]) -> Pool {
        let origin = Origin::of_bits(7);
        let id = |serial: usize| ::breeding::Id { brood: 0, serial: serial as u32, origin };
        let born = |(serial, parents): (usize, &&[usize])| Entry {
            stamp: Stamp { number: serial as u64, pool: origin },
            day: Day(1),
            event: Event::Born(Born {
                id: id(serial),
                parents: parents.iter().map(|parent| id(*parent)).collect(),
                operator: "walk".to_owned(),
                seed: 1,
                species: "expr".to_owned(),
                figures: Traits::new(&[0.5]),
                licence: String::new(),
                strength: 1.0,
                waited: None,
            }),
        };
        let mut entries: Vec<Entry> = births.iter().enumerate().map(born).collect();
        let stamp = Stamp { number: 99, pool: origin };
        entries.push(Entry { stamp, day: Day(1), event: Event::Marked { id: id(0), mark: Mark::Reject } });
        Pool::of(Settings::new("x", origin, 1, &["expr"]), &entries).unwrap()
    }

    #[test]
    fn the_family_of_a_sheep_has_its_ancestors_and_descendants_and_nobody_else() {
        let pool = pool(&[&[], &[], &[0, 1], &[1], &[2], &[4]]);
        let text = "format = 1\nname = \"x\"\nsize = [64, 64]\nfps = [30, 1]\n[[sheep]]\nid = \"rose\"\n";
        let manifest = Manifest::parse(text, Path::new("flock.toml")).unwrap();
        let credit = operations::credits::Credit { parents: vec!["nobody".to_owned()], ..Default::default() };
        let credits = FlockCredits { sheep: vec![credit], transitions: Vec::new(), strangers: Vec::new() };
        let tree = |at: Option<&str>| {
            Tree::of(&manifest, &credits, Some((&pool, Day(1))), at, |_| None, |id| Some(format!("strip-{id}")))
        };
        let whole = tree(None);
        assert_eq!((whole.nodes.len(), whole.edges.len()), (7, 5));
        let dead: Vec<_> = whole.nodes.iter().filter(|node| !node.alive).map(|node| node.reason).collect();
        assert_eq!(dead, [Some("rejected")]);
        assert!(whole.nodes.iter().any(|node| node.id == "rose" && node.in_flock));
        let ids: Vec<String> = pool.sheep().map(|sheep| sheep.born.id.to_string()).collect();
        let family: Vec<_> = tree(Some(&ids[2])).nodes.into_iter().map(|node| node.id).collect();
        assert_eq!(family, [&ids[0], &ids[1], &ids[2], &ids[4], &ids[5]].map(String::clone));
    }
}
