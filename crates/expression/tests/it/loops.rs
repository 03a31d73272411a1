//! Loops are exact, and transitions meet them.

#![allow(clippy::float_cmp, reason = "parts of few nodes are exact")]

use crate::bred;
use crate::drawing::Renderer;
use crate::many::many;
use expression::{Drift, ExpressionError, Genome, Loop, Map, Moving, Node, Samples, Settings, Still, Transition, Zoom};
use species::Image;

const SMALL: Settings = Settings { size: [24, 16], samples: Samples::Sixteen, is_blurred: true };

/// A picture, or none if the genome is refused as too slow.
fn picture(renderer: &Renderer, motion: &dyn Moving, frame: f64) -> Option<Image> {
    match renderer.render(motion, frame, &SMALL) {
        Ok(image) => Some(image),
        Err(error) => {
            assert!(matches!(error, ExpressionError::Slow { .. }), "{error}");
            None
        }
    }
}

fn turning(text: &str, frames: f64) -> Loop {
    Loop::new(&Genome::from(Node::parse(text).unwrap()), frames)
}

fn difference(a: &Image, b: &Image) -> f64 {
    let pairs = a.pixels.as_flattened().iter().zip(b.pixels.as_flattened());
    pairs.map(|(a, b)| f64::from(a - b).abs()).fold(0.0, f64::max)
}

#[test]
fn every_expression_that_parses_is_an_exact_loop() {
    let renderer = Renderer::new(2);
    let (mut drawn, mut moving) = (0, 0);
    let genomes = many("GENOMES", 220);
    for seed in 0..genomes {
        let mut genome = bred::genome(seed);
        genome.turns = 1 + (seed % 3) as u32;
        if seed % 2 == 1 {
            genome.map = moving_map(seed);
        }
        let frames = [7.0, 60.0, 100.5][seed as usize % 3];
        let turning = Loop::new(&genome, frames);
        let Some(first) = picture(&renderer, &turning, 0.0) else { continue };
        drawn += 1;
        for (frame, same) in [(frames, 0.0), (3.0 * frames, 0.0), (frames + 2.0, 2.0), (2.5 - frames, 2.5)] {
            let [one, other] = [frame, same].map(|frame| picture(&renderer, &turning, frame));
            assert_eq!(one, other, "genome {seed}, frames {frame} and {same}: {}", genome.picture);
        }
        moving += u64::from(picture(&renderer, &turning, 2.0) != Some(first));
    }
    assert!(drawn >= genomes * 9 / 10 && moving > genomes / 3, "{drawn} drawn, {moving} of them move");
}

#[test]
fn the_ends_of_a_transition_are_the_loops_to_the_bit() {
    let renderer = Renderer::new(2);
    let mut drawn = 0;
    let pairs = many("PAIRS", 110);
    for seed in 0..pairs {
        // Every third pair is of one family, so that much is shared.
        let from = bred::genome(seed);
        let mut rng = species::Rng::stream(seed, 1);
        let mut to = if seed % 3 == 0 { from.mutated(3.0, &mut rng).0 } else { bred::genome(seed + 1000) };
        to.turns = 1 + (seed % 2) as u32;
        to.map.scale = 1.0 + (seed % 5) as f32;
        to.map.drift = moving_map(seed).drift.filter(|_| seed % 2 == 1);
        let frames = [20.0, 33.0];
        let loops = [Loop::new(&from, frames[0]), Loop::new(&to, frames[1])];
        let between = Transition::new(&loops[0], &loops[1], 17.0);
        for (end, side) in [(0.0, &loops[0]), (17.0, &loops[1])] {
            let [Some(end), Some(start)] = [picture(&renderer, &between, end), picture(&renderer, side, 0.0)] else {
                continue;
            };
            drawn += 1;
            assert_eq!(end, start, "pair {seed}: {} and {}", from.picture, to.picture);
        }
    }
    assert!(drawn >= pairs * 18 / 10, "only {drawn} ends were drawn");
}

/// A map that moves.
fn moving_map(seed: u64) -> Map {
    let (n, part) = (1 + (seed % 4) as u8, (seed % 7) as f32 / 7.0);
    let (zoom, drift) = (Zoom { n, by: part, p: 0.1 }, Drift { n: 5 - n, by: [0.4, part], p: part });
    Map { zoom: Some(zoom), drift: Some(drift), ..Map::default() }
}

/// A map that moves, once a turn.
const ROUND: &str = "(scale 2) (zoom 1 .3 0) (drift 1 .5 .25 .25)";

#[test]
fn a_map_that_moves_goes_round_and_every_transition_meets_it_in_value_and_in_speed() {
    let renderer = Renderer::new(2);
    let wave = "(+ .5 (* .4 (sin (+ (* 3 x) (* 2 y)))))";
    let of = |map: &str, frames: f64| {
        Loop::new(&Genome::parse(&format!("(expression 1 (map {map}) (picture {wave}))")).unwrap(), frames)
    };
    let (still, round) = (of("(scale 2)", 40.0), of(ROUND, 40.0));
    // A quarter of a loop: the zoom is strongest, and the ellipse is at its left.
    let view = round.view(10.0, 0.0);
    assert!((view.scale - 2.0 * 0.3_f32.exp()).abs() < 1e-5 && view.center.iter().all(|x| x.is_finite()), "{view:?}");
    assert!((view.center[0] + 0.5).abs() < 1e-5 && view.center[1].abs() < 1e-5, "{view:?}");
    assert_eq!(still.view(10.0, 0.0), still.view(0.0, 0.2));
    // While the shutter is open, and twice as fast with two turns.
    let twice = Genome { turns: 2, ..Genome::parse(&format!("(expression 1 (map {ROUND}) (picture x))")).unwrap() };
    for (other, same) in [(round.view(9.5, 0.5), view), (Loop::new(&twice, 40.0).view(5.0, 0.0), view)] {
        assert!(
            (other.scale - same.scale).abs() < 1e-5 && (other.center[1] - same.center[1]).abs() < 1e-5,
            "{other:?}"
        );
    }
    let [first, later, last] = [0.0, 10.0, 40.0].map(|frame| picture(&renderer, &round, frame).unwrap());
    assert!(first == last && difference(&first, &later) > 0.1);
    // The seam: the second difference there is as anywhere.
    let at = |frame: f64| picture(&renderer, &round, frame).unwrap();
    let bend = |frame: f64| {
        let [a, b, c] = [frame - 1.0, frame, frame + 1.0].map(at);
        let lights = [a, b, c].map(|image| image.pixels.as_flattened().to_vec());
        (0..lights[0].len()).map(|at| (lights[0][at] - 2.0 * lights[1][at] + lights[2][at]).abs()).fold(0.0, f32::max)
    };
    let usual = (1..39).map(|frame| bend(f64::from(frame))).fold(0.0, f32::max);
    assert!(bend(40.0) <= 1.2 * usual, "{} {usual}", bend(40.0));
    for [from, to] in [[&still, &round], [&round, &still], [&round, &of("(zoom 2 .2 .1)", 64.0)]] {
        let between = Transition::new(from, to, 50.0);
        for (side, end, inwards) in [(from, 0.0, 1.0), (to, 50.0, -1.0)] {
            let apart = |frames: f64| {
                let there = picture(&renderer, &between, end + frames).unwrap();
                difference(&there, &picture(&renderer, side, frames).unwrap())
            };
            assert_eq!(apart(0.0), 0.0);
            let (near, far) = (apart(inwards * 0.25), apart(inwards));
            assert!(far < 0.02 && near < far / 8.0 + 1e-5, "end {end}: {near} {far}");
        }
    }
}

/// Pairs without steps: with common parts, waves, noise and other commutative order, with nothing in common.
const SMOOTH: [[&str; 2]; 4] = [
    ["(+ .5 (* .4 (sin (+ x z))))", "(+ .5 (* .3 (sin (+ (wave 1 .7) (* 2 x)))))"],
    ["(hsv-to-rgb (vector (* .2 z) .7 (+ .5 (* .3 (bw-noise .5 2)))))", "(vector .5 (cos (* y z)) (bw-noise .5 2))"],
    ["(+ .5 (* .4 (warped-bw-noise x y .6 3)))", "(+ .5 (* .4 (warped-bw-noise x (+ y z) .6 4)))"],
    ["(color-grad x 1 z #(.1 .2 .3) #(.8 .6 .7))", "(+ .3 (* .2 (color-noise 1.5 1)))"],
];

#[test]
fn a_genetic_dissolve_meets_both_loops_in_value_and_in_speed() {
    let renderer = Renderer::new(2);
    for [from, to] in SMOOTH {
        let loops = [turning(from, 40.0), turning(to, 64.0)];
        let between = Transition::new(&loops[0], &loops[1], 50.0);
        for (side, end, inwards) in [(0, 0.0, 1.0), (1, 50.0, -1.0)] {
            // If the speeds meet, the difference falls with the square of the distance from the end.
            let apart = |frames: f64| {
                let images = [(&between as &dyn Moving, end + frames), (&loops[side], frames)];
                let [there, here] = images.map(|(motion, frame)| picture(&renderer, motion, frame).unwrap());
                difference(&there, &here)
            };
            let (near, far) = (apart(inwards * 0.25), apart(inwards));
            assert!(far < 0.02 && near < far / 8.0 + 1e-5, "{from} to {to}, end {end}: {near} {far}");
        }
        let middle = picture(&renderer, &between, 25.0).unwrap();
        assert!(loops.iter().all(|side| difference(&middle, &picture(&renderer, side, 0.0).unwrap()) > 0.05));
    }
}

#[test]
fn a_genetic_dissolve_of_equal_genomes_is_the_loop() {
    let renderer = Renderer::new(2);
    for [text, _] in SMOOTH {
        let turning = turning(text, 40.0);
        let between = Transition::new(&turning, &turning, 40.0);
        assert_eq!(between.shared(), 1.0);
        for frame in [0.0, 7.0, 20.0, 33.3] {
            let images = [&between as &dyn Moving, &turning].map(|motion| picture(&renderer, motion, frame).unwrap());
            assert!(difference(&images[0], &images[1]) < 1e-4, "{text}, frame {frame}");
        }
    }
}

#[test]
fn what_is_shared_is_found_in_either_order_and_seeds_are_never_between() {
    let shared = |from: &str, to: &str| Transition::new(&turning(from, 9.0), &turning(to, 9.0), 9.0).shared();
    assert_eq!(shared("(+ (sin x) (abs y))", "(+ (abs y) (sin x))"), 1.0);
    assert_eq!(shared("(- (sin x) (abs y))", "(- (abs y) (sin x))"), 0.2);
    assert_eq!(shared("(bw-noise .3 1)", "(bw-noise .5 1)"), 1.0);
    assert_eq!(shared("(bw-noise .3 1)", "(bw-noise .3 2)"), 0.0);
    // Trying every order of every sum anew would take 4^60 comparisons.
    let chain = |leaf: &str| (0..60).fold(leaf.to_owned(), |inner, _| format!("(+ x {inner})"));
    assert!(shared(&chain("y"), &chain("z")) > 0.9);
}

#[test]
fn phases_of_waves_go_the_shorter_way_round() {
    let ends = [0.1, 0.9].map(|phase| turning(&format!("(wave 1 {phase})"), 40.0));
    let between = Transition::new(&ends[0], &ends[1], 40.0);
    // A quarter of the way: a quarter turn, and the phase 0.1 - 0.2 * 0.15625.
    let Still::Number(wave) = between.still(10.0, 0.0) else { unreachable!("a wave is a number at a moment") };
    let expected = (std::f32::consts::TAU * (0.25 + 0.1 - 0.2 * 0.15625)).sin();
    assert!((wave - expected).abs() < 1e-5, "{wave} {expected}");
}
