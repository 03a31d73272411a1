//! What pictures are, and what they do not depend on.

#![allow(clippy::float_cmp, reason = "what is calculated once is equal to the bit")]

use crate::bred;
use crate::drawing::Renderer;
use expression::{Argument, FUNCTIONS, Function, Genome, Loop, Node, Samples, Settings, Transition, Wants, cost};
use species::Image;

const SMALL: Settings = Settings { size: [64, 36], samples: Samples::Adaptive, is_blurred: true };

fn turning(text: &str) -> Loop {
    Loop::new(&Genome::from(Node::parse(text).unwrap()), 60.0)
}

fn drawn(text: &str) -> Image {
    Renderer::new(2).render(&turning(text), 3.0, &SMALL).unwrap()
}

/// FNV-1a over the bits of all channels.
fn checksum(image: &Image) -> u64 {
    let bytes = image.pixels.as_flattened().iter().flat_map(|light| light.to_bits().to_le_bytes());
    bytes.fold(0xcbf2_9ce4_8422_2325, |sum, byte| (sum ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3))
}

/// The expressions of figure 4 and the parent of figure 5 in Sims's paper, with the checksums of their pictures, which were
/// looked at.
const FIGURES: [(&str, u64); 10] = [
    ("x", 1_372_916_496_078_651_045),
    ("y", 3_231_523_208_822_300_709),
    ("(abs x)", 10_365_981_525_508_287_413),
    ("(mod x (abs y))", 18_028_172_554_331_558_459),
    ("(and x y)", 7_041_236_359_396_344_005),
    ("(bw-noise .2 2)", 17_468_233_606_822_458_749),
    ("(color-noise .1 2)", 3_289_320_102_792_464_914),
    ("(grad-direction (bw-noise .15 2) .0 .0)", 9_521_782_451_441_302_070),
    ("(warped-color-noise (* x .2) y .1 2)", 13_749_394_156_666_363_671),
    (
        "(warped-color-noise (warped-bw-noise (dissolve x 2.53 y) z 0.09 12.0) (invert z) 0.05 -2.06)",
        3_122_043_998_507_908_458,
    ),
];

#[test]
fn the_papers_figures_are_the_pictures_that_were_looked_at() {
    let found = FIGURES.map(|(text, _)| (text, checksum(&drawn(text))));
    assert_eq!(found, FIGURES);
}

#[test]
fn pixels_are_the_same_for_any_number_of_threads() {
    // No side is a whole number of tiles.
    let settings = Settings { size: [131, 70], ..SMALL };
    for text in FIGURES
        .iter()
        .map(|(text, _)| (*text).to_owned())
        .chain((0..6).map(|seed| bred::genome(seed).picture.to_string()))
    {
        let turning = turning(&text);
        let draw = |threads| checksum(&Renderer::new(threads).render(&turning, 3.0, &settings).unwrap());
        let alone = draw(1);
        assert_eq!([draw(2), draw(7)], [alone; 2], "{text}");
    }
}

/// Every function, in the order of the table, and the checksum of a picture of it: the same on every processor.
const CALLS: [(&str, u64); 41] = [
    ("+", 12_550_102_968_053_268_105),
    ("-", 4_829_697_699_373_310_679),
    ("*", 13_917_962_542_639_854_631),
    ("/", 809_401_571_146_121_983),
    ("max", 6_260_165_541_553_166_049),
    ("min", 10_661_959_515_747_020_824),
    ("abs", 6_025_693_170_007_256_309),
    ("invert", 5_825_746_714_747_144_117),
    ("mod", 15_722_565_988_969_247_427),
    ("round", 5_574_457_813_096_506_375),
    ("expt", 6_438_300_543_095_474_740),
    ("log", 6_028_358_707_632_655_162),
    ("sin", 6_216_676_289_160_155_893),
    ("cos", 18_267_214_658_544_011_461),
    ("atan", 12_883_790_801_168_713_047),
    ("and", 3_696_896_753_151_026_285),
    ("or", 13_318_075_533_628_929_132),
    ("xor", 11_115_798_545_575_420_621),
    ("if", 12_664_075_004_885_583_285),
    ("dissolve", 3_042_901_797_301_868_393),
    ("vector", 14_237_415_622_790_717_077),
    ("hsv-to-rgb", 5_286_892_872_031_587_613),
    ("rotate-vector", 3_218_325_024_205_987_629),
    ("transform-vector", 9_109_113_117_184_848_804),
    ("color-grad", 14_059_633_621_140_740_411),
    ("bw-noise", 556_712_100_212_029_911),
    ("color-noise", 15_896_557_430_572_682_446),
    ("warped-bw-noise", 5_083_671_289_531_120_513),
    ("warped-color-noise", 13_499_840_036_142_086_921),
    ("cell", 12_059_731_625_094_742_350),
    ("grad-mag", 14_484_672_628_448_205_357),
    ("grad-direction", 5_200_400_166_027_363_268),
    ("bump", 15_975_771_839_857_700_243),
    ("warp-by-grad", 7_739_730_902_779_562_325),
    ("blur", 1_787_558_263_981_930_269),
    ("band-pass", 3_881_612_699_715_327_725),
    ("ifs", 2_154_794_927_136_048_603),
    ("warped-ifs", 17_425_632_494_607_342_085),
    ("escape", 2_370_172_030_727_937_924),
    ("warp-abs", 12_107_294_906_110_890_533),
    ("warp-rel", 6_106_582_479_843_910_165),
];

#[test]
fn every_function_has_the_picture_that_it_had_and_none_is_as_another() {
    let renderer = Renderer::new(2);
    let mut seen = Vec::new();
    for function in FUNCTIONS {
        let arguments = ["(sin (* 3 x))", "(+ .6 y)", ".7", "(- .4 x)", ".9", ".3", "(* .5 y)", ".8"];
        let arguments: Vec<&str> = arguments.iter().cycle().take(function.arguments.len()).copied().collect();
        let text = format!("({} {})", function.name, arguments.join(" "));
        let image = renderer.render(&turning(&text), 3.0, &SMALL).unwrap();
        let flat = image.pixels.as_flattened();
        assert!(flat.iter().any(|light| (light - flat[0]).abs() > 0.05), "{text} is flat");
        seen.push((function.name, checksum(&image)));
    }
    assert_eq!(seen, CALLS);
    let mut sums: Vec<u64> = seen.into_iter().map(|(_, sum)| sum).collect();
    sums.sort_unstable();
    assert!(sums.windows(2).all(|pair| pair[0] != pair[1]), "two functions have the same picture");
}

/// Of a genetic dissolve, half way: numbers, vectors and phases between both, and results that are dissolved.
const HALF_WAY: u64 = 3_552_121_107_704_409_673;

#[test]
fn half_way_between_two_expressions_is_the_picture_that_it_was() {
    let [from, to] = [
        "(hsv-to-rgb (vector (warped-bw-noise x (wave 1 .25) .4 7) .8 (abs (sin (* 3 y)))))",
        "(hsv-to-rgb (vector (warped-bw-noise y (wave 1 .75) .6 7) (cell x y .5 3) (abs (sin (* 5 (+ x y))))))",
    ]
    .map(turning);
    let between = Transition::new(&from, &to, 40.0);
    assert!(between.shared() > 0.5 && between.shared() < 1.0);
    assert_eq!(checksum(&Renderer::new(2).render(&between, 20.0, &SMALL).unwrap()), HALF_WAY);
}

#[test]
fn a_scalar_is_grey_and_a_vector_red_green_and_blue_and_either_becomes_the_other() {
    let [grey, colour] = ["(+ .5 (* .2 x))", "(vector .2 .5 (+ .5 (* .2 x)))"].map(drawn);
    assert!(grey.pixels.iter().all(|[red, green, blue]| red == green && green == blue));
    assert!(
        colour.pixels.iter().zip(&grey.pixels).all(|(a, b)| (a[0] - 0.2).abs() < 1e-6 && (a[2] - b[2]).abs() < 1e-6)
    );
    let mean = drawn("(vector #(.2 .5 .8) (+ #(.1 .2 .3) .2) .5)").pixels[0];
    assert!(mean.iter().zip([0.5, 0.4, 0.5]).all(|(found, wanted)| (found - wanted).abs() < 1e-6), "{mean:?}");
}

#[test]
fn the_usual_frame_has_y_up_from_minus_one_and_a_map_moves_and_scales_it() {
    // A pixel is 2/36 high; the first one's middle is half of that away from the edge.
    let image = drawn("(vector (/ (+ x 2) 4) (/ (+ y 2) 4) 0)");
    let [red, green, _] = image.pixels[0];
    let expected = [(2.0 - (64.0 / 36.0 - 1.0 / 36.0)) / 4.0, (2.0 + 35.0 / 36.0) / 4.0];
    assert!((red - expected[0]).abs() < 0.003 && (green - expected[1]).abs() < 0.003, "{red} {green} {expected:?}");
    let mapped =
        Genome::parse("(expression 1 (map (scale .1) (center .5 .25)) (picture (vector x (+ .5 y) 0)))").unwrap();
    let image = Renderer::new(1).render(&Loop::new(&mapped, 9.0), 0.0, &SMALL).unwrap();
    let [red, green, _] = image.pixels[18 * 64 + 32];
    assert!((red - 0.5).abs() < 0.01 && (green - 0.75).abs() < 0.01, "{red} {green}");
}

/// A picture of 256 samples a pixel: one sample of each pixel of eight times the size, under a tent.
fn truth(renderer: &Renderer, turning: &Loop, [width, height]: [u32; 2]) -> Vec<[f64; 3]> {
    let settings = Settings { size: [8 * width, 8 * height], samples: Samples::One, is_blurred: true };
    let fine = renderer.render(turning, 3.0, &settings).unwrap();
    let tent = |at: usize| 1.0 - ((at as f64 + 0.5) / 8.0 - 1.0).abs();
    let pixel = |column: usize, row: usize| {
        let mut sum = [0.0; 3];
        for (down, right) in (0..16).flat_map(|down| (0..16).map(move |right| (down, right))) {
            let light = fine.pixels[(8 * row + down - 4) * fine.width + 8 * column + right - 4];
            let weight = tent(down) * tent(right) / 64.0;
            sum.iter_mut().zip(light).for_each(|(sum, light)| *sum += weight * f64::from(light));
        }
        sum
    };
    // The outermost pixels would need samples beyond the edge.
    let inside = |row: usize| (1..width as usize - 1).map(move |column| (column, row));
    (1..height as usize - 1).flat_map(inside).map(|(column, row)| pixel(column, row)).collect()
}

#[test]
fn samples_are_as_good_as_256_of_every_pixel() {
    let renderer = Renderer::new(2);
    let texts = [
        "(if (- (mod (* 2 (+ x y)) 1) .5) .8 .2)",
        "(round (+ .5 (* .5 (sin (* 9 (* x y))))) .2)",
        "(cell x y .3 4)",
        "(color-grad (warped-bw-noise x y .6 1) 3 0 #(.1 0 .3) #(1 .8 .3))",
        "(mod (* 2 x) (+ 1 (abs y)))",
        "(vector (bw-noise .3 1) (sin (* 20 (* x x))) (abs (atan y x)))",
        "(hsv-to-rgb (vector (warped-bw-noise x (* y z) .4 7) .8 (abs (sin (* 3 y)))))",
        "(bump (cell x y .4 4) #(.8 .6 .3) .6 #(1 1 .9) #(.1 .1 .2) .5 .5 .7)",
        "(color-grad (escape x y -.8 (* .2 z)) 3 z #(.1 0 .3) #(1 .8 .3))",
        "(warp-by-grad (color-noise .5 1) (bw-noise .4 2) .5)",
        "(rotate-vector (color-noise .5 1) z #(1 1 1))",
        "(ifs .5 .5 -.5 .5 -.5 0 .5 -.5 .5 .5 .5 0 0 0 1 20)",
        "(grad-direction (bw-noise .5 2) 0 0)",
        "(and x y)",
        "(mod x (+ .5 (abs y)))",
        "(max (invert (* 2 (abs x))) (- .7 (abs y)))",
        "(if (- .5 (+ (* x x) (* y y))) #(.9 .3 .1) #(.1 .2 .4))",
        "(blur (round (color-noise .5 1) .5) .05)",
        "(expt (abs x) (+ 1 (abs y)))",
        "(dissolve (sin (* 9 x)) (cos (* 9 y)) (+ .5 (* .5 (bw-noise .7 3))))",
    ];
    for text in texts {
        // So long a loop that nothing moves while the shutter is open.
        let turning = Loop::new(&Genome::from(Node::parse(text).unwrap()), 1e6);
        let truth = truth(&renderer, &turning, [96, 54]);
        let image = renderer
            .render(&turning, 3.0, &Settings { size: [96, 54], samples: Samples::Adaptive, is_blurred: true })
            .unwrap();
        let inside = (1..53).flat_map(|row| &image.pixels[row * 96 + 1..row * 96 + 95]);
        let errors = inside.zip(&truth).flat_map(|(a, b)| (0..3).map(|at| (f64::from(a[at]) - b[at]).powi(2)));
        let psnr = -10.0 * (errors.sum::<f64>() / (3 * truth.len()) as f64).log10();
        println!("{psnr:.1} dB: {text}");
        assert!(psnr >= 42.0, "{psnr:.1} dB: {text}");
    }
}

#[test]
fn motion_is_blurred_over_half_a_frame() {
    // An edge that goes from -0.5 to 0.5 in a loop of 60 frames; in a loop of 4 it is fifteen times as fast.
    let text = "(if (- x (* .5 z)) 1 0)";
    let renderer = Renderer::new(1);
    let width = |frames: f64| {
        let turning = Loop::new(&Genome::from(Node::parse(text).unwrap()), frames);
        let image = renderer.render(&turning, 0.0, &SMALL).unwrap();
        image.pixels[..64].iter().filter(|pixel| (0.02..0.98).contains(&pixel[0])).count()
    };
    assert!(width(4.0) >= width(60.0) + 3, "{} {}", width(4.0), width(60.0));
}

#[test]
fn what_a_frame_costs_is_known_before() {
    let settings = Settings { size: [1280, 720], samples: Samples::Adaptive, is_blurred: true };
    let of = |text: &str| cost(&turning(text), 0.0, &settings).unwrap();
    let (noise, twice) = (of("(bw-noise .3 1)"), of("(+ (bw-noise .3 1) (bw-noise .3 2))"));
    assert_eq!(noise.samples, [16 * 1280 * 720, 64 * 1280 * 720]);
    assert!((2 * 12 * 1280 * 720..25 * 1280 * 720).contains(&noise.bytes), "{noise:?}");
    let least = of("x").ns_per_sample;
    assert!(noise.ns_per_sample > least + 3.0);
    assert!(twice.ns_per_sample - least > 2.0 * (noise.ns_per_sample - least));
    assert!(twice.bytes_per_thread > noise.bytes_per_thread);
    assert_eq!(of("(sin (+ z 2))").ns_per_sample, least);
}

/// Every function with every one of its arguments: the text of a call in which that argument is `{}`.
fn calls() -> Vec<(String, Argument)> {
    let others = ["(sin (+ x y))", "(+ .6 y)", ".7", "(- .4 x)", ".9", ".3", "(* .5 y)", ".8"];
    let call = |function: &Function, at: usize| {
        let mut arguments: Vec<&str> = others.iter().cycle().take(function.arguments.len()).copied().collect();
        arguments[at] = "{}";
        (format!("({} {})", function.name, arguments.join(" ")), function.arguments[at])
    };
    FUNCTIONS.iter().flat_map(|function| (0..function.arguments.len()).map(move |at| call(function, at))).collect()
}

#[test]
fn arguments_are_converted_as_the_table_says() {
    let renderer = Renderer::new(2);
    let draw = |call: &str, argument: &str| {
        let turning = turning(&call.replace("{}", argument));
        checksum(&renderer.render(&turning, 3.0, &Settings { samples: Samples::One, ..SMALL }).unwrap())
    };
    for (call, argument) in calls() {
        let [scalar, vector] = match argument.wants {
            Wants::Any | Wants::Vector => ["(* .5 y)", "(vector (* .5 y) (* .5 y) (* .5 y))"],
            Wants::Scalar | Wants::Seed | Wants::Size => ["(* (+ (+ x .5) y) (/ 1 3))", "(vector x .5 y)"],
        };
        assert_eq!(draw(&call, scalar), draw(&call, vector), "{call}");
    }
}

#[test]
fn arguments_are_evaluated_as_often_as_the_table_says() {
    let settings = Settings { samples: Samples::One, ..SMALL };
    let ns = |text: &str| cost(&turning(text), 3.0, &settings).unwrap().ns_per_sample;
    let noise = ns("(bw-noise .3 7)") - ns("x");
    for (call, argument) in calls() {
        let times = ((ns(&call.replace("{}", "(bw-noise .3 7)")) - ns(&call.replace("{}", "x"))) / noise).round();
        // Two blurs share their middle.
        let is_as_told = (argument.times - argument.times / 18..=argument.times).contains(&(times as u32));
        assert!(is_as_told, "{call}: {times} times, not {}", argument.times);
    }
}

#[test]
fn every_pixel_is_at_its_place_though_no_side_is_a_whole_number_of_tiles() {
    let turning = turning("(vector (/ (+ x 2) 4) (/ (+ y 2) 4) .5)");
    for [width, height] in [[67, 41], [1, 1], [33, 100]] {
        let settings = Settings { size: [width, height], samples: Samples::One, is_blurred: true };
        let image = Renderer::new(3).render(&turning, 3.0, &settings).unwrap();
        let half = height as f32 / 2.0;
        for (number, [red, green, _]) in image.pixels.iter().enumerate() {
            let (column, row) = (number as u32 % width, number as u32 / width);
            let x = (column as f32 + 0.5 - width as f32 / 2.0) / half;
            let y = (half - row as f32 - 0.5) / half;
            let is_there = (red - (x + 2.0) / 4.0).abs() < 1e-5 && (green - (y + 2.0) / 4.0).abs() < 1e-5;
            assert!(is_there, "{column} {row} of {width} by {height}: {red} {green}");
        }
    }
}
