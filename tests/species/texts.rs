//! Texts survive, and are refused or drawn.
//!
//! Owns claims on the files of all species.

use species::{Settings, Threads};

use super::damage::damaged;
use super::sheep::{SETTINGS, SIZE, genome, picture, turning};
use super::{SPECIES, genomes, many, tried};

#[test]
fn a_text_survives_reading_and_writing_and_is_of_one_species() {
    let threads = Threads::new(0).unwrap();
    for species in tried() {
        for seed in 0..genomes(species) {
            let genome = genome(species, seed);
            let text = genome.text();
            let again = species.parse(&text).unwrap();
            assert_eq!(again.text(), text);
            assert_eq!(again.recipe(&SETTINGS), genome.recipe(&SETTINGS));
            assert!(again.recipe(&SETTINGS) != again.recipe(&Settings { size: [95, 54], ..SETTINGS }), "{text}");
            let [first, second] = [&genome, &again].map(|genome| picture(&*turning(&**genome), 3.0, &threads));
            assert!(first == second, "{text}");
            let begins = SPECIES.iter().filter(|species| species.begins(&text));
            assert_eq!(begins.map(|species| species.ending()).collect::<Vec<_>>(), [species.ending()]);
        }
    }
}

#[test]
fn any_text_is_refused_by_name_or_drawn_within_its_demand() {
    /// The most bytes that a small picture may take.
    const MOST: u64 = 200 << 20;
    let threads = Threads::new(1).unwrap();
    for species in tried() {
        let (mut refused, mut drawn) = (0, 0);
        let texts: Vec<String> = (0..genomes(species) + 2).map(|seed| genome(species, seed).text()).collect();
        let mutants = many("MUTANTS", 300);
        for seed in 0..mutants {
            let text = damaged(&texts[seed as usize % texts.len()], &texts[(seed as usize + 1) % texts.len()], seed);
            let genome = match species.parse(&text) {
                Ok(genome) => genome,
                Err(refusal) => {
                    let words = refusal.to_string();
                    assert!((1..2000).contains(&words.len()), "{words}");
                    refused += 1;
                    continue;
                }
            };
            let turning = genome.turning(SIZE, 9.0);
            let settings = Settings { size: [16, 9], ..SETTINGS };
            let Ok(demand) = turning.demand(4.0, &settings) else { continue };
            // What would take long is told, and not tried.
            if demand.bytes > MOST || demand.samples > 2_000_000 {
                continue;
            }
            let used = threads.run(|| {
                allocation_counter::measure(|| {
                    let found = turning.frame(4.0, &settings, &threads).unwrap();
                    assert!(found.samples <= demand.samples, "{text}");
                })
            });
            assert!(used.bytes_max <= demand.bytes, "{used:?}, {demand:?}: {text}");
            drawn += 1;
        }
        println!("{}: {refused} refused, {drawn} drawn", species.name());
        assert!(drawn > mutants / 20, "{refused} refused, {drawn} drawn");
    }
}
