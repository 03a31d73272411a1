//! The player's trace, parsed.
//!
//! Owns the form of its lines, which is part of the contract; a line of another form fails the claim. The claims judge
//! what was played.
//!
//! Start at [`Trace::read`].

use serde_json::Value;
use std::fs;
use std::path::Path;

/// The trace of one run.
#[derive(Debug, Default)]
pub struct Trace {
    /// The screen and its mode, once for every mode and every form of pictures.
    pub starts: Vec<Start>,
    /// Frames in the order of their flips.
    pub flips: Vec<Flip>,
    /// Pairs of clips at joins.
    pub joins: Vec<(String, String)>,
    /// Kinds and messages of faults.
    pub faults: Vec<(String, String)>,
    /// The closing counts; `None` if the player was killed.
    pub end: Option<End>,
}

/// A screen with its mode.
#[derive(Debug)]
pub struct Start {
    /// `kms:/dev/dri/card1 Virtual-1` or `virtual`.
    pub screen: String,
    /// `1280x720@60`: pixels and exact vblanks per second.
    pub mode: String,
    /// The plane's pixel format.
    pub format: String,
}

/// The flip of a frame.
#[derive(Debug)]
pub struct Flip {
    /// The clip's path in the manifest.
    pub clip: String,
    /// The frame's number in its clip, from 0.
    pub frame: u64,
    /// The kernel's vblank counter at the flip.
    pub vblank: u32,
    /// Nanoseconds of the monotonic clock.
    pub t_ns: u64,
    /// Vblanks that it was late.
    pub late: u64,
    /// MD5 of the visible planes, with `--hash`.
    pub hash: Option<String>,
    /// The acknowledgement that lies over it, counted from 1.
    pub mark: Option<u64>,
}

/// The closing counts of a run.
#[derive(Debug, PartialEq, Eq)]
pub struct End {
    pub flips: u64,
    pub late: u64,
    pub repeated: u64,
    pub skipped: u64,
    pub joins: u64,
    pub faults: u64,
}

impl Trace {
    /// Reads the trace at `path`.
    pub fn read(path: &Path) -> Self {
        let text = fs::read_to_string(path);
        Self::parse(&text.unwrap_or_else(|error| panic!("no trace at `{}`: {error}", path.display())))
    }

    /// Parses a trace. A last line that a kill has cut off is left out.
    pub fn parse(text: &str) -> Self {
        let mut trace = Self::default();
        for line in text.split_inclusive('\n').filter(|line| line.ends_with('\n')) {
            trace.take(&event(line));
        }
        trace
    }

    /// Adds one event.
    fn take(&mut self, event: &Value) {
        match text(event, "event").as_str() {
            "start" => {
                assert!(!event["fps"].is_null(), "a start tells its fps: {event}");
                let (screen, mode, format) = (text(event, "screen"), text(event, "mode"), text(event, "format"));
                self.starts.push(Start { screen, mode, format });
            }
            "flip" => self.flips.push(flip(event)),
            "join" => self.joins.push((text(event, "from"), text(event, "to"))),
            "fault" => self.faults.push((text(event, "kind"), text(event, "message"))),
            "end" => self.end = Some(end(event)),
            unknown => panic!("the trace has an event `{unknown}` that the contract does not know"),
        }
    }

    /// The clips in the order of their flips.
    pub fn clips(&self) -> Vec<&str> {
        let mut clips: Vec<&str> = Vec::new();
        let mut before = None;
        for flip in &self.flips {
            let begins = clips.last() != Some(&flip.clip.as_str()) || before.is_some_and(|frame| frame >= flip.frame);
            if begins {
                clips.push(&flip.clip);
            }
            before = Some(flip.frame);
        }
        clips
    }

    /// Exact vblanks per second of the only mode, as numerator and denominator.
    pub fn refresh(&self) -> (u64, u64) {
        let [start] = &self.starts[..] else { panic!("one mode was lit, found {:?}", self.starts) };
        let (_, rate) = start.mode.split_once('@').expect("a mode is WxH@RATE");
        let (num, den) = rate.split_once('/').unwrap_or((rate, "1"));
        (num.parse().unwrap(), den.parse().unwrap())
    }
}

fn event(line: &str) -> Value {
    serde_json::from_str(line).unwrap_or_else(|error| panic!("no JSON in the trace: {error}: {line}"))
}

fn flip(event: &Value) -> Flip {
    Flip {
        clip: text(event, "clip"),
        frame: number(event, "frame"),
        vblank: u32::try_from(number(event, "vblank")).unwrap(),
        t_ns: number(event, "t_ns"),
        late: number(event, "late"),
        hash: event.get("hash").map(|_| text(event, "hash")),
        mark: event.get("mark").map(|_| number(event, "mark")),
    }
}

fn end(event: &Value) -> End {
    End {
        flips: number(event, "flips"),
        late: number(event, "late"),
        repeated: number(event, "repeated"),
        skipped: number(event, "skipped"),
        joins: number(event, "joins"),
        faults: number(event, "faults"),
    }
}

fn text(event: &Value, key: &str) -> String {
    event[key].as_str().unwrap_or_else(|| panic!("`{key}` is no text in {event}")).to_owned()
}

fn number(event: &Value, key: &str) -> u64 {
    event[key].as_u64().unwrap_or_else(|| panic!("`{key}` is no whole number in {event}"))
}
