//! `flock.toml`, the manifest of a flock.
//!
//! Owns the keys, their limits and defaults. The graph is checked in `flock/faults.rs`, clips by `dreams check`:
//! duplicate sheep and transitions to unknown ones are read without an error.
//!
//! There are two ways of reading, chosen by the text:
//!
//! - In place (`plain.rs`), for the form that the tools write. A million transitions (98 MiB) take 1.1 s of processor time
//!   and 271 MiB, the most that a unit reads (2 MiB) takes 13 MiB.
//! - Through a TOML document (`toml`), for every other form, and for errors with line and key. The same take 4.9 s and
//!   2886 MiB, and 59 MiB; dotted keys take 560 times their bytes. With this way alone a unit, which has 256 MB of
//!   memory, could read 128 KiB and no more: 650 transitions with their hashes.
//!
//! Start at [`Manifest::read`].

mod excerpt;
mod names;
mod plain;
mod plain_manifest;
mod table;
#[cfg(test)]
mod tests;

use std::io::{self, Read};
use std::ops::RangeInclusive;
use std::path::Path;

use timing::{FrameCount, Rate};
use toml::de::DeTable;

pub use excerpt::excerpt;
use names::KnownIds;
pub use names::{ClipHash, ClipPath, NameError, SheepId};
use plain_manifest::{PlainManifest, plain};
pub use table::ManifestError;
use table::{Source, Table};

/// The manifest's name inside the folder.
pub const FILE_NAME: &str = "flock.toml";

/// The name of the root table in errors.
const MANIFEST: &str = "the manifest";
/// How the tables are headed.
const SHEEP: &str = "[[sheep]]";
const TRANSITION: &str = "[[transition]]";
/// The only format there is.
const FORMAT: u32 = 1;
/// Smallest and largest side of a picture: H.264 level 5.2 allows 4096, encoders need 16.
pub const SIDES_PX: RangeInclusive<u32> = 16..=4096;
/// Most frames of a clip: over a day at 30 per second.
pub const MAX_FRAMES: u32 = 4_000_000;
/// Most loops per visit.
pub const MAX_REPEATS: u32 = 10_000;
/// Most bytes of a manifest that a unit reads. A unit has 256 MB of memory; 100,000 sheep in a manifest of this size
/// take 60 MB.
pub const UNIT_BYTES: u64 = 2 << 20;
/// Most bytes of a manifest, or of its head, that a unit parses as a TOML document. Dotted keys, the worst case, take
/// 560 times their bytes.
pub const UNIT_DOCUMENT_BYTES: u64 = 128 << 10;
/// Fastest rate, per second.
pub const MAX_FPS: u32 = 240;

/// A flock as written.
#[derive(Clone, Debug, PartialEq)]
pub struct Manifest {
    /// Its name.
    pub name: String,
    /// Width and height in pixels, both even.
    pub size: (u32, u32),
    /// Frames per second of every clip.
    pub fps: Rate,
    /// In the order of the file; at least one.
    pub sheep: Vec<Sheep>,
    /// In the order of the file.
    pub transitions: Vec<Transition>,
}

/// An animation that loops.
#[derive(Clone, Debug, PartialEq)]
pub struct Sheep {
    /// Its name in the flock.
    pub id: SheepId,
    /// Its loop; `None` for a keyframe that only transitions use.
    pub clip: Option<Clip>,
    /// Its genome's file, if the flock has it.
    pub genome: Option<ClipPath>,
    /// Wished share relative to the others, finite, above 0.
    pub want: f64,
    /// Loops per visit, at least 1.
    pub repeat: u32,
}

/// A transition from one sheep to another.
#[derive(Clone, Debug, PartialEq)]
pub struct Transition {
    /// Where it starts.
    pub from: SheepId,
    /// Where it ends.
    pub to: SheepId,
    /// Its clip.
    pub clip: Clip,
    /// How readily the walk takes it, relative to the others from the same sheep; finite, above 0.
    pub weight: f64,
}

/// One encoded video file.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Clip {
    /// Where it lies.
    pub path: ClipPath,
    /// How many frames it has, at least 1.
    pub frames: FrameCount,
    /// The hash of its bytes, if the tools have written it.
    pub hash: Option<ClipHash>,
}

impl Manifest {
    /// Reads the manifest of the flock in `folder`.
    ///
    /// # Errors
    /// [`ManifestError`], which names file, line and key.
    pub fn read(folder: &Path) -> Result<Self, ManifestError> {
        let path = folder.join(FILE_NAME);
        match durable::open_plain(&path).and_then(io::read_to_string) {
            Ok(text) => Self::parse(&text, &path),
            Err(source) => Err(ManifestError::Read { path, source }),
        }
    }

    /// As [`Manifest::read`], within a unit's memory: at most [`UNIT_BYTES`], and at most [`UNIT_DOCUMENT_BYTES`] that
    /// are not in the plain form.
    ///
    /// # Errors
    /// The same; [`ManifestError::NotPlain`] and [`ManifestError::TooLarge`] besides.
    pub fn read_on_unit(folder: &Path) -> Result<Self, ManifestError> {
        let path = folder.join(FILE_NAME);
        let read = || {
            let (file, mut text) = (durable::open_plain(&path)?, String::new());
            let bytes = file.metadata()?.len();
            if bytes <= UNIT_BYTES {
                file.take(UNIT_BYTES).read_to_string(&mut text)?;
            }
            Ok((text, bytes))
        };
        match read() {
            Ok((text, bytes)) if bytes <= UNIT_BYTES => Self::parse_on_unit(&text, &path),
            Ok((_, bytes)) => Err(ManifestError::TooLarge { path, bytes, limit: UNIT_BYTES }),
            Err(source) => Err(ManifestError::Read { path, source }),
        }
    }

    /// Reads a manifest from `text`; `path` is only named in errors.
    ///
    /// # Errors
    /// [`ManifestError`], which names file, line and key.
    pub fn parse(text: &str, path: &Path) -> Result<Self, ManifestError> {
        Self::parse_unfinished(text, path)?.with_sheep(path)
    }

    /// As [`Manifest::parse`], within the bounds of [`Manifest::read_on_unit`].
    ///
    /// # Errors
    /// The same.
    pub fn parse_on_unit(text: &str, path: &Path) -> Result<Self, ManifestError> {
        let (source, bytes) = (Source { path, text }, text.len() as u64);
        if bytes > UNIT_BYTES {
            return Err(ManifestError::TooLarge { path: path.to_owned(), bytes, limit: UNIT_BYTES });
        }
        if bytes <= UNIT_DOCUMENT_BYTES {
            return Self::parse(text, path);
        }
        plain(source, UNIT_DOCUMENT_BYTES).map_err(|odd| odd.refused(source))?.with_sheep(path)
    }

    /// Itself, unless it has no sheep.
    fn with_sheep(self, path: &Path) -> Result<Self, ManifestError> {
        if self.sheep.is_empty() {
            let (path, similar) = (path.to_owned(), None);
            return Err(ManifestError::Missing { path, line: 1, key: "sheep", table: MANIFEST, similar });
        }
        Ok(self)
    }

    /// As [`Manifest::parse`], but a flock may be without sheep.
    pub(crate) fn parse_unfinished(text: &str, path: &Path) -> Result<Self, ManifestError> {
        let source = Source { path, text };
        // What `plain.rs` does not read is parsed as a document, for the value or for an error with line and key.
        plain(source, u64::MAX).or_else(|_| parsed(source))
    }

    /// Whether `text` reads as this manifest, which may be without sheep. Plain text is compared as it is read.
    pub(crate) fn is_written_in(&self, text: &str) -> bool {
        let source = Source { path: Path::new(FILE_NAME), text };
        let plain = PlainManifest::open(source, u64::MAX).and_then(|plain| plain.is(self));
        plain.unwrap_or_else(|_| parsed(source).is_ok_and(|read| read == *self))
    }

    /// Every clip that the manifest names, loops first, in the order of the file.
    pub fn clips(&self) -> impl Iterator<Item = &Clip> {
        let loops = self.sheep.iter().filter_map(|sheep| sheep.clip.as_ref());
        loops.chain(self.transitions.iter().map(|transition| &transition.clip))
    }
}

/// Parses the manifest in `source` as a TOML document.
fn parsed(source: Source<'_>) -> Result<Manifest, ManifestError> {
    let document = DeTable::parse(source.text).map_err(|error| source.syntax(&error))?;
    let mut table = Table::new(source, MANIFEST, &document);
    let (mut manifest, mut known) = (head(&mut table)?, KnownIds::default());
    if let Some(entry) = table.optional("sheep") {
        let tables = entry.tables(SHEEP)?.into_iter();
        manifest.sheep = tables.map(|table| sheep(table, &mut known)).collect::<Result<_, _>>()?;
    }
    if let Some(entry) = table.optional("transition") {
        let tables = entry.tables(TRANSITION)?.into_iter();
        manifest.transitions = tables.map(|table| transition(table, &mut known)).collect::<Result<_, _>>()?;
    }
    table.finish()?;
    Ok(manifest)
}

/// Reads the keys before the tables; sheep and transitions are empty.
fn head(table: &mut Table<'_, '_>) -> Result<Manifest, ManifestError> {
    table.required("format")?.whole(FORMAT, FORMAT)?;
    let name = table.required("name")?.text()?.to_owned();
    Ok(Manifest { name, size: size(table)?, fps: fps(table)?, sheep: Vec::new(), transitions: Vec::new() })
}

fn size(table: &mut Table<'_, '_>) -> Result<(u32, u32), ManifestError> {
    let entry = table.required("size")?;
    let (width, height) = entry.pair()?;
    let fine = |side: u32| SIDES_PX.contains(&side) && side.is_multiple_of(2);
    if fine(width) && fine(height) {
        Ok((width, height))
    } else {
        Err(entry.refused(format!("an even width and height from {} to {}", SIDES_PX.start(), SIDES_PX.end())))
    }
}

fn fps(table: &mut Table<'_, '_>) -> Result<Rate, ManifestError> {
    let entry = table.required("fps")?;
    let (num, den) = entry.pair()?;
    Rate::new(num.into(), den.into())
        .ok()
        .filter(|rate| rate.num() / rate.den() <= MAX_FPS && rate.num() >= rate.den())
        .ok_or_else(|| entry.refused(format!("numerator and denominator of a rate from 1 to {MAX_FPS} per second")))
}

/// Reads a sheep; its id may be among those that are `known`.
fn sheep(mut table: Table<'_, '_>, known: &mut KnownIds) -> Result<Sheep, ManifestError> {
    let id = table.required("id")?.name(|text| known.id(text))?;
    let (frames, path, hash) = (table.optional("frames"), table.optional("clip"), table.optional("hash"));
    let clip = match (&frames, &path, &hash) {
        (None, None, None) => None,
        (None, Some(_) | None, _) => return Err(table.missing("frames")),
        (Some(_), None, _) => return Err(table.missing("clip")),
        (Some(frames), Some(path), hash) => Some(Clip {
            path: path.name(ClipPath::new)?,
            frames: FrameCount(frames.whole(1, MAX_FRAMES)?),
            hash: hash.as_ref().map(|entry| entry.name(ClipHash::parse)).transpose()?,
        }),
    };
    let genome = table.optional("genome").map(|entry| entry.name(ClipPath::new)).transpose()?;
    let want = table.optional("want").map_or(Ok(1.0), |entry| entry.positive())?;
    let repeat = table.optional("repeat").map_or(Ok(1), |entry| entry.whole(1, MAX_REPEATS))?;
    table.finish()?;
    Ok(Sheep { id, clip, genome, want, repeat })
}

/// Reads a transition between sheep whose ids may be among those that are `known`.
fn transition(mut table: Table<'_, '_>, known: &mut KnownIds) -> Result<Transition, ManifestError> {
    let from = table.required("from")?.name(|text| known.id(text))?;
    let to = table.required("to")?.name(|text| known.id(text))?;
    let frames = FrameCount(table.required("frames")?.whole(1, MAX_FRAMES)?);
    let path = table.required("clip")?.name(ClipPath::new)?;
    let hash = table.optional("hash").map(|entry| entry.name(ClipHash::parse)).transpose()?;
    let weight = table.optional("weight").map_or(Ok(1.0), |entry| entry.positive())?;
    table.finish()?;
    Ok(Transition { from, to, clip: Clip { path, frames, hash }, weight })
}
