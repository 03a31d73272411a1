//! Changes a line or a value of a text.
//!
//! Owns the values that no unit may accept, whoever signed them, and those that only the artist may set. The first are
//! also signed by the artist, the others by all other keys.
//!
//! Start at [`change`].

use super::keys::{KeyHolder, Keys};
use super::{Detection, Dice, Good, Material, Stick};

/// A changed text.
pub(super) struct Change {
    pub(super) text: Vec<u8>,
    pub(super) what: String,
    /// Whether no unit may accept it, even from the artist.
    pub(super) breaks: bool,
}

/// Who has signed a text that was changed.
#[derive(Clone, Copy, Debug)]
pub(super) enum Signing {
    /// Nobody: the signature is that of the text before.
    Kept,
    /// This key, in its own name.
    By(KeyHolder),
    /// A stranger, in the name of the artist.
    Claimed,
}

/// Bytes of a manifest that is far larger than any flock's.
const GIANT: usize = 15 << 20;

/// Values that break a rule, by the key of their line.
const WRONG: &[(&str, &[&str])] = &[
    (
        "sequence",
        &["0", "-1", "+7", "07", "1e3", "18446744073709551616", "", " 7", "7 ", "6.0", "0x7", "\u{667}", "7\r"],
    ),
    (
        "units",
        &["", "Lobby", "all", "../lobby", "/lobby", "lobby lobby", "stairs lobby", "* lobby", "lobby ", "l\u{f3}"],
    ),
    ("units", &["lobby\tstairs", "stairs", "lobby/../stairs", ".", "*  ", "lobby, stairs", "\u{1b}[2Jlobby", "-lobby"]),
    (
        "created",
        &["yesterday", "", "2026-03-01", "2026-03-01T12:00:00+00:00", "2026-03-01t12:00:00z", "20260301T120000Z"],
    ),
    ("flock", &["", "a\u{7f}b", "a\u{9b}b", "a\0b", "a\tb", "a\rb"]),
    (
        "contents",
        &["", "-1 %", "+250 %", "0250 %", "250", "% 250", "0 %", "1 %", "8388609 %", "18446744073709551615 %"],
    ),
    ("contents", &["18446744073709551616 %", "250  %", "250 %0", "250 x%", "250 0", "9e2 %"]),
    (
        "version",
        &["", "next", "1.2.3.4.5", "-1", "01.2", "1..2", "0.2.0-rc", "0.2.0 ", "99999999999999999999", "1.", "v1"],
    ),
    (
        "start",
        &["", "498", "% 498", "-1 %", "0498 %", "1073741825 %", "18446744073709551615 %", "498 %0", "497 %", "499 %"],
    ),
    (
        "root",
        &["", "12320", "-1 %", "+12320 %", "1073741825 %", "18446744073709551616 %", "12320 x%", "1 %", "12321 %"],
    ),
];
/// Values that only the artist may set.
const OTHERS: &[(&str, &[&str])] = &[
    ("sequence", &["7", "1000", "18446744073709551615"]),
    ("units", &["*", "lobby stairs"]),
    ("created", &["2030-01-01T00:00:00Z"]),
    ("flock", &["borealis"]),
    ("version", &["0.3.0", "18446744073709551615"]),
];
/// Lines that no manifest may have.
const WRONG_MANIFESTS: &[(&str, &str)] = &[
    ("format = 1", "format = 2"),
    ("format = 1", "format = 1\ncolour = 1"),
    ("format = 1\n", ""),
    ("name = \"aurora\"\n", ""),
    ("name = \"aurora\"", "name = 5"),
    ("name = \"aurora\"", "name = \"aurora"),
    ("name = \"aurora\"", "name = \"aur\0ora\""),
    ("size = [64, 64]", "size = [64, 63]"),
    ("size = [64, 64]", "size = [0, 64]"),
    ("size = [64, 64]", "size = [64]"),
    ("size = [64, 64]", "size = [-64, 64]"),
    ("size = [64, 64]", "size = [18446744073709551616, 64]"),
    ("fps = [30, 1]", "fps = [0, 1]"),
    ("fps = [30, 1]", "fps = [30, 0]"),
    ("fps = [30, 1]", "fps = 1e999"),
    ("frames = 9", "frames = -9"),
    ("frames = 9", "frames = \"9\""),
    ("frames = 9", "frames = 9\nframes = 9"),
    ("id = \"0\"", "id = \"\""),
    ("id = \"0\"", "id = \"a b\""),
    ("id = \"0\"", "id = \"../0\""),
    ("clip = \"loops/0.mp4\"", "clip = \"../loops/0.mp4\""),
    ("clip = \"loops/0.mp4\"", "clip = \"/etc/passwd\""),
    ("clip = \"loops/0.mp4\"", "clip = \"loops/../loops/0.mp4\""),
    ("clip = \"loops/0.mp4\"", "clip = \"loops\\\\0.mp4\""),
    ("clip = \"loops/0.mp4\"", "clip = \"loops/none.mp4\""),
    ("clip = \"loops/0.mp4\"", "clip = \"http://127.0.0.1/0.mp4\""),
    ("clip = \"loops/0.mp4\"", "clip = [[[[\"loops/0.mp4\"]]]]"),
    ("[[sheep]]", "[sheep]"),
    ("[[sheep]]", "[[sheep]"),
];

/// Changes one text and signs it; returns what was done.
pub(super) fn change(stick: &mut Stick, good: &Good, material: Material<'_>, dice: &mut Dice) -> (String, Detection) {
    let keys = material.keys();
    let has_system = stick.0.contains_key("systems/all.seal");
    match dice.below(if has_system { 5 } else { 4 }) {
        0 => {
            let changed = letter(&good.letter(&good.list()), dice);
            sealed(stick, good, keys, &changed, dice)
        }
        1 => {
            let changed = structural(&good.list(), dice);
            listed(stick, good, keys, &changed, dice)
        }
        2 => {
            let changed = manifest(good, dice);
            in_manifest(stick, good, keys, &changed, dice)
        }
        3 => {
            let changed = letter("dreams key statement 1\n", dice);
            let said = keys.sign(*dice.of_these(&[KeyHolder::Artist, KeyHolder::Stranger]), &changed.text);
            stick.put("statements", said);
            (format!("the statement: {}", changed.what), Detection::ByAllOrHarmless)
        }
        _ => {
            let changed = letter(&good.release(), dice);
            let signing = signing(changed.breaks, dice);
            let seal = dressed(keys, signing, stick.bytes("systems/all.seal"), KeyHolder::Artist, &changed.text);
            stick.put("systems/all.seal", seal);
            (format!("the system's seal, {signing:?}: {}", changed.what), Detection::ByAll)
        }
    }
}

/// Chooses who signs.
pub(super) fn signing(breaks: bool, dice: &mut Dice) -> Signing {
    if breaks && dice.chance(60) {
        return Signing::By(KeyHolder::Artist);
    }
    *dice.of_these(&[Signing::Kept, Signing::By(KeyHolder::Stranger), Signing::By(KeyHolder::Lost), Signing::Claimed])
}

/// `text` signed in this way, where `before` was signed before; `who` stands for the artist.
pub(super) fn dressed(keys: &Keys, signing: Signing, before: &[u8], who: KeyHolder, text: &[u8]) -> Vec<u8> {
    match signing {
        Signing::Kept => {
            let lines: Vec<&[u8]> = before.split_inclusive(|byte| *byte == b'\n').take(4).collect();
            [&lines.concat(), text].concat()
        }
        Signing::By(KeyHolder::Artist) => keys.sign(who, text),
        Signing::By(who) => keys.sign(who, text),
        Signing::Claimed => keys.sign_as(KeyHolder::Stranger, who, text),
    }
}

/// Writes a changed seal.
pub(super) fn sealed(
    stick: &mut Stick,
    good: &Good,
    keys: &Keys,
    changed: &Change,
    dice: &mut Dice,
) -> (String, Detection) {
    let signing = signing(changed.breaks, dice);
    let seal = dressed(keys, signing, good.stick.bytes(&good.seal()), good.who, &changed.text);
    stick.put(&good.seal(), seal);
    (format!("the seal, {signing:?}: {}", changed.what), Detection::ByAll)
}

/// Writes a changed list with a seal that names it, or in the place of the other list.
pub(super) fn listed(
    stick: &mut Stick,
    good: &Good,
    keys: &Keys,
    changed: &Change,
    dice: &mut Dice,
) -> (String, Detection) {
    if dice.chance(25) {
        stick.put(&bundle::ObjectId::of(good.list().as_bytes()).path(), changed.text.clone());
        return (format!("the list in its place: {}", changed.what), Detection::ByAll);
    }
    stick.put_object(&changed.text);
    let letter = good.letter_of(&changed.text).into_bytes();
    let changed = Change { text: letter, what: format!("the list: {}", changed.what), ..*changed };
    sealed(stick, good, keys, &changed, dice)
}

/// Writes a changed manifest, with a list that names it, and a seal.
fn in_manifest(stick: &mut Stick, good: &Good, keys: &Keys, changed: &Change, dice: &mut Dice) -> (String, Detection) {
    stick.put_object(&changed.text);
    let mut files = good.files.clone();
    files.insert("flock.toml".to_owned(), changed.text.clone());
    let list = Good { files, ..good.clone() }.list();
    let what = format!("the manifest: {}", changed.what);
    listed(stick, good, keys, &Change { text: list.into_bytes(), what, breaks: changed.breaks }, dice)
}

fn manifest(good: &Good, dice: &mut Dice) -> Change {
    let text = String::from_utf8(good.files["flock.toml"].clone()).unwrap();
    let (before, after) = *dice.of_these(WRONG_MANIFESTS);
    if dice.chance(70) {
        let what = format!("`{}` becomes `{}`", before.escape_debug(), after.escape_debug());
        return Change { text: text.replacen(before, after, 1).into_bytes(), what, breaks: true };
    }
    let deep = format!("{text}genome = {}{}\n", "[".repeat(30_000), "]".repeat(30_000));
    let wide = format!("{text}{} = 1\n", "a.".repeat(20_000) + "a");
    let (what, text) = match dice.below(7) {
        0 => ("30,000 brackets", deep.into_bytes()),
        1 => ("20,000 dots in a key", wide.into_bytes()),
        2 => ("15 MB of sheep", many_sheep(&text)),
        3 => ("15 MB of words", format!("{text}genome = \"{}\"\n", "words ".repeat(GIANT / 6)).into_bytes()),
        4 => ("15 MB of numbers", format!("{text}genome = [{}]\n", "1,".repeat(GIANT / 2)).into_bytes()),
        5 => ("not UTF-8", [text.as_bytes(), b"# \xff\n"].concat()),
        _ => ("nothing", Vec::new()),
    };
    Change { text, what: what.to_owned(), breaks: true }
}

/// A manifest of 15 MB, of which every line is valid.
fn many_sheep(text: &str) -> Vec<u8> {
    let sheep = |at: usize| format!("[[sheep]]\nid = \"a{at}\"\nframes = 9\nclip = \"loops/0.mp4\"\n");
    let all: Vec<String> = (0..GIANT / sheep(0).len()).map(sheep).collect();
    [text, &all.concat()].concat().into_bytes()
}

/// Changes a value or the structure of a letter.
fn letter(text: &str, dice: &mut Dice) -> Change {
    if dice.chance(35) {
        return structural(text, dice);
    }
    let has = |key: &str| text.lines().any(|line| line.starts_with(&format!("{key} ")));
    let breaks = dice.chance(75);
    let table = if breaks { WRONG } else { OTHERS };
    let rows: Vec<_> = table.iter().filter(|(key, _)| has(key)).collect();
    if rows.is_empty() {
        return structural(text, dice);
    }
    let (key, values) = *dice.of_these(&rows);
    let value = long_or(dice, key, breaks, values);
    let line = text.lines().find(|line| line.starts_with(&format!("{key} "))).expect("it was found above");
    let digest = line.rsplit(' ').next().unwrap_or_default();
    let new = format!("{key} {}", value.replace('%', digest));
    let mut what = format!("{key} becomes `{}`", value.escape_debug());
    what.truncate(what.floor_char_boundary(120));
    Change { text: text.replacen(line, &new, 1).into_bytes(), what, breaks }
}

/// One of `values`, or one that is too long.
fn long_or(dice: &mut Dice, key: &str, breaks: bool, values: &[&str]) -> String {
    if !breaks || !dice.chance(10) {
        return (*dice.of_these(values)).to_owned();
    }
    match key {
        "units" => (0..129).map(|at| format!("lobby{at:03}")).collect::<Vec<_>>().join(" "),
        "flock" => "a".repeat(129),
        _ => "9".repeat(*dice.of_these(&[300, 5_000, 17_000])),
    }
}

/// Changes the structure of a text, which has one valid spelling only.
pub(super) fn structural(text: &str, dice: &mut Dice) -> Change {
    let mut lines: Vec<Vec<u8>> = text.split_inclusive('\n').map(|line| line.as_bytes().to_vec()).collect();
    let at = dice.below(lines.len());
    let within = dice.below(lines[at].len());
    let what = match dice.below(13) {
        0 => {
            lines.insert(at, lines[at].clone());
            "doubled"
        }
        1 => {
            lines.remove(at);
            "missing"
        }
        2 if lines.len() > 1 => {
            lines.swap(at, (at + 1) % text.lines().count());
            "swapped with the next"
        }
        3 => {
            let end = lines[at].len() - 1;
            lines[at].insert(end, b'\r');
            "ends as on other systems"
        }
        4 => {
            for line in &mut lines {
                line.insert(line.len() - 1, b'\r');
            }
            "and all others end as on other systems"
        }
        5 => {
            lines.last_mut().expect("there is one").pop();
            "or rather the last does not end"
        }
        6 => {
            lines.insert(at, b"\n".to_vec());
            "follows an empty one"
        }
        7 => {
            let space = lines[at].iter().position(|byte| *byte == b' ').unwrap_or(0);
            lines[at][space] = b'\t';
            "has a tab"
        }
        8 => {
            lines[at].insert(0, b' ');
            "is indented"
        }
        9 => {
            lines[at].insert(within, 0);
            "has a zero"
        }
        10 => {
            lines[at].insert(within, 0xff);
            "is not UTF-8"
        }
        11 => {
            let end = lines[at].len() - 1;
            lines[at].splice(end..end, vec![b'x'; 20_000]);
            "is far too long"
        }
        _ => {
            lines[0].splice(0..0, "\u{feff}".bytes());
            "or rather the first has a mark before it"
        }
    };
    Change { text: lines.concat(), what: format!("line {} {what}", at + 1), breaks: true }
}
