//! `dreams render` makes what is missing, and continues after an interruption.
//!
//! Owns the claims on whole runs of the program. What is chosen, kept and refused in detail is tested beside the code.

use claims::programs::{self, json, output};
use claims::rendering::{CLIPS, MANIFEST, clips, genomes};
use claims::wait::{self, ends_within};
use rustix::process::{Pid, Signal, kill_process};
use serde_json::Value;
use std::fs;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Command, Stdio};
use tempfile::TempDir;

/// `dreams render FOLDER OPTIONS...`, at low quality.
fn render(folder: &Path, options: &[&str]) -> Command {
    let mut command = Command::new(programs::dreams());
    command.arg("render").arg(folder).args(["--temporal-samples", "4"]).args(options);
    if !options.contains(&"--spp") {
        command.args(["--spp", "4"]);
    }
    command
}

#[test]
fn genomes_become_a_flock_without_a_fault() {
    let flock = genomes();
    let folder = flock.path();
    let dry = output(&mut render(folder, &["--dry-run", "--json"]));
    assert_eq!(dry.status.code(), Some(0));
    let told = json(&dry);
    assert_eq!((told["frames"].as_u64(), told["clips"].as_array().unwrap().len()), (Some(35), 5));
    assert!(told["cpu_hours"].as_f64().unwrap() > 0.0);
    assert!(!folder.join("loops").exists() && !folder.join(".render").exists(), "a dry run writes nothing");

    let said = output(&mut render(folder, &[]));
    assert_eq!(said.status.code(), Some(0), "{}", String::from_utf8_lossy(&said.stderr));
    let lines: Vec<_> = said.stdout.lines().map(Result::unwrap).collect();
    assert_eq!(lines.len(), 5);
    assert!(CLIPS.iter().all(|clip| lines.iter().any(|line| line.starts_with(&format!("{clip} ")))), "{lines:?}");
    let check = output(Command::new(programs::dreams()).args(["check", "--json"]).arg(folder));
    assert_eq!(json(&check)["faults"].as_array().unwrap().len(), 0, "{}", String::from_utf8_lossy(&check.stdout));

    let manifest = fs::read_to_string(folder.join("flock.toml")).unwrap();
    assert_eq!(manifest.lines().filter(|line| line.starts_with("hash = \"b3:")).count(), 5, "{manifest}");
    let others: Vec<_> = manifest.lines().filter(|line| !line.starts_with("hash")).collect();
    assert_eq!(others, MANIFEST.lines().collect::<Vec<_>>(), "nothing but hashes came");

    let again = json(&output(&mut render(folder, &["--json"])));
    assert_eq!((again["frames"].as_u64(), again["clips"].as_array().unwrap().len()), (Some(0), 0));
}

#[test]
fn a_program_that_cannot_use_a_gpu_says_how_one_is_built_that_can() {
    let flock = genomes();
    let said = output(&mut render(flock.path(), &["--on", "gpu", "--json"]));
    let error = &json(&said)["error"];
    assert_eq!((said.status.code(), &error["exit"]), (Some(2), &Value::from(2)), "{error}");
    assert!(error["message"].as_str().unwrap().contains("feature `gpu`"), "{error}");
    assert!(error["hint"].as_str().unwrap().contains("--package dreams --features gpu"), "{error}");
    assert!(!flock.path().join("loops").exists());
}

#[test]
fn a_dry_run_tells_how_good_transitions_are_half_way() {
    let flock = genomes();
    let folder = flock.path();
    let told = || json(&output(&mut render(folder, &["--dry-run", "--json"])))["clips"].as_array().unwrap().clone();
    for clip in &told() {
        let is_loop = clip["clip"].as_str().unwrap().starts_with("loops/");
        assert_eq!(clip.get("middle").is_none(), is_loop, "{clip}");
        assert!(is_loop || (0.0..=1.0).contains(&clip["middle"]["score"].as_f64().unwrap()), "{clip}");
    }
    // A square far away, by transforms that hardly move: half way there, the camera sees nothing.
    let xform =
        |x: f64, y: f64| format!("<xform weight=\"1\" animate=\"0\" coefs=\"0.95 0 0 0.95 {x} {y}\" linear=\"1\"/>");
    let far = [(1.95, 0.05), (1.95, -0.05), (2.05, 0.05), (2.05, -0.05)].map(|(x, y)| xform(x, y)).concat();
    let far = format!(
        "<flame size=\"64 36\" center=\"40 0\" scale=\"15\">{far}<color index=\"0\" rgb=\"255 255 255\"/></flame>"
    );
    fs::write(folder.join("genomes/rosette.flam3"), far).unwrap();
    for clip in &told() {
        let is_far = clip["clip"].as_str().unwrap().starts_with("transitions/") && clip["clip"] != CLIPS[4];
        let is_dead = clip["middle"]["faults"].as_array().is_some_and(|faults| faults.contains(&"dead".into()));
        assert_eq!(is_dead, is_far, "{clip}");
    }
    let lines = output(&mut render(folder, &["--dry-run"]));
    assert!(String::from_utf8_lossy(&lines.stdout).contains(", middle 0.00, dead"), "{lines:?}");
}

#[test]
fn only_what_is_missing_or_changed_is_rendered_and_its_cost_is_told_before() {
    let flock = genomes();
    let folder = flock.path();
    assert_eq!(output(&mut render(folder, &[])).status.code(), Some(0));
    let dry = |options: &[&str]| json(&output(&mut render(folder, &[&["--dry-run", "--json"], options].concat())));
    let states = |told: &Value| -> Vec<String> {
        told["clips"].as_array().unwrap().iter().map(|clip| format!("{} {}", clip["clip"], clip["state"])).collect()
    };
    assert_eq!(dry(&[])["frames"], 0);
    fs::copy(folder.join("genomes/undertow.flam3"), folder.join("genomes/rosette.flam3")).unwrap();
    fs::remove_file(folder.join(CLIPS[4])).unwrap();
    let told = dry(&[]);
    let changed = CLIPS[1..4].iter().map(|clip| format!("\"{clip}\" \"changed\""));
    let wanted: Vec<_> = changed.chain([format!("\"{}\" \"missing\"", CLIPS[4])]).collect();
    assert_eq!(states(&told), wanted);
    assert_eq!((told["frames"].as_u64(), told["kept"].as_u64()), (Some(8 + 5 + 5 + 5), Some(0)));
    // As many as sixteen times 128 orbits draw in whole steps, for each half of a frame's samples.
    assert_eq!(told["samples"].as_f64(), Some((23 * (64 * 36 * 4_u32).next_multiple_of(4096)).into()));
    assert_eq!(states(&dry(&["--missing"])).len(), 1);

    let dreams = output(&mut render(folder, &["--dry-run", "--preset", "dreams", "--spp", "9"]));
    let said = String::from_utf8_lossy(&dreams.stderr).into_owned();
    assert!(said.contains("1280x720 and loops of 768 frames; the flock has 64x36 and 8 to 12"), "{said}");
    let lines = String::from_utf8_lossy(&dreams.stdout).into_owned();
    for part in ["total 35 frames", " samples, ", " CPU hours, "] {
        assert!(lines.contains(part), "{lines}");
    }
    let said = output(&mut render(folder, &[]));
    assert!(String::from_utf8_lossy(&said.stderr).contains("3 clips were rendered from another genome"));
    assert_eq!((said.status.code(), dry(&[])["frames"].as_u64()), (Some(0), Some(0)));
}

#[test]
fn progress_is_a_line_that_is_rewritten_on_a_terminal_and_never_in_the_answer() {
    let flock = genomes();
    // A shell of its own reads the command: paths may have spaces.
    let command = "\"$DREAMS\" render \"$FLOCK\" --temporal-samples 4 --spp 3000 --json > \"$FLOCK/answer\"";
    let mut script = Command::new("script");
    script.args(["--quiet", "--return", "--command", command, "/dev/null"]);
    let said = output(script.env("DREAMS", programs::dreams()).env("FLOCK", flock.path()));
    let seen = String::from_utf8_lossy(&said.stdout).into_owned();
    assert!(seen.contains("/35 frames, ") && seen.contains(" to go"), "{seen}");
    assert!(seen.contains('\r') || seen.contains("\u{1b}["), "rewritten: {seen}");
    let answer: Value = serde_json::from_slice(&fs::read(flock.path().join("answer")).unwrap()).unwrap();
    assert_eq!(answer["frames"], 35);
}

#[test]
fn a_rendering_killed_between_two_clips_goes_on_and_ends_the_same() {
    let (whole, killed) = (genomes(), genomes());
    output(&mut render(whole.path(), &["--threads", "1"]));
    let mut running = render(killed.path(), &["--threads", "2"]).stdout(Stdio::piped()).spawn().unwrap();
    wait::line("the first clip", 600, &mut BufReader::new(running.stdout.as_mut().unwrap()));
    running.kill().unwrap();
    running.wait().unwrap();
    let said = output(&mut render(killed.path(), &[]));
    assert_eq!(said.status.code(), Some(0), "{}", String::from_utf8_lossy(&said.stderr));
    assert_eq!(clips(killed.path()), clips(whole.path()));
    let manifest = |folder: &TempDir| fs::read_to_string(folder.path().join("flock.toml")).unwrap();
    assert_eq!(manifest(&killed), manifest(&whole));
}

#[test]
fn a_signal_ends_a_rendering_at_once_in_the_middle_of_a_frame() {
    let flock = genomes();
    // Each frame would take minutes.
    let mut running = render(flock.path(), &["--spp", "1000000"]);
    let mut running = running.args(["--threads", "2"]).stderr(Stdio::piped()).stdout(Stdio::null()).spawn().unwrap();
    assert!(!ends_within(&running, 2), "it renders");
    kill_process(Pid::from_child(&running), Signal::INT).unwrap();
    assert!(ends_within(&running, 2), "a signal is heard within a frame");
    assert_eq!(running.wait().unwrap().code(), Some(1));
    assert!(CLIPS.iter().all(|clip| !flock.path().join(clip).exists()));
    assert_eq!(fs::read_to_string(flock.path().join("flock.toml")).unwrap(), MANIFEST);
}

#[test]
fn every_way_to_end_has_its_exit_status() {
    let flock = genomes();
    let folder = flock.path();
    let code = |options: &[&str]| output(&mut render(folder, options)).status.code();
    assert_eq!(code(&["ghost"]), Some(2), "a sheep that is not there");
    assert_eq!(code(&["--spp", "0"]), Some(2), "no samples");
    let genome = folder.join("genomes/orchid.flam3");
    let text = fs::read_to_string(&genome).unwrap();
    fs::write(&genome, &text[..text.len() / 2]).unwrap();
    assert_eq!(code(&[]), Some(2), "half a genome");
    fs::remove_file(&genome).unwrap();
    assert_eq!(code(&[]), Some(3), "no genome where the manifest has one");
    fs::write(&genome, text).unwrap();
    // The loop of the other genome is there by now.
    fs::remove_dir_all(folder.join("loops")).unwrap();
    fs::write(folder.join("loops"), "in the way").unwrap();
    assert_eq!(code(&[]), Some(3), "a file where a folder must be");
    fs::remove_file(folder.join("loops")).unwrap();
    let without = MANIFEST.replace("genome = \"genomes/rosette.flam3\"\n", "");
    fs::write(folder.join("flock.toml"), without).unwrap();
    assert_eq!(code(&[]), Some(1), "a sheep without a genome and without a loop");
    assert!(folder.join(CLIPS[0]).exists(), "what can be rendered is");
}
