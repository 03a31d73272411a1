//! A flock that is edited, killed, and edited by others.

mod edits;
mod kill;
mod undo;

use std::collections::BTreeMap;
use std::fs::{self, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};

use flock::{Clip, ClipPath, Draft, Edit, FILE_NAME, Manifest, Sheep, SheepId};
use proptest::prelude::*;
use tempfile::TempDir;

use super::disk::Disk;
use super::requests::NewWeight;
use super::{ApplyError, Document, EditRequest, JOURNAL, MarkKind, NoteRequest, OWN_FOLDER, Surroundings};

/// Three sheep in a ring, with a comment that no edit may touch.
const RING: &str = r#"format = 1
name = "ring"   # by hand
size = [64, 64]
fps = [20, 1]

[[sheep]]
id = "a"
frames = 20
clip = "loops/a.mp4"

[[sheep]] # the second
id = "b"
frames = 20
clip = "loops/b.mp4"
want = 2.0

[[sheep]]
id = "c"
frames = 20
clip = "loops/c.mp4"

[[transition]]
from = "a"
to = "b"
frames = 10
clip = "transitions/a=b.mp4"

[[transition]]
from = "b"
to = "c"
frames = 10
clip = "transitions/b=c.mp4"

[[transition]]
from = "c"
to = "a"
frames = 10
clip = "transitions/c=a.mp4"
"#;

/// Credits with a line for each sheep.
const CREDITS: &str = "a\nb\nc\n";

/// Candidates are what is asked for; credits have one line for each sheep. The marks are those of the pool, which may be shut.
#[derive(Clone, Default)]
struct Fields {
    pool: Arc<Mutex<BTreeMap<SheepId, MarkKind>>>,
    is_shut: Arc<AtomicBool>,
}

impl Surroundings for Fields {
    fn candidate(&self, id: &SheepId, _: &Manifest) -> Result<Sheep, String> {
        let path = ClipPath::new(&format!("loops/{id}.mp4")).unwrap();
        let clip = Clip { path, frames: timing::FrameCount(20), hash: None };
        Ok(Sheep { id: id.clone(), clip: Some(clip), genome: None, want: 1.0, repeat: 1 })
    }

    fn place(&self, _: &Sheep) -> Result<(), String> {
        Ok(())
    }

    fn clip(&self, clip: Clip, _: &Manifest) -> Result<Clip, String> {
        Ok(clip)
    }

    fn credits(&self, text: &str, edits: &[EditRequest], _: &Manifest, after: &Manifest) -> Result<String, String> {
        let mut text = text.to_owned();
        for edit in edits {
            if let EditRequest::Rename { sheep, to } = edit {
                text = text
                    .lines()
                    .map(|line| if line == sheep.as_str() { format!("{to}\n") } else { format!("{line}\n") })
                    .collect();
            }
        }
        let has = |line: &&str| after.sheep.iter().any(|sheep| sheep.id.as_str() == *line);
        Ok(text.lines().filter(has).flat_map(|line| [line, "\n"]).collect())
    }

    fn mark(&self, id: &SheepId) -> Option<MarkKind> {
        self.pool.lock().unwrap().get(id).copied()
    }

    fn set_marks(&self, marks: &[(SheepId, MarkKind)]) -> Result<(), String> {
        if self.is_shut.load(Ordering::SeqCst) {
            return Err("it is in use".to_owned());
        }
        self.pool.lock().unwrap().extend(marks.iter().cloned());
        Ok(())
    }
}

/// A disk that is not waited for, and that ends the program at a write: what is left after it is 0.
#[derive(Clone)]
struct Killer {
    path: PathBuf,
    left: Arc<AtomicUsize>,
    /// Whether the fatal write is made in full, or of a journal in part.
    is_made: bool,
}

impl Killer {
    fn new(folder: &Path, left: usize, is_made: bool) -> Self {
        Self { path: folder.join(OWN_FOLDER).join(JOURNAL), left: Arc::new(AtomicUsize::new(left)), is_made }
    }

    fn write(&self, write: impl FnOnce(bool) -> io::Result<()>) -> io::Result<()> {
        let left = self.left.fetch_update(Ordering::SeqCst, Ordering::SeqCst, |left| Some(left.saturating_sub(1)));
        match left.unwrap() {
            0 => Err(io::Error::other("killed before")),
            1 => write(true).and_then(|()| Err(io::Error::other("killed"))),
            _ => write(false),
        }
    }
}

impl Disk for Killer {
    fn append(&self, bytes: &[u8]) -> io::Result<()> {
        self.write(|is_fatal| {
            let part = if is_fatal && !self.is_made { &bytes[..bytes.len() / 2] } else { bytes };
            OpenOptions::new().append(true).open(&self.path)?.write_all(part)
        })
    }

    fn replace(&self, bytes: &[u8]) -> io::Result<()> {
        self.save(&self.path, std::str::from_utf8(bytes).unwrap_or_default())
            .and_then(|()| fs::write(&self.path, bytes))
    }

    fn save(&self, path: &Path, text: &str) -> io::Result<()> {
        self.write(|is_fatal| {
            if is_fatal && !self.is_made {
                return Ok(());
            }
            let new = path.with_extension("new");
            fs::write(&new, text)?;
            fs::rename(&new, path)
        })
    }
}

fn id(text: &str) -> SheepId {
    SheepId::new(text).unwrap()
}

fn ring() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join(FILE_NAME), RING).unwrap();
    fs::write(folder.path().join("credits.toml"), CREDITS).unwrap();
    fs::create_dir(folder.path().join("loops")).unwrap();
    for name in ["a", "b", "c"] {
        fs::write(folder.path().join(format!("loops/{name}.mp4")), name).unwrap();
    }
    folder
}

fn open(folder: &Path) -> Document {
    open_until(folder, usize::MAX, true).unwrap()
}

fn open_until(folder: &Path, left: usize, is_made: bool) -> Result<Document, super::DocumentError> {
    Document::open_on(folder, Box::new(Fields::default()), Box::new(Killer::new(folder, left, is_made)))
}

fn text(folder: &Path) -> String {
    fs::read_to_string(folder.join(FILE_NAME)).unwrap()
}

fn credits(folder: &Path) -> String {
    fs::read_to_string(folder.join("credits.toml")).unwrap()
}

/// Applies edits that were meant for the text as it is.
fn apply(document: &mut Document, edits: &[EditRequest]) -> Result<super::Applied, ApplyError> {
    let base = document.revision().clone();
    document.apply(edits, &base, None, true)
}

fn want(sheep: &str, value: f64) -> EditRequest {
    EditRequest::Want { sheep: id(sheep), value }
}

fn link(from: &str, to: &str) -> EditRequest {
    EditRequest::Link { from: id(from), to: id(to), frames: None }
}

fn unlink(from: &str, to: &str) -> EditRequest {
    EditRequest::Unlink { from: id(from), to: id(to) }
}

fn keep(sheep: &str) -> NoteRequest {
    NoteRequest::Mark { sheep: id(sheep), mark: Some(MarkKind::Kept), rating: None }
}

/// What somebody else's command does: the same edit, under the same lock.
fn command(folder: &Path, edit: impl FnOnce(&mut Edit)) {
    let mut draft = Draft::lock(folder).unwrap();
    edit(&mut draft.edit);
    draft.save().unwrap();
}

fn any_sheep() -> impl Strategy<Value = SheepId> {
    "[a-e]".prop_map(|text| id(&text))
}

/// An edit that may make sense, or may be refused.
fn any_edit() -> impl Strategy<Value = EditRequest> {
    let number = || (1u32..40).prop_map(|tenths| f64::from(tenths) / 10.0);
    let weight = || (any_sheep(), any_sheep(), number()).prop_map(|(from, to, value)| NewWeight { from, to, value });
    prop_oneof![
        4 => (any_sheep(), number()).prop_map(|(sheep, value)| EditRequest::Want { sheep, value }),
        4 => weight().prop_map(EditRequest::Weight),
        1 => prop::collection::vec(weight(), 1..3).prop_map(|values| EditRequest::Weights { values }),
        2 => (any_sheep(), 1u32..5).prop_map(|(sheep, value)| EditRequest::Repeat { sheep, value }),
        4 => (any_sheep(), any_sheep()).prop_map(|(from, to)| EditRequest::Link { from, to, frames: Some(12) }),
        2 => (any_sheep(), any_sheep()).prop_map(|(from, to)| EditRequest::Unlink { from, to }),
        1 => any_sheep().prop_map(|sheep| EditRequest::Drop { sheep }),
        1 => any_sheep().prop_map(|sheep| EditRequest::Prune { drop: vec![sheep] }),
        2 => (any_sheep(), any_sheep()).prop_map(|(sheep, to)| EditRequest::Rename { sheep, to }),
        3 => any_sheep().prop_map(|sheep| EditRequest::Add { candidates: vec![sheep] }),
    ]
}

fn any_note() -> impl Strategy<Value = NoteRequest> {
    let mark = prop_oneof![Just(MarkKind::Kept), Just(MarkKind::Rejected), Just(MarkKind::None)];
    prop_oneof![
        (any_sheep(), prop::option::of(mark), prop::option::of(0u8..=5))
            .prop_map(|(sheep, mark, rating)| NoteRequest::Mark { sheep, mark, rating }),
        (any_sheep(), prop::option::of([-9.0..9.0f64, -9.0..9.0]))
            .prop_map(|(sheep, at)| NoteRequest::Pin { sheep, at }),
        (any_sheep(), any_sheep(), any::<bool>()).prop_map(|(from, to, bad)| NoteRequest::Join { from, to, bad }),
    ]
}
