//! The recorder: a thread that writes down what happens, so that the flip thread never waits for a disk.
//!
//! Owns the trace file, the log lines about playing and the messages to systemd (READY, WATCHDOG, STOPPING). Never
//! decides anything. The form of the trace lines is `trace.rs`.

use crate::recording::trace::Line;
use crate::recording::view::Tally;
use crate::stream::ScheduledClip;
use diagnostics::chain;
use player::{ThreadError, threads};
use screen::ScreenInfo;
use sd_notify::NotifyState;
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, TryRecvError, TrySendError, sync_channel};
use std::thread::JoinHandle;
use timing::{Nanos, Rate, Vblank};
use tracing::{debug, info, warn};

/// How many records may wait where a vblank does not: a minute of flips, for the slowest disk.
const WAITING: usize = 4_096;

/// Something that happened.
#[derive(Clone, Debug)]
pub(crate) enum Record {
    /// The screen is taken.
    Start { lit: Arc<ScreenInfo>, fps: Rate },
    /// A picture arrived on the glass.
    Flip {
        clip: Option<Arc<ScheduledClip>>,
        frame: u32,
        vblank: Vblank,
        at: Nanos,
        late: u32,
        hash: Option<[u8; 16]>,
        mark: Option<u32>,
    },
    /// The picture that arrives now is another clip's than the one before.
    Join { from: Arc<ScheduledClip>, to: Arc<ScheduledClip> },
    /// Something went wrong.
    Fault { kind: &'static str, message: String, is_repeated: bool },
    /// The first picture is on the glass.
    Ready,
    /// Playback is alive.
    Alive,
    /// The run is over.
    End { tally: Tally, faults: u64 },
}

/// The way to the recorder; clones reach the same one.
#[derive(Clone, Debug)]
pub(crate) struct Recorder {
    records: SyncSender<Record>,
    /// Whether each record is written before the run goes on: right where no vblank waits.
    is_synchronous: bool,
    /// Whether there is a trace: nothing else needs every flip.
    is_traced: bool,
    lost: Arc<AtomicU64>,
}

impl Recorder {
    /// Starts the thread. It ends after [`Record::End`]. If it `is_synchronous` each record is waited for, so that the
    /// trace of a player that is killed is complete.
    pub(crate) fn start(trace: Option<Trace>, is_synchronous: bool) -> Result<(Self, JoinHandle<()>), ThreadError> {
        let (records, inbox) = sync_channel(if is_synchronous { 0 } else { WAITING });
        let lost = Arc::new(AtomicU64::new(0));
        let recorder = Self { records, is_synchronous, is_traced: trace.is_some(), lost: Arc::clone(&lost) };
        let work = move || write_down(&inbox, trace, is_synchronous, &lost);
        Ok((recorder, threads::start("recorder", work)?))
    }

    /// Writes `record` down soon.
    pub(crate) fn record(&self, record: Record) {
        if !self.is_traced && matches!(record, Record::Flip { .. }) {
            return;
        }
        if self.is_synchronous || matches!(record, Record::End { .. }) {
            // The recorder ends only after the end of the run, when there is nothing left to record. The end is recorded
            // however full the queue is: the recorder waits for it. If that takes too long a signal ends the process.
            self.records.send(record).ok();
        } else if let Err(TrySendError::Full(_)) = self.records.try_send(record) {
            self.lost.fetch_add(1, Ordering::Relaxed);
        }
    }

    /// A recorder that writes nothing: a test reads the records.
    #[cfg(test)]
    pub(crate) fn for_tests() -> (Self, Receiver<Record>) {
        let (records, queue) = sync_channel(WAITING);
        (Self { records, is_synchronous: false, is_traced: true, lost: Arc::default() }, queue)
    }
}

/// The file that the trace is written to.
#[derive(Debug)]
pub(crate) struct Trace {
    path: PathBuf,
    file: BufWriter<File>,
}

impl Trace {
    /// Creates the file at `path`.
    pub(crate) fn create(path: &Path) -> io::Result<Self> {
        Ok(Self { path: path.to_owned(), file: BufWriter::new(File::create(path)?) })
    }

    fn write(&mut self, line: &Line) -> io::Result<()> {
        serde_json::to_writer(&mut self.file, line)?;
        self.file.write_all(b"\n")
    }
}

fn write_down(inbox: &Receiver<Record>, mut trace: Option<Trace>, is_synchronous: bool, lost: &AtomicU64) {
    loop {
        let record = match inbox.try_recv() {
            Ok(record) => record,
            Err(TryRecvError::Disconnected) => return,
            Err(TryRecvError::Empty) => {
                // Nothing waits: a reader of the trace sees everything so far, even if the player is killed now.
                attempt(&mut trace, |trace| trace.file.flush());
                let Ok(record) = inbox.recv() else { return };
                record
            }
        };
        if let Some(line) = Line::of(&record) {
            attempt(&mut trace, |trace| trace.write(&line));
            if is_synchronous {
                attempt(&mut trace, |trace| trace.file.flush());
            }
        }
        log(&record);
        if matches!(record, Record::End { .. }) {
            attempt(&mut trace, |trace| trace.file.flush());
            let lost = lost.load(Ordering::Relaxed);
            if lost > 0 {
                warn!(lost_lines = lost, "the playback trace is incomplete: the disk was too slow");
            }
            return;
        }
    }
}

/// Does something to the trace; gives the trace up if that fails.
fn attempt(trace: &mut Option<Trace>, work: impl FnOnce(&mut Trace) -> io::Result<()>) {
    let Some(open) = trace else { return };
    if let Err(error) = work(open) {
        warn!(path = %open.path.display(), error = chain(&error), "cannot write the trace, no more of it is written");
        *trace = None;
    }
}

fn log(record: &Record) {
    match record {
        Record::Start { lit, fps } => {
            info!(screen = lit.screen, mode = lit.mode, format = lit.format, %fps, "screen taken");
            if fps.span_ns(1_000) < lit.refresh.span_ns(1_000) {
                warn!(%fps, refresh = %lit.refresh, "the flock has more frames per second than the screen: it is played slower");
            }
        }
        Record::Join { from, to } => debug!(from = from.clip.as_str(), to = to.clip.as_str(), "join"),
        Record::Fault { kind, message, is_repeated: true } => debug!(kind, "{message}"),
        Record::Fault { kind, message, is_repeated: false } => warn!(kind, "{message}"),
        Record::Ready => tell_systemd(NotifyState::Ready),
        Record::Alive => tell_systemd(NotifyState::Watchdog),
        Record::End { tally, faults } => {
            tell_systemd(NotifyState::Stopping);
            info!(flips = tally.flips, late = tally.late, joins = tally.joins, faults, "run ended");
        }
        Record::Flip { .. } => {}
    }
}

fn tell_systemd(state: NotifyState<'_>) {
    if let Err(error) = sd_notify::notify(&[state]) {
        debug!(error = chain(&error), "cannot notify systemd");
    }
}

#[cfg(test)]
mod tests {
    use super::{Record, Recorder, WAITING};
    use crate::recording::view::Tally;
    use std::thread;

    #[test]
    fn the_end_is_told_however_much_was_lost_before() {
        let (recorder, records) = Recorder::for_tests();
        for _ in 0..WAITING + 9 {
            recorder.record(Record::Alive);
        }
        let ending = thread::spawn(move || recorder.record(Record::End { tally: Tally::default(), faults: 0 }));
        assert!(matches!(records.iter().last(), Some(Record::End { .. })));
        ending.join().unwrap();
    }
}
