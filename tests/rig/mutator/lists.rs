//! Changes the list of files.
//!
//! Owns lists that are longer, shorter or another bundle's, and lists with bad paths or over a limit, which are also
//! signed by the artist. Never changes the files themselves.
//!
//! Start at [`change`].

use super::astray::ASTRAY;
use super::fields::{Change, listed};
use super::{Detection, Dice, Good, Material, Stick};
use bundle::ObjectId;

/// Invalid or wrong sizes.
const SIZES: &[&str] = &[
    "0",
    "1",
    "2999",
    "3001",
    "-1",
    "+3000",
    "03000",
    "",
    "3e3",
    "68719476736",
    "68719476737",
    "18446744073709551615",
    "18446744073709551616",
    "3000.0",
];

/// Writes another list; returns what it is. The files that another bundle's list names are there too, so that only list
/// and seal can be wrong.
pub(super) fn change(stick: &mut Stick, good: &Good, material: Material<'_>, dice: &mut Dice) -> (String, Detection) {
    let other = material.other(dice);
    for (path, item) in other.stick.0.iter().filter(|(path, _)| path.starts_with("objects/")) {
        stick.0.entry(path.clone()).or_insert_with(|| item.clone());
    }
    if dice.chance(20) {
        return of_a_changed_clip(stick, good, dice);
    }
    let changed = changed(good, other, dice);
    listed(stick, good, material.keys(), &changed, dice)
}

/// Replaces a clip by another one of the same length, and the list by one that names it, in its old place.
fn of_a_changed_clip(stick: &mut Stick, good: &Good, dice: &mut Dice) -> (String, Detection) {
    let list = good.list();
    let mut files = good.files.clone();
    let clip = files.get_mut("loops/0.mp4").expect("each flock here has it");
    let (at, more) = (dice.below(clip.len()), 1 + dice.below(255));
    clip[at] ^= more as u8;
    stick.put_object(clip);
    let changed = Good { files, ..good.clone() }.list();
    stick.put(&ObjectId::of(list.as_bytes()).path(), changed);
    (format!("the list in its place names a clip with another byte at {at}"), Detection::ByAll)
}

fn changed(good: &Good, other: &Good, dice: &mut Dice) -> Change {
    let list = good.list();
    let lines: Vec<&str> = list.split_inclusive('\n').collect();
    let other = other.list();
    let others: Vec<&str> = other.split_inclusive('\n').collect();
    let at = 1 + dice.below(lines.len() - 1);
    let said = |what: &str, lines: &[&str], breaks| Change {
        text: lines.concat().into_bytes(),
        what: what.to_owned(),
        breaks,
    };
    match dice.below(10) {
        0 => said("is another bundle's", &others, false),
        1 => said("is shorter", &[&lines[..at], &lines[at + 1..]].concat(), true),
        2 => {
            // Of flocks with the same names it is the line of the same file.
            let exchanged = [&lines[..at], &others[at..=at], &lines[at + 1..]].concat();
            let same = exchanged == lines;
            let (what, other) =
                if same { ("is its heading", vec![lines[0]]) } else { ("has a file of another's", exchanged) };
            said(what, &other, same)
        }
        3 => {
            let more = format!("{} 3000 zebra.mp4\n", ObjectId::of(b"nowhere"));
            said("is longer", &[&lines[..], &[&more]].concat(), true)
        }
        4 => {
            let long = format!("{} 3000 {}\n", ObjectId::of(b"nowhere"), "x".repeat(256));
            said("has a path that is too long", &sorted(&lines, &long), true)
        }
        5 => {
            let path = *dice.of_these(ASTRAY);
            let line = format!("{} 3000 {path}\n", ObjectId::of(&good.files["loops/0.mp4"]));
            let what = format!("leads to `{}`", path.escape_debug());
            said(&what, &sorted(&lines, &line), true)
        }
        6 => {
            let size = *dice.of_these(SIZES);
            let clip = lines.iter().rposition(|line| line.contains(" 3000 ")).expect("there are clips");
            let line = lines[clip].replace(" 3000 ", &format!(" {size} "));
            let what = format!("has a file of `{size}` bytes");
            said(&what, &[&lines[..clip], &[&line], &lines[clip + 1..]].concat(), true)
        }
        7 => {
            let digest = *dice.of_these(&["", "g", "00", "-", " "]);
            let line = format!("{digest}{}", &lines[at][1..]);
            said("has a digest that is none", &[&lines[..at], &[&line], &lines[at + 1..]].concat(), true)
        }
        8 => {
            let count = *dice.of_these(&[50_001, 60_000, 200_000]);
            let id = ObjectId::of(&good.files["loops/0.mp4"]);
            let many = (0..count).map(|at| format!("{id} 3000 a/{at:06}\n")).collect::<Vec<_>>().concat();
            said(&format!("has {count} files more"), &[&lines[..1], &[&many], &lines[1..]].concat(), true)
        }
        _ => {
            let huge: Vec<String> =
                (0..70).map(|at| format!("{} 68719476736 a/{at:06}\n", ObjectId::of(&[at]))).collect();
            let huge: Vec<&str> = huge.iter().map(String::as_str).collect();
            said("has 4.4 TB", &[&lines[..1], &huge, &lines[1..]].concat(), true)
        }
    }
}

/// The list with one more line, in its place.
fn sorted<'l>(lines: &[&'l str], more: &'l str) -> Vec<&'l str> {
    let mut sorted = [&lines[1..], &[more]].concat();
    sorted.sort_by_key(|line| line.splitn(3, ' ').nth(2));
    [&lines[..1], &sorted].concat()
}
