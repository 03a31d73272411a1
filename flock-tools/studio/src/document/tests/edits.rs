//! Edits of the studio and of commands, at once.

use std::fs;
use std::thread;

use flock::{Edit, FILE_NAME, Manifest, SheepId};
use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::{Config, TestRunner};

use super::super::perform::perform;
use super::super::requests::NewWeight;
use super::super::{ApplyError, Change, DocumentError, EditRequest, Revision, Surroundings};
use super::{Fields, RING, any_edit, apply, command, credits, id, link, open, ring, text, unlink, want};

#[test]
fn an_edit_made_meanwhile_by_a_command_is_kept() {
    let folder = ring();
    let mut document = open(folder.path());
    let base = document.revision().clone();
    command(folder.path(), |edit| edit.set_want(&id("a"), 3.0).unwrap());
    let applied = document.apply(&[want("b", 5.0)], &base, None, false).unwrap();
    assert!(applied.merged && applied.revision == Revision::of(&text(folder.path())));
    let manifest = document.snapshot().manifest;
    assert_eq!((manifest.sheep[0].want, manifest.sheep[1].want), (3.0, 5.0));
    let ours = document.apply(&[want("c", 2.0)], &applied.revision, None, false).unwrap();
    assert!(!ours.merged);
    let late = document.apply(&[want("c", 4.0)], &applied.revision, None, false).unwrap();
    assert!(!late.merged, "our own edit since is not somebody else's");
}

#[test]
fn an_edit_that_no_longer_fits_is_a_conflict_and_one_that_never_did_is_refused() {
    let folder = ring();
    let mut document = open(folder.path());
    let base = document.revision().clone();
    command(folder.path(), |edit| edit.drop_transition(&id("a"), &id("b")).unwrap());
    let weight = EditRequest::Weight(NewWeight { from: id("a"), to: id("b"), value: 2.0 });
    let before = text(folder.path());
    match document.apply(&[want("a", 9.0), weight.clone()], &base, None, false) {
        Err(ApplyError::Conflict { error }) => assert!(error.contains("no transition from `a` to `b`"), "{error}"),
        other => panic!("{other:?}"),
    }
    let now = document.revision().clone();
    assert!(matches!(document.apply(&[weight], &now, None, false), Err(ApplyError::Refused { .. })));
    for (edit, said) in [(want("a", -1.0), "above 0"), (link("a", "x"), "`x`"), (link("b", "c"), "already")] {
        match document.apply(&[edit], &now, None, true) {
            Err(ApplyError::Refused { error }) => assert!(error.contains(said), "{error}"),
            other => panic!("{other:?}"),
        }
    }
    assert_eq!(text(folder.path()), before);
}

#[test]
fn sheep_go_off_the_wall_only_if_it_is_asked_for() {
    let folder = ring();
    let mut document = open(folder.path());
    let base = document.revision().clone();
    apply(&mut document, &[link("b", "a")]).unwrap();
    match document.apply(&[unlink("b", "c")], &base, None, false) {
        Err(ApplyError::Unshown { no_longer_shown }) => assert_eq!(no_longer_shown, [id("c")]),
        other => panic!("{other:?}"),
    }
    let applied = document.apply(&[unlink("b", "c")], &base, None, true).unwrap();
    assert_eq!(applied.no_longer_shown, [id("c")]);
    let all = ["a", "b", "c"].map(|sheep| EditRequest::Drop { sheep: id(sheep) });
    assert!(matches!(document.apply(&all, &applied.revision, None, false), Err(ApplyError::Empty)));
}

#[test]
fn pruning_leaves_the_bytes_of_the_command_keeps_who_came_in_meanwhile_and_is_undone() {
    let loose = "\n[[sheep]]\nid = \"d\"\n\n[[transition]]\nfrom = \"d\"\nto = \"a\"\nframes = 10\nclip = \"x.mp4\"\n";
    let [folder, alone] = [ring(), ring()];
    for folder in [&folder, &alone] {
        fs::write(folder.path().join(FILE_NAME), [RING, loose].concat()).unwrap();
    }
    let mut document = open(folder.path());
    let prune = EditRequest::Prune { drop: vec![id("d")] };
    let applied = apply(&mut document, std::slice::from_ref(&prune)).unwrap();
    command(alone.path(), |edit| edit.keep_only(&["a", "b", "c"].map(id).into()));
    assert_eq!((text(folder.path()), &*applied.said), (text(alone.path()), "pruned d"));
    document.undo().unwrap();
    assert_eq!(text(folder.path()), [RING, loose].concat());
    let base = document.revision().clone();
    command(folder.path(), |edit| edit.add_sheep(sheep("e")).unwrap());
    document.apply(&[prune], &base, None, false).unwrap();
    let left: Vec<String> = document.snapshot().manifest.sheep.iter().map(|sheep| sheep.id.to_string()).collect();
    assert_eq!(left, ["a", "b", "c", "e"]);
    let unknown = document.what_if(&[EditRequest::Prune { drop: vec![id("a"), id("d")] }]);
    assert!(matches!(unknown, Err(ApplyError::Refused { error }) if error.contains("`d`")));
}

#[test]
fn what_if_answers_and_writes_nothing() {
    let folder = ring();
    let document = open(folder.path());
    let manifest = document.what_if(&[want("a", 7.0), link("a", "c")]).unwrap();
    assert_eq!((manifest.sheep[0].want, manifest.transitions.len()), (7.0, 4));
    assert!(document.what_if(&[link("a", "b")]).is_err());
    assert_eq!(text(folder.path()), RING);
}

#[test]
fn a_rename_takes_notes_credits_and_files_along_and_deletes_none() {
    let folder = ring();
    let mut document = open(folder.path());
    document.note(&[super::keep("a")], None).unwrap();
    let rename = EditRequest::Rename { sheep: id("a"), to: id("ram") };
    let applied = apply(&mut document, std::slice::from_ref(&rename)).unwrap();
    assert_eq!(applied.said, "renamed a to ram");
    assert!(document.snapshot().notes.marks.contains_key(&id("ram")));
    assert_eq!(credits(folder.path()), "ram\nb\nc\n");
    assert_eq!(fs::read_to_string(folder.path().join("loops/ram.mp4")).unwrap(), "a");
    assert!(folder.path().join("loops/a.mp4").exists());
    document.undo().unwrap();
    assert!(document.snapshot().notes.marks.contains_key(&id("a")));
    assert_eq!((text(folder.path()), credits(folder.path())), (RING.to_owned(), super::CREDITS.to_owned()));
    document.redo().unwrap();
    document.undo().unwrap();
    fs::write(folder.path().join("loops/ram.mp4"), "another").unwrap();
    assert!(matches!(apply(&mut document, &[rename]), Err(ApplyError::Refused { .. })));
    assert_eq!(text(folder.path()), RING);
}

/// The claim on 1000 edits, half of them a command's, in one order.
#[test]
fn a_thousand_edits_of_studio_and_commands_leave_the_bytes_of_the_commands_alone() {
    let (mixed, alone) = (ring(), ring());
    // Names that come and go would meet each other's files, which are never replaced.
    fs::remove_dir_all(mixed.path().join("loops")).unwrap();
    let mut document = open(mixed.path());
    let mut runner = TestRunner::new(Config { failure_persistence: None, ..Config::default() });
    let mut made = 0;
    while made < 1000 {
        let (edit, by_command) = (any_edit(), any::<bool>()).new_tree(&mut runner).unwrap().current();
        let mut draft = Edit::parse(text(alone.path()), alone.path()).unwrap();
        let is_fine = perform(std::slice::from_ref(&edit), &mut draft, &Fields::default()).is_ok()
            && draft.text() != text(alone.path());
        if is_fine {
            fs::write(alone.path().join(FILE_NAME), draft.text()).unwrap();
            made += 1;
        }
        if by_command && is_fine {
            command(mixed.path(), |draft| drop(perform(std::slice::from_ref(&edit), draft, &Fields::default())));
        } else if !by_command {
            // The page knows the revision before the commands.
            let stale = document.revision().clone();
            assert!(document.apply(&[edit], &stale, None, true).is_ok() || !is_fine);
        }
        if is_fine {
            assert_eq!(text(mixed.path()), text(alone.path()));
        }
    }
    document.poll();
    assert_eq!(*document.revision(), Revision::of(&text(mixed.path())));
}

#[test]
fn edits_of_a_studio_and_of_commands_at_the_same_time_are_all_kept() {
    const EDITS: u32 = 60;
    let folder = ring();
    let mut document = open(folder.path());
    let path = folder.path().to_owned();
    let other = thread::spawn(move || {
        for value in 1..=EDITS {
            command(&path, |edit| edit.add_sheep(sheep(&format!("command.{value}"))).unwrap());
        }
    });
    for value in 1..=EDITS {
        let candidates = vec![id(&format!("studio.{value}"))];
        let stale = Revision::of(RING);
        document.apply(&[EditRequest::Add { candidates }], &stale, None, false).unwrap();
    }
    other.join().unwrap();
    document.poll();
    let manifest = document.snapshot().manifest;
    let count = |by: &str| manifest.sheep.iter().filter(|sheep| sheep.id.as_str().starts_with(by)).count();
    assert_eq!((count("command."), count("studio.")), (EDITS as usize, EDITS as usize));
}

/// A sheep as a command adds it.
fn sheep(name: &str) -> flock::Sheep {
    let id: SheepId = id(name);
    let manifest = Manifest::parse(RING, FILE_NAME.as_ref()).unwrap();
    Fields::default().candidate(&id, &manifest).unwrap()
}

#[test]
fn what_somebody_else_did_is_told_once_and_a_broken_manifest_is_not_taken() {
    let folder = ring();
    let mut document = open(folder.path());
    assert!(document.poll().is_none());
    apply(&mut document, &[want("a", 2.0)]).unwrap();
    assert!(document.poll().is_none(), "our own edits are no news");
    command(folder.path(), |edit| edit.set_want(&id("c"), 4.0).unwrap());
    assert!(matches!(document.poll(), Some(Change::Edited)));
    assert_eq!(*document.revision(), Revision::of(&text(folder.path())));
    assert!(document.poll().is_none());
    let good = text(folder.path());
    fs::write(folder.path().join(FILE_NAME), "format = ").unwrap();
    assert!(matches!(document.poll(), Some(Change::Unreadable { .. })));
    let base = document.revision().clone();
    assert!(matches!(document.apply(&[want("a", 3.0)], &base, None, false), Err(ApplyError::Manifest(_))));
    assert_eq!(document.now.text.as_ref(), good);
    assert_eq!(text(folder.path()), "format = ");
}

#[test]
fn a_flock_is_open_in_one_studio_and_a_folder_without_one_is_left_alone() {
    let folder = ring();
    let first = open(folder.path());
    assert!(matches!(super::open_until(folder.path(), usize::MAX, true), Err(DocumentError::Taken { .. })));
    drop(first);
    open(folder.path());
    let empty = tempfile::tempdir().unwrap();
    assert!(matches!(super::open_until(empty.path(), usize::MAX, true), Err(DocumentError::Manifest(_))));
    assert_eq!(fs::read_dir(empty.path()).unwrap().count(), 0);
}

#[test]
fn the_interface_reads_as_it_is_written_down() {
    let edits = r#"[{"do":"want","sheep":"a","value":2},{"do":"weight","from":"a","to":"b","value":0.5},
        {"do":"repeat","sheep":"a","value":3},{"do":"link","from":"a","to":"c"},
        {"do":"link","from":"a","to":"c","frames":96},{"do":"unlink","from":"a","to":"c"},{"do":"drop","sheep":"a"},
        {"do":"prune","drop":["a"]},{"do":"rename","sheep":"a","to":"b"},{"do":"add","candidates":["x"]},
        {"do":"weights","values":[{"from":"a","to":"b","value":1}]}]"#;
    let edits: Vec<EditRequest> = serde_json::from_str(edits).unwrap();
    assert_eq!((edits[0].clone(), edits[3].clone()), (want("a", 2.0), link("a", "c")));
    assert!(serde_json::from_str::<EditRequest>(r#"{"do":"drop","sheep":"../a"}"#).is_err());
}
