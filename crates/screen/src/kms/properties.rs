//! Reading an object's properties from the kernel.
//!
//! Owns the cache of what each property is: names and choices never change, values do. Never sets a property.

use super::card::{Id, Properties, Property, Values};
use drm::control::property::{Handle, ValueType};
use drm::control::{Device as Control, PropertyValueSet};
use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::io;

/// What the properties of one open card are.
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
        ValueType::Unknown
        | ValueType::SignedRange(..)
        | ValueType::Bitmask
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
