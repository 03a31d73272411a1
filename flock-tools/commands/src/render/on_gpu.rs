//! The GPU of `dreams render --on gpu`.
//!
//! Owns its choice and what is told where there is none. Never draws: `flame` does.
//!
//! Start at [`open`].

use flame::{Backend, RenderError};
use flock::ClipHash;
use operations::program::{Exit, Fatal, print};

/// The GPU that draws, with the hash by which frames remember it; tells which it is.
/// Errors: [`Fatal`] where this program cannot use one, or none is there.
pub(super) fn open() -> Result<(Backend, Option<ClipHash>), Fatal> {
    let backend = Backend::gpu().map_err(refused)?;
    let name = backend.name().unwrap_or_default().to_owned();
    print::note(&format!("note: frames are drawn by {name}"));
    let hash = ClipHash::of(name.as_bytes()).expect("reading memory does not fail");
    Ok((backend, Some(hash)))
}

fn refused(error: RenderError) -> Fatal {
    if error == RenderError::NotBuilt {
        let hint = "`cargo build --release --package dreams --features gpu` builds one that can; without --on gpu the \
                    processor renders";
        return Fatal::new(Exit::Malformed, error).hint(hint);
    }
    let hint = "`vulkaninfo --summary` tells what Vulkan finds; without --on gpu the processor renders";
    Fatal::new(Exit::Unreadable, error).hint(hint)
}
