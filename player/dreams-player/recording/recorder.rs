//! The scribe: a thread that writes down what happens, so that the flip thread never waits for a disk.
//!
//! Owns the trace file, the log lines about playing and the words to systemd. Never decides anything.
//! What the lines look like is `trace.rs`.

use crate::recording::tally::Tally;
use crate::recording::trace::Line;
use crate::stream::scheduled_clip::Turn;
use player::ending::chain;
use player::threads::{self, ThreadError};
use screen::Lit;
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

/// How many notes may wait, where a vblank does not: a minute of flips, for the slowest disk.
const WAITING: usize = 4_096;

/// Something to write down.
#[derive(Clone, Debug)]
pub(crate) enum Note {
    /// The screen is taken.
    Start { lit: Arc<Lit>, fps: Rate },
    /// A picture arrived on the glass.
    Flip { turn: Option<Arc<Turn>>, frame: u32, vblank: Vblank, at: Nanos, late: u32, hash: Option<[u8; 16]> },
    /// The picture that arrives now is another clip's than the one before.
    Join { from: Arc<Turn>, to: Arc<Turn> },
    /// Something went wrong.
    Fault { kind: &'static str, message: String, is_repeated: bool },
    /// The first picture is on the glass.
    Ready,
    /// Playback is alive.
    Alive,
    /// The run is over.
    End { tally: Tally, faults: u64 },
}

/// The flip thread's way to the scribe; clones reach the same one.
#[derive(Clone, Debug)]
pub(crate) struct Scribe {
    notes: SyncSender<Note>,
    /// Wait until a line is written before doing what the next one tells: right where no vblank waits.
    is_patient: bool,
    /// Whether there is a trace: nothing else needs to know of every flip.
    is_traced: bool,
    lost: Arc<AtomicU64>,
}

impl Scribe {
    /// Starts the thread. It ends after [`Note::End`]. A patient scribe is waited for: what is not in the trace yet
    /// has hardly happened, so that a player that is killed has told everything.
    ///
    /// # Errors
    /// [`ThreadError`].
    pub(crate) fn start(trace: Option<Trace>, is_patient: bool) -> Result<(Self, JoinHandle<()>), ThreadError> {
        let (notes, inbox) = sync_channel(if is_patient { 0 } else { WAITING });
        let lost = Arc::new(AtomicU64::new(0));
        let scribe = Self { notes, is_patient, is_traced: trace.is_some(), lost: Arc::clone(&lost) };
        let work = move || write_down(&inbox, trace, is_patient, &lost);
        Ok((scribe, threads::start("recorder", work)?))
    }

    /// Writes `note` down soon.
    pub(crate) fn note(&self, note: Note) {
        if !self.is_traced && matches!(note, Note::Flip { .. }) {
            return;
        }
        if self.is_patient || matches!(note, Note::End { .. }) {
            // The scribe is gone only after the end of the run, when there is nothing left to tell. The end is told
            // however full the shelf is: the scribe would wait for it. If that takes for ever a signal ends it all.
            self.notes.send(note).ok();
        } else if let Err(TrySendError::Full(_)) = self.notes.try_send(note) {
            self.lost.fetch_add(1, Ordering::Relaxed);
        }
    }

    /// A scribe that writes nothing down: the notes are to be read by a test.
    #[cfg(test)]
    pub(crate) fn on_a_shelf() -> (Self, Receiver<Note>) {
        let (notes, shelf) = sync_channel(WAITING);
        (Self { notes, is_patient: false, is_traced: true, lost: Arc::default() }, shelf)
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
    ///
    /// # Errors
    /// What the file system says.
    pub(crate) fn create(path: &Path) -> io::Result<Self> {
        Ok(Self { path: path.to_owned(), file: BufWriter::new(File::create(path)?) })
    }

    fn write(&mut self, line: &Line) -> io::Result<()> {
        serde_json::to_writer(&mut self.file, line)?;
        self.file.write_all(b"\n")
    }
}

fn write_down(inbox: &Receiver<Note>, mut trace: Option<Trace>, is_patient: bool, lost: &AtomicU64) {
    loop {
        let note = match inbox.try_recv() {
            Ok(note) => note,
            Err(TryRecvError::Disconnected) => return,
            Err(TryRecvError::Empty) => {
                // Nothing waits: whoever reads the trace sees everything so far, even if we are killed now.
                attempt(&mut trace, |trace| trace.file.flush());
                let Ok(note) = inbox.recv() else { return };
                note
            }
        };
        if let Some(line) = Line::of(&note) {
            attempt(&mut trace, |trace| trace.write(&line));
            if is_patient {
                attempt(&mut trace, |trace| trace.file.flush());
            }
        }
        log(&note);
        if matches!(note, Note::End { .. }) {
            attempt(&mut trace, |trace| trace.file.flush());
            let lost = lost.load(Ordering::Relaxed);
            if lost > 0 {
                warn!(lost, "trace is incomplete: its disk was too slow");
            }
            return;
        }
    }
}

/// Does something to the trace; gives the trace up if that fails.
fn attempt(trace: &mut Option<Trace>, work: impl FnOnce(&mut Trace) -> io::Result<()>) {
    let Some(open) = trace else { return };
    if let Err(error) = work(open) {
        warn!(path = %open.path.display(), error = chain(&error), "trace given up: it cannot be written");
        *trace = None;
    }
}

fn log(note: &Note) {
    match note {
        Note::Start { lit, fps } => {
            info!(screen = lit.screen, mode = lit.mode, format = lit.format, %fps, "screen taken");
            if fps.span_ns(1_000) < lit.refresh.span_ns(1_000) {
                warn!(%fps, refresh = %lit.refresh, "the flock is faster than the screen: it is played slower, and whole");
            }
        }
        Note::Join { from, to } => debug!(from = from.clip.as_str(), to = to.clip.as_str(), "join"),
        Note::Fault { kind, message, is_repeated: true } => debug!(kind, "{message}"),
        Note::Fault { kind, message, is_repeated: false } => warn!(kind, "{message}"),
        Note::Ready => tell_systemd(NotifyState::Ready),
        Note::Alive => tell_systemd(NotifyState::Watchdog),
        Note::End { tally, faults } => {
            tell_systemd(NotifyState::Stopping);
            info!(flips = tally.flips, late = tally.late, joins = tally.joins, faults, "run ended");
        }
        Note::Flip { .. } => {}
    }
}

fn tell_systemd(state: NotifyState<'_>) {
    if let Err(error) = sd_notify::notify(&[state]) {
        debug!(error = chain(&error), "cannot tell systemd");
    }
}

#[cfg(test)]
mod tests {
    use super::{Note, Scribe, WAITING};
    use crate::recording::tally::Tally;
    use std::thread;

    #[test]
    fn the_end_is_told_however_much_was_lost_before() {
        let (scribe, notes) = Scribe::on_a_shelf();
        for _ in 0..WAITING + 9 {
            scribe.note(Note::Alive);
        }
        let ending = thread::spawn(move || scribe.note(Note::End { tally: Tally::default(), faults: 0 }));
        assert!(matches!(notes.iter().last(), Some(Note::End { .. })));
        ending.join().unwrap();
    }
}
