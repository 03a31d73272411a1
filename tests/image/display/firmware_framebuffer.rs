//! A display without a driver, and a driver that comes late.
//!
//! Owns the claim that the firmware's framebuffer shows the picture until the card's own driver takes it over.

use crate::machine::PAUSE;
use crate::machine::picture::only_art;
use crate::starts::first_start::{MOVES, OFTEN, UP};
use crate::unit::Unit;
use crate::unit::direct_boot::parts;
use claims::programs::repository;

#[test]
fn a_driver_that_comes_late_takes_the_picture_over_from_the_firmwares_framebuffer() {
    let unit = Unit::new();
    let folder = tempfile::tempdir_in(repository().join("target/image")).unwrap();
    let mut words = parts(folder.path());
    // The driver is not loaded automatically.
    words.last_mut().unwrap().push_str(" modprobe.blacklist=virtio_gpu");
    let mut machine = unit.start_with(&words);
    machine.may_tear = true;
    let mut looks = machine.await_shell();
    looks.extend(machine.watch_while(PAUSE, UP));
    machine.run("systemctl set-property --runtime dreams.slice CPUWeight=20");
    let told = machine.run("dreams-status; echo");
    assert!(told.contains("firmware:/dev/fb0") && told.contains("no driver drives this display"), "{told}");
    looks.extend(machine.watch_move(PAUSE, MOVES));

    let is_taken = "until dreams-status | grep -q 'kms:/dev/dri/card0'; do sleep 1; done";
    looks.extend(machine.watch_while(PAUSE, &format!("modprobe virtio_gpu && {is_taken}")));
    machine.may_tear = false;
    looks.extend(machine.watch_move(PAUSE, MOVES));
    only_art(&looks, OFTEN);
    machine.is_well();
}
