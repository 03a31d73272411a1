//! A unit with an ARM processor.
//!
//! Owns the claim that the same build makes an image for it that starts by UEFI and shows its picture. Raspberry Pis
//! are not emulated: `docs/hardware.md` has what was seen on them.

use crate::machine::PAUSE;
use crate::machine::hardware::{Display, Firmware, Hardware, USUAL};
use crate::machine::picture::only_art;
use crate::starts::first_start::{MOVES, OFTEN, PROVEN};
use crate::unit::Unit;
use claims::programs::repository;

const ARM: Hardware = Hardware { firmware: Firmware::Arm64, display: Display::VirtioGpu, ..USUAL };
/// Where `make crash` builds it.
const IMAGE: &str = concat!("target/image-arm64/bench-", env!("CARGO_PKG_VERSION"));

#[test]
fn a_unit_with_an_arm_processor_shows_its_art() {
    let unit = Unit::of(&repository().join(IMAGE));
    unit.know(ARM.firmware.variables());
    let mut machine = unit.start_as(ARM, &[]);
    let mut looks = machine.await_shell();
    looks.extend(machine.watch_move(PAUSE, MOVES));
    looks.extend(machine.watch_while(PAUSE, PROVEN));
    only_art(&looks, OFTEN);
    assert_eq!(machine.run("uname -m").trim(), "aarch64");
    machine.run("[ -b /dev/dm-0 ] && findmnt --noheadings --output SOURCE / | grep -q dm-0");
    machine.is_well();
}
