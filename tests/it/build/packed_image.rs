//! The packed image of a disk.
//!
//! Owns the claim on `image-build/pack`: every program that knows zstd opens what it writes.

use claims::programs::{repository, succeed};
use std::fs;
use std::process::Command;

/// The largest window that every decoder has to support, in bytes: RFC 8878, 3.1.1.1.2.
const WINDOW: u64 = 8 << 20;

/// The window that a zstd frame of `content` bytes asks for, in bytes, by its header: RFC 8878, 3.1.1.1.
fn window(frame: &[u8], content: usize) -> u64 {
    assert_eq!(frame[..4], 0xfd2f_b528_u32.to_le_bytes(), "it is a frame of zstd");
    if frame[4] & 0x20 != 0 {
        // A single segment: all of it.
        return content as u64;
    }
    let (exponent, mantissa) = (u64::from(frame[5] >> 3), u64::from(frame[5] & 7));
    let base = 1 << (10 + exponent);
    base + base / 8 * mantissa
}

#[test]
fn a_packed_image_opens_without_options_and_in_the_least_memory_that_decoders_have() {
    let folder = tempfile::tempdir().unwrap();
    let disk = folder.path().join("disk.img");
    // Two slots that are equal, further apart than the window.
    let mut slot = vec![0; 12 << 20];
    blake3::Hasher::new().update(b"slot").finalize_xof().fill(&mut slot);
    let bytes = [&slot[..], &slot[..]].concat();
    fs::write(&disk, &bytes).unwrap();
    succeed(Command::new(repository().join("image-build/pack")).arg(&disk));
    let packed = folder.path().join("disk.img.zst");
    let asked = window(&fs::read(&packed).unwrap(), bytes.len());
    assert!(asked <= WINDOW, "it asks for {asked} bytes");
    for options in [&[][..], &["--memory=8MB"]] {
        let opened = succeed(Command::new("zstd").args(["-d", "-c", "-q"]).args(options).arg(&packed));
        assert!(opened == bytes, "{options:?}");
    }
}
