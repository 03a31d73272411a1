//! The lines of the trace.
//!
//! Owns their fields, which other tools rely on. Never writes them: `recorder.rs` does.

use crate::recording::recorder::Record;
use crate::recording::view::Tally;
use crate::stream::FAULT_CARD;
use serde::{Serialize, Serializer};

/// One line of the trace, as JSON.
#[derive(Debug, Serialize)]
#[serde(tag = "event", rename_all = "lowercase")]
pub(crate) enum Line<'a> {
    /// The screen is taken; `fps` is the flock's, numerator and denominator.
    Start { screen: &'a str, mode: &'a str, format: &'a str, fps: [u32; 2] },
    /// Frame `frame` of `clip`, counted from 0, is on the glass since `vblank`, which began at `t_ns` and was `late`
    /// vblanks after the one at which the frame was due; the acknowledgement `mark`, counted from 1, lies over it.
    Flip {
        clip: &'a str,
        frame: u32,
        vblank: u32,
        t_ns: u64,
        late: u32,
        #[serde(skip_serializing_if = "Option::is_none")]
        hash: Option<Hex>,
        #[serde(skip_serializing_if = "Option::is_none")]
        mark: Option<u32>,
    },
    /// The next flip is the first of clip `to`.
    Join { from: &'a str, to: &'a str },
    /// Something went wrong; the picture goes on.
    Fault { kind: &'a str, message: &'a str },
    /// The run is over.
    End {
        #[serde(flatten)]
        tally: &'a Tally,
        faults: u64,
    },
}

impl<'a> Line<'a> {
    /// The line of `record`, if it has one.
    pub(crate) fn of(record: &'a Record) -> Option<Self> {
        Some(match record {
            Record::Start { lit, fps } => {
                Self::Start { screen: &lit.screen, mode: &lit.mode, format: &lit.format, fps: [fps.num(), fps.den()] }
            }
            Record::Flip { clip, frame, vblank, at, late, hash, mark } => Self::Flip {
                clip: clip.as_ref().map_or(FAULT_CARD, |clip| clip.clip.as_str()),
                frame: *frame,
                vblank: vblank.0,
                t_ns: at.0,
                late: *late,
                hash: hash.map(Hex),
                mark: *mark,
            },
            Record::Join { from, to } => Self::Join { from: from.clip.as_str(), to: to.clip.as_str() },
            Record::Fault { kind, message, .. } => Self::Fault { kind, message },
            Record::End { tally, faults } => Self::End { tally, faults: *faults },
            Record::Ready | Record::Alive => return None,
        })
    }
}

/// An MD5, written as ffmpeg writes it.
#[derive(Debug)]
pub(crate) struct Hex([u8; 16]);

impl Serialize for Hex {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        to.collect_str(&format_args!("{:032x}", u128::from_be_bytes(self.0)))
    }
}

#[cfg(test)]
mod tests {
    use super::Line;
    use crate::recording::recorder::Record;
    use crate::recording::view::Tally;
    use crate::stream::scheduled_clip::tests::scheduled_clips;
    use screen::{DimmedBy, ScreenInfo};
    use std::sync::Arc;
    use timing::{Nanos, Rate, Vblank};

    fn line(record: &Record) -> String {
        serde_json::to_string(&Line::of(record).unwrap()).unwrap()
    }

    #[test]
    fn the_lines_have_the_fields_that_other_tools_rely_on() {
        let lit = ScreenInfo {
            screen: "virtual".to_owned(),
            mode: "640x480@60".to_owned(),
            size: (640, 480),
            format: "YU12".to_owned(),
            refresh: Rate::new(60, 1).unwrap(),
            notes: Vec::new(),
            dimmed_by: DimmedBy::Nothing,
            connector: None,
        };
        assert_eq!(
            line(&Record::Start { lit: Arc::new(lit), fps: Rate::new(24_000, 1_001).unwrap() }),
            r#"{"event":"start","screen":"virtual","mode":"640x480@60","format":"YU12","fps":[24000,1001]}"#
        );
        let scheduled = scheduled_clips(1, 2).remove(0);
        let flip = |clip, hash| Record::Flip {
            clip,
            frame: 1,
            vblank: Vblank(9),
            at: Nanos(150),
            late: 0,
            hash,
            mark: hash.map(|_| 3),
        };
        assert_eq!(
            line(&flip(Some(scheduled.clone()), None)),
            r#"{"event":"flip","clip":"loop.mp4","frame":1,"vblank":9,"t_ns":150,"late":0}"#
        );
        assert_eq!(
            line(&flip(None, Some([0xab; 16]))),
            format!(
                r#"{{"event":"flip","clip":"fault-card","frame":1,"vblank":9,"t_ns":150,"late":0,"hash":"{}","mark":3}}"#,
                "ab".repeat(16)
            )
        );
        assert_eq!(
            line(&Record::Join { from: scheduled.clone(), to: scheduled }),
            r#"{"event":"join","from":"loop.mp4","to":"loop.mp4"}"#
        );
        assert_eq!(
            line(&Record::Fault { kind: "missing-clip", message: "gone".to_owned(), is_repeated: false }),
            r#"{"event":"fault","kind":"missing-clip","message":"gone"}"#
        );
        let tally = Tally { flips: 6, late: 5, repeated: 4, skipped: 3, joins: 2 };
        assert_eq!(
            line(&Record::End { tally, faults: 1 }),
            r#"{"event":"end","flips":6,"late":5,"repeated":4,"skipped":3,"joins":2,"faults":1}"#
        );
    }
}
