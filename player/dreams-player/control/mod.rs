//! What changes the picture from outside: brightness, hours, and what lies over it.
//!
//! Owns the three threads that look for these, and one that asks the display itself to switch off and on. Never touches a
//! screen: `pipeline` applies what they found.
//!
//! Start at [`BrightnessControl`].

mod acknowledgement;
mod brightness;
mod display_power;
mod notice_pane;
mod notice_watcher;
mod pane;

pub(crate) use acknowledgement::Acknowledgements;
pub(crate) use brightness::{BrightnessControl, DisplayTarget};
pub(crate) use notice_watcher::NoticeWatcher;
#[cfg(test)]
pub(crate) use pane::Pane;
pub(crate) use pane::{FULL, Overlay, PaneBuffer};
