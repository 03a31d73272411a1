//! On which days the picture is shown, and between which times.
//!
//! Owns the spelling of hours and of closed days, and which moments of the local calendar they include. Hours over midnight
//! belong to the day on which they begin. Never reads a clock, never knows a time zone: the caller passes date and minute.
//!
//! Start at [`is_shown`].

use crate::day::Window;
use jiff::civil::{Date, Weekday};
use serde::Deserialize;
use std::ops::RangeInclusive;
use std::str::FromStr;
use toml::value::Datetime;

/// Windows of one week, or entries of closed days, at most.
const MOST: usize = 100;
/// A day of each name, from Monday, as people write it: two letters of it are enough.
const NAMES: [(&str, Weekday); 7] = [
    ("monday", Weekday::Monday),
    ("tuesday", Weekday::Tuesday),
    ("wednesday", Weekday::Wednesday),
    ("thursday", Weekday::Thursday),
    ("friday", Weekday::Friday),
    ("saturday", Weekday::Saturday),
    ("sunday", Weekday::Sunday),
];
/// A year that has every day.
const LEAP_YEAR: i16 = 2024;

/// When the picture is shown: the same times on all days, or times of some days of the week; not at all on the others.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(try_from = "String")]
pub struct Hours(Vec<(Weekdays, Window)>);

/// Days without the picture.
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(try_from = "Vec<Spelled>")]
pub struct Closed(Vec<Days>);

/// One text of hours that cannot be read.
#[derive(Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "`{0}` are not valid hours: two times of the day, as in `08:00-23:00`, or those of some days of the week, as in \
     `Tue-Fri 10:00-18:00, Sat-Sun 11:00-20:00`"
)]
pub struct NoHours(pub String);

/// One text of closed days that cannot be read.
#[derive(Debug, PartialEq, Eq, thiserror::Error)]
pub enum NoClosed {
    /// It names no day.
    #[error(
        "`{0}` is not a valid closed day: expected days of the week, as in `Mon`, a day of every year, as in `12-25`, a \
         date, as in `2026-12-24`, or two of these with ` to ` between them"
    )]
    Day(String),
    /// There are too many.
    #[error("{0} closed days are given: expected {MOST} at most; combine days that follow each other with ` to `")]
    TooMany(usize),
}

/// Days of the week, the first bit for Monday.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Weekdays(u8);

/// Some days.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Days {
    OfWeek(Weekdays),
    /// Month and day, of every year; over the new year if the second is earlier.
    OfYear((i8, i8), (i8, i8)),
    /// Of one year, or several.
    Dates(RangeInclusive<Date>),
}

/// Whether the picture is shown at `minute` of `date`: within `hours`, at any time if there are none, and not on a day that
/// is `closed`.
pub fn is_shown(hours: Option<&Hours>, closed: &Closed, date: Date, minute: u64) -> bool {
    let is_open = |date: Date| !closed.include(date);
    let Some(Hours(windows)) = hours else { return is_open(date) };
    windows.iter().any(|(days, window)| {
        let begins = |date: Date| days.include(date.weekday()) && is_open(date);
        (window.includes_of_its_day(minute) && begins(date))
            || (window.includes_of_next_day(minute) && date.yesterday().is_ok_and(begins))
    })
}

impl Weekdays {
    const ALL: Self = Self(0b111_1111);

    /// The days that `text` names, as `Tue`, or `Sat-Mon`.
    fn parse(text: &str) -> Option<Self> {
        let (from, to) = text.split_once('-').unwrap_or((text, text));
        let (from, to) = (weekday(from)?, weekday(to)?);
        let count = (to + 7 - from) % 7;
        Some((0..=count).fold(Self::default(), |days, after| Self(days.0 | 1 << ((from + after) % 7))))
    }

    fn include(self, day: Weekday) -> bool {
        self.0 & 1 << day.to_monday_zero_offset() != 0
    }

    fn and(self, others: Self) -> Self {
        Self(self.0 | others.0)
    }
}

/// Days from Monday to the one that `text` names.
fn weekday(text: &str) -> Option<i8> {
    let text = text.trim().to_ascii_lowercase();
    let is_named = |name: &str| text.len() >= 2 && name.starts_with(&text);
    NAMES.iter().find(|(name, _)| is_named(name)).map(|(_, day)| day.to_monday_zero_offset())
}

impl FromStr for Hours {
    type Err = NoHours;

    fn from_str(text: &str) -> Result<Self, NoHours> {
        windows(text).filter(|windows| windows.len() <= MOST).map(Self).ok_or_else(|| NoHours(text.to_owned()))
    }
}

/// The windows in `text`: each with times, and before them the days that have not got any yet.
fn windows(text: &str) -> Option<Vec<(Weekdays, Window)>> {
    let mut windows = Vec::new();
    let mut waiting = Weekdays::default();
    let mut names_days = None;
    for part in text.split(',').map(str::trim) {
        if part.is_empty() {
            return None;
        }
        let (days, times) = part.rsplit_once(' ').unwrap_or(if part.contains(':') { ("", part) } else { (part, "") });
        let has_days = !days.is_empty() || waiting != Weekdays::default();
        if *names_days.get_or_insert(has_days) != has_days {
            return None;
        }
        if !days.is_empty() {
            waiting = waiting.and(Weekdays::parse(days)?);
        }
        if !times.is_empty() {
            let days = if has_days { std::mem::take(&mut waiting) } else { Weekdays::ALL };
            if !times.eq_ignore_ascii_case("closed") {
                windows.push((days, Window::parse(times)?));
            } else if !has_days {
                return None;
            }
        }
    }
    (waiting == Weekdays::default() && !windows.is_empty()).then_some(windows)
}

impl Closed {
    fn include(&self, date: Date) -> bool {
        self.0.iter().any(|days| days.include(date))
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

impl Days {
    /// The days that `text` names.
    fn parse(text: &str) -> Option<Self> {
        let (from, to) = text.split_once(" to ").unwrap_or((text, text));
        let (from, to) = (from.trim(), to.trim());
        if let (Some(from), Some(to)) = (date(from), date(to)) {
            return (from <= to).then_some(Self::Dates(from..=to));
        }
        if let (Some(from), Some(to)) = (day_of_year(from), day_of_year(to)) {
            return Some(Self::OfYear(from, to));
        }
        let week = if from == to { Weekdays::parse(from) } else { Weekdays::parse(&format!("{from}-{to}")) };
        week.map(Self::OfWeek)
    }

    fn include(&self, date: Date) -> bool {
        match self {
            Self::OfWeek(days) => days.include(date.weekday()),
            Self::OfYear(from, to) => {
                let day = (date.month(), date.day());
                if from <= to { (*from..=*to).contains(&day) } else { day >= *from || day <= *to }
            }
            Self::Dates(dates) => dates.contains(&date),
        }
    }
}

/// A date, as `2026-12-24`. Its own reading allows a time of day behind it.
fn date(text: &str) -> Option<Date> {
    text.parse().ok().filter(|_| text.len() == "2026-12-24".len())
}

/// Month and day, as `12-25`.
fn day_of_year(text: &str) -> Option<(i8, i8)> {
    let date = format!("{LEAP_YEAR}-{text}").parse::<Date>().ok().filter(|_| text.len() == "12-25".len())?;
    Some((date.month(), date.day()))
}

/// A closed day as it stands in a file: a date of TOML has no quotation marks.
#[derive(Deserialize)]
#[serde(untagged, expecting = "days, as in `Mon`, `12-25` or `2026-12-24`")]
enum Spelled {
    Text(String),
    Date(Datetime),
}

impl TryFrom<Vec<Spelled>> for Closed {
    type Error = NoClosed;

    fn try_from(spelled: Vec<Spelled>) -> Result<Self, NoClosed> {
        if spelled.len() > MOST {
            return Err(NoClosed::TooMany(spelled.len()));
        }
        let days = |spelled: Spelled| {
            let text = match spelled {
                Spelled::Text(text) => text,
                Spelled::Date(date) => date.to_string(),
            };
            Days::parse(&text).ok_or(NoClosed::Day(text))
        };
        spelled.into_iter().map(days).collect::<Result<_, _>>().map(Self)
    }
}

crate::from_string!(NoHours: Hours);

#[cfg(test)]
mod tests {
    use super::{Closed, Hours, MOST, NoHours, is_shown};
    use jiff::civil::Date;
    use serde::Deserialize;

    #[derive(Deserialize)]
    struct Settings {
        closed: Closed,
    }

    fn closed(list: &str) -> Result<Closed, String> {
        let settings = toml::from_str::<Settings>(&format!("closed = [{list}]"));
        settings.map(|settings| settings.closed).map_err(|error| error.message().to_owned())
    }

    fn date(text: &str) -> Date {
        text.parse().unwrap()
    }

    /// The hours of each day of the week from Monday 2026-11-23 on which the picture is shown at half past.
    fn week(hours: &str) -> [String; 7] {
        let hours: Hours = hours.parse().unwrap();
        let mut date = date("2026-11-23");
        [(); 7].map(|()| {
            let is_shown = |hour: &u64| is_shown(Some(&hours), &Closed::default(), date, hour * 60 + 30);
            let shown: Vec<_> = (0..24).filter(is_shown).map(|hour| hour.to_string()).collect();
            date = date.tomorrow().unwrap();
            shown.join(" ")
        })
    }

    #[test]
    fn hours_are_those_of_the_days_that_are_named_and_of_no_other_day() {
        assert_eq!(week("08:00-10:00"), ["8 9"; 7]);
        assert_eq!(week("08:00-09:00, 20:00-21:00"), ["8 20"; 7]);
        let museum = ["", "10", "10", "10", "10", "11 12", "11 12"];
        assert_eq!(week("Tue-Fri 10:00-11:00, Sat-Sun 11:00-13:00"), museum);
        assert_eq!(week("Mon closed, Tue-Fri 10:00-11:00, sat, SUNDAY 11:00-13:00"), museum);
        assert_eq!(week("Tu,We,Th-Fr 10:00-11:00, Sa-Su 11:00-13:00"), museum);
        assert_eq!(week("Sat-Mon 10:00-11:00"), ["10", "", "", "", "", "10", "10"]);
        assert_eq!(week("Fri 09:00-10:00, Fri 20:00-21:00"), ["", "", "", "", "9 20", "", ""]);
    }

    #[test]
    fn hours_over_midnight_belong_to_the_day_on_which_they_begin() {
        assert_eq!(week("Fri 22:00-02:00"), ["", "", "", "", "22 23", "0 1", ""]);
        assert_eq!(week("Sun 23:00-01:00")[6], "23", "the week before was the same");
        assert_eq!(week("Sun 23:00-01:00")[0], "0");
        let hours: Hours = "22:00-02:00".parse().unwrap();
        let closed = closed("\"2026-12-24\"").unwrap();
        let is_shown = |day: &str, hour: u64| is_shown(Some(&hours), &closed, date(day), hour * 60);
        assert!(is_shown("2026-12-24", 1), "of the 23rd");
        assert!(!is_shown("2026-12-24", 23) && !is_shown("2026-12-25", 1) && is_shown("2026-12-25", 23));
    }

    #[test]
    fn closed_days_are_those_of_a_week_of_a_year_or_of_the_calendar() {
        for (list, day, is_closed) in [
            ("\"Mon\"", "2026-11-23", true),
            ("\"Mon\"", "2026-11-24", false),
            ("\"Mon to Tue\"", "2026-11-24", true),
            ("\"Mon-Tue\"", "2026-11-24", true),
            ("\"12-25\"", "2026-12-25", true),
            ("\"12-25\"", "2041-12-25", true),
            ("\"12-25\"", "2026-12-26", false),
            ("\"12-24 to 01-02\"", "2027-01-02", true),
            ("\"12-24 to 01-02\"", "2026-12-24", true),
            ("\"12-24 to 01-02\"", "2026-12-23", false),
            ("\"02-29\"", "2028-02-29", true),
            ("\"2026-12-24\"", "2026-12-24", true),
            ("\"2026-12-24\"", "2027-12-24", false),
            ("2026-12-24", "2026-12-24", true),
            ("2026-12-26, \"2026-12-28 to 2027-01-03\"", "2027-01-01", true),
            ("2026-12-26, \"2026-12-28 to 2027-01-03\"", "2027-01-04", false),
            ("", "2026-12-24", false),
        ] {
            let closed = closed(list).unwrap();
            assert_eq!(!is_shown(None, &closed, date(day), 12 * 60), is_closed, "{list} on {day}");
        }
    }

    #[test]
    fn what_names_no_day_or_no_time_is_refused_by_name() {
        for wrong in [
            "",
            "08:00",
            "8:00-9:00",
            "08:00-24:00",
            "08:00-08:00",
            "08:00-09:00,",
            "Mon",
            "Mon closed",
            "closed",
            "M 08:00-09:00",
            "Montag 08:00-09:00",
            "Mon08:00-09:00",
            "Mon 08:00-09:00, 10:00-11:00",
            "08:00-09:00, Mon 10:00-11:00",
            "Mon 08:00-09:00, Tue",
            "Mon-Tue-Wed 08:00-09:00",
        ] {
            assert_eq!(wrong.parse::<Hours>(), Err(NoHours(wrong.to_owned())));
        }
        for wrong in
            ["", "Christmas", "13-01", "02-30", "2026-02-29", "2026-12-24 to 2026-12-23", "24.12.", "2026-12-24 to Mon"]
        {
            let refused = closed(&format!("\"{wrong}\"")).unwrap_err();
            assert!(refused.contains(&format!("`{wrong}` is not a valid closed day")), "{refused}");
        }
        for wrong in ["7", "2026-12-24T08:00:00", "08:00:00"] {
            closed(wrong).unwrap_err();
        }
        let many = vec!["\"Mon\""; MOST + 1].join(", ");
        assert!(closed(&many).unwrap_err().contains("101 closed days are given: expected 100 at most"));
    }
}
