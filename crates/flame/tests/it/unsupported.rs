//! What is not drawn is named, and what is neutral changes no bit.
//!
//! Owns the claims on pictures of genomes of other programs. Which attributes are neutral is tested beside their tables.

use flame::{Backend, Filter, Flame, Flames, Genome, Image, RenderError, Renderer, Rng, Settings};
use species::{Breed, Genome as _};

const SMALL: Settings = Settings {
    size: Some([48, 32]),
    spp: Some(10.0),
    psnr: None,
    supersample: Some(1),
    temporal_samples: Some(1),
    filter: Filter::Variance,
    seed: 1,
    arithmetic: flame::Arithmetic::Fastest,
};

/// A flame with these attributes of its own and these of its first transform.
fn flame(own: &str, of_first: &str) -> Genome {
    let text = format!(
        "<flame size=\"48 32\" scale=\"16\" {own}><xform weight=\"1\" color=\"0\" linear=\"0.6\" coefs=\"0.6 0.2 -0.2 0.6 0.5 0\" \
         {of_first}/><xform weight=\"1\" color=\"1\" spherical=\"0.5\" coefs=\"0.5 0 0 0.5 -0.5 0.2\"/>\
         <color index=\"0\" rgb=\"255 128 64\"/><color index=\"255\" rgb=\"16 128 255\"/></flame>"
    );
    Genome::parse(&text).unwrap()
}

fn drawn(genome: &Genome) -> Result<Image, RenderError> {
    Renderer::new(1).unwrap().render(genome, 0.0, &SMALL)
}

#[test]
fn neutral_attributes_of_other_programs_change_no_bit() {
    let of_flame = "version=\"Apophysis 7X.15C\" cam_zoom=\"1.0\" cam_pitch=\"0.0\" \
                    background_ul=\"0.0 0.0 0.0\" post_symmetry_type=\"NONE\" post_symmetry_order=\"3\" \
                    overall_curve=\"0 0 0.3 0.3 1 1\" grad_edit_hue_curve_x1=\"23\"";
    let of_xform = "var_color=\"1\" linear_fx_priority=\"0\" color_type=\"DIFFUSION\" material=\"0.0\" \
                    weightCurve_enabled=\"false\" weightCurve_x1=\"9\" yzCoefs=\"1 0 0 1 0 0\" \
                    mirror_pre_post_translations=\"0\" wfield_type=\"NONE\" wfield_input=\"AFFINE\" waltz=\"0\" waltz_beat=\"3\"";
    assert_eq!(drawn(&flame(of_flame, of_xform)).unwrap(), drawn(&flame("", "")).unwrap());
}

#[test]
fn what_changes_a_picture_is_refused_in_loops_and_in_transitions() {
    let plain = Flame::new(flame("nick=\"ann\"", ""), Backend::default());
    let settings = species::Settings {
        size: [48, 32],
        spp: Some(10.0),
        psnr: None,
        supersample: Some(1),
        temporal_samples: Some(1),
        smooths: true,
        seed: 1,
    };
    for (own, of_first, name) in [
        ("sld_render_enabled=\"1\"", "", "solid rendering by `sld_render_enabled` (`1`, the flame)"),
        ("", "waltz=\"0.5\"", "the variation `waltz` (`0.5`, transform 0)"),
        ("", "falloff2=\"0.5\" falloff2_type=\"3\"", "this value of `falloff2_type` (`3`, transform 0)"),
        ("", "dc_linear=\"0.5\" var_color=\"0.3\"", "the colouring `var_color` (`0.3`, transform 0)"),
    ] {
        let odd = Flame::new(flame(own, of_first), Backend::default());
        let turning = odd.turning([48, 32], 30.0);
        let to = plain.transition(&odd, [48, 32], [30.0, 30.0], 12.0).unwrap();
        let from = odd.transition(&plain, [48, 32], [30.0, 30.0], 12.0).unwrap();
        for (what, motion) in [("a loop", turning), ("a transition to it", to), ("one from it", from)] {
            let refused = motion.demand(6.0, &settings).unwrap_err().to_string();
            assert_eq!(refused, format!("this renderer does not draw {name}"), "{what}");
        }
    }
    assert!(plain.turning([48, 32], 30.0).demand(6.0, &settings).is_ok());
}

#[test]
fn cells_at_other_places_are_drawn_and_named() {
    let places = |attributes: &str| flame("", attributes).unsupported();
    let moved = places("crackle=\"0.5\" crackle_distort=\"0.7\"");
    assert!(moved.refused.is_empty());
    assert_eq!(moved.without.to_string(), "the same places of cells for `crackle_distort` (`0.7`, transform 0)");
    assert_eq!(moved.without.0[0].why.word(), "places");
    for exact in ["crackle=\"0.5\" crackle_distort=\"0\"", "crackle=\"0\" crackle_distort=\"0.7\""] {
        assert!(places(exact).without.is_empty(), "{exact}");
    }
    assert!(drawn(&flame("", "crackle=\"0.5\" crackle_distort=\"0.7\"")).is_ok());
}

#[test]
fn a_marked_genome_draws_and_breeds_without_unknown_variations() {
    let plain = flame("", "");
    let odd = flame("", "waltz=\"0.5\" waltz_beat=\"3\"");
    assert!(matches!(drawn(&odd), Err(RenderError::Unsupported { .. })));
    let marked = Genome::parse(&odd.as_far_as_possible().to_xml()).unwrap();
    assert_eq!(drawn(&marked).unwrap(), drawn(&plain).unwrap());
    let other = flame("", "polka=\"1\"").as_far_as_possible();
    let mut rng = Rng::stream(3, 4);
    for (child, _) in (0..20).map(|_| marked.crossed(&other, &mut rng)) {
        let text = child.to_xml();
        assert!(["drawn_without", "waltz", "polka"].iter().all(|word| !text.contains(word)), "{text}");
    }
    let flames = Flames { backend: Backend::default(), coloured: Ok };
    let parent = Flame::new(marked, Backend::default());
    let (child, _) = flames.mutate(&parent, 0.5, &mut rng).expect("a child that may be shown");
    assert!(!child.text().contains("drawn_without"), "{}", child.text());
}
