//! `dreams render --on gpu`, by the program with the feature `gpu`.
//!
//! Owns the claims on the command; pictures are compared in `crates/flame/tests/it/gpu.rs`. Any GPU that Vulkan knows will
//! do, a software driver too: `make gpu` runs it.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]
#![allow(clippy::panic, reason = "a test that cannot go on has failed")]

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use serde_json::Value;
use tempfile::TempDir;

const MANIFEST: &str = "format = 1\nname = \"one\"\nsize = [64, 36]\nfps = [30, 1]\n\
                        [[sheep]]\nid = \"orchid\"\nframes = 6\nclip = \"loops/orchid.mp4\"\ngenome = \"genomes/orchid.flam3\"\n";

/// A flock of one sheep, in a folder whose name has a space.
fn flock() -> TempDir {
    let folder = tempfile::Builder::new().prefix("on a gpu").tempdir().unwrap();
    fs::write(folder.path().join("flock.toml"), MANIFEST).unwrap();
    fs::create_dir(folder.path().join("genomes")).unwrap();
    let genome = Path::new(env!("CARGO_MANIFEST_DIR")).join("../demo/genomes/orchid.flam3");
    fs::copy(genome, folder.path().join("genomes/orchid.flam3")).unwrap();
    folder
}

/// `dreams render FOLDER OPTIONS...`, at low quality.
fn render(folder: &Path, options: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_dreams"));
    command
        .arg("render")
        .arg(folder)
        .args(["--spp", "4", "--supersample", "1", "--temporal-samples", "3"])
        .args(options);
    command
}

fn json(said: &Output) -> Value {
    serde_json::from_slice(&said.stdout).unwrap_or_else(|_| panic!("{}", String::from_utf8_lossy(&said.stderr)))
}

fn answer(folder: &Path, options: &[&str]) -> Value {
    json(&render(folder, &[options, &["--json"]].concat()).output().unwrap())
}

#[test]
fn a_gpu_renders_the_clips_and_a_dry_run_names_it() {
    let flock = flock();
    let dry = answer(flock.path(), &["--on", "gpu", "--dry-run"]);
    assert!(!dry["gpu"].as_str().unwrap().is_empty() && dry["frames"] == 6, "{dry}");
    assert!(dry["hours"].as_f64().unwrap() > 0.0, "{dry}");
    assert!(answer(flock.path(), &["--dry-run"])["gpu"].is_null());
    let made = answer(flock.path(), &["--on", "gpu"]);
    assert_eq!((&made["clips"][0]["state"], &made["frames"]), (&"made".into(), &6.into()), "{made}");
    assert_eq!(answer(flock.path(), &["--on", "gpu"])["frames"], 0);
}

#[test]
fn no_clip_has_frames_of_the_processor_and_of_a_gpu() {
    let flock = flock();
    // A part of the frames, by the processor.
    assert_eq!(answer(flock.path(), &["--shard", "1/2"])["frames"], 3);
    let made = answer(flock.path(), &["--on", "gpu"]);
    assert_eq!(made["frames"], 6, "{made}");
    let by_gpu = fs::read(flock.path().join("loops/orchid.mp4")).unwrap();
    // For the processor the clip is one of another look, and so are its frames.
    let again = answer(flock.path(), &[]);
    assert_eq!((&again["clips"][0]["state"], &again["frames"]), (&"made".into(), &6.into()), "{again}");
    assert!(fs::read(flock.path().join("loops/orchid.mp4")).unwrap() != by_gpu);
    // The GPU gives the same bytes again.
    assert_eq!(answer(flock.path(), &["--on", "gpu"])["frames"], 6);
    assert!(fs::read(flock.path().join("loops/orchid.mp4")).unwrap() == by_gpu);
}

#[test]
fn a_machine_without_a_gpu_is_told_what_was_found() {
    let flock = flock();
    let mut command = render(flock.path(), &["--on", "gpu", "--json"]);
    for name in ["VK_ICD_FILENAMES", "VK_DRIVER_FILES"] {
        command.env(name, "/nonexistent");
    }
    let said = command.output().unwrap();
    let error = &json(&said)["error"];
    assert_eq!((said.status.code(), &error["exit"]), (Some(3), &3.into()), "{error}");
    let message = error["message"].as_str().unwrap();
    assert!(message.starts_with("no GPU can be used: Vulkan knows none"), "{message}");
    assert!(error["hint"].as_str().unwrap().contains("vulkaninfo"), "{error}");
    assert!(!flock.path().join("loops").exists());
}
