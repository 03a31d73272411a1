//! What the machine calls itself.
//!
//! Owns the reading of the host name: a unit that nobody has named is called by it. Never sets it.

use std::io;
use std::path::Path;

/// Where the kernel has it.
pub const HOST_NAME: &str = "/proc/sys/kernel/hostname";
/// Bytes of it that are read, at most.
const LARGEST: u64 = 256;

/// The host name, in lower case.
/// Errors: If it cannot be read.
pub fn host_name() -> io::Result<String> {
    let name = durable::read_plain_text(Path::new(HOST_NAME), LARGEST)?;
    Ok(name.trim().to_lowercase())
}
