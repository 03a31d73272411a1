//! Keys, and what they stand for.
//!
//! Owns how a key is made: of the clip's hash, size and time of change, or of the texts of genomes, with the version of what
//! is made of them. Whoever gives a key to the page has it remembered here; a key that was never given stands for nothing,
//! so that no request names a path. Opens no clip.
//!
//! Start at [`Media::strip_key`] and [`Media::pair_key`].

use std::collections::HashMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};
use std::time::{SystemTime, UNIX_EPOCH};

use flock::{Clip, ClipHash, Manifest, SheepId};
use operations::render::selection::usual_turn;
use timing::FrameCount;
use video::Form;

use super::{Media, MediaError};
use crate::lock::locked;

/// The version of what is kept: another one makes everything again.
const VERSION: &str = concat!("1 of ", env!("CARGO_PKG_VERSION"));
/// Hexadecimal digits of a key: 128 bits.
const DIGITS: usize = 32;
/// Frames in which a sheep without a loop turns for its strip.
const TURN: FrameCount = FrameCount(240);

/// A transition that there is, or that there might be.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pair<'a> {
    pub(crate) from: &'a SheepId,
    pub(crate) to: &'a SheepId,
    pub(crate) frames: FrameCount,
}

/// What something is made of.
#[derive(Clone, Debug)]
pub(super) enum Source {
    /// A clip that is there, in the flock's form; and the genome to fall back on if it is damaged.
    Clip { clip: Clip, form: Form, genome: Option<PathBuf> },
    /// A genome without a clip.
    Genome { path: PathBuf, turn: FrameCount, form: Form },
    /// Two genomes.
    Pair(PairSource),
}

/// The two ends of a transition.
#[derive(Clone, Debug)]
pub(super) struct PairSource {
    pub(super) names: [SheepId; 2],
    pub(super) genomes: [PathBuf; 2],
    /// The frames in which each turns once.
    pub(super) turns: [FrameCount; 2],
    pub(super) frames: FrameCount,
    pub(super) form: Form,
}

/// A file's size and when it was changed.
type Stamp = (u64, Option<SystemTime>);

/// What is known of keys and files.
#[derive(Debug, Default)]
pub(super) struct Sources {
    given: Mutex<HashMap<String, Arc<Source>>>,
    /// The hashes of genomes' texts.
    texts: Mutex<HashMap<PathBuf, (Stamp, ClipHash)>>,
}

impl Sources {
    /// What `key` stands for.
    pub(super) fn find(&self, key: &str) -> Result<Arc<Source>, MediaError> {
        let given = locked(&self.given);
        given.get(key).cloned().ok_or_else(|| MediaError::Unknown { key: key.to_owned() })
    }

    /// Gives the key of what `text` describes, and remembers what it stands for.
    fn give(&self, text: &str, source: impl FnOnce() -> Source) -> String {
        let hash = ClipHash::of(format!("{VERSION}\n{text}").as_bytes()).expect("reading memory does not fail");
        let key: String = hash.to_string().chars().skip("b3:".len()).take(DIGITS).collect();
        let mut given = locked(&self.given);
        given.entry(key.clone()).or_insert_with(|| Arc::new(source()));
        key
    }

    /// The hash of the genome at `path`, which is read if it has changed; `None` if it is not there.
    fn text(&self, path: &Path) -> Option<ClipHash> {
        let stamp = stamp(path)?;
        let known = || locked(&self.texts);
        if let Some((_, hash)) = known().get(path).filter(|(known, _)| *known == stamp) {
            return Some(*hash);
        }
        let hash = fs::File::open(path).and_then(ClipHash::of).ok()?;
        known().insert(path.to_owned(), (stamp, hash));
        Some(hash)
    }
}

impl Media {
    /// Whether `key` was given to the page since the program began.
    pub(crate) fn knows(&self, key: &str) -> bool {
        self.sources.find(key).is_ok()
    }

    /// The key of the strip and the poster of a sheep: of its loop `clip` if that is there, else of its `genome`.
    pub(crate) fn strip_key(&self, form: Form, clip: Option<&Clip>, genome: Option<&Path>) -> Option<String> {
        let of_clip = clip.and_then(|clip| self.clip_key(form, clip, genome));
        of_clip.or_else(|| {
            let path = genome?;
            let turn = clip.map_or(TURN, |clip| clip.frames);
            let (hash, (width, height)) = (self.sources.text(path)?, form.size);
            let text = format!("genome {hash} {turn} {width}x{height}");
            Some(self.sources.give(&text, || Source::Genome { path: path.to_owned(), turn, form }))
        })
    }

    /// The key of the fragments and the packets of a clip that is there.
    pub(crate) fn fragments_key(&self, form: Form, clip: &Clip) -> Option<String> {
        self.clip_key(form, clip, None)
    }

    fn clip_key(&self, form: Form, clip: &Clip, genome: Option<&Path>) -> Option<String> {
        let (bytes, changed) = stamp(&clip.path.inside(&self.folder))?;
        let changed = changed?.duration_since(UNIX_EPOCH).map_or(0, |since| since.as_nanos());
        let name = clip.hash.map_or_else(|| clip.path.as_str().to_owned(), |hash| hash.to_string());
        let text = format!("clip {name} {bytes} {changed} {} {form:?}", clip.frames);
        let (clip, genome) = (clip.clone(), genome.map(Path::to_owned));
        Some(self.sources.give(&text, || Source::Clip { clip, form, genome }))
    }

    /// The key of the previews of a transition; `None` unless both its sheep have genomes.
    pub(crate) fn pair_key(&self, manifest: &Manifest, pair: &Pair<'_>) -> Option<String> {
        let end = |id: &SheepId| {
            let sheep = manifest.sheep.iter().find(|sheep| sheep.id == *id)?;
            let path = sheep.genome.as_ref()?.inside(&self.folder);
            let turn = sheep.clip.as_ref().map_or_else(|| usual_turn(manifest), |clip| clip.frames);
            let hash = self.sources.text(&path)?;
            Some((path, turn, hash))
        };
        let (from, to, frames) = (end(pair.from)?, end(pair.to)?, pair.frames);
        let form = Form { size: manifest.size, fps: manifest.fps };
        let text = format!("pair {} {} {} {} {frames} {form:?}", from.2, from.1, to.2, to.1);
        let source = || {
            let names = [pair.from.clone(), pair.to.clone()];
            Source::Pair(PairSource { names, genomes: [from.0, to.0], turns: [from.1, to.1], frames, form })
        };
        Some(self.sources.give(&text, source))
    }
}

fn stamp(path: &Path) -> Option<Stamp> {
    let status = fs::metadata(path).ok().filter(fs::Metadata::is_file)?;
    Some((status.len(), status.modified().ok()))
}
