//! A flock of works in the forms of other programs: imported, linked, rendered and played.
//!
//! Owns ten genomes, each with what its program writes and flam3 does not: containers, versions, priorities, stages, cameras
//! in space, several final transforms, palettes of other lengths.

use crate::tools::import_folders::ImportFolders;
use claims::player_run::PlayerRun;
use claims::programs::{self, output, succeed};
use std::collections::BTreeSet;
use std::fmt::Write;
use std::fs;
use std::process::Command;

/// Each one's file, its root, the attributes of its flame, its two transforms, and what follows these.
#[rustfmt::skip]
const WORKS: [[&str; 5]; 10] = [
    ["harbour.flame", "Flames name=\"Apophysis\"", "version=\"Apophysis 7X.15C\" cam_pitch=\"0.7\" cam_yaw=\"0.3\" cam_perspective=\"0.2\"",
     "linear3D=\"0.8\" zblur=\"0.2\" var_color=\"1\"|TwinTrian=\"0.2\" linear3D=\"0.7\"", ""],
    ["cloister.flame", "flames name=\"Batch\"", "version=\"Apophysis v2.09\" angle=\"1.0471975511966\" rotate=\"-60\" oversample=\"1\"",
     "linear=\"0.9\"|julian=\"1\" julian_power=\"3\" julian_dist=\"1\"", ""],
    ["meander.flame", "flames", "version=\"EMBER-WIN-1.0.0.11\" cam_zpos=\"0.1\" blur_curve=\"0\" curves=\"0 0 1 0 0 1 1 1 1 1 1 1 0 0 1 0 0 1 1 1 1 1 1 1 0 0 1 0 0 1 1 1 1 1 1 1 0 0 1 0 0 1 1 1 1 1 1 1\"",
     "spherical=\"0.6\" post_curl=\"1\" post_curl_c1=\"0.2\"|pre_gaussian_blur=\"0.2\" linear=\"0.9\"", ""],
    ["quarry.flame", "flames", "version=\"EMBER-LNX-1.0.0.19\" temporal_samples=\"1.0\"",
     "pre_spherical=\"1\" swirl=\"0.7\"|linear=\"0.8\" flatten=\"1\"", ""],
    ["regatta.flame", "jwf-flames", "version=\"JWildfire V7.30 (01.01.2022)\" cam_zoom=\"1.5\" cam_pitch=\"0.5\" cam_persp=\"0.3\" smooth_gradient=\"0\"",
     "linear3D=\"0.7\" linear3D_fx_priority=\"0\" bubble=\"0.5\" bubble_fx_priority=\"0\" bubble#1#=\"0.3\" bubble#1#_fx_priority=\"0\" color_type=\"DIFFUSION\"|linear3D=\"0.8\" ztranslate=\"0.3\"", ""],
    ["sextant.flame", "flames", "version=\"JWildfire V3.10\" post_symmetry_type=\"NONE\" mixer_mode=\"OFF\"",
     "linear=\"0.8\" gaussian_blur=\"0.2\" gaussian_blur_fx_priority=\"-1\" material=\"0.0\"|horseshoe=\"0.7\" horseshoe_fx_priority=\"0\"",
     "<finalxform weight=\"0\" color_speed=\"0\" linear=\"1\"/><finalxform weight=\"0\" color_speed=\"0\" curl=\"1\" curl_c1=\"0.3\"/>"],
    ["tern.flame", "flames", "flam3h_hsv=\"1 1 1\" version=\"FLAM3H-1.9\"", "linear=\"0.9\"|disc=\"0.9\"", ""],
    ["umber.flame", "flames", "version=\"JWildfire V7.00\" preserve_z=\"0\" cam_roll=\"0.1\"",
     "julian=\"0.9\" julian_power=\"2\" mod_gamma=\"0.0\" pre_blur=\"0.2\" pre_blur_fx_priority=\"0\"|linear=\"0.8\"", ""],
    ["vellum.flam3", "flames", "palette_mode=\"linear\"", "linear=\"0.8\"|sinusoidal=\"0.9\"", ""],
    ["wharf.flame", "Flames name=\"x\"", "new_linear=\"1\" plugins=\"\"", "Mobius=\"1\" Mobius_Re_A=\"1\" Mobius_Re_B=\"0.3\" Mobius_Re_C=\"0.2\" Mobius_Re_D=\"1\"|linear=\"0.7\"", ""],
];

/// The text of a work, whose colours are of its program's length.
fn text([file, root, flame, xforms, more]: [&str; 5]) -> String {
    let name = file.split('.').next().unwrap();
    let colours = if root == "flames" && flame.contains("EMBER") { 512 } else { 256 };
    let mut hex = String::new();
    for at in 0..colours {
        write!(hex, "{:02X}{:02X}60", 40 + at * 200 / colours, 250 - at * 180 / colours).unwrap();
    }
    let xforms: Vec<String> = xforms
        .split('|')
        .zip(["0.6 0.4 -0.4 0.6 0.4 0.1", "0.5 -0.3 0.4 0.6 -0.6 0.3"])
        .enumerate()
        .map(|(at, (xform, coefs))| format!("<xform weight=\"1\" color=\"{at}\" {xform} coefs=\"{coefs}\"/>"))
        .collect();
    let end = root.split(' ').next().unwrap();
    format!(
        "<{root}>\n<flame name=\"{name}\" size=\"640 360\" center=\"0 0\" scale=\"90\" quality=\"5\" brightness=\"8\" {flame}>\n{}{more}\n\
         <palette count=\"{colours}\" format=\"RGB\">{hex}</palette>\n</flame>\n</{end}>\n",
        xforms.concat()
    )
}

#[test]
fn works_of_other_programs_become_a_flock_that_plays() {
    let folders = ImportFolders::new("64x36");
    for work in WORKS {
        fs::write(folders.inbox().join(work[0]), text(work)).unwrap();
    }
    let answer = folders.answer(0, &[".", "--frames", "6"]);
    assert_eq!(answer["genomes"].as_array().unwrap().len(), WORKS.len(), "{answer}");
    let names: Vec<&str> = WORKS.iter().map(|work| work[0].split('.').next().unwrap()).collect();
    for (at, from) in names.iter().enumerate() {
        let mut link = Command::new(programs::dreams());
        link.arg("link").arg(folders.flock()).args([from, names[(at + 1) % names.len()], "--frames", "4"]);
        succeed(&mut link);
    }
    let mut render = Command::new(programs::dreams());
    render.arg("render").arg(folders.flock()).args(["--spp", "30", "--temporal-samples", "2"]);
    succeed(&mut render);
    let check = output(Command::new(programs::dreams()).arg("check").arg(folders.flock()).arg("--json"));
    assert_eq!(check.status.code(), Some(0), "{}", String::from_utf8_lossy(&check.stdout));
    let play = PlayerRun::of(&folders.flock())
        .with(&["--screen", "virtual", "--clock", "free", "--seed", "3", "--clips", "40", "--hash"]);
    let (code, trace) = play.start().end_within(120);
    assert_eq!((code, trace.faults.len()), (Some(0), 0), "{:?}", trace.faults);
    let shown: BTreeSet<_> = trace.flips.iter().map(|flip| flip.clip.clone()).collect();
    assert!(shown.len() >= 2 * WORKS.len(), "all loops and transitions are shown: {shown:?}");
    let pictures: BTreeSet<_> = trace.flips.iter().map(|flip| flip.hash.clone()).collect();
    assert!(pictures.len() >= 60, "{} pictures differ", pictures.len());
}
