//! Times of the day.
//!
//! Owns their spelling, and which of them lie between two others. Never reads a clock, never knows a time zone: the caller
//! passes the minute.

/// Minutes of a day.
pub const DAY_MIN: u64 = 24 * 60;

/// From the first minute to before the last, over midnight if that is less.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Window {
    from_min: u64,
    to_min: u64,
}

impl Window {
    /// The window that `text` spells, as `02:00-05:30`; `None` if it spells none, or an empty one.
    pub fn parse(text: &str) -> Option<Self> {
        let (from, to) = text.split_once('-')?;
        let (from_min, to_min) = (minute(from)?, minute(to)?);
        (from_min != to_min).then_some(Self { from_min, to_min })
    }

    /// Whether `minute` of any day lies in it.
    pub fn includes(self, minute: u64) -> bool {
        self.includes_of_its_day(minute) || self.includes_of_next_day(minute)
    }

    /// Whether `minute` of the day on which it begins lies in it.
    pub fn includes_of_its_day(self, minute: u64) -> bool {
        minute >= self.from_min && (minute < self.to_min || self.is_over_midnight())
    }

    /// Whether `minute` of the day after lies in it.
    pub fn includes_of_next_day(self, minute: u64) -> bool {
        minute < self.to_min && self.is_over_midnight()
    }

    fn is_over_midnight(self) -> bool {
        self.to_min < self.from_min
    }
}

/// The minute of the day that `text` spells, as `07:30`.
pub fn minute(text: &str) -> Option<u64> {
    let (hours, minutes) = text.split_once(':')?;
    let digits = hours.len() == 2 && minutes.len() == 2 && text.bytes().all(|b| b.is_ascii_digit() || b == b':');
    let (hours, minutes) = (hours.parse::<u64>().ok()?, minutes.parse::<u64>().ok()?);
    (digits && hours < 24 && minutes < 60).then_some(hours * 60 + minutes)
}
