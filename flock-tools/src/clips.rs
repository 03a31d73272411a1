//! What is wrong with the clips of a flock.
//!
//! Owns the look at the files: is each there, is it in the flock's form, is it whole? Never judges the graph.
//!
//! Start at [`faults`].

use std::collections::HashMap;
use std::fs::File;
use std::io;
use std::num::NonZero;
use std::path::Path;

use flock::{Clip, ClipHash, Fault, FaultKind, Manifest, SheepId};
use rayon::iter::{IntoParallelRefIterator, ParallelIterator};
use timing::FrameCount;
use video::{Form, Probe, ProbeError};

use crate::decoder::{Decoder, Video};
use crate::progress;
use crate::report::{Fatal, chain};

/// A clip and whose it is.
struct Owned<'a> {
    clip: &'a Clip,
    sheep: Option<&'a SheepId>,
    between: Option<(&'a SheepId, &'a SheepId)>,
}

/// What a look at a file found.
pub(crate) type Finding = (FaultKind, String);

/// Every fault of the clips of the flock in `folder`, in the order of the manifest. Shows its progress on a terminal.
/// Where no clip is there, none is decoded.
///
/// # Errors
/// If a clip is there, and nothing to decode it.
pub(crate) fn faults(folder: &Path, manifest: &Manifest, video: Video) -> Result<Vec<Fault>, Fatal> {
    let loops = manifest.sheep.iter().filter_map(|sheep| {
        let clip = sheep.clip.as_ref()?;
        Some(Owned { clip, sheep: Some(&sheep.id), between: None })
    });
    let transitions =
        manifest.transitions.iter().map(|t| Owned { clip: &t.clip, sheep: None, between: Some((&t.from, &t.to)) });
    let owned: Vec<Owned> = loops.chain(transitions).collect();
    // A file that serves twice is looked at once.
    let mut first: HashMap<&Clip, usize> = HashMap::new();
    let mut distinct: Vec<&Clip> = Vec::new();
    for Owned { clip, .. } in &owned {
        first.entry(clip).or_insert_with(|| {
            distinct.push(clip);
            distinct.len() - 1
        });
    }
    let gone = |clip: &&Clip| open(&clip.path.inside(folder)).err().map(|finding| vec![named(clip, finding)]);
    let findings: Vec<Vec<Finding>> = match distinct.iter().map(gone).collect() {
        Some(all_gone) => all_gone,
        None => looked_at(folder, manifest, &distinct, video.decoder()?),
    };
    let mut faults = Vec::new();
    for owned in &owned {
        faults.extend(findings[first[owned.clip]].iter().map(|finding| fault(owned, finding)));
    }
    Ok(faults)
}

/// What is wrong with each of `clips`, on all cores.
fn looked_at(folder: &Path, manifest: &Manifest, clips: &[&Clip], decoder: &dyn Decoder) -> Vec<Vec<Finding>> {
    let form = Form { size: manifest.size, fps: manifest.fps };
    let bar = progress::bar("checking clips", clips.len());
    let look = |clip: &&Clip| {
        let found = look(folder, clip, &form, decoder);
        bar.inc(1);
        found
    };
    let findings = clips.par_iter().map(look).collect();
    bar.finish_and_clear();
    findings
}

fn fault(owned: &Owned<'_>, (kind, message): &Finding) -> Fault {
    Fault {
        kind: *kind,
        sheep: owned.sheep.cloned(),
        from: owned.between.map(|(from, _)| from.clone()),
        to: owned.between.map(|(_, to)| to.clone()),
        clip: Some(owned.clip.path.clone()),
        message: message.clone(),
    }
}

/// What is wrong with `clip`, each kind once: that it is not there, that its bytes are not those that were shipped,
/// that it has another form, that it does not decode.
fn look(folder: &Path, clip: &Clip, form: &Form, decoder: &dyn Decoder) -> Vec<Finding> {
    let path = clip.path.inside(folder);
    let mut found: Vec<Finding> = Vec::new();
    match open(&path) {
        Err(finding) => found.push(finding),
        Ok(file) => match clip.hash.and_then(|expected| other_bytes(file, expected)) {
            // What is damaged may have another form besides; that it does not decode is said already.
            Some(damage) => {
                let more = decoder.faults(&path, clip, form);
                found.extend(more.into_iter().filter(|(kind, _)| *kind != FaultKind::DamagedClip));
                found.insert(0, damage);
            }
            None => found.extend(decoder.faults(&path, clip, form)),
        },
    }
    found.into_iter().map(|finding| named(clip, finding)).collect()
}

/// `finding` as a sentence about `clip`.
fn named(clip: &Clip, (kind, why): Finding) -> Finding {
    (kind, format!("clip `{}` {why}", clip.path))
}

/// What is wrong with the clip in the file at `path`, one thing only: that it is no video, that it has another form, or
/// that it does not decode.
pub(crate) fn decoded(path: &Path, clip: &Clip, form: &Form) -> Vec<Finding> {
    let found = match video::probe(path) {
        Err(error) => Some((kind_of(&error), format!("cannot be shown: {}", chain(&error)))),
        Ok(probe) => other_form(&probe, form, clip.frames).or_else(|| undecodable(path, clip.frames)),
    };
    found.into_iter().collect()
}

/// How many frames the file at `path` has, which no manifest names yet; or why it cannot be a clip of a flock of this
/// `form`.
pub(crate) fn frames(path: &Path, form: &Form) -> Result<FrameCount, String> {
    open(path).map_err(|(_, why)| why)?;
    let probe = video::probe(path).map_err(|error| format!("cannot be shown: {}", chain(&error)))?;
    let found = other_form(&probe, form, probe.frames).or_else(|| undecodable(path, probe.frames));
    found.map_or(Ok(probe.frames), |(_, why)| Err(why))
}

/// How a clip differs from the `form` and the `frames` that it should have.
fn other_form(probe: &Probe, form: &Form, frames: FrameCount) -> Option<Finding> {
    let differences = probe.differences(form, frames);
    let told = differences.iter().map(ToString::to_string).collect::<Vec<_>>().join("; ");
    (!differences.is_empty()).then(|| (FaultKind::WrongClip, format!("has another form: {told}")))
}

/// The file at `path`, if it is one and has bytes.
fn open(path: &Path) -> Result<File, Finding> {
    let missing = |why: String| (FaultKind::MissingClip, why);
    let refused = |error: io::Error| {
        let gone = error.kind() == io::ErrorKind::NotFound;
        missing(if gone { "does not exist".into() } else { format!("cannot be read: {error}") })
    };
    let kind = std::fs::metadata(path).map_err(refused)?;
    if kind.is_dir() {
        return Err(missing("is a folder".into()));
    }
    if !kind.is_file() {
        return Err(missing("is not a file".into()));
    }
    if kind.len() == 0 {
        return Err((FaultKind::DamagedClip, "is empty".into()));
    }
    File::open(path).map_err(refused)
}

/// How the bytes of `file` are not the `expected` ones.
fn other_bytes(file: File, expected: ClipHash) -> Option<Finding> {
    let why = match ClipHash::of(file) {
        Ok(found) if found == expected => return None,
        Ok(found) => format!("does not match its hash (expected `{expected}`, found `{found}`)"),
        Err(error) => format!("cannot be read to its end: {error}"),
    };
    Some((FaultKind::DamagedClip, why))
}

/// How the clip at `path` fails to decode. One thread each: the clips are many.
fn undecodable(path: &Path, frames: FrameCount) -> Option<Finding> {
    let why = match video::decode_whole(path, NonZero::<usize>::MIN) {
        Ok(found) if found == frames => return None,
        Ok(found) => format!("yields {found} frames when decoded (expected {frames})"),
        Err(damage) => format!("does not decode cleanly: {damage}"),
    };
    Some((FaultKind::DamagedClip, why))
}

fn kind_of(error: &ProbeError) -> FaultKind {
    match error {
        ProbeError::Open { .. } | ProbeError::NotAFile { .. } => FaultKind::MissingClip,
        ProbeError::Empty { .. }
        | ProbeError::NotAVideo { .. }
        | ProbeError::Read { .. }
        | ProbeError::Truncated { .. } => FaultKind::DamagedClip,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;
    use std::path::PathBuf;
    use video::{Encoder, Quality, Yuv420p};

    const FRAMES: u32 = 12;

    /// A sheep whose loop is a clip of noise, in its own folder.
    struct Pen {
        folder: tempfile::TempDir,
        hash: String,
    }

    impl Pen {
        fn new() -> Self {
            let folder = tempfile::tempdir().unwrap();
            let clip = folder.path().join("a.mp4");
            encode(&clip, (64, 64), FRAMES);
            let hash = ClipHash::of(File::open(&clip).unwrap()).unwrap().to_string();
            Self { folder, hash }
        }

        fn clip(&self) -> PathBuf {
            self.folder.path().join("a.mp4")
        }

        /// The kinds found, where the manifest tells the hash of the clip as it was made, or none.
        fn kinds(&self, hashed: bool) -> Vec<FaultKind> {
            let hash = if hashed { format!("hash = \"{}\"\n", self.hash) } else { String::new() };
            let text = format!(
                "format = 1\nname = \"pen\"\nsize = [64, 64]\nfps = [30, 1]\n\
                 [[sheep]]\nid = \"a\"\nframes = {FRAMES}\nclip = \"a.mp4\"\n{hash}"
            );
            let manifest = Manifest::parse(&text, Path::new("flock.toml")).unwrap();
            let found = faults(self.folder.path(), &manifest, Video::here()).unwrap();
            for fault in &found {
                assert!(fault.message.contains("a.mp4"), "{}", fault.message);
                assert_eq!(fault.sheep.as_ref().unwrap().as_str(), "a");
            }
            found.iter().map(|fault| fault.kind).collect()
        }
    }

    fn encode(path: &Path, size: (u32, u32), frames: u32) {
        let form = Form { size, fps: timing::Rate::new(30, 1).unwrap() };
        let quality = Quality { crf: 20.0, preset: "ultrafast", max_bits_per_second: None };
        let mut encoder = Encoder::create(path, &form, quality).unwrap();
        for frame in 0..frames {
            let noise = |at: u32| (at.wrapping_add(frame * 977).wrapping_mul(2_654_435_761) >> 16) as u16;
            let rgb: Vec<u16> = (0..size.0 * size.1 * 3).map(noise).collect();
            encoder.push(&Yuv420p::from_rgb16(size.0, size.1, &rgb).unwrap()).unwrap();
        }
        encoder.finish().unwrap();
    }

    #[test]
    fn a_clip_as_it_was_made_has_no_fault() {
        let pen = Pen::new();
        assert_eq!(pen.kinds(true), []);
        assert_eq!(pen.kinds(false), []);
    }

    #[test]
    fn a_clip_that_is_not_there_is_missing() {
        let pen = Pen::new();
        fs::remove_file(pen.clip()).unwrap();
        assert_eq!(pen.kinds(true), [FaultKind::MissingClip]);
        fs::create_dir(pen.clip()).unwrap();
        assert_eq!(pen.kinds(true), [FaultKind::MissingClip]);
        fs::remove_dir(pen.clip()).unwrap();
        std::os::unix::fs::symlink(pen.clip(), pen.clip()).unwrap();
        assert_eq!(pen.kinds(true), [FaultKind::MissingClip]);
    }

    #[test]
    fn half_a_file_an_empty_one_and_a_scratched_one_are_damaged_with_or_without_a_hash() {
        let pen = Pen::new();
        let whole = fs::read(pen.clip()).unwrap();
        let mut scratched = whole.clone();
        scratched[whole.len() / 2..][..300].fill(0x55);
        for bytes in [&scratched[..], &whole[..whole.len() / 2], &[], b"not a video at all"] {
            fs::write(pen.clip(), bytes).unwrap();
            assert_eq!(pen.kinds(true), [FaultKind::DamagedClip], "{} bytes", bytes.len());
            assert_eq!(pen.kinds(false), [FaultKind::DamagedClip], "{} bytes", bytes.len());
        }
    }

    #[test]
    fn any_flipped_byte_differs_from_the_hash() {
        let pen = Pen::new();
        let whole = fs::read(pen.clip()).unwrap();
        for at in [5, whole.len() / 3, whole.len() / 2, whole.len() - 1] {
            let mut flipped = whole.clone();
            flipped[at] ^= 0x01;
            fs::write(pen.clip(), flipped).unwrap();
            assert!(pen.kinds(true).contains(&FaultKind::DamagedClip), "byte {at}");
        }
    }

    #[test]
    fn another_size_or_frame_count_is_wrong_and_not_what_was_hashed() {
        let pen = Pen::new();
        for (size, frames) in [((96, 64), FRAMES), ((64, 64), FRAMES - 1)] {
            encode(&pen.clip(), size, frames);
            assert_eq!(pen.kinds(false), [FaultKind::WrongClip]);
            assert_eq!(pen.kinds(true), [FaultKind::DamagedClip, FaultKind::WrongClip]);
        }
    }
}
