//! Rendering a flock: resumed, shared, refused, and its hashes written.
//!
//! Owns the claims on selecting, making and writing hashes; whole runs of the program are claimed in `tests/it/tools`.

use std::fs;
use std::num::NonZeroUsize;
use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, LazyLock};

use ::species::{Light, Settings, Threads};
use flame::Backend;
use flock::{ClipHash, FILE_NAME, Manifest, SheepId};
use timing::Rate;
use video::{Form, Quality, Tuning};

use super::estimate;
use super::frames::part_of;
use super::hashes::write_hashes;
use super::make::{MakeError, Outcome, RunOptions, RunResult, make};
use super::plan::{ClipPlan, ClipRole, Look, SEED};
use super::selection::{Request, Scope, Selection};
use super::shard::{Part, shard};
use crate::program::Exit;

/// Tiny and coarse.
static LOOK: LazyLock<Look> = LazyLock::new(|| Look {
    form: Form { size: (64, 36), fps: Rate::new(30, 1).unwrap() },
    spp: Some(2.0),
    psnr: None,
    supersample: Some(1),
    temporal_samples: Some(3),
    seed: SEED,
    gpu: None,
    quality: Quality { crf: 20.0, preset: "ultrafast", tuning: Tuning::Film, max_bits_per_second: None },
});

const HEAD: &str = "format = 1\nname = \"small\"\nsize = [64, 36]\nfps = [30, 1]\n";

/// Two sheep that lead to each other.
const BODY: &str = "
[[sheep]]
id = \"a\" # the first
frames = 4
clip = \"loops/a.mp4\"
genome = \"a.flam3\"
[[sheep]]
id = \"b\"
frames = 6
clip = \"loops/b.mp4\"
genome = \"b.flam3\"
[[transition]]
from = \"a\"
to = \"b\"
frames = 3
clip = \"t/a=b.mp4\"
[[transition]]
from = \"b\"
to = \"a\"
frames = 3
clip = \"t/b=a.mp4\"
";

/// A flock whose clips are all missing.
struct TestFlock(tempfile::TempDir);

impl TestFlock {
    fn new(body: &str) -> Self {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join(FILE_NAME), format!("{HEAD}{body}")).unwrap();
        fs::write(folder.path().join("a.flam3"), include_str!("../../../demo/genomes/orchid.flam3")).unwrap();
        fs::write(folder.path().join("b.flam3"), include_str!("../../../demo/genomes/rosette.flam3")).unwrap();
        Self(folder)
    }

    fn path(&self) -> &Path {
        self.0.path()
    }

    fn at(&self, path: &str) -> PathBuf {
        self.path().join(path)
    }

    fn selection(&self, sheep: &[&str], again: bool, look: &Look) -> Selection {
        let manifest = Manifest::read(self.path()).unwrap();
        let sheep: Vec<_> = sheep.iter().map(|id| SheepId::new(id).unwrap()).collect();
        let scope = if again { Scope::All } else { Scope::Changed };
        Selection::new(self.path(), &manifest, &Request { sheep: &sheep, scope }, look, &Backend::default()).unwrap()
    }

    fn refused(&self, sheep: &[&str]) -> String {
        let manifest = Manifest::read(self.path()).unwrap();
        let sheep: Vec<_> = sheep.iter().map(|id| SheepId::new(id).unwrap()).collect();
        let request = Request { sheep: &sheep, scope: Scope::Changed };
        let refused = Selection::new(self.path(), &manifest, &request, &LOOK, &Backend::default());
        format!("{:?}", refused.err().unwrap())
    }

    fn make(&self, again: bool, look: &Look, options: &RunOptions) -> Result<RunResult, MakeError> {
        make(&self.selection(&[], again, look).clips, look, self.path(), options, &|_, _| ())
    }

    /// The bytes of all clips.
    fn clips(&self) -> Vec<Vec<u8>> {
        let manifest = Manifest::read(self.path()).unwrap();
        manifest.clips().map(|clip| fs::read(clip.path.inside(self.path())).unwrap()).collect()
    }
}

fn options(threads: usize) -> RunOptions {
    let threads = NonZeroUsize::new(threads).unwrap();
    RunOptions { threads, keep_frames: false, stop: Arc::default(), part: Part::Whole, shows_progress: false }
}

fn paths(selection: &Selection) -> Vec<&str> {
    selection.clips.iter().map(|clip| clip.path.as_str()).collect()
}

#[test]
fn the_number_of_threads_changes_no_byte() {
    let (one, three) = (TestFlock::new(BODY), TestFlock::new(BODY));
    let made = one.make(false, &LOOK, &options(1)).unwrap();
    assert_eq!(made.frames, 16);
    assert_eq!(made.outcomes, three.make(false, &LOOK, &options(3)).unwrap().outcomes);
    assert_eq!(one.clips(), three.clips());
    assert!(!one.at(".render/loops/a.mp4").exists(), "frames of finished clips are thrown away");
}

#[test]
fn what_was_interrupted_goes_on_and_ends_the_same() {
    let (whole, torn) = (TestFlock::new(BODY), TestFlock::new(BODY));
    whole.make(false, &LOOK, &options(2)).unwrap();
    torn.make(false, &LOOK, &RunOptions { keep_frames: true, ..options(2) }).unwrap();
    fs::write(torn.at("loops/a.mp4"), &torn.clips()[0][..200]).unwrap();
    fs::write(torn.at(".render/loops/b.mp4.made"), b"b3:\xff").unwrap();
    fs::write(torn.at(".render/loops/b.mp4/000002.yuv"), b"torn").unwrap();
    fs::remove_file(torn.at("t/a=b.mp4")).unwrap();
    let made = torn.make(true, &LOOK, &options(2)).unwrap();
    assert_eq!(made.frames, 1, "one frame was torn");
    assert!(matches!(made.outcomes[..], [Outcome::Made(_), Outcome::Made(_), Outcome::Made(_), Outcome::UpToDate(_)]));
    assert_eq!(torn.clips(), whole.clips());
}

#[test]
fn a_run_that_is_stopped_leaves_no_half_clip() {
    let flock = TestFlock::new(BODY);
    let stopped = RunOptions { stop: Arc::new(AtomicBool::new(true)), ..options(2) };
    let made = flock.make(false, &LOOK, &stopped).unwrap();
    assert_eq!((made.frames, &made.outcomes[..]), (0, &[Outcome::Unfinished; 4][..]));
    let stop = Arc::new(AtomicBool::new(false));
    let selection = flock.selection(&[], false, &LOOK);
    let after_one = |_: &_, _: ClipHash| stop.store(true, Ordering::Relaxed);
    make(&selection.clips, &LOOK, flock.path(), &RunOptions { stop: Arc::clone(&stop), ..options(1) }, &after_one)
        .unwrap();
    assert_eq!(paths(&flock.selection(&[], false, &LOOK)), ["loops/b.mp4", "t/a=b.mp4", "t/b=a.mp4"]);
    assert_eq!(fs::read_dir(flock.at("loops")).unwrap().count(), 1, "nothing but the finished clip");
}

#[test]
fn a_clip_that_another_process_has_taken_is_left_to_it() {
    let flock = TestFlock::new(BODY);
    fs::create_dir_all(flock.at(".render/loops")).unwrap();
    let other = fs::File::create(flock.at(".render/loops/b.mp4.made")).unwrap();
    other.lock().unwrap();
    let made = flock.make(false, &LOOK, &options(2)).unwrap();
    assert!(matches!(made.outcomes[..], [Outcome::Made(_), Outcome::Busy, Outcome::Made(_), Outcome::Made(_)]));
    drop(other);
    assert!(matches!(flock.make(false, &LOOK, &options(2)).unwrap().outcomes[..], [Outcome::Made(_)]));
}

#[test]
fn a_full_disk_takes_neither_the_old_clip_nor_the_frames() {
    let flock = TestFlock::new(BODY);
    flock.make(false, &LOOK, &options(2)).unwrap();
    let before = flock.clips();
    let finer = Look { spp: Some(4.0), ..*LOOK };
    // The disk is full when the second frame comes, and later when the clip is encoded.
    fs::create_dir_all(flock.at(".render/loops/a.mp4")).unwrap();
    symlink("/dev/full", part_of(&flock.at(".render/loops/a.mp4/000001.yuv"))).unwrap();
    let full = flock.make(true, &finer, &options(1)).unwrap_err();
    assert!(format!("{full:?}").contains("StorageFull"), "{full:?}");
    symlink("/dev/full", flock.at("loops/a.mp4.new.part")).unwrap();
    let full = flock.make(true, &finer, &options(1)).unwrap_err();
    assert!(matches!(full, MakeError::Encode(_)), "{full:?}");
    assert_eq!(flock.clips(), before);
    let made = flock.make(true, &finer, &options(1)).unwrap();
    assert_eq!(made.frames, 6 + 3 + 3, "the four frames of the first clip were kept");
    assert_ne!(flock.clips(), before);
}

#[test]
fn only_what_is_missing_is_selected_and_again_everything() {
    let flock = TestFlock::new(BODY);
    fs::create_dir(flock.at("t")).unwrap();
    fs::write(flock.at("t/a=b.mp4"), "the artist's own").unwrap();
    assert_eq!(paths(&flock.selection(&[], false, &LOOK)), ["loops/a.mp4", "loops/b.mp4", "t/b=a.mp4"]);
    assert_eq!(paths(&flock.selection(&["a"], false, &LOOK)), ["loops/a.mp4", "t/b=a.mp4"]);
    assert_eq!(paths(&flock.selection(&[], true, &LOOK)).len(), 4);
    assert!(flock.refused(&["ghost"]).contains("Unknown"));
}

#[test]
fn again_makes_what_was_made_from_something_else_and_nothing_twice() {
    let flock = TestFlock::new(BODY);
    let first = flock.make(false, &LOOK, &options(2)).unwrap();
    assert_eq!(flock.make(true, &LOOK, &options(2)).unwrap().frames, 0);
    fs::write(flock.at("b.flam3"), include_str!("../../../demo/genomes/undertow.flam3")).unwrap();
    let second = flock.make(true, &LOOK, &options(2)).unwrap();
    assert_eq!(second.frames, 6 + 3 + 3, "all but the loop of the sheep that stayed");
    assert!(matches!((first.outcomes[0], second.outcomes[0]), (Outcome::Made(a), Outcome::UpToDate(b)) if a == b));
    let coarser = Look { quality: Quality { crf: 45.0, ..LOOK.quality }, ..*LOOK };
    assert_eq!(flock.make(true, &coarser, &options(2)).unwrap().frames, 16, "no frames were kept");
}

#[test]
fn what_was_rendered_from_something_else_is_selected_and_what_is_the_artists_own_is_not() {
    let flock = TestFlock::new(BODY);
    flock.make(false, &LOOK, &options(2)).unwrap();
    assert_eq!(paths(&flock.selection(&[], false, &LOOK)), [""; 0]);
    let finer = Look { spp: Some(4.0), ..*LOOK };
    assert_eq!(flock.selection(&[], false, &finer).changed.len(), 4);
    fs::write(flock.at("b.flam3"), include_str!("../../../demo/genomes/undertow.flam3")).unwrap();
    let selection = flock.selection(&[], false, &LOOK);
    assert_eq!(paths(&selection), ["loops/b.mp4", "t/a=b.mp4", "t/b=a.mp4"]);
    assert_eq!(selection.changed.len(), 3);
    fs::write(flock.at("t/a=b.mp4"), "the artist's own").unwrap();
    assert_eq!(paths(&flock.selection(&[], false, &LOOK)), ["loops/b.mp4", "t/b=a.mp4"]);
    let manifest = Manifest::read(flock.path()).unwrap();
    let missing = Request { sheep: &[], scope: Scope::Missing };
    assert_eq!(Selection::new(flock.path(), &manifest, &missing, &LOOK, &Backend::default()).unwrap().clips.len(), 0);
}

#[test]
fn shards_render_all_frames_between_them_and_a_plain_run_encodes_them() {
    let (whole, cut) = (TestFlock::new(BODY), TestFlock::new(BODY));
    whole.make(false, &LOOK, &options(2)).unwrap();
    let mut frames = 0;
    for part in ["1/3", "3/3", "2/3", "1/3"] {
        let part = Part::Shard(shard(part).unwrap());
        let made = cut.make(false, &LOOK, &RunOptions { part, ..options(2) }).unwrap();
        assert_eq!(made.outcomes, [Outcome::Rendered; 4]);
        frames += made.frames;
    }
    assert_eq!(frames, 16, "none twice");
    assert!(!cut.at("loops/a.mp4").exists(), "nothing is encoded");
    assert_eq!(cut.make(false, &LOOK, &options(2)).unwrap().frames, 0);
    assert_eq!(cut.clips(), whole.clips());
}

#[test]
fn processes_that_render_parts_share_a_clip_and_keep_it_from_others() {
    let flock = TestFlock::new(BODY);
    fs::create_dir_all(flock.at(".render/loops")).unwrap();
    let other = fs::File::create(flock.at(".render/loops/b.mp4.made")).unwrap();
    other.lock_shared().unwrap();
    let made = flock.make(false, &LOOK, &options(2)).unwrap();
    assert!(matches!(made.outcomes[..], [Outcome::Made(_), Outcome::Busy, Outcome::Made(_), Outcome::Made(_)]));
    let part = Part::Shard(shard("1/2").unwrap());
    let made = flock.make(false, &LOOK, &RunOptions { part, ..options(2) }).unwrap();
    assert_eq!((&made.outcomes[..], made.frames), (&[Outcome::Rendered][..], 3));
}

#[test]
fn what_cannot_be_rendered_is_told_with_its_reason() {
    let body = BODY.replace("genome = \"b.flam3\"\n", "")
        + "[[transition]]\nfrom = \"a\"\nto = \"c\"\nframes = 3\nclip = \"c\"\n";
    let flock = TestFlock::new(&body);
    let selection = flock.selection(&[], false, &LOOK);
    assert_eq!(paths(&selection), ["loops/a.mp4"]);
    let told: Vec<_> = selection.left_out.iter().map(|one| (one.clip.as_str(), one.reason.as_str())).collect();
    let no_genome = "sheep `b` has no genome";
    let all = [("loops/b.mp4", no_genome), ("t/a=b.mp4", no_genome), ("t/b=a.mp4", no_genome)];
    assert_eq!(told, [&all[..], &[("c", "sheep `c` is not in the flock")]].concat());
}

#[test]
fn a_missing_or_torn_genome_leaves_its_own_clips_out_alone() {
    let flock = TestFlock::new(BODY);
    flock.make(false, &LOOK, &options(2)).unwrap();
    let malformed = [
        ("<flame/>", "no palette"),
        ("not xml", "XML"),
        ("<flames><flame/><flame/></flames>", "2"),
        ("<flame><xform weight=\"1\" waltz=\"1\"/><palette count=\"256\" format=\"RGB\"/></flame>", "0 digits"),
    ];
    let unreadable = [(None, "No such file", Exit::Unreadable)];
    for (text, part, exit) in
        malformed.map(|(text, part)| (Some(text), part, Exit::Malformed)).into_iter().chain(unreadable)
    {
        match text {
            Some(text) => fs::write(flock.at("b.flam3"), text).unwrap(),
            None => fs::remove_file(flock.at("b.flam3")).unwrap(),
        }
        for again in [false, true] {
            let selection = flock.selection(&[], again, &LOOK);
            assert_eq!(paths(&selection), if again { &["loops/a.mp4"][..] } else { &[] }, "{part}");
            let left_out: Vec<_> = selection.left_out.iter().map(|one| one.clip.as_str()).collect();
            assert_eq!(left_out, ["loops/b.mp4", "t/a=b.mp4", "t/b=a.mp4"], "clips that are there, too: {part}");
            assert_eq!(selection.exit() as u8, exit as u8, "{part}");
            for one in &selection.left_out {
                let told = one.in_words();
                assert!(told.contains("b.flam3") && told.contains(part) && told.contains("stays as it is"), "{told}");
            }
        }
    }
}

#[test]
fn nothing_is_rendered_over_a_genome_a_manifest_or_another_clip() {
    for path in ["flock.toml", "b.flam3", "loops/a.mp4"] {
        let flock = TestFlock::new(&BODY.replace("t/a=b.mp4", path));
        let selection = flock.selection(&[], true, &LOOK);
        assert!(selection.left_out.iter().any(|one| one.clip.as_str() == path), "{path}");
        assert!(!paths(&selection).contains(&path), "{path}");
    }
}

#[test]
fn a_transition_between_cameras_of_two_sizes_has_no_jump_half_way() {
    let flock = TestFlock::new(BODY);
    let genome = fs::read_to_string(flock.at("b.flam3")).unwrap();
    let larger = genome.replace("size=\"1280 720\"", "size=\"64 64\"");
    assert_ne!(genome, larger, "the genome is 1280 by 720");
    fs::write(flock.at("b.flam3"), larger).unwrap();
    let selection = flock.selection(&[], false, &LOOK);
    for clip in selection.clips.iter().filter(|clip| matches!(clip.role, ClipRole::Transition(..))) {
        let half = f64::from(clip.frames.0) / 2.0;
        let light = |frame: f64| {
            let settings = Settings { spp: Some(2000.0), ..LOOK.settings() };
            Light::of(&clip.motion.frame(frame, &settings, &Threads::new(0).unwrap()).unwrap().image)
        };
        let apart = light(half - 1e-9).apart(&light(half + 1e-9));
        assert!(apart < 0.01, "{}: {apart}", clip.path);
    }
}

#[test]
fn a_transition_takes_no_more_memory_and_no_other_samples_than_was_told_though_both_globes_are_there_half_way() {
    let flock = TestFlock::new(&BODY.replace(".flam3", ".agents").replace("frames = 3", "frames = 24"));
    fs::write(flock.at("a.agents"), include_str!("../../../demo/genomes/snowglobe.agents")).unwrap();
    fs::write(flock.at("b.agents"), include_str!("../../../demo/genomes/gilt.agents")).unwrap();
    // Small: what is drawn takes more than the picture.
    let look = *LOOK;
    let selection = flock.selection(&[], true, &look);
    let told = |clip: &ClipPlan| clip.demand(&look).unwrap().bytes as f64;
    for clip in &selection.clips {
        let frames = (0..=clip.frames.0).map(|frame| clip.motion.demand(f64::from(frame), &look.settings()).unwrap());
        let frames: Vec<_> = frames.collect();
        let most = frames.iter().map(|demand| demand.bytes).max().unwrap() as f64;
        assert!((0.95..1.2).contains(&(told(clip) / most)), "{:?}: {} {most}", clip.role, told(clip));
        if matches!(clip.role, ClipRole::Transition(..)) {
            let samples: f64 = frames[..24].iter().map(|demand| demand.samples as f64).sum();
            let estimated = estimate::samples(clip, 24, &look).unwrap();
            assert!((estimated / samples - 1.0).abs() < 0.1, "{:?}: {estimated} {samples}", clip.role);
            assert!(frames[12].bytes > frames[0].bytes, "{:?} {:?}", frames[0], frames[12]);
        }
    }
    let most = selection.clips.iter().map(told).fold(0.0, f64::max);
    assert!((selection.bytes as f64 - most).abs() < 1.0);
}

#[test]
fn hashes_go_into_the_manifest_and_nothing_else_changes() {
    let flock = TestFlock::new(BODY);
    write_hashes(flock.path()).unwrap();
    flock.make(false, &LOOK, &options(2)).unwrap();
    write_hashes(flock.path()).unwrap();
    let manifest = Manifest::read(flock.path()).unwrap();
    for clip in manifest.clips() {
        let file = fs::File::open(clip.path.inside(flock.path())).unwrap();
        assert_eq!(clip.hash, Some(ClipHash::of(file).unwrap()), "{}", clip.path);
    }
    let text = fs::read_to_string(flock.at(FILE_NAME)).unwrap();
    let others: Vec<_> = text.lines().filter(|line| !line.starts_with("hash")).collect();
    assert_eq!(others, format!("{HEAD}{BODY}").lines().collect::<Vec<_>>());
    write_hashes(flock.path()).unwrap();
    assert_eq!(fs::read_to_string(flock.at(FILE_NAME)).unwrap(), text);
}

#[test]
fn a_clip_that_the_tools_did_not_leave_so_keeps_its_hash() {
    let flock = TestFlock::new(BODY);
    flock.make(false, &LOOK, &options(2)).unwrap();
    fs::write(flock.at("loops/a.mp4"), "the artist's own").unwrap();
    write_hashes(flock.path()).unwrap();
    let manifest = Manifest::read(flock.path()).unwrap();
    let hashed: Vec<_> = manifest.clips().map(|clip| clip.hash.is_some()).collect();
    assert_eq!(hashed, [false, true, true, true]);
}

/// A flock of flames that was rendered by an earlier release is not rendered again: that takes hours.
#[test]
fn recipes_of_flames_are_what_they_were_before_there_were_other_species() {
    let flock = TestFlock::new(BODY);
    let gpu = Look { gpu: Some(ClipHash::of(&b"x"[..]).unwrap()), psnr: Some(30.0), spp: None, ..*LOOK };
    let recipes = |look: &Look| {
        let clips = flock.selection(&[], true, look).clips;
        let [first, _, transition, _] = &clips[..] else { panic!("{} clips", clips.len()) };
        [first.picture_recipe, first.recipe, transition.picture_recipe, transition.recipe].map(|hash| hash.to_string())
    };
    assert_eq!(flame::VERSION, 4, "another version makes other recipes, and these are to be written anew");
    assert_eq!(
        recipes(&LOOK),
        [
            "b3:27e880dee106e3cf9f2e5d246ac1e71e9a8a8eceded58fc193259e404873526c",
            "b3:c55a2b90cc902d4830f0dd8e4466445408f768638e3294a94fb205d62fd1b342",
            "b3:7d0ded5bf085be821275ef9361d31055270c360b3e27437a13ac5c2c045a36fd",
            "b3:ae8667631630347280f0f29eaf1e5481c762f3e9d9a24eba6a4262ae29294a98",
        ]
    );
    assert_eq!(
        recipes(&gpu),
        [
            "b3:ac32a7a9f7171951973ca46ba08b3f27de1a16cb6eef32519e1eb3ba3f616e83",
            "b3:1a1067b51fa811b9e3f451ebf0968b05641253608ea8b38782b841445ec8e5d4",
            "b3:f76153f79816b17de4ac6c438989a925b36045aed40713005aca6d213537304b",
            "b3:559567bf1021ed2c5a257f40212467484e1fc6a168e35a4110f451af54174b8e",
        ]
    );
}
