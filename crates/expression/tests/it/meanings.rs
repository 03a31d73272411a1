//! What functions mean that are more than a formula of their arguments: each on an image whose values are known.

use std::f32::consts::{FRAC_1_SQRT_2, TAU};

use crate::drawing::Renderer;
use expression::{Genome, Loop, Node, Samples, Settings};

const SIZE: [u32; 2] = [64, 36];
/// Light of a value of 1, beside a half: so that all values are seen that are tried.
const UNIT: f32 = 0.1;

/// The values of an expression at every pixel's middle, each with its x and y.
fn values(text: &str) -> Vec<([f32; 2], [f32; 3])> {
    let shown = Node::parse(&format!("(+ .5 (* {UNIT} {text}))")).unwrap();
    let settings = Settings { size: SIZE, samples: Samples::One, is_blurred: false };
    let image = Renderer::new(1).render(&Loop::new(&Genome::from(shown), 60.0), 0.0, &settings).unwrap();
    let half = SIZE.map(|side| side as f32 / 2.0);
    let place = |at: usize| {
        let [right, down] = [at % image.width, at / image.width].map(|pixel| pixel as f32 + 0.5);
        [(right - half[0]) / half[1], (half[1] - down) / half[1]]
    };
    image.pixels.iter().enumerate().map(|(at, light)| (place(at), light.map(|light| (light - 0.5) / UNIT))).collect()
}

/// Asserts that an expression has these values.
fn is(text: &str, wants: impl Fn(f32, f32) -> [f32; 3]) {
    for ([x, y], found) in values(text) {
        let wants = wants(x, y);
        let is_near = found.iter().zip(wants).all(|(found, wants)| (found - wants).abs() < 2e-3);
        assert!(is_near, "{text} at {x} {y} is {found:?}, not {wants:?}");
    }
}

#[test]
fn rotate_vector_turns_by_the_right_hand_about_the_third() {
    is("(rotate-vector #(1 0 0) .25 #(0 0 1))", |_, _| [0.0, 1.0, 0.0]);
    is("(rotate-vector #(0 1 0) .25 #(1 0 0))", |_, _| [0.0, 0.0, 1.0]);
    is("(rotate-vector #(0 0 1) .25 #(0 1 0))", |_, _| [1.0, 0.0, 0.0]);
    // The length of the axis does not count, and what lies along it stays.
    is("(rotate-vector #(.3 .2 .5) .25 #(0 0 7))", |_, _| [-0.2, 0.3, 0.5]);
    is("(rotate-vector #(.3 .2 .5) x #(0 0 1))", |x, _| {
        let (sine, cosine) = (TAU * x).sin_cos();
        [0.3 * cosine - 0.2 * sine, 0.3 * sine + 0.2 * cosine, 0.5]
    });
}

#[test]
fn transform_vector_is_a_matrix_that_its_seed_chooses() {
    let column = |vector: &str, seed: u32| values(&format!("(transform-vector {vector} {seed})"))[0].1;
    let columns = ["#(1 0 0)", "#(0 1 0)", "#(0 0 1)"].map(|vector| column(vector, 4));
    is("(transform-vector (vector x y .5) 4)", |x, y| {
        [0, 1, 2].map(|row| x * columns[0][row] + y * columns[1][row] + 0.5 * columns[2][row])
    });
    assert!(columns.as_flattened().iter().all(|factor| factor.abs() <= 1.001), "{columns:?}");
    let mut factors = columns.as_flattened().to_vec();
    factors.sort_by(f32::total_cmp);
    assert!(factors.windows(2).all(|pair| pair[1] - pair[0] > 1e-4), "{columns:?} has two equal factors");
    assert!((column("#(1 0 0)", 5)[0] - columns[0][0]).abs() > 1e-4);
}

#[test]
fn color_grad_goes_from_the_first_colour_to_the_second_and_back_for_each_unit_of_the_image_times_its_waves() {
    is("(color-grad x 2 .25 #(.1 .2 .3) #(.9 .4 1))", |x, _| {
        let part = 0.5 - 0.5 * (TAU * (2.0 * x + 0.25)).cos();
        [0.1 + 0.8 * part, 0.2 + 0.2 * part, 0.3 + 0.7 * part]
    });
    is("(color-grad 0 3 0 #(.1 .2 .3) #(.9 .4 1))", |_, _| [0.1, 0.2, 0.3]);
    is("(color-grad .5 3 0 #(.1 .2 .3) #(.9 .4 1))", |_, _| [0.9, 0.4, 1.0]);
}

#[test]
fn grad_mag_is_how_steep_an_image_is_in_both_directions() {
    is("(grad-mag x)", |_, _| [1.0; 3]);
    is("(grad-mag (- 1 y))", |_, _| [1.0; 3]);
    is("(grad-mag (+ (* .6 x) (* .8 y)))", |_, _| [1.0; 3]);
    is("(grad-mag (* x y))", |x, y| [x.hypot(y); 3]);
    is("(grad-mag .7)", |_, _| [0.0; 3]);
}

#[test]
fn grad_direction_is_bright_where_an_image_rises_towards_the_light() {
    // Of a slope of 1, which is not quite steep.
    let full = 0.5 / 1.01_f32.sqrt();
    is("(grad-direction x 0 0)", |_, _| [0.5 + full; 3]);
    is("(grad-direction x .25 0)", |_, _| [0.5; 3]);
    is("(grad-direction y .25 .1)", |_, _| [0.6 + full; 3]);
    is("(grad-direction y .75 0)", |_, _| [0.5 - full; 3]);
}

#[test]
fn bump_is_lit_on_the_side_that_faces_the_light() {
    let bump = |height: &str, light: &str| format!("(bump {height} #(.5 .5 1) 1 #(1 .5 1) #(.1 .1 .2) {light})");
    let (lit, shade) = ([0.55, 0.3, 1.2], [0.05, 0.05, 0.2]);
    // A flat surface from the front, and one that rises to the right from the left, and from behind it.
    is(&bump(".3", "0 0 2"), |_, _| lit);
    is(&bump("x", "-1 0 1"), |_, _| lit);
    is(&bump("x", "1 0 1"), |_, _| shade);
    is(&bump("y", "0 -3 3"), |_, _| lit);
    is(&bump("y", "0 3 3"), |_, _| shade);
    // As high as the first times the third.
    is("(bump x #(1 1 1) 0 #(1 1 1) #(0 0 0) 0 0 1)", |_, _| [1.0; 3]);
    is("(bump x #(1 1 1) -1 #(1 1 1) #(0 0 0) 1 0 1)", |_, _| [1.0; 3]);
}

#[test]
fn warp_by_grad_looks_up_the_slope_which_counts_as_at_most_1() {
    is("(warp-by-grad (vector x y 0) x .4)", |x, y| [x + 0.4 * FRAC_1_SQRT_2, y, 0.0]);
    is("(warp-by-grad (vector x y 0) (* -1 y) .4)", |x, y| [x, y - 0.4 * FRAC_1_SQRT_2, 0.0]);
    is("(warp-by-grad (vector x y 0) (* 400 y) .4)", |x, y| [x, y + 0.4, 0.0]);
}

#[test]
fn blur_is_the_mean_of_what_is_its_radius_around() {
    is("(blur (vector x y .3) .2)", |x, y| [x, y, 0.3]);
    // Of a parabola: half of the radius squared is added, in its own direction.
    is("(blur (vector (* x x) (* y y) (* x y)) .4)", |x, y| [x * x + 0.08, y * y + 0.08, x * y]);
}

#[test]
fn band_pass_is_a_blur_less_one_of_twice_the_radius() {
    is("(band-pass (vector x y .3) .2)", |_, _| [0.0; 3]);
    is("(band-pass (vector (* x x) (* y y) (* x y)) .4)", |_, _| [0.08 - 0.32, 0.08 - 0.32, 0.0]);
}

#[test]
fn warp_abs_looks_where_it_is_told_to() {
    is("(warp-abs (vector x y .3) (* 2 y) (* .5 x))", |x, y| [2.0 * y, 0.5 * x, 0.3]);
    is("(warp-abs (- x y) .7 .2)", |_, _| [0.5; 3]);
}

#[test]
fn warp_rel_looks_so_far_to_the_right_and_up() {
    is("(warp-rel (vector x y .3) .3 -.2)", |x, y| [x + 0.3, y - 0.2, 0.3]);
    is("(warp-rel (vector x y .3) y 0)", |x, y| [x + y, y, 0.3]);
    // What is within is looked at from there.
    is("(warp-rel (warp-rel x y 0) 0 .2)", |x, y| [x + y + 0.2; 3]);
}
