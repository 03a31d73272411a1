//! Somebody else has signed it, or the artist something else.
//!
//! Owns seals of other bundles, of other keys, of before, and signatures that belong to something else. Never changes what a
//! seal vouches for, but where somebody signs the change who may not.
//!
//! Start at [`change`].

use super::fields::{Dress, dressed};
use super::keys::Who;
use super::{Dice, Good, PLAYED, Seen, Stick, Stuff};
use crate::mutator::bytes;

/// Bytes that a seal may have.
const LARGEST: usize = 16 << 10;

/// Lays out another seal; what it is.
pub(super) fn change(stick: &mut Stick, good: &Good, stuff: Stuff<'_>, dice: &mut Dice) -> (String, Seen) {
    let keys = stuff.keys();
    let (path, list) = (good.seal(), good.list());
    let (seal, text) = (good.stick.bytes(&path).to_vec(), good.letter(&list));
    let of_before = || Good { sequence: 1 + text.len() as u64 % PLAYED, ..good.clone() }.letter(&list);
    let (what, new, seen) = match dice.below(15) {
        0 => {
            let other = stuff.other(dice);
            ("that of another bundle", other.stick.bytes(&other.seal()).to_vec(), Seen::ByUnits)
        }
        1 => ("a stranger's", keys.sign(Who::Stranger, text.as_bytes()), Seen::ByAll),
        2 => ("of a key that was called back", keys.sign(Who::Lost, text.as_bytes()), Seen::ByAll),
        3 => (
            "a stranger's in the artist's name",
            keys.sign_as(Who::Stranger, Who::Artist, text.as_bytes()),
            Seen::ByAll,
        ),
        4 => {
            stick.0.remove("statements");
            ("of a key that nobody vouches for", keys.sign(Who::New, text.as_bytes()), Seen::ByAll)
        }
        5 => ("older than what was played", keys.sign(Who::Artist, of_before().as_bytes()), Seen::ByUnits),
        6 => return changed_by_a_stranger(stick, good, stuff, dice),
        7 => {
            let said = keys.trust(Who::Artist, Who::New);
            (
                "a signature of something else",
                dressed(keys, Dress::Kept, &said, Who::Artist, text.as_bytes()),
                Seen::ByAll,
            )
        }
        8 => ("a statement", keys.trust(Who::Artist, Who::New), Seen::ByAll),
        9 => ("followed by itself", [&seal[..], &seal].concat(), Seen::ByAll),
        10 => {
            let mut long = seal.clone();
            long.resize(LARGEST + dice.below(3), b'\n');
            ("filled up to its limit", long, Seen::ByAll)
        }
        11 => {
            let old = Good { sequence: good.sequence + 1, ..good.clone() };
            let other = keys.sign(good.who, old.letter(&list).as_bytes());
            (
                "with a signature of another number",
                dressed(keys, Dress::Kept, &other, good.who, text.as_bytes()),
                Seen::ByAll,
            )
        }
        12 => ("with another comment", comment(&seal, dice), Seen::ByAll),
        13 => ("signed over itself", keys.sign(Who::Artist, &seal), Seen::ByAll),
        _ => ("without a signature", text.into_bytes(), Seen::ByAll),
    };
    stick.put(&path, new);
    (format!("the seal is {what}"), seen)
}

/// The seal with a signature whose lines are not as they were.
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

/// A clip is another one, all papers name it, and somebody signs who may not.
fn changed_by_a_stranger(stick: &mut Stick, good: &Good, stuff: Stuff<'_>, dice: &mut Dice) -> (String, Seen) {
    let mut files = good.files.clone();
    let clip = files.get_mut("loops/0.mp4").expect("each flock here has it");
    let done = bytes::varied(clip, dice);
    stick.put_object(clip);
    let list = Good { files, ..good.clone() }.list();
    stick.put_object(list.as_bytes());
    let dress = *dice.of_these(&[Dress::By(Who::Stranger), Dress::By(Who::Lost), Dress::Claimed, Dress::Kept]);
    let text = good.letter(&list);
    let seal = dressed(stuff.keys(), dress, stick.bytes(&good.seal()), good.who, text.as_bytes());
    stick.put(&good.seal(), seal);
    (format!("a clip was changed, {dress:?}: {done}"), Seen::ByAllOrHarmless)
}
