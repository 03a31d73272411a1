//! Replaces the seal, or its signature.
//!
//! Owns seals of other bundles, of other keys, of earlier bundles, and signatures of other files. Changes what a seal
//! vouches for only where a key signs that must not.
//!
//! Start at [`change`].

use super::fields::{Signing, dressed};
use super::keys::KeyHolder;
use super::{Detection, Dice, Good, Material, PLAYED, Stick};
use crate::mutator::bytes;

/// The most bytes of a seal.
const LARGEST: usize = 16 << 10;

/// Writes another seal; returns what it is.
pub(super) fn change(stick: &mut Stick, good: &Good, material: Material<'_>, dice: &mut Dice) -> (String, Detection) {
    let keys = material.keys();
    let (path, list) = (good.seal(), good.list());
    let (seal, text) = (good.stick.bytes(&path).to_vec(), good.letter(&list));
    let of_before = || Good { sequence: 1 + text.len() as u64 % PLAYED, ..good.clone() }.letter(&list);
    let (what, new, detection) = match dice.below(15) {
        0 => {
            let other = material.other(dice);
            ("that of another bundle", other.stick.bytes(&other.seal()).to_vec(), Detection::ByUnits)
        }
        1 => ("a stranger's", keys.sign(KeyHolder::Stranger, text.as_bytes()), Detection::ByAll),
        2 => ("of a key that was called back", keys.sign(KeyHolder::Lost, text.as_bytes()), Detection::ByAll),
        3 => (
            "a stranger's in the artist's name",
            keys.sign_as(KeyHolder::Stranger, KeyHolder::Artist, text.as_bytes()),
            Detection::ByAll,
        ),
        4 => {
            stick.0.remove("statements");
            ("of a key that nobody vouches for", keys.sign(KeyHolder::New, text.as_bytes()), Detection::ByAll)
        }
        5 => ("older than what was played", keys.sign(KeyHolder::Artist, of_before().as_bytes()), Detection::ByUnits),
        6 => return changed_by_a_stranger(stick, good, material, dice),
        7 => {
            let said = keys.trust(KeyHolder::Artist, KeyHolder::New);
            (
                "a signature of something else",
                dressed(keys, Signing::Kept, &said, KeyHolder::Artist, text.as_bytes()),
                Detection::ByAll,
            )
        }
        8 => ("a statement", keys.trust(KeyHolder::Artist, KeyHolder::New), Detection::ByAll),
        9 => ("followed by itself", [&seal[..], &seal].concat(), Detection::ByAll),
        10 => {
            let mut long = seal.clone();
            long.resize(LARGEST + dice.below(3), b'\n');
            ("filled up to its limit", long, Detection::ByAll)
        }
        11 => {
            let old = Good { sequence: good.sequence + 1, ..good.clone() };
            let other = keys.sign(good.who, old.letter(&list).as_bytes());
            (
                "with a signature of another number",
                dressed(keys, Signing::Kept, &other, good.who, text.as_bytes()),
                Detection::ByAll,
            )
        }
        12 => ("with another comment", comment(&seal, dice), Detection::ByAll),
        13 => ("signed over itself", keys.sign(KeyHolder::Artist, &seal), Detection::ByAll),
        _ => ("without a signature", text.into_bytes(), Detection::ByAll),
    };
    stick.put(&path, new);
    (format!("the seal is {what}"), detection)
}

/// The seal with a signature whose lines are changed.
fn comment(seal: &[u8], dice: &mut Dice) -> Vec<u8> {
    let mut lines: Vec<Vec<u8>> = seal.split_inclusive(|byte| *byte == b'\n').map(<[u8]>::to_vec).collect();
    let at = dice.below(4);
    let before = lines[at].clone();
    match dice.below(4) {
        0 => lines.insert(at, before),
        1 => drop(lines.remove(at)),
        2 => lines[at].splice(0..0, dice.bytes(300)).for_each(drop),
        _ => {
            bytes::varied(&mut lines[at], dice);
            if lines[at] == before {
                lines[at].clear();
            }
        }
    }
    lines.concat()
}

/// Replaces a clip, and list and seal with it, signed by a key that must not.
fn changed_by_a_stranger(
    stick: &mut Stick,
    good: &Good,
    material: Material<'_>,
    dice: &mut Dice,
) -> (String, Detection) {
    let mut files = good.files.clone();
    let clip = files.get_mut("loops/0.mp4").expect("each flock here has it");
    let done = bytes::varied(clip, dice);
    stick.put_object(clip);
    let list = Good { files, ..good.clone() }.list();
    stick.put_object(list.as_bytes());
    let signing = *dice.of_these(&[
        Signing::By(KeyHolder::Stranger),
        Signing::By(KeyHolder::Lost),
        Signing::Claimed,
        Signing::Kept,
    ]);
    let text = good.letter(&list);
    let seal = dressed(material.keys(), signing, stick.bytes(&good.seal()), good.who, text.as_bytes());
    stick.put(&good.seal(), seal);
    (format!("a clip was changed, {signing:?}: {done}"), Detection::ByAllOrHarmless)
}
