//! Progress bars, on a terminal only.
//!
//! Owns the look of a bar, the same for every command. The callers count.

use std::io::{self, IsTerminal};

use indicatif::{ProgressBar, ProgressStyle};

/// A bar of `length` steps, headed by `what`.
pub(crate) fn bar(what: &'static str, length: usize) -> ProgressBar {
    drawn(what, length as u64, "{prefix} {bar:40} {pos}/{len} {eta}")
}

/// A bar of `length` bytes, headed by `what`.
pub(crate) fn bytes(what: &'static str, length: u64) -> ProgressBar {
    drawn(what, length, "{prefix} {bar:40} {decimal_bytes}/{decimal_total_bytes} {decimal_bytes_per_sec} {eta}")
}

fn drawn(what: &'static str, length: u64, template: &str) -> ProgressBar {
    if !io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let style = ProgressStyle::with_template(template).expect("the template is well formed");
    ProgressBar::new(length).with_style(style).with_prefix(what)
}
