//! The demo's transitions are worth their rendering half way.
//!
//! Owns the claim on their brightness. Never renders a clip.

use flame::{Exposed, Exposure, Image, Motion, Renderer, Settings};

use super::plan::{Edition, Plan};
use crate::render::plan::{ClipPlan, ClipRole};

/// Another picture than those by which the exposure is measured.
const SMALL: Settings = Settings {
    size: Some([160, 90]),
    spp: Some(100.0),
    psnr: None,
    supersample: Some(1),
    temporal_samples: Some(1),
    filter: flame::Filter::Variance,
    seed: 9,
    arithmetic: flame::Arithmetic::Fastest,
};

fn luma(image: &Image) -> f64 {
    let sum = |[red, green, blue]: &[f32; 3]| {
        0.2126 * f64::from(*red) + 0.7152 * f64::from(*green) + 0.0722 * f64::from(*blue)
    };
    image.pixels.iter().map(sum).sum::<f64>() / image.pixels.len() as f64
}

/// The brightness of some moments between the ends that is furthest off, as a part of what lies between theirs.
fn furthest(clip: &ClipPlan, exposure: &Exposure, renderer: &Renderer) -> f64 {
    let motion = Exposed { motion: &*clip.motion, exposure };
    let frames = f64::from(clip.frames.0);
    let light = |frame: f64| luma(&renderer.render(&motion, frame, &SMALL).unwrap());
    let ends = [light(0.0), light(frames)];
    let off = |part: f64| light(part * frames) / (ends[0] + (ends[1] - ends[0]) * part * part * (3.0 - 2.0 * part));
    let parts = [0.1, 0.22, 0.35, 0.5, 0.65, 0.78, 0.9];
    parts.map(off).into_iter().max_by(|a, b| a.ln().abs().total_cmp(&b.ln().abs())).unwrap()
}

#[test]
fn half_way_the_demo_is_as_bright_as_its_ends_and_would_not_be_without_a_curve() {
    let plan = Plan::new(Edition::small()).unwrap();
    let renderer = Renderer::new(0).unwrap();
    let mut worst_without: f64 = 1.0;
    for clip in plan.clips.iter().filter(|clip| matches!(clip.role, ClipRole::Transition(..))) {
        let exposure = clip.exposure(&renderer).unwrap();
        let (with, without) = (furthest(clip, &exposure, &renderer), furthest(clip, &Exposure::EVEN, &renderer));
        println!("{}: {with:.2}, without a curve {without:.2}", clip.path);
        assert!((0.75..=1.25).contains(&with), "{}: {with}", clip.path);
        worst_without = if without.ln().abs() > worst_without.ln().abs() { without } else { worst_without };
        let middle = clip.middle(&renderer).unwrap().unwrap();
        println!("    {middle:?}");
        assert_eq!(middle.faults, [], "{}", clip.path);
        let frames = f64::from(clip.frames.0);
        let exposed = Exposed { motion: &*clip.motion, exposure: &exposure };
        for end in [0.0, frames] {
            assert_eq!(exposed.at(end), clip.motion.at(end), "the ends are the loops'");
        }
    }
    assert!(!(0.6..=1.6).contains(&worst_without), "{worst_without}");
}
