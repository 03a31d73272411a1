//! `flock.toml`: what a flock is, as its artist wrote it.
//!
//! Owns the keys, their limits and defaults. Never judges the graph (`faults.rs` does) and never opens a clip
//! (`flock check` does): sheep named twice or leading nowhere are read as they stand.
//!
//! Start at [`Manifest::read`].

use std::ops::RangeInclusive;
use std::path::Path;

use timing::{FrameCount, Rate};
use toml::de::DeTable;

use crate::names::{ClipHash, ClipPath, SheepId};
use crate::plain::{Block, Blocks};
use crate::table::{ManifestError, Source, Table};

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

    /// Reads a manifest from `text`; `path` is only named in errors.
    ///
    /// # Errors
    /// [`ManifestError`], which names file, line and key.
    pub fn parse(text: &str, path: &Path) -> Result<Self, ManifestError> {
        let manifest = Self::parse_unfinished(text, path)?;
        if manifest.sheep.is_empty() {
            return Err(ManifestError::Missing { path: path.to_owned(), line: 1, key: "sheep", table: MANIFEST });
        }
        Ok(manifest)
    }

    /// As [`Manifest::parse`], but a flock may be without sheep.
    pub(crate) fn parse_unfinished(text: &str, path: &Path) -> Result<Self, ManifestError> {
        let source = Source { path, text };
        // What the quick way cannot read, or refuses, the parser reads, or refuses with line and key.
        if let Some(manifest) = plain(source) {
            return Ok(manifest);
        }
        parsed(source)
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

/// The manifest in `source`, if it is plain and without fault.
fn plain(source: Source<'_>) -> Option<Manifest> {
    let (text, mut blocks) = Blocks::split(source.text)?;
    let document = DeTable::parse(text).ok()?;
    let mut table = Table::new(source, MANIFEST, &document);
    let mut manifest = head(&mut table).ok()?;
    table.finish().ok()?;
    let mut block = Block::new();
    while blocks.next(&mut block)? {
        match block.name {
            "sheep" => manifest.sheep.push(sheep(Table::plain(source, SHEEP, &block)).ok()?),
            "transition" => manifest.transitions.push(transition(Table::plain(source, TRANSITION, &block)).ok()?),
            _ => return None,
        }
    }
    Some(manifest)
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

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const HEAD: &str = "format = 1\nname = \"aurora\"\nsize = [1280, 720]\nfps = [30000, 1001]\n";

    fn parse(text: &str) -> Result<Manifest, ManifestError> {
        Manifest::parse(text, Path::new("aurora/flock.toml"))
    }

    fn said(body: &str) -> String {
        parse(&format!("{HEAD}{body}")).unwrap_err().to_string()
    }

    #[test]
    fn every_key_of_the_contract_is_read() {
        let hash = ClipHash::of(&b"x"[..]).unwrap();
        let text = format!(
            "{HEAD}[[sheep]]\nid = \"a\"\nframes = 768\nclip = \"loops/a.mp4\"\ngenome = \"genomes/a.flam3\"\n\
             hash = \"{hash}\"\nwant = 2\nrepeat = 3\n[[sheep]]\nid = \"b\"\n\
             [[transition]]\nfrom = \"a\"\nto = \"b\"\nframes = 384\nclip = \"t/a=b.mp4\"\nweight = 0.25\n"
        );
        let flock = parse(&text).unwrap();
        assert_eq!((flock.name.as_str(), flock.size, flock.fps.den()), ("aurora", (1280, 720), 1001));
        let a = &flock.sheep[0];
        assert_eq!((a.want, a.repeat, a.clip.as_ref().unwrap().hash), (2.0, 3, Some(hash)));
        assert_eq!(flock.sheep[1].clip, None);
        assert_eq!((flock.transitions[0].weight, flock.transitions[0].clip.frames), (0.25, FrameCount(384)));
        assert_eq!(flock.clips().count(), 2);
    }

    #[test]
    fn refusals_name_file_line_key_and_both_values() {
        assert_eq!(
            said("[[sheep]]\nid = \"a\"\nwant = -1.5\n"),
            "`aurora/flock.toml`, line 7, key `want`: wanted a finite number above 0, found `-1.5`"
        );
        assert_eq!(
            said("[[sheep]]\nid = \"a b\"\n"),
            "`aurora/flock.toml`, line 6, key `id`: wanted 1 to 64 of `A-Z a-z 0-9 . _ -`, found `a b`"
        );
        assert_eq!(
            said("[[sheep]]\nid = \"a\"\nwnat = 1\n"),
            "`aurora/flock.toml`, line 7: unknown key `wnat` in [[sheep]], which has `id`, `frames`, `clip`, `hash`, \
             `genome`, `want`, `repeat`"
        );
        assert_eq!(
            said("[[sheep]]\nid = \"a\"\nframes = 7\n"),
            "`aurora/flock.toml`, line 5: the key `clip` is missing from [[sheep]]"
        );
    }

    #[test]
    fn values_outside_their_limits_are_refused() {
        for (body, part) in [
            ("[[sheep]]\nid = 7\n", "key `id`: wanted a text in quotes, found `7`"),
            ("[[sheep]]\nid = \"a\"\nrepeat = 0\n", "found `0`"),
            ("[[sheep]]\nid = \"a\"\nclip = \"../a.mp4\"\nframes = 1\n", "found `../a.mp4`"),
            ("[[sheep]]\nid = \"a\"\nclip = \"a.mp4\"\nframes = 0\n", "key `frames`"),
            ("[[sheep]]\nid = \"a\"\nclip = \"a.mp4\"\nframes = 4294967296\n", "found `4294967296`"),
            ("[[sheep]]\nid = \"a\"\nwant = nan\n", "found `nan`"),
            ("[[sheep]]\nid = \"a\"\nwant = inf\n", "found `inf`"),
            ("[[sheep]]\nid = \"a\"\nhash = \"b3:00\"\n", "`frames` is missing"),
            ("[[sheep]]\nid = \"a\"\n[[transition]]\nfrom = \"a\"\nto = \"a\"\nframes = 1\n", "`clip` is missing"),
            ("[[sheep]]\nid = \"a\"\nid = \"b\"\n", "key `id`: not TOML"),
            ("[[sheep]]\nid = \n", "key `id`: not TOML"),
            ("", "the key `sheep` is missing"),
            ("sheep = []", "the key `sheep` is missing"),
            ("sheep = 3", "wanted tables, each headed [[sheep]], found `3`"),
        ] {
            let said = said(body);
            assert!(said.contains(part), "{body:?} said {said:?}");
        }
    }

    #[test]
    fn sizes_are_even_and_rates_are_rates() {
        let with = |size: &str, fps: &str| {
            parse(&format!("format = 1\nname = \"x\"\nsize = {size}\nfps = {fps}\n[[sheep]]\nid = \"a\"\n"))
        };
        assert!(with("[1280, 720]", "[24000, 1001]").is_ok());
        for (size, fps) in [
            ("[1281, 720]", "[30, 1]"),
            ("[0, 720]", "[30, 1]"),
            ("[1280, 99998]", "[30, 1]"),
            ("[1280]", "[30, 1]"),
            ("\"1280x720\"", "[30, 1]"),
            ("[1280, 720]", "[0, 1]"),
            ("[1280, 720]", "[30, 0]"),
            ("[1280, 720]", "[1000, 1]"),
            ("[1280, 720]", "30"),
        ] {
            assert!(with(size, fps).is_err(), "{size} {fps}");
        }
    }

    #[test]
    fn a_folder_without_a_manifest_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let error = Manifest::read(folder.path()).unwrap_err();
        assert!(error.to_string().ends_with("flock.toml`"), "{error}");
        assert!(error.hint().is_some());
    }

    /// Tables that are fine as they stand, their lines in any order.
    fn table() -> impl Strategy<Value = Vec<&'static str>> {
        let sheep = vec!["id = \"a\"", "frames = 7", "clip = \"a.mp4\"", "want = 2.5e-1", "repeat = 3 # thrice"];
        let way = vec!["from = \"a\"", "to = \"b\"", "frames = 7", "  clip\t= \"a.mp4\"\t", "weight = 3", ""];
        let headed = |header, lines: Vec<&'static str>| {
            Just(lines).prop_shuffle().prop_map(move |lines| [vec![header], lines].concat())
        };
        prop_oneof![headed("[[sheep]]", sheep), headed("[[transition]] # on", way)]
    }

    /// Lines that are not plain, or wrong, or wrong where they stand.
    const ODD: &[&str] = &[
        "id = \"b\"",
        "clip = \"b.mp4\"",
        "want = 1",
        "frames = 9",
        "repeat = 2",
        "weight = 1",
        "hash = \"b3:00\"",
        "# a comment",
        "# a bell \u{7}",
        "#\u{7f}",
        "want = 1_000",
        "want = +1.0",
        "want = 0x10",
        "want = 01",
        "want = 1.",
        "want = .5",
        "want = 1e400",
        "want = 5e-324",
        "want = nan",
        "want = 1.0 x",
        "want = 1\r",
        "want = 1.0e",
        "want = \"1\"",
        "id = 'a'",
        "id = \"\\u0061\"",
        "id = \"\"\"a\"\"\"",
        "id = \"\"",
        "id = \"a",
        "\"id\" = \"a\"",
        "a.b = 1",
        "id",
        "= 7",
        "[sheep]",
        "[ [sheep]]",
        "[[ sheep ]]",
        "[[sheep.kid]]",
        "[[other]]",
        "[[sheep]] x\nid = \"c\"",
        "[[sheep]",
        "x = 7 = 7",
        "\u{feff}",
        "name = \"x\"",
        "format = 1",
        "genome = \"ä\"",
        "genome = \"a\tb\"",
        "\u{a0}want = 1",
        "want = 1,",
        "want = 1]",
    ];

    proptest! {
        #![proptest_config(ProptestConfig { cases: 4000, ..ProptestConfig::default() })]

        #[test]
        fn what_is_read_in_place_is_what_the_parser_reads(
            tables in prop::collection::vec(table(), 0..4),
            odd in prop::collection::vec((prop::sample::select(ODD), any::<prop::sample::Index>()), 0..3),
            end in prop_oneof![Just("\n"), Just("\r\n"), Just("")],
        ) {
            let mut lines: Vec<&str> = HEAD.lines().chain(["[[sheep]]", "id = \"b\""]).chain(tables.concat()).collect();
            for (line, at) in odd {
                lines.insert(at.index(lines.len() + 1), line);
            }
            let text = lines.join("\n") + end;
            let source = Source { path: Path::new("flock.toml"), text: &text };
            if let Some(manifest) = plain(source) {
                prop_assert_eq!(Some(manifest), parsed(source).ok(), "{}", text);
            }
        }
    }

    #[test]
    fn a_manifest_of_the_contract_is_read_in_place() {
        let body = "# all\n[[sheep]]\nid = \"a\"\nframes = 768\nclip = \"loops/a.mp4\"\nwant = 1.5 # more\n\n\
                    [[transition]]\n  from = \"a\"\n  to = \"a\"\n  frames = 3\n  clip = \"t/a.mp4\"";
        for text in [format!("{HEAD}{body}"), format!("{HEAD}{body}\n")] {
            let source = Source { path: Path::new("flock.toml"), text: &text };
            let manifest = plain(source).expect("it is plain");
            assert_eq!((manifest.sheep.len(), manifest.transitions.len()), (1, 1));
            assert_eq!(manifest, parsed(source).unwrap());
        }
    }
}
