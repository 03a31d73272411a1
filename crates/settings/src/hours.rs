//! The hours of the picture, and how bright it is in them.
//!
//! Owns the decision, a pure function of the time: at night the display sleeps, by day its brightness fades from step to
//! step. While the time is not known it is day. By local time: an hour that the clocks leave out is over at once, and
//! one that they repeat is kept both times. The same time says when the unit may restart into a new system. Never reads
//! a clock, never dims anything: `control/brightness.rs` does.
//!
//! Start at [`Day::lighting`].

use crate::day::{self, DAY_MIN};
use crate::week::{Closed, Hours, is_shown};
use jiff::Timestamp;
use jiff::civil::DateTime;
use jiff::tz::TimeZone;
use screen::PowerMeans;
use serde::Deserialize;
use std::ops::{Range, RangeInclusive};
use std::str::FromStr;

/// How long the way from one brightness to the next takes, where there is time for it.
const FADE_S: u64 = 600;
const DAY_S: u64 = DAY_MIN * 60;
/// Below the first a viewer cannot see whether the unit works.
const PERCENT: RangeInclusive<u16> = 1..=100;
/// One step an hour at most.
const STEPS: RangeInclusive<usize> = 1..=24;

/// How bright it is: one brightness for all the day, or from each of these times on.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(try_from = "Spelled")]
pub struct Brightness {
    /// Minute of the day, and percent; in the order of the day, no two at the same time.
    steps: Vec<(u64, u16)>,
}

/// What the display does at night.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(try_from = "String")]
pub enum Night {
    /// It is switched off.
    #[default]
    Off,
    /// It stays on and shows black: for displays that light a box of their own when there is no signal.
    Black,
    /// It is asked by HDMI-CEC to go into standby, and its signal is switched off.
    Cec,
    /// It is asked by DDC/CI to switch off, and its signal is switched off.
    Ddc,
}

impl Night {
    /// How the display itself is asked to switch off and on; `None` if it is not asked.
    pub fn power(self) -> Option<PowerMeans> {
        match self {
            Self::Off | Self::Black => None,
            Self::Cec => Some(PowerMeans::Cec),
            Self::Ddc => Some(PowerMeans::Ddc),
        }
    }
}

/// When a unit that shows its picture day and night may restart: minutes of the local day.
const RESTART_MIN: Range<u64> = 4 * 60..5 * 60;
/// How long a unit that does not know the time runs before it may restart.
const RESTART_AFTER_S: u64 = DAY_S;

/// What the hour wants.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lighting {
    /// A display that is switched off.
    Off,
    /// A black picture.
    Black,
    /// The picture.
    On {
        /// Of the light that there is.
        thousandths: u16,
    },
}

impl Lighting {
    /// The picture as it is.
    pub const FULL: Self = Self::On { thousandths: 1000 };
}

/// The time zone of the unit.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(try_from = "String")]
pub struct Zone(TimeZone);

/// A text that is none of them.
#[derive(Debug, PartialEq, Eq, thiserror::Error)]
pub enum NoSetting {
    /// For a brightness.
    #[error(
        "`{0}` is not a valid brightness: a percentage from 1 to 100, or some with their times, as in `07:00 100, 20:00 40`"
    )]
    Brightness(String),
    /// For a night.
    #[error("`{0}` is not a valid value of night: `off`, `black`, `ddc` or `cec`")]
    Night(String),
    /// For a time zone.
    #[error("`{0}` is not a valid time zone: its name, as in `Europe/Zurich`")]
    Zone(String),
}

/// What a unit was told about its days.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Day {
    /// When the picture is lit; `None` for always.
    pub hours: Option<Hours>,
    /// On which days it is not.
    pub closed: Closed,
    /// What the display does at other times.
    pub night: Night,
    /// How bright it is in them.
    pub brightness: Brightness,
    /// By which local time; `None` for the machine's own.
    pub zone: Option<Zone>,
}

impl Day {
    /// How bright the picture is to be at `known_s` seconds since 1970; `None` while the time is not known.
    pub fn lighting(&self, known_s: Option<u64>) -> Lighting {
        let Some(time) = known_s.and_then(|known_s| self.local_time(known_s)) else {
            return Lighting::On { thousandths: self.brightness.brightest() };
        };
        match self.night {
            _ if self.is_shown(time) => Lighting::On { thousandths: self.brightness.at(second(time)) },
            Night::Off | Night::Cec | Night::Ddc => Lighting::Off,
            Night::Black => Lighting::Black,
        }
    }

    /// Whether a unit that has run for `up_s` seconds may restart at `known_s` seconds since 1970: while the picture is dark;
    /// if that is never, from four to five in the morning; while the time is not known, after a day.
    pub fn allows_restart(&self, known_s: Option<u64>, up_s: u64) -> bool {
        let Some(time) = known_s.and_then(|known_s| self.local_time(known_s)) else { return up_s >= RESTART_AFTER_S };
        let is_early = RESTART_MIN.contains(&(second(time) / 60));
        !self.is_shown(time) || (self.hours.is_none() && is_early)
    }

    fn is_shown(&self, time: DateTime) -> bool {
        is_shown(self.hours.as_ref(), &self.closed, time.date(), second(time) / 60)
    }

    /// The local date and time; `None` for a time that no calendar has.
    fn local_time(&self, known_s: u64) -> Option<DateTime> {
        let zone = self.zone.as_ref().map_or_else(TimeZone::system, |zone| zone.0.clone());
        Some(Timestamp::from_second(i64::try_from(known_s).ok()?).ok()?.to_zoned(zone).datetime())
    }
}

/// The second of the day.
fn second(time: DateTime) -> u64 {
    let [hour, minute, second] = [time.hour(), time.minute(), time.second()].map(|part| u64::from(part.unsigned_abs()));
    hour * 3_600 + minute * 60 + second
}

impl Brightness {
    /// Always as bright as can be.
    pub fn full() -> Self {
        Self { steps: vec![(0, *PERCENT.end())] }
    }

    fn brightest(&self) -> u16 {
        self.steps.iter().map(|(_, percent)| percent * 10).max().unwrap_or(1_000)
    }

    /// Thousandths at `second` of the day. After each step's time the way leads evenly there from the step before.
    fn at(&self, second: u64) -> u16 {
        let count = self.steps.len();
        // Before the day's first step, the last one of yesterday holds.
        let reached = self.steps.iter().rposition(|(minute, _)| minute * 60 <= second).unwrap_or(count - 1);
        let (minute, to) = self.steps[reached];
        let (_, from) = self.steps[(reached + count - 1) % count];
        let (next, _) = self.steps[(reached + 1) % count];
        let since = (second + DAY_S - minute * 60) % DAY_S;
        let way = FADE_S.min(if count == 1 { DAY_S } else { (next * 60 + DAY_S - minute * 60) % DAY_S });
        let (from, to) = (u64::from(from) * 10, u64::from(to) * 10);
        let gone = since.min(way);
        ((from * (way - gone) + to * gone) / way) as u16
    }
}

impl FromStr for Brightness {
    type Err = NoSetting;

    fn from_str(text: &str) -> Result<Self, NoSetting> {
        let wrong = || NoSetting::Brightness(text.to_owned());
        let percent = |text: &str| {
            let digits = text.bytes().all(|byte| byte.is_ascii_digit());
            text.parse().ok().filter(|percent| digits && PERCENT.contains(percent))
        };
        if let Some(percent) = percent(text) {
            return Ok(Self { steps: vec![(0, percent)] });
        }
        let step = |step: &str| {
            let (time, value) = step.trim().split_once(' ')?;
            Some((day::minute(time)?, percent(value.trim())?))
        };
        let mut steps: Vec<(u64, u16)> = text.split(',').map(step).collect::<Option<_>>().ok_or_else(wrong)?;
        steps.sort_unstable();
        let is_twice = steps.windows(2).any(|pair| pair[0].0 == pair[1].0);
        if is_twice || !STEPS.contains(&steps.len()) { Err(wrong()) } else { Ok(Self { steps }) }
    }
}

impl FromStr for Night {
    type Err = NoSetting;

    fn from_str(text: &str) -> Result<Self, NoSetting> {
        match text {
            "off" => Ok(Self::Off),
            "black" => Ok(Self::Black),
            "cec" => Ok(Self::Cec),
            "ddc" => Ok(Self::Ddc),
            _ => Err(NoSetting::Night(text.to_owned())),
        }
    }
}

impl FromStr for Zone {
    type Err = NoSetting;

    fn from_str(text: &str) -> Result<Self, NoSetting> {
        TimeZone::get(text).map(Self).map_err(|_| NoSetting::Zone(text.to_owned()))
    }
}

/// A brightness as it stands in a file: a percentage may stand there as a number.
#[derive(Deserialize)]
#[serde(untagged, expecting = "a percentage from 1 to 100, or some with their times, as in `07:00 100, 20:00 40`")]
enum Spelled {
    Number(i64),
    Text(String),
}

impl TryFrom<Spelled> for Brightness {
    type Error = NoSetting;

    fn try_from(spelled: Spelled) -> Result<Self, NoSetting> {
        match spelled {
            Spelled::Number(percent) => percent.to_string().parse(),
            Spelled::Text(text) => text.parse(),
        }
    }
}

crate::from_string!(NoSetting: Night, Zone);

#[cfg(test)]
mod tests {
    use super::{Brightness, Closed, DAY_S, Day, Hours, Lighting, Night, NoSetting, Zone};
    use proptest::prelude::*;
    use screen::PowerMeans;

    /// 2026-07-01 00:00 in UTC, in seconds since 1970.
    const JULY_S: u64 = 1_782_864_000;
    const ON: Lighting = Lighting::FULL;

    fn day(hours: &str, brightness: &str, zone: &str) -> Day {
        Day {
            hours: Some(hours.parse::<Hours>().unwrap()),
            closed: Closed::default(),
            night: Night::Off,
            brightness: brightness.parse().unwrap(),
            zone: Some(zone.parse().unwrap()),
        }
    }

    /// Seconds since 1970 of a local time in a zone; of the first, where there are two.
    fn clock(local: &str, zone: &str) -> u64 {
        let local: jiff::civil::DateTime = local.parse().unwrap();
        local.in_tz(zone).unwrap().timestamp().as_second().unsigned_abs()
    }

    #[test]
    fn the_display_sleeps_outside_its_hours_by_local_time() {
        let zurich = "Europe/Zurich";
        for (hours, time, light) in [
            ("08:00-23:00", "07:59:59", Lighting::Off),
            ("08:00-23:00", "08:00:00", ON),
            ("08:00-23:00", "22:59:59", ON),
            ("08:00-23:00", "23:00:00", Lighting::Off),
            ("18:00-02:00", "17:59:59", Lighting::Off),
            ("18:00-02:00", "23:59:59", ON),
            ("18:00-02:00", "00:00:00", ON),
            ("18:00-02:00", "01:59:59", ON),
            ("18:00-02:00", "02:00:00", Lighting::Off),
        ] {
            for date in ["2026-01-15", "2026-07-15"] {
                let clock = clock(&format!("{date}T{time}"), zurich);
                assert_eq!(day(hours, "100", zurich).lighting(Some(clock)), light, "{hours} at {date} {time}");
            }
        }
    }

    #[test]
    fn a_night_in_black_begins_and_ends_with_the_others() {
        let black = Day { night: "black".parse().unwrap(), ..day("08:00-23:00", "40", "UTC") };
        let at = |hour: u64| black.lighting(Some(JULY_S + hour * 3_600));
        assert_eq!([at(7), at(8), at(23)], [Lighting::Black, Lighting::On { thousandths: 400 }, Lighting::Black]);
        assert_eq!(black.lighting(None), Lighting::On { thousandths: 400 }, "nobody knows the time");
        for (night, power) in [("ddc", Some(PowerMeans::Ddc)), ("cec", Some(PowerMeans::Cec)), ("off", None)] {
            let day = Day { night: night.parse().unwrap(), ..black.clone() };
            let at = |hour: u64| day.lighting(Some(JULY_S + hour * 3_600));
            assert_eq!(([at(7), at(23)], day.night.power()), ([Lighting::Off; 2], power), "{night}");
        }
    }

    #[test]
    fn hours_hold_on_the_days_when_the_clocks_change() {
        let zurich = "Europe/Zurich";
        // Over the night of the change, for each minute that its clocks show.
        for (noon, hours_of_night) in [("2026-03-28T12:00:00", 23), ("2026-10-24T12:00:00", 25)] {
            let (from, hours) = (clock(noon, zurich), day("02:30-06:00", "100", zurich));
            let lit = (0..hours_of_night * 60).filter(|minute| hours.lighting(Some(from + minute * 60)) == ON).count();
            // In March the clocks go from 2 to 3; in October the half hour after half past two comes twice.
            assert_eq!(lit, if hours_of_night == 23 { 180 } else { 240 });
            let day = day("08:00-23:00", "100", zurich);
            let lit = (0..hours_of_night * 60).filter(|minute| day.lighting(Some(from + minute * 60)) == ON).count();
            assert_eq!(lit, 15 * 60, "a day is as long as it always is");
        }
    }

    #[test]
    fn while_the_time_is_not_known_it_is_day() {
        let night = day("08:00-09:00", "07:00 80, 20:00 40", "UTC");
        for unknown in [None, Some(u64::MAX)] {
            assert_eq!(night.lighting(unknown), Lighting::On { thousandths: 800 }, "{unknown:?}");
        }
        assert_eq!(night.lighting(Some(JULY_S)), Lighting::Off);
        let machines = Day {
            hours: None,
            closed: Closed::default(),
            night: Night::Off,
            brightness: Brightness::full(),
            zone: None,
        };
        assert_eq!(machines.lighting(Some(JULY_S)), ON, "whatever the machine's own zone");
    }

    #[test]
    fn on_a_day_without_hours_or_a_closed_day_it_is_night() {
        // A Wednesday.
        let noon = JULY_S + DAY_S / 2;
        let museum = day("Tue-Fri 10:00-18:00, Sat-Sun 11:00-20:00", "100", "UTC");
        let of_week = [0, 1, 2, 3, 4, 5, 6].map(|after| museum.lighting(Some(noon + after * DAY_S)) == ON);
        assert_eq!(of_week, [true, true, true, true, true, false, true], "dark on Monday, six days after Wednesday");
        let closed: Closed =
            toml::from_str::<toml::Table>("closed = [2026-07-02]").unwrap()["closed"].clone().try_into().unwrap();
        for hours in [None, museum.hours.clone()] {
            let holiday = Day { hours, closed: closed.clone(), ..museum.clone() };
            let of_week = [0, 1, 2].map(|after| holiday.lighting(Some(noon + after * DAY_S)));
            assert_eq!(of_week, [ON, Lighting::Off, ON]);
            assert!(holiday.allows_restart(Some(noon + DAY_S), 0) && !holiday.allows_restart(Some(noon), 0));
        }
    }

    #[test]
    fn a_unit_restarts_while_it_is_dark_else_at_four_and_without_a_clock_after_a_day() {
        let zurich = "Europe/Zurich";
        let dark = day("08:00-23:00", "100", zurich);
        let lit = Day { hours: None, ..dark.clone() };
        for (day, time, is_allowed) in [
            (&dark, "22:59:59", false),
            (&dark, "23:00:00", true),
            (&dark, "07:59:59", true),
            (&dark, "08:00:00", false),
            (&lit, "03:59:59", false),
            (&lit, "04:00:00", true),
            (&lit, "04:59:59", true),
            (&lit, "05:00:00", false),
            (&lit, "23:30:00", false),
        ] {
            for date in ["2026-01-15", "2026-07-15"] {
                let found = day.allows_restart(Some(clock(&format!("{date}T{time}"), zurich)), 10 * DAY_S);
                assert_eq!(found, is_allowed, "{date} {time} {:?}", day.hours);
            }
        }
        for day in [&dark, &lit] {
            assert_eq!([0, DAY_S - 1, DAY_S].map(|up_s| day.allows_restart(None, up_s)), [false, false, true]);
        }
    }

    #[test]
    fn brightness_goes_gently_from_step_to_step() {
        let steps: Brightness = "20:00 40, 07:00 100".parse().unwrap();
        let at = |hour: u64, minute: u64, second: u64| steps.at(hour * 3_600 + minute * 60 + second);
        assert_eq!([at(6, 59, 59), at(7, 0, 0), at(7, 5, 0), at(7, 10, 0)], [400, 400, 700, 1000]);
        assert_eq!([at(19, 59, 59), at(20, 0, 0), at(20, 1, 0), at(20, 10, 0)], [1000, 1000, 940, 400]);
        assert_eq!([at(23, 59, 59), at(0, 0, 0)], [400, 400], "over midnight");
        let late: Brightness = "23:55 50, 12:00 100".parse().unwrap();
        assert_eq!([late.at(DAY_S - 60), late.at(0), late.at(60)], [800, 750, 700], "a way leads over midnight");
    }

    #[test]
    fn what_is_no_setting_is_refused_by_name() {
        for wrong in ["", "0", "101", "+5", "07:00", "07:00 0", "07:00 50,", "07:00 50, 07:00 60", "50, 07:00 60"] {
            assert_eq!(wrong.parse::<Brightness>(), Err(NoSetting::Brightness(wrong.to_owned())), "{wrong}");
        }
        assert_eq!("dark".parse::<Night>(), Err(NoSetting::Night("dark".to_owned())));
        for wrong in ["", "Zurich", "Europe/Nowhere", "../../etc/passwd"] {
            assert_eq!(wrong.parse::<Zone>(), Err(NoSetting::Zone(wrong.to_owned())));
        }
        for (line, zone) in [("UTC", "UTC"), ("America/New_York", "America/New_York")] {
            assert!(line.parse::<Zone>().is_ok(), "{zone}");
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

        #[test]
        fn brightness_never_leaps_and_never_leaves_its_steps(
            steps in prop::collection::btree_map(0..1_440_u64, 1..=100_u16, 1..24),
        ) {
            let spelt: Vec<_> = steps.iter().map(|(min, percent)| format!("{:02}:{:02} {percent}", min / 60, min % 60)).collect();
            let brightness: Brightness = spelt.join(", ").parse().unwrap();
            let values: Vec<u16> = (0..DAY_S).map(|second| brightness.at(second)).collect();
            let (least, most) = (steps.values().min().unwrap() * 10, steps.values().max().unwrap() * 10);
            prop_assert!(values.iter().all(|value| (least..=most).contains(value)));
            let last = values[values.len() - 1];
            let leap = values.windows(2).map(|pair| pair[0].abs_diff(pair[1])).chain([last.abs_diff(values[0])]).max();
            // From one to a hundred percent within the shortest time between two steps, a minute.
            prop_assert!(leap <= Some(17), "{leap:?}");
        }

        #[test]
        fn the_light_is_a_function_of_the_local_time_alone(
            from in 0..1_440_u64, length in 1..1_440_u64, clock in JULY_S..JULY_S + 400 * DAY_S,
            zone in prop::sample::select(vec!["UTC", "Europe/Zurich", "America/St_Johns", "Australia/Lord_Howe", "Asia/Kathmandu"]),
        ) {
            let to = (from + length) % 1_440;
            let spelt = format!("{:02}:{:02}-{:02}:{:02}", from / 60, from % 60, to / 60, to % 60);
            let local = jiff::Timestamp::from_second(clock.cast_signed()).unwrap().in_tz(zone).unwrap();
            let minute = u64::from(local.hour().unsigned_abs()) * 60 + u64::from(local.minute().unsigned_abs());
            let is_day = (minute + 1_440 - from) % 1_440 < length;
            prop_assert_eq!(day(&spelt, "100", zone).lighting(Some(clock)) == ON, is_day);
        }
    }
}
