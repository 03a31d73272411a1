//! The rendered copy in the repository is what this code makes.
//!
//! Owns the claims about `demo/small`: its form, its size, and that its pictures are ours. Never writes to it: the
//! command that makes it again is in `demo/README.md`.

use std::fs;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

use flock::Manifest;
use operations::render::plan::{ClipPlan, Look};
use species::Threads;
use video::{Clip, Poll, Session};

use super::manifest;
use super::plan::{Edition, Plan};

/// The most bytes of the copy on the disk.
const ROOM: u64 = 48_000_000;

/// How near a frame of the copy comes to the same frame rendered now, in decibels: encoding at the copy's rate factor
/// takes the rest. Frames before and after it are further off by [`APART_DB`] at least.
const NEAR_DB: f64 = 30.0;
const APART_DB: f64 = 3.0;

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../demo/small")
}

fn plan() -> Plan {
    Plan::new(Edition::small()).unwrap()
}

/// Peak signal-to-noise ratio of two planes of bytes, in decibels.
fn psnr(ours: &[u8], theirs: &[u8]) -> f64 {
    assert_eq!(ours.len(), theirs.len());
    let squares: f64 = ours.iter().zip(theirs).map(|(a, b)| f64::from(a.abs_diff(*b)).powi(2)).sum();
    10.0 * (255.0_f64.powi(2) * ours.len() as f64 / squares.max(1.0)).log10()
}

/// The luma of frame `number` of a clip of the copy.
fn decoded(clip: &ClipPlan, look: &Look, number: u32) -> Vec<u8> {
    let mut session = Session::new(NonZeroUsize::MIN).unwrap();
    session.push(Clip::open(&clip.path.inside(&folder()), &look.form, clip.frames).unwrap());
    session.finish();
    loop {
        match session.poll() {
            Poll::Frame(frame) if frame.in_clip() == number => {
                let rows = frame.planes()[0].chunks(frame.strides()[0]);
                return rows.flat_map(|row| &row[..look.form.size.0 as usize]).copied().collect();
            }
            Poll::Frame(_) => {}
            other @ (Poll::Starved | Poll::ClipEnd { .. } | Poll::Finished | Poll::Failed(_)) => {
                panic!("frame {number} of {} did not come: {other:?}", clip.path)
            }
        }
    }
}

#[test]
fn the_small_copy_is_the_planned_flock() {
    let plan = plan();
    let manifest = Manifest::read(&folder()).unwrap();
    let hashes: Vec<_> = manifest.clips().map(|clip| clip.hash.unwrap()).collect();
    let written = fs::read_to_string(folder().join(flock::FILE_NAME)).unwrap();
    assert_eq!(written, manifest::text(&plan, &hashes));
    assert_eq!(flock::Flock::new(manifest).faults(), []);
}

#[test]
fn the_small_copy_takes_at_most_48_mb() {
    let mut sum = 0;
    let mut folders = vec![folder()];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).unwrap().map(Result::unwrap) {
            let about = entry.metadata().unwrap();
            if about.is_dir() {
                folders.push(entry.path());
            } else {
                sum += about.len();
            }
        }
    }
    assert!(sum <= ROOM, "{sum} bytes");
}

#[test]
fn frames_of_the_small_copy_come_out_again() {
    let plan = plan();
    let look = &plan.edition.look;
    let threads = Threads::new(0).unwrap();
    let shown = |path: &str| plan.clips.iter().find(|clip| clip.path.as_str() == path).unwrap();
    for (path, number) in [
        ("loops/tempest.mp4", 40),
        ("loops/lagoon.mp4", 40),
        ("loops/neon.mp4", 40),
        ("loops/linden.mp4", 40),
        ("transitions/oracle=clematis.mp4", 28),
        ("transitions/kindle=dahlia.mp4", 40),
    ] {
        let clip = shown(path);
        let ours = clip.picture(number, look, &threads).unwrap().unwrap();
        let [before, near, after] =
            [number - 1, number, number + 1].map(|frame| psnr(ours.planes()[0], &decoded(clip, look, frame)));
        assert!(near >= NEAR_DB, "frame {number} of {path}: {near:.1} dB");
        let next = before.max(after);
        assert!(near >= next + APART_DB, "frame {number} of {path}: {near:.1} dB, its neighbour {next:.1} dB");
    }
}
