//! Texts survive, and are refused or drawn.
//!
//! Owns claims on the files of all species.

use species::{Breed, Settings, Threads};

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

/// The most bytes that reading a text, and drawing its small picture, may take.
const MOST: u64 = 200 << 20;

/// What the parser of XML says without a place.
const PLACELESS: [&str; 3] =
    ["the document does not have a root node", "the root node was opened but never closed", "unexpected end of stream"];

/// What became of damaged texts.
#[derive(Debug, Default)]
struct Outcomes {
    /// Not read.
    refused: u64,
    /// Read, but refused for what a picture would take.
    costly: u64,
    drawn: u64,
    most_bytes: u64,
    most_samples: u64,
}

impl Outcomes {
    /// Reads `text`, and draws a small picture of what it describes.
    fn add(&mut self, species: &dyn Breed, text: &str, threads: &Threads) {
        let mut read = None;
        let used = allocation_counter::measure(|| read = Some(species.parse(text)));
        assert!(used.bytes_max <= MOST, "reading takes {used:?}: {text}");
        let genome = match read.unwrap() {
            Ok(genome) => genome,
            Err(refusal) => {
                let words = refusal.to_string();
                assert!(words.len() < 2000 && is_placed(species, &words), "{words}: {text}");
                self.refused += 1;
                return;
            }
        };
        let turning = genome.turning(SIZE, 9.0);
        let settings = Settings { size: [16, 9], ..SETTINGS };
        let demand = match turning.demand(4.0, &settings) {
            Ok(demand) => demand,
            Err(refusal) => {
                let words = refusal.to_string();
                assert!(words.contains(|letter: char| letter.is_ascii_digit()), "no limit is named: {words}: {text}");
                let drawn = turning.frame(4.0, &settings, threads);
                assert_eq!(drawn.unwrap_err().to_string(), words, "{text}");
                self.costly += 1;
                return;
            }
        };
        assert!(demand.bytes <= MOST, "{demand:?}: {text}");
        let used = threads.run(|| {
            allocation_counter::measure(|| {
                let found = turning.frame(4.0, &settings, threads).unwrap();
                assert!(found.samples <= demand.samples, "{text}");
            })
        });
        assert!(used.bytes_max <= demand.bytes, "{used:?}, {demand:?}: {text}");
        self.drawn += 1;
        self.most_bytes = self.most_bytes.max(demand.bytes);
        self.most_samples = self.most_samples.max(demand.samples);
    }
}

/// Whether a refusal of a text names the line and the column, where there is one.
fn is_placed(species: &dyn Breed, words: &str) -> bool {
    let after_number = |text: &str| {
        let rest = text.trim_start_matches(|letter: char| letter.is_ascii_digit());
        if rest.len() < text.len() { Some(rest.to_owned()) } else { None }
    };
    let column = words.strip_prefix("line ").and_then(after_number);
    let why = column.and_then(|rest| after_number(rest.strip_prefix(", column ")?));
    if why.is_some_and(|why| why.len() > 2 && why.starts_with(": ")) {
        return true;
    }
    // Flames are XML: its parser names a place as 2:17, but none of what is missing; nor has a wrong number of flames one.
    let is_place = |text: &str| after_number(text).and_then(|rest| after_number(rest.strip_prefix(':')?)).is_some();
    let is_of_xml = |why: &str| {
        why.match_indices(" at ").any(|(at, word)| is_place(&why[at + word.len()..])) || PLACELESS.contains(&why)
    };
    let is_count = words.starts_with("found ") && words.ends_with(" flames, expected one");
    species.ending() == "flam3" && (is_count || words.strip_prefix("not well-formed XML: ").is_some_and(is_of_xml))
}

#[test]
fn any_text_is_refused_by_name_or_drawn_within_its_demand() {
    let threads = Threads::new(1).unwrap();
    for species in tried() {
        let mut outcomes = Outcomes::default();
        let texts: Vec<String> = (0..genomes(species) + 2).map(|seed| genome(species, seed).text()).collect();
        let mutants = many("MUTANTS", 300);
        for seed in 0..mutants {
            let text = damaged(&texts[seed as usize % texts.len()], &texts[(seed as usize + 1) % texts.len()], seed);
            outcomes.add(species, &text, &threads);
        }
        println!("{}: {outcomes:?}", species.name());
        assert_eq!(outcomes.refused + outcomes.costly + outcomes.drawn, mutants);
        assert!(outcomes.drawn > mutants / 20 && outcomes.refused > 0, "{}: {outcomes:?}", species.name());
    }
}
