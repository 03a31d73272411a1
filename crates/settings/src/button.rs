//! The buttons of voters, as settings name them: an input device, and its keys.
//!
//! Owns the names of keys that a setting may use, as Linux has them; every other key goes by its number. Never reads a
//! device.
//!
//! The crate `evdev` (0.13) knows all names, but adds seven crates to the programs of a unit and replaces 46 lines: the
//! settings name buttons, and `dreams-votes` reads a pipe like a device.
//!
//! # Source
//! `linux/input-event-codes.h`.

use serde::de::{Error, Unexpected, Visitor};
use serde::{Deserialize, Deserializer};
use std::borrow::Cow;
use std::fmt;
use std::path::PathBuf;

/// The folder of the votes, where no config names another.
pub const VOTES_FOLDER: &str = "/var/lib/dreams/votes";
/// What stands for every key of a device, and for every device.
const ANY: &str = "any";

/// The input device with the buttons.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ButtonDevice {
    /// Every input device that is plugged in, at any time.
    Any,
    /// The one of this path, where it is plugged in.
    At(PathBuf),
}

impl<'de> Deserialize<'de> for ButtonDevice {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        let name = String::deserialize(from)?;
        match name.as_str() {
            ANY => Ok(Self::Any),
            path if path.starts_with('/') => Ok(Self::At(name.into())),
            other => Err(D::Error::invalid_value(Unexpected::Str(other), &"`any`, or a path below /dev/input")),
        }
    }
}

/// Keys of buttons, pedals, keyboards, presenters and remote controls.
const NAMES: [(&str, u16); 46] = [
    ("BTN_0", 256),
    ("BTN_1", 257),
    ("BTN_2", 258),
    ("BTN_3", 259),
    ("BTN_EAST", 305),
    ("BTN_LEFT", 272),
    ("BTN_MIDDLE", 274),
    ("BTN_RIGHT", 273),
    ("BTN_SOUTH", 304),
    ("BTN_THUMB", 289),
    ("BTN_TRIGGER", 288),
    ("KEY_A", 30),
    ("KEY_B", 48),
    ("KEY_BLUE", 401),
    ("KEY_C", 46),
    ("KEY_CHANNELDOWN", 403),
    ("KEY_CHANNELUP", 402),
    ("KEY_DOWN", 108),
    ("KEY_ENTER", 28),
    ("KEY_ESC", 1),
    ("KEY_F5", 63),
    ("KEY_GREEN", 399),
    ("KEY_KPENTER", 96),
    ("KEY_KPMINUS", 74),
    ("KEY_KPPLUS", 78),
    ("KEY_LEFT", 105),
    ("KEY_MINUS", 12),
    ("KEY_N", 49),
    ("KEY_NEXTSONG", 163),
    ("KEY_OK", 352),
    ("KEY_PAGEDOWN", 109),
    ("KEY_PAGEUP", 104),
    ("KEY_PLAYPAUSE", 164),
    ("KEY_PREVIOUSSONG", 165),
    ("KEY_PROG1", 148),
    ("KEY_RED", 398),
    ("KEY_RIGHT", 106),
    ("KEY_SELECT", 353),
    ("KEY_SPACE", 57),
    ("KEY_UP", 103),
    ("KEY_VOLUMEDOWN", 114),
    ("KEY_VOLUMEUP", 115),
    ("KEY_X", 45),
    ("KEY_Y", 21),
    ("KEY_YELLOW", 400),
    ("KEY_Z", 44),
];
/// The largest code that the kernel has.
const LARGEST: u16 = 0x2ff;

/// A key, or any.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Key(pub Option<u16>);

impl Key {
    /// Every key of the device.
    pub const ANY: Self = Self(None);
}

/// As a setting has it.
impl fmt::Display for ButtonDevice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = match self {
            Self::Any => Cow::Borrowed(ANY),
            Self::At(path) => path.to_string_lossy(),
        };
        toml::Value::from(&*name).fmt(f)
    }
}

/// As a setting has it: a number, where it has one.
impl fmt::Display for Key {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.map_or_else(|| toml::Value::from(ANY), |code| toml::Value::from(i64::from(code))).fmt(f)
    }
}

impl<'de> Deserialize<'de> for Key {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        from.deserialize_any(NameOrCode)
    }
}

/// Reads one key, not any.
pub fn one<'de, D: Deserializer<'de>>(from: D) -> Result<Option<Key>, D::Error> {
    let key = Key::deserialize(from)?;
    let any = || D::Error::invalid_value(Unexpected::Str(ANY), &"the name or the number of one key");
    if key == Key::ANY { Err(any()) } else { Ok(Some(key)) }
}

/// Reads the path of one input device, not any.
/// Errors: For what is no path.
pub fn at<'de, D: Deserializer<'de>>(from: D) -> Result<Option<ButtonDevice>, D::Error> {
    match ButtonDevice::deserialize(from)? {
        ButtonDevice::Any => Err(D::Error::invalid_value(Unexpected::Str(ANY), &"a path below /dev/input")),
        device @ ButtonDevice::At(_) => Ok(Some(device)),
    }
}

struct NameOrCode;

impl Visitor<'_> for NameOrCode {
    type Value = Key;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "`any`, a name as `KEY_UP`, or the number of a key from 1 to {LARGEST}")
    }

    fn visit_str<E: serde::de::Error>(self, name: &str) -> Result<Key, E> {
        let found = NAMES.iter().find(|(known, _)| *known == name).map(|(_, code)| Key(Some(*code)));
        found.or((name == ANY).then_some(Key::ANY)).ok_or_else(|| E::invalid_value(Unexpected::Str(name), &self))
    }

    fn visit_i64<E: serde::de::Error>(self, code: i64) -> Result<Key, E> {
        let code_of_key = u16::try_from(code).ok().filter(|code| (1..=LARGEST).contains(code));
        code_of_key.map(|code| Key(Some(code))).ok_or_else(|| E::invalid_value(Unexpected::Signed(code), &self))
    }
}

#[cfg(test)]
mod tests {
    use super::{ButtonDevice, Key, LARGEST, NAMES, one};
    use crate::config_file::parse;
    use serde::Deserialize;
    use std::path::Path;

    #[derive(Debug, Deserialize)]
    #[serde(default, deny_unknown_fields)]
    struct Buttons {
        device: ButtonDevice,
        up: Key,
        #[serde(deserialize_with = "one")]
        down: Option<Key>,
    }

    impl Default for Buttons {
        fn default() -> Self {
            Self { device: ButtonDevice::Any, up: Key::ANY, down: None }
        }
    }

    fn read(text: &str) -> Result<Buttons, String> {
        parse(Path::new("votes.toml"), text).map_err(|error| error.to_string())
    }

    #[test]
    fn a_key_goes_by_its_name_or_its_number() {
        for (value, key) in [("\"any\"", Key::ANY), ("\"KEY_UP\"", Key(Some(103))), ("704", Key(Some(704)))] {
            assert_eq!(read(&format!("up = {value}")).unwrap().up, key);
        }
        for wrong in ["\"up\"", "0", "-3", "768", "1.5", "true"] {
            let said = read(&format!("up = {wrong}")).unwrap_err();
            assert!(
                said.contains("expected `any`, a name as `KEY_UP`, or the number of a key from 1 to 767"),
                "{said}"
            );
        }
        assert_eq!(read("down = 108").unwrap().down, Some(Key(Some(108))));
        let any = read("down = \"any\"").unwrap_err();
        assert!(any.contains("expected the name or the number of one key"), "{any}");
        assert!(NAMES.is_sorted() && NAMES.iter().all(|(_, code)| *code <= LARGEST));
    }

    #[test]
    fn a_device_is_a_path_or_any() {
        assert_eq!(read("device = \"any\"").unwrap().device, ButtonDevice::Any);
        let path = "/dev/input/by-id/pedal";
        assert_eq!(read(&format!("device = \"{path}\"")).unwrap().device, ButtonDevice::At(path.into()));
        let said = read("device = \"pedal\"").unwrap_err();
        assert!(
            said.contains("key `device`: invalid value: string \"pedal\", expected `any`, or a path below /dev/input"),
            "{said}"
        );
    }
}
