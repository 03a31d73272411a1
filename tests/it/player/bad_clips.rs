//! Clips that are damaged in every way that a disk or an artist may damage them.
//!
//! Owns the claims that the tools report each of them, and that a player leaves them out, reports each once, and never
//! shows black.

use claims::broken_clips::{BROKEN, broken_flock};
use claims::flocks::Flock;
use claims::programs::{self, json, output};
use std::collections::HashSet;
use std::process::Command;

/// The faults that `dreams check` finds in `flock`, as kind and clip, with its exit code.
fn faults(flock: &Flock) -> (Option<i32>, Vec<(String, String)>) {
    let said = output(Command::new(programs::dreams()).arg("check").arg(&flock.folder).arg("--json"));
    let answer = json(&said);
    let text = |value: &serde_json::Value| value.as_str().unwrap_or_default().to_owned();
    let faults = answer["faults"].as_array().unwrap().iter();
    (said.status.code(), faults.map(|fault| (text(&fault["kind"]), text(&fault["clip"]))).collect())
}

#[test]
fn every_broken_clip_is_named_with_its_fault_kind() {
    for (name, clip, kind, _) in BROKEN {
        for hashed in [true, false] {
            let (_scratch, flock) = broken_flock(&[name], hashed);
            let (code, faults) = faults(&flock);
            assert_eq!(code, Some(1), "{name}, hashed {hashed}");
            assert!(!faults.is_empty() && faults.iter().all(|(_, named)| named == clip), "{name}: {faults:?}");
            // A clip in another form also differs from the hash of the one it replaced.
            let kinds: HashSet<_> = faults.iter().map(|(kind, _)| kind.as_str()).collect();
            assert!(kinds.contains(kind), "{name}, hashed {hashed}: wanted `{kind}`, found {faults:?}");
        }
    }
}
