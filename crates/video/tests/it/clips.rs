//! Clips made on the spot, and what ffmpeg says of them.
//!
//! Owns the calls of the `ffmpeg` command line, which is the judge of every frame here. Never part of the crate.

use md5::{Digest, Md5};
use std::num::NonZero;
use std::path::{Path, PathBuf};
use std::process::Command;
use timing::{FrameCount, Rate};
use video::{Clip, ClipNumber, Damage, Form, Frame, Poll, Session};

/// Small enough to be quick, not a multiple of 16 high, so that cropping is seen too.
pub(crate) const SIZE: (u32, u32) = (128, 100);
/// The filter that tags pictures as a flock's: ffmpeg 7 takes primaries and transfer from the pictures, not from options.
const SETPARAMS: &str = "setparams=range=tv:color_primaries=bt709:color_trc=bt709:colorspace=bt709";
/// What makes any ffmpeg clip one of the flock's form.
const FORM: &str = "-c:v libx264 -pix_fmt yuv420p -color_primaries bt709 -color_trc bt709 -colorspace bt709 \
                    -color_range tv -x264-params repeat-headers=1 -movflags +faststart";

pub(crate) fn form() -> Form {
    Form { size: SIZE, fps: Rate::new(30, 1).unwrap() }
}

/// A clip of `frames` frames in the flock's form, with more encoder settings as the command line has them.
pub(crate) fn clip(folder: &Path, name: &str, frames: u32, settings: &str) -> PathBuf {
    let (width, height) = SIZE;
    let source = format!("testsrc2=size={width}x{height}:rate=30,noise=alls=20:allf=t,hue=h=7*n,{SETPARAMS}");
    made(folder, name, &source, frames, &format!("{FORM} {settings}"))
}

/// Any clip that ffmpeg can make.
pub(crate) fn made(folder: &Path, name: &str, source: &str, frames: u32, settings: &str) -> PathBuf {
    let path = folder.join(name);
    let made = Command::new("ffmpeg")
        .args(["-v", "error", "-y", "-f", "lavfi", "-i", source, "-frames:v", &frames.to_string()])
        .args(settings.split_whitespace())
        .arg(&path)
        .status()
        .expect("the tests need the `ffmpeg` command");
    assert!(made.success(), "ffmpeg could not make {name}");
    path
}

/// The MD5 of every frame as ffmpeg decodes it.
pub(crate) fn framemd5(path: &Path) -> Vec<String> {
    let output = Command::new("ffmpeg")
        .args(["-v", "error", "-threads", "1", "-i"])
        .arg(path)
        .args(["-f", "framemd5", "-"])
        .output()
        .expect("the tests need the `ffmpeg` command");
    let text = String::from_utf8(output.stdout).unwrap();
    let hashes = text.lines().filter(|line| !line.starts_with('#'));
    hashes.map(|line| line.rsplit(',').next().unwrap().trim().to_owned()).collect()
}

/// The MD5 of a frame's visible rows.
pub(crate) fn hash(frame: &Frame) -> String {
    let mut md5 = Md5::new();
    for plane in 0..3 {
        let half = u32::from(plane > 0);
        let (width, height) = ((frame.size().0 >> half) as usize, (frame.size().1 >> half) as usize);
        for row in frame.planes()[plane].chunks(frame.strides()[plane]).take(height) {
            md5.update(&row[..width]);
        }
    }
    hex(md5)
}

/// A digest as ffmpeg writes it.
pub(crate) fn hex(md5: Md5) -> String {
    let digits = md5.finalize().into_iter().flat_map(|byte| [byte >> 4, byte & 15]);
    digits.filter_map(|digit| char::from_digit(digit.into(), 16)).collect()
}

/// What a session did with some clips.
#[derive(Default)]
pub(crate) struct Played {
    pub(crate) frames: Vec<(ClipNumber, u32, String)>,
    pub(crate) ends: Vec<(ClipNumber, FrameCount, Vec<Damage>)>,
}

impl Played {
    pub(crate) fn hashes(&self, clip: u64) -> Vec<String> {
        self.frames.iter().filter(|frame| frame.0 == ClipNumber(clip)).map(|frame| frame.2.clone()).collect()
    }
}

/// Plays clips that are in the form, each pushed only when the session starves for it, and checks on the way that
/// frames and ends come in order.
pub(crate) fn play(clips: impl IntoIterator<Item = Clip>, threads: usize) -> Played {
    let mut session = Session::new(NonZero::new(threads).unwrap()).unwrap();
    let (mut clips, mut played) = (clips.into_iter(), Played::default());
    loop {
        match session.poll() {
            Poll::Frame(frame) => {
                assert_eq!(frame.index().0, played.frames.len() as u64, "indices have no gap");
                assert_eq!(frame.clip().0, played.ends.len() as u64, "a frame belongs to the clip that has not ended");
                played.frames.push((frame.clip(), frame.in_clip(), hash(&frame)));
            }
            Poll::ClipEnd { clip, frames, damage } => {
                assert_eq!(clip.0, played.ends.len() as u64, "clips end in order");
                played.ends.push((clip, frames, damage));
            }
            Poll::Starved => match clips.next() {
                Some(clip) => drop(session.push(clip)),
                None => session.finish(),
            },
            Poll::Finished => return played,
            Poll::Failed(error) => panic!("{error}"),
        }
    }
}
