//! `make boot` on a machine without a display.
//!
//! Owns the claim that it leaves a picture of the unit's screen.

use crate::machine::built_in;
use crate::machine::picture::Look;
use crate::unit::image;
use claims::programs::{repository, succeed};
use std::os::unix::fs::symlink;
use std::process::Command;
use std::time::Duration;

#[test]
fn without_a_display_a_picture_of_the_running_unit_is_left() {
    let folder = tempfile::tempdir_in(repository().join("target/image")).unwrap();
    symlink(image(), folder.path().join("bench-now")).unwrap();
    let mut boot = Command::new(repository().join("image-build/boot"));
    succeed(boot.arg(folder.path()).env_remove("DISPLAY").env_remove("WAYLAND_DISPLAY"));
    let [left, shot] = ["boot.png", "boot.ppm"].map(|name| folder.path().join(name));
    succeed(Command::new("ffmpeg").args(["-loglevel", "error", "-i"]).args([left, shot.clone()]));
    let look = Look::new(&shot, Duration::ZERO, &[built_in()], &mut 0, false);
    assert!(look.is_art(), "it shows {:?}", look.other);
}
