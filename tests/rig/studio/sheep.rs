//! Flocks for the studio's claims.
//!
//! Owns generated manifests without clips, the demo flock with genomes and clips, the same with small pictures, and rings of
//! small sheep that are quick to draw.
//!
//! Start at [`ring`].

use crate::clips::{SETPARAMS, TAGS};
use crate::programs::{claims_folder, dreams, repository, succeed};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Mutex;
use tempfile::TempDir;

/// The folder of files in memory, on systems that have one.
const MEMORY: &str = "/dev/shm";

/// A folder with a flock `name` of `sheep` in a ring, each with `chords` more transitions, without clips: the ids are
/// `s0`, `s1` and so on. It lies in memory where the system has a folder for that: the studio syncs the disk thousands of
/// times in some claims, and a disk that is still writing what was compiled lets a sync wait.
pub fn ring(name: &str, sheep: usize, chords: usize) -> TempDir {
    let folder = tempfile::tempdir_in(MEMORY).or_else(|_| tempfile::tempdir()).unwrap();
    fs::write(folder.path().join("flock.toml"), manifest(name, sheep, chords)).unwrap();
    folder
}

/// The manifest of [`ring`].
pub fn manifest(name: &str, sheep: usize, chords: usize) -> String {
    let mut text = format!("format = 1\nname = \"{name}\"\nsize = [1280, 720]\nfps = [30, 1]\n");
    for at in 0..sheep {
        write!(text, "\n[[sheep]]\nid = \"s{at}\"\nframes = 768\nclip = \"loops/s{at}.mp4\"\n").unwrap();
    }
    for from in 0..sheep {
        let ends: BTreeSet<usize> = (0..=chords).map(|chord| (from + 1 + chord * 7) % sheep).collect();
        for to in ends.into_iter().filter(|to| *to != from) {
            write!(text, "\n[[transition]]\nfrom = \"s{from}\"\nto = \"s{to}\"\n").unwrap();
            write!(text, "frames = 384\nclip = \"transitions/s{from}=s{to}.mp4\"\n").unwrap();
        }
    }
    text
}

/// A copy of the demo flock in `flock-tools/demo/small`, with its genomes and clips.
pub fn demo() -> TempDir {
    let folder = tempfile::tempdir_in(claims_folder()).unwrap();
    let from = repository().join("flock-tools/demo/small");
    succeed(Command::new("cp").args(["--recursive", "--reflink=auto"]).arg(from.join(".")).arg(folder.path()));
    folder
}

/// Frames per second of [`small_pictures`]: at four times that, a screen of 60 Hz still shows every one.
pub const RATE: u32 = 12;

/// The same, slower, and each frame 320 pixels wide: many are decoded a second also on a busy machine. Its clips have no
/// hashes and its sheep no genomes, so that nothing but the clips can be shown. It is kept for the next run.
pub fn small_pictures() -> PathBuf {
    static MAKING: Mutex<()> = Mutex::new(());
    let _one_at_a_time = MAKING.lock();
    let from = repository().join("flock-tools/demo/small");
    let text = fs::read_to_string(from.join("flock.toml")).unwrap();
    let made_from = [text.as_str(), include_str!("sheep.rs")].concat();
    let folder = claims_folder().join(format!("studio-{}", &blake3::hash(made_from.as_bytes()).to_hex()[..16]));
    if folder.exists() {
        return folder;
    }
    let scratch = tempfile::tempdir_in(claims_folder()).unwrap();
    for name in ["loops", "transitions"] {
        fs::create_dir(scratch.path().join(name)).unwrap();
        for clip in fs::read_dir(from.join(name)).unwrap().map(|entry| entry.unwrap()) {
            let mut ffmpeg = Command::new("ffmpeg");
            ffmpeg.args(["-v", "error", "-nostdin", "-r", &RATE.to_string(), "-i"]).arg(clip.path());
            ffmpeg.args(["-vf", &format!("scale=320:180,{SETPARAMS}"), "-c:v", "libx264", "-profile:v", "high"]);
            ffmpeg.args(["-preset", "veryfast", "-x264-params", "open-gop=0:bframes=3:8x8dct=1"]);
            ffmpeg.args(["-bsf:v", "dump_extra=freq=keyframe", "-movflags", "+faststart"]).args(TAGS);
            succeed(ffmpeg.arg(scratch.path().join(name).join(clip.file_name())));
        }
    }
    let is_kept = |line: &&str| !line.starts_with("hash = ") && !line.starts_with("genome = ");
    let kept: Vec<_> = text.lines().filter(is_kept).collect();
    let kept = kept.join("\n").replace("size = [1280, 720]", "size = [320, 180]");
    let kept = kept.replace("fps = [30, 1]", &format!("fps = [{RATE}, 1]")) + "\n";
    fs::write(scratch.path().join("flock.toml"), kept).unwrap();
    fs::rename(scratch.keep(), &folder).unwrap();
    folder
}

/// How many sheep are drawn for [`many`], and the frames of each of their clips.
const KINDS: usize = 5;
const LONG: usize = 120;

/// A genome that is drawn in no time, and moves neither so fast nor so slowly that drafts of it do not meet.
pub fn quick(kind: usize) -> String {
    let [bands, later] = [kind + 2, (kind + 3) % 10];
    let tint = format!("(+ 0.{} (* 0.1 (sin (+ (* 3 x) (* 2 (wave 1 0.{kind}))))))", 2 * kind);
    let light = format!("(+ 0.5 (* 0.3 (sin (+ (* {bands} y) (+ x (* 2 (wave 1 0.{later})))))))");
    format!("(expression 1 (picture (hsv-to-rgb (vector {tint} 0.5 {light}))))\n")
}

/// A small ring of quick sheep with rendered clips, kept for the next run: the folder.
fn rendered() -> PathBuf {
    static MAKING: Mutex<()> = Mutex::new(());
    let _one_at_a_time = MAKING.lock();
    let folder =
        claims_folder().join(format!("studio-quick-{}", &blake3::hash(include_bytes!("sheep.rs")).to_hex()[..16]));
    if folder.exists() {
        return folder;
    }
    let scratch = tempfile::tempdir_in(claims_folder()).unwrap();
    fs::create_dir(scratch.path().join("genomes")).unwrap();
    for kind in 0..KINDS {
        fs::write(scratch.path().join(format!("genomes/s{kind:03}.expr")), quick(kind)).unwrap();
    }
    fs::write(scratch.path().join("flock.toml"), small_manifest(KINDS, |_, _| String::new())).unwrap();
    succeed(Command::new(dreams()).args(["render", "--preset", "draft"]).arg(scratch.path()));
    fs::rename(scratch.keep(), &folder).unwrap();
    folder
}

/// The manifest of a ring of `sheep` with genomes; `hash` gives the line for the hash of the clip at a place of a list.
fn small_manifest(sheep: usize, hash: impl Fn(&str, usize) -> String) -> String {
    let mut text = "format = 1\nname = \"meadow\"\nsize = [96, 54]\nfps = [15, 1]\n".to_owned();
    for at in 0..sheep {
        let clip = format!("frames = {LONG}\nclip = \"loops/s{at:03}.mp4\"\n{}", hash("sheep", at));
        write!(text, "\n[[sheep]]\nid = \"s{at:03}\"\ngenome = \"genomes/s{at:03}.expr\"\n{clip}").unwrap();
    }
    for at in 0..sheep {
        let to = (at + 1) % sheep;
        let clip = format!("clip = \"transitions/s{at:03}=s{to:03}.mp4\"\n{}", hash("transition", at));
        write!(text, "\n[[transition]]\nfrom = \"s{at:03}\"\nto = \"s{to:03}\"\nframes = {LONG}\n{clip}").unwrap();
    }
    text
}

/// A flock of `sheep` in a ring, all with genomes and clips, by the ids `s000`, `s001` and so on: copies of five sheep by
/// turns.
pub fn many(sheep: usize) -> TempDir {
    assert_eq!(sheep % KINDS, 0, "the ring closes");
    let from = rendered();
    let listed: toml::Table = fs::read_to_string(from.join("flock.toml")).unwrap().parse().unwrap();
    let hash = |list: &str, at: usize| {
        let hash = listed[list][at % KINDS]["hash"].as_str().expect("it is rendered");
        format!("hash = \"{hash}\"\n")
    };
    let folder = tempfile::tempdir_in(claims_folder()).unwrap();
    for name in ["genomes", "loops", "transitions"] {
        fs::create_dir(folder.path().join(name)).unwrap();
    }
    let link = |old: String, new: String| fs::hard_link(from.join(old), folder.path().join(new)).unwrap();
    for at in 0..sheep {
        let (kind, to) = (at % KINDS, (at + 1) % sheep);
        link(format!("genomes/s{kind:03}.expr"), format!("genomes/s{at:03}.expr"));
        link(format!("loops/s{kind:03}.mp4"), format!("loops/s{at:03}.mp4"));
        let next = (kind + 1) % KINDS;
        link(format!("transitions/s{kind:03}=s{next:03}.mp4"), format!("transitions/s{at:03}=s{to:03}.mp4"));
    }
    fs::write(folder.path().join("flock.toml"), small_manifest(sheep, hash)).unwrap();
    folder
}

/// A word of the flock, which no answer to a stranger may have.
pub const SECRET_WORD: &str = "velvet";

/// Every file of a flock, without what the studio keeps for itself.
pub fn files(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    entries.filter(|path| path.is_file()).map(|path| (path.clone(), fs::read(path).unwrap())).collect()
}
