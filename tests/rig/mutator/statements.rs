//! Changes the statements about keys.
//!
//! Owns statements that are missing, that come twice, too late or in thousands, and statements of keys that must not
//! make them. A trusted key never revokes another one: that would be valid.
//!
//! Start at [`change`].

use super::keys::KeyHolder;
use super::{Detection, Dice, Good, Material, Stick};
use crate::mutator::bytes;
use ct_codecs::{Base64, Encoder};

/// More statements than a unit reads.
const MANY: usize = 70;
const THOUSANDS: usize = 5_000;

/// Changes the statements; returns what was done.
pub(super) fn change(stick: &mut Stick, good: &Good, material: Material<'_>, dice: &mut Dice) -> (String, Detection) {
    let keys = material.keys();
    let said = stick.bytes("statements").to_vec();
    // The signature of the good statement is wrong for them, which every reader detects.
    let strangers = || [keys.state(KeyHolder::Stranger, "revoke 0000000000000000")].concat().repeat(THOUSANDS);
    let letter = good.letter(&good.list());
    let by_a_stranger = keys.sign(KeyHolder::Stranger, letter.as_bytes());
    let (what, new) = match dice.below(15) {
        0 => ("are gone", Vec::new()),
        1 => ("come twice", said.repeat(2)),
        2 => ("are a stranger's", keys.trust(KeyHolder::Stranger, KeyHolder::New)),
        3 => ("are a stranger's who calls everybody back", revocations(material).concat()),
        4 => ("come behind thousands of a stranger's", [strangers(), said].concat()),
        5 => ("come before thousands of a stranger's", [said, strangers()].concat()),
        6 => {
            let many: Vec<u8> = (0..MANY).flat_map(|_| keys.state(KeyHolder::Stranger, &any_key(dice))).collect();
            ("come behind 70 of a stranger's", [many, said].concat())
        }
        7 => ("come behind a line", [b"a line\n".to_vec(), said].concat()),
        8 => ("come behind a line without end", [vec![b'x'; 1 << 20], said].concat()),
        9 => {
            stick.put(&good.seal(), by_a_stranger);
            ("are a stranger's who has signed", keys.trust(KeyHolder::Stranger, KeyHolder::Stranger))
        }
        10 => {
            stick.put(&good.seal(), by_a_stranger);
            ("are of a key that was called back", [said, keys.trust(KeyHolder::Lost, KeyHolder::Stranger)].concat())
        }
        11 => {
            stick.put(&good.seal(), keys.sign_as(KeyHolder::Stranger, KeyHolder::Spare, letter.as_bytes()));
            let two = format!("trust {}", keys.line_as(KeyHolder::Stranger, KeyHolder::Spare));
            ("give a key the name of another", keys.state(KeyHolder::Artist, &two))
        }
        12 => {
            let wrong =
                ["trust", "trust ", "revoke", "revoke all", "trust RW", "trust ../key", "revoke 00", "believe me"];
            ("say what nobody can say", keys.state(KeyHolder::Artist, wrong[dice.below(wrong.len())]))
        }
        13 => {
            let ends = String::from_utf8(said).unwrap().replace('\n', "\r\n");
            ("end as on other systems", ends.into_bytes())
        }
        _ => {
            let mut changed = said;
            let done = bytes::varied(&mut changed, dice);
            stick.put("statements", changed);
            return (format!("the statements: {done}"), Detection::ByAllOrHarmless);
        }
    };
    stick.put("statements", new);
    (format!("the statements {what}"), Detection::ByAllOrHarmless)
}

/// A stranger's statements that revoke every key.
fn revocations(material: Material<'_>) -> Vec<Vec<u8>> {
    let keys = material.keys();
    let all = [KeyHolder::Artist, KeyHolder::Spare, KeyHolder::New];
    all.iter().map(|who| keys.state(KeyHolder::Stranger, &format!("revoke {}", keys.id(*who)))).collect()
}

/// A statement that trusts a key nobody has.
fn any_key(dice: &mut Dice) -> String {
    let raw = [b"Ed".to_vec(), dice.bytes(40)].concat();
    format!("trust {}", Base64::encode_to_string(raw).unwrap())
}
