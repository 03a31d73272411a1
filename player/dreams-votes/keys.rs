//! Keys by their names.
//!
//! Owns the names that a config may use, as Linux has them; every other key goes by its number. Never reads a device.
//!
//! # Source
//! `linux/input-event-codes.h`.

use serde::de::{Error, Unexpected, Visitor};
use serde::{Deserialize, Deserializer};
use std::fmt;

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
pub(crate) struct Key(pub(crate) Option<u16>);

impl Key {
    /// Every key of the device.
    pub(crate) const ANY: Self = Self(None);
}

impl<'de> Deserialize<'de> for Key {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        from.deserialize_any(NameOrCode)
    }
}

/// One key, not any.
pub(crate) fn one<'de, D: Deserializer<'de>>(from: D) -> Result<Option<Key>, D::Error> {
    let key = Key::deserialize(from)?;
    let any = || D::Error::invalid_value(Unexpected::Str("any"), &"the name or the number of one key");
    if key == Key::ANY { Err(any()) } else { Ok(Some(key)) }
}

struct NameOrCode;

impl Visitor<'_> for NameOrCode {
    type Value = Key;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "`any`, a name as `KEY_UP`, or the number of a key from 1 to {LARGEST}")
    }

    fn visit_str<E: serde::de::Error>(self, name: &str) -> Result<Key, E> {
        let found = NAMES.iter().find(|(known, _)| *known == name).map(|(_, code)| Key(Some(*code)));
        found.or((name == "any").then_some(Key::ANY)).ok_or_else(|| E::invalid_value(Unexpected::Str(name), &self))
    }

    fn visit_i64<E: serde::de::Error>(self, code: i64) -> Result<Key, E> {
        let code_of_key = u16::try_from(code).ok().filter(|code| (1..=LARGEST).contains(code));
        code_of_key.map(|code| Key(Some(code))).ok_or_else(|| E::invalid_value(Unexpected::Signed(code), &self))
    }
}

#[cfg(test)]
mod tests {
    use super::{Key, LARGEST, NAMES};
    use player::config_file::parse;
    use std::path::Path;

    fn read(value: &str) -> Result<Key, String> {
        let text = format!("up = {value}");
        let config = parse::<crate::config::Config>(Path::new("votes.toml"), &text);
        config.map(|config| config.up).map_err(|error| error.to_string())
    }

    #[test]
    fn a_key_goes_by_its_name_or_its_number() {
        assert_eq!(
            (read("\"any\""), read("\"KEY_UP\""), read("704")),
            (Ok(Key::ANY), Ok(Key(Some(103))), Ok(Key(Some(704))))
        );
        for wrong in ["\"up\"", "0", "-3", "768", "1.5", "true"] {
            let said = read(wrong).unwrap_err();
            assert!(
                said.contains("expected `any`, a name as `KEY_UP`, or the number of a key from 1 to 767"),
                "{said}"
            );
        }
        let any = parse::<crate::config::Config>(Path::new("votes.toml"), "down = \"any\"").unwrap_err().to_string();
        assert!(any.contains("expected the name or the number of one key"), "{any}");
        assert!(NAMES.is_sorted() && NAMES.iter().all(|(_, code)| *code <= LARGEST));
    }
}
