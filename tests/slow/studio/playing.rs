//! What the studio plays is what the wall shows.
//!
//! Owns the claims on the walk, frame by frame against `dreams walk` and ffmpeg, on its buffer over a long time, and on
//! the loupe.
//!
//! Start at [`WATCH`].

use claims::programs::{self, claims_folder, succeed};
use claims::studio::browser::Browser;
use claims::studio::page::{DESK, Page, Window};
use claims::studio::running::Studio;
use claims::studio::sheep::{RATE, small_pictures};
use serde_json::{Value, json};
use std::collections::HashMap;
use std::fs;
use std::path::Path;
use std::process::Command;
use tempfile::TempDir;

/// The virtual seconds of walk that are watched: `WALK_S` for `make soak`, which watches half an hour.
fn seconds() -> u64 {
    std::env::var("WALK_S").map_or(120, |seconds| seconds.parse().expect("WALK_S is a number"))
}

/// Those after which the page must have kept its pace, too.
const SOAK_S: u64 = 1_800;

/// Runs before the page: notes each frame of a video that is shown, with its time and fingerprint, and how often it stood:
/// for want of what is to be played, or because the decoder was too slow. Frames are read from the video as they were
/// decoded; `window.every` says of how many shown frames one is read. Of each clip that the page says is shown it notes the
/// first frame that is, by the video's own time.
const WATCH: &str = r"
  window.shown = []
  window.stalls = 0
  window.slow = []
  window.every = 1
  window.joins = []
  const noted = new WeakSet()
  const note = video => {
    if (noted.has(video)) return
    noted.add(video)
    for (const name of ['waiting', 'stalled']) video.addEventListener(name, () => {
      if (video.currentTime < 0.5 || video.paused || video.seeking) return
      const { buffered, currentTime } = video
      const isThere = [...Array(buffered.length).keys()].some(at => buffered.start(at) <= currentTime && buffered.end(at) > currentTime + 0.5)
      if (isThere) window.slow.push(currentTime)
      else window.stalls++
    })
    let count = 0
    const after = new MessageChannel()
    after.port1.onmessage = ({ data: [time, fps] }) => {
      const { clip, frame } = document.querySelector('.screen').dataset
      if (Number(frame) === Math.round(time * fps) && Number(clip) !== window.joins.at(-1)?.[0]) window.joins.push([Number(clip), Number(frame)])
    }
    const each = async (_, { mediaTime }) => {
      video.requestVideoFrameCallback(each)
      // When the page has been told of the frame, too.
      after.port2.postMessage([mediaTime, window.fps])
      if (count++ % window.every) return
      const frame = new VideoFrame(video)
      const data = new Uint8Array(frame.allocationSize())
      const { format, timestamp } = frame
      await frame.copyTo(data)
      frame.close()
      const sha1 = new Uint8Array(await crypto.subtle.digest('SHA-1', data))
      window.shown.push([timestamp / 1e6, format, [...sha1].map(byte => byte.toString(16).padStart(2, '0')).join('')])
    }
    video.requestVideoFrameCallback(each)
  }
  new MutationObserver(() => document.querySelectorAll('video').forEach(note)).observe(document, { childList: true, subtree: true })";

/// The SHA-1 of every frame of `clip`, in order, as ffmpeg decodes them.
fn framehash(clip: &Path) -> Vec<String> {
    let mut ffmpeg = Command::new("ffmpeg");
    ffmpeg.args(["-v", "error", "-nostdin", "-i"]).arg(clip);
    ffmpeg.args(["-an", "-pix_fmt", "yuv420p", "-fps_mode", "passthrough", "-f", "framehash", "-hash", "sha160", "-"]);
    let list = String::from_utf8(succeed(&mut ffmpeg)).unwrap();
    let digest = |line: &str| line.rsplit(',').next().map(|hash| hash.trim().to_owned());
    list.lines().filter(|line| !line.starts_with('#')).filter_map(digest).collect()
}

/// The clips of the walk of `seed`, as `dreams walk` prints them.
fn walk(folder: &Path, seed: &str, steps: usize) -> Vec<String> {
    let mut dreams = Command::new(programs::dreams());
    dreams.arg("walk").arg(folder).args(["--seed", seed, "--steps", &steps.to_string()]);
    String::from_utf8(succeed(&mut dreams)).unwrap().lines().map(str::to_owned).collect()
}

/// The fingerprints of the frames of `clips`, one clip after the other.
fn frames(folder: &Path, clips: &[String]) -> Vec<String> {
    let mut known: HashMap<&String, Vec<String>> = HashMap::new();
    let mut all = Vec::new();
    for clip in clips {
        all.extend_from_slice(known.entry(clip).or_insert_with(|| framehash(&folder.join(clip))));
    }
    all
}

/// A copy of [`small_pictures`]: one studio at a time has a flock.
fn own_copy() -> TempDir {
    let copy = tempfile::tempdir_in(claims_folder()).unwrap();
    succeed(Command::new("cp").arg("-r").arg(small_pictures().join(".")).arg(copy.path()));
    copy
}

/// A window that leaves the machine's power to the decoder.
const LITTLE: Window = Window { width: 800, height: 600, ..DESK };

#[test]
fn what_the_studio_plays_is_what_the_wall_shows() {
    let flock = own_copy();
    let folder = flock.path().to_owned();
    let expected = frames(&folder, &walk(&folder, "7", 6));
    let studio = Studio::of(&folder);
    let browser = Browser::start();
    let page = Page::prepared(&browser, &studio.address(), LITTLE, WATCH);
    page.ask("location.hash = '#/walk?seed=7'");
    page.until(
        "the walk has come to its 300th frame",
        "Number(document.querySelector('.screen')?.dataset.frame) > 300",
    );
    let shown = page.ask("window.shown");
    let shown = shown.as_array().expect("a list of frames");
    assert!(shown.len() > 50, "{} frames were seen", shown.len());
    for seen in shown {
        let (time, layout, hash) = (seen[0].as_f64().unwrap(), &seen[1], seen[2].as_str().unwrap());
        let frame = (time * f64::from(RATE)).round();
        assert!((time * f64::from(RATE) - frame).abs() < 0.01, "{time} s is no frame of {RATE} a second");
        assert_eq!(layout, "I420", "frames are compared as they were decoded");
        assert_eq!(hash, expected[frame as usize], "frame {frame}, {time} s");
    }
    let order: Vec<f64> = shown.iter().map(|seen| seen[0].as_f64().unwrap()).collect();
    assert!(order.is_sorted(), "{order:?}");
    assert_eq!(json!(page.complaints()), json!([]));
}

/// The frame at which each clip of a walk begins: a loop that is repeated is one clip to the page.
fn starts(folder: &Path, clips: &[String]) -> Vec<u64> {
    let manifest: toml::Table = fs::read_to_string(folder.join("flock.toml")).unwrap().parse().unwrap();
    let listed = ["sheep", "transition"].map(|list| manifest[list].as_array().unwrap().iter());
    let frames: HashMap<&str, u64> = listed
        .into_iter()
        .flatten()
        .map(|own| (own["clip"].as_str().unwrap(), own["frames"].as_integer().unwrap().cast_unsigned()))
        .collect();
    let (mut starts, mut frame, mut last) = (Vec::new(), 0, "");
    for clip in clips {
        if clip != last {
            starts.push(frame);
        }
        (frame, last) = (frame + frames[clip.as_str()], clip);
    }
    starts
}

#[test]
fn a_long_walk_at_four_times_its_pace_has_one_buffer_never_stands_and_comes_to_every_clip_at_its_frame() {
    let flock = own_copy();
    let folder = flock.path().to_owned();
    let begins = starts(&folder, &walk(&folder, "7", usize::try_from(seconds() / 8).unwrap() + 8));
    let studio = Studio::of(&folder);
    let browser = Browser::start();
    let watch = format!("{WATCH}; window.every = Infinity; window.fps = {RATE}");
    let page = Page::prepared(&browser, &studio.address(), LITTLE, &watch);
    page.ask("location.hash = '#/walk?seed=7'");
    page.until("the walk plays", "document.querySelector('video')?.currentTime > 1");
    page.press("4");
    page.until("it plays at that pace", "document.querySelector('video').currentTime > 5");
    page.ask("window.slow = []");
    page.ask("window.ranges = 0; setInterval(() => { window.ranges = Math.max(ranges, document.querySelector('video').buffered.length) }, 200)");
    let limit = u32::try_from(seconds()).unwrap().max(300) * 2;
    let is_over = format!("document.querySelector('video').currentTime > {}", seconds());
    page.until_within("the whole walk was played", limit, &is_over);
    let told = page.ask("(() => { const video = document.querySelector('video'), { totalVideoFrames, droppedVideoFrames } = video.getVideoPlaybackQuality()
        return { ranges, stalls, slow, joins, rate: video.playbackRate, all: totalVideoFrames, dropped: droppedVideoFrames, ahead: video.buffered.end(0) - video.buffered.start(0) } })()");
    assert_eq!((&told["ranges"], &told["stalls"]), (&json!(1), &json!(0)), "{told}");
    assert!(told["ahead"].as_f64().unwrap() < 200.0, "what was played is let go: {told}");
    let joins = told["joins"].as_array().unwrap();
    assert!(joins.len() as u64 > seconds() / 40, "{} clips were seen in {} s", joins.len(), seconds());
    for (at, join) in joins.iter().enumerate() {
        let frame = join[1].as_u64().unwrap();
        let fits = join[0] == at && (begins[at]..begins[at + 1]).contains(&frame);
        assert!(fits, "clip {at} begins at frame {}, was first seen at {frame}: {told}", begins[at]);
    }
    println!("{} frames, {} dropped, too slow at {}", told["all"], told["dropped"], told["slow"]);
    // How many frames are dropped is the machine's speed: `make soak` looks for half an hour, where nothing else runs.
    if seconds() >= SOAK_S {
        let part = told["dropped"].as_f64().unwrap() / told["all"].as_f64().unwrap();
        assert!(part <= 0.005, "{part} of the frames were dropped: {told}");
        assert_eq!(told["slow"], json!([]), "the decoder is too slow at these seconds: {told}");
        assert_eq!(told["rate"].as_f64(), Some(4.0), "it plays at another pace than it was told: {told}");
    }
}

#[test]
fn joins_in_the_loupe_are_those_that_ffmpeg_decodes_bit_for_bit() {
    let flock = own_copy();
    let folder = flock.path().to_owned();
    let clips = walk(&folder, "7", 30);
    let clips = &clips[..21];
    let expected: Vec<Vec<String>> = clips.iter().map(|clip| framehash(&folder.join(clip))).collect();
    let studio = Studio::of(&folder);
    let state = studio.get("/api/state");
    let key = |clip: &String| {
        let name = clip.split('/').next_back().unwrap().trim_end_matches(".mp4");
        let of = |list: &str, fits: &dyn Fn(&Value) -> bool| {
            let all = state[list].as_array().unwrap();
            all.iter().find(|one| fits(one)).unwrap_or_else(|| panic!("no `{name}`"))["fragments"].clone()
        };
        match name.split_once('=') {
            Some((from, to)) => of("transitions", &|one| one["from"] == from && one["to"] == to),
            None => of("sheep", &|one| one["id"] == name),
        }
    };
    let keys: Vec<Value> = clips.iter().map(key).collect();
    let browser = Browser::start();
    let page = Page::open(&browser, &studio.address(), LITTLE);
    let told = page.ask(&format!("import('/app/loupe.js').then(loupe => loupe.hashes({}))", json!(keys)));
    let told = told.as_array().expect("a list of frames");
    assert_eq!(told.len(), expected.iter().map(Vec::len).sum::<usize>());
    let mut all = expected
        .iter()
        .enumerate()
        .flat_map(|(clip, hashes)| hashes.iter().enumerate().map(move |(frame, hash)| (clip, frame, hash)));
    for seen in told {
        let (clip, frame, hash) = all.next().expect("there are as many");
        assert_eq!(
            (&seen["clip"], &seen["frame"], &seen["sha1"]),
            (&json!(clip), &json!(frame), &json!(hash)),
            "{}",
            clips[clip]
        );
    }
}
