//! The owner's settings of a display: connector, mode, rotation, signal range and margin.
//!
//! Owns these settings and their spelling. `kms/choose.rs` checks whether a display supports them.

use std::fmt;
use std::str::FromStr;
use timing::Rate;

/// The margin that may be set, in percent of the display's width and height, on each side.
const MARGIN_PERCENT: std::ops::RangeInclusive<u8> = 0..=20;
/// Allowed width and height of a mode in pixels.
const SIDE: std::ops::RangeInclusive<u32> = 64..=16_384;
/// The shortest allowed period of a refresh, in nanoseconds.
const SHORTEST_PERIOD_NS: u64 = 1_000_000;

/// The settings of a display. By default the display and its driver decide.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct OutputSettings {
    /// The connector to use, as the kernel names it: `HDMI-A-1`. `None` for the best one.
    pub connector: Option<String>,
    /// The mode to set. `None` for the best one.
    pub mode: Option<RequestedMode>,
    /// The rotation of the picture, added to that of a built-in panel.
    pub rotation: Rotation,
    /// Which levels of a channel are sent over the cable.
    pub range: SignalRange,
    /// How much of the display stays black at each side.
    pub margin: Margin,
}

/// A mode that is asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RequestedMode {
    /// Pixels across and down.
    pub size: (u32, u32),
    /// Vblanks per second; `None` for the best there is.
    pub refresh: Option<Rate>,
}

/// A rotation of the picture on the panel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Rotation {
    /// None.
    #[default]
    None,
    /// By 90 degrees clockwise.
    Clockwise90,
    /// By 180 degrees.
    Half,
    /// By 270 degrees clockwise.
    Clockwise270,
}

/// Which levels of a channel mean black and white on the cable.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SignalRange {
    /// What the display's own description says.
    #[default]
    Automatic,
    /// 0 and 255.
    Full,
    /// 16 and 235.
    Limited,
}

/// How much stays black at each side, in percent of the display's width and height.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Margin(u8);

/// A text that is no such setting.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum OutputError {
    /// For a margin.
    #[error("`{0}` is not a margin: expected a percentage from {start} to {end}", start = MARGIN_PERCENT.start(), end = MARGIN_PERCENT.end())]
    Margin(String),
    /// For a mode.
    #[error(
        "`{0}` is not a mode: expected `1920x1080`, or with a refresh rate `1920x1080@60`, `1920x1080@59.94` or `1920x1080@60000/1001`"
    )]
    Mode(String),
    /// For a range.
    #[error("`{0}` is not a signal range: expected `auto`, `full` or `limited`")]
    Range(String),
    /// For a rotation.
    #[error("`{0}` is not a rotation: expected 0, 90, 180 or 270")]
    Rotation(String),
}

impl Rotation {
    /// This one, and then `other`.
    #[must_use]
    pub fn then(self, other: Self) -> Self {
        Self::of_quarters(self.quarters() + other.quarters())
    }

    /// `size` as it is after the rotation.
    #[must_use]
    pub fn of_size(self, (width, height): (u32, u32)) -> (u32, u32) {
        match self {
            Self::None | Self::Half => (width, height),
            Self::Clockwise90 | Self::Clockwise270 => (height, width),
        }
    }

    /// Degrees clockwise.
    pub fn degrees(self) -> u32 {
        90 * u32::from(self.quarters())
    }

    fn quarters(self) -> u8 {
        match self {
            Self::None => 0,
            Self::Clockwise90 => 1,
            Self::Half => 2,
            Self::Clockwise270 => 3,
        }
    }

    fn of_quarters(quarters: u8) -> Self {
        match quarters % 4 {
            0 => Self::None,
            1 => Self::Clockwise90,
            2 => Self::Half,
            _ => Self::Clockwise270,
        }
    }
}

impl Margin {
    /// Percent of the display's width and height, on each side.
    pub fn percent(self) -> u8 {
        self.0
    }
}

impl RequestedMode {
    /// The mode's size and refresh, if both are set.
    pub fn exact(self) -> Option<((u32, u32), Rate)> {
        self.refresh.map(|refresh| (self.size, refresh))
    }
}

impl TryFrom<i64> for Rotation {
    type Error = OutputError;

    fn try_from(degrees: i64) -> Result<Self, OutputError> {
        match degrees {
            0 => Ok(Self::None),
            90 => Ok(Self::Clockwise90),
            180 => Ok(Self::Half),
            270 => Ok(Self::Clockwise270),
            _ => Err(OutputError::Rotation(degrees.to_string())),
        }
    }
}

impl TryFrom<i64> for Margin {
    type Error = OutputError;

    fn try_from(percent: i64) -> Result<Self, OutputError> {
        let fits = u8::try_from(percent).ok().filter(|percent| MARGIN_PERCENT.contains(percent));
        fits.map(Self).ok_or_else(|| OutputError::Margin(percent.to_string()))
    }
}

impl FromStr for Rotation {
    type Err = OutputError;

    fn from_str(text: &str) -> Result<Self, OutputError> {
        let wrong = |_| OutputError::Rotation(text.to_owned());
        text.parse::<i64>().map_err(wrong)?.try_into()
    }
}

impl FromStr for Margin {
    type Err = OutputError;

    fn from_str(text: &str) -> Result<Self, OutputError> {
        let wrong = |_| OutputError::Margin(text.to_owned());
        text.parse::<i64>().map_err(wrong)?.try_into()
    }
}

impl FromStr for SignalRange {
    type Err = OutputError;

    fn from_str(text: &str) -> Result<Self, OutputError> {
        match text {
            "auto" => Ok(Self::Automatic),
            "full" => Ok(Self::Full),
            "limited" => Ok(Self::Limited),
            _ => Err(OutputError::Range(text.to_owned())),
        }
    }
}

impl FromStr for RequestedMode {
    type Err = OutputError;

    fn from_str(text: &str) -> Result<Self, OutputError> {
        let read = || {
            let (size, refresh) = text.split_once('@').map_or((text, None), |(size, rate)| (size, Some(rate)));
            let (width, height) = size.split_once('x')?;
            let side = |text: &str| text.parse().ok().filter(|side| SIDE.contains(side));
            let refresh = match refresh {
                Some(refresh) => Some(rate(refresh)?),
                None => None,
            };
            Some(Self { size: (side(width)?, side(height)?), refresh })
        };
        read().ok_or_else(|| OutputError::Mode(text.to_owned()))
    }
}

/// `60`, `59.94` or `60000/1001` a second.
fn rate(text: &str) -> Option<Rate> {
    let rate = if let Some((num, den)) = text.split_once('/') {
        Rate::new(num.parse().ok()?, den.parse().ok()?)
    } else if let Some((whole, fraction)) = text.split_once('.') {
        let den = 10u64.checked_pow(u32::try_from(fraction.len()).ok()?)?;
        Rate::new(whole.parse::<u64>().ok()?.checked_mul(den)?.checked_add(fraction.parse().ok()?)?, den)
    } else {
        Rate::new(text.parse().ok()?, 1)
    };
    rate.ok().filter(|rate| rate.span_ns(1) >= SHORTEST_PERIOD_NS)
}

impl fmt::Display for RequestedMode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (width, height) = self.size;
        write!(f, "{width}x{height}")?;
        self.refresh.map_or(Ok(()), |refresh| write!(f, "@{refresh}"))
    }
}

impl fmt::Display for SignalRange {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Automatic => "auto",
            Self::Full => "full",
            Self::Limited => "limited",
        })
    }
}

#[cfg(test)]
mod tests {
    use super::{Margin, OutputError, RequestedMode, Rotation, SignalRange};
    use timing::Rate;

    #[test]
    fn rotations_add_up_and_quarters_swap_the_sides() {
        let all = [Rotation::None, Rotation::Clockwise90, Rotation::Half, Rotation::Clockwise270];
        for (quarters, rotation) in all.into_iter().enumerate() {
            assert_eq!(rotation.degrees(), 90 * quarters as u32);
            assert_eq!(rotation.degrees().to_string().parse(), Ok(rotation));
            for (more, other) in all.into_iter().enumerate() {
                assert_eq!(rotation.then(other), all[(quarters + more) % 4]);
            }
            let expected = if quarters % 2 == 1 { (720, 1280) } else { (1280, 720) };
            assert_eq!(rotation.of_size((1280, 720)), expected);
        }
    }

    #[test]
    fn modes_are_spelled_with_and_without_their_refresh() {
        let mode = |text: &str| text.parse::<RequestedMode>();
        let at = |n, d| Some(Rate::new(n, d).unwrap());
        for (text, size, refresh) in [
            ("1366x768", (1366, 768), None),
            ("1920x1080@60", (1920, 1080), at(60, 1)),
            ("640x480@59.94", (640, 480), at(5994, 100)),
            ("720x1280@60000/1001", (720, 1280), at(60_000, 1_001)),
        ] {
            assert_eq!(mode(text), Ok(RequestedMode { size, refresh }));
        }
        for wrong in
            ["", "1080p", "1920x", "1920x1080@", "1920x1080@0", "0x0", "1920X1080", "1920x1080@60Hz", "9x99999"]
        {
            assert_eq!(mode(wrong), Err(OutputError::Mode(wrong.to_owned())));
        }
    }

    #[test]
    fn what_is_no_setting_is_refused_by_name() {
        assert_eq!("15".parse::<Margin>().map(Margin::percent), Ok(15));
        assert_eq!("21".parse::<Margin>(), Err(OutputError::Margin("21".to_owned())));
        assert_eq!("-1".parse::<Margin>(), Err(OutputError::Margin("-1".to_owned())));
        assert_eq!("45".parse::<Rotation>(), Err(OutputError::Rotation("45".to_owned())));
        assert_eq!("full".parse(), Ok(SignalRange::Full));
        let refused = "16-235".parse::<SignalRange>().unwrap_err();
        assert_eq!(refused.to_string(), "`16-235` is not a signal range: expected `auto`, `full` or `limited`");
    }
}
