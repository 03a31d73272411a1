//! All machines of `docs/hardware.md` that QEMU can emulate. `hardware_sample.rs` has the one for `make check-all`.

use crate::machine::hardware::{Bus, Display, Hardware, USUAL};
use crate::starts::hardware_sample::shows_its_art;

#[test]
fn a_unit_on_uas_with_qxl_shows_its_art() {
    shows_its_art(Hardware { bus: Bus::Uas, display: Display::Qxl, ..USUAL });
}

#[test]
fn a_unit_on_virtio_scsi_shows_its_art() {
    shows_its_art(Hardware { bus: Bus::VirtioScsi, ..USUAL });
}

#[test]
fn a_unit_on_sata_shows_its_art() {
    shows_its_art(Hardware { bus: Bus::Ahci, ..USUAL });
}

#[test]
fn a_unit_on_usb_storage_shows_its_art() {
    shows_its_art(Hardware { bus: Bus::UsbStorage, ..USUAL });
}

#[test]
fn a_unit_on_an_sd_card_shows_its_art() {
    shows_its_art(Hardware { bus: Bus::Sd, ..USUAL });
}

#[test]
fn a_unit_with_a_standard_vga_shows_its_art() {
    shows_its_art(Hardware { display: Display::StandardVga, ..USUAL });
}

#[test]
fn a_unit_with_cirrus_shows_its_art() {
    shows_its_art(Hardware { display: Display::Cirrus, ..USUAL });
}

#[test]
fn a_unit_with_the_firmwares_framebuffer_alone_shows_its_art() {
    shows_its_art(Hardware { display: Display::Ramfb, ..USUAL });
}

#[test]
fn a_unit_with_vmwares_display_shows_its_art() {
    shows_its_art(Hardware { display: Display::Vmware, ..USUAL });
}

#[test]
fn a_unit_with_512_mib_shows_its_art() {
    shows_its_art(Hardware { memory_mib: 512, ..USUAL });
}

#[test]
fn a_unit_with_4_gib_shows_its_art() {
    shows_its_art(Hardware { memory_mib: 4_096, ..USUAL });
}
