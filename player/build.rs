//! Tells the linker where a unit keeps the libraries that are the player's own, and what not to take from the C library.
//!
//! Owns the one path, relative to the program; what lies there `image-build/ffmpeg/build` makes. Where nothing does,
//! the system's libraries are taken. And the names that the standard library would use to start a program if the C library
//! has them: that of Debian 12 does not, and would refuse a program that names them.

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rustc-link-arg-bins=-Wl,-rpath,$ORIGIN/../lib/dreams-player");
    println!("cargo::rustc-link-arg-bins=-Wl,--defsym=pidfd_spawnp=0,--defsym=pidfd_getpid=0");
}
