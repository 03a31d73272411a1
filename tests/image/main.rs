//! Claims about the image of a unit on a whole machine: those that `make check-all` runs.
//!
//! Owns this list, apart from `it`, since a machine under QEMU takes all processors for minutes. The image has the
//! profile `bench`, which `make check-all` has made: that of a unit, with a shell on the serial port. Claims that take longer
//! are listed in `whole.rs`.
//!
//! Start at [`starts::first_start`]; [`machine`] is the emulated machine, [`unit`] its disk.
#![forbid(unsafe_code)]
#![allow(clippy::unwrap_used, clippy::panic, clippy::print_stdout, reason = "a claim fails by panicking")]
#![allow(dead_code, reason = "it shares helpers with `whole.rs` and `it`, and needs a part of each")]

mod damage {
    mod boot_copies;
    mod power_cuts;
}
mod machine;
mod network {
    mod dhcp_request;
    mod ports;
}
mod owner {
    pub(crate) mod settings_error;
    mod settings_stick;
}
mod player {
    mod restart;
    mod user_rights;
}
mod starts {
    mod bios;
    pub(crate) mod first_start;
    mod hardware_sample;
    mod kernel_modules;
}
mod unit;
mod updates {
    pub(crate) mod flock_from_stick;
    mod foreign_stick;
    pub(crate) mod next_system;
}
