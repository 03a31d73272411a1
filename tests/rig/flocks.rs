//! Small flocks to play, made once and kept.
//!
//! Owns the flocks that claims use: their graph, their clips, and the hashes of all frames. `player_run.rs` plays them;
//! `player/bad_clips.rs` damages copies.
//!
//! Start at [`Plan::flock`].

use crate::clips::{Encode, framemd5};
use crate::programs::{self, claims_folder, succeed};
use std::collections::HashMap;
use std::fmt::Write as _;
use std::fs;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Mutex;

/// The plan of a flock. Its graph is a ring with chords: every sheep leads to the next and to the one after.
#[derive(Clone, Copy, Debug, Hash)]
pub struct Plan {
    /// The flock's name, and the prefix of its folder's name.
    pub name: &'static str,
    /// Width and height of its clips in pixels.
    pub size: (u32, u32),
    /// Frames per second, numerator and denominator.
    pub fps: (u32, u32),
    /// The number of sheep, at least 3. The last has no loop where there are 5 or more; the second is shown twice per
    /// visit.
    pub sheep: usize,
    /// The number of frames of the shortest clip; the longest has 6 more.
    pub frames: u32,
}

/// A flock on disk, with its frames.
pub struct Flock {
    /// Its folder.
    pub folder: PathBuf,
    /// Every clip's path in the manifest, and the MD5 of each of its frames.
    pub shows: HashMap<String, Vec<String>>,
}

/// The flock of the thousand joins: six sheep, with clips that are all encoded differently.
pub const JOINS: Plan = Plan { name: "joins", size: (640, 480), fps: (30, 1), sheep: 6, frames: 6 };

/// A flock of small frames and short clips, to be played as fast as possible.
pub const SMALL: Plan = Plan { name: "small", size: (320, 240), fps: (30, 1), sheep: 5, frames: 6 };

static MAKING: Mutex<()> = Mutex::new(());

impl Plan {
    /// The flock of this plan: made now, unless an earlier run has made it.
    pub fn flock(&self) -> Flock {
        let mut hasher = DefaultHasher::new();
        (self, crate::clips::SETTINGS, include_str!("flocks.rs"), include_str!("clips.rs")).hash(&mut hasher);
        let folder = claims_folder().join(format!("{}-{:016x}", self.name, hasher.finish()));
        let _one_at_a_time = MAKING.lock();
        if !folder.exists() {
            let scratch = tempfile::tempdir_in(claims_folder()).unwrap().keep();
            self.make(&scratch);
            fs::rename(scratch, &folder).unwrap();
        }
        let shows = read_shows(&folder);
        Flock { folder, shows }
    }

    /// Writes clips, manifest and frame hashes into `folder`.
    fn make(&self, folder: &Path) {
        let mut manifest = format!(
            "format = 1\nname = \"{}\"\nsize = [{}, {}]\nfps = [{}, {}]\n",
            self.name, self.size.0, self.size.1, self.fps.0, self.fps.1
        );
        let mut shows = String::new();
        let mut clip = |name: &str, number: usize| {
            let frames = self.frames + u32::try_from(number * 5 % 7).unwrap();
            let path = folder.join(name);
            Encode { size: self.size, fps: self.fps, frames, number }.make(&path);
            let list = framemd5(&path);
            assert_eq!(list.len(), frames as usize, "`{name}` has not the frames asked for");
            writeln!(shows, "{name} {}", list.join(" ")).unwrap();
            let digest = blake3::hash(&fs::read(&path).unwrap());
            format!("frames = {frames}\nclip = \"{name}\"\nhash = \"b3:{digest}\"\n")
        };
        for sheep in 0..self.sheep {
            let repeat = if sheep == 1 { 2 } else { 1 };
            write!(manifest, "\n[[sheep]]\nid = \"s{sheep}\"\nrepeat = {repeat}\n").unwrap();
            if sheep < 4 || sheep + 1 < self.sheep {
                manifest += &clip(&format!("s{sheep}.mp4"), sheep);
            }
        }
        for from in 0..self.sheep {
            for step in 1..=2 {
                let to = (from + step) % self.sheep;
                write!(manifest, "\n[[transition]]\nfrom = \"s{from}\"\nto = \"s{to}\"\n").unwrap();
                manifest += &clip(&format!("s{from}=s{to}.mp4"), self.sheep * step + from);
            }
        }
        fs::write(folder.join("flock.toml"), manifest).unwrap();
        fs::write(folder.join("shows"), shows).unwrap();
    }
}

/// The frame hashes that [`Plan::make`] wrote to `folder`; no two frames of a flock are equal.
fn read_shows(folder: &Path) -> HashMap<String, Vec<String>> {
    let text = fs::read_to_string(folder.join("shows")).unwrap();
    let mut shows = HashMap::new();
    let mut seen = HashMap::new();
    for line in text.lines() {
        let (clip, list) = line.split_once(' ').expect("a clip and its frames");
        let frames: Vec<String> = list.split(' ').map(str::to_owned).collect();
        for frame in &frames {
            let twin = seen.insert(frame.clone(), clip.to_owned());
            assert!(twin.is_none(), "`{clip}` and {twin:?} show the same frame: their order could not be told");
        }
        shows.insert(clip.to_owned(), frames);
    }
    shows
}

impl Flock {
    /// The clips of the first `count` places of the walk with `seed`, as `dreams walk` prints them.
    pub fn walk(&self, seed: &str, count: usize) -> Vec<String> {
        let mut flock = Command::new(programs::dreams());
        flock.arg("walk").arg(&self.folder).args(["--seed", seed, "--steps", &count.to_string()]);
        let text = String::from_utf8(succeed(&mut flock)).unwrap();
        let clips: Vec<String> = text.lines().take(count).map(str::to_owned).collect();
        assert_eq!(clips.len(), count, "`dreams walk --steps {count}` prints at least a clip a step");
        clips
    }

    /// Clip, frame and hash of every frame that playing `clips` one after another shows.
    pub fn frames<'a>(&'a self, clips: &'a [String]) -> Vec<(&'a str, u64, &'a str)> {
        let of = |clip: &'a String| {
            let frames = &self.shows[clip];
            frames.iter().enumerate().map(move |(frame, hash)| (clip.as_str(), frame as u64, hash.as_str()))
        };
        clips.iter().flat_map(of).collect()
    }
}

#[test]
fn every_test_clip_is_in_the_form_that_a_flock_asks_for() {
    let flock = JOINS.flock();
    let said = programs::output(Command::new(programs::dreams()).arg("check").arg(&flock.folder));
    assert!(
        said.status.success(),
        "{}{}",
        String::from_utf8_lossy(&said.stdout),
        String::from_utf8_lossy(&said.stderr)
    );
}
