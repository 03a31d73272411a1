//! What genomes say of their origin, and what makes children.
//!
//! Owns claims on operators and lineages of all species.

use std::collections::BTreeSet;

use species::{Breed, Genome, Lineage, Rng, UNCHANGED};

use super::sheep::{SETTINGS, genome};
use super::tried;

/// Parents that are tried with an operator until it has something to do.
const FAMILIES: usize = 4;

/// A lineage with everything that there may be.
fn whole() -> Lineage {
    let texts = |texts: &[&str]| texts.iter().map(ToString::to_string).collect::<Vec<String>>();
    Lineage {
        id: Some("7.00412".into()),
        parents: texts(&["7.00400", "a \"b\" \\ <c> & 'd'"]),
        operator: Some("union".into()),
        date: Some("2026-11-25".into()),
        authors: texts(&["ann <ann.example>", "b\u{f6}b"]),
        licence: Some("CC-BY-NC-3.0".into()),
    }
}

#[test]
fn a_lineage_reads_back_and_changes_no_picture() {
    for species in tried() {
        let sheep = genome(species, 1);
        let mut last = sheep.with_lineage(&Lineage::default());
        let bare = last.text();
        assert_eq!(last.lineage(), Lineage::default());
        let one = Lineage { authors: vec!["ann".into()], ..Lineage::default() };
        for lineage in [whole(), one, whole(), Lineage::default()] {
            last = last.with_lineage(&lineage);
            let again = species.parse(&last.text()).unwrap();
            assert_eq!(again.lineage(), lineage, "{}", last.text());
            assert_eq!(again.text(), last.text());
            assert_eq!(again.recipe(&SETTINGS), sheep.recipe(&SETTINGS));
        }
        assert_eq!(last.text(), bare, "nothing is left of an earlier one");
    }
}

#[test]
fn children_name_their_parents_their_authors_and_the_strictest_licence() {
    for species in tried() {
        let said = |id: &str, author: &str, licence: &str, seed: u64| {
            let lineage = Lineage {
                id: Some(id.into()),
                authors: vec![author.into()],
                licence: Some(licence.into()),
                ..Lineage::default()
            };
            genome(species, seed).with_lineage(&lineage)
        };
        let (a, b) = (said("7.1", "ann", "CC-BY-4.0", 0), said("7.2", "bob", "CC-BY-NC-4.0", 1));
        let mut rng = Rng::stream(4, 34);
        let (child, how) = species.mutate(&*a, 1.0, &mut rng).unwrap();
        let lineage = child.lineage();
        assert_eq!((lineage.parents, lineage.operator.as_deref()), (vec!["7.1".to_owned()], Some(how)));
        assert_eq!((lineage.authors, lineage.licence.as_deref()), (vec!["ann".to_owned()], Some("CC-BY-4.0")));
        let (child, how) = species.cross([&*a, &*b], &mut rng).unwrap();
        let lineage = child.lineage();
        assert_eq!(lineage.parents, ["7.1", "7.2"]);
        assert_eq!((lineage.operator.as_deref(), child.name()), (Some(how), None));
        assert_eq!((lineage.authors.len(), lineage.licence.as_deref()), (2, Some("CC-BY-NC-4.0")));
    }
}

#[test]
fn every_operator_has_a_name_and_makes_a_child_when_it_is_asked_for() {
    for species in tried() {
        let names = species.operators().iter().flat_map(|operator| operator.aliases.iter().chain([&operator.name]));
        let mut seen = BTreeSet::from([UNCHANGED]);
        for name in names {
            assert!(seen.insert(*name), "{}: `{name}` is there twice", species.name());
            let is_word = |letter: char| letter.is_ascii_lowercase() || letter == '-' || letter == '_';
            assert!(name.chars().all(is_word) && species.operator(name).is_some(), "{name}");
        }
        // Each with a relative: some crossings want parents that have much in common.
        let family = |seed: u64| {
            let parent = genome(species, seed);
            let relative = species.mutate(&*parent, 1.0, &mut Rng::stream(seed, 36)).unwrap().0;
            [parent, relative]
        };
        let mut families = vec![family(0)];
        let mut without = Vec::new();
        for operator in species.operators() {
            assert!(operator.does.chars().next().is_some_and(char::is_lowercase) && !operator.does.ends_with('.'));
            let mut rng = Rng::stream(9, 35);
            let mut made = None;
            for number in 0..FAMILIES {
                if number == families.len() {
                    families.push(family(number as u64));
                }
                let parents: Vec<&dyn Genome> = families[number].iter().map(|parent| &**parent).collect();
                let wrong = &parents[..3 - operator.parents];
                assert!(species.apply(operator.name, wrong, 1.0, &mut rng).is_none(), "{}", operator.name);
                let child = species.apply(operator.name, &parents[..operator.parents], 1.0, &mut rng);
                // Parents that are much alike may have a child that is one of them.
                made = child.filter(|(child, _)| child.recipe(&SETTINGS) != parents[0].recipe(&SETTINGS));
                if made.is_some() {
                    break;
                }
            }
            let Some((child, how)) = made else {
                without.push(operator.name);
                continue;
            };
            assert_eq!((how, child.lineage().operator.as_deref()), (operator.name, Some(operator.name)));
        }
        println!("{}: nothing to do for {without:?}", species.name());
        assert!(without.len() <= 1, "{}: {without:?}", species.name());
        assert!(species.apply("waltz", &[&*families[0][0]], 1.0, &mut Rng::stream(9, 35)).is_none());
    }
}

#[test]
fn flames_know_the_operators_of_flam3_by_their_names() {
    let flames: &dyn Breed = &super::FLAMES;
    let known = |names: &[&str], parents: usize| {
        names.iter().all(|name| flames.operator(name).is_some_and(|operator| operator.parents == parents))
    };
    let mutations =
        ["all_vars", "one_xform", "add_symmetry", "post_xforms", "color_palette", "delete_xform", "all_coefs"];
    assert!(known(&mutations, 1) && known(&["union", "interpolate", "alternate"], 2));
}
