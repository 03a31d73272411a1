//! Progress bars: on a terminal, and nowhere else.
//!
//! Owns how a bar looks, the same for every command. Never counts: the work does.

use std::io::{self, IsTerminal};

use indicatif::{ProgressBar, ProgressStyle};

/// A bar of `length` steps, headed by `what`.
pub(crate) fn bar(what: &'static str, length: usize) -> ProgressBar {
    if !io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let style = ProgressStyle::with_template("{prefix} {bar:40} {pos}/{len} {eta}");
    ProgressBar::new(length as u64).with_style(style.expect("the template is well formed")).with_prefix(what)
}
