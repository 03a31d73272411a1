//! `flock.toml`: what a flock is, as its artist wrote it.
//!
//! Owns the keys, their limits and defaults. Never judges the graph (`flock/faults.rs` does) and never opens a clip
//! (`flock check` does): sheep named twice or leading nowhere are read as they stand.
//!
//! There are two ways of reading, chosen by the text:
//!
//! - In place (`plain.rs`), for the form that the tools write. A million transitions (98 MiB) take 1.1 s of processor time
//!   and 271 MiB, the most that a unit reads (2 MiB) takes 13 MiB.
//! - By way of a TOML document (`toml`), for every other form, and to word what is wrong with line and key. The same take
//!   4.9 s and 2886 MiB, and 59 MiB; dotted keys take 560 times their bytes. With this way alone a unit, which has 256 MB
//!   of memory, could read 128 KiB and no more: 650 transitions with their hashes.
//!
//! Start at [`Manifest::read`].

mod names;
mod plain;
mod table;
#[cfg(test)]
mod tests;
mod told;

use std::fs::File;
use std::io::Read;
use std::ops::RangeInclusive;
use std::path::Path;

use timing::{FrameCount, Rate};
use toml::de::DeTable;

pub use names::{ClipHash, ClipPath, NameError, SheepId};
use plain::{Block, Blocks};
pub use table::ManifestError;
use table::{Source, Table};
pub use told::told;

/// The manifest's name inside the folder.
pub const FILE_NAME: &str = "flock.toml";

/// What errors call the table around all others.
const MANIFEST: &str = "the manifest";
/// How the tables are headed.
const SHEEP: &str = "[[sheep]]";
const TRANSITION: &str = "[[transition]]";
/// The only format there is.
const FORMAT: u32 = 1;
/// Smallest and largest side of a picture: H.264 level 5.2 ends at 4096, its encoders want 16.
pub const SIDES_PX: RangeInclusive<u32> = 16..=4096;
/// Most frames of a clip: over a day at 30 per second.
pub const MOST_FRAMES: u32 = 4_000_000;
/// Most loops per visit.
pub const MOST_REPEATS: u32 = 10_000;
/// Most bytes of a manifest that a unit reads. A unit has 256 MB of memory; 100,000 sheep in so many bytes take 60 of
/// them.
pub const UNIT_BYTES: u64 = 2 << 20;
/// Most bytes of a manifest, or of its head, that a unit reads by way of a whole TOML document. Dotted keys, the worst
/// of all, take 560 times their bytes.
pub const UNIT_DOCUMENT_BYTES: u64 = 128 << 10;
/// Fastest rate, per second.
pub const FASTEST_FPS: u32 = 240;

/// A flock as written.
#[derive(Clone, Debug, PartialEq)]
pub struct Manifest {
    /// What the artist calls it.
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

/// An animated flame.
#[derive(Clone, Debug, PartialEq)]
pub struct Sheep {
    /// Its name in the flock.
    pub id: SheepId,
    /// Its loop; `None` for a keyframe that is only passed through.
    pub clip: Option<Clip>,
    /// Its genome's file, if it travels along.
    pub genome: Option<ClipPath>,
    /// Wished share relative to the others, finite, above 0.
    pub want: f64,
    /// Loops per visit, at least 1.
    pub repeat: u32,
}

/// The way from one sheep to another.
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
    /// What its bytes hash to, where the tools have written it.
    pub hash: Option<ClipHash>,
}

impl Manifest {
    /// Reads the manifest of the flock in `folder`.
    ///
    /// # Errors
    /// [`ManifestError`], which names file, line and key.
    pub fn read(folder: &Path) -> Result<Self, ManifestError> {
        let path = folder.join(FILE_NAME);
        match std::fs::read_to_string(&path) {
            Ok(text) => Self::parse(&text, &path),
            Err(source) => Err(ManifestError::Read { path, source }),
        }
    }

    /// As [`Manifest::read`], but never more than a unit has the memory for: [`UNIT_BYTES`], of which no more than
    /// [`UNIT_DOCUMENT_BYTES`] that are not plain.
    ///
    /// # Errors
    /// The same; [`ManifestError::NotPlain`] and [`ManifestError::TooLarge`] besides.
    pub fn read_on_unit(folder: &Path) -> Result<Self, ManifestError> {
        let path = folder.join(FILE_NAME);
        let read = || {
            let (file, mut text) = (File::open(&path)?, String::new());
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

    /// Itself, unless it is without sheep.
    fn with_sheep(self, path: &Path) -> Result<Self, ManifestError> {
        if self.sheep.is_empty() {
            return Err(ManifestError::Missing { path: path.to_owned(), line: 1, key: "sheep", table: MANIFEST });
        }
        Ok(self)
    }

    /// As [`Manifest::parse`], but a flock may be without sheep.
    pub(crate) fn parse_unfinished(text: &str, path: &Path) -> Result<Self, ManifestError> {
        let source = Source { path, text };
        // What the quick way cannot read, or refuses, the parser reads, or refuses with line and key.
        plain(source, u64::MAX).or_else(|_| parsed(source))
    }

    /// Every clip that the manifest names, loops first, in the order of the file.
    pub fn clips(&self) -> impl Iterator<Item = &Clip> {
        let loops = self.sheep.iter().filter_map(|sheep| sheep.clip.as_ref());
        loops.chain(self.transitions.iter().map(|transition| &transition.clip))
    }
}

/// The manifest in `source`, by way of a whole TOML document.
fn parsed(source: Source<'_>) -> Result<Manifest, ManifestError> {
    let document = DeTable::parse(source.text).map_err(|error| source.syntax(&error))?;
    let mut table = Table::new(source, MANIFEST, &document);
    let mut manifest = head(&mut table)?;
    if let Some(entry) = table.optional("sheep") {
        manifest.sheep = entry.tables(SHEEP)?.into_iter().map(sheep).collect::<Result<_, _>>()?;
    }
    if let Some(entry) = table.optional("transition") {
        manifest.transitions = entry.tables(TRANSITION)?.into_iter().map(transition).collect::<Result<_, _>>()?;
    }
    table.finish()?;
    Ok(manifest)
}

/// Why a manifest was not read in place.
enum Odd {
    /// It is plain, and wrong.
    Fault(ManifestError),
    /// At this byte it is not plain: so many bytes would have to be read as a TOML document.
    NotPlain { at: usize, bytes: u64 },
}

impl Odd {
    /// What whoever builds no document of `source` says.
    fn refused(self, source: Source<'_>) -> ManifestError {
        match self {
            Self::Fault(error) => error,
            Self::NotPlain { at, bytes } => source.not_plain(at, bytes, UNIT_DOCUMENT_BYTES),
        }
    }
}

impl From<ManifestError> for Odd {
    fn from(error: ManifestError) -> Self {
        Self::Fault(error)
    }
}

/// The manifest in `source`, if it is plain and without fault, and its head has no more than `most` bytes.
fn plain(source: Source<'_>, most: u64) -> Result<Manifest, Odd> {
    let not_plain = |at| Odd::NotPlain { at, bytes: source.text.len() as u64 };
    let (text, mut blocks) = Blocks::split(source.text).map_err(not_plain)?;
    let bytes = text.len() as u64;
    if bytes > most {
        return Err(Odd::NotPlain { at: 0, bytes });
    }
    let document = DeTable::parse(text).map_err(|error| source.syntax(&error))?;
    let mut table = Table::new(source, MANIFEST, &document);
    let mut manifest = head(&mut table)?;
    table.finish()?;
    let mut block = Block::new();
    loop {
        match (blocks.next(&mut block), block.name) {
            (None, _) => return Err(not_plain(blocks.at())),
            (Some(false), _) => return Ok(manifest),
            (Some(true), "sheep") => manifest.sheep.push(sheep(Table::plain(source, SHEEP, &block))?),
            (Some(true), "transition") => {
                manifest.transitions.push(transition(Table::plain(source, TRANSITION, &block))?);
            }
            (Some(true), _) => return Err(not_plain(block.at)),
        }
    }
}

/// What stands before the tables; sheep and transitions are still to come.
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
        .filter(|rate| rate.num() / rate.den() <= FASTEST_FPS && rate.num() >= rate.den())
        .ok_or_else(|| entry.refused(format!("numerator and denominator of a rate from 1 to {FASTEST_FPS} per second")))
}

fn sheep(mut table: Table<'_, '_>) -> Result<Sheep, ManifestError> {
    let id = table.required("id")?.name(SheepId::new)?;
    let (frames, path, hash) = (table.optional("frames"), table.optional("clip"), table.optional("hash"));
    let clip = match (&frames, &path, &hash) {
        (None, None, None) => None,
        (None, Some(_) | None, _) => return Err(table.missing("frames")),
        (Some(_), None, _) => return Err(table.missing("clip")),
        (Some(frames), Some(path), hash) => Some(Clip {
            path: path.name(ClipPath::new)?,
            frames: FrameCount(frames.whole(1, MOST_FRAMES)?),
            hash: hash.as_ref().map(|entry| entry.name(ClipHash::parse)).transpose()?,
        }),
    };
    let genome = table.optional("genome").map(|entry| entry.name(ClipPath::new)).transpose()?;
    let want = table.optional("want").map_or(Ok(1.0), |entry| entry.positive())?;
    let repeat = table.optional("repeat").map_or(Ok(1), |entry| entry.whole(1, MOST_REPEATS))?;
    table.finish()?;
    Ok(Sheep { id, clip, genome, want, repeat })
}

fn transition(mut table: Table<'_, '_>) -> Result<Transition, ManifestError> {
    let from = table.required("from")?.name(SheepId::new)?;
    let to = table.required("to")?.name(SheepId::new)?;
    let frames = FrameCount(table.required("frames")?.whole(1, MOST_FRAMES)?);
    let path = table.required("clip")?.name(ClipPath::new)?;
    let hash = table.optional("hash").map(|entry| entry.name(ClipHash::parse)).transpose()?;
    let weight = table.optional("weight").map_or(Ok(1.0), |entry| entry.positive())?;
    table.finish()?;
    Ok(Transition { from, to, clip: Clip { path, frames, hash }, weight })
}
