//! What a session costs beside `ffmpeg` decoding the same clip: CPU seconds per 1000 frames and peak memory, as JSON.
//!
//! Owns the measurement of issue 2's promise that the fence is free. Makes its own clip: 720p30 at 14 Mbit/s of a
//! zooming fractal with noise. Never part of the player.
//!
//! Run with `cargo run --release -p video --example decode_cost`.
#![expect(
    clippy::print_stdout,
    clippy::unwrap_used,
    clippy::panic,
    reason = "a bench prints its figures and stops at surprises"
)]

use std::env;
use std::fs;
use std::num::NonZero;
use std::path::Path;
use std::process::{Command, Stdio};
use timing::{FrameCount, Rate};
use video::{Clip, Form, Poll, Session};

const FRAMES: u32 = 300;
/// Clips played in a row, as many for either side.
const ROUNDS: u32 = 3;
const SOURCE: &str = "mandelbrot=size=1280x720:rate=30:end_scale=0.0003,noise=alls=12:allf=t,format=yuv420p";
const FORM: &str = "-c:v libx264 -preset medium -b:v 14M -maxrate 14M -bufsize 28M -color_primaries bt709 \
                    -color_trc bt709 -colorspace bt709 -color_range tv -x264-params repeat-headers=1";

fn main() {
    let arguments: Vec<String> = env::args().collect();
    match arguments.as_slice() {
        [_, clip, threads] => play(Path::new(clip), threads.parse().unwrap()),
        _ => compare(),
    }
}

/// The child: plays the clip [`ROUNDS`] times through one session and prints its peak memory in kB.
fn play(path: &Path, threads: NonZero<usize>) {
    let form = Form { size: (1280, 720), fps: Rate::new(30, 1).unwrap() };
    let mut session = Session::new(threads).unwrap();
    let (mut left, mut frames) = (ROUNDS, 0);
    loop {
        match session.poll() {
            Poll::Frame(_) => frames += 1,
            Poll::Starved if left > 0 => {
                session.push(Clip::open(path, &form, FrameCount(FRAMES)).unwrap());
                left -= 1;
            }
            Poll::Starved => session.finish(),
            Poll::ClipEnd { damage, .. } => assert!(damage.is_empty(), "{damage:?}"),
            Poll::Finished => break,
            Poll::Failed(error) => panic!("{error}"),
        }
    }
    assert_eq!(frames, ROUNDS * FRAMES);
    let status = fs::read_to_string("/proc/self/status").unwrap();
    let peak = status.lines().find(|line| line.starts_with("VmHWM")).unwrap();
    println!("{}", peak.split_whitespace().nth(1).unwrap());
}

/// The parent: makes the clip and runs both sides five times in turn.
fn compare() {
    let folder = tempfile::TempDir::new().unwrap();
    let clip = folder.path().join("clip.mp4");
    let mut make = Command::new("ffmpeg");
    make.args(["-v", "error", "-f", "lavfi", "-i", SOURCE, "-frames:v", &FRAMES.to_string()]);
    assert!(make.args(FORM.split_whitespace()).arg(&clip).status().unwrap().success());
    let bits = fs::metadata(&clip).unwrap().len() * 8 * 30 / u64::from(FRAMES);
    for threads in ["1", "2"] {
        let loops = (ROUNDS - 1).to_string();
        let mut ffmpeg = Command::new("ffmpeg");
        ffmpeg.args(["-v", "error", "-threads", threads, "-stream_loop", &loops, "-i"]);
        ffmpeg.arg(&clip).args(["-f", "null", "-"]);
        let mut session = Command::new(env::current_exe().unwrap());
        session.arg(&clip).arg(threads);
        let mut runs: Vec<(f64, f64, u64)> = Vec::new();
        for _ in 0..5 {
            let (theirs, _) = cost(&mut ffmpeg);
            let (ours, said) = cost(&mut session);
            runs.push((ours, theirs, said.trim().parse().unwrap()));
        }
        let ours = median(runs.iter().map(|run| run.0).collect());
        let theirs = median(runs.iter().map(|run| run.1).collect());
        let peak = runs.iter().map(|run| run.2).max().unwrap();
        println!(
            "{{\"threads\": {threads}, \"bits_per_second\": {bits}, \"session_cpu_s_per_1000\": {ours:.3}, \
             \"ffmpeg_cpu_s_per_1000\": {theirs:.3}, \"ratio\": {:.3}, \"session_peak_kb\": {peak}}}",
            ours / theirs
        );
    }
}

/// CPU seconds per 1000 frames that a child took, and what it said.
fn cost(child: &mut Command) -> (f64, String) {
    let before = children_seconds();
    let output = child.stderr(Stdio::inherit()).output().unwrap();
    assert!(output.status.success());
    let seconds = children_seconds() - before;
    (seconds * 1000.0 / f64::from(ROUNDS * FRAMES), String::from_utf8(output.stdout).unwrap())
}

/// User and system time of all children that were waited for: fields 16 and 17 of proc(5)'s stat, in 1/100 s.
fn children_seconds() -> f64 {
    let stat = fs::read_to_string("/proc/self/stat").unwrap();
    let fields = stat.rsplit(')').next().unwrap().split_whitespace();
    fields.skip(13).take(2).map(|ticks| ticks.parse::<f64>().unwrap() / 100.0).sum()
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}
