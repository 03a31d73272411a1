//! Shows a moving test card on a KMS display, and tells in one JSON document what was lit and how evenly.
//!
//! Owns nothing of the player: it is the smallest program that drives a [`Screen`] rightly, to prove a display by.
//! Usage: `test_card [DEVICE] [FRAMES] [WIDTHxHEIGHT] [FPS] [MILLISECONDS]`; it ends after FRAMES flips, or after
//! MILLISECONDS, whichever comes first. `missed` counts the vblanks by which frames came later than their cadence.
#![expect(clippy::print_stdout, reason = "its output is its purpose")]

use screen::{Event, Keeper, KmsScreen, KmsSettings, Picture, Screen, ScreenError};
use std::sync::OnceLock;
use std::time::{Duration, Instant};
use timing::{Cadence, Nanos, Rate, Vblank};

fn main() -> Result<(), ScreenError> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let argument = |index: usize, default: &str| arguments.get(index).map_or(default, String::as_str).to_owned();
    let number = |text: &str| text.parse::<u64>().expect("arguments are numbers");
    let (device, size) = (argument(0, "any"), argument(2, "1280x720"));
    let (width, height) = size.split_once('x').expect("a size is WIDTHxHEIGHT");
    let size = (number(width) as u32, number(height) as u32);
    let fps = Rate::new(number(&argument(3, "60")), 1).expect("a rate is not 0");
    let device = (device != "any").then(|| device.into());
    let screen = KmsScreen::open(KmsSettings { device, size, fps, now, keeper: Keeper::NOBODY })?;
    let until = now().after(number(&argument(4, "3600000")) * 1_000_000);
    println!("{}", Show::new(screen, size, fps).run(number(&argument(1, "600")), until));
    Ok(())
}

/// Nanoseconds since the first call.
#[expect(clippy::disallowed_methods, reason = "a program reads the clock in one place: this one")]
fn now() -> Nanos {
    static ORIGIN: OnceLock<Instant> = OnceLock::new();
    Nanos(ORIGIN.get_or_init(Instant::now).elapsed().as_nanos() as u64)
}

/// The test card on its way through the screen, and what became of it.
struct Show {
    screen: KmsScreen,
    card: Card,
    fps: Rate,
    cadence: Cadence,
    /// For how many vblanks the frame on the glass is to stay.
    hold: u32,
    frame: u64,
    flips: u64,
    missed: i64,
    last: Option<(Vblank, Nanos)>,
    first: Nanos,
    longest_ns: u64,
    dark_since: Option<Nanos>,
    longest_dark_ns: u64,
    lost: u64,
    back: u64,
    recovered: u64,
    reasons: Vec<String>,
}

impl Show {
    fn new(screen: KmsScreen, size: (u32, u32), fps: Rate) -> Self {
        Self {
            screen,
            card: Card::new(size),
            fps,
            cadence: Cadence::new(fps, fps),
            hold: 1,
            frame: 0,
            flips: 0,
            missed: 0,
            last: None,
            first: Nanos(0),
            longest_ns: 0,
            dark_since: None,
            longest_dark_ns: 0,
            lost: 0,
            back: 0,
            recovered: 0,
            reasons: Vec::new(),
        }
    }

    fn run(mut self, frames: u64, until: Nanos) -> String {
        self.start();
        while self.flips < frames && now() < until {
            match self.screen.next_event(Duration::from_nanos(until.since(now()))) {
                Event::Flip { vblank, at } => self.flipped(vblank, at),
                Event::Back => {
                    self.back += 1;
                    self.start();
                }
                Event::Lost { reason } => {
                    self.lost += 1;
                    self.dark_since.get_or_insert(now());
                    self.last = None;
                    self.note(reason);
                }
                Event::Recovered { reason } => {
                    self.recovered += 1;
                    self.note(reason);
                    self.screen.commit();
                }
                Event::Vblank { .. } => self.screen.commit(),
                Event::Asleep | Event::Idle => {}
            }
        }
        self.report()
    }

    fn flipped(&mut self, vblank: Vblank, at: Nanos) {
        self.flips += 1;
        if let Some(since) = self.dark_since.take() {
            self.longest_dark_ns = self.longest_dark_ns.max(now().since(since));
        }
        match self.last.replace((vblank, at)) {
            Some((before, then)) => {
                self.missed += i64::from(vblank.since(before)) - i64::from(self.hold);
                self.longest_ns = self.longest_ns.max(at.since(then));
            }
            None => self.first = at,
        }
        self.hold = self.cadence.hold().max(1);
        self.stage();
        if self.hold == 1 {
            self.screen.commit();
        } else {
            self.screen.notify_at(vblank.after(self.hold - 1));
        }
    }

    /// Lights the first frame of a run.
    fn start(&mut self) {
        if let Some(lit) = self.screen.lit() {
            self.cadence = Cadence::new(self.fps, lit.refresh);
        }
        self.stage();
        self.screen.commit();
    }

    fn stage(&mut self) {
        self.card.draw(self.frame);
        self.frame += 1;
        self.screen.stage(&self.card.picture()).expect("the card is even and as large as was said");
    }

    fn note(&mut self, reason: String) {
        if !self.reasons.contains(&reason) {
            self.reasons.push(reason);
        }
    }

    fn report(&self) -> String {
        let lit = self.screen.lit();
        let text = |text: Option<&String>| text.map_or("null".to_owned(), |text| format!("{text:?}"));
        let span = self.last.map_or(0, |(_, at)| at.since(self.first));
        format!(
            "{{\"screen\":{},\"mode\":{},\"format\":{},\"flips\":{},\"missed\":{},\"span_ns\":{span},\"longest_ns\":{},\
             \"lost\":{},\"back\":{},\"recovered\":{},\"longest_dark_ms\":{},\"dark\":{},\"descriptors\":{},\"reasons\":{:?}}}",
            text(lit.as_ref().map(|lit| &lit.screen)),
            text(lit.as_ref().map(|lit| &lit.mode)),
            text(lit.as_ref().map(|lit| &lit.format)),
            self.flips,
            self.missed,
            self.longest_ns,
            self.lost,
            self.back,
            self.recovered,
            self.longest_dark_ns / 1_000_000,
            self.dark_since.is_some(),
            std::fs::read_dir("/proc/self/fd").map_or(0, Iterator::count),
            self.reasons,
        )
    }
}

/// Colour bars, a grey ramp, and a white bar that runs across.
struct Card {
    size: (u32, u32),
    planes: [Vec<u8>; 3],
}

impl Card {
    /// Y, U and V of 75 % bars in BT.709: white, yellow, cyan, green, magenta, red, blue, black.
    const BARS: [[u8; 3]; 8] = [
        [180, 128, 128],
        [168, 44, 136],
        [145, 147, 44],
        [133, 63, 52],
        [63, 193, 204],
        [51, 109, 212],
        [28, 212, 120],
        [16, 128, 128],
    ];

    fn new(size: (u32, u32)) -> Self {
        let luma = size.0 as usize * size.1 as usize;
        Self { size, planes: [vec![0; luma], vec![0; luma / 4], vec![0; luma / 4]] }
    }

    fn draw(&mut self, frame: u64) {
        for (plane, bytes) in self.planes.iter_mut().enumerate() {
            let half = usize::from(plane > 0);
            let (width, height) = (self.size.0 as usize >> half, self.size.1 as usize >> half);
            let run = (frame as usize * 8 % self.size.0 as usize) >> half;
            for (row, line) in bytes.chunks_exact_mut(width).enumerate() {
                for (column, byte) in line.iter_mut().enumerate() {
                    let ramp = [16 + (column * 219 / width) as u8, 128, 128];
                    let bar = Self::BARS[column * 8 / width];
                    *byte = if row < height * 3 / 4 { bar[plane] } else { ramp[plane] };
                }
                line[run..(run + (8 >> half)).min(width)].fill([235, 128, 128][plane]);
            }
        }
    }

    fn picture(&self) -> Picture<'_> {
        let [y, u, v] = &self.planes;
        let (width, height) = self.size;
        let half = width as usize / 2;
        Picture { width, height, planes: [y, u, v], strides: [width as usize, half, half] }
    }
}
