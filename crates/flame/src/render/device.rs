//! A processor of another kind than this machine's own.
//!
//! Owns what the renderer asks of it. Never chooses one: `backend.rs` does.
//!
//! Start at [`Device`].

use std::fmt::Debug;
use std::sync::atomic::AtomicBool;

use super::RenderError;
use super::histogram::Sums;
use super::shot::Shot;

/// A processor of another kind.
pub(crate) trait Device: Debug + Send + Sync {
    /// Its name, with that of its driver.
    fn name(&self) -> &str;

    /// Draws all samples of `shot` and adds them to `sums`; once `stop` is set, fewer. Returns how many samples that were,
    /// seen or not.
    /// Errors: [`RenderError`] if the device fails, or lacks memory.
    fn draw(&self, shot: &Shot, sums: &mut Sums, stop: &AtomicBool) -> Result<u64, RenderError>;
}
