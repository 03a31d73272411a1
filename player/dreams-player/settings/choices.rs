//! Settings that are more than a number: which screen, which clock, where the status page is.
//!
//! Owns their spelling, the same in the config and on the command line. Never acts on them.

use serde::Deserialize;
use std::fmt;
use std::net::SocketAddr;
use std::path::PathBuf;
use std::str::FromStr;
use timing::Rate;

/// Which screen to light.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(try_from = "String")]
pub(crate) enum ScreenChoice {
    /// A KMS device if there is one to take, else the virtual screen.
    Auto,
    /// A KMS device: this one, or the best there is.
    Kms(Option<PathBuf>),
    /// A picture in memory, of this size and refresh or of the flock's own size at 60 Hz.
    Virtual(Option<((u32, u32), Rate)>),
}

/// What makes the vblanks of a virtual screen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(try_from = "String")]
pub(crate) enum Clock {
    /// Time does.
    Vblank,
    /// Frames do: it flips as fast as they come.
    Free,
}

/// Where the status page is served.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(try_from = "String")]
pub(crate) enum StatusAddress {
    /// Nowhere.
    Off,
    /// On a loopback address and port, as the user gave it.
    Host(String),
    /// On a unix socket.
    Unix(PathBuf),
}

/// Why a setting was refused.
#[derive(Debug, PartialEq, Eq, thiserror::Error)]
pub(crate) enum SettingError {
    #[error("`{0}` is not a valid clock: `vblank` or `free`")]
    Clock(String),
    #[error("`{0}` is not a loopback address and port, `off` or `unix:PATH`: the page is for this machine only")]
    Status(String),
    #[error("`{0}` is not a valid screen: `auto`, `kms[:DEVICE]` or `virtual[:WxH@HZ]`, as in `virtual:1280x720@60`")]
    Screen(String),
}

impl FromStr for ScreenChoice {
    type Err = SettingError;

    fn from_str(text: &str) -> Result<Self, SettingError> {
        let wrong = || SettingError::Screen(text.to_owned());
        match text.split_once(':') {
            None if text == "auto" => Ok(Self::Auto),
            None if text == "kms" => Ok(Self::Kms(None)),
            None if text == "virtual" => Ok(Self::Virtual(None)),
            Some(("kms", device)) if !device.is_empty() => Ok(Self::Kms(Some(device.into()))),
            Some(("virtual", mode)) => mode_of(mode).map(|mode| Self::Virtual(Some(mode))).ok_or_else(wrong),
            Some(_) | None => Err(wrong()),
        }
    }
}

/// `1280x720@60`, `640x480@59.94` or `640x480@60000/1001`.
fn mode_of(text: &str) -> Option<((u32, u32), Rate)> {
    let (size, refresh) = text.split_once('@')?;
    let (width, height) = size.split_once('x')?;
    let side = |text: &str| text.parse().ok().filter(|side| (2..=16_384).contains(side));
    let rate = if let Some((num, den)) = refresh.split_once('/') {
        Rate::new(num.parse().ok()?, den.parse().ok()?)
    } else if let Some((whole, fraction)) = refresh.split_once('.') {
        let den = 10u64.checked_pow(u32::try_from(fraction.len()).ok()?)?;
        Rate::new(whole.parse::<u64>().ok()?.checked_mul(den)?.checked_add(fraction.parse().ok()?)?, den)
    } else {
        Rate::new(refresh.parse().ok()?, 1)
    };
    Some(((side(width)?, side(height)?), rate.ok().filter(|rate| rate.span_ns(1) >= 1_000_000)?))
}

impl FromStr for Clock {
    type Err = SettingError;

    fn from_str(text: &str) -> Result<Self, SettingError> {
        match text {
            "vblank" => Ok(Self::Vblank),
            "free" => Ok(Self::Free),
            _ => Err(SettingError::Clock(text.to_owned())),
        }
    }
}

impl FromStr for StatusAddress {
    type Err = SettingError;

    fn from_str(text: &str) -> Result<Self, SettingError> {
        let loopback = || match text.parse::<SocketAddr>() {
            Ok(address) => address.ip().is_loopback(),
            Err(_) => {
                text.split_once(':').is_some_and(|(host, port)| host == "localhost" && port.parse::<u16>().is_ok())
            }
        };
        match text.strip_prefix("unix:") {
            _ if text == "off" => Ok(Self::Off),
            Some(path) if !path.is_empty() => Ok(Self::Unix(path.into())),
            None if loopback() => Ok(Self::Host(text.to_owned())),
            Some(_) | None => Err(SettingError::Status(text.to_owned())),
        }
    }
}

settings::from_string!(SettingError: ScreenChoice, Clock, StatusAddress);

impl fmt::Display for StatusAddress {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Off => f.write_str("off"),
            Self::Host(address) => write!(f, "http://{address}/"),
            Self::Unix(path) => write!(f, "unix:{}", path.display()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Clock, ScreenChoice, SettingError, StatusAddress};
    use timing::Rate;

    #[test]
    fn screens_are_spelled_as_the_contract_says() {
        let virtual_at = |w, h, n, d| Ok(ScreenChoice::Virtual(Some(((w, h), Rate::new(n, d).unwrap()))));
        assert_eq!("auto".parse(), Ok(ScreenChoice::Auto));
        assert_eq!("kms".parse(), Ok(ScreenChoice::Kms(None)));
        assert_eq!("kms:/dev/dri/card1".parse(), Ok(ScreenChoice::Kms(Some("/dev/dri/card1".into()))));
        assert_eq!("virtual".parse(), Ok(ScreenChoice::Virtual(None)));
        assert_eq!("virtual:1280x720@60".parse(), virtual_at(1280, 720, 60, 1));
        assert_eq!("virtual:640x480@59.94".parse(), virtual_at(640, 480, 5994, 100));
        assert_eq!("virtual:640x480@60000/1001".parse(), virtual_at(640, 480, 60_000, 1_001));
        for wrong in ["", "kms:", "vga", "virtual:", "virtual:640x480", "virtual:0x0@60", "virtual:640x480@0"] {
            assert_eq!(wrong.parse::<ScreenChoice>(), Err(SettingError::Screen(wrong.to_owned())));
        }
    }

    #[test]
    fn the_status_page_is_never_for_the_world() {
        for fine in ["127.0.0.1:80", "[::1]:7180", "localhost:0"] {
            assert_eq!(fine.parse(), Ok(StatusAddress::Host(fine.to_owned())));
        }
        assert_eq!("off".parse(), Ok(StatusAddress::Off));
        assert_eq!("unix:/run/dreams.sock".parse(), Ok(StatusAddress::Unix("/run/dreams.sock".into())));
        for wrong in ["192.0.2.1:80", "0.0.0.0:80", "unix:", "7180", "localhost:http", ""] {
            assert_eq!(wrong.parse::<StatusAddress>(), Err(SettingError::Status(wrong.to_owned())));
        }
    }

    #[test]
    fn there_are_two_clocks() {
        assert_eq!("free".parse(), Ok(Clock::Free));
        assert_eq!("vblank".parse(), Ok(Clock::Vblank));
        assert!("ntp".parse::<Clock>().is_err());
    }
}
