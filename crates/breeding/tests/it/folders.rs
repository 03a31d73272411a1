//! The folder of a pool: what a cut leaves, what is refused, what a merge makes.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use crate::meadow::{Sheep, events, settings, waiting};
use crate::simulation::World;
use breeding::{BreedingError, Count, Day, Event, Folder, Id, LEDGER, Mark, Order, SETTINGS, Settings};
use species::Rng;

/// A pool on a disk with two broods and some votes.
fn filled(path: &Path, seed: u64) -> Folder {
    let world = World::new(seed);
    let mut folder = Folder::create(path, &settings(seed)).unwrap();
    let mut sheep = Sheep::new(&world, seed, 0);
    let waits = |serial: u64| Event::Waits(waiting(world.figures(&World::random(&mut Rng::stream(seed, serial)))));
    // One of two is born; the other comes after the last brood.
    folder.tell(Day(0), vec![waits(1)]).unwrap();
    for day in 0..2 {
        sheep.pool = folder.pool().clone();
        let brood = sheep.brood(&Order { births: Some(4), ..Order::default() });
        sheep.meadow.genes.extend(brood.born.iter().map(|(born, genes)| (born.id, *genes)));
        folder.bear(Day(day), &brood, |born, _| format!("genome of {}", born.id)).unwrap();
        let count = Count { shown: 30 * (u64::from(day) + 1), up: 2 * (u64::from(day) + 1), down: 0 };
        let votes = folder.pool().living().map(|sheep| (sheep.born.id.to_string(), count)).collect();
        folder.tell(Day(day), vec![Event::Votes { unit: "wall".to_owned(), sheep: votes }]).unwrap();
    }
    folder.tell(Day(1), vec![waits(2)]).unwrap();
    assert_eq!(folder.pool().waiting().count(), 1);
    folder
}

#[test]
fn a_kill_at_any_byte_loses_nothing_that_was_told_and_leaves_no_sheep_without_a_genome() {
    let scratch = tempfile::tempdir().unwrap();
    let path = scratch.path().join("pool");
    drop(filled(&path, 1));
    let (all, bytes) = (events(&path), fs::read(path.join(LEDGER)).unwrap());
    let mut told = 0;
    for cut in 0..=bytes.len() {
        fs::write(path.join(LEDGER), &bytes[..cut]).unwrap();
        told += usize::from(cut > 0 && bytes[cut - 1] == b'\n');
        // Every line that was whole is there; the torn one is not.
        assert_eq!(events(&path), all[..told], "after {cut} bytes");
        // The next event follows the whole ones, whatever was torn.
        if cut % 251 == 0 || cut + 3 > bytes.len() {
            let mut folder = Folder::open_for_changes(&path).unwrap();
            assert_eq!(folder.missing_genomes().count(), 0);
            folder.tell(Day(9), vec![Event::Brood { brood: 9, seed: 9 }]).unwrap();
            let after = events(&path);
            assert_eq!((&after[..told], after.len()), (&all[..told], told + 1), "after {cut} bytes");
        }
    }
    assert_eq!(told, all.len());
}

#[test]
fn a_cut_before_the_ledger_is_told_leaves_genomes_that_mean_nothing_and_are_replaced() {
    let scratch = tempfile::tempdir().unwrap();
    let mut folder = filled(scratch.path(), 1);
    let serial = folder.pool().next_serial();
    let id = Id { brood: folder.pool().next_brood(), serial, origin: folder.pool().settings.origin };
    let orphan = scratch.path().join(format!("genomes/{id}.simulated"));
    fs::write(&orphan, "of a brood that was never told").unwrap();
    assert!(folder.pool().get(id).is_none());
    let world = World::new(1);
    let mut sheep = Sheep::new(&world, 1, 0);
    sheep.pool = folder.pool().clone();
    let brood =
        sheep.brood(&Order { births: Some(3), operation: Some(breeding::Operation::Stranger), ..Order::default() });
    folder.bear(Day(2), &brood, |born, _| format!("genome of {}", born.id)).unwrap();
    assert_eq!(fs::read_to_string(&orphan).unwrap(), format!("genome of {id}"));
    fs::remove_file(&orphan).unwrap();
    assert_eq!(folder.missing_genomes().map(|born| born.id).collect::<Vec<_>>(), [id]);
}

#[test]
fn a_line_that_is_not_understood_is_refused_by_its_number_and_members_of_later_versions_are_kept() {
    let scratch = tempfile::tempdir().unwrap();
    drop(filled(scratch.path(), 1));
    let file = scratch.path().join(LEDGER);
    let text = fs::read_to_string(&file).unwrap();
    let lines: Vec<&str> = text.lines().collect();
    let refused = |line: &str| {
        let changed = [&lines[..2], &[line], &lines[3..]].concat().join("\n") + "\n";
        fs::write(&file, changed).unwrap();
        let error = Folder::open(scratch.path()).unwrap_err();
        let BreedingError::BadEvent { line, reason, .. } = error else { panic!("{error}") };
        (line, reason)
    };
    let later = lines[2].replace("\"event\":\"born\"", "\"event\":\"sung\"");
    let (line, reason) = refused(&later);
    assert!(line == 3 && reason.contains("unknown variant `sung`"), "{reason}");
    for bad in ["", "{", "\u{0}\u{0}", &lines[2][..40], &lines[2].replace("0.0000", "0.000")] {
        assert_eq!(refused(bad).0, 3, "{bad}");
    }
    // A member that only a later version knows means nothing here, and goes along where the pool is merged.
    let known = text.replacen("\"event\":\"born\"", "\"mood\":\"calm\",\"event\":\"born\"", 1);
    fs::write(&file, &known).unwrap();
    let other = tempfile::tempdir().unwrap();
    let mut merged = Folder::create(other.path(), &settings(2)).unwrap();
    merged.merge(&Folder::open(scratch.path()).unwrap()).unwrap();
    assert_eq!(fs::read_to_string(other.path().join(LEDGER)).unwrap(), known);
}

/// What is the same whichever of two pools took in the other.
fn state(folder: &Folder) -> String {
    let mut genomes = BTreeMap::new();
    for file in fs::read_dir(folder.genome_folder()).unwrap().map(Result::unwrap) {
        genomes.insert(file.file_name(), fs::read_to_string(file.path()).unwrap());
    }
    let sheep: Vec<_> = folder.pool().sheep().collect();
    let tallies = folder.pool().votes().tallies(Day(50));
    format!("{sheep:?} {tallies:?} {:?} {genomes:?}", folder.ledger().entries().collect::<Vec<_>>())
}

#[test]
fn pools_are_merged_in_any_order_and_any_number_of_times_with_the_same_result() {
    let scratch = tempfile::tempdir().unwrap();
    let paths = ["a", "b", "ab", "ba"].map(|name| scratch.path().join(name));
    for (path, seed) in paths.iter().zip([1, 2, 1, 2]) {
        drop(filled(path, seed));
    }
    let open = |at: usize| Folder::open(&paths[at]).unwrap();
    let merged = |into: usize, from: &[usize]| {
        let mut folder = Folder::open_for_changes(&paths[into]).unwrap();
        for from in from {
            folder.merge(&open(*from)).unwrap();
        }
        assert_eq!(folder.missing_genomes().count(), 0);
        assert_eq!(state(&folder), state(&open(into)), "the disk has what the program has");
        state(&folder)
    };
    let both = merged(2, &[1]);
    assert_eq!(both, merged(3, &[0]));
    assert_eq!(both, merged(2, &[1, 0, 3, 2]));
    assert!(open(2).pool().living().count() == 16 && both != state(&open(0)));
    // What one pool says of the other's sheep goes back with it.
    let mut folder = Folder::open_for_changes(&paths[2]).unwrap();
    let id = open(1).pool().living().next().unwrap().born.id;
    folder.tell(Day(0), vec![Event::Marked { id, mark: Mark::Reject }]).unwrap();
    drop(folder);
    merged(1, &[2]);
    assert!(!open(1).pool().get(id).unwrap().is_alive());
}

#[test]
fn a_copy_of_a_pool_that_went_its_own_way_is_not_merged() {
    let scratch = tempfile::tempdir().unwrap();
    let [one, two] = ["one", "two"].map(|name| filled(&scratch.path().join(name), 1));
    let [mut one, mut two] = [one, two];
    one.tell(Day(3), vec![Event::Brood { brood: 2, seed: 1 }]).unwrap();
    two.tell(Day(3), vec![Event::Brood { brood: 2, seed: 2 }]).unwrap();
    let before = fs::read(scratch.path().join("one").join(LEDGER)).unwrap();
    assert!(matches!(one.merge(&two), Err(BreedingError::Clash { .. })));
    assert_eq!(fs::read(scratch.path().join("one").join(LEDGER)).unwrap(), before);
}

#[test]
fn two_programs_do_not_change_a_pool_at_once_and_no_pool_is_made_over_another() {
    let scratch = tempfile::tempdir().unwrap();
    let folder = filled(scratch.path(), 1);
    assert!(matches!(Folder::open_for_changes(scratch.path()), Err(BreedingError::InUse { .. })));
    let mut reader = Folder::open(scratch.path()).unwrap();
    assert!(matches!(reader.tell(Day(1), Vec::new()), Err(BreedingError::InUse { .. })));
    drop(folder);
    assert!(Folder::open_for_changes(scratch.path()).is_ok());
    assert!(matches!(Folder::create(scratch.path(), &settings(2)), Err(BreedingError::Exists { .. })));
}

#[test]
fn settings_are_read_as_written_and_refused_with_both_values() {
    let text = settings(7).text().unwrap();
    assert_eq!(Settings::parse(&text, SETTINGS).unwrap(), settings(7));
    let cases = [
        ("crossings = 0.5", "crossings = 0.8", "crossings is 0.8, and mutations is 0.4: together over 1"),
        ("births = 20", "births = 0", "births is 0, not 1 to 1000"),
        ("\"contrast\"", "\"mean\"", "niches is `mean`, and again `mean`: not two figures"),
        ("half_life_days = 180.0", "half_life_days = 0.0", "half_life_days is 0, not 1 or more"),
    ];
    for (from, to, said) in cases {
        assert!(text.contains(from), "{text}");
        assert_eq!(Settings::parse(&text.replace(from, to), SETTINGS).unwrap_err().to_string(), said);
    }
    let unknown = Settings::parse(&format!("{text}colour = 1\n"), SETTINGS).unwrap_err();
    assert!(matches!(unknown, BreedingError::Settings { .. }), "{unknown}");
}

#[test]
fn what_two_pools_heard_of_a_unit_counts_once_when_they_are_merged() {
    let scratch = tempfile::tempdir().unwrap();
    let paths = ["a", "b"].map(|name| scratch.path().join(name));
    drop(filled(&paths[0], 1));
    let mut b = filled(&paths[1], 2);
    b.merge(&Folder::open(&paths[0]).unwrap()).unwrap();
    let id = Folder::open(&paths[0]).unwrap().pool().living().next().unwrap().born.id.to_string();
    let heard = |folder: &mut Folder, shown: u64| {
        let sheep = BTreeMap::from([(id.clone(), Count { shown, up: shown / 10, down: 0 })]);
        folder.tell(Day(3), vec![Event::Votes { unit: "lobby".to_owned(), sheep }]).unwrap();
    };
    heard(&mut b, 100);
    heard(&mut Folder::open_for_changes(&paths[0]).unwrap(), 80);
    b.merge(&Folder::open(&paths[0]).unwrap()).unwrap();
    assert_eq!(b.pool().total("lobby", &id).shown, 100);
    let before = b.pool().votes().tallies(Day(3));
    heard(&mut b, 90);
    assert_eq!(b.pool().votes().tallies(Day(3)), before, "an older total is no news");
}
