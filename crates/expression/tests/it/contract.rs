//! What those rely on who know no expression.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use crate::bred;
use crate::many::many;
use expression::{ExpressionError, Expressions, FASTEST_NS, Genome, VERSION};
use species::{Breed, Figures, Genome as _, Motion, RenderError, Rng, Settings, Species, Threads};

const SIZE: [u32; 2] = [96, 54];
const SETTINGS: Settings =
    Settings { size: SIZE, spp: None, psnr: None, supersample: None, temporal_samples: None, smooths: true, seed: 1 };

fn genome(text: &str) -> Genome {
    Genome::parse(text).unwrap()
}

fn expression(of: &dyn species::Genome) -> &Genome {
    of.as_any().downcast_ref().unwrap()
}

#[test]
fn a_file_is_known_by_how_it_begins_whatever_its_name_is() {
    for text in ["(expression 1 (picture x))", "\n ; A comment.\n  (expression", "(expression 2"] {
        assert!(Expressions.begins(text), "{text}");
    }
    for text in ["", "<flame>", "; (expression", "(express", "x (expression"] {
        assert!(!Expressions.begins(text), "{text}");
    }
    assert_eq!((Expressions.name(), Expressions.ending()), ("an expression", "expr"));
}

#[test]
fn a_refusal_says_where() {
    let refusal = Expressions.parse("(expression 1\n (picture (sine x)))").unwrap_err();
    assert_eq!(refusal.to_string(), "line 2, column 12: `sine` is not known");
    let place = refusal.downcast::<ExpressionError>().unwrap().place();
    assert_eq!(place, Some(species::Place { line: 2, column: 12 }));
}

#[test]
fn settings_choose_the_samples_that_are_drawn() {
    let threads = Threads::new(1).unwrap();
    let edge = genome("(expression 1 (picture (if (- x (* .5 z)) 1 0)))").turning(SIZE, 4.0);
    let drawn = |settings: Settings| edge.frame(0.0, &settings, &threads).unwrap();
    let samples = |spp: f64| drawn(Settings { spp: Some(spp), ..SETTINGS }).samples / (96 * 54);
    assert_eq!([0.5, 1.0, 1.5, 15.9].map(samples), [1, 1, 16, 16]);
    let adaptive = drawn(SETTINGS);
    for settings in [
        Settings { spp: Some(16.0), ..SETTINGS },
        Settings { spp: Some(5000.0), ..SETTINGS },
        Settings { spp: Some(1.0), psnr: Some(40.0), ..SETTINGS },
        Settings { seed: 7, supersample: Some(3), smooths: false, ..SETTINGS },
    ] {
        assert_eq!(drawn(settings), adaptive);
    }
    assert!(adaptive.samples > 16 * 96 * 54 && adaptive.psnr.is_none() && !edge.is_noisy());
    let grey = |settings: Settings| {
        drawn(settings).image.pixels[..96].iter().filter(|pixel| (0.02..0.98).contains(&pixel[0])).count()
    };
    let sharp = Settings { temporal_samples: Some(1), ..SETTINGS };
    assert!(grey(SETTINGS) > grey(sharp), "one moment has no motion blur");
}

#[test]
fn a_recipe_has_all_that_pictures_depend_on_and_nothing_else() {
    let plain = genome("(expression 1 (picture (sin x)))").recipe(&SETTINGS);
    let named = genome("(expression 1 ; What.\n (name \"tide\") (light 1) (picture (sin x)))").recipe(&SETTINGS);
    assert_eq!(plain, named);
    assert_eq!(plain.version, format!("expression {VERSION}"));
    assert_eq!((&*plain.settings, &*plain.genome), ("96x54 adaptive blurred", "(expression 1\n  (picture (sin x)))\n"));
    for text in ["(turns 2)", "(map (scale 2))"] {
        assert_ne!(genome(&format!("(expression 1 {text} (picture (sin x)))")).recipe(&SETTINGS).genome, plain.genome);
    }
    let recipe = |settings: Settings| genome("(expression 1 (picture x))").recipe(&settings).settings;
    assert_eq!(recipe(Settings { spp: Some(1.0), temporal_samples: Some(8), ..SETTINGS }), "96x54 one sharp");
    assert_eq!(recipe(Settings { spp: Some(4.0), temporal_samples: Some(1), ..SETTINGS }), "96x54 sixteen sharp");
    assert_eq!(recipe(Settings { seed: 2, ..SETTINGS }), recipe(SETTINGS));
}

#[test]
fn only_relatives_have_a_transition_of_their_own() {
    let [a, b, c] = ["(+ x (sin (* 3 z)))", "(+ y (sin (* 4 z)))", "(bw-noise .3 1)"]
        .map(|picture| genome(&format!("(expression 1 (picture {picture}))")));
    assert!(a.transition(&b, SIZE, [60.0, 90.0], 30.0).is_some());
    assert!(a.transition(&c, SIZE, [60.0, 90.0], 30.0).is_none());
}

#[test]
fn drawing_stops_when_it_is_told_to() {
    let stopped = Threads::new(2).unwrap().with_stop_flag(Arc::new(AtomicBool::new(true)));
    let turning = genome("(expression 1 (picture x))").turning(SIZE, 4.0);
    assert!(matches!(turning.frame(0.0, &SETTINGS, &stopped), Err(RenderError::Stopped)));
}

#[test]
fn a_picture_takes_no_more_memory_than_was_told() {
    let threads = Threads::new(1).unwrap();
    let within = |motion: &dyn Motion, frame: f64, settings: Settings, text: &dyn std::fmt::Display| {
        // What is refused takes nothing.
        let Ok(demand) = motion.demand(frame, &settings) else { return 0 };
        // On the one thread that draws, where allocations are counted.
        let used = threads.run(|| {
            allocation_counter::measure(|| {
                motion.frame(frame, &settings, &threads).unwrap();
            })
        });
        assert!(used.bytes_max <= demand.bytes, "{used:?}, {demand:?}: {text}");
        1
    };
    let mut drawn = 0;
    for seed in 0..many("GENOMES", 200) {
        let (genome, to) = (bred::genome(seed), bred::genome(seed + 1));
        let size = [[8, 6], [1, 1], [64, 36], [200, 3]][seed as usize % 4];
        let settings = Settings { size, spp: [None, Some(1.0)][seed as usize / 4 % 2], ..SETTINGS };
        drawn += within(&*genome.turning(size, 9.0), 4.0, settings, &genome);
        let way =
            expression::Transition::new(&expression::Loop::new(&genome, 9.0), &expression::Loop::new(&to, 9.0), 9.0);
        drawn += within(&way, 4.0, settings, &genome);
    }
    assert!(drawn >= many("GENOMES", 200), "only {drawn} were drawn");
    let settings = Settings { size: [640, 360], ..SETTINGS };
    let largest = genome("(expression 1 (picture (color-grad (escape x y -.8 (* .2 z)) 3 z #(.1 0 .3) #(1 .8 .3))))");
    assert_eq!(within(&*largest.turning([640, 360], 9.0), 4.0, settings, &largest), 1);
    // 256 different waves, added up: its tables are larger than its picture.
    let waves = |count: usize| (1..=count).map(|wave| format!("(sin (* x {wave}))")).collect::<Vec<_>>();
    let mut sums = waves(256);
    while let [_, _, ..] = &sums[..] {
        sums = sums.chunks(2).map(|pair| format!("(+ {})", pair.join(" "))).collect();
    }
    let longest = genome(&format!("(expression 1 (picture {}))", sums[0]));
    let settings = Settings { size: [8, 6], ..SETTINGS };
    assert_eq!(within(&*longest.turning([8, 6], 9.0), 4.0, settings, &longest), 1);
}

#[test]
fn candidates_are_fast_and_without_a_fault_and_the_same_for_the_same_numbers() {
    let threads = Threads::new(1).unwrap();
    let is_shown = |genome: &dyn species::Genome| {
        let figures = Figures::sketched(&*genome.turning(SIZE, 384.0), 384.0, [1280, 720], &threads).unwrap();
        assert_eq!(figures.faults(), [], "{figures:?}: {}", genome.text());
        assert!(expression(genome).ns_per_sample().unwrap() <= FASTEST_NS);
    };
    let mut last = Expressions.random(&mut Rng::stream(99, 9));
    for seed in 0..many("GENOMES", 8) {
        let breed = || {
            let mut rng = Rng::stream(seed, 9);
            let random = Expressions.random(&mut rng);
            let mutated = Expressions.mutate(&*random, 1.0, &mut rng).unwrap();
            let crossed = Expressions.cross([&*random, &*last], &mut rng);
            (random, mutated, crossed)
        };
        let (random, mutated, crossed) = breed();
        is_shown(&*random);
        is_shown(&*mutated.0);
        assert!(mutated.1 == "none" || mutated.0.text() != random.text(), "{}", mutated.1);
        if let Some((child, action)) = &crossed {
            is_shown(&**child);
            assert!(["graft", "walk"].contains(action));
        }
        let again = breed();
        assert_eq!((again.0.text(), again.1.0.text(), again.1.1), (random.text(), mutated.0.text(), mutated.1));
        last = random;
    }
}

#[test]
fn a_strength_of_nothing_changes_nothing() {
    let parent = bred::genome(3);
    let (child, action) = Expressions.mutate(&parent, 0.0, &mut Rng::stream(1, 0)).unwrap();
    assert_eq!((expression(&*child), action), (&parent, "none"));
}
