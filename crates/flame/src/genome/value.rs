//! Numbers as programs write them.
//!
//! Owns whole numbers that are written as reals, and centres that are not finite. Never knows an attribute's name.
//!
//! Start at [`integer`].

use std::borrow::Cow;

/// Whole numbers up to this one are exact as reals: 2^53.
const EXACT: f64 = 9_007_199_254_740_992.0;

/// The whole number of a value, which programs also write `1.0`.
pub(super) fn integer<T: TryFrom<i64>>(value: &str) -> Option<T> {
    let value = value.trim();
    let of_real = || {
        let real = value.parse::<f64>().ok()?;
        (real.fract() == 0.0 && real.abs() <= EXACT).then_some(real as i64)
    };
    value.parse::<i64>().ok().or_else(of_real)?.try_into().ok()
}

/// A list of numbers with 0 in place of each that is not finite: `nan`, `inf`, and `-1.#IND` and the like, as Windows
/// writes them.
pub(super) fn all_finite(value: &str) -> Cow<'_, str> {
    if value.split_whitespace().all(is_finite) {
        return Cow::Borrowed(value);
    }
    let words: Vec<&str> = value.split_whitespace().map(|word| if is_finite(word) { word } else { "0" }).collect();
    Cow::Owned(words.join(" "))
}

/// Whether a word is no number that is not finite.
fn is_finite(word: &str) -> bool {
    let name = word.trim_start_matches(['-', '+']).to_ascii_lowercase();
    let is_named = ["nan", "1.#ind", "1.#inf", "1.#qnan", "1.#snan"].iter().any(|start| name.starts_with(start));
    !is_named && word.parse::<f64>().map_or(true, f64::is_finite)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_whole_number_may_be_written_as_a_real() {
        let wanted = [("3", Some(3)), (" 100.0 ", Some(100)), ("1e2", Some(100)), ("-0.0", Some(0))];
        let refused = ["", "1.5", "-1", "x", "nan", "inf", "1e300", "4294967296.0"];
        for (value, number) in wanted.into_iter().chain(refused.map(|value| (value, None))) {
            assert_eq!(integer::<u32>(value), number, "{value}");
        }
        assert_eq!(integer::<i32>("-2.0"), Some(-2));
    }

    #[test]
    fn what_is_not_finite_counts_as_0_and_the_rest_stays() {
        for (value, wanted) in [
            ("nan nan", "0 0"),
            ("-nan(ind) 2", "0 2"),
            ("-1.#IND00 1.#QNAN", "0 0"),
            ("inf 0", "0 0"),
            ("3 -Infinity", "3 0"),
            ("-1.#INF00 1e400", "0 0"),
        ] {
            assert_eq!(all_finite(value), wanted);
        }
        for whole in ["1  2", "info 0", "x"] {
            assert_eq!(all_finite(whole), whole);
        }
    }
}
