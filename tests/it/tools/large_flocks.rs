//! What the tools take for a flock that is larger than any that an artist has.
//!
//! Owns the claim on their memory, by the transition, at a size that costs little time: 10,000 sheep with 10 transitions
//! each. The page of a large flock is in `report.rs`.
//!
//! Start at [`peak`].

use crate::metering::{Measurement, Meter};
use claims::programs;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

const SHEEP: usize = 10_000;
const EXITS: usize = 10;
/// The most bytes of memory a transition: 450 MB for a million of them.
const MOST: u64 = 450;
/// Code that a command for a large flock has in memory and one for a small flock has not. Programs that are built for tests
/// are 7 MB larger than those that ship.
const CODE_KIB: u64 = if cfg!(debug_assertions) { 4_096 } else { 0 };

/// The manifest of a ring of `sheep`, each with transitions to `exits` others; weights and wants differ.
fn manifest(sheep: usize, exits: usize) -> String {
    let mut text = "format = 1\nname = \"large\"\nsize = [1280, 720]\nfps = [30, 1]\n".to_owned();
    for at in 0..sheep {
        let clip = format!("frames = 768\nclip = \"loops/{at}.mp4\"\nwant = {}", 1 + at % 3);
        writeln!(text, "\n[[sheep]]\nid = \"s{at}\"\n{clip}").unwrap();
    }
    for from in 0..sheep {
        for exit in 0..exits {
            // Far and near, by a step that has no divisor in common with the ring.
            let to = (from + 1 + exit * (exit * 997 + 1)) % sheep;
            let clip =
                format!("frames = 384\nclip = \"transitions/{from}={to}.mp4\"\nweight = 0.{}", 25 + (from + to) % 70);
            writeln!(text, "\n[[transition]]\nfrom = \"s{from}\"\nto = \"s{to}\"\n{clip}").unwrap();
        }
    }
    text
}

/// What `words` took for the flock in `folder`.
fn peak(meter: &mut Meter, folder: &Path, words: &[&str]) -> Measurement {
    let dreams = programs::dreams();
    let folder = folder.to_str().unwrap();
    let words: Vec<&str> = [dreams.to_str().unwrap()]
        .into_iter()
        .chain(words.iter().map(|&word| if word == "DIR" { folder } else { word }))
        .collect();
    let took = meter.run(&words);
    assert!((0..2).contains(&took.code), "{words:?}: {}", took.stderr);
    took
}

#[test]
fn no_command_takes_more_than_450_bytes_of_memory_a_transition() {
    let mut meter = Meter::new();
    let [large, small] = [(SHEEP, EXITS), (12, 2)].map(|(sheep, exits)| {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("flock.toml"), manifest(sheep, exits)).unwrap();
        folder
    });
    let page = large.path().join("page.html");
    let told: Vec<String> = [
        &["check", "DIR"][..],
        &["share", "DIR", "--json"],
        &["walk", "DIR", "--seed", "1", "--steps", "100"],
        &["simulate", "DIR", "--seed", "1", "--steps", "100"],
        &["balance", "DIR", "--json"],
        &["balance", "DIR", "--suggest", "1"],
        &["report", "DIR", "--out", page.to_str().unwrap()],
        &["want", "DIR", "s7", "2"],
        &["link", "DIR", "s7", "s7"],
        &["unlink", "DIR", "s7", "s7"],
        &["rename", "DIR", "s7", "ram"],
        &["drop", "DIR", "ram", "--force"],
        &["balance", "DIR", "--write"],
    ]
    .into_iter()
    .filter_map(|words| {
        let [large, small] = [&large, &small].map(|folder| peak(&mut meter, folder.path(), words).peak_kib);
        let bytes = 1024 * large.saturating_sub(small + CODE_KIB) / (SHEEP * EXITS) as u64;
        (bytes > MOST).then(|| format!("{words:?}: {bytes}"))
    })
    .collect();
    assert!(told.is_empty(), "{told:#?}");
}
