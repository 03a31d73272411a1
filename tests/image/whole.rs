//! Claims about the image of a unit on a whole machine: nearly all of them, for `make crash`.
//!
//! Owns this list. It has all of `main.rs` but `kernel_modules`, and the claims that take longer; `make crash` leaves out
//! [`starts::boot_time`], which `make bench` measures.
//!
//! Start at [`starts`], [`player`], [`updates`], [`damage`], [`display`], [`network`] and [`owner`].
#![forbid(unsafe_code)]
#![allow(clippy::unwrap_used, clippy::panic, clippy::print_stdout, reason = "a claim fails by panicking")]

mod damage {
    mod bad_sticks;
    pub(crate) mod boot_copies;
    mod boot_copies_matrix;
    mod flocks_disk;
    mod flocks_disk_kept;
    mod hundred_power_cuts;
    mod power_cuts;
}
mod display {
    mod backlight;
    mod display_power;
    mod firmware_framebuffer;
    mod no_display;
    mod picture_gaps;
    mod text_console;
}
mod machine;
mod network {
    mod dhcp_request;
    mod equal_boards;
    mod ports;
    mod wifi;
}
mod owner {
    mod log_on_stick;
    pub(crate) mod settings_error;
    mod votes_file;
}
mod player {
    mod memory_shortage;
    mod restart;
    mod user_rights;
    mod watchdog;
}
mod starts {
    mod arm64;
    mod bios;
    pub(crate) mod boot_time;
    pub(crate) mod first_start;
    mod hardware_matrix;
    mod hardware_sample;
    mod installer;
    mod make_boot;
    mod secure_boot;
    mod usb_disk;
}
mod unit;
mod updates {
    pub(crate) mod flock_from_stick;
    mod foreign_stick;
    pub(crate) mod next_system;
    mod restart_hour;
    mod slots;
}
