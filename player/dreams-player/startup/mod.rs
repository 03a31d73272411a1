//! How the first picture gets onto the screen: before systemd, by the player, or as the last resort.
//!
//! Owns the opening of the screen, the first picture of a unit's start and its hand-over, and the still picture of the
//! last resort. Never decodes more than one frame.
//!
//! Start at [`screen_opening::screen`].

pub(crate) mod handover;
pub(crate) mod prelude;
pub(crate) mod screen_opening;
pub(crate) mod signals;
pub(crate) mod still;
