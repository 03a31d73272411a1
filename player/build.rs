//! Tells the linker where a unit keeps the libraries that are the player's own.
//!
//! Owns the one path, relative to the program; what lies there `image-build/ffmpeg/build` makes. Where nothing does,
//! the system's libraries are taken.

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rustc-link-arg-bins=-Wl,-rpath,$ORIGIN/../lib/dreams-player");
}
