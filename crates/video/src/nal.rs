//! The units inside an H.264 packet of an MP4 file.
//!
//! Owns the walk over length-prefixed NAL units, and the change of their lengths into start codes in place, so that
//! clips with different configuration records go through one decoder. Slices are not parsed.
//!
//! Start at [`units`]. What a parameter set says is read in `sps.rs`.

/// Bytes of a unit's length field: the size that every known muxer writes, and that of a start code.
const PREFIX: usize = 4;

/// A unit's length field points outside its packet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct MalformedUnit;

/// The kinds of units that matter at joins.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    /// A slice of a picture that may refer to pictures before it.
    Slice,
    /// A slice of an IDR picture.
    Idr,
    /// Supplemental information; `true` if it has a recovery point, the start of an open GOP.
    Sei { recovery: bool },
    /// A sequence parameter set.
    Sps,
    /// A picture parameter set.
    Pps,
    /// Anything else.
    Other,
}

/// What the unit `unit` (header byte first) is.
pub(crate) fn kind(unit: &[u8]) -> Kind {
    match unit.first().map(|header| header & 0x1f) {
        Some(1..=4) => Kind::Slice,
        Some(5) => Kind::Idr,
        Some(6) => Kind::Sei { recovery: unit.get(1) == Some(&6) },
        Some(7) => Kind::Sps,
        Some(8) => Kind::Pps,
        Some(_) | None => Kind::Other,
    }
}

/// The units of a packet in order, each without its length field; ends after the first [`MalformedUnit`] one.
pub(crate) fn units(packet: &[u8]) -> impl Iterator<Item = Result<&[u8], MalformedUnit>> {
    let mut rest = packet;
    std::iter::from_fn(move || {
        if rest.is_empty() {
            return None;
        }
        let unit = length(rest).map(|bytes| {
            let (unit, after) = rest[PREFIX..].split_at(bytes);
            rest = after;
            unit
        });
        if unit.is_err() {
            rest = &[];
        }
        Some(unit)
    })
}

/// Whether a packet has a slice of an IDR picture; its units have lengths or start codes before them.
pub(crate) fn has_idr(packet: &[u8]) -> bool {
    let is_idr = |unit: &[u8]| kind(unit) == Kind::Idr;
    if packet.starts_with(&[0, 0, 1]) || packet.starts_with(&[0, 0, 0, 1]) {
        return packet.windows(4).any(|bytes| bytes.starts_with(&[0, 0, 1]) && is_idr(&bytes[3..]));
    }
    units(packet).flatten().any(is_idr)
}

/// Whether no other picture refers to this one: `nal_ref_idc` of all its slices is 0.
pub(crate) fn is_disposable(packet: &[u8]) -> bool {
    let slices = units(packet).flatten().filter(|unit| matches!(kind(unit), Kind::Slice | Kind::Idr));
    let mut counts = slices.map(|unit| unit[0] >> 5 & 3).peekable();
    counts.peek().is_some() && counts.all(|count| count == 0)
}

/// Turns every length field into a start code. From a broken one on, the rest becomes one last unit.
/// Errors: [`MalformedUnit`] if a length pointed outside; the packet may still be decoded, as far as it goes.
pub(crate) fn to_start_codes(packet: &mut [u8]) -> Result<(), MalformedUnit> {
    let mut rest = packet;
    while !rest.is_empty() {
        let bytes = length(rest);
        if let Some(prefix) = rest.first_chunk_mut::<PREFIX>() {
            *prefix = [0, 0, 0, 1];
        }
        rest = &mut rest[PREFIX + bytes?..];
    }
    Ok(())
}

/// The length that `rest` starts with: at least 1, and inside `rest`.
fn length(rest: &[u8]) -> Result<usize, MalformedUnit> {
    let (prefix, body) = rest.split_first_chunk::<PREFIX>().ok_or(MalformedUnit)?;
    let bytes = u32::from_be_bytes(*prefix) as usize;
    if (1..=body.len()).contains(&bytes) { Ok(bytes) } else { Err(MalformedUnit) }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TWO: [u8; 11] = [0, 0, 0, 2, 0x67, 9, 0, 0, 0, 1, 0x65];

    #[test]
    fn units_are_told_apart() {
        let kinds: Vec<_> = units(&TWO).map(|unit| kind(unit.unwrap())).collect();
        assert_eq!(kinds, [Kind::Sps, Kind::Idr]);
    }

    #[test]
    fn a_picture_is_disposable_if_none_of_its_slices_is_referred_to() {
        for (packet, disposable) in [
            (&[0, 0, 0, 1, 0x06, 0, 0, 0, 1, 0x01, 0, 0, 0, 1, 0x01][..], true),
            (&[0, 0, 0, 1, 0x01, 0, 0, 0, 1, 0x21], false),
            (&TWO, false),
            (&[0, 0, 0, 1, 0x06], false),
            (&[], false),
        ] {
            assert_eq!(is_disposable(packet), disposable, "{packet:?}");
        }
    }

    #[test]
    fn lengths_become_start_codes_in_place() {
        let mut packet = TWO;
        assert_eq!(to_start_codes(&mut packet), Ok(()));
        assert_eq!(packet, [0, 0, 0, 1, 0x67, 9, 0, 0, 0, 1, 0x65]);
    }

    #[test]
    fn a_length_that_points_outside_is_told_and_ends_the_walk() {
        for packet in [&[0, 0, 0, 9, 0x65][..], &[0, 0, 0, 0, 1], &[0, 0, 1], &[255; 5]] {
            assert_eq!(units(packet).collect::<Vec<_>>(), [Err(MalformedUnit)], "{packet:?}");
            assert_eq!(to_start_codes(&mut packet.to_vec()), Err(MalformedUnit), "{packet:?}");
        }
    }
}
