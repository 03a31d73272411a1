//! Where each sheep stands in the drawing of the graph.
//!
//! Owns `.studio/places.json`. A sheep stays where it was first drawn, whatever is edited; a new one comes near those that it
//! is linked with. What the artist has dragged is a note of the document, and goes before. Never draws.
//!
//! Start at [`Places::update`].

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use flock::Flock;
use operations::portrait::layout::{Point, own_place, places};

/// The file in the studio's own folder.
const FILE: &str = "places.json";
/// How far a new sheep stands from the middle of those that it is linked with.
const NEAR: f64 = 0.12;
/// Places are kept to this part of 1: so coarse that JSON gives them back to the bit.
const GRAIN: f64 = 1e6;
/// The part of sheep without a place above which all are laid out together.
const MANY: f64 = 0.5;

/// The places of all sheep that were ever drawn, from -1 to 1 along each axis.
#[derive(Debug, Default)]
pub(crate) struct Places {
    path: PathBuf,
    at: BTreeMap<String, Point>,
}

impl Places {
    /// The places in the studio's own folder; none if they cannot be read.
    pub(crate) fn open(own: &Path) -> Self {
        let path = own.join(FILE);
        let at = fs::read(&path).ok().and_then(|bytes| serde_json::from_slice(&bytes).ok()).unwrap_or_default();
        Self { path, at }
    }

    /// Gives every sheep of `flock` a place.
    pub(crate) fn update(&mut self, flock: &Flock) {
        let whole = flock.whole();
        let ids: Vec<&str> = whole.sheep().map(|sheep| whole.id(sheep).as_str()).collect();
        let new: Vec<usize> = (0..ids.len()).filter(|at| !self.at.contains_key(ids[*at])).collect();
        if new.is_empty() {
            return;
        }
        let links = whole.sheep().flat_map(|from| whole.exits(from).map(move |exit| (from, exit)));
        let pairs: Vec<(usize, usize)> = links.map(|(from, exit)| (from.index(), whole.target(exit).index())).collect();
        if new.len() as f64 > MANY * ids.len() as f64 {
            let all = places(&ids, &pairs);
            self.at.extend(ids.iter().zip(all).map(|(id, at)| ((*id).to_owned(), at)));
        } else {
            for at in new {
                let linked = pairs.iter().filter_map(|(from, to)| match (*from == at, *to == at) {
                    (true, false) => Some(*to),
                    (false, true) => Some(*from),
                    (true, true) | (false, false) => None,
                });
                let near: Vec<Point> = linked.filter_map(|other| self.at.get(ids[other]).copied()).collect();
                let place = beside(&near, own_place(ids[at]));
                self.at.insert(ids[at].to_owned(), place);
            }
        }
        for place in self.at.values_mut() {
            *place = place.map(|axis| (axis * GRAIN).round() / GRAIN);
        }
        // Without it the drawing is another one after a restart, and nothing else.
        let _ = serde_json::to_vec(&self.at).map(|bytes| durable::write(&self.path, &bytes));
    }

    /// The place of a sheep; the middle if it has none.
    pub(crate) fn of(&self, id: &str) -> Point {
        self.at.get(id).copied().unwrap_or_default()
    }
}

/// A place beside the middle of `near`, in the direction `own`; `own` itself if there are none.
fn beside(near: &[Point], own: Point) -> Point {
    if near.is_empty() {
        return own;
    }
    let middle = |axis: usize| near.iter().map(|at| at[axis]).sum::<f64>() / near.len() as f64;
    [0, 1].map(|axis| (middle(axis) + NEAR * own[axis]).clamp(-1.0, 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use flock::{Edit, Sheep, SheepId, Transition};
    use std::path::Path;

    #[test]
    fn a_new_sheep_comes_beside_its_neighbours_and_no_other_moves() {
        let scratch = tempfile::tempdir().unwrap();
        let demo = Path::new(env!("CARGO_MANIFEST_DIR")).join("../demo/small/flock.toml");
        let text = fs::read_to_string(&demo).unwrap();
        let mut edit = Edit::parse(text, &demo).unwrap();
        let mut drawn = Places::open(scratch.path());
        drawn.update(&Flock::new(edit.shared_manifest()));
        let before = drawn.at.clone();
        let new = SheepId::new("new").unwrap();
        let sheep = edit.manifest().sheep[0].clone();
        edit.add_sheep(Sheep { id: new.clone(), ..sheep.clone() }).unwrap();
        let link = edit.manifest().transitions[0].clone();
        edit.add_transition(Transition { from: sheep.id.clone(), to: new, ..link }).unwrap();
        let mut again = Places::open(scratch.path());
        again.update(&Flock::new(edit.shared_manifest()));
        assert!(before.iter().all(|(id, at)| again.of(id).map(f64::to_bits) == at.map(f64::to_bits)));
        let [a, b] = [again.of("new"), again.of(sheep.id.as_str())];
        let far = ((a[0] - b[0]).powi(2) + (a[1] - b[1]).powi(2)).sqrt();
        assert!(far > 0.0 && far <= NEAR * 1.5, "{far}");
    }
}
