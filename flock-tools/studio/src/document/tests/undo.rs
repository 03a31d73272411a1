//! What was done is taken back, over restarts, and never what somebody else did.

use std::fs;
use std::sync::atomic::Ordering;

use flock::{Clip, ClipHash, FILE_NAME};
use proptest::prelude::*;
use proptest::test_runner::Config;

use super::super::history::MOST_STEPS;
use super::super::{Document, EditRequest, Mark, MarkKind, NoteRequest, Notes, UndoError};
use super::{Fields, RING, any_edit, any_note, apply, command, credits, id, keep, link, open, ring, text, want};

/// Takes back all that can be; returns how many steps it was.
fn undo_all(document: &mut Document) -> usize {
    let mut steps = 0;
    loop {
        match document.undo() {
            Ok(_) => steps += 1,
            Err(UndoError::Nothing { .. }) => return steps,
            Err(error) => panic!("{error}"),
        }
    }
}

/// What a test does with a document.
#[derive(Clone, Debug)]
enum Act {
    Edit(EditRequest, Option<u8>),
    Note(NoteRequest),
    Redo,
    Reopen,
    Undo,
}

fn any_act() -> impl Strategy<Value = Act> {
    prop_oneof![
        10 => (any_edit(), prop::option::of(0u8..2)).prop_map(|(edit, gesture)| Act::Edit(edit, gesture)),
        4 => any_note().prop_map(Act::Note),
        2 => Just(Act::Undo),
        1 => Just(Act::Redo),
        1 => Just(Act::Reopen),
    ]
}

proptest! {
    #![proptest_config(Config { cases: 12, failure_persistence: None, ..Config::default() })]

    /// And done again they give the last bytes.
    #[test]
    fn two_hundred_random_edits_undone_give_the_first_bytes(acts in prop::collection::vec(any_act(), 200)) {
        let folder = ring();
        let mut document = open(folder.path());
        for act in acts {
            match act {
                Act::Edit(edit, gesture) => {
                    let (base, gesture) = (document.revision().clone(), gesture.map(|number| format!("g{number}")));
                    // Most are refused: there are few sheep.
                    let _ = document.apply(&[edit], &base, gesture.as_deref(), true);
                }
                Act::Note(note) => drop(document.note(&[note], None).unwrap()),
                Act::Redo => drop(document.redo()),
                Act::Undo => drop(document.undo()),
                Act::Reopen => {
                    drop(document);
                    document = open(folder.path());
                }
            }
            prop_assert_eq!(text(folder.path()), document.now.text.to_string());
        }
        while document.redo().is_ok() {}
        let (last, notes, of_sheep) = (text(folder.path()), document.snapshot().notes, credits(folder.path()));
        drop(document);
        let mut document = open(folder.path());
        let steps = undo_all(&mut document);
        prop_assert_eq!(text(folder.path()), RING);
        prop_assert_eq!(credits(folder.path()), super::CREDITS);
        prop_assert_eq!(&*document.snapshot().notes, &Notes::default());
        let again = std::iter::from_fn(|| document.redo().ok()).count();
        prop_assert_eq!(again, steps);
        prop_assert_eq!((text(folder.path()), credits(folder.path())), (last, of_sheep));
        prop_assert_eq!(document.snapshot().notes, notes);
    }
}

#[test]
fn what_will_be_undone_is_said_before_and_after() {
    let folder = ring();
    let mut document = open(folder.path());
    assert_eq!((document.snapshot().undo, document.snapshot().redo), (None, None));
    assert!(matches!(document.undo(), Err(UndoError::Nothing { what: "undo" })));
    assert_eq!(apply(&mut document, &[link("a", "c")]).unwrap().said, "linked a to c");
    assert_eq!(document.note(&[keep("b")], None).unwrap(), "kept b");
    assert_eq!(document.snapshot().undo.as_deref(), Some("kept b"));
    document.undo().unwrap();
    assert_eq!(document.snapshot().undo.as_deref(), Some("linked a to c"));
    assert_eq!(document.undo().unwrap().said, "linked a to c");
    assert_eq!(document.snapshot().redo.as_deref(), Some("linked a to c"));
    assert_eq!(document.redo().unwrap().said, "linked a to c");
    apply(&mut document, &[want("a", 3.0)]).unwrap();
    assert!(matches!(document.redo(), Err(UndoError::Nothing { what: "redo" })), "a new edit ends what was undone");
}

#[test]
fn a_gesture_is_undone_at_once_and_one_that_comes_back_to_its_start_is_no_step() {
    let folder = ring();
    let mut document = open(folder.path());
    let slide = |document: &mut Document, gesture: &str, values: &[f64]| {
        for value in values {
            let base = document.revision().clone();
            document.apply(&[want("b", *value)], &base, Some(gesture), false).unwrap();
        }
    };
    slide(&mut document, "g1", &[2.5, 3.0, 4.0]);
    let after = text(folder.path());
    slide(&mut document, "g2", &[5.0, 6.0, 4.0]);
    assert_eq!(text(folder.path()), after);
    drop(document);
    let mut document = open(folder.path());
    assert_eq!(undo_all(&mut document), 1);
    assert_eq!(text(folder.path()), RING);
}

#[test]
fn what_somebody_else_changed_is_never_undone_and_what_came_after_is() {
    let folder = ring();
    let mut document = open(folder.path());
    apply(&mut document, &[want("a", 3.0)]).unwrap();
    let by_hand = text(folder.path()).replace("# by hand", "# by her");
    fs::write(folder.path().join(FILE_NAME), &by_hand).unwrap();
    assert!(matches!(document.undo(), Err(UndoError::Changed { file: FILE_NAME })));
    assert_eq!((document.snapshot().undo, text(folder.path())), (None, by_hand.clone()));
    apply(&mut document, &[want("b", 7.0)]).unwrap();
    document.note(&[keep("a")], None).unwrap();
    drop(document);
    let mut document = open(folder.path());
    document.undo().unwrap();
    document.undo().unwrap();
    assert_eq!(text(folder.path()), by_hand);
    assert!(matches!(document.undo(), Err(UndoError::Changed { .. })));
    apply(&mut document, &[want("c", 7.0)]).unwrap();
    document.undo().unwrap();
    assert!(matches!(document.undo(), Err(UndoError::Changed { .. })), "also after another edit");
    assert_eq!(text(folder.path()), by_hand);
}

#[test]
fn hashes_that_a_render_writes_are_nobodys_edit_and_outlive_an_undo() {
    let folder = ring();
    let mut document = open(folder.path());
    apply(&mut document, &[want("a", 3.0)]).unwrap();
    apply(&mut document, &[EditRequest::Drop { sheep: id("b") }]).unwrap();
    let hashed = |manifest: &flock::Manifest, at: usize| {
        let clip = manifest.sheep[at].clip.clone().unwrap();
        Clip { hash: Some(ClipHash::new([at as u8; 32])), ..clip }
    };
    command(folder.path(), |edit| {
        let manifest = edit.shared_manifest();
        edit.set_loop(&id("a"), hashed(&manifest, 0)).unwrap();
        edit.set_loop(&id("c"), hashed(&manifest, 1)).unwrap();
    });
    document.poll().unwrap();
    assert_eq!(document.snapshot().undo.as_deref(), Some("dropped b"));
    apply(&mut document, &[want("c", 2.0)]).unwrap();
    assert_eq!(undo_all(&mut document), 3);
    let manifest = document.snapshot().manifest;
    assert!(
        manifest.sheep[0].clip.as_ref().unwrap().hash.is_some() && manifest.sheep[0].want.to_bits() == 1f64.to_bits()
    );
    assert_eq!(
        text(folder.path()).lines().filter(|line| !line.contains("b3:")).collect::<Vec<_>>(),
        RING.lines().collect::<Vec<_>>()
    );
}

#[test]
fn credits_that_somebody_else_changed_stop_an_undo_that_would_write_them() {
    let folder = ring();
    let mut document = open(folder.path());
    apply(&mut document, &[link("a", "c"), EditRequest::Drop { sheep: id("b") }]).unwrap();
    assert_eq!(credits(folder.path()), "a\nc\n");
    let after = text(folder.path());
    fs::write(folder.path().join("credits.toml"), "a\nc\nd\n").unwrap();
    assert!(matches!(document.undo(), Err(UndoError::Changed { file: "credits.toml" })));
    assert_eq!(text(folder.path()), after);
}

#[test]
fn notes_come_back_after_a_restart_and_malformed_ones_are_refused() {
    let folder = ring();
    let mut document = open(folder.path());
    document.note(&[keep("a"), keep("pool.7")], None).unwrap();
    document.note(&[NoteRequest::Mark { sheep: id("a"), mark: None, rating: Some(4) }], None).unwrap();
    document.note(&[NoteRequest::Pin { sheep: id("b"), at: Some([1.0, -2.5]) }], None).unwrap();
    document.note(&[NoteRequest::Join { from: id("a"), to: id("b"), bad: true }], None).unwrap();
    assert!(document.note(&[NoteRequest::Mark { sheep: id("a"), mark: None, rating: Some(6) }], None).is_err());
    assert!(document.note(&[NoteRequest::Pin { sheep: id("a"), at: Some([f64::NAN, 0.0]) }], None).is_err());
    drop(document);
    let notes = open(folder.path()).snapshot().notes;
    assert_eq!(notes.marks[&id("a")], Mark { kind: MarkKind::Kept, rating: 4 });
    assert_eq!(notes.marks[&id("pool.7")], Mark { kind: MarkKind::Kept, rating: 0 });
    assert_eq!((notes.pins[&id("b")], notes.bad_joins.len()), ([1.0, -2.5], 1));
}

#[test]
fn the_oldest_steps_are_forgotten_and_no_note_with_them() {
    let folder = ring();
    let mut document = open(folder.path());
    document.note(&[keep("a")], None).unwrap();
    for at in 0..MOST_STEPS {
        apply(&mut document, &[want("b", 3.0 + at as f64)]).unwrap();
    }
    drop(document);
    let mut document = open(folder.path());
    assert_eq!(undo_all(&mut document), MOST_STEPS);
    assert_eq!(text(folder.path()), RING);
    assert!(document.snapshot().notes.marks.contains_key(&id("a")));
}

#[test]
fn a_journal_that_cannot_be_read_is_put_aside_and_the_flock_is_open_all_the_same() {
    let folder = ring();
    let journal = folder.path().join(".studio/journal");
    drop(open(folder.path()));
    fs::write(&journal, "another program's").unwrap();
    let document = open(folder.path());
    assert_eq!(document.snapshot().undo, None);
    assert_eq!(fs::read_to_string(journal.with_extension("unreadable")).unwrap(), "another program's");
}

#[test]
fn a_mark_of_a_sheep_of_the_pool_is_the_pools_and_none_that_another_program_made_is_taken_back() {
    let (folder, fields) = (ring(), Fields::default());
    let in_pool = |sheep: &str| fields.pool.lock().unwrap()[&id(sheep)];
    fields.pool.lock().unwrap().extend([(id("p"), MarkKind::None), (id("q"), MarkKind::Kept)]);
    let mut document = Document::open(folder.path(), Box::new(fields.clone())).unwrap();
    let mark = |sheep: &str, kind| NoteRequest::Mark { sheep: id(sheep), mark: Some(kind), rating: None };
    document
        .note(&[mark("p", MarkKind::Rejected), mark("q", MarkKind::Rejected), mark("a", MarkKind::Kept)], None)
        .unwrap();
    assert_eq!([in_pool("p"), in_pool("q")], [MarkKind::Rejected; 2]);
    assert!(!fields.pool.lock().unwrap().contains_key(&id("a")), "it is in no pool");
    document.undo().unwrap();
    assert_eq!([in_pool("p"), in_pool("q")], [MarkKind::None, MarkKind::Kept], "the pool's own marks come back");
    document.redo().unwrap();
    fields.pool.lock().unwrap().insert(id("p"), MarkKind::Kept);
    document.undo().unwrap();
    assert_eq!([in_pool("p"), in_pool("q")], [MarkKind::Kept; 2]);
    // A mark is changed from what the pool says, not from what was noted here.
    document.note(&[mark("p", MarkKind::None)], None).unwrap();
    document.undo().unwrap();
    assert_eq!(in_pool("p"), MarkKind::Kept);
    fields.is_shut.store(true, Ordering::SeqCst);
    let before = document.snapshot();
    assert!(document.note(&[mark("p", MarkKind::Rejected)], None).unwrap_err().to_string().contains("it is in use"));
    assert_eq!((document.snapshot().undo, document.snapshot().notes), (before.undo, before.notes));
}
