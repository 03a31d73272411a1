//! Whether bytes are a small JPEG.
//!
//! Owns the limits of a picture in a report. Reads the segments up to the picture's data, never the data: a browser that
//! shows it needs memory for the sides that stand there, so that those are limited, too.
//!
//! # Source
//! ITU-T T.81, annex B.
//!
//! Start at [`check`].

/// The most bytes of a picture.
pub(crate) const MOST_BYTES: usize = 64 << 10;
/// The most pixels of a side.
const LONGEST_SIDE: u16 = 1920;

/// Why bytes are no such picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub(crate) enum PictureError {
    #[error("the picture is not in base64 with padding")]
    Base64,
    #[error("the picture is not a whole JPEG of one of the usual kinds (baseline or progressive)")]
    Jpeg,
    #[error("the picture has more than {MOST_BYTES} bytes: send a smaller one")]
    Long,
    #[error("the picture has {width} by {height} pixels, expected 1 to {LONGEST_SIDE} a side")]
    Sides { width: u16, height: u16 },
}

/// Checks that `bytes` are one JPEG of at most [`MOST_BYTES`] bytes and [`LONGEST_SIDE`] pixels a side.
/// Errors: Why they are not.
pub(crate) fn check(bytes: &[u8]) -> Result<(), PictureError> {
    if bytes.len() > MOST_BYTES {
        return Err(PictureError::Long);
    }
    let [width, height] = sides(bytes).ok_or(PictureError::Jpeg)?;
    if [width, height].iter().all(|side| (1..=LONGEST_SIDE).contains(side)) {
        Ok(())
    } else {
        Err(PictureError::Sides { width, height })
    }
}

/// Width and height in pixels, if the segments lead to the picture's data, and those end as they must.
fn sides(bytes: &[u8]) -> Option<[u16; 2]> {
    let mut rest = bytes.strip_prefix(&[0xff, 0xd8])?.strip_suffix(&[0xff, 0xd9])?;
    let mut found = None;
    loop {
        let (marker, after) = rest.strip_prefix(&[0xff])?.split_first()?;
        let length = usize::from(u16::from_be_bytes(*after.first_chunk()?));
        let (segment, next) = after.split_at_checked(length)?;
        let body = segment.get(2..)?;
        match marker {
            // A frame: baseline, extended, progressive. Precision, height, width.
            0xc0..=0xc2 if found.is_none() => {
                let [_, h, i, w, j] = *body.first_chunk()?;
                found = Some([u16::from_be_bytes([w, j]), u16::from_be_bytes([h, i])]);
            }
            // Tables, restarts, applications, comments.
            0xc4 | 0xdb | 0xdd | 0xe0..=0xef | 0xfe => {}
            // The data.
            0xda => return found.filter(|_| !next.is_empty()),
            _ => return None,
        }
        rest = next;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use jpeg_encoder::{ColorType, Encoder};

    fn jpeg(width: u16, height: u16) -> Vec<u8> {
        let mut bytes = Vec::new();
        let pixels = vec![90; usize::from(width) * usize::from(height)];
        Encoder::new(&mut bytes, 60).encode(&pixels, width, height, ColorType::Luma).unwrap();
        bytes
    }

    #[test]
    fn a_picture_is_a_whole_jpeg_within_the_limits_and_nothing_else() {
        assert_eq!(check(&jpeg(320, 180)), Ok(()));
        assert_eq!(check(&jpeg(1921, 8)), Err(PictureError::Sides { width: 1921, height: 8 }));
        let whole = jpeg(32, 18);
        for end in 0..whole.len() {
            assert_eq!(check(&whole[..end]), Err(PictureError::Jpeg), "{end} bytes");
        }
        for other in
            [&b"GIF89a"[..], b"<svg onload=alert(1)>", b"\xff\xd8\xff\xd9", b"\xff\xd8\xff\xe0\x00\x01\xff\xd9"]
        {
            assert_eq!(check(other), Err(PictureError::Jpeg));
        }
        let mut long = whole.clone();
        long.splice(whole.len() - 2..whole.len() - 2, vec![0; MOST_BYTES]);
        assert_eq!(check(&long), Err(PictureError::Long));
    }
}
