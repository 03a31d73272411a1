//! Manifests written in any hand, edited by chance.

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::path::Path;

use proptest::prelude::*;
use timing::Rate;

use super::{clip, edit, id, sheep, transition};
use crate::edit::{
    Edit, Kind,
    render::{self, Pair},
};
use crate::manifest::{Clip, ClipHash, Manifest, SheepId};

const KINDS: [Kind; 2] = [Kind::Sheep, Kind::Transition];

/// Choices about how a manifest is written; all zero is the plain hand.
struct Tape<'a>(std::slice::Iter<'a, u8>);

impl Tape<'_> {
    fn of<T: Copy>(&mut self, choices: &[T]) -> T {
        choices[*self.0.next().unwrap_or(&0) as usize % choices.len()]
    }

    fn comment(&mut self) -> &'static str {
        self.of(&["", "", "# note", "# ü [[sheep]] id = \"a\" 🐑", "#"])
    }

    /// `key = value`, without an end.
    fn pair(&mut self, key: &str, value: &str) -> String {
        let key =
            self.of(&[key.to_owned(), key.to_owned(), format!("\"{key}\""), format!("'{key}'")].each_ref()).clone();
        let value = match value.strip_prefix('"').and_then(|value| value.strip_suffix('"')) {
            Some(bare) => self.of(&[value, &format!("'{bare}'"), &format!("\"\"\"{bare}\"\"\"")]).to_owned(),
            None if value == "7.5" => self.of(&["7.5", "75e-1", "+7.50", "0.75_0E+1"]).to_owned(),
            None if value == "4.0" => self.of(&["4.0", "4", "0x4", "4e0"]).to_owned(),
            None => value.to_owned(),
        };
        format!("{key}{}{value}", self.of(&[" = ", "=", "   =\t", "= "]))
    }

    /// An entry below its header.
    fn headed(&mut self, kind: Kind, pairs: &[Pair]) -> String {
        let (indent, name) = (self.of(&["", "", "  ", "\t"]), kind.name());
        let header = self.of(&["[[{}]]", "[[ {} ]]", "[[\"{}\"]] # {}"]).replace("{}", name);
        let mut text = format!("{}{header}\n", self.of(&["", indent]));
        for (key, value) in pairs {
            let blank = self.of(&["", "", "", "\n", "  # of its own\n"]);
            writeln!(text, "{blank}{indent}{} {}", self.pair(key, value), self.comment()).unwrap();
        }
        let between = self.of(&["\n", "", "\n\n", "# below\n\n", "\n# above\n"]);
        text + between
    }

    /// All entries of a kind in an array.
    fn array(&mut self, kind: Kind, entries: &[Vec<Pair>]) -> String {
        let (pad, newline) = (self.of(&["", " "]), self.of(&["", "\n"]));
        let entries: Vec<String> = entries
            .iter()
            .map(|pairs| {
                let pairs: Vec<_> = pairs.iter().map(|(key, value)| self.pair(key, value)).collect();
                format!("{{{pad}{}{pad}}}", pairs.join(self.of(&[", ", ",", ", # inside\n "])))
            })
            .collect();
        let between = format!(",{}{newline}", if newline.is_empty() { " " } else { self.comment() });
        let comma = if entries.is_empty() { "" } else { self.of(&["", ",", " ,"]) };
        format!("{} = [{pad}{newline}{}{comma}{newline}]\n", kind.name(), entries.join(&between))
    }

    fn manifest(&mut self, sheep: &[Vec<Pair>], transitions: &[Vec<Pair>]) -> String {
        let head = ["format = 1", "name = \"x\"", "size = [64, 64]", "fps = [ 30,\n 1 ]"];
        let mut text = head.map(|line| format!("{line} {}\n", self.comment())).concat();
        let inline = [self.of(&[false, false, true]), self.of(&[false, false, true])];
        let mut headed = [sheep.iter(), transitions.iter()];
        for kind in [0, 1].into_iter().filter(|kind| inline[*kind]) {
            text += &self.array(KINDS[kind], std::mem::take(&mut headed[kind]).as_slice());
        }
        while !headed.iter().all(|entries| entries.as_slice().is_empty()) {
            let (first, other) = self.of(&[(0, 1), (1, 0)]);
            let kind = if headed[first].as_slice().is_empty() { other } else { first };
            text.extend(headed[kind].next().map(|entry| self.headed(KINDS[kind], entry)));
        }
        if self.of(&[false, true]) {
            text.truncate(text.trim_end().len());
        }
        let text = if self.of(&[false, true]) { text.replace('\n', "\r\n") } else { text };
        self.of(&["", "\u{feff}"]).to_owned() + &text
    }
}

#[derive(Clone, Debug)]
enum Op {
    Weight(usize, f64),
    Want(usize, f64),
    Repeat(usize, u32),
    KeepOnly(usize),
    Loop(usize, Clip),
    Add(usize),
    Link(usize, usize),
    Unlink(usize),
    Drop(usize),
    Rename(usize, usize),
}

impl Op {
    /// The same on a plain model; `false` if it cannot be done.
    fn on(&self, model: &mut Manifest, edit: &mut Edit) -> bool {
        let name = |at: usize| id(&format!("s{at}"));
        let (sheep, pairs) = (&model.sheep, &model.transitions);
        let nth = |at: usize| pairs.get(at % pairs.len().max(1)).map(|t| (t.from.clone(), t.to.clone()));
        let has = |at: usize| sheep.iter().position(|sheep| sheep.id == name(at));
        match self {
            Self::Weight(at, weight) => nth(*at).is_some_and(|(from, to)| {
                edit.set_weight(&from, &to, *weight).unwrap();
                let count = model.transitions.len();
                model.transitions[*at % count].weight = *weight;
                true
            }),
            Self::Want(at, want) => has(*at).is_some_and(|place| {
                edit.set_want(&name(*at), *want).unwrap();
                model.sheep[place].want = *want;
                true
            }),
            Self::Repeat(at, repeat) => has(*at).is_some_and(|place| {
                edit.set_repeat(&name(*at), *repeat).unwrap();
                model.sheep[place].repeat = *repeat;
                true
            }),
            Self::KeepOnly(count) => keep_only(model, edit, &(0..*count).map(name).collect()),
            Self::Loop(at, clip) => has(*at).is_some_and(|place| {
                edit.set_loop(&name(*at), clip.clone()).unwrap();
                model.sheep[place].clip = Some(clip.clone());
                true
            }),
            Self::Add(at) => {
                has(*at).is_none() && {
                    edit.add_sheep(self::sheep(name(*at).as_str())).unwrap();
                    model.sheep.push(self::sheep(name(*at).as_str()));
                    true
                }
            }
            Self::Link(from, to) => {
                let new = transition(name(*from).as_str(), name(*to).as_str());
                let can = edit.add_transition(new.clone()).is_ok();
                if can {
                    model.transitions.push(new);
                }
                can
            }
            Self::Unlink(at) => nth(*at).is_some_and(|(from, to)| {
                edit.drop_transition(&from, &to).unwrap();
                model.transitions.retain(|t| (&t.from, &t.to) != (&from, &to));
                true
            }),
            Self::Drop(at) => {
                has(*at).is_some() && {
                    edit.drop_sheep(&name(*at)).unwrap();
                    model.sheep.retain(|sheep| sheep.id != name(*at));
                    model.transitions.retain(|t| t.from != name(*at) && t.to != name(*at));
                    true
                }
            }
            Self::Rename(old, new) => {
                has(*old).is_some() && has(*new).is_none() && {
                    edit.rename(&name(*old), &name(*new)).unwrap();
                    let ids = model.sheep.iter_mut().map(|sheep| &mut sheep.id);
                    let ends = model.transitions.iter_mut().flat_map(|t| [&mut t.from, &mut t.to]);
                    ids.chain(ends).filter(|id| **id == name(*old)).for_each(|id| *id = name(*new));
                    true
                }
            }
        }
    }
}

/// The sheep `kept` are kept, and the transitions among them.
fn keep_only(model: &mut Manifest, edit: &mut Edit, kept: &BTreeSet<SheepId>) -> bool {
    edit.keep_only(kept);
    model.sheep.retain(|sheep| kept.contains(&sheep.id));
    model.transitions.retain(|t| kept.contains(&t.from) && kept.contains(&t.to));
    true
}

fn ops() -> impl Strategy<Value = Vec<Op>> {
    let number = || prop::sample::select(vec![1.0, 0.5, 3.25, 1e-9, 1e300, 0.1 + 0.2]);
    let loops = prop::sample::select(vec![None, Some(&b"x"[..]), Some(&b"y"[..])])
        .prop_flat_map(|hash| (0..8usize, (1..99u32).prop_map(move |frames| clip("l/it's \"so\".mp4", frames, hash))));
    let op = prop_oneof![
        (0..20usize, number()).prop_map(|(at, weight)| Op::Weight(at, weight)),
        (0..8usize, number()).prop_map(|(at, want)| Op::Want(at, want)),
        (0..8usize, 1..4u32).prop_map(|(at, repeat)| Op::Repeat(at, repeat)),
        (3..9usize).prop_map(Op::KeepOnly),
        loops.prop_map(|(at, clip)| Op::Loop(at, clip)),
        (0..9usize).prop_map(Op::Add),
        (0..8usize, 0..8usize).prop_map(|(from, to)| Op::Link(from, to)),
        (0..20usize).prop_map(Op::Unlink),
        (0..8usize).prop_map(Op::Drop),
        (0..8usize, 0..12usize).prop_map(|(old, new)| Op::Rename(old, new)),
    ];
    prop::collection::vec(op, 0..6)
}

/// A flock of `count` sheep, some with a loop and a want, and of some of the transitions among them.
fn flock(count: usize, arcs: &[(usize, usize)]) -> Manifest {
    let mut flock = Manifest {
        name: "x".into(),
        size: (64, 64),
        fps: Rate::new(30, 1).unwrap(),
        sheep: (0..count).map(|at| sheep(&format!("s{at}"))).collect(),
        transitions: Vec::new(),
    };
    for (at, sheep) in flock.sheep.iter_mut().enumerate() {
        sheep.clip = sheep.clip.take().filter(|_| at % 3 != 1);
        sheep.want = [1.0, 2.0, 0.25][at % 3];
    }
    for (at, (from, to)) in arcs.iter().enumerate().filter(|(_, (from, to))| *from.max(to) < count) {
        let mut new = transition(&format!("s{from}"), &format!("s{to}"));
        new.weight = [1.0, 7.5, 4.0][at % 3];
        new.clip.hash = ClipHash::of(&b"z"[..]).ok().filter(|_| at % 4 == 0);
        flock.transitions.push(new);
    }
    flock
}

fn written(flock: &Manifest, tape: &[u8]) -> String {
    let sheep: Vec<_> = flock.sheep.iter().map(render::sheep).collect();
    let transitions: Vec<_> = flock.transitions.iter().map(render::transition).collect();
    Tape(tape.iter()).manifest(&sheep, &transitions)
}

/// Whether `before` is `after` without the `marks`: where a value stood it may be any number, where none did there is
/// neither the mark, nor its key, nor what parts them from the pair before.
fn rest_is_same(before: &str, after: &str, marks: &[(String, bool)]) -> bool {
    let mut places: Vec<_> =
        marks.iter().map(|(mark, stood)| (after.find(mark).unwrap(), mark.len(), *stood)).collect();
    places.sort_unstable();
    let (mut old, mut new) = (before, 0);
    for (at, length, stood) in places {
        let kept = &after[new..at];
        let kept = if stood { kept } else { without_key(kept) };
        let Some(rest) = old.strip_prefix(kept) else { return false };
        let digit = |letter: char| letter.is_ascii_alphanumeric() || "+-_.".contains(letter);
        (old, new) = (if stood { rest.trim_start_matches(digit) } else { rest }, at + length);
    }
    old == &after[new..]
}

/// `text` without the key of a weight that it ends in, and what parts that from the pair before.
fn without_key(text: &str) -> &str {
    let text = &text[..text.rfind("weight").unwrap()];
    if let Some(inline) = text.strip_suffix(", ") {
        return inline;
    }
    let line = text.trim_end_matches([' ', '\t']).strip_suffix('\n').unwrap();
    line.strip_suffix('\r').unwrap_or(line)
}

/// Whether `part` is `whole` with bytes taken out.
fn is_within(part: &str, whole: &str) -> bool {
    let mut rest = whole.bytes();
    part.bytes().all(|byte| rest.any(|other| other == byte))
}

proptest! {
    #[test]
    fn a_manifest_in_any_hand_comes_to_mean_what_the_edits_say(
        count in 1usize..7,
        arcs in prop::collection::btree_set((0usize..6, 0usize..6), 0..12),
        tape in prop::collection::vec(any::<u8>(), 0..300),
        ops in ops(),
    ) {
        let mut model = flock(count, &arcs.into_iter().collect::<Vec<_>>());
        let text = written(&model, &tape);
        let mut edit = edit(&text);
        prop_assert_eq!(edit.manifest(), &model);
        prop_assert_eq!(edit.text(), text.clone());
        for op in &ops {
            op.on(&mut model, &mut edit);
        }
        prop_assert_eq!(edit.manifest(), &model);
        let after = edit.text();
        let read = Manifest::parse_unfinished(&after, Path::new("flock.toml"));
        prop_assert!(read.is_ok(), "{:?}\n{text}\n---\n{after}", read);
        prop_assert_eq!(read.unwrap(), model);
        let adds = |op: &Op| matches!(op, Op::Add(_) | Op::Link(..));
        let drops = |op: &Op| matches!(op, Op::Drop(_) | Op::KeepOnly(_) | Op::Unlink(_));
        if ops.iter().all(adds) {
            prop_assert!(is_within(&text, &after), "{text}\n---\n{after}");
        }
        if ops.iter().all(drops) {
            prop_assert!(is_within(&after, &text), "{text}\n---\n{after}");
        }
        if !ops.iter().any(drops) {
            prop_assert_eq!(after.matches("# note").count(), text.matches("# note").count());
        }
    }

    #[test]
    fn whatever_is_still_a_manifest_after_some_slips_of_the_pen_can_be_edited(
        count in 1usize..4,
        arcs in prop::collection::btree_set((0usize..4, 0usize..4), 0..6),
        tape in prop::collection::vec(any::<u8>(), 0..150),
        slips in prop::collection::vec((any::<prop::sample::Index>(), 0usize..2, "[\\[\\]{}=,#\"'\r\n .a1]{0,2}"), 1..4),
    ) {
        let mut text = written(&flock(count, &arcs.into_iter().collect::<Vec<_>>()), &tape);
        for (at, gone, new) in slips {
            let places: Vec<usize> = text.char_indices().map(|(at, _)| at).collect();
            let place = at.index(places.len());
            let end = places.get(place + gone).copied().unwrap_or(text.len());
            text.replace_range(places[place]..end, &new);
        }
        if let Ok(mut edit) = Edit::parse(text.clone(), Path::new("flock.toml")) {
            prop_assert_eq!(edit.text(), text);
            for at in 0..edit.manifest().sheep.len() {
                let id = edit.manifest().sheep[at].id.clone();
                edit.set_want(&id, 0.125).unwrap();
            }
            edit.add_sheep(sheep("new")).unwrap();
            let read = Manifest::parse(&edit.text(), Path::new("flock.toml"));
            prop_assert_eq!(&read.unwrap(), edit.manifest());
        }
    }

    #[test]
    fn what_is_added_and_dropped_again_leaves_no_trace(
        count in 1usize..7,
        arcs in prop::collection::btree_set((0usize..6, 0usize..6), 1..12),
        tape in prop::collection::vec(any::<u8>(), 0..300),
    ) {
        let flock = flock(count, &arcs.into_iter().collect::<Vec<_>>());
        let text = written(&flock, &tape);
        let mut added = edit(&text);
        added.add_sheep(sheep("new")).unwrap();
        added.add_transition(transition("s0", "new")).unwrap();
        let mut dropped = edit(&added.text());
        dropped.drop_sheep(&id("new")).unwrap();
        // A blank line may be left where none parted its neighbours.
        let lines = |text: &str| {
            let lines = text.lines().map(str::trim_end).filter(|line| !line.is_empty());
            lines.map(str::to_owned).collect::<Vec<_>>()
        };
        prop_assert_eq!(lines(&dropped.text()), lines(&text));
    }

    #[test]
    fn setting_weights_changes_weights_and_nothing_else_whether_they_stood_there_or_not(
        count in 1usize..7,
        arcs in prop::collection::btree_set((0usize..6, 0usize..6), 0..12),
        tape in prop::collection::vec(any::<u8>(), 0..300),
    ) {
        let flock = flock(count, &arcs.into_iter().collect::<Vec<_>>());
        let text = written(&flock, &tape);
        let mark = |number: usize| 1_000_007.5 + 10_000.0 * number as f64;
        let set = |edit: &mut Edit| for (number, t) in flock.transitions.iter().enumerate() {
            edit.set_weight(&t.from, &t.to, mark(number)).unwrap();
        };
        let mut once = edit(&text);
        set(&mut once);
        let after = once.text();
        let stood = |weight: f64| weight.to_bits() != 1.0_f64.to_bits();
        let marks: Vec<(String, bool)> =
            flock.transitions.iter().enumerate().map(|(at, t)| (number_of(mark(at)), stood(t.weight))).collect();
        prop_assert!(rest_is_same(&text, &after, &marks), "{text}\n---\n{after}");
        let mut twice = edit(&after);
        set(&mut twice);
        prop_assert_eq!(twice.text(), after);
    }

    #[test]
    fn setting_weights_and_wants_changes_the_bytes_of_these_values_and_no_others(
        count in 1usize..7,
        arcs in prop::collection::btree_set((0usize..6, 0usize..6), 0..12),
        tape in prop::collection::vec(any::<u8>(), 0..300),
        seed in any::<u32>(),
    ) {
        // A value that stands nowhere else marks each place; both texts are then the same but for the marks.
        let mut flock = flock(count, &arcs.into_iter().collect::<Vec<_>>());
        let mark = |at: usize| f64::from(seed % 7919) + 1_000_007.5 + 10_000.0 * at as f64;
        let (mut number, mut marks) = (0, Vec::new());
        let sheep = flock.sheep.iter_mut().map(|sheep| &mut sheep.want);
        for value in sheep.chain(flock.transitions.iter_mut().map(|t| &mut t.weight)) {
            *value = mark(number);
            marks.push((mark(number), 1.0 / (1.0 + number as f64)));
            number += 1;
        }
        let text = written(&flock, &tape);
        let mut edit = edit(&text);
        for (sheep, (_, new)) in flock.sheep.iter().zip(&marks) {
            edit.set_want(&sheep.id, *new).unwrap();
        }
        for (t, (_, new)) in flock.transitions.iter().zip(&marks[flock.sheep.len()..]) {
            edit.set_weight(&t.from, &t.to, *new).unwrap();
        }
        let expected = marks.iter().fold(text, |text, (old, new)| text.replace(&number_of(*old), &number_of(*new)));
        prop_assert_eq!(edit.text(), expected);
    }
}

fn number_of(value: f64) -> String {
    render::number(value)
}
