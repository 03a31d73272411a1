//! A studio that is killed, at any write.

use std::fs;
use std::io::{self, BufRead, BufReader};
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::{Arc, Mutex};

use flock::FILE_NAME;

use super::super::disk::Disk;
use super::super::{Document, EditRequest, JournalFile, Notes, UndoError};
use super::{CREDITS, Fields, Killer, RING, credits, id, keep, link, open, open_until, ring, text, unlink, want};

/// Where the studio that is to be killed works.
const FOLDER: &str = "STUDIO_TEST_FOLDER";

/// What must be as before or as after: manifest, credits and notes.
type Whole = (String, String, Arc<Notes>);

fn whole(folder: &Path, document: &Document) -> Whole {
    (text(folder), credits(folder), document.snapshot().notes)
}

/// One of everything that writes.
fn act(document: &mut Document, at: usize) -> Result<(), Box<dyn std::error::Error>> {
    let base = document.revision().clone();
    let mut edit = |edits: &[EditRequest], gesture| {
        document.apply(edits, &base, gesture, true).map(drop).map_err(Box::<dyn std::error::Error>::from)
    };
    match at {
        0 => edit(&[want("a", 3.0)], Some("g")),
        1 => edit(&[want("a", 4.0)], Some("g")),
        2 => Ok(document.note(&[keep("b")], None).map(drop)?),
        3 => edit(&[EditRequest::Rename { sheep: id("b"), to: id("ram") }], None),
        4 => edit(&[link("a", "c"), unlink("a", "ram")], None),
        5 | 6 | 9 => Ok(document.undo().map(drop)?),
        7 => Ok(document.redo().map(drop)?),
        8 => edit(&[EditRequest::Drop { sheep: id("c") }], None),
        _ => edit(&[EditRequest::Add { candidates: vec![id("d")] }], None),
    }
}

const ACTS: usize = 11;

#[test]
fn a_kill_at_any_write_leaves_the_state_before_or_after_and_all_can_be_undone() {
    let folder = ring();
    let mut document = open(folder.path());
    let mut states = vec![whole(folder.path(), &document)];
    for at in 0..ACTS {
        act(&mut document, at).unwrap();
        states.push(whole(folder.path(), &document));
    }
    let mut kills = 0;
    for (writes, is_made) in (1..).flat_map(|writes| [(writes, false), (writes, true)]) {
        let folder = ring();
        let Ok(mut document) = open_until(folder.path(), writes, is_made) else { continue };
        let Some(at) = (0..ACTS).find(|at| act(&mut document, *at).is_err()) else { break };
        drop(document);
        let mut document = open(folder.path());
        let found = whole(folder.path(), &document);
        assert!(found == states[at] || found == states[at + 1], "write {writes}, act {at}: {found:?}");
        while document.undo().is_ok() {}
        assert!(matches!(document.undo(), Err(UndoError::Nothing { .. })), "write {writes}, act {at}");
        let first = (RING.to_owned(), CREDITS.to_owned(), Arc::new(Notes::default()));
        assert_eq!(whole(folder.path(), &document), first, "write {writes}, act {at}");
        kills += 1;
    }
    assert!(kills > 40, "only {kills} kills");
}

#[test]
fn a_disk_that_fails_once_loses_nothing_and_the_next_edit_is_made() {
    for writes in 2..8 {
        for is_made in [false, true] {
            let folder = ring();
            let killer = super::Killer::new(folder.path(), writes, is_made);
            let left = Arc::clone(&killer.left);
            let mut document = Document::open_on(folder.path(), Box::new(Fields::default()), Box::new(killer)).unwrap();
            let failed = (0..3).find(|at| act(&mut document, *at).is_err());
            left.store(usize::MAX, std::sync::atomic::Ordering::SeqCst);
            // The program goes on: what failed is tried again.
            for at in failed.unwrap_or(3)..5 {
                act(&mut document, at).unwrap();
            }
            drop(document);
            let mut document = open(folder.path());
            while document.undo().is_ok() {}
            assert_eq!(
                (text(folder.path()), credits(folder.path())),
                (RING.to_owned(), CREDITS.to_owned()),
                "{writes}"
            );
        }
    }
}

/// A disk that keeps what the list of the folder named at the last write of a file that the artist keeps.
struct Reader(Killer, Arc<Mutex<String>>);

impl Disk for Reader {
    fn append(&self, bytes: &[u8]) -> io::Result<()> {
        self.0.append(bytes)
    }

    fn replace(&self, bytes: &[u8]) -> io::Result<()> {
        self.0.replace(bytes)
    }

    fn save(&self, path: &Path, text: &str) -> io::Result<()> {
        *self.1.lock().unwrap() = fs::read_to_string(path.with_file_name(".flock-edit")).unwrap_or_default();
        self.0.save(path, text)
    }
}

#[test]
fn what_an_edit_is_about_to_write_is_listed_for_the_next_editor_until_it_is_written() {
    let folder = ring();
    let listed = Arc::new(Mutex::new(String::new()));
    let disk = Reader(Killer::new(folder.path(), usize::MAX, true), Arc::clone(&listed));
    let mut document = Document::open_on(folder.path(), Box::new(Fields::default()), Box::new(disk)).unwrap();
    let rename = EditRequest::Rename { sheep: id("b"), to: id("ram") };
    super::apply(&mut document, &[rename]).unwrap();
    let files = "loops/ram.mp4\ntransitions/a=ram.mp4\ntransitions/ram=c.mp4\ncredits.toml\n";
    let mut lines: Vec<_> = listed.lock().unwrap().lines().map(str::to_owned).collect();
    lines.sort();
    let mut wanted: Vec<_> = files.lines().map(str::to_owned).collect();
    wanted.sort();
    assert_eq!(lines, wanted);
    document.undo().unwrap();
    assert_eq!(*listed.lock().unwrap(), "credits.toml\n");
    assert!(!folder.path().join(".flock-edit").exists());
}

/// Run by the test below as a program of its own; alone it does nothing.
#[test]
fn a_studio_for_the_next_test_edits_until_it_is_killed() {
    let Some(folder) = std::env::var_os(FOLDER) else { return };
    let folder = Path::new(&folder);
    let journal = JournalFile(folder.join(".studio/journal"));
    let mut document = Document::open_on(folder, Box::new(Fields::default()), Box::new(journal)).unwrap();
    println!();
    for at in 0.. {
        let base = document.revision().clone();
        document.apply(&[want("a", 2.0 + f64::from(at % 7))], &base, None, false).unwrap();
        document.note(&[keep("a")], None).unwrap();
        println!("edited");
    }
}

#[test]
fn a_studio_that_is_killed_with_sigkill_can_undo_all_that_it_did() {
    const KILLS: usize = 12;
    let folder = ring();
    let name = "document::tests::kill::a_studio_for_the_next_test_edits_until_it_is_killed";
    for kill in 0..KILLS {
        let mut studio = Command::new(std::env::current_exe().unwrap());
        studio.args(["--exact", name, "--nocapture", "--test-threads=1"]).env(FOLDER, folder.path());
        let mut studio = studio.stdout(Stdio::piped()).stderr(Stdio::null()).spawn().unwrap();
        let lines = BufReader::new(studio.stdout.take().unwrap()).lines().map_while(Result::ok);
        let edits = lines.filter(|line| line == "edited").take(1 + kill).count();
        // The next edit has begun.
        studio.kill().unwrap();
        studio.wait().unwrap();
        assert_eq!(edits, 1 + kill, "it ended by itself");
    }
    let mut document = open(folder.path());
    assert_eq!(fs::read_to_string(folder.path().join(FILE_NAME)).unwrap(), document.now.text.to_string());
    let steps = std::iter::from_fn(|| document.undo().ok()).count();
    assert!(steps > KILLS, "only {steps}");
    assert!(matches!(document.undo(), Err(UndoError::Nothing { .. })));
    assert_eq!(text(folder.path()), RING);
}
