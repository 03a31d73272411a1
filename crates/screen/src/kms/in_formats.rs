//! The `IN_FORMATS` blob of a plane: the supported formats with their modifiers.
//!
//! Owns the parser, which checks all offsets.
//!
//! Source: `struct drm_format_modifier_blob` in the kernel's `drm_mode.h`.

/// The formats of `blob` that may be stored with `modifier`; empty if the blob is malformed.
pub(crate) fn formats_with(blob: &[u8], modifier: u64) -> Vec<u32> {
    parse(blob, modifier).unwrap_or_default()
}

fn parse(blob: &[u8], wanted: u64) -> Option<Vec<u32>> {
    let number = |at: usize| Some(u32::from_ne_bytes(blob.get(at..at + 4)?.try_into().ok()?));
    let long = |at: usize| Some(u64::from_ne_bytes(blob.get(at..at + 8)?.try_into().ok()?));
    let (count, formats_at) = (number(8)? as usize, number(12)? as usize);
    let (modifiers, modifiers_at) = (number(16)? as usize, number(20)? as usize);
    let mut found = Vec::new();
    for entry in (0..modifiers).map(|index| modifiers_at + index * 24) {
        let (mask, first, modifier) = (long(entry)?, number(entry + 8)? as usize, long(entry + 16)?);
        if modifier == wanted {
            let bits = (0..64).filter(|bit| mask >> bit & 1 == 1).map(|bit| first + bit);
            for index in bits.filter(|&index| index < count) {
                found.push(number(formats_at + index * 4)?);
            }
        }
    }
    Some(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Formats 11, 22, 33; `LINEAR` (0) takes the first and the last, modifier 7 all.
    fn blob() -> Vec<u8> {
        let mut blob = Vec::new();
        for word in [1u32, 0, 3, 24, 2, 40, 11, 22, 33, 0] {
            blob.extend(word.to_ne_bytes());
        }
        for (mask, modifier) in [(0b101u64, 0u64), (0b111, 7)] {
            blob.extend(mask.to_ne_bytes());
            blob.extend(0u64.to_ne_bytes());
            blob.extend(modifier.to_ne_bytes());
        }
        blob
    }

    #[test]
    fn a_format_is_taken_only_with_its_own_modifiers() {
        assert_eq!(formats_with(&blob(), 0), [11, 33]);
        assert_eq!(formats_with(&blob(), 7), [11, 22, 33]);
        assert_eq!(formats_with(&blob(), 8), []);
    }

    #[test]
    fn a_blob_that_was_cut_short_takes_nothing() {
        for length in 0..blob().len() {
            assert_eq!(formats_with(&blob()[..length], 7), [], "{length} bytes");
        }
    }
}
