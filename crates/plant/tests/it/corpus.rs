//! The corpus of the fuzzer, given to the same function that it drives.
//!
//! What must hold stands in `fuzz/target.rs`; `cargo +nightly fuzz run genome` looks further.

#[path = "../../../species/tests/variations/mod.rs"]
mod variations;

use crate::target;
use std::path::Path;

#[test]
fn a_plant_is_refused_or_read_just_as_it_is_written_and_drawn_whatever_bytes_it_is_made_of() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/corpus/genome");
    variations::try_all(&folder, 16, b"\n \"='#[]{},_+-09e.", target::genome);
}
