//! The corpus of the fuzzer, given to the same function that it drives.
//!
//! What must hold stands in `fuzz/target.rs`; `cargo +nightly fuzz run globe` looks further.

#[path = "../../fuzz/target.rs"]
mod target;
#[path = "../../../species/tests/variations/mod.rs"]
mod variations;

use std::path::Path;

#[test]
fn a_globe_is_refused_or_read_just_as_it_is_written_whatever_bytes_it_is_made_of() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/corpus/globe");
    variations::try_all(&folder, 16, b"\n \"='&;[]F+-09e.\\", target::globe);
}
