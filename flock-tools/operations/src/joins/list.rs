//! Every join that the walk can come to.
//!
//! Owns the list of joins that a manifest implies. Never opens a clip: `ends.rs` does.
//!
//! Start at [`all`].

use std::collections::HashMap;

use flock::{Clip, Manifest, Sheep, SheepId, Transition};

/// One join: `before` ends and `after` begins.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Join {
    /// The sheep where they meet.
    pub sheep: SheepId,
    /// The clip that ends.
    pub before: Clip,
    /// The clip that begins.
    pub after: Clip,
    /// From and to of the transition that takes part, the later one if both clips are transitions; `None` where a loop
    /// meets itself.
    pub between: Option<(SheepId, SheepId)>,
}

impl Join {
    /// The clip to render again where the two do not meet: the transition, the later one of two; else the loop.
    pub fn clip_to_render(&self) -> &Clip {
        match &self.between {
            Some((from, _)) if *from == self.sheep => &self.after,
            Some(_) => &self.before,
            None => &self.after,
        }
    }
}

/// The transitions that meet at a sheep.
#[derive(Default)]
struct Ways<'m> {
    arriving: Vec<&'m Transition>,
    leaving: Vec<&'m Transition>,
}

/// Every join of `manifest`, by sheep in its order. A loop meets itself where it is shown more than once: by its
/// `repeat`, or because no transition leaves the sheep. Transitions to or from sheep that are not there meet nothing.
pub(super) fn all(manifest: &Manifest) -> Vec<Join> {
    let mut ways: HashMap<&SheepId, Ways<'_>> = HashMap::new();
    for transition in &manifest.transitions {
        ways.entry(&transition.to).or_default().arriving.push(transition);
        ways.entry(&transition.from).or_default().leaving.push(transition);
    }
    let none = Ways::default();
    manifest.sheep.iter().flat_map(|sheep| of_sheep(sheep, ways.get(&sheep.id).unwrap_or(&none))).collect()
}

fn of_sheep(sheep: &Sheep, Ways { arriving, leaving }: &Ways<'_>) -> Vec<Join> {
    let join = |before: &Clip, after: &Clip, along: Option<&Transition>| Join {
        sheep: sheep.id.clone(),
        before: before.clone(),
        after: after.clone(),
        between: along.map(|t| (t.from.clone(), t.to.clone())),
    };
    let Some(own) = &sheep.clip else {
        let pairs = arriving.iter().flat_map(|into| leaving.iter().map(move |out| (into, out)));
        return pairs.map(|(into, out)| join(&into.clip, &out.clip, Some(out))).collect();
    };
    let again = sheep.repeat > 1 || leaving.is_empty();
    let itself = again.then(|| join(own, own, None));
    let into = arriving.iter().map(|t| join(&t.clip, own, Some(t)));
    let out = leaving.iter().map(|t| join(own, &t.clip, Some(t)));
    itself.into_iter().chain(into).chain(out).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    /// The joins as `sheep: before > after`.
    fn joins(body: &str) -> Vec<String> {
        let text = format!("format = 1\nname = \"x\"\nsize = [64, 64]\nfps = [30, 1]\n{body}");
        let manifest = Manifest::parse(&text, Path::new("flock.toml")).unwrap();
        let text = |join: &Join| format!("{}: {} > {}", join.sheep, join.before.path, join.after.path);
        all(&manifest).iter().map(text).collect()
    }

    fn sheep(id: &str, more: &str) -> String {
        format!("[[sheep]]\nid = \"{id}\"\n{more}\n")
    }

    fn transition(from: &str, to: &str) -> String {
        format!("[[transition]]\nfrom = \"{from}\"\nto = \"{to}\"\nframes = 9\nclip = \"{from}{to}\"\n")
    }

    #[test]
    fn every_way_into_and_out_of_a_loop_is_a_join() {
        let a = sheep("a", "frames = 9\nclip = \"a\"");
        let b = sheep("b", "frames = 9\nclip = \"b\"\nrepeat = 2");
        let ways = [transition("a", "b"), transition("b", "a"), transition("b", "b")].concat();
        let expected = ["a: ba > a", "a: a > ab", "b: b > b", "b: ab > b", "b: bb > b", "b: b > ba", "b: b > bb"]
            .map(str::to_owned);
        assert_eq!(joins(&[a, b, ways].concat()), expected);
    }

    #[test]
    fn at_a_sheep_without_a_loop_every_arriving_transition_meets_every_leaving_one() {
        let sheep = [sheep("a", ""), sheep("b", ""), sheep("c", "")].concat();
        let ways = [transition("a", "c"), transition("b", "c"), transition("c", "a"), transition("c", "b")].concat();
        let expected = ["a: ca > ac", "b: cb > bc", "c: ac > ca", "c: ac > cb", "c: bc > ca", "c: bc > cb"];
        assert_eq!(joins(&[sheep, ways].concat()), expected.map(str::to_owned));
    }

    #[test]
    fn a_loop_that_nothing_leaves_meets_itself() {
        assert_eq!(joins(&sheep("a", "frames = 9\nclip = \"a\"")), ["a: a > a"]);
    }
}
