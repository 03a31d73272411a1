//! What comparisons with flam3 have in common.
//!
//! Owns the genomes that are compared, and the processor's clock. Never renders.

use std::error::Error;
use std::fs;
use std::path::{Path, PathBuf};

/// Ticks of the CPU clock in a second, as `/proc` counts them.
const TICKS_PER_SECOND: f64 = 100.0;

/// From simple ones to eight transforms with xaos and a final one.
pub(crate) fn genomes() -> Vec<PathBuf> {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let demo = ["blossom", "caldera", "nautilus", "nocturne", "orchid", "rosette", "undertow"];
    let demo = demo.iter().map(|name| here.join("../../flock-tools/demo/genomes").join(name).with_extension("flam3"));
    demo.chain([here.join("tests/genomes/eight-with-xaos.flam3")]).collect()
}

/// CPU seconds of this process, and of its children, so far.
pub(crate) fn cpu_seconds() -> Result<[f64; 2], Box<dyn Error>> {
    let stat = fs::read_to_string("/proc/self/stat")?;
    let after_name = stat.rsplit(')').next().unwrap_or_default();
    let ticks: Vec<f64> = after_name.split_whitespace().skip(11).take(4).map(str::parse).collect::<Result<_, _>>()?;
    let [user, system, child_user, child_system] = ticks[..] else { return Err("no CPU times in `/proc`".into()) };
    Ok([(user + system) / TICKS_PER_SECOND, (child_user + child_system) / TICKS_PER_SECOND])
}
