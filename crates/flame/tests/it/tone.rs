//! Pictures have the tone of the program that wrote their genome.
//!
//! Owns the claims on JWildfire's and Fractorium's light, uneven palettes, tone curves and `cam_zoom`: how they look, how they are
//! written back, what lies between two of them.

#![allow(clippy::float_cmp, reason = "values are read, not computed")]

use flame::genome::Finish;
use flame::{Arithmetic, Filter, Genome, Image, KeyFrames, Loop, Motion, Renderer, Rng, Settings, Transition};

const SETTINGS: Settings = Settings {
    size: None,
    spp: Some(2000.0),
    psnr: None,
    supersample: Some(1),
    temporal_samples: Some(1),
    filter: Filter::None,
    seed: 1,
    arithmetic: Arithmetic::Fastest,
};

const JWILDFIRE: &str = "version=\"JWildfire V7.30 (27.11.2021)\"";
const BENT: &str = "overall_curve=\"0 0 0.3 0.1 0.7 0.9 1 1\" red_curve=\"0 0 1 0.5\"";

/// A disc of one colour, dense in its middle, whose flame has these attributes, too.
fn disc(attributes: &str) -> Genome {
    let own = ["gamma", "vibrancy", "brightness"].map(|name| attributes.contains(&format!(" {name}=")));
    let usual = [" gamma=\"4\"", " vibrancy=\"1\"", " brightness=\"2\""];
    let usual: String = usual.into_iter().zip(own).filter(|(_, own)| !own).map(|(usual, _)| usual).collect();
    let text = format!(
        "<flame size=\"200 150\" center=\"0 0\" scale=\"50\" quality=\"25\" filter=\"0.1\" gamma_threshold=\"0.01\" {usual} \
         {attributes}><xform weight=\"1\" color=\"0\" gaussian_blur=\"0.6\" coefs=\"1 0 0 1 0 0\"/>\
         <color index=\"0\" rgb=\"200 120 40\"/><color index=\"255\" rgb=\"200 120 40\"/></flame>"
    );
    Genome::parse(&text).unwrap()
}

fn draw(genome: &Genome) -> Image {
    Renderer::new(0).unwrap().render(genome, 0.0, &SETTINGS).unwrap()
}

/// The mean colour, of 255, of a ring of the disc from `from` to `from + 0.05`.
fn ring(image: &Image, from: f64) -> [f64; 3] {
    let mut sum = [0.0; 4];
    for (at, pixel) in image.pixels.iter().enumerate() {
        let [x, y] = [(at % 200) as f64 - 99.5, (at / 200) as f64 - 74.5];
        if (from..from + 0.05).contains(&(x.hypot(y) / 50.0)) {
            (0..3).for_each(|i| sum[i] += 255.0 * f64::from(pixel[i]));
            sum[3] += 1.0;
        }
    }
    [0, 1, 2].map(|i| sum[i] / sum[3])
}

/// Holds the rings of `disc`, drawn with `spp` samples a pixel, against their colours in the program that wrote it, of 255.
fn compare_rings(disc: &Genome, spp: f64, rings: [[f64; 3]; 3]) {
    let image = Renderer::new(0).unwrap().render(disc, 0.0, &Settings { spp: Some(spp), ..SETTINGS }).unwrap();
    // The programs round down.
    for (from, due) in [0.15, 0.4, 0.65].into_iter().zip(rings) {
        let found = ring(&image, from);
        let is_near = found.iter().zip(due).all(|(found, due)| (found - due - 0.5).abs() < 1.0 + 0.012 * due);
        assert!(is_near, "{}, ring {from}: {found:?}, {due:?} is due", disc.to_xml());
    }
}

/// The mean colours of blocks of 10 x 10 pixels.
fn blocks(image: &Image) -> Image {
    let (width, height) = (image.width / 10, image.height / 10);
    let mut pixels = vec![[0.0; 3]; width * height];
    for (at, pixel) in image.pixels.iter().enumerate() {
        let block = &mut pixels[at / image.width / 10 * width + at % image.width / 10];
        (0..3).for_each(|i| block[i] += pixel[i] / 100.0);
    }
    Image { width, height, pixels }
}

fn off(a: &Image, b: &Image) -> f64 {
    let pairs = a.pixels.as_flattened().iter().zip(b.pixels.as_flattened());
    pairs.map(|(a, b)| f64::from((a - b).abs())).fold(0.0, f64::max)
}

#[test]
fn a_jwildfire_genome_has_the_light_that_jwildfire_gives_it() {
    // The colours of three rings as JWildfire 9.00 renders them, of 255, with 1500 samples per pixel, or with 25.
    for (attributes, rings) in [
        ("", [[211.8, 127.1, 42.4], [162.7, 97.6, 32.6], [113.2, 67.9, 22.6]]),
        ("contrast=\"0.5\"", [[196.3, 117.7, 39.2], [156.9, 94.2, 31.4], [112.1, 67.2, 22.4]]),
        ("contrast=\"2.0\"", [[224.1, 134.5, 44.8], [166.4, 99.8, 33.2], [113.8, 68.3, 22.8]]),
        ("white_level=\"330.0\"", [[141.2, 84.7, 28.2], [108.5, 65.1, 21.7], [75.5, 45.3, 15.1]]),
        (
            "balancing_red=\"1.3\" balancing_green=\"0.5\"",
            [[255.0, 63.6, 42.4], [211.5, 48.8, 32.6], [147.3, 34.0, 22.7]],
        ),
        ("saturation=\"0.5\"", [[149.2, 127.1, 105.0], [114.0, 97.7, 81.4], [79.4, 67.9, 56.6]]),
        ("vibrancy=\"0.5\"", [[242.8, 184.0, 112.7], [186.6, 141.4, 86.6], [129.9, 98.4, 60.3]]),
        (
            "gamma=\"1\" brightness=\"1\" low_density_brightness=\"10\"",
            [[167.5, 100.5, 33.5], [58.8, 35.3, 11.8], [16.4, 9.8, 3.3]],
        ),
        (
            "gamma=\"1\" brightness=\"1\" low_density_brightness=\"-10\"",
            [[168.1, 100.9, 33.6], [57.8, 34.7, 11.5], [11.1, 6.7, 2.2]],
        ),
    ] {
        compare_rings(&disc(&format!("{JWILDFIRE} {attributes}")), 25.0, rings);
    }
}

#[test]
fn a_jwildfires_colour_is_the_nearest_entry_of_all_but_one_and_others_the_one_before() {
    // Whether the colour `place / 255` is entry `first` of the palette or one after it.
    let is_from = |version: &str, first: usize, place: f64| {
        let mut genome = disc(version);
        let colour = |entry: usize| if entry < first { [0.0, 255.0, 0.0, 255.0] } else { [255.0, 0.0, 0.0, 255.0] };
        genome.palette = Some(flame::genome::Palette::from_fn(colour));
        (genome.xforms[0].color, genome.xforms[0].color_speed) = (place / 255.0, 1.0);
        let [red, green, _] = ring(&draw(&genome), 0.15);
        red > green
    };
    // Entries that JWildfire 9.00 shows, none of them within a tenth of an edge.
    for (place, entry) in [(0.25, 0), (0.75, 1), (1.25, 1), (100.7, 100), (200.0, 199), (240.7, 240), (255.0, 254)] {
        assert!(is_from(JWILDFIRE, entry, place) && !is_from(JWILDFIRE, entry + 1, place), "{place}: {entry}");
    }
    assert!(!is_from("version=\"EMBER-LNX-1.0.0.19\"", 1, 0.75));
}

#[test]
fn samples_of_orbits_that_escape_count_in_jwildfire_alone() {
    let light = |version: &str, second: &str| {
        let mut genome = disc(version);
        genome.xforms.extend(Genome::parse(&format!("<flame>{second}</flame>")).unwrap().xforms);
        let image = draw(&genome);
        image.pixels.as_flattened().iter().map(|part| f64::from(*part)).sum::<f64>()
    };
    let to = |variation: &str, x: &str| {
        format!("<xform weight=\"0.25\" color=\"0\" {variation}=\"1\" coefs=\"1 0 0 1 {x} 0\"/>")
    };
    let (infinite, outside) = (to("exponential", "2000"), to("linear", "1000"));
    let near = |a: f64, b: f64| (a / b - 1.0).abs() < 0.003;
    assert!(near(light(JWILDFIRE, &infinite), light(JWILDFIRE, &outside)));
    assert!(near(light("", &infinite), light("", "")));
    assert!(!near(light("", &outside), light("", "")));
}

#[test]
fn many_samples_leave_no_light_of_their_own_to_pixels_that_have_few() {
    // JWildfire 9.00, too, draws the same with 400 samples per pixel, whatever the attribute says.
    for low_density in ["10", "-10", "0.24"] {
        let attributes = format!("gamma=\"1\" brightness=\"1\" low_density_brightness=\"{low_density}\"");
        let rings = [[167.7, 100.6, 33.5], [58.6, 35.2, 11.7], [13.9, 8.3, 2.8]];
        compare_rings(&disc(&format!("{JWILDFIRE} {attributes}")), 400.0, rings);
    }
}

#[test]
fn a_fractorium_genome_has_the_light_that_fractorium_gives_it() {
    // The same rings as its renderer, version 25, draws them with 2000 samples per pixel.
    for (attributes, rings) in [
        ("", [[239.2, 143.3, 47.5], [183.2, 109.8, 36.3], [127.7, 76.4, 25.1]]),
        ("gamma=\"1\" brightness=\"1\"", [[205.8, 123.2, 40.8], [70.8, 42.3, 13.8], [16.5, 9.6, 2.8]]),
        ("vibrancy=\"0.5\"", [[255.0, 197.9, 119.6], [201.6, 151.6, 91.6], [140.5, 105.6, 63.8]]),
    ] {
        compare_rings(&disc(&format!("version=\"EMBER-LNX-1.0.0.19\" {attributes}")), 2000.0, rings);
    }
}

#[test]
fn colours_of_an_uneven_palette_that_stand_still_are_seen_as_they_are() {
    let colours = |i: usize| format!("<color index=\"{i}\" rgb=\"{} 255 255\"/>", 255 * (i % 2));
    let colours: String = (0..256).map(colours).collect();
    for step in 0..8 {
        let part = f64::from(step) / 8.0;
        let text = format!(
            "<flame version=\"EMBER-WIN-1.0.0.19\" size=\"16 16\" scale=\"4\" brightness=\"0.5\" gamma=\"1\" \
             vibrancy=\"1\" palette_mode=\"linear\"><xform weight=\"1\" color=\"{}\" color_speed=\"1\" square=\"2\" \
             coefs=\"1 0 0 1 0 0\"/>{colours}</flame>",
            (100.0 + part) / 255.0
        );
        let [red, green, _] = draw(&Genome::parse(&text).unwrap()).pixels[8 * 16 + 8];
        let found = f64::from(red / green);
        assert!((found - part).abs() < 0.04, "{part} of the way to the next colour: {found}");
    }
}

#[test]
fn fractoriums_and_jwildfires_palettes_end_with_their_last_colour() {
    let picture = |version: &str| {
        let colour = |i| format!("<color index=\"{i}\" rgb=\"{0} {0} {0}\"/>", 255 * (i / 255));
        let colours = (0..256).map(colour).collect::<Vec<_>>().concat();
        let text = format!(
            "<flame version=\"{version}\" size=\"16 16\" scale=\"4\" brightness=\"40\"><xform weight=\"1\" color=\"0.998\" \
             color_speed=\"1\" gaussian_blur=\"1\" coefs=\"1 0 0 1 0 0\"/>{colours}</flame>"
        );
        let image = draw(&Genome::parse(&text).unwrap());
        image.pixels.as_flattened().iter().fold(0.0_f32, |most, light| most.max(*light))
    };
    assert!(picture("FLAM3-LNX-3.1.1") > 0.9, "256 c is the last colour");
    assert!(picture("EMBER-WIN-1.0.0.19") < 0.1 && picture("JWildfire V7.30") < 0.1, "255 c is the one before it");
}

#[test]
fn cam_zoom_multiplies_the_scale_and_leaves_the_samples() {
    let genome = disc("cam_zoom=\"2.5\"");
    assert_eq!((genome.camera.scale, genome.camera.zoom, genome.sampling.quality), (125.0, 0.0, 25.0));
    assert_eq!(disc("cam_zoom=\"1.0\"").camera, disc("").camera);
    assert_eq!(Genome::parse(&genome.to_xml()).unwrap(), genome);
}

#[test]
fn tone_curves_bend_the_light_that_comes_out_of_gamma() {
    let plain = draw(&disc(""));
    let bent = |curves: &str| draw(&disc(curves));
    let due = |by: fn(usize, f64) -> f64| {
        let pixel = |pixel: &[f32; 3]| [0, 1, 2].map(|i| by(i, f64::from(pixel[i])) as f32);
        Image { pixels: plain.pixels.iter().map(pixel).collect(), ..plain.clone() }
    };
    // Two points make a line; that of all channels comes first.
    let lines = bent(
        "overall_curve=\"0 0.2 1 0.8\" red_curve=\"1 0 0 1\" curves=\"0 0 1 0 0 1 1 1 1 1 1 1 0 0 1 0 0 1 1 1 1 1 1 1 \
         0 0 1 0 0 1 1 1 1 1 1 1 0 0 1 0 0 1 1 1 1 1 1 1\"",
    );
    let by_hand = due(|channel, x| if channel == 0 { 0.8 - 0.6 * x } else { 0.2 + 0.6 * x });
    assert!(off(&lines, &by_hand) < 1e-4, "{}", off(&lines, &by_hand));
    // With such x a Bezier curve is the polynomial of its heights.
    let straight = "0 0 1 0.25 0.25 1 0.75 0.75 1 1 1 1";
    let third = 1.0 / 3.0;
    let curves = format!("curves=\"{straight} {straight} 0 0 1 {third} 0.9 1 {} 0.9 1 1 1 1 {straight}\"", 2.0 * third);
    let by_hand = due(|channel, x| {
        let s = 1.0 - x;
        if channel == 1 { 2.7 * s * s * x + 2.7 * s * x * x + x * x * x } else { x }
    });
    let found = bent(&curves);
    assert!(off(&found, &by_hand) < 1e-4, "{}", off(&found, &by_hand));
    assert_eq!(disc(&format!("curves=\"{straight} {straight} {straight} {straight}\"")).finish, Finish::default());
}

#[test]
fn a_tone_that_is_written_back_reads_the_same() {
    let bezier = "curves=\"0 0 1 0.25 0.3 2 0.75 0.75 1 1 1 1 0 0 1 0 0 1 1 1 1 1 1 1 0 0 1 0 0 1 1 1 1 1 1 1 0 0 1 0 0 1 1 1 1 1 1 1\"";
    let genomes = [
        disc(""),
        disc("version=\"EMBER-LNX-1.0.0.19\""),
        disc(JWILDFIRE),
        disc(&format!(
            "{JWILDFIRE} contrast=\"0.8\" low_density_brightness=\"-2\" balancing_blue=\"1.2\" saturation=\"0.9\""
        )),
        disc(BENT),
        disc(bezier),
    ];
    for genome in &genomes {
        let again = Genome::parse(&genome.to_xml()).unwrap();
        assert_eq!(again, *genome);
        for other in &genomes {
            let way = Transition::new(&Loop::new(genome, 9.0), &Loop::new(other, 9.0), 9.0);
            let middle = way.at(4.0);
            assert_eq!(Genome::parse(&middle.to_xml()).unwrap().finish, middle.finish);
        }
    }
    assert_eq!(genomes[0].finish, Finish::default());
    assert!(!genomes[0].to_xml().contains("white_level"), "nothing of others is written into flam3's");
    assert!(genomes[1].finish != Finish::default() && genomes[2].finish != genomes[1].finish);
}

#[test]
fn a_tone_comes_in_without_a_jump_in_transitions_and_key_frames() {
    let jwildfire =
        format!("{JWILDFIRE} contrast=\"0.6\" low_density_brightness=\"-4\" white_level=\"300\" saturation=\"0.5\"");
    let ends = [disc(&format!("{jwildfire} time=\"0\"")), disc(&format!("{BENT} time=\"10\""))];
    let way = Transition::new(&Loop::new(&ends[0], 1e9), &Loop::new(&ends[1], 1e9), 10.0);
    let keys = KeyFrames::new(ends.to_vec()).unwrap();
    for motion in [&way as &dyn Motion, &keys] {
        let at = |time: f64| draw(&motion.at(time));
        for (end, near) in [(0.0, 1e-3), (10.0, 10.0 - 1e-3)] {
            // Noise is other noise where samples are lost in part; the light of blocks is not.
            let jump = off(&blocks(&at(end)), &blocks(&at(near)));
            assert!(jump < 2e-3, "{jump} at {end}");
        }
        let middle = motion.at(5.0).finish;
        assert!((middle.contrast - 0.8).abs() < 1e-9 && (middle.white_level - 250.0).abs() < 0.5, "{middle:?}");
    }
}

#[test]
fn a_child_has_the_tone_of_its_first_parent() {
    let rng = &mut Rng::stream(3, 1);
    let [first, second] = [format!("{JWILDFIRE} contrast=\"0.7\" {BENT}"), String::new()].map(|text| disc(&text));
    for _ in 0..20 {
        assert_eq!(first.crossed(&second, rng).0.finish, first.finish);
        assert_eq!(second.crossed(&first, rng).0.finish, second.finish);
        assert_eq!(first.mutated(1.0, rng).0.finish, first.finish);
    }
}

#[test]
fn a_tone_with_a_wrong_value_is_refused_by_its_name() {
    for (attribute, value, expected) in [
        ("contrast", "0", "a number above 0"),
        ("white_level", "-1", "a number above 0"),
        ("balancing_red", "x", "a number from 0 on"),
        ("low_density_brightness", "inf", "a finite number"),
        ("cam_zoom", "0", "a number above 0"),
        ("cam_zoom", "1e308", "stays a finite number"),
        ("red_curve", "0 0 0 1", "points `x y` of different x"),
        ("blue_curve", "0 0 1", "points `x y`"),
        ("curves", "0 0 1 1", "four curves of four points"),
    ] {
        let text = format!("<flame {JWILDFIRE} scale=\"50\" {attribute}=\"{value}\"/>");
        let refused = Genome::parse(&text).unwrap_err().to_string();
        assert!(refused.contains(&format!("`{attribute}` of `flame` is `{value}`")), "{refused}");
        assert!(refused.contains(expected), "{refused}");
    }
    let kept = Genome::parse("<flame version=\"FLAM3-LNX-3.1.1\" contrast=\"2\"/>").unwrap();
    assert_eq!((kept.finish, kept.extra.len()), (Finish::default(), 2), "flam3 has no contrast");
}

#[test]
fn a_background_of_one_colour_is_drawn_and_a_gradient_is_kept() {
    let corners = |last: &str| {
        let names = ["background_ul", "background_ur", "background_ll", "background_lr"];
        let same: String = names.map(|name| format!("{name}=\"0.5 0.2 0.1\" ")).concat();
        disc(&format!("{JWILDFIRE} {same} background_cc=\"{last}\""))
    };
    let plain = corners("0.5 0.2 0.1");
    assert_eq!(plain.tone.background, [0.5, 0.2, 0.1]);
    assert_eq!(plain.extra.len(), 1);
    assert_eq!(corners("0 0 0").extra.len(), 6);
}
