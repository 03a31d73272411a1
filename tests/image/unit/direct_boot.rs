//! A start without a boot loader: QEMU loads kernel, initramfs and command line.
//!
//! Owns the extraction of these parts from the image.

use crate::unit::image;
use bundle::{BootFiles, lay_out};
use std::fs;
use std::path::Path;

/// QEMU's options for such a start; the parts are written to `folder`. The last option is the kernel's command line.
pub(crate) fn parts(folder: &Path) -> Vec<String> {
    let start = fs::read(image().join("dreams.start")).unwrap();
    let BootFiles { entry, parts } = lay_out(&start, 1).expect("what was just made is whole");
    let [kernel, initramfs] = ["linux", "initramfs"].map(|name| {
        let (_, bytes) = parts.iter().find(|(path, _)| path.ends_with(name)).unwrap();
        fs::write(folder.join(name), bytes).unwrap();
        folder.join(name).display().to_string()
    });
    let words = entry.lines().find_map(|line| line.strip_prefix("options ")).unwrap();
    // The first of them names the initramfs to the boot loader.
    let words = words.split_once(' ').unwrap().1;
    ["-kernel", &kernel, "-initrd", &initramfs, "-append", words].map(str::to_owned).to_vec()
}
