//! The packets of a clip as they lie in its file, for a decoder outside: a browser's.
//!
//! Owns which packets an excerpt needs and what is told of each. Never decodes. A decoder that gets them in order, those of
//! several clips in a row and without a flush in between, shows the frames that [`Session`](crate::Session) shows.
//!
//! Start at [`packets`].

use crate::clip::{Clip, ClipError};
use crate::nal;
use crate::probe::ProbeError;
use crate::raw::Packet;
use std::ops::Range;
use std::path::Path;
use timing::FrameCount;

/// Packets of a clip, in decoding order.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ClipPackets {
    /// The codec as RFC 6381 writes it: `avc1.640020`.
    pub codec: String,
    /// The decoder's configuration record, `avcC` of ISO/IEC 14496-15.
    pub configuration: Vec<u8>,
    /// Visible width and height in pixels.
    pub size: (u32, u32),
    /// The length of the whole clip.
    pub frames: FrameCount,
    /// What is told of each packet.
    pub packets: Vec<ClipPacket>,
    /// The packets one after the other. Each unit in one has its length before it.
    pub bytes: Vec<u8>,
}

/// What is told of a packet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ClipPacket {
    /// The frame of the clip that it shows, from 0.
    pub frame: u32,
    /// Its place in decoding order, from 0.
    pub place: u32,
    /// Whether decoding can start with it: an IDR picture.
    pub is_key: bool,
    /// Whether the frame is asked for: the others are decoded only because it needs them.
    pub is_shown: bool,
    /// Its length.
    pub bytes: usize,
}

/// The packets that the frames `part` of the clip at `path` need, from the keyframe at or before them. Frames beyond the end
/// are left out.
///
/// # Errors
/// [`ClipError`] if it is no H.264 clip of even frame rate, or a packet is damaged.
pub fn packets(path: &Path, part: Range<u32>) -> Result<ClipPackets, ClipError> {
    let whole = Clip::open_any(path)?;
    let (size, frames) = (whole.size(), whole.frames());
    let configuration = whole.configuration().to_vec();
    let unreadable = |frame: u32, reason: String| ClipError::Probe {
        error: ProbeError::Read { path: path.to_owned(), frame, reason },
    };
    let codec = codec(&configuration).ok_or_else(|| unreadable(0, "it has no configuration record".into()))?;
    let mut clip = whole.excerpt(part.clone());
    let (mut packets, mut bytes) = (Vec::new(), Vec::new());
    let mut packet = Packet::new().map_err(|code| unreadable(0, code.to_string()))?;
    // Decoding starts at a keyframe, before which as many packets lie as frames, since every GOP is closed.
    let mut start = None;
    while let Some((frame, read)) =
        clip.next_stored(&mut packet).map_err(|(place, reason)| unreadable(place, reason))?
    {
        let start = *start.get_or_insert((frame + 1).saturating_sub(read));
        let data = packet.bytes_mut().map_err(|code| unreadable(frame, code.to_string()))?;
        packets.push(ClipPacket {
            frame,
            place: start + read - 1,
            is_key: nal::has_idr(data),
            is_shown: part.contains(&frame),
            bytes: data.len(),
        });
        bytes.extend_from_slice(data);
    }
    Ok(ClipPackets { codec, configuration, size, frames, packets, bytes })
}

/// The codec of an `avcC` record as RFC 6381 writes it; `None` if it is none.
pub(crate) fn codec(configuration: &[u8]) -> Option<String> {
    match configuration {
        [1, profile, constraints, level, ..] => Some(format!("avc1.{profile:02x}{constraints:02x}{level:02x}")),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::codec;

    #[test]
    fn a_codec_is_written_as_browsers_read_it() {
        assert_eq!(codec(&[1, 0x64, 0, 0x20, 0xff]).as_deref(), Some("avc1.640020"));
        assert_eq!([codec(&[]), codec(&[0, 0, 0, 1, 0x67])], [None, None]);
    }
}
