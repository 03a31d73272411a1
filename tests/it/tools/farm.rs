//! Frames come out the same wherever they are rendered, and whatever happens meanwhile.
//!
//! Owns the claims on frames that many processes and machines render: killed, cut into parts, and sent to a real Slurm
//! cluster. What one process renders is in `render.rs`.

use crate::programs::{self, output};
use crate::slurm_cluster::{PARTITION, SlurmCluster};
use crate::tools::command_line::json;
use crate::tools::render::{CLIPS, clips, genomes};
use claims::wait::{self, ends_within};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use rustix::process::{Pid, Signal, kill_process};
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// The frames of the clips together.
const FRAMES: usize = 35;

/// `dreams render FOLDER`, which keeps its frames; each takes so many samples per pixel.
fn render(command: &mut Command, folder: &Path, spp: &str) {
    command.arg("render").arg(folder).args(["--temporal-samples", "4", "--spp", spp]);
}

/// The files of all frames, by their paths.
fn frames(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut found = BTreeMap::new();
    for clip in CLIPS {
        for entry in fs::read_dir(folder.join(".render").join(clip)).into_iter().flatten() {
            let path = entry.unwrap().path();
            // One that is being written may be renamed meanwhile.
            let bytes = fs::read(&path).unwrap_or_default();
            found.insert(path.strip_prefix(folder).unwrap().to_owned(), bytes);
        }
    }
    found
}

/// The number of frames that are there.
fn count(folder: &Path) -> usize {
    let is_frame = |path: &&PathBuf| path.extension().is_some_and(|ending| ending == "yuv");
    frames(folder).keys().filter(is_frame).count()
}

/// A flock that one process has rendered at once, with its frames.
fn whole(spp: &str) -> tempfile::TempDir {
    let flock = genomes();
    let mut command = Command::new(programs::dreams());
    render(&mut command, flock.path(), spp);
    let said = output(command.arg("--keep-frames"));
    assert_eq!(said.status.code(), Some(0), "{}", String::from_utf8_lossy(&said.stderr));
    assert_eq!(count(flock.path()), FRAMES);
    flock
}

#[test]
fn a_rendering_killed_twenty_times_at_random_gives_the_same_frames_on_any_number_of_threads() {
    let spp = "300";
    let whole = whole(spp);
    let mut random = ChaCha8Rng::seed_from_u64(18);
    for threads in ["1", "2", "7"] {
        let flock = genomes();
        let mut in_the_middle = 0;
        for kill in 0..20 {
            let before = count(flock.path());
            let mut command = Command::new(programs::dreams());
            render(&mut command, flock.path(), spp);
            command.args(["--keep-frames", "--threads", threads]);
            let mut running = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
            // Every second time at any moment, otherwise some time after another frame.
            let mut ticks = random.next_u32() % 40;
            wait::until("the moment of a kill", 600, || {
                let is_counted = kill % 2 == 0 || count(flock.path()) > before || ends_within(&running, 0);
                ticks = ticks.saturating_sub(u32::from(is_counted));
                ticks == 0
            });
            in_the_middle += usize::from(!ends_within(&running, 0) && before < FRAMES);
            running.kill().unwrap();
            running.wait().unwrap();
        }
        assert!(in_the_middle >= 5, "{threads} threads: only {in_the_middle} kills in the middle");
        let mut command = Command::new(programs::dreams());
        render(&mut command, flock.path(), spp);
        let said = output(command.args(["--keep-frames", "--again", "--threads", threads]));
        assert_eq!(said.status.code(), Some(0), "{}", String::from_utf8_lossy(&said.stderr));
        assert!(frames(flock.path()) == frames(whole.path()), "{threads} threads: other frames");
        assert!(clips(flock.path()) == clips(whole.path()), "{threads} threads: other clips");
    }
}

#[test]
fn the_same_frames_make_the_same_clips_whatever_was_in_memory_before() {
    let flock = whole("4");
    let before = clips(flock.path());
    // glibc fills memory that it takes back with this byte, and memory that it hands out with its complement.
    for byte in ["1", "90", "165", "254"] {
        for clip in CLIPS {
            fs::remove_file(flock.path().join(clip)).unwrap();
        }
        let mut command = Command::new(programs::dreams());
        render(&mut command, flock.path(), "4");
        let said = output(command.args(["--keep-frames", "--json"]).env("MALLOC_PERTURB_", byte));
        assert_eq!(json(&said)["frames"], 0, "all frames were there");
        assert!(clips(flock.path()) == before, "other clips with memory full of {byte}");
    }
}

#[test]
fn shards_at_once_and_a_killed_one_make_the_frames_of_one_run() {
    let spp = "300";
    let (whole, flock) = (whole(spp), genomes());
    let shard = |part: &str| {
        let mut command = Command::new(programs::dreams());
        render(&mut command, flock.path(), spp);
        command.args(["--threads", "1", "--json", "--shard", part]);
        command
    };
    let spawn = |part| shard(part).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let mut running = ["1/3", "2/3", "3/3"].map(spawn);
    wait::until("some frames", 600, || count(flock.path()) >= 3);
    running[1].kill().unwrap();
    for (part, child) in running.into_iter().enumerate() {
        let said = wait::output("a shard", 600, child);
        if part != 1 {
            assert_eq!(said.status.code(), Some(0), "{}", String::from_utf8_lossy(&said.stderr));
            let told = json(&said);
            let of_clips = told["clips"].as_array().unwrap();
            assert!(of_clips.len() == 5 && of_clips.iter().all(|clip| clip["state"] == "rendered"), "{told}");
        }
    }
    assert!(CLIPS.iter().all(|clip| !flock.path().join(clip).exists()), "a shard encodes nothing");
    assert_eq!(output(&mut shard("2/3")).status.code(), Some(0));
    assert_eq!(count(flock.path()), FRAMES);
    let mut command = Command::new(programs::dreams());
    render(&mut command, flock.path(), spp);
    let made = json(&output(command.args(["--keep-frames", "--json"])));
    assert_eq!(made["frames"], 0, "all were there: {made}");
    assert!(frames(flock.path()) == frames(whole.path()), "other frames");
    assert!(clips(flock.path()) == clips(whole.path()), "other clips");
    assert_eq!(output(&mut shard("4/3")).status.code(), Some(2), "a part that there is not");
}

/// The processes of tasks in `folder` that render.
fn tasks(folder: &Path) -> Vec<Pid> {
    let is_task = |process: &Path| {
        let words = fs::read(process.join("cmdline")).unwrap_or_default();
        let is_ours = fs::read_link(process.join("cwd")).is_ok_and(|cwd| cwd == folder);
        is_ours && String::from_utf8_lossy(&words).contains("--plan=.render/slurm/")
    };
    let processes = fs::read_dir("/proc").unwrap().map(|entry| entry.unwrap().path());
    let number = |path: PathBuf| path.file_name()?.to_str()?.parse().ok();
    processes.filter(|path| is_task(path)).filter_map(number).filter_map(Pid::from_raw).collect()
}

#[test]
fn a_cluster_renders_the_frames_of_one_run_whatever_is_killed() {
    let spp = "6000";
    let (whole, flock, cluster) = (whole(spp), genomes(), SlurmCluster::start(2));
    let folder = flock.path().canonicalize().unwrap();
    let sent = |more: &[&str]| {
        let mut command = cluster.command(programs::dreams());
        render(&mut command, &folder, spp);
        command.args(["--on", "slurm", "--keep-frames", "--json"]).args(more);
        command
    };
    let said = output(&mut sent(&["--partition", "goats"]));
    let error = json(&said)["error"].to_string();
    assert_eq!(said.status.code(), Some(3), "{error}");
    let mut here = Command::new(programs::dreams());
    render(&mut here, &folder, spp);
    let said = output(here.args(["--on", "cpu", "--tasks", "3"]));
    assert_eq!(said.status.code(), Some(2), "options of a cluster are not for this machine");
    assert!(error.contains("sbatch") && error.contains("partition"), "{error}");

    // Damaged: it does not verify.
    let damaged = folder.join(".render").join(CLIPS[0]).join("000002.yuv");
    fs::create_dir_all(damaged.parent().unwrap()).unwrap();
    let mut bytes = fs::read(whole.path().join(damaged.strip_prefix(&folder).unwrap())).unwrap();
    bytes[100] ^= 1;
    fs::write(damaged, bytes).unwrap();

    let mut first =
        sent(&["--tasks", "3", "--partition", PARTITION]).stdout(Stdio::null()).stderr(Stdio::null()).spawn();
    let first = first.as_mut().unwrap();
    wait::until("the first frames of a task", 300, || count(&folder) >= 3 && !tasks(&folder).is_empty());
    let second = output(&mut sent(&[]));
    assert_eq!(second.status.code(), Some(1), "{}", String::from_utf8_lossy(&second.stderr));
    assert!(json(&second)["error"]["message"].as_str().unwrap().contains("another run"), "one at a time");
    first.kill().unwrap();
    first.wait().unwrap();
    let before = count(&folder);
    assert!(before < FRAMES, "the tasks were too fast for this claim");
    let killed = tasks(&folder)[0];
    kill_process(killed, Signal::KILL).unwrap();

    let said = output(&mut sent(&["--partition", PARTITION]));
    let told = String::from_utf8_lossy(&said.stderr);
    assert_eq!(said.status.code(), Some(0), "{told}");
    assert!(told.contains("of an earlier run") && told.contains("sent again"), "{told}");
    let answer = json(&said);
    assert!(answer["clips"].as_array().unwrap().iter().all(|clip| clip["state"] == "made"), "{answer}");
    assert!(frames(&folder) == frames(whole.path()), "other frames");
    for ((clip, ours), theirs) in CLIPS.iter().zip(clips(&folder)).zip(clips(whole.path())) {
        let differs = ours.iter().zip(&theirs).position(|(ours, theirs)| ours != theirs);
        let sizes = (ours.len(), theirs.len());
        assert!(ours == theirs, "`{clip}` is another: {sizes:?} bytes, the first that differs is {differs:?}");
    }
    let plans = fs::read_dir(folder.join(".render/slurm")).unwrap().map(|entry| entry.unwrap().path());
    assert!(
        plans.filter(|path| path.extension().is_some_and(|ending| ending == "json")).count() == 0,
        "a plan is left"
    );
}

#[test]
fn a_task_that_cannot_render_is_given_up_with_what_it_said() {
    let (flock, cluster) = (genomes(), SlurmCluster::start(2));
    let mut command = cluster.command(programs::dreams());
    render(&mut command, flock.path(), "4");
    let said = output(command.args(["--on", "slurm", "--tasks", "1", "--sbatch=--wrap=echo no disk here; false"]));
    let error = String::from_utf8_lossy(&said.stderr);
    assert_eq!(said.status.code(), Some(3), "{error}");
    assert!(error.contains("3 times") && error.contains("no disk here"), "{error}");
}
