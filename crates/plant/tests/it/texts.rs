//! Texts survive, and what is wrong in them is refused by name.

use crate::grove::{SMALL, many, plant};
use crate::target;
use plant::{GENES, MOST_BYTES, Plant, PlantError, Plants};
use species::{Genome, Rng, Species};

#[test]
fn a_genome_that_is_written_is_read_as_it_was() {
    for seed in 0..many("GENOMES", 200) {
        let mut plant = plant(seed);
        plant.name = (seed % 2 == 0).then(|| format!("a \"quoted\"\nname\t{seed} \u{1f33f}"));
        let text = plant.text();
        assert_eq!(Plant::parse(&text).unwrap(), plant, "{text}");
        assert!(Plants.begins(&text));
    }
}

#[test]
fn what_is_missing_takes_its_default_and_what_is_not_known_is_kept() {
    let text = "mark = [1, {a = nan}]\n[plant]\nversion = 1\ncurl = 1\nby = \"me\"\nmore.x = 0x10\n\n[studio]\n'a b' = 1e3\n\
                [studio.deep]\nx = 1979-05-27\n";
    let plant = Plant::parse(text).unwrap();
    let curl = GENES.iter().position(|gene| gene.name == "curl").unwrap();
    assert!(
        GENES.iter().enumerate().all(|(place, gene)| {
            (plant.genes[place] - if place == curl { 1.0 } else { gene.default }).abs() < 1e-12
        })
    );
    let again = plant.text();
    for kept in ["mark = [1, { a = nan }]", "by = \"me\"", "more = { x = 16 }", "[studio]", "1979-05-27", "\"a b\""] {
        assert!(again.contains(kept), "{kept} in {again}");
    }
    assert_eq!(Plant::parse(&again).unwrap(), plant);
    assert_eq!(plant.recipe(&SMALL), Plant { unknown: [vec![], vec![]], ..plant.clone() }.recipe(&SMALL));
}

#[test]
fn what_is_wrong_is_refused_by_name_with_both_values_and_its_place() {
    let of = |line: &str| format!("[plant]\nversion = 1\n  {line}\n");
    for (text, message) in [
        (of("curl = 1.5"), "line 3, column 10: `curl` is `1.5`, it must be a number from 0 to 1"),
        (of("sway = nan"), "line 3, column 10: `sway` is `nan`, it must be a number from 0 to 1"),
        (of("hue = \"red\""), "line 3, column 9: `hue` is `\"red\"`, it must be a number from 0 to 1"),
        (of("turns = 17"), "line 3, column 11: `turns` is `17`, it must be a whole number from 1 to 16"),
        (of("sky = [0, 1]"), "line 3, column 9: `sky` is `[0, 1]`, it must be three numbers from 0 to 1"),
        (of("horizon = [0, 1, 2]"), "line 3, column 20: `horizon` is `2`, it must be three numbers from 0 to 1"),
        ("[plant]\nversion = 2".to_owned(), "line 2, column 11: `version` is `2`, it must be 1"),
        ("[plant]\nname = \"a\"".to_owned(), "`version` is missing"),
        ("[fern]".to_owned(), "line 1, column 1: `plant` is missing"),
        ("plant = 3".to_owned(), "line 1, column 9: `plant` is `3`, it must be a table"),
        (of("curl 1"), "line 3, column "),
        (of("curl = 0.1\ncurl = 0.2"), "line 4, column 1"),
    ] {
        let error = Plant::parse(&text).unwrap_err();
        assert!(error.to_string().contains(message), "{error} for {text}");
        assert!(error.place().is_some());
    }
    let long = format!("{}#{}", of("curl = 1"), " ".repeat(MOST_BYTES));
    assert!(matches!(Plant::parse(&long), Err(PlantError::Long { most: MOST_BYTES, .. })));
}

#[test]
fn a_file_is_known_by_its_first_table() {
    for text in ["[plant]\n", "# a\n\n [ plant ] # b\n", "\u{feff}x = 1\n[plant]"] {
        assert!(Plants.begins(text), "{text}");
    }
    for text in ["", "<flame>", "(expression 1 x)", "[[plant]]", "[plants]\n[plant]", "v=60&str=F"] {
        assert!(!Plants.begins(text), "{text}");
    }
    assert_eq!((Plants.name(), Plants.ending()), ("a plant", "plant"));
}

/// A text with a few damaged places.
fn damaged(text: &str, rng: &mut Rng) -> Vec<u8> {
    const PIECES: [&str; 12] =
        ["1e999", "-0", "nan", "inf", "[", "]", "=", "\n", "\"\"\"", "seed = 9223372036854775807", "{a = 1}", "é"];
    let mut bytes = text.as_bytes().to_vec();
    for _ in 0..=rng.bits() % 3 {
        let at = (rng.unit() * bytes.len() as f64) as usize;
        let until = (at + (rng.unit() * rng.unit() * 40.0) as usize).min(bytes.len());
        match rng.bits() % 4 {
            0 => drop(bytes.splice(at..until, PIECES[(rng.bits() % 12) as usize].bytes())),
            1 => drop(bytes.drain(at..until)),
            2 => bytes[at] ^= 1 << (rng.bits() % 8),
            _ => {
                let piece = bytes[at..until].to_vec();
                drop(bytes.splice(at..at, piece));
            }
        }
    }
    bytes
}

#[test]
fn a_damaged_text_is_refused_with_its_place_or_drawn() {
    let (mut read, many) = (0, many("MUTANTS", 400));
    for seed in 0..many {
        let mut rng = Rng::stream(seed, 9);
        let bytes = damaged(&plant(seed % 50).text(), &mut rng);
        read += u64::from(target::genome(&bytes));
    }
    assert!(read > many / 20 && read < many, "{read} of {many} were read");
}

#[test]
fn genomes_of_ours_are_read_and_named_as_their_files() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../flock-tools/demo/genomes");
    let mut many = 0;
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_none_or(|ending| ending != "plant") {
            continue;
        }
        let text = std::fs::read_to_string(&path).unwrap();
        let plant = Plant::parse(&text).unwrap();
        assert_eq!(plant.name.as_deref(), path.file_stem().unwrap().to_str());
        assert_eq!(plant.text(), text, "written otherwise");
        assert!(plant::Look::of(&plant).is_fair());
        many += 1;
    }
    assert_eq!(many, 4);
}
