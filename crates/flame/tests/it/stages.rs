//! Variations before and after the sum, several of a kind, several final transforms, and flames in space.
//!
//! Owns claims by pairs of genomes that are the same flame, said in two ways: files of other programs in one of them.

use flame::{Arithmetic, Filter, Genome, Image, Loop, Motion, Renderer, Settings, Transition};

const SETTINGS: Settings = Settings {
    size: Some([64, 48]),
    spp: Some(2000.0),
    psnr: None,
    supersample: Some(1),
    temporal_samples: Some(1),
    filter: Filter::None,
    seed: 5,
    arithmetic: Arithmetic::Fastest,
};

/// A flame whose second transform has these attributes; `more` is on the flame, and `last` follows the transforms.
fn flame(attributes: &str, more: &str, last: &str) -> Genome {
    let text = format!(
        "<flame size=\"64 48\" scale=\"12\" brightness=\"8\" {more}>\
         <xform weight=\"1\" color=\"0\" coefs=\"0.6 0.3 -0.4 0.5 0.5 0.2\" linear=\"1\"/>\
         <xform weight=\"1\" color=\"1\" coefs=\"0.7 -0.2 0.3 0.6 -0.4 0.3\" {attributes}/>{last}\
         <color index=\"0\" rgb=\"250 90 40\"/><color index=\"200\" rgb=\"60 80 240\"/></flame>"
    );
    Genome::parse(&text).unwrap()
}

fn drawn(motion: &dyn Motion, frame: f64, arithmetic: Arithmetic) -> Image {
    Renderer::new(2).unwrap().render(motion, frame, &Settings { arithmetic, ..SETTINGS }).unwrap()
}

fn picture(genome: &Genome) -> Image {
    drawn(genome, 0.0, Arithmetic::Fastest)
}

fn psnr(a: &Image, b: &Image) -> f64 {
    let pairs = a.pixels.as_flattened().iter().zip(b.pixels.as_flattened());
    let error: f64 = pairs.map(|(a, b)| f64::from(a - b).powi(2)).sum();
    -10.0 * (error / (3 * a.pixels.len()) as f64).log10()
}

#[test]
fn one_flame_said_in_two_ways_is_one_picture() {
    let identity = "<finalxform coefs=\"1 0 0 1 0 0\" color_speed=\"0\" linear=\"1\"/>";
    let bent = "<finalxform coefs=\"1 0 0 1 0 0\" color_speed=\"0\" curl=\"1\" curl_c1=\"0.4\"/>";
    let curl = "curl_c1=\"0.4\" curl_c2=\"0.2\"";
    let post_curl = "post_curl=\"1\" post_curl_c1=\"0.4\" post_curl_c2=\"0.2\"";
    for (name, one, other) in [
        ("post", flame(&format!("linear=\"1\" {post_curl}"), "", ""), flame(&format!("curl=\"1\" {curl}"), "", "")),
        (
            "pre",
            flame(&format!("linear=\"1\" {}", post_curl.replace("post_", "pre_")), "", ""),
            flame(&format!("curl=\"1\" {curl}"), "", ""),
        ),
        (
            "a post that runs in the sum",
            flame(&format!("linear=\"1\" {post_curl} post_curl_fx_priority=\"0\""), "", ""),
            flame(&format!("curl=\"1\" {curl}"), "", ""),
        ),
        (
            "a blur before the sum",
            flame("linear=\"1\" gaussian_blur=\"0.3\" gaussian_blur_fx_priority=\"-1\"", "", ""),
            flame("linear=\"1\" pre_blur=\"0.3\"", "", ""),
        ),
        ("Fractorium's name", flame("linear=\"1\" pre_gaussian_blur=\"0.3\"", "", ""), {
            flame("linear=\"1\" pre_blur=\"0.3\"", "", "")
        }),
        (
            "a pre of priority 0",
            flame("linear=\"1\" pre_blur=\"0.3\" pre_blur_fx_priority=\"0\"", "", ""),
            flame("linear=\"1\"", "", ""),
        ),
        ("two final transforms", flame("linear=\"1\"", "", &format!("{identity}{bent}")), {
            flame("linear=\"1\"", "", bent)
        }),
        ("a flat flame in space", flame("linear3D=\"1\"", "", ""), flame("linear=\"1\"", "", "")),
        (
            "nothing in the sum in Fractorium",
            flame("pre_curl=\"1\" pre_curl_c1=\"0.4\" post_bubble=\"1\"", "version=\"EMBER-WIN-22\"", ""),
            flame("linear=\"1\" pre_curl=\"1\" pre_curl_c1=\"0.4\" post_bubble=\"1\"", "version=\"EMBER-WIN-22\"", ""),
        ),
        ("z alone", flame("linear=\"1\" ztranslate=\"0.4\" zcone=\"0.3\" flatten=\"1\"", "", ""), {
            flame("linear=\"1\"", "", "")
        }),
        ("Mobius", flame("Mobius=\"1\" Mobius_Re_A=\"1\" Mobius_Re_D=\"2\"", "", ""), {
            flame("mobius=\"1\" mobius_re_a=\"1\" mobius_re_d=\"2\"", "", "")
        }),
    ] {
        // A blur of another name draws its random numbers in another order: the noise is another one.
        let least = if name == "a blur before the sum" { 30.0 } else { 100.0 };
        let found = psnr(&picture(&one), &picture(&other));
        assert!(found > least, "{name}: {found}");
        let again = Genome::parse(&one.to_xml()).unwrap();
        assert_eq!(again, one, "{name}, written and read");
    }
    let added = flame("sinusoidal=\"1\" spherical=\"0.2\" spherical_fx_priority=\"1\"", "", "");
    let plain = flame("sinusoidal=\"1\" spherical=\"0.2\"", "", "");
    assert!(psnr(&picture(&added), &picture(&plain)) < 30.0, "what is added after the sum sees the sum");
}

#[test]
fn two_of_a_kind_both_count() {
    let twice = flame("linear=\"0.6\" bubble=\"0.2\" bubble.2=\"0.3\"", "", "");
    let once = flame("linear=\"0.6\" bubble=\"0.5\"", "", "");
    assert_eq!(twice.xforms[1].variations.len(), 3);
    assert!(psnr(&picture(&twice), &picture(&once)) > 35.0);
}

#[test]
fn two_of_a_kind_in_different_stages_are_written_under_two_names() {
    for variations in [
        "bubble=\"0.3\" bubble_fx_priority=\"0\" bubble#1#=\"0.2\" bubble#1#_fx_priority=\"1\"",
        "bubble=\"0.3\" bubble_fx_priority=\"1\" bubble#1#=\"0.2\" bubble#1#_fx_priority=\"0\"",
        "bubble=\"0.3\" bubble_fx_priority=\"-1\" bubble#1#=\"0.2\" bubble#1#_fx_priority=\"1\"",
        "bubble=\"0.3\" bubble#1#=\"0.2\" bubble#1#_fx_priority=\"1\" bubble#2#=\"-0.1\" bubble#3#=\"0.1\" bubble#3#_fx_priority=\"1\"",
        "bubble#1#_fx_priority=\"1\" bubble_fx_priority=\"1\" bubble=\"0.3\" bubble#1#=\"-0.2\"",
        "linear=\"0.3\" linear#1#=\"0.2\" linear#1#_fx_priority=\"1\" rings2=\"0.1\" rings2_val=\"0.4\" rings2#1#=\"0.1\" rings2#1#_val=\"0.7\" rings2#1#_fx_priority=\"-1\"",
    ] {
        let genome = flame(variations, "version=\"JWildfire V7.30 (27.11.2021)\"", "");
        let again = Genome::parse(&genome.to_xml()).unwrap_or_else(|error| panic!("{variations}: {error}"));
        assert_eq!(again, genome, "{variations}");
        assert_eq!(again.to_xml(), genome.to_xml(), "{variations}");
    }
}

#[test]
fn a_tilted_plane_is_lower_and_a_camera_goes_round() {
    let straight = |more: &str| picture(&flame("linear=\"1\"", more, ""));
    let squeeze = |factor: f64| format!("<finalxform coefs=\"1 0 0 {factor} 0 0\" color_speed=\"0\" linear=\"1\"/>");
    let lower = picture(&flame("linear=\"1\"", "", &squeeze(0.5)));
    let tilt = std::f64::consts::FRAC_PI_3;
    assert!(psnr(&straight(&format!("cam_pitch=\"{tilt}\"")), &lower) > 35.0);
    let yaw = format!("cam_yaw=\"{}\"", 0.5_f64);
    let turned = format!("rotate=\"{}\"", -(0.5_f64.to_degrees()));
    assert!(psnr(&straight(&yaw), &straight(&turned)) > 35.0);
    let round = Loop::new(&flame("linear3D=\"1\" zcone=\"0.4\"", "cam_pitch=\"1\" cam_yaw_turns=\"1\"", ""), 40.0);
    let still = Loop::new(&flame("linear3D=\"1\" zcone=\"0.4\"", "cam_pitch=\"1\"", ""), 40.0);
    assert_eq!(drawn(&round, 0.0, Arithmetic::Fastest), drawn(&round, 40.0, Arithmetic::Fastest));
    let apart =
        |frame: f64| psnr(&drawn(&round, frame, Arithmetic::Fastest), &drawn(&still, frame, Arithmetic::Fastest));
    assert!(apart(0.0) > 100.0 && apart(10.0) < 30.0);
}

#[test]
fn a_jwildfires_picture_in_space_turns_about_the_origin_and_others_about_their_centre() {
    let seen = |more: &str| flame("linear=\"1\"", &format!("rotate=\"30\" {more}"), "");
    // Turned by 30 degrees, (0.3, -0.2) is at (0.3598, -0.0232).
    let (jwildfire, tilt) = ("version=\"JWildfire V7.30 (27.11.2021)\"", "cam_pitch=\"0.4\"");
    let its = seen(&format!("{jwildfire} {tilt} center=\"0.3598076 -0.0232051\""));
    let mine = seen(&format!("{jwildfire} {tilt} center=\"0.3 -0.2\" center_turns=\"1\""));
    assert_eq!((its.camera.center_turns, mine.camera.center_turns), (0.0, 1.0));
    assert!(psnr(&picture(&its), &picture(&mine)) > 40.0);
    for genome in [&its, &mine] {
        assert_eq!(Genome::parse(&genome.to_xml()).unwrap(), *genome);
    }
    for other in [seen(&format!("{jwildfire} center=\"0.3 -0.2\"")), seen(&format!("{tilt} center=\"0.3 -0.2\""))] {
        assert!((other.camera.center_turns - 1.0).abs() < 1e-9);
    }
    assert!(psnr(&picture(&seen(&format!("{jwildfire} {tilt} center=\"0.3 -0.2\""))), &picture(&mine)) < 30.0);
}

#[test]
fn a_jwildfires_depth_blur_is_on_one_side_unless_the_genome_says_otherwise() {
    let jwildfire = "version=\"JWildfire V7.30 (27.11.2021)\"";
    for (attributes, expected) in [
        (format!("{jwildfire} cam_dof=\"2\""), 1.0),
        (format!("{jwildfire} cam_dof=\"2\" dof_one_sided=\"0.25\""), 0.25),
        (format!("{jwildfire} cam_dof=\"2\" new_dof=\"1\""), 0.0),
        (jwildfire.to_owned(), 0.0),
        ("cam_dof=\"2\"".to_owned(), 0.0),
        ("cam_dof=\"2\" dof_one_sided=\"1\"".to_owned(), 1.0),
    ] {
        let genome = flame("linear3D=\"1\" zblur=\"1\"", &attributes, "");
        assert_eq!(genome.camera.pose.one_sided.to_bits(), f64::to_bits(expected), "{attributes}");
        assert_eq!(Genome::parse(&genome.to_xml()).unwrap(), genome, "{attributes}");
    }
    let refused =
        Genome::parse(&flame("linear=\"1\"", "", "").to_xml().replacen("<flame", "<flame dof_one_sided=\"2\"", 1));
    assert!(refused.unwrap_err().to_string().contains("a number from 0 to 1"));
}

#[test]
fn a_jwildfires_last_transform_colours_only_where_it_says_so() {
    // As JWildfire 9.00 draws a disc of colour 1 after a last transform of colour 0.
    let jwildfire = "version=\"JWildfire V7.30 (27.11.2021)\"";
    for (version, says, speed) in [
        (jwildfire, "", 0.0),
        (jwildfire, "color_type=\"DIFFUSION\"", 0.5),
        (jwildfire, "color_type=\"NONE\"", 0.0),
        ("", "", 0.5),
    ] {
        let last = format!("<finalxform color=\"0\" symmetry=\"0\" linear=\"1\" {says}/>");
        let genome = flame("linear=\"1\"", version, &last);
        assert!(
            (genome.finals[0].color_speed - speed).abs() < 1e-9,
            "{version} {says}: {:?}",
            genome.finals[0].color_speed
        );
        assert_eq!(Genome::parse(&genome.to_xml()).unwrap(), genome);
    }
}

#[test]
fn many_orbits_in_space_are_where_one_is() {
    let solid = flame(
        "linear3D=\"0.7\" bubble=\"0.4\" zblur=\"0.1\" post_zscale=\"0.5\"",
        "cam_pitch=\"0.7\" cam_yaw=\"0.4\" cam_persp=\"0.3\" cam_dof=\"0.5\" cam_roll=\"0.2\" cam_zpos=\"0.1\" cam_pos_x=\"0.2\" cam_pos_z=\"0.1\"",
        "<finalxform coefs=\"1 0 0 1 0.1 0\" color_speed=\"0.3\" linear3D=\"1\" opacity=\"0.8\"/>",
    );
    let many = drawn(&solid, 0.0, Arithmetic::Fastest);
    assert!(psnr(&many, &drawn(&solid, 0.0, Arithmetic::Reference)) > 35.0);
    assert_eq!(many, drawn(&solid, 0.0, Arithmetic::Portable));
}

#[test]
fn many_orbits_have_the_colours_that_one_has() {
    let last =
        "<finalxform coefs=\"1 0 0 1 0 0\" color_speed=\"0.2\" linear=\"0.5\" dc_linear=\"0.5\" opacity=\"0.7\"/>";
    let point = "post_point_symmetry_wf=\"1\" post_point_symmetry_wf_colorshift=\"0.3\"";
    let axis = "post_axis_symmetry_wf=\"0.5\" post_axis_symmetry_wf_x1colorshift=\"0.4\" \
                post_axis_symmetry_wf_x2colorshift=\"-0.3\" post_axis_symmetry_wf_rotation=\"20\"";
    let falloff = "pre_falloff2=\"1\" pre_falloff2_scatter=\"5\" pre_falloff2_mul_c=\"9\"";
    for (own, last, without) in [
        (
            "dc_linear=\"0.6\" dc_linear_scale=\"0.2\" dc_linear_angle=\"0.5\" linear=\"0.3\"".to_owned(),
            "",
            "linear=\"0.9\"".to_owned(),
        ),
        (format!("linear=\"1\" {point}"), "", format!("linear=\"1\" {}", point.replace("0.3", "0"))),
        (
            format!("linear3D=\"1\" {axis}"),
            "",
            format!("linear3D=\"1\" {}", axis.replace("0.4", "0").replace("-0.3", "0")),
        ),
        (
            format!("linear3D=\"0.8\" {falloff}"),
            last,
            format!("linear3D=\"0.8\" {}", falloff.replace("\"9\"", "\"0\"")),
        ),
    ] {
        let genome = flame(&own, "", last);
        let many = picture(&genome);
        let found = psnr(&many, &drawn(&genome, 0.0, Arithmetic::Reference));
        assert!(found > 45.0, "{own}: {found}");
        assert_eq!(many, drawn(&genome, 0.0, Arithmetic::Portable), "{own}");
        let plain = psnr(&many, &picture(&flame(&without, "", "")));
        println!("{found:.1} dB, without colours {plain:.1}: {own}");
        assert!(plain + 6.0 < found, "{own}: {plain}, {found}");
        assert_eq!(Genome::parse(&genome.to_xml()).unwrap(), genome, "{own}");
    }
}

#[test]
fn a_priority_of_2_applies_a_variation_twice() {
    let curl = "curl_c1=\"0.4\" curl_c2=\"0.2\"";
    for value in ["2", "-2"] {
        let twice = flame(&format!("linear=\"0.8\" curl=\"0.3\" curl_fx_priority=\"{value}\" {curl}"), "", "");
        let said = format!(
            "linear=\"0.8\" curl=\"0.3\" curl_fx_priority=\"-1\" {curl} curl.2=\"0.3\" curl.2_fx_priority=\"1\" {}",
            curl.replace("curl_", "curl.2_")
        );
        assert_eq!(picture(&twice), picture(&flame(&said, "", "")));
        assert_eq!(Genome::parse(&twice.to_xml()).unwrap(), twice);
    }
    let one = flame("linear=\"0.8\" post_curl=\"0.3\" post_curl_fx_priority=\"-1\" post_curl_c1=\"0.4\"", "", "");
    assert_eq!(picture(&one), picture(&flame("linear=\"0.8\" pre_curl=\"0.3\" pre_curl_c1=\"0.4\"", "", "")));
}

#[test]
fn a_jwildfires_falloff_moves_points_to_one_side_unless_the_genome_says_otherwise() {
    let jwildfire = "version=\"JWildfire V7.30 (27.11.2021)\"";
    for (version, says, expected) in [
        (jwildfire, "", 0.5),
        (jwildfire, "falloff2_above=\"0.25\"", 0.25),
        ("", "", 0.0),
        ("", "falloff2_above=\"0.5\"", 0.5),
    ] {
        let genome = flame(&format!("falloff2=\"1\" {says}"), version, "");
        let falloff = genome.xforms[1].variations[0];
        assert_eq!(falloff.params[11].to_bits(), f64::to_bits(expected), "{version} {says}");
        assert_eq!(Genome::parse(&genome.to_xml()).unwrap(), genome);
    }
}

#[test]
fn affine_parts_of_all_planes_are_one_map_of_space() {
    let half_turn = "-1 0 0 -1 0 0";
    let pitched = |attributes: &str| flame(&format!("linear3D=\"1\" {attributes}"), "cam_pitch=\"0.7\"", "");
    for (name, one, other) in [
        (
            "about x, with the translation of `coefs` after it",
            pitched("yzCoefs=\"0.8 0.6 -0.6 0.8 0 0\""),
            pitched(
                "pre_affine3D=\"1\" pre_affine3D_rotateX=\"36.8698976458440\" pre_affine3D_translateY=\"0.06\" \
                 pre_affine3D_translateZ=\"-0.18\"",
            ),
        ),
        (
            "half a turn and back",
            pitched(&format!("zxCoefs=\"{half_turn}\" zxPost=\"{half_turn}\"")),
            pitched("post=\"1 0 0 1 0.8 0\""),
        ),
    ] {
        let off = psnr(&picture(&one), &picture(&other));
        assert!(off > 35.0, "{name}: {off} dB");
    }
    let tilted = flame("linear3D=\"1\" yzCoefs=\"0.8 0.6 -0.6 0.8 0.2 0.1\"", "", "");
    let off = psnr(&picture(&tilted), &drawn(&tilted, 0.0, Arithmetic::Reference));
    assert!(off > 35.0, "{off} dB");
    let plain = flame("linear3D=\"1\"", "", "");
    assert!(psnr(&picture(&tilted), &picture(&plain)) < 25.0);
    // It comes from nothing.
    let [from, to] = [&plain, &tilted].map(|genome| Loop::new(genome, 1800.0));
    let off = psnr(&drawn(&Transition::new(&from, &to, 900.0), 0.01, Arithmetic::Fastest), &picture(&plain));
    assert!(off > 35.0, "{off} dB");
}

#[test]
fn formulas_of_the_plane_carry_z_as_the_program_has_it() {
    let seen = "cam_pitch=\"1.1\" cam_yaw=\"0.4\"";
    let solid = |attributes: &str, more: &str| {
        flame(&format!("{attributes} ztranslate=\"0.6\""), &format!("{seen} {more}"), "")
    };
    let (fractorium, jwildfire) = ("version=\"EMBER-WIN-22\"", "version=\"JWildfire V7.00\" preserve_z=\"1\"");
    let flat = solid("linear=\"0.7\" julia=\"0.1\"", "");
    let carried = solid("linear3D=\"0.7\" julia=\"0.1\"", "");
    assert!(psnr(&picture(&flat), &picture(&carried)) < 30.0);
    let halved = solid("pre_linear3D=\"0.5\" linear3D=\"1\"", fractorium);
    let off = |one: &Genome, other: &Genome| psnr(&picture(one), &picture(other));
    for (name, one, other) in [
        ("by an attribute", solid("linear=\"0.7\" linear.z=\"1\" julia=\"0.1\"", ""), &carried),
        ("not in JWildfire by itself", solid("linear=\"0.7\" julia=\"0.1\"", "preserve_z=\"0\""), &flat),
        ("in Fractorium before the sum", solid("pre_linear=\"0.5\" linear3D=\"1\"", fractorium), &halved),
        (
            "two halves",
            solid("linear=\"0.35\" linear.z=\"1\" linear.2=\"0.35\" linear.2.z=\"1\" julia=\"0.1\"", ""),
            &carried,
        ),
    ] {
        assert!(off(&one, other) > 35.0, "{name}: {}", off(&one, other));
        assert_eq!(Genome::parse(&one.to_xml()).unwrap(), one, "{name}, written and read");
    }
    // Their palettes have another span: the rest of the flame is the same.
    for (name, more, all) in [("Fractorium", fractorium, 0.0), ("JWildfire", jwildfire, 1.0)] {
        let one = solid("linear=\"0.7\" julia=\"0.1\"", more);
        let said = solid(&format!("linear=\"0.7\" linear.z=\"1\" julia=\"0.1\" julia.z=\"{all}\""), more);
        assert_eq!(one, said, "{name}");
        assert_eq!(Genome::parse(&one.to_xml()).unwrap(), one, "{name}, written and read");
        let none = solid("linear=\"0.7\" linear.z=\"0\" julia=\"0.1\" julia.z=\"0\"", more);
        assert!(off(&one, &none) < 30.0, "{name}");
        assert_eq!(Genome::parse(&none.to_xml()).unwrap(), none, "{name} without, written and read");
        // Of less z, whose beginning is soon forgotten: orbits of a pool are shorter than the one.
        let less = solid("linear=\"0.4\" julia=\"0.1\"", more);
        let found = psnr(&picture(&less), &drawn(&less, 0.0, Arithmetic::Reference));
        assert!(found > 30.0, "{name}, by one orbit: {found}");
        let [from, to] = [&none, &one].map(|genome| Loop::new(genome, 1800.0));
        let near = drawn(&Transition::new(&from, &to, 900.0), 0.01, Arithmetic::Fastest);
        let found = psnr(&near, &picture(&none));
        assert!(found > 35.0, "{name}, from nothing: {found}");
    }
}

#[test]
fn what_replaces_the_point_comes_from_nothing() {
    let plain = Loop::new(&flame("linear=\"0.9\"", "", ""), 1800.0);
    for with in [
        "linear=\"0.9\" pre_spherical=\"1\"",
        "linear=\"0.9\" post_spherical=\"0.6\"",
        "linear=\"0.9\" post_spherical=\"0.6\" post_spherical_fx_priority=\"0\"",
        "linear=\"0.9\" spherical=\"0.6\" spherical_fx_priority=\"1\"",
        "linear=\"0.9\" flatten=\"1\"",
        "linear=\"0.9\" dc_linear=\"0.6\"",
        "linear=\"0.9\" falloff2=\"0.6\" falloff2_mul_c=\"9\"",
        "linear=\"0.9\" truchet=\"1\"",
        "linear=\"0.9\" crackle=\"0.6\"",
        "linear=\"0.9\" taurus=\"0.4\"",
    ] {
        let changed = Loop::new(&flame(with, "cam_pitch=\"0.3\"", ""), 1800.0);
        for (from, to, frame, end) in [(&plain, &changed, 0.01, &plain), (&plain, &changed, 899.99, &changed)] {
            let near = drawn(&Transition::new(from, to, 900.0), frame, Arithmetic::Fastest);
            let off = psnr(&near, &drawn(end, if frame < 1.0 { frame } else { -0.01 }, Arithmetic::Fastest));
            assert!(off > 35.0, "{with}, {frame}: {off}");
        }
    }
}
