//! From a source into the store, object by object.
//!
//! Owns resuming after an interruption, the limits of speed and waiting, and that no byte is read twice. The store checks
//! what arrived against the signature. Never chooses what to fetch: `update_run.rs` does.

use crate::fatal::Fatal;
use crate::origin::Origin;
use crate::progress::Progress;
use crate::rate_limit::RateLimit;
use bundle::{FetchItem, Intake, Source, Store, StoreError};
use diagnostics::chain;
use player::now;
use std::io::{ErrorKind, Read};
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;
use tracing::{debug, warn};

/// How much is read at a time.
const CHUNK: u64 = 256 << 10;
/// How often an object is tried without progress.
const TRIES: u32 = 5;
/// The least bytes of it that are progress: a server that hangs up sooner each time is given up, too.
const PROGRESS: u64 = 64 << 10;
/// How long to wait after the first failure of a server; it doubles with each further one.
const PAUSE: Duration = Duration::from_millis(250);

/// A source, and the limits of fetching from it.
pub(crate) struct Fetcher<'e> {
    pub(crate) source: &'e mut Origin,
    pub(crate) rate_limit: RateLimit,
    pub(crate) progress: Progress,
    pub(crate) stop: &'e AtomicBool,
    /// Objects that arrived, and bytes that were read for them.
    pub(crate) objects: usize,
    pub(crate) bytes: u64,
}

impl Fetcher<'_> {
    /// Fetches one object, from where it was left.
    /// Errors: [`Fatal`]. What has arrived stays.
    pub(crate) fn fetch(&mut self, store: &Store, wanted: &FetchItem) -> Result<(), Fatal> {
        let mut tries = 0;
        loop {
            let mut intake = store.intake(wanted)?;
            let begun = intake.have();
            let poured = self.pour(wanted, &mut intake);
            let arrived = intake.have() - begun;
            let trouble = match poured.and_then(|()| Ok(intake.finish()?)) {
                Ok(frozen) => {
                    debug!(clip = wanted.path.as_str(), ?frozen, "object fetched");
                    self.objects += 1;
                    return Ok(());
                }
                Err(trouble) => trouble,
            };
            let is_damaged = matches!(trouble, Fatal::Store(StoreError::Damaged { .. }));
            let is_cut_off = matches!(&trouble, Fatal::Store(StoreError::Incomplete { .. }))
                || matches!(&trouble, Fatal::Read { source, .. } if source.kind() != ErrorKind::NotFound);
            let may_pass = is_damaged || is_cut_off;
            let is_progress = arrived >= PROGRESS && !is_damaged;
            tries = if is_progress { 0 } else { tries + 1 };
            if !may_pass || tries >= TRIES {
                return Err(trouble);
            }
            warn!(clip = wanted.path.as_str(), error = chain(&trouble), "cannot fetch an object, trying again");
            if self.source.is_far() && tries > 0 {
                thread::park_timeout(PAUSE * 2u32.pow(tries - 1));
            }
        }
    }

    /// Reads what is missing of an object.
    fn pour(&mut self, wanted: &FetchItem, intake: &mut Intake<'_>) -> Result<(), Fatal> {
        if intake.missing() == 0 {
            return Ok(());
        }
        let unread = |source| Fatal::Read { name: wanted.path.to_string(), source };
        let mut reader = self.source.object(&wanted.id, wanted.size, intake.have()).map_err(unread)?;
        let mut chunk = vec![0; usize::try_from(CHUNK.min(intake.missing())).unwrap_or(usize::MAX)];
        while intake.missing() > 0 {
            if self.stop.load(Ordering::Relaxed) {
                return Err(Fatal::Stopped);
            }
            let most = usize::try_from(intake.missing()).map_or(chunk.len(), |missing| missing.min(chunk.len()));
            let count = match reader.read(&mut chunk[..most]) {
                Ok(0) => break,
                Ok(count) => count,
                Err(error) if error.kind() == ErrorKind::Interrupted => continue,
                Err(error) => return Err(unread(error)),
            };
            intake.append(&chunk[..count])?;
            self.bytes += count as u64;
            self.progress.moved(count as u64, now());
            let wait = self.rate_limit.after(count as u64, now());
            if !wait.is_zero() {
                thread::park_timeout(wait);
            }
        }
        Ok(())
    }
}
