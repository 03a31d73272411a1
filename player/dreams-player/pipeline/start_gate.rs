//! What holds other work back until the first picture is lit.
//!
//! Owns the gate that the flip thread opens. Never holds anybody for long: without a screen there is nothing to compete
//! with.

use player::hold;
use std::sync::{Condvar, Mutex};
use std::time::Duration;

/// How long the first picture may keep others waiting.
const PATIENCE: Duration = Duration::from_millis(500);

/// Open once the first picture is lit.
#[derive(Debug, Default)]
pub(crate) struct StartGate {
    is_open: Mutex<bool>,
    opened: Condvar,
}

impl StartGate {
    /// The first picture is lit.
    pub(crate) fn open(&self) {
        *hold(&self.is_open) = true;
        self.opened.notify_all();
    }

    /// Waits until it is, so as not to take the processor from it; not for ever.
    pub(crate) fn wait(&self) {
        let closed = self.opened.wait_timeout_while(hold(&self.is_open), PATIENCE, |is_open| !*is_open);
        drop(closed);
    }
}
