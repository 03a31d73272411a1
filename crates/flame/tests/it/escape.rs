//! Orbits that escape begin again in flam3's flames, and are lost in JWildfire's.
//!
//! Owns the claims on how many samples are left of them. `tone.rs` has what that does to light.

use flame::{Arithmetic, Filter, Genome, Measured, Renderer, Settings};

const JWILDFIRE: &str = "version=\"JWildfire V7.30 (27.11.2021)\"";

/// Samples of a picture: each orbit takes some thousand steps.
const SAMPLES: f64 = 20_000_000.0;

/// Draws `xforms` in a flame with these attributes.
fn draw(attributes: &str, xforms: &str, arithmetic: Arithmetic) -> Measured {
    draw_on(0, SAMPLES, attributes, xforms, arithmetic)
}

/// The same on so many threads, of which 0 are all.
fn draw_on(threads: usize, samples: f64, attributes: &str, xforms: &str, arithmetic: Arithmetic) -> Measured {
    let text = format!(
        "<flame size=\"80 50\" center=\"0 0\" scale=\"20\" filter=\"0.1\" {attributes}>{xforms}\
         <color index=\"0\" rgb=\"200 120 40\"/><color index=\"255\" rgb=\"40 120 200\"/></flame>"
    );
    let settings = Settings {
        spp: Some(samples / 4000.0),
        supersample: Some(1),
        temporal_samples: Some(1),
        filter: Filter::None,
        arithmetic,
        ..Settings::default()
    };
    Renderer::new(threads).unwrap().render_measured(&Genome::parse(&text).unwrap(), 0.0, &settings).unwrap()
}

/// The part of samples that are left of the flame's.
fn left(attributes: &str, xforms: &str) -> f64 {
    draw(attributes, xforms, Arithmetic::Fastest).samples as f64 / SAMPLES
}

/// A blurred disc that an orbit leaves for infinity in `entries` of 1,024 steps, and to which it does not come back: what
/// is no number stays none, however small the part of it that is added.
fn leaking(entries: u32) -> String {
    format!(
        "<xform weight=\"{}\" color=\"0\" gaussian_blur=\"0.5\" linear3D=\"1e-30\" coefs=\"1 0 0 1 0 0\"/>\
         <xform weight=\"{entries}\" color=\"1\" exponential=\"1\" coefs=\"1 0 0 1 2000 0\"/>",
        1024 - entries
    )
}

/// A blurred disc, e to the power of it and `shift` after as many steps in it as `chaos` says, and the way back to a blur of
/// its own.
fn returning(chaos: &str, shift: &str) -> String {
    format!(
        "<xform weight=\"1\" color=\"0\" gaussian_blur=\"0.5\" coefs=\"1 0 0 1 0 0\" chaos=\"{chaos}\"/>\
         <xform weight=\"1\" color=\"1\" exponential=\"1\" coefs=\"1 0 0 1 {shift} 0\" chaos=\"0 0 1\"/>\
         <xform weight=\"1\" color=\"1\" spherical=\"1\" gaussian_blur=\"0.3\" coefs=\"1 0 0 1 0 0\" chaos=\"1 0 0\"/>"
    )
}

#[test]
fn samples_are_lost_as_in_jwildfire_where_an_orbit_does_not_come_back() {
    // Parts of a disc's light that JWildfire 9.00 leaves of it.
    for (entries, due) in [(1, 0.653), (2, 0.425), (3, 0.299), (5, 0.172), (8, 0.094), (10, 0.067), (20, 0.021)] {
        for arithmetic in [Arithmetic::Fastest, Arithmetic::Reference] {
            let found = draw(JWILDFIRE, &leaking(entries), arithmetic).samples as f64 / SAMPLES;
            assert!((found / due - 1.0).abs() < 0.1, "{entries}: {found:.4} by {arithmetic:?} and not {due}");
        }
        let elsewhere = left("", &leaking(entries));
        assert!((elsewhere - 1.0 + f64::from(entries) / 1024.0).abs() < 1e-3, "{entries}: {elsewhere:.4}");
    }
}

#[test]
fn an_orbit_comes_back_from_where_f64_reaches_in_jwildfire_and_from_where_space_ends_in_flam3() {
    // 1e87 and 1e260, out of `f32`; `spherical` leads back from there.
    for (shift, is_left) in [("200", true), ("600", true), ("2000", false)] {
        let flame = returning("0 1 0", shift);
        let due = if is_left { 1.0 } else { 1.0 / 3.0 };
        let found = left(JWILDFIRE, &flame);
        assert!((found - due).abs() < 0.01, "{shift}: {found:.4}");
        assert!((left("", &flame) - 2.0 / 3.0).abs() < 0.01, "{shift}");
    }
}

#[test]
fn samples_are_lost_bit_by_bit_on_the_way_from_flam3_to_jwildfire() {
    let found: Vec<f64> =
        (0..=20).map(|part| left(&format!("lost_samples=\"{}\"", f64::from(part) / 20.0), &leaking(10))).collect();
    assert!(found.windows(2).all(|pair| pair[1] <= pair[0] && pair[1] > pair[0] / 3.0), "{found:.4?}");
}

#[test]
fn lost_orbits_are_the_same_bits_by_all_instruction_sets_and_on_any_number_of_threads() {
    // Two halves of two parts, that threads take as they come.
    let flame = returning("49 1 0", "200");
    let drawn = |threads, arithmetic| draw_on(threads, 4.0 * SAMPLES, JWILDFIRE, &flame, arithmetic);
    let fastest = drawn(0, Arithmetic::Fastest);
    assert_eq!(fastest, drawn(1, Arithmetic::Fastest));
    assert_eq!(fastest, drawn(1, Arithmetic::Avx2));
    assert_eq!(fastest, drawn(1, Arithmetic::Portable));
}
