//! The claims on whole machines that take longer, and nearly all of `main.rs`: `make crash` tries them.
//!
//! Owns no more than that list.
//!
//! Start at [`hundred`], [`arm64`], [`backlight`], [`bad_sticks`], [`booting`], [`closely`], [`console`], [`dark`], [`damage`],
//! [`damages`], [`firmware`], [`flocks_disk`], [`hanging`], [`log`], [`machines`], [`memory`], [`restart`], [`secure`],
//! [`slots`], [`twins`], [`usb`] and [`wifi`]; [`soon`] is only measured: `make bench` does.
#![forbid(unsafe_code)]
#![allow(clippy::unwrap_used, clippy::panic, clippy::print_stdout, reason = "a claim fails by panicking")]

mod all_ports;
mod arm64;
mod arriving;
mod backlight;
mod bad_sticks;
mod booting;
#[path = "../it/clips.rs"]
#[allow(dead_code, reason = "`it` needs the rest")]
mod clips;
mod closely;
mod console;
mod cuts;
mod damage;
mod damages;
mod dark;
mod direct;
mod disk;
mod fences;
mod firmware;
mod flocks_disk;
mod gallery;
mod hanging;
mod hardware;
mod hundred;
mod lease;
mod log;
mod loss;
mod machine;
mod machines;
mod matrix;
mod memory;
mod mistake;
mod monitor;
mod neighbour;
mod now;
mod path;
mod picture;
mod player;
mod ports;
#[path = "../it/programs.rs"]
#[allow(dead_code, reason = "`it` needs the rest")]
mod programs;
mod qemu;
mod redundant;
mod restart;
mod secure;
mod serial;
mod slots;
mod soon;
mod starting;
mod stick;
mod system;
mod twins;
mod unit;
mod usb;
mod wifi;
