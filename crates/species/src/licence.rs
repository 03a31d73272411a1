//! Which of two licences a child is under.
//!
//! Owns what licences demand, as far as it tells which is stricter. Never judges whether a licence was given, or whether
//! one allows to breed.
//!
//! Start at [`strictest`].

/// What a licence demands of those who show or change a work: whether names have to be told, more than in a notice; whether
/// what is made of it is under the same licence; whether it is not to be sold; whether nothing is to be made of it. `None`
/// if nobody here knows.
type Demands = Option<[bool; 4]>;

/// Licences that demand no more than a notice, by the beginnings of their names.
const FREE: [&str; 11] =
    ["0BSD", "APACHE-", "BSD-", "CC0-", "ISC", "MIT", "MIT-0", "PDDL-", "UNLICENSE", "WTFPL", "ZLIB"];
/// Licences whose works pass them on.
const SHARED: [&str; 6] = ["AGPL-", "FAL-", "GFDL-", "GPL-", "LGPL-", "MPL-"];

/// What joins licences that all hold.
const AND: &str = " AND ";

/// The licence of what is made of two works, as SPDX writes it: the stricter one, or both joined by `AND` where neither
/// demands all that the other does. Non-commercial is stricter than commercial, share-alike than attribution, attribution
/// than a notice. A licence that is not known is never left out. `None`, no licence, is the strictest.
pub fn strictest(a: Option<&str>, b: Option<&str>) -> Option<String> {
    let mut terms: Vec<&str> = terms(a?);
    terms.extend(self::terms(b?));
    terms.sort_unstable();
    terms.dedup();
    // Of two that demand the same, neither is left out.
    let is_left = |term: &&&str| terms.iter().all(|other| !exceeds(demands(other), demands(term)));
    let left: Vec<&str> = terms.iter().filter(is_left).copied().collect();
    let part =
        |term: &&str| if left.len() > 1 && term.contains(" OR ") { format!("({term})") } else { (*term).to_owned() };
    Some(left.iter().map(part).collect::<Vec<String>>().join(AND))
}

/// The parts of an expression that are joined by `AND`, without parentheses around them.
fn terms(expression: &str) -> Vec<&str> {
    let (mut depth, mut start, mut found) = (0_usize, 0, Vec::new());
    for (at, letter) in expression.char_indices() {
        match letter {
            '(' => depth += 1,
            ')' => depth = depth.saturating_sub(1),
            ' ' if depth == 0 && at >= start && expression[at..].starts_with(AND) => {
                found.push(&expression[start..at]);
                start = at + AND.len();
            }
            _ => {}
        }
    }
    found.push(&expression[start..]);
    let parts = found.into_iter().map(str::trim).flat_map(|term| inside(term).map_or(vec![term], terms));
    parts.filter(|term| !term.is_empty()).collect()
}

/// What is in the only pair of parentheses, if it is around all.
fn inside(term: &str) -> Option<&str> {
    term.strip_prefix('(')?.strip_suffix(')').filter(|inside| !inside.contains(['(', ')']))
}

/// What a licence demands, or the least of several that one may choose among.
fn demands(term: &str) -> Demands {
    term.split(" OR ").map(demands_of_one).reduce(|a, b| if a.is_none() || exceeds(a, b) { b } else { a }).flatten()
}

fn demands_of_one(name: &str) -> Demands {
    let name = name.trim().to_ascii_uppercase();
    let deed = name.split_once("CREATIVECOMMONS.ORG/LICENSES/").map(|(_, deed)| format!("CC-{deed}"));
    let name = deed.unwrap_or(name).replace([' ', '_', '/'], "-");
    let parts: Vec<&str> = name.split('-').collect();
    let begins = |with: &str| name == with || (with.ends_with('-') && name.starts_with(with));
    match parts[..] {
        ["CC", "BY", ..] => Some([true, parts.contains(&"SA"), parts.contains(&"NC"), parts.contains(&"ND")]),
        _ if FREE.iter().any(|free| begins(free)) => Some([false; 4]),
        _ if SHARED.iter().any(|shared| begins(shared)) => Some([true, true, false, false]),
        _ => None,
    }
}

/// Whether what `a` demands is all that `b` does, and more.
fn exceeds(a: Demands, b: Demands) -> bool {
    a.zip(b).is_some_and(|(a, b)| a != b && a.iter().zip(b).all(|(a, b)| *a || !b))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_child_is_under_the_strictest_licence_of_its_parents() {
        for (a, b, wanted) in [
            ("MIT", "CC0-1.0", "CC0-1.0 AND MIT"),
            ("MIT OR Apache-2.0", "CC-BY-4.0", "CC-BY-4.0"),
            ("CC-BY-4.0", "CC-BY-SA-4.0", "CC-BY-SA-4.0"),
            ("CC-BY-4.0", "CC-BY-NC-3.0", "CC-BY-NC-3.0"),
            ("CC-BY-SA-4.0", "CC-BY-NC-SA-4.0", "CC-BY-NC-SA-4.0"),
            ("CC-BY-NC-4.0", "CC-BY-NC-ND-4.0", "CC-BY-NC-ND-4.0"),
            ("GPL-3.0-or-later", "CC-BY-4.0", "GPL-3.0-or-later"),
            // Neither demands all that the other does: both hold.
            ("CC-BY-SA-4.0", "CC-BY-NC-4.0", "CC-BY-NC-4.0 AND CC-BY-SA-4.0"),
            ("CC-BY-3.0", "CC-BY-4.0", "CC-BY-3.0 AND CC-BY-4.0"),
            ("CC-BY-3.0 AND CC-BY-4.0", "CC-BY-4.0", "CC-BY-3.0 AND CC-BY-4.0"),
            ("CC-BY-3.0 AND (MIT OR Apache-2.0)", "CC-BY-NC-4.0", "CC-BY-NC-4.0"),
            ("MIT OR Apache-2.0", "Zlib", "(MIT OR Apache-2.0) AND Zlib"),
            // Of several that one may choose among, the easiest counts.
            ("CC-BY-NC-4.0 OR CC-BY-4.0", "CC-BY-SA-4.0", "CC-BY-SA-4.0"),
            // What nobody here knows is never left out, and leaves nothing out.
            ("LicenseRef-mine", "CC-BY-NC-4.0", "CC-BY-NC-4.0 AND LicenseRef-mine"),
            ("LicenseRef-mine", "LicenseRef-mine", "LicenseRef-mine"),
            // As people write them.
            ("CC BY 4.0", "cc by-nc 3.0", "cc by-nc 3.0"),
            (
                "https://creativecommons.org/licenses/by-nc-sa/4.0/",
                "CC-BY-NC-4.0",
                "https://creativecommons.org/licenses/by-nc-sa/4.0/",
            ),
        ] {
            assert_eq!(strictest(Some(a), Some(b)).as_deref(), Some(wanted), "{a} and {b}");
            assert_eq!(strictest(Some(b), Some(a)).as_deref(), Some(wanted), "{b} and {a}");
            assert_eq!(strictest(Some(a), None), None);
            assert_eq!(strictest(None, Some(b)), None);
        }
    }

    #[test]
    fn odd_expressions_do_no_harm() {
        for odd in ["", " AND ", "X AND AND Y", "(((", ")) AND ((", "(A AND (B", "é AND é", " OR "] {
            assert!(strictest(Some(odd), Some("MIT")).is_some_and(|both| both.contains("MIT")), "{odd}");
        }
    }
}
