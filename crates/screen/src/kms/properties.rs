//! Reading an object's properties from the kernel.
//!
//! Owns the cache of names and choices, which do not change; values are read each time.

use super::card::{Id, Properties, Property, Values};
use drm::control::property::{Handle, ValueType};
use drm::control::{Device as Control, PropertyValueSet};
use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::io;

/// The cached properties of one open card.
#[derive(Default)]
pub(super) struct PropertyCache(HashMap<Handle, Property>);

impl PropertyCache {
    /// Names the properties of `values`, asking `card` for those never seen before.
    pub(super) fn read(&mut self, card: &impl Control, values: &PropertyValueSet) -> io::Result<Properties> {
        let mut read = Vec::new();
        for (&id, &value) in values {
            let known = match self.0.entry(id) {
                Entry::Occupied(known) => known.into_mut(),
                Entry::Vacant(unknown) => unknown.insert(describe(card, id)?),
            };
            read.push(Property { value, ..known.clone() });
        }
        Ok(Properties(read))
    }
}

fn describe(card: &impl Control, id: Handle) -> io::Result<Property> {
    let info = card.get_property(id)?;
    let values = match info.value_type() {
        ValueType::Boolean => Values::UpTo { max: 1 },
        ValueType::UnsignedRange(_, max) => Values::UpTo { max: *max },
        ValueType::Enum(choices) => {
            let named = choices.values().1.iter();
            Values::Named(named.map(|choice| (choice.name().to_string_lossy().into_owned(), choice.value())).collect())
        }
        ValueType::Bitmask => Values::Bits(bits(card, id)?),
        ValueType::Unknown
        | ValueType::SignedRange(..)
        | ValueType::Blob
        | ValueType::Object
        | ValueType::CRTC
        | ValueType::Connector
        | ValueType::Encoder
        | ValueType::Framebuffer
        | ValueType::Plane
        | ValueType::Property => Values::Other,
    };
    let name = info.name().to_string_lossy().into_owned();
    Ok(Property { id: Id(id.into()), name, value: 0, mutable: info.mutable(), values })
}

/// The names of a bitmask's bits, with what each adds. `drm` has no call for them.
fn bits(card: &impl Control, id: Handle) -> io::Result<Vec<(String, u64)>> {
    let mut named = Vec::new();
    // The kernel always fills both.
    drm_ffi::mode::get_property(card.as_fd(), id.into(), Some(&mut Vec::new()), Some(&mut named))?;
    let bit = |bit: &drm_ffi::drm_mode_property_enum| {
        let name = bit.name.iter().flat_map(|letter| letter.to_ne_bytes()).take_while(|letter| *letter != 0).collect();
        let value = u32::try_from(bit.value).ok().and_then(|place| 1u64.checked_shl(place)).unwrap_or(0);
        (String::from_utf8(name).unwrap_or_default(), value)
    };
    Ok(named.iter().map(bit).collect())
}
