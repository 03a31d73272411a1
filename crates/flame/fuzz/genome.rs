//! The target `genome` of `target.rs`, in the fuzzer's hands.
//! Never says what must hold: that file does.
#![no_main]

mod target;

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    target::genome(data);
    target::picture(data);
});
