//! The target `settings` of `targets.rs`, in the fuzzer's hands.
//! Never says what must hold: that file does.
#![no_main]

#[path = "../crates/bundle/tests/it/folders.rs"]
mod folders;
mod targets;

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    targets::settings(data);
});
