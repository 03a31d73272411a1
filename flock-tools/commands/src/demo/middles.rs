//! The demo's transitions are worth their rendering half way.
//!
//! Owns the claim on their brightness. Never renders a clip.

use ::species::{Image, Motion, Settings, Threads};
use operations::render::plan::ClipRole;

use super::plan::{Edition, Plan};

/// Another picture than those by which the exposure is measured.
const SMALL: Settings = Settings {
    size: [160, 90],
    spp: Some(100.0),
    psnr: None,
    supersample: Some(1),
    temporal_samples: Some(1),
    smooths: true,
    seed: 9,
};

fn luma(image: &Image) -> f64 {
    let sum = |[red, green, blue]: &[f32; 3]| {
        0.2126 * f64::from(*red) + 0.7152 * f64::from(*green) + 0.0722 * f64::from(*blue)
    };
    image.pixels.iter().map(sum).sum::<f64>() / image.pixels.len() as f64
}

/// The brightness of some moments between the ends that is furthest off, as a part of what lies between theirs.
fn furthest(motion: &dyn Motion, frames: f64, threads: &Threads) -> f64 {
    let light = |frame: f64| luma(&motion.frame(frame, &SMALL, threads).unwrap().image);
    let ends = [light(0.0), light(frames)];
    let off = |part: f64| light(part * frames) / (ends[0] + (ends[1] - ends[0]) * part * part * (3.0 - 2.0 * part));
    let parts = [0.1, 0.22, 0.35, 0.5, 0.65, 0.78, 0.9];
    parts.map(off).into_iter().max_by(|a, b| a.ln().abs().total_cmp(&b.ln().abs())).unwrap()
}

#[test]
fn half_way_the_demo_is_as_bright_as_its_ends() {
    let plan = Plan::new(Edition::small()).unwrap();
    let threads = Threads::new(0).unwrap();
    for clip in plan.clips.iter().filter(|clip| matches!(clip.role, ClipRole::Transition(..))) {
        let found = furthest(&*clip.motion, f64::from(clip.frames.0), &threads);
        let middle = clip.middle(&plan.edition.look, &threads).unwrap().unwrap();
        println!("{}: {found:.2}, {middle:?}", clip.path);
        // Only flames are exposed: others may be brighter and darker by their nature.
        assert!((0.75..=1.25).contains(&found) || !clip.motion.is_noisy(), "{}: {found}", clip.path);
        assert_eq!(middle.faults, [], "{}", clip.path);
    }
}
