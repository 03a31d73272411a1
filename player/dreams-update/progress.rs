//! How far an update is, told to people in front of the picture.
//!
//! Owns the file that the player draws from, and how often it is written. That it cannot be written stops nothing.

use crate::sentences;
use diagnostics::chain;
use player::Notice;
use std::path::PathBuf;
use std::time::Duration;
use timing::Nanos;
use tracing::debug;

/// The time between two notices.
const OFTEN: Duration = Duration::from_millis(500);

/// The notices of one update.
#[derive(Debug)]
pub(crate) struct Progress {
    notice: Option<PathBuf>,
    /// What is coming.
    coming: &'static str,
    total: u64,
    done: u64,
    told: Option<Nanos>,
}

impl Progress {
    /// Tells through the file `notice`, if there is one.
    pub(crate) fn new(notice: Option<PathBuf>) -> Self {
        Self { notice, coming: sentences::COMING, total: 0, done: 0, told: None }
    }

    /// There are `total` bytes, of which `done` are here.
    pub(crate) fn begins(&mut self, total: u64, done: u64, now: Nanos) {
        (self.total, self.done, self.told) = (total, done, None);
        self.moved(0, now);
    }

    /// A system comes next.
    pub(crate) fn is_of_a_system(&mut self) {
        self.coming = sentences::SYSTEM_COMING;
    }

    /// `bytes` more are here.
    pub(crate) fn moved(&mut self, bytes: u64, now: Nanos) {
        self.done = self.done.saturating_add(bytes).min(self.total);
        if self.told.is_none_or(|told| u128::from(now.since(told)) >= OFTEN.as_nanos()) {
            self.told = Some(now);
            let thousandths = u128::from(self.done) * 1_000 / u128::from(self.total.max(1));
            self.tell(self.coming, u16::try_from(thousandths).ok());
        }
    }

    /// It is over, and that is what there is to say.
    pub(crate) fn ended(&self, text: &str) {
        self.tell(text, None);
    }

    fn tell(&self, text: &str, thousandths: Option<u16>) {
        let Some(path) = &self.notice else { return };
        if let Err(error) = (Notice { text: text.to_owned(), thousandths }).tell(path) {
            debug!(path = %path.display(), error = chain(&error), "cannot write the notice about the progress");
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{OFTEN, Progress};
    use player::Notice;
    use timing::Nanos;

    #[test]
    fn progress_is_told_now_and_then_and_the_end_at_once() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("notice");
        let told = || Notice::read(&path).map(|notice| notice.thousandths);
        let mut progress = Progress::new(Some(path.clone()));
        progress.begins(1_000, 250, Nanos(0));
        assert_eq!(told(), Some(Some(250)));
        progress.moved(250, Nanos(1));
        assert_eq!(told(), Some(Some(250)), "not so soon");
        progress.moved(250, Nanos(u64::try_from(OFTEN.as_nanos()).unwrap()));
        assert_eq!(told(), Some(Some(750)));
        progress.ended("Done.");
        assert_eq!(told(), Some(None));
        progress.begins(0, 0, Nanos(0));
        assert_eq!(told(), Some(Some(0)), "nothing to fetch is no division by nothing");
    }
}
