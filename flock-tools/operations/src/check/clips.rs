//! The faults of a flock's clips.
//!
//! Owns what is checked of each file: that it is there, is whole, and has the flock's form. Never judges the graph.
//!
//! Start at [`faults`].

use std::collections::HashMap;
use std::fs::File;
use std::io;
use std::path::Path;

use flock::{Clip, ClipHash, Fault, FaultKind, Manifest, SheepId};
use rayon::iter::{IntoParallelRefIterator, ParallelIterator};
use timing::FrameCount;
use video::{Form, Probe, ProbeError};

use crate::decoder::{Decoder, DecoderHandle};
use crate::program::{Fatal, chain, progress};

/// A clip, and the loop or the transition that it is.
struct ClipUse<'a> {
    clip: &'a Clip,
    sheep: Option<&'a SheepId>,
    between: Option<(&'a SheepId, &'a SheepId)>,
}

/// A fault of a file, by kind and in words.
type Finding = (FaultKind, String);

/// Every fault of the clips of the flock in `folder`, in the order of the manifest. Shows its progress on a terminal.
/// If no clip is there, no decoder is asked for.
/// Errors: If a clip is there, and the decoder cannot be started.
pub fn faults(folder: &Path, manifest: &Manifest, decoder: DecoderHandle) -> Result<Vec<Fault>, Fatal> {
    let gone = |clip_use: ClipUse| {
        let finding = open(&clip_use.clip.path.inside(folder)).err()?;
        Some(fault(&clip_use, named(clip_use.clip, finding)))
    };
    if let Some(all_gone) = uses(manifest).map(gone).collect() {
        return Ok(all_gone);
    }
    // A file that is used twice is checked once.
    let mut first: HashMap<&Clip, usize> = HashMap::new();
    let mut distinct: Vec<&Clip> = Vec::new();
    for ClipUse { clip, .. } in uses(manifest) {
        first.entry(clip).or_insert_with(|| {
            distinct.push(clip);
            distinct.len() - 1
        });
    }
    let findings = check_all(folder, manifest, &distinct, decoder.get()?);
    let found = |clip_use: ClipUse| {
        let findings = findings[first[clip_use.clip]].iter().cloned();
        findings.map(|finding| fault(&clip_use, finding)).collect::<Vec<Fault>>()
    };
    Ok(uses(manifest).flat_map(found).collect())
}

/// Every loop and every transition of `manifest`.
fn uses(manifest: &Manifest) -> impl Iterator<Item = ClipUse<'_>> {
    let loops = manifest.sheep.iter().filter_map(|sheep| {
        let clip = sheep.clip.as_ref()?;
        Some(ClipUse { clip, sheep: Some(&sheep.id), between: None })
    });
    let transitions =
        manifest.transitions.iter().map(|t| ClipUse { clip: &t.clip, sheep: None, between: Some((&t.from, &t.to)) });
    loops.chain(transitions)
}

/// The findings of each of `clips`, on all cores.
fn check_all(folder: &Path, manifest: &Manifest, clips: &[&Clip], decoder: &dyn Decoder) -> Vec<Box<[Finding]>> {
    let form = Form { size: manifest.size, fps: manifest.fps };
    let bar = progress::bar("checking clips", clips.len());
    let check = |clip: &&Clip| {
        let findings = check(folder, clip, &form, decoder);
        bar.inc(1);
        findings.into_boxed_slice()
    };
    let findings = clips.par_iter().map(check).collect();
    bar.finish_and_clear();
    findings
}

fn fault(clip_use: &ClipUse<'_>, (kind, message): Finding) -> Fault {
    Fault {
        kind,
        sheep: clip_use.sheep.cloned(),
        from: clip_use.between.map(|(from, _)| from.clone()),
        to: clip_use.between.map(|(_, to)| to.clone()),
        clip: Some(clip_use.clip.path.clone()),
        message,
    }
}

/// The findings of `clip`, each kind once: it is missing, its hash is wrong, it has another form, it does not decode.
fn check(folder: &Path, clip: &Clip, form: &Form, decoder: &dyn Decoder) -> Vec<Finding> {
    let path = clip.path.inside(folder);
    let mut findings: Vec<Finding> = Vec::new();
    match open(&path) {
        Err(finding) => findings.push(finding),
        Ok(file) => match clip.hash.and_then(|expected| other_bytes(file, expected)) {
            // A damaged clip may have another form besides; that it does not decode is clear already.
            Some(damage) => {
                let other = form_or_damage(&path, clip, form, decoder);
                findings.push(damage);
                findings.extend(other.filter(|(kind, _)| *kind != FaultKind::DamagedClip));
            }
            None => findings.extend(form_or_damage(&path, clip, form, decoder)),
        },
    }
    findings.into_iter().map(|finding| named(clip, finding)).collect()
}

/// `finding` as a sentence about `clip`.
fn named(clip: &Clip, (kind, why): Finding) -> Finding {
    // Of the right length: a large flock may lack a million clips.
    (kind, ["clip `", clip.path.as_str(), "` ", &why].concat())
}

/// The first of these that is true of the clip in the file at `path`: it is no video, it has another form, it does not
/// decode.
fn form_or_damage(path: &Path, clip: &Clip, form: &Form, decoder: &dyn Decoder) -> Option<Finding> {
    match decoder.probe(path) {
        Err(error) => Some((kind_of(&error), format!("cannot be shown: {}", chain(&error)))),
        Ok(probe) => other_form(&probe, form, clip.frames).or_else(|| damage(path, clip.frames, decoder)),
    }
}

/// The number of frames of the file at `path`, which no manifest names yet; or why it cannot be a clip of a flock of
/// this `form`.
pub fn frames(path: &Path, form: &Form, decoder: &dyn Decoder) -> Result<FrameCount, String> {
    open(path).map_err(|(_, why)| why)?;
    let probe = decoder.probe(path).map_err(|error| format!("cannot be shown: {}", chain(&error)))?;
    let finding = other_form(&probe, form, probe.frames).or_else(|| damage(path, probe.frames, decoder));
    finding.map_or(Ok(probe.frames), |(_, why)| Err(why))
}

/// How a clip differs from the `form` and the `frames` that it should have.
fn other_form(probe: &Probe, form: &Form, frames: FrameCount) -> Option<Finding> {
    let differences = probe.differences(form, frames);
    let list = differences.iter().map(ToString::to_string).collect::<Vec<_>>().join("; ");
    (!differences.is_empty()).then(|| (FaultKind::WrongClip, format!("has another form: {list}")))
}

/// The file at `path`, if it is a plain file and not empty.
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

/// That the bytes of `file` have another hash than `expected`.
fn other_bytes(file: File, expected: ClipHash) -> Option<Finding> {
    let why = match ClipHash::of(file) {
        Ok(found) if found == expected => return None,
        Ok(found) => format!("does not match its hash (expected `{expected}`, found `{found}`)"),
        Err(error) => format!("cannot be read to its end: {error}"),
    };
    Some((FaultKind::DamagedClip, why))
}

/// That the clip at `path` does not decode cleanly to its number of `frames`.
fn damage(path: &Path, frames: FrameCount, decoder: &dyn Decoder) -> Option<Finding> {
    let why = match decoder.decode(path) {
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
    use crate::decoder::ffmpeg::Ffmpeg;
    use std::fs;
    use std::path::PathBuf;
    use video::{Encoder, Quality, Tuning, Yuv420p};

    const FRAMES: u32 = 12;

    /// A sheep whose loop is a clip of noise, in its own folder.
    struct TestFlock {
        folder: tempfile::TempDir,
        hash: String,
    }

    impl TestFlock {
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
                "format = 1\nname = \"test\"\nsize = [64, 64]\nfps = [30, 1]\n\
                 [[sheep]]\nid = \"a\"\nframes = {FRAMES}\nclip = \"a.mp4\"\n{hash}"
            );
            let manifest = Manifest::parse(&text, Path::new("flock.toml")).unwrap();
            let faults = faults(self.folder.path(), &manifest, DecoderHandle(Some(&Ffmpeg))).unwrap();
            for fault in &faults {
                assert!(fault.message.contains("a.mp4"), "{}", fault.message);
                assert_eq!(fault.sheep.as_ref().unwrap().as_str(), "a");
            }
            faults.iter().map(|fault| fault.kind).collect()
        }
    }

    fn encode(path: &Path, size: (u32, u32), frames: u32) {
        let form = Form { size, fps: timing::Rate::new(30, 1).unwrap() };
        let quality = Quality { crf: 20.0, preset: "ultrafast", tuning: Tuning::Film, max_bits_per_second: None };
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
        let flock = TestFlock::new();
        assert_eq!(flock.kinds(true), []);
        assert_eq!(flock.kinds(false), []);
    }

    #[test]
    fn a_clip_that_is_not_there_is_missing() {
        let flock = TestFlock::new();
        fs::remove_file(flock.clip()).unwrap();
        assert_eq!(flock.kinds(true), [FaultKind::MissingClip]);
        fs::create_dir(flock.clip()).unwrap();
        assert_eq!(flock.kinds(true), [FaultKind::MissingClip]);
        fs::remove_dir(flock.clip()).unwrap();
        std::os::unix::fs::symlink(flock.clip(), flock.clip()).unwrap();
        assert_eq!(flock.kinds(true), [FaultKind::MissingClip]);
    }

    #[test]
    fn half_a_file_an_empty_one_and_a_scratched_one_are_damaged_with_or_without_a_hash() {
        let flock = TestFlock::new();
        let whole = fs::read(flock.clip()).unwrap();
        let mut scratched = whole.clone();
        scratched[whole.len() / 2..][..300].fill(0x55);
        for bytes in [&scratched[..], &whole[..whole.len() / 2], &[], b"not a video at all"] {
            fs::write(flock.clip(), bytes).unwrap();
            assert_eq!(flock.kinds(true), [FaultKind::DamagedClip], "{} bytes", bytes.len());
            assert_eq!(flock.kinds(false), [FaultKind::DamagedClip], "{} bytes", bytes.len());
        }
    }

    #[test]
    fn any_flipped_byte_differs_from_the_hash() {
        let flock = TestFlock::new();
        let whole = fs::read(flock.clip()).unwrap();
        for at in [5, whole.len() / 3, whole.len() / 2, whole.len() - 1] {
            let mut flipped = whole.clone();
            flipped[at] ^= 0x01;
            fs::write(flock.clip(), flipped).unwrap();
            assert!(flock.kinds(true).contains(&FaultKind::DamagedClip), "byte {at}");
        }
    }

    #[test]
    fn another_size_or_frame_count_is_wrong_and_not_what_was_hashed() {
        let flock = TestFlock::new();
        for (size, frames) in [((96, 64), FRAMES), ((64, 64), FRAMES - 1)] {
            encode(&flock.clip(), size, frames);
            assert_eq!(flock.kinds(false), [FaultKind::WrongClip]);
            assert_eq!(flock.kinds(true), [FaultKind::DamagedClip, FaultKind::WrongClip]);
        }
    }
}
