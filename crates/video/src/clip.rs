//! A clip as a sequence of packets for the decoder.
//!
//! Owns the open file, its place in it, and the numbering of its packets by the frame they show. `session.rs` takes the
//! packets and decodes them.
//!
//! Start at [`Clip::open`].

use crate::code::Code;
use crate::damage::Damage;
use crate::form::{self, Difference, Form};
use crate::nal;
use crate::probe::{self, OpenedClip, ProbeError};
use crate::raw::{Demuxer, Packet};
use rustix::fs::{Advice, fadvise};
use std::fs::File;
use std::io;
use std::ops::Range;
use std::path::{Path, PathBuf};
use timing::{FrameCount, Rate};

/// A clip in the flock's form, positioned at its first packet.
pub struct Clip {
    demuxer: Demuxer,
    file: File,
    /// The first packet, read already to look at it.
    first: Option<Packet>,
    /// When the first frame is shown, in ticks: in a closed GOP that is the IDR picture's time. 0 where an edit list
    /// cuts that picture away: ffmpeg counts from the cut.
    start: i64,
    fps: Rate,
    frames: FrameCount,
    size: (u32, u32),
    /// How many packets were handed out.
    read: u32,
    /// The frames that are shown, all of them but in an excerpt.
    part: Range<u32>,
    /// Only these of them, in rising order, if they are chosen one by one.
    chosen: Option<Vec<u32>>,
    /// How many frames of an excerpt have not been handed out; `None` where the file is read to its end.
    left: Option<u32>,
}

/// Why a clip is not played.
#[derive(Debug, thiserror::Error)]
pub enum ClipError {
    /// It is a video, but not in the flock's form.
    #[error("clip `{path}` is not in the flock's form: {}", form::join_differences(differences))]
    Form {
        /// The file.
        path: PathBuf,
        /// In what it differs, at least one.
        differences: Vec<Difference>,
    },
    /// It cannot be opened, or is no complete video.
    #[error(transparent)]
    Probe {
        /// The cause.
        error: ProbeError,
    },
}

impl ClipError {
    /// Whether the cause is a shortage of file descriptors or memory, so that another attempt may succeed.
    pub fn is_shortage(&self) -> bool {
        matches!(self, Self::Probe { error: ProbeError::Open { source, .. } } if probe::is_shortage(source))
    }
}

/// The next packet of a clip.
pub(crate) enum Next {
    /// A packet that shows the frame at this place of the clip.
    Packet(u32),
    /// A packet that is needed to decode others but shows nothing that belongs to the clip.
    Hidden,
    /// Nothing more.
    End,
}

impl Clip {
    /// Opens the clip at `path` and checks header, index and first packet, in a few milliseconds.
    ///
    /// # Errors
    /// [`ClipError`] if it is not in `form` with `frames` frames. Damage after that is found when it is played.
    pub fn open(path: &Path, form: &Form, frames: FrameCount) -> Result<Self, ClipError> {
        let opened = probe::open(path).map_err(|error| ClipError::Probe { error })?;
        let differences = opened.probe.differences(form, frames);
        if !differences.is_empty() {
            return Err(ClipError::Form { path: path.to_owned(), differences });
        }
        Ok(Self::from_opened(opened, form.fps))
    }

    /// Opens any H.264 clip of even frame rate, whatever its size and length.
    pub(crate) fn open_any(path: &Path) -> Result<Self, ClipError> {
        let opened = probe::open(path).map_err(|error| ClipError::Probe { error })?;
        let probe = &opened.probe;
        let one = Rate::new(1, 1).expect("one per second is a rate");
        // A single frame has no rate: any value places it.
        match probe.fps.or((probe.frames == FrameCount(1)).then_some(one)) {
            Some(fps) if probe.codec == "h264" => Ok(Self::from_opened(opened, fps)),
            _ => {
                let form = Form { size: probe.size, fps: one };
                let differences = probe.differences(&form, probe.frames);
                Err(ClipError::Form { path: path.to_owned(), differences })
            }
        }
    }

    fn from_opened(opened: OpenedClip, fps: Rate) -> Self {
        let OpenedClip { demuxer, first, probe, file } = opened;
        let start = if first.is_discarded() { 0 } else { first.pts().unwrap_or(0) };
        let (frames, size) = (probe.frames, probe.size);
        let part = 0..frames.0;
        Self { demuxer, file, first: Some(first), start, fps, frames, size, read: 0, part, chosen: None, left: None }
    }

    /// Only the frames `part` of this clip, as a clip of that length whose frames count from 0. Reading starts at the last
    /// keyframe at or before them; frames before the excerpt are decoded and not shown, those after it are not read.
    ///
    /// Call this before the clip is played. Frames beyond its end are left out; read errors are reported as damage when
    /// it is played.
    #[must_use]
    pub fn excerpt(mut self, part: Range<u32>) -> Self {
        let end = part.end.min(self.frames.0);
        self.part = part.start.min(end)..end;
        self.left = Some(self.part.end - self.part.start);
        let mut sought = false;
        for keyframe in self.keyframes(self.part.start).into_iter().rev() {
            if keyframe == 0 && !sought {
                break;
            }
            sought = true;
            // Where the container's times are shifted, a seek may land on a later keyframe.
            let first = self.packet_at(keyframe);
            let reached = |first: &Packet| self.number(first).is_some_and(|frame| frame <= self.part.start.into());
            self.first = first.filter(reached);
            if self.first.is_some() {
                break;
            }
        }
        self
    }

    /// Only these frames of this clip, as a clip whose frames count from 0 in their order. Pictures between them that no other
    /// refers to are not decoded, which is a third to a half of most clips.
    ///
    /// Call this before the clip is played. Frames beyond its end are left out.
    #[must_use]
    pub fn selection(self, frames: &[u32]) -> Self {
        let mut chosen: Vec<u32> = frames.iter().copied().filter(|frame| *frame < self.frames.0).collect();
        chosen.sort_unstable();
        chosen.dedup();
        let part = chosen.first().copied().unwrap_or(0)..chosen.last().map_or(0, |last| last + 1);
        let mut clip = self.excerpt(part);
        (clip.left, clip.chosen) = (Some(chosen.len() as u32), Some(chosen));
        clip
    }

    /// The place of frame `frame` among those that are shown.
    fn place_of(&self, frame: u32) -> Option<u32> {
        match &self.chosen {
            Some(chosen) => chosen.binary_search(&frame).ok().map(|at| at as u32),
            None => self.part.contains(&frame).then(|| frame - self.part.start),
        }
    }

    /// The keyframes up to frame `last`, as frames of the clip: the pictures before one are shown before it, because
    /// every GOP is closed.
    fn keyframes(&self, last: u32) -> Vec<u32> {
        let samples = self.demuxer.samples();
        let shown = samples.iter().filter(|sample| sample.shown);
        let keyed = shown.zip(0u32..).filter(|(sample, _)| sample.key).map(|(_, frame)| frame);
        keyed.take_while(|frame| *frame <= last).collect()
    }

    /// The first packet from the keyframe `frame` on.
    fn packet_at(&mut self, frame: u32) -> Option<Packet> {
        let (num, den) = self.demuxer.time_base();
        let up = i128::from(frame) * i128::from(self.fps.den()) * i128::from(den);
        let ticks = up / (i128::from(num) * i128::from(self.fps.num()));
        self.demuxer.seek(self.start.checked_add(i64::try_from(ticks).ok()?)?).ok()?;
        let mut packet = Packet::new().ok()?;
        self.demuxer.read(&mut packet).ok()?.then_some(packet)
    }

    /// Reads the whole file into the page cache, so that playing it never waits for storage.
    ///
    /// Plain reads after `WILLNEED`, not `mmap`: 60 MB after `DONTNEED` took 40 to 53 ms this way and 42 to 48 ms by
    /// touching a mapping, but the mapping counted all 60 MB as the player's memory.
    ///
    /// # Errors
    /// The kernel's error. The clip can still be played.
    pub fn page_in(&mut self) -> io::Result<()> {
        fadvise(&self.file, 0, None, Advice::WillNeed)?;
        io::copy(&mut &self.file, &mut io::sink())?;
        Ok(())
    }

    /// How many frames it shows, by its header.
    pub fn frames(&self) -> FrameCount {
        let chosen = self.chosen.as_ref().map(|chosen| chosen.len() as u32);
        FrameCount(chosen.unwrap_or(self.part.end - self.part.start))
    }

    /// Visible width and height, by its first access unit.
    pub fn size(&self) -> (u32, u32) {
        self.size
    }

    /// A copy of the packet that shows the first frame, in start-code form, until the first call of [`Clip::next`].
    pub(crate) fn first_packet(&self) -> Option<Packet> {
        let mut packet = self.first.as_ref()?.clone_ref().ok()?;
        let is_whole = !packet.is_discarded() && !packet.is_corrupt() && self.number(&packet) == Some(0);
        (is_whole && nal::to_start_codes(packet.bytes_mut().ok()?).is_ok()).then_some(packet)
    }

    /// Reads the next packet, in start-code form, into `packet`. Damage is passed to `blame`.
    pub(crate) fn next(&mut self, packet: &mut Packet, blame: &mut impl FnMut(Damage)) -> Next {
        let frame = self.read;
        if self.left == Some(0) {
            return Next::End;
        }
        match self.read(packet) {
            Ok(true) => (),
            Ok(false) => return Next::End,
            Err(code) => {
                blame(Damage::Unreadable { frame, reason: code.to_string() });
                return Next::End;
            }
        }
        let whole = packet.bytes_mut().is_ok_and(|bytes| nal::to_start_codes(bytes).is_ok());
        if !whole || packet.is_corrupt() {
            blame(Damage::Malformed { frame });
        }
        if packet.is_discarded() { Next::Hidden } else { self.place(packet, blame) }
    }

    /// Reads the next packet as it is stored into `packet`. Returns the frame that it shows, which an excerpt may not ask
    /// for, and how many packets were read so far; `None` after the last one.
    /// Errors: What is wrong with the packet, and its place among those that were read.
    pub(crate) fn next_stored(&mut self, packet: &mut Packet) -> Result<Option<(u32, u32)>, (u32, String)> {
        let at = self.read;
        if self.left == Some(0) || !self.read(packet).map_err(|code| (at, code.to_string()))? {
            return Ok(None);
        }
        let whole = packet.bytes_mut().is_ok_and(|bytes| nal::units(bytes).all(|unit| unit.is_ok()));
        if !whole || packet.is_corrupt() {
            return Err((at, "the packet is damaged".into()));
        }
        let frame = self.number(packet).and_then(|frame| u32::try_from(frame).ok());
        let frame = frame.filter(|frame| *frame < self.frames.0 && !packet.is_discarded());
        let frame = frame.ok_or_else(|| (at, "it shows no frame of the clip".to_owned()))?;
        if self.part.contains(&frame) {
            self.left = self.left.map(|left| left.saturating_sub(1));
        }
        Ok(Some((frame, self.read)))
    }

    /// The decoder's configuration record; empty where there is none.
    pub(crate) fn configuration(&self) -> &[u8] {
        self.demuxer.configuration()
    }

    /// Reads the next packet that is needed; `false` at the end of the file.
    fn read(&mut self, packet: &mut Packet) -> Result<bool, Code> {
        loop {
            match self.first.take() {
                Some(first) => *packet = first,
                None if self.demuxer.read(packet)? => (),
                None => return Ok(false),
            }
            self.read += 1;
            if !self.is_skippable(packet) {
                return Ok(true);
            }
        }
    }

    /// Whether an excerpt can skip a packet: its picture is neither shown nor referenced by another.
    fn is_skippable(&self, packet: &mut Packet) -> bool {
        let shown =
            || self.number(packet).is_none_or(|frame| self.place_of(u32::try_from(frame).unwrap_or(0)).is_some());
        self.left.is_some() && !shown() && packet.bytes_mut().is_ok_and(|bytes| nal::is_disposable(bytes))
    }

    /// Numbers a packet by the frame that it shows.
    fn place(&mut self, packet: &Packet, blame: &mut impl FnMut(Damage)) -> Next {
        let frame = self.number(packet).unwrap_or(i64::MIN);
        let shown = u32::try_from(frame).ok().and_then(|frame| self.place_of(frame));
        if let Some(place) = shown {
            self.left = self.left.map(|left| left.saturating_sub(1));
            return Next::Packet(place);
        }
        match u32::try_from(frame) {
            Ok(frame) if frame < self.frames.0 => Next::Hidden,
            _ => {
                let reason = format!("the clip has frames 0 to {}", self.frames.0.saturating_sub(1));
                blame(Damage::Misplaced { frame, reason });
                Next::Hidden
            }
        }
    }

    /// The packet's frame number in the clip, from its timestamp.
    fn number(&self, packet: &Packet) -> Option<i64> {
        let (num, den) = self.demuxer.time_base();
        let ticks = i128::from(packet.pts().unwrap_or(i64::MIN)) - i128::from(self.start);
        let up = ticks * i128::from(num) * i128::from(self.fps.num());
        let down = i128::from(den) * i128::from(self.fps.den());
        i64::try_from((2 * up + down).div_euclid(2 * down)).ok()
    }
}

#[cfg(test)]
mod tests {
    use super::ClipError;
    use crate::probe::ProbeError;
    use rustix::io::Errno;

    #[test]
    fn a_machine_without_descriptors_or_memory_is_not_the_clips_fault() {
        let opening = |errno: Errno| {
            let error = ProbeError::Open { path: "a.mp4".into(), source: errno.into() };
            ClipError::Probe { error }.is_shortage()
        };
        assert!([Errno::MFILE, Errno::NFILE, Errno::NOMEM].into_iter().all(opening));
        assert!(![Errno::NOENT, Errno::ACCESS, Errno::IO, Errno::LOOP].into_iter().any(opening));
    }
}
