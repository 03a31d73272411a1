//! Replaces a file by something else.
//!
//! Owns the replacements: nothing, another file, a folder, a link, a pipe, a file without end.

use super::{Detection, Dice, Item, Stick};

/// The targets of links.
const TARGETS: &[&str] = &["/etc/passwd", "/dev/zero", "/dev/null", "/proc/self/mem", "..", ".", "../kept", "/nowhere"];

/// Replaces one file; returns what was done.
pub(super) fn change(stick: &mut Stick, dice: &mut Dice) -> (String, Detection) {
    let paths: Vec<String> = stick.0.keys().cloned().collect();
    let path = dice.of_these(&paths).clone();
    let bytes = stick.bytes(&path).to_vec();
    let lay = |stick: &mut Stick, item, what: &str| {
        stick.0.insert(path.clone(), item);
        format!("`{path}` is {what}")
    };
    let what = match dice.below(14) {
        0 => {
            stick.0.remove(&path);
            format!("`{path}` is missing")
        }
        1 => {
            let other = dice.of_these(&paths).clone();
            let (one, two) = (stick.0[&path].clone(), stick.0[&other].clone());
            if one == two {
                stick.0.remove(&path);
            } else {
                stick.0.extend([(path.clone(), two), (other.clone(), one)]);
            }
            format!("`{path}` and `{other}` are swapped, or the one is missing")
        }
        2 => lay(stick, Item::Folder, "a folder"),
        3 => {
            let target = *dice.of_these(TARGETS);
            lay(stick, Item::Link(target.to_owned()), &format!("a link to `{target}`"))
        }
        4 => {
            // To the very bytes.
            stick.put("beside", bytes);
            let up = "../".repeat(path.matches('/').count());
            lay(stick, Item::Link(format!("{up}beside")), "a link to what it should be")
        }
        5 => lay(stick, Item::Pipe, "a pipe"),
        6 => lay(stick, Item::Huge(Vec::new()), "a hole of 100 GiB"),
        7 => lay(stick, Item::Huge(bytes), "followed by a hole of 100 GiB"),
        8 => lay(stick, Item::Bytes(Vec::new()), "empty"),
        9 => {
            let size = bytes.len() / 2;
            stick.0.remove(&path);
            stick.put(&format!("{path}.000"), &bytes[..size]);
            stick.put(&format!("{path}.001"), &bytes[size / 2..]);
            format!("`{path}` lies in two parts that are not its own")
        }
        10 => folder(stick, &path, dice),
        11 => {
            let beneath = paths.iter().map(String::as_str).find(|other| *other != path).unwrap_or_default();
            let item = stick.0.remove(beneath).expect("it lies there");
            stick.0.remove(&path);
            stick.0.insert(format!("{path}/inside"), item);
            format!("`{path}` is a folder with `{beneath}` in it")
        }
        12 => {
            let folder = path.split('/').next().unwrap_or_default().to_owned();
            stick.0.retain(|path, _| !path.starts_with(&folder));
            format!("`{folder}` is missing")
        }
        _ => {
            stick.0.retain(|path, _| !path.starts_with("seals"));
            (0..300).for_each(|at| stick.put(&format!("seals/attic{at:03}.seal"), &bytes[..bytes.len() / 2]));
            "300 seals of others are there, and not its own".to_owned()
        }
    };
    (what, Detection::ByAllOrHarmless)
}

/// Replaces a folder in `path`.
fn folder(stick: &mut Stick, path: &str, dice: &mut Dice) -> String {
    let ends: Vec<usize> = path.match_indices('/').map(|(at, _)| at).collect();
    let folder = ends.get(dice.below(ends.len().max(1))).map_or(path, |end| &path[..*end]);
    let inside = format!("{folder}/");
    let moved: Vec<String> = stick.0.keys().filter(|path| path.starts_with(&inside)).cloned().collect();
    for path in moved {
        let item = stick.0.remove(&path).expect("it was found above");
        stick.0.insert(path.replacen(folder, "elsewhere", 1), item);
    }
    let up = "../".repeat(folder.matches('/').count());
    let (item, what) = match dice.below(3) {
        0 => (Item::Link(format!("{up}elsewhere")), "a link to one"),
        1 => (Item::Bytes(b"no folder".to_vec()), "a file"),
        _ => (Item::Pipe, "a pipe"),
    };
    stick.0.insert(folder.to_owned(), item);
    format!("`{folder}`, which should be a folder, is {what}")
}
