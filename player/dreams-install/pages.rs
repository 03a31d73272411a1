//! The pages on a screen: which one is visible, and since when.
//!
//! Owns the screen: opens it when there is one, and shows the page again when it is back. Prints the text of every page on
//! standard output, in one line. Never has a word of its own.
//!
//! Start at [`Pages::show`].

use crate::options::ScreenKind;
use crate::page::{Page, SIZE};
use diagnostics::chain;
use player::now;
use screen::{Display, Event, FdStore, KmsSettings, OutputSettings, Pace, Screen, ScreenError, VirtualScreen};
use std::io::{self, Write};
use std::thread;
use std::time::Duration;
use timing::{Nanos, Rate};
use tracing::warn;

/// The rate of pictures, and of the vblanks of a screen in memory.
const FPS: u64 = 30;
const REFRESH_HZ: u64 = 60;
/// The longest wait for one event of the screen: so often keys are read.
const QUIET: Duration = Duration::from_millis(50);
/// The time between two attempts to open a screen, and the longest wait for a flip.
const PAUSE_NS: u64 = 2_000_000_000;

/// The pages on a screen.
pub(crate) struct Pages {
    kind: ScreenKind,
    screen: Option<Box<dyn Screen>>,
    /// When the next attempt to open a screen is due.
    next: Nanos,
    is_told: bool,
    page: Option<Page>,
    /// Whether the page is not on the screen yet.
    is_stale: bool,
    /// When the last picture was committed, while its flip is awaited.
    committed: Option<Nanos>,
    /// Since when the text of the page is visible.
    visible: Option<Nanos>,
}

impl Pages {
    /// None yet, on a screen of this kind.
    pub(crate) fn new(kind: ScreenKind) -> Self {
        let (screen, page, committed, visible) = (None, None, None, None);
        Self { kind, screen, next: Nanos(0), is_told: false, page, is_stale: false, committed, visible }
    }

    /// Shows `page` from the next flip on.
    pub(crate) fn show(&mut self, page: Page) {
        if self.page.as_ref() == Some(&page) {
            return;
        }
        let is_other = self.page.as_ref().is_none_or(|old| (old.title, &old.text) != (page.title, &page.text));
        if is_other {
            self.visible = None;
            let text = format!("{}: {}\n", page.title, page.text.join(" ").replace('\n', ", "));
            // Nobody may listen.
            let _ = io::stdout().write_all(text.as_bytes());
        }
        (self.page, self.is_stale) = (Some(page), true);
    }

    /// For how many milliseconds the text of the page has been visible; `None` if it is not yet.
    pub(crate) fn visible_ms(&self) -> Option<u64> {
        self.visible.map(|since| now().since(since) / 1_000_000)
    }

    /// Waits a moment for the screen.
    pub(crate) fn wait(&mut self) {
        self.open();
        self.light();
        let Some(screen) = &mut self.screen else { return thread::park_timeout(QUIET) };
        match screen.next_event(QUIET) {
            Event::Flip { .. } => {
                self.committed = None;
                if !self.is_stale {
                    self.visible.get_or_insert_with(now);
                }
            }
            Event::Back | Event::Recovered { .. } => (self.committed, self.is_stale) = (None, true),
            Event::Lost { reason } => {
                warn!(reason, "the screen is lost");
                (self.committed, self.visible) = (None, None);
            }
            Event::Vblank { .. } | Event::Asleep | Event::Changed | Event::Idle => {}
        }
    }

    /// Puts the page on the screen, if it is not, and no flip is awaited.
    fn light(&mut self) {
        let is_waiting = self.committed.is_some_and(|at| now().since(at) < PAUSE_NS);
        let (Some(screen), Some(page)) = (&mut self.screen, &self.page) else { return };
        if !self.is_stale || is_waiting {
            return;
        }
        match screen.stage(&page.draw().picture()) {
            Ok(()) => {
                screen.commit();
                (self.committed, self.is_stale) = (Some(now()), false);
            }
            Err(error @ (ScreenError::Size { .. } | ScreenError::Open { .. })) => {
                warn!(error = chain(&error), "cannot show the page");
                self.screen = None;
            }
        }
    }

    /// Opens the screen, if it is time.
    fn open(&mut self) {
        if self.screen.is_some() || now() < self.next {
            return;
        }
        self.next = now().after(PAUSE_NS);
        match screen(self.kind) {
            Ok(screen) => (self.screen, self.is_stale, self.committed) = (Some(screen), true, None),
            Err(error) if !std::mem::replace(&mut self.is_told, true) => {
                warn!(error = chain(&error), "cannot open a screen, trying again");
            }
            Err(_) => {}
        }
    }
}

fn screen(kind: ScreenKind) -> Result<Box<dyn Screen>, ScreenError> {
    let rate = |hz| Rate::new(hz, 1).expect("a whole number of hertz is a rate");
    Ok(match kind {
        ScreenKind::Virtual => Box::new(VirtualScreen::new(SIZE, rate(REFRESH_HZ), Pace::Timer, now)),
        ScreenKind::Kms => Box::new(Display::open(KmsSettings {
            device: None,
            size: SIZE,
            fps: rate(FPS),
            now,
            keeper: FdStore::NOBODY,
            output: OutputSettings::default(),
        })?),
    })
}
