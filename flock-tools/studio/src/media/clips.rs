//! Clips as a browser takes them: in fragments for the walk, as packets for the joins.
//!
//! Owns the form of the answer with packets. Both copy what is in the clip and decode nothing, so that what the page shows is
//! what the wall shows.
//!
//! Start at [`Media::fragments`] and [`Media::packets`].

use std::fs;
use std::ops::Range;
use std::path::PathBuf;

use ct_codecs::{Base64, Encoder as _};
use operations::program::chain;
use serde_json::json;
use video::{ClipPacket, ClipPackets, Form};

use super::sources::Source;
use super::{Media, MediaError, cache};

/// The files of a fragmented copy, and of its codec.
pub(super) const FRAGMENTS: &str = "-fragments.mp4";
const CODEC: &str = "-codec.txt";

impl Media {
    /// The fragmented copy of the clip of `key`, which is made if it is not there, and its codec, such as `avc1.640020`.
    /// Errors: [`MediaError`] if the clip is damaged or cannot be copied.
    pub(crate) fn fragments(&self, key: &str) -> Result<(PathBuf, String), MediaError> {
        let source = self.sources.find(key)?;
        let Source::Clip { clip, .. } = &*source else { return Err(MediaError::Unknown { key: key.to_owned() }) };
        let refused = |error: &dyn std::error::Error| MediaError::refused(clip.path.as_str(), chain(error));
        let path = self.cache.once(key, FRAGMENTS, |path| {
            let made = video::fragment(&clip.path.inside(&self.folder), path).map_err(|error| refused(&error))?;
            if made.frames != clip.frames {
                let _ = fs::remove_file(path);
                let reason = format!("it has {} frames (expected {})", made.frames, clip.frames);
                return Err(MediaError::refused(clip.path.as_str(), reason));
            }
            cache::write(&self.cache.path(key, CODEC), made.codec.as_bytes())
        })?;
        let told = self.cache.path(key, CODEC);
        let codec = fs::read_to_string(&told).map_err(MediaError::file(&told))?;
        Ok((path, codec))
    }

    /// The packets that the frames `part` of the clip of `key` need: the length of a JSON document in 4 bytes, the lowest
    /// first, the document, then the packets one after the other in decoding order.
    /// Errors: [`MediaError`] if the clip is damaged.
    pub(crate) fn packets(&self, key: &str, part: Range<u32>) -> Result<Vec<u8>, MediaError> {
        let source = self.sources.find(key)?;
        let Source::Clip { clip, form, .. } = &*source else {
            return Err(MediaError::Unknown { key: key.to_owned() });
        };
        let refused = |reason: String| MediaError::refused(clip.path.as_str(), reason);
        let found = video::packets(&clip.path.inside(&self.folder), part).map_err(|error| refused(chain(&error)))?;
        answer(&found, form).ok_or_else(|| refused("it is too long".to_owned()))
    }
}

/// The answer with packets; `None` if its head is longer than 4 bytes can tell.
fn answer(found: &ClipPackets, form: &Form) -> Option<Vec<u8>> {
    let packet = |packet: &ClipPacket| {
        json!({
            "pts": packet.frame,
            "dts": packet.place,
            "key": packet.is_key,
            "show": packet.is_shown,
            "bytes": packet.bytes,
        })
    };
    let head = json!({
        "codec": found.codec,
        "description": Base64::encode_to_string(&found.configuration).ok()?,
        "rate": [form.fps.num(), form.fps.den()],
        "frames": found.frames.0,
        "size": [found.size.0, found.size.1],
        "packets": found.packets.iter().map(packet).collect::<Vec<_>>(),
    });
    let head = head.to_string();
    let length = u32::try_from(head.len()).ok()?;
    Some([&length.to_le_bytes()[..], head.as_bytes(), &found.bytes].concat())
}
