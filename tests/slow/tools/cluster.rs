//! A real Slurm cluster renders the frames that one process renders.
//!
//! Owns the claims on `dreams render --on slurm`: killed tasks, damaged frames, and tasks that cannot render. Parts that
//! this machine renders are in `it/tools/farm.rs`.

use crate::slurm_cluster::{PARTITION, SlurmCluster};
use claims::programs::{self, json, output};
use claims::rendering::{CLIPS, FRAMES, clips, count, frames, genomes, render, whole};
use claims::wait;
use rustix::process::{Pid, Signal, kill_process};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

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
