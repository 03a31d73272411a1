//! Progress, on stderr: a bar on a terminal, elsewhere none, or a line now and then.
//!
//! Owns the look of a bar, the same for every command, and how often a line is printed. The callers count.

use std::io::{self, IsTerminal};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use indicatif::{HumanDuration, ProgressBar, ProgressStyle};

use super::now::Stopwatch;
use super::print;

/// The shortest time between two lines where there is no terminal.
const BETWEEN_LINES: Duration = Duration::from_secs(30);

/// A bar of `length` steps, headed by `what`.
pub fn bar(what: &'static str, length: usize) -> ProgressBar {
    drawn(what, length as u64, "{prefix} {bar:40} {pos}/{len} {eta}")
}

/// A bar of `length` bytes, headed by `what`.
pub fn bytes(what: &'static str, length: u64) -> ProgressBar {
    drawn(what, length, "{prefix} {bar:40} {decimal_bytes}/{decimal_total_bytes} {decimal_bytes_per_sec} {eta}")
}

fn drawn(what: &'static str, length: u64, template: &str) -> ProgressBar {
    if !io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let style = ProgressStyle::with_template(template).expect("the template is well formed");
    ProgressBar::new(length).with_style(style).with_prefix(what)
}

/// The progress of a long rendering in frames, with the time that is left: a bar on a terminal, elsewhere a line at each
/// percent, at most one in half a minute.
#[derive(Debug)]
pub struct FrameProgress {
    bar: ProgressBar,
    /// `None` where the bar is seen, or nothing is to be.
    lines: Option<Mutex<Lines>>,
}

/// The lines so far.
#[derive(Debug)]
struct Lines {
    watch: Stopwatch,
    last: Duration,
    percent: u64,
}

impl FrameProgress {
    /// Of `frames` frames.
    pub fn new(frames: u64) -> Self {
        let bar = drawn("", frames, "{wide_bar} {pos}/{len} frames, {eta} to go{msg}");
        let is_seen = io::stderr().is_terminal();
        let lines = Lines { watch: Stopwatch::start(), last: Duration::ZERO, percent: 0 };
        bar.set_length(frames);
        Self { bar, lines: (!is_seen).then(|| Mutex::new(lines)) }
    }

    /// One that shows nothing.
    pub fn hidden() -> Self {
        Self { bar: ProgressBar::hidden(), lines: None }
    }

    /// So many more frames are finished.
    pub fn add(&self, frames: u64) {
        self.bar.inc(frames);
        let Some(lines) = &self.lines else { return };
        let mut lines = lines.lock().unwrap_or_else(PoisonError::into_inner);
        let since = lines.watch.wall();
        let (done, all) = (self.bar.position(), self.bar.length().unwrap_or_default());
        if let Some(line) = lines.next(done, all, since) {
            print::note(&line);
        }
    }

    /// So many frames need not be rendered.
    pub fn skip(&self, frames: u64) {
        self.bar.dec_length(frames);
    }

    /// What is told beside the bar, on a terminal.
    pub fn tell(&self, state: &str) {
        self.bar.set_message(if state.is_empty() { String::new() } else { format!("; {state}") });
    }

    /// Runs `print`, which prints lines, without the bar in its way.
    pub fn suspend<R>(&self, print: impl FnOnce() -> R) -> R {
        self.bar.suspend(print)
    }

    /// Takes the bar away.
    pub fn end(&self) {
        self.bar.finish_and_clear();
    }
}

impl Lines {
    /// The line to print when `done` frames of `all` are finished after the time `since`, if one is due.
    fn next(&mut self, done: u64, all: u64, since: Duration) -> Option<String> {
        let percent = (100 * done).checked_div(all)?;
        if percent <= self.percent || since < self.last + BETWEEN_LINES || done == 0 {
            return None;
        }
        (self.percent, self.last) = (percent, since);
        let left = since.mul_f64(all.saturating_sub(done) as f64 / done as f64);
        Some(format!("{done} of {all} frames ({percent} %), {} to go", HumanDuration(left)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_comes_at_a_new_percent_and_not_too_often_and_tells_the_time_that_is_left() {
        let mut lines = Lines { watch: Stopwatch::start(), last: Duration::ZERO, percent: 0 };
        let mut next = |done, seconds| lines.next(done, 1000, Duration::from_secs(seconds));
        assert_eq!(next(100, 10), None, "too early");
        assert_eq!(next(100, 3600).as_deref(), Some("100 of 1000 frames (10 %), 9 hours to go"));
        assert_eq!(next(105, 3900), None, "the same percent");
        assert_eq!(next(200, 3620), None, "too soon");
        assert_eq!(next(1000, 7200).as_deref(), Some("1000 of 1000 frames (100 %), 0 seconds to go"));
        assert_eq!(lines.next(0, 0, Duration::from_mins(150)), None, "nothing to do");
    }
}
