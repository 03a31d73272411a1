//! The states that pages were sent, and what is new to a page that has one of them.
//!
//! Owns the tags by which a page says what it has, and the form of the answer: lists in which what is as it was is named by
//! its place, and the figures, which an edit changes everywhere, as numbers in the order of the lists. A page whose tag is
//! not known is sent everything. Never computes a state.
//!
//! Start at [`SentStates::answer`].

use std::collections::{HashMap, VecDeque};
use std::hash::Hash;
use std::mem;
use std::sync::Arc;

use flock::Fault;
use serde::{Serialize, Serializer};

use super::figures::Figures;
use super::state::{FlockPart, Head, SheepState, State, TransitionState};

/// How many states are remembered: the tabs of a browser ask in turn.
const MOST_KEPT: usize = 8;

/// The states that were sent last.
#[derive(Debug)]
pub(crate) struct SentStates {
    /// Tells this start's tags from those of another.
    start: u32,
    last: u64,
    kept: VecDeque<(String, Arc<State>)>,
}

/// A state for a page: all of it, or what is new.
#[derive(Debug)]
pub(crate) struct StateAnswer {
    tag: String,
    state: Arc<State>,
    delta: Option<Delta>,
}

/// What is new in a state, by places in its lists.
#[derive(Debug, PartialEq)]
struct Delta {
    /// The tag of the state that the page has.
    since: String,
    sheep: Vec<Part>,
    candidates: Vec<Part>,
    transitions: Vec<Part>,
    are_shares_new: bool,
    are_wants_new: bool,
    are_visits_new: bool,
}

/// A part of a list.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Part {
    /// Those of the page's list from this place up to that one.
    Same(usize, usize),
    /// The item at this place of the new list.
    New(usize),
}

impl SentStates {
    /// None were sent. `start` is another number at each start of the program.
    pub(crate) fn new(start: u32) -> Self {
        Self { start, last: 0, kept: VecDeque::new() }
    }

    /// The answer to a page that has the state of the tag `since`.
    pub(crate) fn answer(&mut self, mut state: State, since: Option<&str>) -> StateAnswer {
        let known = self.kept.iter().find(|(tag, before)| Some(&**tag) == since && before.head.by == state.head.by);
        let delta = known.map(|(tag, before)| Delta::of(tag, &before.part, &mut state.part));
        self.last += 1;
        let (tag, state) = (format!("{:x}-{}", self.start, self.last), Arc::new(state));
        self.kept.push_back((tag.clone(), Arc::clone(&state)));
        if self.kept.len() > MOST_KEPT {
            self.kept.pop_front();
        }
        StateAnswer { tag, state, delta }
    }
}

impl Delta {
    fn of(tag: &str, before: &FlockPart, after: &mut FlockPart) -> Self {
        let id = |own: &SheepState| own.id.clone();
        let ends = |own: &TransitionState| (own.from.clone(), own.to.clone());
        Self {
            since: tag.to_owned(),
            are_shares_new: differ(&before.sheep, &after.sheep, |own| (&own.id, own.share.to_bits())),
            are_wants_new: differ(&before.sheep, &after.sheep, |own| (&own.id, own.wanted.to_bits())),
            are_visits_new: differ(&before.transitions, &after.transitions, |own| {
                (&own.from, &own.to, own.visits.to_bits())
            }),
            sheep: parts(&before.sheep, &mut after.sheep, id, is_same_sheep),
            candidates: parts(&before.candidates, &mut after.candidates, id, |old, new| old == new),
            transitions: parts(&before.transitions, &mut after.transitions, ends, is_same_transition),
        }
    }
}

/// Whether the lists differ in what `of` says of their items.
fn differ<'a, T, K: PartialEq>(before: &'a [T], after: &'a [T], of: impl Fn(&'a T) -> K) -> bool {
    !before.iter().map(&of).eq(after.iter().map(&of))
}

/// The list `after` in parts of the list `before`.
fn parts<T, K: Eq + Hash>(
    before: &[T],
    after: &mut [T],
    key: impl Fn(&T) -> K,
    is_same: impl Fn(&T, &mut T) -> bool,
) -> Vec<Part> {
    let known: HashMap<K, usize> = before.iter().enumerate().map(|(place, item)| (key(item), place)).collect();
    let mut parts = Vec::new();
    for (place, item) in after.iter_mut().enumerate() {
        let same = known.get(&key(item)).copied().filter(|old| is_same(&before[*old], item));
        match (same, parts.last_mut()) {
            (Some(old), Some(Part::Same(_, end))) if *end == old => *end = old + 1,
            (Some(old), _) => parts.push(Part::Same(old, old + 1)),
            (None, _) => parts.push(Part::New(place)),
        }
    }
    parts
}

/// Whether they are equal but for the figures, which are told apart. `new` is left as it is.
fn is_same_sheep(old: &SheepState, new: &mut SheepState) -> bool {
    let own = (mem::replace(&mut new.share, old.share), mem::replace(&mut new.wanted, old.wanted), new.ratio);
    new.ratio = old.ratio;
    let is_same = old == new;
    (new.share, new.wanted, new.ratio) = own;
    is_same
}

/// The same of transitions.
fn is_same_transition(old: &TransitionState, new: &mut TransitionState) -> bool {
    let own = mem::replace(&mut new.visits, old.visits);
    let is_same = old == new;
    new.visits = own;
    is_same
}

/// The answer with everything.
#[derive(Serialize)]
struct WholeDocument<'a> {
    tag: &'a str,
    #[serde(flatten)]
    state: &'a State,
}

/// The answer with what is new.
#[derive(Serialize)]
struct DeltaDocument<'a> {
    tag: &'a str,
    since: &'a str,
    #[serde(flatten)]
    head: &'a Head,
    figures: &'a Figures,
    faults: &'a [Fault],
    sheep: Vec<Item<'a, SheepState>>,
    candidates: Vec<Item<'a, SheepState>>,
    transitions: Vec<Item<'a, TransitionState>>,
    /// Of each sheep, and of each transition; absent if none is another one. A ratio is their quotient.
    #[serde(skip_serializing_if = "Option::is_none")]
    shares: Option<Vec<f32>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    wants: Option<Vec<f32>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    visits: Option<Vec<f32>>,
}

/// A part of a list as it is sent: `[from, to]`, or an item.
#[derive(Serialize)]
#[serde(untagged)]
enum Item<'a, T> {
    Same([usize; 2]),
    New(&'a T),
}

fn items<'a, T>(parts: &[Part], list: &'a [T]) -> Vec<Item<'a, T>> {
    let item = |part: &Part| match *part {
        Part::Same(from, to) => Item::Same([from, to]),
        Part::New(place) => Item::New(&list[place]),
    };
    parts.iter().map(item).collect()
}

/// One figure of each item, if `are_new`. Seven digits are more than a page shows, and half of the letters.
fn column<T>(are_new: bool, list: &[T], figure: impl Fn(&T) -> f64) -> Option<Vec<f32>> {
    are_new.then(|| list.iter().map(|item| figure(item) as f32).collect())
}

impl Serialize for StateAnswer {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let Self { tag, state, delta } = self;
        let Some(delta) = delta else { return WholeDocument { tag, state }.serialize(serializer) };
        let part = &state.part;
        let document = DeltaDocument {
            tag,
            since: &delta.since,
            head: &state.head,
            figures: &part.figures,
            faults: &part.faults,
            sheep: items(&delta.sheep, &part.sheep),
            candidates: items(&delta.candidates, &part.candidates),
            transitions: items(&delta.transitions, &part.transitions),
            shares: column(delta.are_shares_new, &part.sheep, |own| own.share),
            wants: column(delta.are_wants_new, &part.sheep, |own| own.wanted),
            visits: column(delta.are_visits_new, &part.transitions, |own| own.visits),
        };
        document.serialize(serializer)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::document::{Notes, Revision};
    use crate::views::state::Capabilities;
    use crate::views::state::tests::part;
    use flock::Measure;
    use serde_json::{Value, json};

    fn state() -> State {
        let head = Head {
            revision: Revision::of("a"),
            name: "small".to_owned(),
            fps: [30, 1],
            size: [64, 36],
            by: Measure::Visits,
            now_ms: 0,
            undo: None,
            redo: None,
            jobs: Vec::new(),
            paused: false,
            pool: None,
            capabilities: Capabilities { gpu: false },
        };
        State { head, part: part(&Notes::default(), &[]) }
    }

    fn answer(sent: &mut SentStates, state: State, since: Option<&Value>) -> Value {
        let told = sent.answer(state, since.and_then(Value::as_str));
        serde_json::from_str(&serde_json::to_string(&told).unwrap()).unwrap()
    }

    #[test]
    fn a_list_is_told_by_what_stays_and_what_is_new() {
        let before = [('a', 1), ('b', 2), ('c', 3), ('d', 4), ('e', 5), ('f', 6)];
        let mut after = [('a', 1), ('b', 2), ('c', 9), ('d', 4), ('f', 6), ('x', 7), ('e', 5)];
        let told = parts(&before, &mut after, |item| item.0, |old, new| old == new);
        let expected =
            [Part::Same(0, 2), Part::New(2), Part::Same(3, 4), Part::Same(5, 6), Part::New(5), Part::Same(4, 5)];
        assert_eq!(told, expected);
    }

    #[test]
    fn a_page_is_told_what_changed_since_what_it_has_and_everything_if_that_is_not_known() {
        let mut sent = SentStates::new(7);
        let whole = answer(&mut sent, state(), None);
        let (sheep, transitions) = (whole["sheep"].as_array().unwrap().len(), whole["transitions"].as_array().unwrap());
        assert!(whole.get("since").is_none() && sheep > 3 && transitions.len() > 3);
        let same = answer(&mut sent, state(), Some(&whole["tag"]));
        assert_eq!((&same["since"], &same["sheep"]), (&whole["tag"], &json!([[0, sheep]])));
        assert_eq!((same.get("shares"), same.get("wants"), same.get("visits")), (None, None, None));
        let mut weighed = state();
        weighed.part.transitions[1].weight = 3.0;
        weighed.part.transitions[1].visits = 0.5;
        weighed.part.sheep[0].share = 0.25;
        let delta = answer(&mut sent, weighed, Some(&same["tag"]));
        assert_eq!(delta["sheep"], json!([[0, sheep]]), "shares are told apart");
        assert_eq!((&delta["shares"][0], delta.get("wants")), (&json!(0.25), None));
        assert_eq!(
            (&delta["transitions"][0], &delta["transitions"][2]),
            (&json!([0, 1]), &json!([2, transitions.len()]))
        );
        assert_eq!((&delta["transitions"][1]["weight"], &delta["visits"][1]), (&json!(3.0), &json!(0.5)));
        for _ in 0..MOST_KEPT {
            answer(&mut sent, state(), None);
        }
        assert!(answer(&mut sent, state(), Some(&delta["tag"])).get("since").is_none(), "it is forgotten");
        let other = answer(&mut SentStates::new(8), state(), Some(&whole["tag"]));
        assert!(other.get("since").is_none(), "the program was started anew");
    }

    #[test]
    fn sheep_that_change_places_have_their_figures_with_them() {
        let mut sent = SentStates::new(7);
        let mut first = state();
        let figure = |state: &mut State, at: usize, share: f64| state.part.sheep[at].share = share;
        figure(&mut first, 0, 0.125);
        figure(&mut first, 1, 0.5);
        let mut second = state();
        second.part.sheep.swap(0, 1);
        figure(&mut second, 0, 0.125);
        figure(&mut second, 1, 0.5);
        let whole = answer(&mut sent, first, None);
        let delta = answer(&mut sent, second, Some(&whole["tag"]));
        assert_eq!((&delta["shares"][0], &delta["shares"][1]), (&json!(0.125), &json!(0.5)));
    }
}
