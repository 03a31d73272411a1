//! The acknowledgement of a press: a small mark over the picture, for a moment.
//!
//! Owns the drawing, a dot in the lower right corner, its duration, and the socket at which `dreams-votes` asks for it. The
//! flip thread never waits for it. Nothing that comes through the socket costs the picture more than the mark: messages are
//! of one form, all others are ignored, and a flood of them is read slowly and lost.
//!
//! Start at [`Acknowledgements::start`].

use crate::control::pane::{CLEAR, Overlay, Pane};
use crate::recording::SharedView;
use diagnostics::chain;
use player::acknowledgement::{MESSAGE, listen};
use player::{ThreadError, threads};
use std::io::ErrorKind;
use std::os::unix::net::UnixDatagram;
use std::path::Path;
use std::sync::Arc;
use std::thread;
use std::time::Duration;
use timing::Nanos;
use tracing::info;

/// How long the mark is shown after a press.
const SHOWN_NS: u64 = 1_500_000_000;
/// The time between two messages that are read.
const PAUSE: Duration = Duration::from_millis(10);
/// The picture's height, or its width if that is less, has so many diameters of the mark: it covers at most 1/484.
const DIAMETERS: u32 = 22;
/// Luma of the mark and of the ring around it: seen on every picture, and calm.
const INK: u8 = 200;
const RING: u8 = 30;
/// The part of the diameter that the ring encloses, in hundredths.
const INNER: u32 = 64;

/// The acknowledgements of a run.
#[derive(Debug, Default)]
pub(crate) struct Acknowledgements {
    /// How many there were.
    count: u32,
    /// Until when the mark is shown, while it is.
    until: Option<Nanos>,
    /// The mark for the pictures of this run.
    drawn: Option<Arc<Pane>>,
}

impl Acknowledgements {
    /// Starts the thread that listens at `path`, for as long as the process lives. If that cannot be done the picture goes on
    /// without.
    /// Errors: If the machine is out of threads.
    pub(crate) fn start(
        path: Option<&Path>,
        view: Arc<SharedView>,
        overlay: Arc<Overlay>,
        now: fn() -> Nanos,
    ) -> Result<(), ThreadError> {
        let Some(path) = path else { return Ok(()) };
        match listen(path) {
            Ok(socket) => {
                let listening = move || Self::default().run(&socket, &view, &overlay, now);
                threads::start("acknowledge", listening).map(drop)
            }
            Err(error) => {
                info!(path = %path.display(), error = chain(&error), "no votes are acknowledged on the picture");
                Ok(())
            }
        }
    }

    /// Listens for ever.
    fn run(mut self, socket: &UnixDatagram, view: &SharedView, overlay: &Overlay, now: fn() -> Nanos) {
        let mut buffer = [0; MESSAGE.len() + 1];
        loop {
            let wait = self.wait(now());
            let received = socket.set_read_timeout(wait).and_then(|()| socket.recv(&mut buffer));
            match received {
                Ok(length) if buffer[..length] == *MESSAGE => {
                    if let (Some(size), _) = view.size_and_notes() {
                        overlay.set_mark(Some(self.told(size, now())));
                    }
                    thread::park_timeout(PAUSE);
                }
                Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::Interrupted) => {}
                Ok(_) | Err(_) => thread::park_timeout(PAUSE),
            }
            if self.ends(now()) {
                overlay.set_mark(None);
            }
        }
    }

    /// How long there is nothing to do but to listen; `None` for ever.
    fn wait(&self, now: Nanos) -> Option<Duration> {
        self.until.map(|until| Duration::from_nanos(until.since(now).max(1_000_000)))
    }

    /// A press is acknowledged at `now`, over pictures of this size. Returns the mark, with its number from 1.
    fn told(&mut self, size: (u32, u32), now: Nanos) -> (u32, Arc<Pane>) {
        self.count = self.count.wrapping_add(1);
        self.until = Some(now.after(SHOWN_NS));
        let fits = self.drawn.take().filter(|drawn| drawn.picture == size);
        let drawn = fits.unwrap_or_else(|| Arc::new(mark(size)));
        self.drawn = Some(Arc::clone(&drawn));
        (self.count, drawn)
    }

    /// Whether the mark is over by `now`; told once.
    fn ends(&mut self, now: Nanos) -> bool {
        self.until.take_if(|until| *until <= now).is_some()
    }
}

/// The mark for pictures of this size.
fn mark((width, height): (u32, u32)) -> Pane {
    let diameter = (width.min(height) / DIAMETERS).max(2) & !1;
    let at = ((width.saturating_sub(2 * diameter)) & !1, (height.saturating_sub(2 * diameter)) & !1);
    // From the middle, in half pixels.
    let squared = |x: u32, y: u32| {
        let [x, y] = [x, y].map(|place| (2 * place + 1).abs_diff(diameter));
        x * x + y * y
    };
    let luma = |x: u32, y: u32| match squared(x, y) {
        distance if distance * 10_000 <= diameter * diameter * INNER * INNER => INK,
        distance if distance <= diameter * diameter => RING,
        _ => CLEAR,
    };
    let pixels = (0..diameter).flat_map(|y| (0..diameter).map(move |x| luma(x, y)));
    Pane { picture: (width, height), at, size: (diameter, diameter), luma: pixels.collect() }
}

#[cfg(test)]
mod tests {
    use super::{Acknowledgements, SHOWN_NS, mark};
    use crate::control::pane::{FULL, Overlay, PaneBuffer};
    use screen::Picture;
    use std::sync::Arc;
    use timing::Nanos;

    #[test]
    fn the_mark_is_in_a_corner_and_covers_at_most_a_four_hundredth_of_the_picture() {
        for (width, height) in [(640u32, 480u32), (1280, 720), (3840, 2160), (720, 1280), (720, 720), (64, 48), (2, 2)]
        {
            let overlay = Overlay::default();
            overlay.set_mark(Some((1, Arc::new(mark((width, height))))));
            let ground = vec![90; (width * height) as usize];
            let colour = vec![77; ((width / 2) * (height / 2)) as usize];
            let (wide, half) = (width as usize, width as usize / 2);
            let picture = Picture { width, height, planes: [&ground, &colour, &colour], strides: [wide, half, half] };
            let mut memory = PaneBuffer::default();
            let over = overlay.get().over(&picture, FULL, &mut memory);
            let changed = over.planes[0].iter().filter(|luma| **luma != 90).count();
            assert!(changed > 0 && (changed * 400 <= ground.len() || width < 64), "{changed} of {width}x{height}");
            let elsewhere = |at: usize| at % wide < wide / 2 || at / wide < height as usize / 2;
            let stray = (0..ground.len()).filter(|at| elsewhere(*at) && over.planes[0][*at] != 90).count();
            assert!(stray == 0 || width < 64, "it lies in the lower right corner");
            let grey = over.planes[1].iter().filter(|sample| **sample != 77).count();
            assert!(grey * 400 <= colour.len() || width < 64, "{grey} of {width}x{height} have lost their colour");
        }
    }

    #[test]
    fn a_mark_is_shown_for_a_second_and_a_half_after_the_last_press() {
        let mut marks = Acknowledgements::default();
        let (first, drawn) = marks.told((640, 480), Nanos(0));
        let (second, again) = marks.told((640, 480), Nanos(9));
        assert!((first, second) == (1, 2) && Arc::ptr_eq(&drawn, &again), "it is drawn once");
        assert_eq!([SHOWN_NS, SHOWN_NS + 9, SHOWN_NS + 10].map(|at| marks.ends(Nanos(at))), [false, true, false]);
        assert_eq!(marks.told((1280, 720), Nanos(9)).1.picture, (1280, 720));
    }
}
