//! Edits on an oddly written manifest, compared byte by byte.
//!
//! Owns the examples, one for each edit; `tests/hands.rs` edits by chance. Never looks at how the places are found.

mod hands;

use std::path::Path;

use timing::{FrameCount, Rate};

use super::Edit;
use crate::manifest::{Clip, ClipHash, ClipPath, Manifest, Sheep, SheepId, Transition};

const HEAD: &str = "format = 1\nname = \"x\"\nsize = [64, 64]\nfps = [30, 1]\n";
const ODD: &str = include_str!("tests/odd.toml");

fn id(text: &str) -> SheepId {
    SheepId::new(text).unwrap()
}

fn clip(path: &str, frames: u32, hash: Option<&[u8]>) -> Clip {
    let hash = hash.map(|bytes| ClipHash::of(bytes).unwrap());
    Clip { path: ClipPath::new(path).unwrap(), frames: FrameCount(frames), hash }
}

fn sheep(name: &str) -> Sheep {
    let clip = Some(clip(&format!("loops/{name}.mp4"), 768, None));
    Sheep { id: id(name), clip, genome: None, want: 1.0, repeat: 1 }
}

fn transition(from: &str, to: &str) -> Transition {
    let clip = clip(&format!("transitions/{from}={to}.mp4"), 384, None);
    Transition { from: id(from), to: id(to), clip, weight: 1.0 }
}

fn edit(text: &str) -> Edit {
    Edit::parse(text.to_owned(), Path::new("flock.toml")).unwrap()
}

/// `text` after `change`; what it then means must be what the edit says.
fn after(text: &str, change: impl FnOnce(&mut Edit)) -> String {
    let mut edit = edit(text);
    change(&mut edit);
    let after = edit.text();
    let read = Manifest::parse_unfinished(&after, Path::new("flock.toml"));
    assert_eq!(&read.unwrap_or_else(|error| panic!("{error}\n{after}")), edit.manifest(), "{after}");
    after
}

/// The lines of `new` that are not in `old`, and those of `old` that are not in `new`, marked `+` and `-`.
fn diff(old: &str, new: &str) -> Vec<String> {
    let (old, new): (Vec<_>, Vec<_>) = (old.split('\n').collect(), new.split('\n').collect());
    let mut longest = vec![vec![0; new.len() + 1]; old.len() + 1];
    for (a, line) in old.iter().enumerate().rev() {
        for (b, other) in new.iter().enumerate().rev() {
            longest[a][b] =
                if line == other { 1 + longest[a + 1][b + 1] } else { longest[a + 1][b].max(longest[a][b + 1]) };
        }
    }
    let (mut a, mut b, mut told) = (0, 0, Vec::new());
    while a < old.len() || b < new.len() {
        if a < old.len() && b < new.len() && old[a] == new[b] {
            (a, b) = (a + 1, b + 1);
        } else if a < old.len() && (b == new.len() || longest[a + 1][b] >= longest[a][b + 1]) {
            told.push(format!("-{}", old[a]));
            a += 1;
        } else {
            told.push(format!("+{}", new[b]));
            b += 1;
        }
    }
    told
}

fn changed(change: impl FnOnce(&mut Edit)) -> Vec<String> {
    diff(ODD, &after(ODD, change))
}

#[test]
fn an_edit_that_changes_nothing_keeps_every_byte() {
    assert_eq!(after(ODD, |_| {}), ODD);
    let same = |edit: &mut Edit| {
        edit.set_weight(&id("a.1"), &id("b"), 2.0).unwrap();
        edit.set_want(&id("a.1"), 1.0).unwrap();
        let clip = edit.manifest().sheep[0].clip.clone().unwrap();
        edit.set_loop(&id("a.1"), clip).unwrap();
    };
    assert_eq!(after(ODD, same), ODD);
}

#[test]
fn a_byte_order_mark_and_line_ends_of_both_kinds_stay() {
    let text = format!("\u{feff}{HEAD}[[sheep]]\r\nid = \"a\"\n[[ \"sheep\" ]]\r\nid = \"b\"\r\n");
    let wanted = text.replace("\"b\"\r\n", "\"b\"\nwant = 2.0\r\n");
    assert_eq!(after(&text, |edit| edit.set_want(&id("b"), 2.0).unwrap()), wanted);
}

#[test]
fn a_value_is_replaced_where_it_stands() {
    let weight = changed(|edit| edit.set_weight(&id("a.1"), &id("b"), 0.1).unwrap());
    assert_eq!(weight, ["-    'weight'= 2_0e-1 # twice # as often", "+    'weight'= 0.1 # twice # as often"]);
    let want = changed(|edit| edit.set_want(&id("b"), 3.5).unwrap());
    assert_eq!(want, ["-want   = 0.5", "+want   = 3.5"]);
}

#[test]
fn a_key_that_did_not_stand_there_is_written_in_the_hand_of_its_neighbour() {
    let weight = changed(|edit| edit.set_weight(&id("b"), &id("a.1"), 3.0).unwrap());
    assert_eq!(weight, ["+weight=3.0"]);
    let want = changed(|edit| edit.set_want(&id("c"), 2.0).unwrap());
    assert_eq!(want, ["+want   = 2.0"]);
    let want = changed(|edit| edit.set_want(&id("a.1"), 2.0).unwrap());
    assert_eq!(want, ["+  want = 2.0"]);
}

#[test]
fn a_dropped_sheep_takes_its_lines_and_leaves_the_comments_around_them() {
    assert_eq!(
        changed(|edit| edit.drop_sheep(&id("b")).unwrap()),
        [
            "-[[sheep]]",
            "-id     = \"b\" # the old one",
            "-# inside of b",
            "-want   = 0.5",
            "-[[ \"transition\" ]] # there",
            "-    'from'= \"a.1\"",
            "-    'to'= \"b\"",
            "-    'frames'= 384",
            "-    'clip'= 'transitions/a.1=b \"x\".mp4'",
            "-    'weight'= 2_0e-1 # twice # as often",
            "-",
            "-[[transition]]",
            "-from=\"b\"",
            "-to=\"a.1\"",
            "-frames=384",
            "-clip=\"transitions/b=a.1.mp4\"",
        ]
    );
}

#[test]
fn what_is_added_stands_below_the_last_of_its_kind() {
    let mut ram = sheep("ram");
    (ram.want, ram.repeat) = (0.25, 2);
    let added = changed(|edit| edit.add_sheep(ram).unwrap());
    let block = ["+[[sheep]]", "+id     = \"ram\"", "+frames = 768", "+clip   = \"loops/ram.mp4\""];
    assert_eq!(added, [&block[..], &["+want   = 0.25", "+repeat = 2", "+"]].concat());
    let added = changed(|edit| edit.add_transition(transition("a.1", "a.1")).unwrap());
    let pairs = ["+from=\"a.1\"", "+to=\"a.1\"", "+frames=384", "+clip=\"transitions/a.1=a.1.mp4\""];
    assert_eq!(added, [&["+", "+[[transition]]"][..], &pairs].concat());
}

#[test]
fn a_rename_goes_to_every_place_of_the_id_and_to_no_path() {
    let lines = changed(|edit| edit.rename(&id("b"), &id("bee")).unwrap());
    let new: Vec<_> = lines.iter().filter(|line| line.starts_with('+')).collect();
    assert_eq!(new, ["+id     = \"bee\" # the old one", "+    'to'= \"bee\"", "+from=\"bee\""]);
    assert_eq!(lines.len(), 6);
}

#[test]
fn a_clip_brings_its_frames_and_its_hash_and_takes_the_old_hash_away() {
    let hashed = clip("loops/a.1.mp4", 12, Some(b"x"));
    let hash = hashed.hash.unwrap();
    let with = after(ODD, |edit| edit.set_loop(&id("a.1"), hashed).unwrap());
    let lines = diff(ODD, &with);
    assert_eq!(lines, ["-  \"frames\" = 0x10", "+  \"frames\" = 12", &format!("+  hash = \"{hash}\"")]);
    let without = after(&with, |edit| edit.set_loop(&id("a.1"), clip("loops/a.1.mp4", 16, None)).unwrap());
    assert_eq!(without, ODD.replace("0x10", "16"));
    let first = changed(|edit| edit.set_loop(&id("c"), clip("loops/c.mp4", 5, None)).unwrap());
    assert_eq!(first, ["+frames = 5", "+clip   = \"loops/c.mp4\""]);
    let genome = changed(|edit| edit.set_genome(&id("c"), ClipPath::new("genomes/c.flam3").unwrap()).unwrap());
    assert_eq!(genome, ["+genome = \"genomes/c.flam3\""]);
    let other = changed(|edit| edit.set_transition_clip(&id("b"), &id("a.1"), clip("x.mp4", 384, None)).unwrap());
    assert_eq!(other, ["-clip=\"transitions/b=a.1.mp4\"", "+clip=\"x.mp4\""]);
}

#[test]
fn entries_in_arrays_are_edited_in_their_arrays() {
    let head = HEAD;
    let lines = format!(
        "{head}sheep = [ # all\n  {{id = \"a\"}}, # first\n  {{id = \"b\", want = 2}}, # second\n]\n\
         transition = [{{from=\"a\", to=\"b\", frames=1, clip=\"x\"}}, {{from=\"b\", to=\"a\", frames=1, clip=\"y\"}}]\n"
    );
    let dropped = after(&lines, |edit| edit.drop_sheep(&id("b")).unwrap());
    assert_eq!(dropped, format!("{head}sheep = [ # all\n  {{id = \"a\"}}, # first\n  # second\n]\ntransition = []\n"));
    let unlinked = after(&lines, |edit| edit.drop_transition(&id("b"), &id("a")).unwrap());
    assert!(unlinked.ends_with("transition = [{from=\"a\", to=\"b\", frames=1, clip=\"x\"}]\n"), "{unlinked}");
    let unlinked = after(&lines, |edit| edit.drop_transition(&id("a"), &id("b")).unwrap());
    assert!(unlinked.ends_with("transition = [{from=\"b\", to=\"a\", frames=1, clip=\"y\"}]\n"), "{unlinked}");
    let keyframe = |name: &str| Sheep { clip: None, ..sheep(name) };
    let added = after(&lines, |edit| {
        edit.set_want(&id("a"), 0.5).unwrap();
        edit.add_sheep(keyframe("c")).unwrap();
        edit.add_transition(transition("a", "c")).unwrap();
    });
    assert!(added.contains("{id = \"a\", want = 0.5}, # first"), "{added}");
    assert!(added.contains("want = 2}, # second\n  {id = \"c\"},\n]"), "{added}");
    let clip = "clip=\"y\"}, {from=\"a\", to=\"c\", frames=384, clip=\"transitions/a=c.mp4\"}]\n";
    assert!(added.ends_with(clip), "{added}");
}

#[test]
fn the_first_sheep_finds_its_place() {
    let head = HEAD;
    let block = "\n[[sheep]]\nid = \"a\"\nframes = 768\nclip = \"loops/a.mp4\"\n";
    let add = |edit: &mut Edit| edit.add_sheep(sheep("a")).unwrap();
    assert_eq!(after(head, add), format!("{head}{block}"));
    assert_eq!(after(head.trim_end(), add), format!("{head}{block}"));
    let inline = after(&format!("{head}sheep = []"), add);
    assert_eq!(inline, format!("{head}sheep = [{{ id = \"a\", frames = 768, clip = \"loops/a.mp4\" }}]"));
    let windows = head.replace('\n', "\r\n");
    assert_eq!(after(&windows, add), format!("{head}{block}").replace('\n', "\r\n"));
}

#[test]
fn a_blank_flock_is_what_it_was_asked_to_be() {
    let mut blank = Edit::blank("it's \"so\"\n🐑", (64, 48), Rate::new(30_000, 1001).unwrap());
    assert_eq!(edit(&blank.text()).manifest(), blank.manifest());
    assert_eq!(Edit::blank("x", (64, 64), Rate::new(30, 1).unwrap()).text(), HEAD);
    blank.add_sheep(sheep("a")).unwrap();
    assert_eq!(edit(&blank.text()).manifest(), blank.manifest());
}

#[test]
fn what_cannot_be_meant_is_refused_and_changes_nothing() {
    let mut edit = edit(ODD);
    let (a, b, nobody) = (id("a.1"), id("b"), id("nobody"));
    let said = [
        edit.set_want(&nobody, 1.0),
        edit.set_want(&a, 0.0),
        edit.set_weight(&a, &b, f64::NAN),
        edit.set_weight(&b, &b, 1.0),
        edit.add_sheep(sheep("b")),
        edit.add_transition(transition("a.1", "b")),
        edit.add_transition(transition("a.1", "nobody")),
        edit.drop_sheep(&nobody),
        edit.drop_transition(&b, &b),
        edit.rename(&a, &b),
        edit.rename(&nobody, &b),
    ]
    .map(|refused| refused.unwrap_err().to_string());
    assert_eq!(
        said,
        [
            "sheep `nobody` is not in the flock",
            "a want must be a finite number above 0, found `0`",
            "a weight must be a finite number above 0, found `NaN`",
            "there is no transition from `b` to `b`",
            "sheep `b` already exists in the flock",
            "a transition from `a.1` to `b` already exists in the flock",
            "sheep `nobody` is not in the flock",
            "sheep `nobody` is not in the flock",
            "there is no transition from `b` to `b`",
            "sheep `b` already exists in the flock",
            "sheep `nobody` is not in the flock",
        ]
    );
    assert_eq!(edit.text(), ODD);
}
