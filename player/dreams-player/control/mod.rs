//! What changes the picture from outside: brightness, hours, and notices over it.
//!
//! Owns the two threads that look for these. Never touches a screen: `pipeline` takes what they found.
//!
//! Start at [`brightness::LightingControl`].

pub(crate) mod brightness;
pub(crate) mod notice_pane;
pub(crate) mod notice_watcher;
