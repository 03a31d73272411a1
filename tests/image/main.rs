//! Claims about the image of a unit, tried on a whole machine: from power to art, and back to art whatever happens.
//!
//! Owns its own folder of claims, since a machine under QEMU takes all processors for minutes. The image is the one of
//! the profile `bench`, which `make check` has made: that of a wall, with a shell on the serial port. What takes longer
//! stands in `whole.rs` beside these.
//!
//! Start at [`starting`]; what a machine is, says [`machine`].
#![forbid(unsafe_code)]
#![allow(clippy::unwrap_used, clippy::panic, clippy::print_stdout, reason = "a claim fails by panicking")]
#![allow(dead_code, reason = "what `whole.rs` needs is here, too")]

mod arriving;
#[path = "../it/clips.rs"]
#[allow(dead_code, reason = "`it` needs the rest")]
mod clips;
mod closure;
mod cuts;
mod direct;
mod disk;
mod fences;
mod gallery;
mod hardware;
mod lease;
mod loss;
mod machine;
mod matrix;
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
mod serial;
#[allow(dead_code, reason = "it is only measured from `whole.rs`")]
mod starting;
mod stick;
mod system;
mod unit;
