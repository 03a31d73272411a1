//! A system to send, small and without a kernel.
//!
//! Owns the halves of which `dreams pack --system` makes one. Never packs them.
//!
//! Start at [`make_halves`].

use crate::programs::{self, repository};
use std::fs;
use std::path::Path;
use std::process::Command;

/// Two halves of this version, in `folder`.
pub fn make_halves(folder: &Path, version: &str) {
    fs::create_dir_all(folder).unwrap();
    let salt = version.as_bytes()[2];
    let (blocks, mut root) = (3, vec![salt; 3 * 4096]);
    root.extend([0; 16]);
    root.extend([salt; 16]);
    root.extend(vec![salt; 60_000]);
    fs::write(folder.join("root.img"), root).unwrap();
    let slot = format!("{salt:02x}").repeat(16);
    let words = format!("quiet dreams.version={version} dreams.root={slot}:{blocks}:salt:hash gpt");
    for part in ["linux", "initramfs"] {
        fs::write(folder.join(part), format!("{part} of {version}\n").repeat(300)).unwrap();
    }
    let mut start = Command::new(repository().join("image-build/start"));
    start.arg(folder.join("dreams.start")).args([version, &words]);
    programs::succeed(start.args(["linux", "initramfs"].map(|part| folder.join(part))));
}
