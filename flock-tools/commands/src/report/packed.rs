//! Many ids and many numbers in few bytes of JSON.
//!
//! Owns the forms in which a page of a large flock holds its sheep: ids without what each has in common with the one before
//! it, numbers in as few digits as they need. `sheet/large_facts.js` reads both.
//!
//! Start at [`ids`] and [`Column::of`].

use std::collections::HashMap;

use ct_codecs::{Base64, Encoder as _};

/// The digits of a number below 64, as a page writes them.
const DIGITS: &[u8; 64] = b"0123456789ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz-_";
/// The most different numbers of a column that are told by their places in a list.
const MOST_FEW: usize = 256;

/// A number of each sheep.
#[derive(Debug, PartialEq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Column {
    /// The one that they all have.
    Same(f64),
    /// Different numbers, and for every sheep the place of its own among them: a byte, in base64.
    Few(Vec<f64>, String),
    /// The upper three bytes of a 32-bit float for every sheep, the highest first, in base64: 16 bits of precision.
    Many(String),
}

/// `ids`, each as a digit and a rest, with blanks between them: the digit tells how many characters it has in common with
/// the one before it.
///
/// # Source
/// Incremental encoding, as in the `locate` of Woods (1983).
pub(super) fn ids<'a>(ids: impl Iterator<Item = &'a str>) -> String {
    let (mut packed, mut before) = (String::new(), "");
    for id in ids {
        let common = id.bytes().zip(before.bytes()).take_while(|(a, b)| a == b).count().min(DIGITS.len() - 1);
        if !packed.is_empty() {
            packed.push(' ');
        }
        packed.push(char::from(DIGITS[common]));
        packed.push_str(&id[common..]);
        before = id;
    }
    packed
}

impl Column {
    /// The column of `numbers`, which are 0 or more. Those that are not 0 do not become 0.
    pub(super) fn of(numbers: &[f64]) -> Self {
        let (mut few, mut places, mut place_of) = (Vec::new(), Vec::new(), HashMap::new());
        for number in numbers {
            let place = *place_of.entry(number.to_bits()).or_insert(few.len());
            if place == few.len() {
                few.push(*number);
            }
            if few.len() > MOST_FEW {
                return Self::Many(base64(
                    &numbers.iter().flat_map(|&number| upper_bytes(number)).collect::<Vec<u8>>(),
                ));
            }
            places.push(place as u8);
        }
        match few[..] {
            [same] => Self::Same(same),
            _ => Self::Few(few, base64(&places)),
        }
    }
}

/// The upper three bytes of `number` as a 32-bit float, rounded.
fn upper_bytes(number: f64) -> [u8; 3] {
    let least = if number > 0.0 { f32::MIN_POSITIVE } else { 0.0 };
    let bits = (number as f32).max(least).to_bits();
    let [.., a, b, c] = ((bits + 0x80) >> 8).to_be_bytes();
    [a, b, c]
}

fn base64(bytes: &[u8]) -> String {
    Base64::encode_to_string(bytes).expect("its own buffer is long enough")
}

#[cfg(test)]
mod tests {
    use super::*;
    use ct_codecs::Decoder as _;

    /// What the page reads from packed ids.
    fn unpacked(packed: &str) -> Vec<String> {
        let mut ids: Vec<String> = Vec::new();
        for entry in packed.split(' ').filter(|entry| !entry.is_empty()) {
            let common = DIGITS.iter().position(|&digit| digit == entry.as_bytes()[0]).unwrap();
            let before = ids.last().map_or("", String::as_str);
            ids.push(format!("{}{}", &before[..common], &entry[1..]));
        }
        ids
    }

    #[test]
    fn ids_are_told_by_what_they_have_of_their_own() {
        let long = "x".repeat(63);
        let all = ["a", "a.1", "a.12", "b", &long, &format!("{long}y"), "y"];
        assert_eq!(ids(all[..4].iter().copied()), "0a 1.1 32 0b");
        assert_eq!(unpacked(&ids(all.iter().copied())), all);
        assert_eq!(ids(std::iter::empty()), "");
    }

    #[test]
    fn numbers_take_as_many_bytes_as_they_need() {
        assert_eq!(Column::of(&[2.5; 7]), Column::Same(2.5));
        assert_eq!(Column::of(&[1.0, 3.0, 1.0]), Column::Few(vec![1.0, 3.0], base64(&[0, 1, 0])));
        let many: Vec<f64> = (0..1000).map(|at| f64::from(at) / 7e5).chain([1e-300]).collect();
        let Column::Many(text) = Column::of(&many) else { panic!("they are all different") };
        let bytes = ct_codecs::Base64::decode_to_vec(text, None).unwrap();
        for (number, bytes) in many.iter().zip(bytes.chunks_exact(3)) {
            let read = f64::from(f32::from_be_bytes([bytes[0], bytes[1], bytes[2], 0]));
            assert!((read - number).abs() <= number * 2e-5 || *number < 1e-37, "{number} {read}");
            assert_eq!(read == 0.0, *number == 0.0, "{number}");
        }
    }
}
