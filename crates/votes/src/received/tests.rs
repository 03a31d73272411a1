//! Reports in any order, and reports of strangers.
//!
//! Owns the corpus of hostile reports, made of good ones by a source of chance that is the same each time.

use super::{MOST_LEDGERS, Received, UnitLimits};
use crate::totals::tests_random::random;
use crate::totals::{LONGEST, LedgerId, SheepTotals, Totals};
use proptest::collection::vec;
use proptest::prelude::{any, prop_assert_eq, proptest};

const TODAY: u32 = 20_600;
const SINCE: u32 = 20_500;
const LIMITS: UnitLimits = UnitLimits { loop_s: 20 };

fn known() -> Received {
    let mut received = Received::default();
    received.know("lobby", LIMITS, None).unwrap();
    received
}

/// A document of `count` sheep, each shown `shown` times and a bit.
fn totals(ledger: u64, count: u32, shown: u32) -> Totals {
    let one = |k: u32| SheepTotals { shown: shown + k, up: (shown + k) / 9, down: shown / 30, near_s: shown * 11 };
    let sheep = (0..count).map(|k| (format!("191.{k:05}"), one(k))).collect();
    Totals { ledger: LedgerId(ledger), since_day: SINCE, sheep }
}

proptest! {
    #[test]
    fn totals_survive_any_order_loss_and_repetition(
        steps in vec((0u32..5, 0u32..40, 0u32..40), 1..20),
        delivered in vec(any::<usize>(), 0..40),
    ) {
        // A unit's reports, whose totals only grow.
        let mut now = totals(1, 5, 100);
        let mut reports = vec![now.to_json()];
        for (sheep, shown, up) in steps {
            let totals = now.sheep.get_mut(&format!("191.{sheep:05}")).unwrap();
            totals.shown += shown;
            totals.up = (totals.up + up.min(shown)).min(totals.shown);
            totals.near_s += shown * 3;
            reports.push(now.to_json());
        }
        let (mut straight, mut shuffled) = (known(), known());
        straight.take("lobby", reports.last().unwrap().as_bytes(), TODAY).unwrap();
        let last = reports.len() - 1;
        let thinned = delivered.iter().map(|place| place % reports.len());
        for place in thinned.clone().chain([last]).chain(thinned) {
            shuffled.take("lobby", reports[place].as_bytes(), TODAY).unwrap();
        }
        prop_assert_eq!(shuffled.totals("lobby"), now.sheep);
        prop_assert_eq!(shuffled, straight);
    }
}

#[test]
fn the_largest_totals_of_each_ledger_are_kept_and_summed() {
    let mut received = known();
    assert!(received.take("lobby", totals(1, 2, 100).to_json().as_bytes(), TODAY).unwrap());
    assert!(!received.take("lobby", totals(1, 2, 90).to_json().as_bytes(), TODAY).unwrap(), "an older report");
    assert!(received.take("lobby", totals(2, 1, 50).to_json().as_bytes(), TODAY).unwrap(), "the unit began anew");
    let sheep = received.totals("lobby");
    assert_eq!((sheep["191.00000"].shown, sheep["191.00001"].shown), (150, 101));
    let kept = received.to_json("lobby").unwrap();
    let mut again = Received::default();
    again.know("lobby", LIMITS, Some(&kept)).unwrap();
    assert_eq!(again, received);
    assert_eq!((again.units().collect::<Vec<_>>(), again.to_json("stairs")), (vec!["lobby"], None));
    assert!(again.know("lobby", LIMITS, Some("{}")).is_err());
}

#[test]
fn no_more_votes_count_than_there_were_showings() {
    let mut received = known();
    let greedy = totals(1, 1, 10).to_json().replace("\"up\": 1", "\"up\": 4000000000");
    received.take("lobby", greedy.as_bytes(), TODAY).unwrap();
    assert_eq!(received.totals("lobby")["191.00000"].up, 10);
}

/// A document that a stranger may send, of kind `kind`, made of `good` by chance.
fn hostile(kind: u64, good: &Totals, random: &mut impl FnMut() -> u64) -> Vec<u8> {
    let text = good.to_json();
    let at = random() as usize % text.len();
    let sheep = format!("\"191.{:05}\"", random() % good.sheep.len() as u64);
    let mut changed = good.clone();
    match kind {
        // Cut off, or not text.
        0 => text[..at].into(),
        1 => [&text.as_bytes()[..at], &[0xff], &text.as_bytes()[at..]].concat(),
        2 => (0..at).map(|_| random() as u8).collect(),
        // Members that there are not, or are twice.
        3 => text.replace(&sheep, &format!("{sheep}: {{}}, {sheep}")).into(),
        4 => text.replacen('{', "{\"day_ms\": 4,", 1 + (random() % 3) as usize).into(),
        5 => text.replace("\"since_day\"", "\"since\"").into(),
        // Ids that a path or a terminal would take for something else.
        6 => text.replace(&sheep, ["\"../../etc\"", "\"a/b\"", "\"\\u0007\"", "\"\""][random() as usize % 4]).into(),
        7 => text.replace(&sheep, &format!("\"{}\"", "9".repeat(65 + at))).into(),
        // Numbers that are no totals.
        8 => text
            .replace("\"down\": ", ["\"down\": -", "\"down\": 1e", "\"down\": 9999999999"][random() as usize % 3])
            .into(),
        9 => text.replace("\"near_s\": ", "\"near_s\": [[[[[[[[[[").into(),
        // More than there can be.
        10 => "[".repeat(100_000).into(),
        11 => [text.as_bytes(), &vec![b' '; LONGEST]].concat(),
        12 => totals(random(), 5_000, 1).to_json().into(),
        // Faster than time, or at another time.
        13 => {
            changed.sheep.values_mut().for_each(|totals| totals.shown += 500_000 + (random() % 1_000_000) as u32);
            changed.to_json().into()
        }
        14 => {
            changed.sheep.values_mut().for_each(|totals| totals.near_s = u32::MAX - (random() % 9_000) as u32);
            changed.to_json().into()
        }
        15 => Totals { since_day: 1 + (random() % 20_000) as u32, ..changed }.to_json().into(),
        16 => Totals { since_day: TODAY + 2 + (random() % 900) as u32, ..changed }.to_json().into(),
        17 => Totals { ledger: LedgerId(1), since_day: SINCE + 1, ..changed }.to_json().into(),
        // Another number of the ledger than sixteen digits.
        18 => text.replacen("\"ledger\": \"", "\"ledger\": \"0", 1).into(),
        // An old report again.
        _ => totals(1, 3, 100 - (random() % 100) as u32).to_json().into(),
    }
}

#[test]
fn ten_thousand_hostile_reports_change_nothing() {
    let mut received = known();
    let good = totals(1, 3, 200);
    received.take("lobby", good.to_json().as_bytes(), TODAY).unwrap();
    let before = received.clone();
    let mut random = random(6);
    let mut refused = 0;
    for number in 0..10_000 {
        let (kind, document) = (number % 20, hostile(number % 20, &good, &mut random));
        let taken = received.take("lobby", &document, TODAY);
        refused += u32::from(taken.is_err());
        assert!(taken.is_err() == (kind < 19) || taken.is_ok_and(|is_news| !is_news), "kind {kind}, report {number}");
        assert!(received == before, "report {number} of kind {kind}: {}", String::from_utf8_lossy(&document));
    }
    assert_eq!(refused, 9_500);
    for unit in ["", "stairs", "Lobby", "lobby\u{1b}[2J"] {
        let said = received.take(unit, good.to_json().as_bytes(), TODAY).unwrap_err().to_string();
        assert!(said.contains("is not one of those that are known") && !said.contains('\u{1b}'), "{said}");
    }
    assert_eq!(received, before);
}

#[test]
fn a_flipped_byte_is_refused_or_within_what_time_allows() {
    let good = totals(1, 3, 200).to_json().into_bytes();
    for (at, bit) in (0..good.len()).flat_map(|at| (0..8).map(move |bit| (at, bit))) {
        let mut received = known();
        let mut flipped = good.clone();
        flipped[at] ^= 1 << bit;
        if received.take("lobby", &flipped, TODAY).is_ok() {
            let sheep = received.totals("lobby");
            assert!(sheep.len() <= 3 && sheep.values().all(|totals| totals.up <= totals.shown), "{at} {bit}");
        }
    }
}

#[test]
fn a_unit_has_no_end_of_ledgers() {
    let mut received = known();
    for ledger in 0..MOST_LEDGERS as u64 {
        received.take("lobby", totals(ledger, 1, 1).to_json().as_bytes(), TODAY).unwrap();
    }
    let said = received.take("lobby", totals(99, 1, 1).to_json().as_bytes(), TODAY).unwrap_err().to_string();
    assert_eq!(said, "unit `lobby` has 32 ledgers already, ledger 0000000000000063 is refused");
    assert!(received.take("lobby", totals(3, 1, 2).to_json().as_bytes(), TODAY).unwrap());
}

#[test]
fn invented_ledgers_give_no_more_showings_than_the_days_have() {
    let mut received = known();
    // 102 days of showings of 20 seconds.
    let most = 102 * 86_400 / 20;
    let taken = (0..32)
        .filter(|ledger| received.take("lobby", totals(*ledger, 1, 100_000).to_json().as_bytes(), TODAY).is_ok());
    assert_eq!(taken.count(), 4);
    let said = received.take("lobby", totals(99, 1, 100_000).to_json().as_bytes(), TODAY).unwrap_err().to_string();
    assert_eq!(
        said,
        format!(
            "the 5 ledgers of unit `lobby` together grow faster than showings can: 500000 showings, at most {most} by day \
             {TODAY}"
        )
    );
    // What is left is the unit's still.
    assert!(received.take("lobby", totals(99, 1, 40_000).to_json().as_bytes(), TODAY).unwrap());
    assert_eq!(received.totals("lobby")["191.00000"].shown, 440_000);
}
