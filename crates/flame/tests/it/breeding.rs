//! What is bred of flames can be drawn, and changes as it says.
//!
//! Owns claims on random flames, on each operator, and on children of the demo's flames that nobody has judged.

#![allow(clippy::print_stdout, reason = "what was found is told where it is asked for")]

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

use flame::breed::{Crossing, Judge, Mutation};
use flame::{Flames, FrameCost, Genome, Loop, Renderer, Rng, Settings};
use species::{Breed, Figures};

/// Children of the demo's flames: as many mutants, a third as many by crossing.
fn many(name: &str, usual: u64) -> u64 {
    std::env::var(name).ok().and_then(|number| number.parse().ok()).unwrap_or(usual)
}

/// The demo's flames, by name.
fn demo() -> Vec<Genome> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../flock-tools/demo/genomes");
    let files = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let mut files: Vec<_> = files.filter(|path| path.extension().is_some_and(|it| it == "flam3")).collect();
    files.sort();
    files.iter().map(|path| Genome::parse(&fs::read_to_string(path).unwrap()).unwrap()).collect()
}

fn has_sound_parts(genome: &Genome) -> bool {
    let flies = |numbers: &[f64]| numbers.iter().all(|number| number.is_finite());
    (2..=8).contains(&genome.xforms.len())
        && genome.palette.is_some()
        && genome.xforms.iter().all(|xform| {
            let affine =
                [xform.affine.a, xform.affine.b, xform.affine.c, xform.affine.d, xform.affine.e, xform.affine.f];
            xform.weight > 0.0
                && flies(&affine)
                && (0.0..=1.0).contains(&xform.color)
                && (0.0..=1.0).contains(&xform.color_speed)
                && (xform.chaos.is_empty() || xform.chaos.iter().any(|weight| *weight > 0.0))
                && xform.variations.iter().all(|variation| variation.weight.is_finite() && flies(&variation.params))
        })
}

#[test]
fn genomes_of_many_generations_stay_within_limits_and_every_part_changes() {
    let mut rng = Rng::stream(1, 40);
    let mut counts = BTreeSet::new();
    let mut symmetries = BTreeSet::new();
    let (mut grown, mut shrunk) = (0, 0);
    let mut genome = Genome::random(&mut rng);
    assert!((2..=6).contains(&genome.xforms.len()));
    for generation in 0..600 {
        let (child, mutation) = genome.mutated(1.0, &mut rng);
        assert!(has_sound_parts(&child), "{mutation:?}: {}", child.to_xml());
        let grows = child.xforms.len() as i64 - genome.xforms.len() as i64;
        match mutation {
            Mutation::Add => assert_eq!(grows, 1),
            Mutation::Delete => assert_eq!(grows, -1),
            Mutation::Symmetry => assert_ne!(child.symmetries, genome.symmetries),
            Mutation::Palette => assert!(child.palette != genome.palette && grows == 0),
            Mutation::Affine
            | Mutation::Affines
            | Mutation::Variations
            | Mutation::Post
            | Mutation::Colours
            | Mutation::Final => assert!(grows == 0 && child != genome, "{mutation:?}"),
            // Only a camera that stands in space is moved.
            Mutation::Camera => assert!(grows == 0 && child.camera.pose != genome.camera.pose, "{mutation:?}"),
        }
        grown += u32::from(grows > 0);
        shrunk += u32::from(grows < 0);
        counts.insert(child.xforms.len());
        symmetries.extend(child.symmetries.first().copied());
        genome = if generation % 10 == 9 { child.crossed(&Genome::random(&mut rng), &mut rng).0 } else { child };
        assert!(has_sound_parts(&genome), "{}", genome.to_xml());
    }
    assert!(grown > 5 && shrunk > 5 && counts.len() >= 4, "{grown}, {shrunk}, {counts:?}");
    assert!(symmetries.len() >= 5, "{symmetries:?}");
}

#[test]
fn a_flame_of_many_transforms_or_of_one_has_children_of_two_to_eight() {
    let mut rng = Rng::stream(2, 40);
    let one = "<xform weight=\"W\" color=\"0\" swirl=\"1\" coefs=\"0.5 0 0 0.5 0.1 0\" chaos=\"1 0 1\"/>";
    for count in [1, 2, 20] {
        let xforms: String = (0..count).map(|number| one.replace('W', &(number + 1).to_string())).collect();
        let mut genome = Genome::parse(&format!("<flame>{xforms}</flame>")).unwrap();
        genome.palette = Genome::random(&mut rng).palette;
        for _ in 0..40 {
            let (child, mutation) = genome.mutated(1.0, &mut rng);
            assert!(has_sound_parts(&child), "{mutation:?} of {count}: {}", child.to_xml());
            let (child, crossing) = genome.crossed(&Genome::random(&mut rng), &mut rng);
            assert!(has_sound_parts(&child), "{crossing:?} of {count}: {}", child.to_xml());
        }
    }
}

#[test]
fn both_parents_give_to_a_child() {
    let mut rng = Rng::stream(3, 40);
    for _ in 0..100 {
        let [a, b] = [(); 2].map(|()| Genome::random(&mut rng));
        // Digits apart, a transform that is taken over is the parent's.
        let of = |child: &Genome, parent: &Genome| {
            let is_from = |xform: &&flame::genome::Xform| {
                parent.xforms.iter().any(|own| (own.affine.a - xform.affine.a).abs() < 1e-5)
            };
            child.xforms.iter().filter(is_from).count()
        };
        let child = a.crossed_by(Crossing::Alternation, &b, &mut rng);
        let given = [of(&child, &a), of(&child, &b)];
        assert!(given[0] > 0 && given[1] > 0 && given[0] + given[1] == child.xforms.len(), "{given:?}");
        let child = a.crossed_by(Crossing::Union, &b, &mut rng);
        assert_eq!(child.xforms.len(), (a.xforms.len() + b.xforms.len()).min(8));
        let child = a.crossed_by(Crossing::Interpolation, &b, &mut rng);
        assert!(child != a && child != b && child.xforms.len() == a.xforms.len().max(b.xforms.len()));
        let child = a.crossed_by(Crossing::Recolouring, &b, &mut rng);
        assert!(child.palette == b.palette && of(&child, &a) == child.xforms.len());
    }
}

#[test]
fn a_child_keeps_what_nobody_knows_and_loses_its_name_and_the_number_of_its_palette() {
    let mut parent = demo().swap_remove(0);
    parent.extra.push(("made".into(), "by hand".into()));
    parent.palette_number = Some(7);
    let (child, _) = parent.mutated(1.0, &mut Rng::stream(4, 40));
    assert!(parent.name.is_some() && child.name.is_none() && child.palette_number.is_none());
    assert!(child.extra.contains(&("made".to_owned(), "by hand".to_owned())));
}

#[test]
fn a_symmetry_that_was_written_out_can_be_changed() {
    let bower = demo().into_iter().find(|genome| genome.name.as_deref() == Some("bower")).unwrap();
    assert_eq!((bower.xforms.len(), bower.symmetries.len()), (4, 0));
    let child = bower.mutated_by(Mutation::Colours, 1.0, &mut Rng::stream(5, 40)).unwrap();
    assert_eq!((child.xforms.len(), child.symmetries.as_slice()), (2, &[3][..]));
    assert_eq!(bower.mutated_by(Mutation::Delete, 1.0, &mut Rng::stream(5, 40)), None, "there are two");
}

#[test]
fn a_child_of_a_child_is_the_same_after_reading_and_stands_where_its_parent_did_if_only_colours_changed() {
    let (judge, renderer) = (Judge::new().unwrap(), Renderer::new(0).unwrap());
    let settings = Settings { size: Some([48, 27]), spp: Some(20.0), temporal_samples: Some(2), ..Settings::default() };
    let mut rng = Rng::stream(6, 40);
    let mut genome = demo().swap_remove(2);
    let (mut looked, mut still) = (0, 0);
    while looked < 12 {
        let (child, mutation) = genome.mutated(1.0, &mut rng);
        let Some(child) = judge.look_at_child(&child, mutation.is_of_colours()) else { continue };
        looked += 1;
        if mutation.is_of_colours() {
            assert_eq!(child.camera, genome.camera);
            still += 1;
        }
        let again = Genome::parse(&child.to_xml()).unwrap();
        assert_eq!(again, child);
        let picture = |genome: &Genome| renderer.render(&Loop::new(genome, 8.0), 3.0, &settings).unwrap();
        assert!(picture(&again) == picture(&child));
        genome = child;
    }
    println!("{still} of {looked} changed their colours only");
}

/// What is wrong with children that nobody has judged.
fn judged(children: impl Iterator<Item = (Genome, bool)>) -> (f64, BTreeMap<&'static str, u32>) {
    let judge = Judge::new().unwrap();
    let (mut count, mut fine, mut faults) = (0, 0, BTreeMap::new());
    for (child, is_of_colours) in children {
        count += 1;
        assert_eq!(Genome::parse(&child.to_xml()).unwrap(), child);
        let Some(child) = judge.look_at_child(&child, is_of_colours) else {
            *faults.entry("nothing to see").or_insert(0) += 1;
            continue;
        };
        FrameCost::of(&Loop::new(&child, 384.0), 0.0, &Settings::default()).unwrap();
        let found = judge.figures(&child).as_ref().map(Figures::faults).unwrap();
        fine += u32::from(found.is_empty());
        for fault in found {
            *faults.entry(fault.name()).or_insert(0) += 1;
        }
    }
    (f64::from(fine) / f64::from(count), faults)
}

#[test]
fn a_third_of_the_children_of_the_demos_flames_may_be_shown_as_they_are() {
    let (parents, children) = (demo(), many("CHILDREN", 30));
    let one = |number: u64| &parents[number as usize % parents.len()];
    let mutants = judged((0..children).map(|number| {
        let (child, mutation) = one(number).mutated(1.0, &mut Rng::stream(number, 41));
        (child, mutation.is_of_colours())
    }));
    let crossed = judged((0..children * 3 / 10).map(|number| {
        let other = one(number + 1 + number / parents.len() as u64 % (parents.len() as u64 - 1));
        let (child, crossing) = one(number).crossed(other, &mut Rng::stream(number, 42));
        (child, crossing.is_of_colours())
    }));
    println!("{:.2} of mutants, {:?}; {:.2} of crossed ones, {:?}", mutants.0, mutants.1, crossed.0, crossed.1);
    assert!(mutants.0 >= 1.0 / 3.0 && crossed.0 >= 1.0 / 3.0, "{mutants:?}, {crossed:?}");
}

#[test]
fn no_strength_changes_nothing() {
    let flames = Flames { backend: flame::Backend::PROCESSOR, coloured: Ok };
    let parent = flame::Flame::new(demo().swap_remove(0), flame::Backend::PROCESSOR);
    let (child, how) = flames.mutate(&parent, 0.0, &mut Rng::stream(7, 40)).unwrap();
    assert_eq!((child.text(), how), (parent.genome().to_xml(), species::UNCHANGED));
}
