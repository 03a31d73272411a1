//! What the units have reported of their votes.
//!
//! Owns which reports are accepted, and the largest totals seen for each unit, ledger and sheep: any order, loss or
//! repetition of reports leads to the same totals. Reports are not signed and come from strangers' networks: only units
//! that the artist has named count, and neither the totals of a ledger nor those of a unit may grow faster than showings
//! can. A report that is refused changes nothing. Never reads a file or a clock.
//!
//! Start at [`Received::take`].

use crate::error::VotesError;
use crate::totals::{MOST_SHEEP, SheepTotals, Totals};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Ledgers of a unit, at most: one a year and then some.
const MOST_LEDGERS: usize = 32;
/// Characters of a unit's name that an error shows, at most.
const SHOWN: usize = 64;
/// No unit is older: 2026-01-01, in days since 1970. A clock that shows less was never set.
pub const FOUNDED_DAY: u32 = 20_454;
/// Seconds of a day.
pub const DAY_S: u64 = 86_400;

/// What the showings of a unit are limited by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct UnitLimits {
    /// The seconds of its flock's shortest loop, at least 1: a showing is not shorter.
    pub loop_s: u32,
}

/// What is known of the votes of all units.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Received {
    units: BTreeMap<String, (UnitLimits, Reported)>,
}

/// The totals that a unit has reported: the file `votes/UNIT.json` of a pool.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Reported {
    /// The largest totals of each ledger, by its number.
    ledgers: BTreeMap<String, Totals>,
}

impl Received {
    /// Makes `unit` known, with what `kept` has of it: the text that [`Self::to_json`] gave, if there is one.
    ///
    /// # Errors
    /// [`VotesError::Malformed`], if that cannot be read.
    pub fn know(&mut self, unit: &str, limits: UnitLimits, kept: Option<&str>) -> Result<(), VotesError> {
        let malformed = |error: serde_json::Error| VotesError::Malformed { message: error.to_string() };
        let reported = kept.map(|text| serde_json::from_str(text).map_err(malformed)).transpose()?;
        self.units.insert(unit.to_owned(), (limits, reported.unwrap_or_default()));
        Ok(())
    }

    /// Takes in the `document` that `unit` has sent, on the day `today` since 1970. Returns whether it said anything new.
    ///
    /// # Errors
    /// [`VotesError`]; nothing is changed then.
    pub fn take(&mut self, unit: &str, document: &[u8], today: u32) -> Result<bool, VotesError> {
        let Some((limits, reported)) = self.units.get_mut(unit) else {
            let plain = unit.chars().filter(char::is_ascii_graphic).take(SHOWN).collect();
            return Err(VotesError::Unknown { unit: plain });
        };
        let totals = Totals::parse(document)?;
        let ledger = totals.ledger.to_string();
        let known = reported.ledgers.get(&ledger);
        is_since(&totals, known, today)?;
        is_possible(&totals, *limits, today)?;
        if known.is_none() && reported.ledgers.len() >= MOST_LEDGERS {
            return Err(VotesError::Ledgers { unit: unit.to_owned(), ledger, most: MOST_LEDGERS });
        }
        let grown = merged(known, totals);
        is_possible(&grown, *limits, today)?;
        reported.is_possible_with(unit, &ledger, &grown, *limits, today)?;
        let is_news = known != Some(&grown);
        reported.ledgers.insert(ledger, grown);
        Ok(is_news)
    }

    /// The totals of `unit` by sheep, over all of its ledgers; empty if it is not known.
    pub fn totals(&self, unit: &str) -> BTreeMap<String, SheepTotals> {
        let ledgers = self.units.get(unit).into_iter().flat_map(|(_, reported)| reported.ledgers.values());
        let mut sums: BTreeMap<String, SheepTotals> = BTreeMap::new();
        for (id, totals) in ledgers.flat_map(|ledger| &ledger.sheep) {
            let sum = sums.entry(id.clone()).or_default();
            *sum = sum.plus(*totals);
        }
        sums
    }

    /// The units that are known.
    pub fn units(&self) -> impl Iterator<Item = &str> {
        self.units.keys().map(String::as_str)
    }

    /// What is known of `unit`, for its file; `None` if it is not known.
    ///
    /// # Panics
    /// Serializing names and numbers to memory cannot fail.
    pub fn to_json(&self, unit: &str) -> Option<String> {
        let (_, reported) = self.units.get(unit)?;
        Some(serde_json::to_string_pretty(reported).expect("totals are names and numbers"))
    }
}

impl Reported {
    /// Refuses more showings of `unit`, with `grown` in the place of `ledger`, than the days since its first ledger began
    /// allow: whoever invents ledgers gets no more votes by that.
    fn is_possible_with(
        &self,
        unit: &str,
        ledger: &str,
        grown: &Totals,
        limits: UnitLimits,
        today: u32,
    ) -> Result<(), VotesError> {
        let others = || self.ledgers.iter().filter(|(id, _)| *id != ledger).map(|(_, totals)| totals);
        let all = || others().chain([grown]);
        let most = all().map(|totals| most_showings(days(totals.since_day, today), limits)).max().unwrap_or_default();
        let found = all().map(|totals| sum(totals, |sheep| sheep.shown)).fold(0, u64::saturating_add);
        if found <= most || others().next().is_none() {
            return Ok(());
        }
        Err(VotesError::Sum { unit: unit.to_owned(), ledgers: all().count(), found, most, day: today })
    }
}

/// The days since the day `since_day`. Both days have begun and need not be over, on clocks that may differ.
fn days(since_day: u32, today: u32) -> u64 {
    u64::from(today.saturating_sub(since_day.max(FOUNDED_DAY))) + 2
}

/// The most showings in so many days.
fn most_showings(days: u64, limits: UnitLimits) -> u64 {
    days * DAY_S / u64::from(limits.loop_s.max(1))
}

/// The sum of a number over all sheep.
fn sum(totals: &Totals, number: fn(&SheepTotals) -> u32) -> u64 {
    totals.sheep.values().map(|sheep| u64::from(number(sheep))).sum()
}

/// Refuses a ledger that cannot have begun on its day.
fn is_since(totals: &Totals, known: Option<&Totals>, today: u32) -> Result<(), VotesError> {
    let found = totals.since_day;
    let is_a_day = found == 0 || (FOUNDED_DAY..=today.saturating_add(1)).contains(&found);
    let expected = match known {
        Some(known) if known.since_day != found => format!("day {}, as it said before", known.since_day),
        Some(_) | None if !is_a_day => format!("a day from {FOUNDED_DAY} to {today}"),
        Some(_) | None => return Ok(()),
    };
    Err(VotesError::Since { ledger: totals.ledger.to_string(), found, expected })
}

/// Refuses more showings, or a longer time of somebody near, than the days since the ledger began allow.
fn is_possible(totals: &Totals, limits: UnitLimits, today: u32) -> Result<(), VotesError> {
    let days = days(totals.since_day, today);
    let most = most_showings(days, limits);
    let found = sum(totals, |sheep| sheep.shown);
    let is_near_possible = sum(totals, |sheep| sheep.near_s) <= days * DAY_S;
    if found <= most && is_near_possible && totals.sheep.len() <= MOST_SHEEP {
        return Ok(());
    }
    Err(VotesError::Growth { ledger: totals.ledger.to_string(), found, most, day: today })
}

/// The larger totals of both, number by number, with no more votes than showings. A sheep that was never shown is left out.
fn merged(known: Option<&Totals>, new: Totals) -> Totals {
    let Totals { ledger, since_day, mut sheep } = new;
    sheep.retain(|_, totals| totals.shown > 0);
    for totals in sheep.values_mut() {
        *totals = totals.capped();
    }
    for (id, before) in known.into_iter().flat_map(|known| &known.sheep) {
        let totals = sheep.entry(id.clone()).or_default();
        *totals = totals.larger(*before);
    }
    Totals { ledger, since_day, sheep }
}

#[cfg(test)]
mod tests;
