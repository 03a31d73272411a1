//! Frames come out the same wherever they are rendered, and whatever happens meanwhile.
//!
//! Owns the claims on frames that many processes and machines render: killed, cut into parts, and sent to a real Slurm
//! cluster. What one process renders is in `render.rs`.

use claims::programs::{self, json, output};
use claims::rendering::{CLIPS, FRAMES, clips, count, frames, genomes, render, whole};
use claims::wait::{self, ends_within};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use std::fs;
use std::process::{Command, Stdio};

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
