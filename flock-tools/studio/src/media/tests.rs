//! What the page gets of a small flock, and what it costs when it is cancelled.
//!
//! Owns the claims that need genomes and clips; what one file promises by itself is tested in it.

use std::fs;
use std::path::{Path, PathBuf};

use flock::{Clip, ClipPath, FILE_NAME, Manifest, SheepId};
use timing::FrameCount;
use video::Form;

use super::sources::Pair;
use super::strip::STRIP_BYTES;
use super::{Media, MediaError, Wanted};
use crate::jobs::Progress;

/// Sheep of every species; two of them have loops, and one transition of each kind is missing.
const MANIFEST: &str = r#"format = 1
name = "small"
size = [64, 36]
fps = [30, 1]
[[sheep]]
id = "lagoon"
genome = "lagoon.expr"
frames = 30
clip = "loops/lagoon.mp4"
[[sheep]]
id = "vesper"
genome = "vesper.expr"
frames = 24
clip = "loops/vesper.mp4"
[[sheep]]
id = "orchid"
genome = "orchid.flam3"
[[sheep]]
id = "linden"
genome = "linden.plant"
[[sheep]]
id = "gilt"
genome = "gilt.agents"
[[transition]]
from = "lagoon"
to = "vesper"
frames = 12
clip = "transitions/lagoon=vesper.mp4"
"#;

struct TestFlock {
    scratch: tempfile::TempDir,
    media: Media,
}

impl TestFlock {
    fn new() -> Self {
        let scratch = tempfile::tempdir().unwrap();
        let genomes = Path::new(env!("CARGO_MANIFEST_DIR")).join("../demo/genomes");
        for name in ["lagoon.expr", "vesper.expr", "orchid.flam3", "linden.plant", "gilt.agents"] {
            fs::copy(genomes.join(name), scratch.path().join(name)).unwrap();
        }
        fs::write(scratch.path().join(FILE_NAME), MANIFEST).unwrap();
        let media = Media::open(scratch.path(), &scratch.path().join(".studio"));
        Self { scratch, media }
    }

    fn manifest(&self) -> Manifest {
        Manifest::read(self.scratch.path()).unwrap()
    }

    fn form(&self) -> Form {
        let manifest = self.manifest();
        Form { size: manifest.size, fps: manifest.fps }
    }

    fn at(&self, path: &str) -> PathBuf {
        self.scratch.path().join(path)
    }

    fn clip(&self, id: &str) -> Clip {
        self.manifest().sheep.iter().find(|sheep| sheep.id.as_str() == id).unwrap().clip.clone().unwrap()
    }

    /// The key of the strip of a sheep, as the page has it.
    fn strip_key(&self, id: &str) -> Option<String> {
        let manifest = self.manifest();
        let sheep = manifest.sheep.iter().find(|sheep| sheep.id.as_str() == id).unwrap();
        let genome = sheep.genome.as_ref().map(|genome| genome.inside(self.scratch.path()));
        self.media.strip_key(self.form(), sheep.clip.as_ref(), genome.as_deref())
    }

    fn pair_key(&self, from: &str, to: &str, frames: u32) -> Option<String> {
        let [from, to] = [from, to].map(|id| SheepId::new(id).unwrap());
        self.media.pair_key(&self.manifest(), &Pair { from: &from, to: &to, frames: FrameCount(frames) })
    }

    fn render(&self, path: &str) -> Result<serde_json::Value, String> {
        self.media.render(&ClipPath::new(path).unwrap(), true, &Progress::detached())
    }
}

/// The width and height of a JPEG.
fn size(path: &Path) -> (u16, u16) {
    let bytes = fs::read(path).unwrap();
    assert!(bytes.starts_with(&[0xff, 0xd8]) && bytes.len() < STRIP_BYTES, "{} bytes", bytes.len());
    let at = bytes.windows(2).position(|two| two == [0xff, 0xc0]).expect("a frame header");
    let number = |at: usize| u16::from_be_bytes([bytes[at], bytes[at + 1]]);
    (number(at + 7), number(at + 5))
}

#[test]
fn every_sheep_has_a_strip_of_24_pictures_with_or_without_a_clip() {
    let flock = TestFlock::new();
    for id in ["lagoon", "vesper", "orchid", "linden", "gilt"] {
        let key = flock.strip_key(id).unwrap();
        assert!(flock.media.find_strip(&key).is_none() && flock.media.look(&key).is_none());
        let path = flock.media.make_strip(&key, &Progress::detached()).unwrap();
        assert_eq!(size(&path), (6 * 64, 4 * 36), "{id}");
        let (activity, colour) = flock.media.look(&key).unwrap();
        assert!(activity > 0.001 && activity < 0.5 && colour.len() == 7, "{id}: {activity} {colour}");
        assert_eq!(flock.media.find_strip(&key), Some(path));
        assert_eq!(size(&flock.media.poster(&key).unwrap()), (64, 36), "{id}");
    }
    let of_genome = flock.strip_key("vesper").unwrap();
    flock.render("loops/vesper.mp4").unwrap();
    let of_clip = flock.strip_key("vesper").unwrap();
    assert_ne!(of_clip, of_genome, "a clip has another key than what there was before it");
    assert_eq!(size(&flock.media.make_strip(&of_clip, &Progress::detached()).unwrap()), (6 * 64, 4 * 36));
    let [a, b] = [&of_genome, &of_clip].map(|key| flock.media.look(key).unwrap().0);
    assert!((a - b).abs() < 0.2 * a, "both show one turn of the same sheep: {a} {b}");
}

#[test]
fn a_key_follows_what_it_is_made_of_and_a_key_of_nobody_is_refused() {
    let flock = TestFlock::new();
    let before = flock.strip_key("orchid").unwrap();
    assert_eq!(flock.strip_key("orchid").unwrap(), before);
    assert!(flock.media.knows(&before));
    fs::copy(flock.at("lagoon.expr"), flock.at("orchid.flam3")).unwrap();
    let after = flock.strip_key("orchid").unwrap();
    assert_ne!(after, before);
    fs::remove_file(flock.at("orchid.flam3")).unwrap();
    assert_eq!(flock.strip_key("orchid"), None);
    let gone = flock.media.make_strip(&after, &Progress::detached()).unwrap_err();
    assert!(matches!(gone, MediaError::Refused { .. }), "{gone}");
    for key in ["", "../flock", "00112233445566778899aabbccddeeff"] {
        let unknown = flock.media.make_strip(key, &Progress::detached());
        assert!(matches!(unknown, Err(MediaError::Unknown { .. })) && !flock.media.knows(key));
        assert!(flock.media.fragments(key).is_err() && flock.media.packets(key, 0..1).is_err());
        assert!(flock.media.find_middle(key, 1).is_none() && flock.media.moving(key, 0).is_none());
    }
}

#[test]
fn a_clip_is_rendered_as_the_command_does_and_goes_to_the_page_in_pieces() {
    let flock = TestFlock::new();
    let (work, left_out) = flock.media.to_render(&flock.manifest(), &Wanted::Missing, true).unwrap();
    let whats: Vec<_> = work.iter().map(|work| work.what.as_str()).collect();
    assert_eq!(whats, ["the loop of lagoon", "the loop of vesper", "the transition from lagoon to vesper"]);
    assert_eq!(left_out, [""; 0]);
    assert!(work.iter().all(|work| work.cost_s.is_some_and(|cost| cost > 0.0 && cost < 60.0)), "{work:?}");
    assert!(flock.media.fragments_key(flock.form(), &flock.clip("lagoon")).is_none(), "it is not there yet");
    let answer = flock.render("loops/lagoon.mp4").unwrap();
    assert_eq!(answer["frames"], 30);
    let clip = flock.clip("lagoon");
    assert_eq!(clip.hash.unwrap().to_string(), answer["hash"], "the manifest has the hash");
    assert_eq!(flock.render("loops/lagoon.mp4").unwrap()["frames"], 0, "it is not rendered twice");
    let (rest, _) = flock.media.to_render(&flock.manifest(), &Wanted::Missing, true).unwrap();
    assert_eq!(rest.len(), 2);
    let key = flock.media.fragments_key(flock.form(), &clip).unwrap();
    let (path, codec) = flock.media.fragments(&key).unwrap();
    assert!(codec.starts_with("avc1.64") && fs::read(&path).unwrap()[4..8] == *b"ftyp");
    let packets = flock.media.packets(&key, 20..24).unwrap();
    let head = u32::from_le_bytes(packets[..4].try_into().unwrap()) as usize;
    let told: serde_json::Value = serde_json::from_slice(&packets[4..4 + head]).unwrap();
    let list = told["packets"].as_array().unwrap();
    let bytes: u64 = list.iter().map(|packet| packet["bytes"].as_u64().unwrap()).sum();
    assert_eq!(bytes as usize, packets.len() - 4 - head);
    let shown = list.iter().filter(|packet| packet["show"] == true).map(|packet| packet["pts"].as_u64().unwrap());
    let mut shown: Vec<_> = shown.collect();
    shown.sort_unstable();
    assert_eq!(shown, [20, 21, 22, 23]);
    assert_eq!((&told["frames"], &told["rate"]), (&30.into(), &serde_json::json!([30, 1])));
}

#[test]
fn a_damaged_clip_has_no_fragments_and_its_strip_comes_from_its_genome() {
    let flock = TestFlock::new();
    fs::create_dir(flock.at("loops")).unwrap();
    fs::write(flock.at("loops/vesper.mp4"), "damaged").unwrap();
    let key = flock.strip_key("vesper").unwrap();
    flock.media.make_strip(&key, &Progress::detached()).unwrap();
    assert_eq!(size(&flock.media.poster(&key).unwrap()), (64, 36));
    let refused = flock.media.fragments(&key).unwrap_err().to_string();
    assert!(refused.contains("loops/vesper.mp4"), "{refused}");
}

#[test]
fn a_transition_that_does_not_exist_is_seen_and_judged_before_it_is_rendered() {
    let flock = TestFlock::new();
    for (from, to) in [("vesper", "lagoon"), ("vesper", "linden")] {
        let key = flock.pair_key(from, to, 20).unwrap();
        assert_ne!(key, flock.pair_key(from, to, 21).unwrap());
        let figures = flock.media.make_middles(&key, &Progress::detached()).unwrap();
        assert!(figures["score"].as_f64().unwrap() > 0.0, "{figures}");
        assert_eq!(flock.media.find_figures(&key), Some(figures));
        for at in 1..=3 {
            assert_eq!(size(&flock.media.find_middle(&key, at).unwrap()), (64, 36));
        }
        assert_eq!(flock.media.find_middle(&key, 4), None);
        assert!(flock.media.moving(&key, 0).is_none());
        flock.media.make_moving(&key, &Progress::detached()).unwrap();
        let (whole, is_whole) = flock.media.moving(&key, 0).unwrap();
        assert!(is_whole && whole[4..8] == *b"ftyp");
        assert_eq!(flock.media.moving(&key, 100).unwrap().0, whole[100..]);
        assert_eq!(flock.media.moving(&key, u64::MAX), Some((Vec::new(), true)));
        let cost = |frames| {
            let [from, to] = [from, to].map(|id| SheepId::new(id).unwrap());
            flock.media.cost_s(&flock.manifest(), &from, &to, FrameCount(frames), false).unwrap()
        };
        assert!((cost(40) / cost(20) - 2.0).abs() < 1e-6);
    }
}

#[test]
fn a_cancelled_render_keeps_its_frames_and_the_next_one_goes_on() {
    let flock = TestFlock::new();
    let path = ClipPath::new("loops/lagoon.mp4").unwrap();
    let stopped = flock.media.render(&path, false, &Progress::cancelled_after(3));
    let kept = fs::read_dir(flock.at(".render/loops/lagoon.mp4")).map_or(0, Iterator::count);
    assert!(stopped.is_err() && kept > 2 && !flock.at("loops/lagoon.mp4").exists(), "{stopped:?} {kept}");
    let made = flock.media.render(&path, false, &Progress::detached()).unwrap();
    let rendered = made["frames"].as_u64().unwrap() as usize;
    assert!(rendered + kept <= 31 && rendered < 30, "{rendered} of 30 after {kept} were kept");
    assert!(flock.at("loops/lagoon.mp4").is_file());
}

#[test]
fn work_that_is_cancelled_leaves_nothing_half_made() {
    let flock = TestFlock::new();
    let (strip, pair) = (flock.strip_key("orchid").unwrap(), flock.pair_key("orchid", "gilt", 20).unwrap());
    let cancelled = Progress::detached();
    cancelled.cancel();
    assert!(matches!(flock.media.make_strip(&strip, &cancelled), Err(MediaError::Cancelled)));
    assert!(matches!(flock.media.make_middles(&pair, &cancelled), Err(MediaError::Cancelled)));
    assert!(matches!(flock.media.make_moving(&pair, &cancelled), Err(MediaError::Cancelled)));
    assert!(flock.media.find_strip(&strip).is_none() && flock.media.moving(&pair, 0).is_none());
}
