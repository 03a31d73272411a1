//! What `make play` does: the flock is rendered better while it plays, and the player takes over each clip at a join.
//!
//! Owns the claim on `flock-tools/demo/play`, on a virtual screen in real time.

use claims::clips::framemd5;
use claims::programs::{self, succeed};
use claims::rendering::{CLIPS, clips, genomes};
use claims::trace::{Flip, Trace};
use claims::wait;
use rustix::process::{Pid, Signal, kill_process_group};
use std::fs;
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

/// How long a few tiny frames may take on a busy machine, in seconds.
const SECONDS: u32 = 120;

/// `flock-tools/demo/play` with `flock`, its state and its trace in `scratch`, in a process group of its own.
fn play(flock: &Path, scratch: &Path) -> Child {
    let mut script = Command::new(programs::repository().join("flock-tools/demo/play"));
    script.arg(programs::player()).arg(programs::dreams()).arg(flock).arg(scratch.join("a state"));
    script
        .args(["--screen", "virtual", "--status", "off", "--seed", "5", "--hash", "--trace"])
        .arg(scratch.join("trace"));
    script.process_group(0).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap()
}

/// The copy that is played from.
fn copy(scratch: &Path) -> Option<PathBuf> {
    let inside = fs::read_dir(scratch.join("a state")).ok()?.map(|entry| entry.unwrap().path());
    inside.into_iter().find(|path| path.file_name().unwrap().to_string_lossy().starts_with("flock-"))
}

/// What the player has told so far.
fn trace_of(scratch: &Path) -> Option<Trace> {
    let path = scratch.join("trace");
    path.exists().then(|| Trace::read(&path))
}

/// The flips of each visit of a clip, in their order; the last one may have just begun.
fn visits(trace: &Trace) -> Vec<&[Flip]> {
    trace.flips.chunk_by(|one, next| one.clip == next.clip && one.frame < next.frame).collect()
}

/// Whether a visit shows these frames, from the first on.
fn shows(visit: &[Flip], frames: &[String]) -> bool {
    visit.len() <= frames.len()
        && visit.iter().map(|flip| flip.hash.as_ref()).eq(frames[..visit.len()].iter().map(Some))
}

#[test]
fn a_flock_is_rendered_better_while_it_plays_and_each_clip_is_taken_over_at_a_join() {
    let (flock, scratch) = (genomes(), tempfile::tempdir_in(programs::claims_folder()).unwrap());
    let folder = flock.path();
    succeed(Command::new(programs::dreams()).arg("render").arg(folder).args(["--preset", "draft"]));
    let before = clips(folder);
    let coarse = CLIPS.map(|clip| framemd5(&folder.join(clip)));

    let mut running = play(folder, scratch.path());
    wait::until("every clip is rendered better", SECONDS, || {
        copy(scratch.path()).is_some_and(|copy| clips(&copy).iter().zip(&before).all(|(now, then)| now != then))
    });
    let better = copy(scratch.path()).unwrap();
    let fine = CLIPS.map(|clip| framemd5(&better.join(clip)));
    let trace = || trace_of(scratch.path()).unwrap();
    wait::until("every clip is shown as it is now", SECONDS, || {
        let (trace, mut places) = (trace(), 0..CLIPS.len());
        places.all(|place| visits(&trace).iter().any(|visit| visit.len() > 1 && shows(visit, &fine[place])))
    });
    let group = Pid::from_child(&running);
    kill_process_group(group, Signal::INT).unwrap();
    assert_eq!(wait::ended("the script, after Ctrl-C", 30, &mut running).code(), Some(0));

    let trace = trace();
    assert!(trace.faults.is_empty(), "{:?}", trace.faults);
    for visit in visits(&trace) {
        let place = CLIPS.iter().position(|clip| *clip == visit[0].clip).unwrap();
        assert!(shows(visit, &coarse[place]) || shows(visit, &fine[place]), "a visit of {} is torn", visit[0].clip);
    }
    assert_eq!(clips(folder), before, "the flock itself stays as it is");
    succeed(Command::new(programs::dreams()).arg("check").arg(&better));
}

#[test]
fn rendering_ends_with_the_player_and_the_next_run_goes_on_with_what_there_is() {
    let (flock, scratch) = (genomes(), tempfile::tempdir_in(programs::claims_folder()).unwrap());
    let folder = flock.path();
    // So large that it is not finished before the player ends.
    let manifest = fs::read_to_string(folder.join("flock.toml")).unwrap().replace("[64, 36]", "[640, 360]");
    fs::write(folder.join("flock.toml"), manifest).unwrap();
    succeed(Command::new(programs::dreams()).arg("render").arg(folder).args(["--preset", "draft", "--spp", "1"]));
    let kept = || copy(scratch.path()).map(|copy| copy.join(".render"));
    let frames = || kept().map_or(0, |folder| count(&folder));
    for run in ["first", "second"] {
        let there = frames();
        // The trace of the run before.
        let _ = fs::remove_file(scratch.path().join("trace"));
        let mut running = play(folder, scratch.path());
        wait::until("a picture", SECONDS, || trace_of(scratch.path()).is_some_and(|trace| !trace.flips.is_empty()));
        wait::until(&format!("the {run} run has finished a frame"), SECONDS, || frames() > there);
        kill_process_group(Pid::from_child(&running), Signal::INT).unwrap();
        assert_eq!(wait::ended("the script, after Ctrl-C", 30, &mut running).code(), Some(0));
        let log = scratch.path().join("a state/render.log");
        wait::until(&format!("the {run} run's rendering has ended and says how to go on"), 30, || {
            fs::read_to_string(&log).unwrap().contains("the same command continues")
        });
        assert!(frames() > there, "finished frames are kept");
    }
}

/// How many frames are kept below `folder`.
fn count(folder: &Path) -> usize {
    let Ok(inside) = fs::read_dir(folder) else { return 0 };
    let paths = inside.filter_map(|entry| Some(entry.ok()?.path()));
    let is_frame = |path: &Path| path.extension().is_some_and(|ending| ending == "yuv");
    paths.map(|path| if path.is_dir() { count(&path) } else { is_frame(&path).into() }).sum()
}
