//! What changes the picture from outside: brightness, hours, and notices over it.
//!
//! Owns the two threads that look for these. Never touches a screen: `pipeline` applies what they found.
//!
//! Start at [`BrightnessControl`].

mod brightness;
mod notice_pane;
mod notice_watcher;

pub(crate) use brightness::{BrightnessControl, DisplayTarget};
pub(crate) use notice_pane::{Overlay, PaneBuffer};
pub(crate) use notice_watcher::NoticeWatcher;
