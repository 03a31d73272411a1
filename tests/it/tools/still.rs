//! `dreams still`: a picture and its figures, for scripts.
//!
//! Owns the claims on whole runs of the program.

use claims::programs::{self, json, output};
use serde_json::Value;
use std::fs;
use std::path::Path;
use std::process::{Command, Output};

/// `dreams still orchid --out OUT OPTIONS...` in `folder`, small and at low quality.
fn still(folder: &Path, out: &str, options: &[&str]) -> Output {
    let genome = programs::repository().join("flock-tools/demo/genomes/orchid.flam3");
    let mut coarse = vec!["--size", "64x36", "--supersample", "2", "--json"];
    if !options.contains(&"--spp") && !options.contains(&"--psnr") {
        coarse.extend(["--spp", "20"]);
    }
    output(
        Command::new(programs::dreams())
            .current_dir(folder)
            .arg("still")
            .arg(genome)
            .args(["--out", out])
            .args(coarse)
            .args(options),
    )
}

/// The answer to a still that must succeed.
fn answer(said: &Output) -> Value {
    assert_eq!(said.status.code(), Some(0), "{}", String::from_utf8_lossy(&said.stderr));
    json(said)
}

#[test]
fn a_still_is_a_picture_with_its_figures_and_the_same_for_any_number_of_threads() {
    let folder = tempfile::tempdir().unwrap();
    let one = answer(&still(folder.path(), "one.png", &["--threads", "1"]));
    let three = answer(&still(folder.path(), "three.png", &["--threads", "3"]));
    // As many as sixteen times 128 orbits draw in whole steps, for each half of the samples.
    assert_eq!(one["samples"].as_u64(), Some((64 * 36 * 20_u64).next_multiple_of(4096)));
    assert!(one["cpu_s"].as_f64().unwrap() > 0.0 && one["seconds"].as_f64().unwrap() > 0.0);
    assert_eq!(one["checksum"], three["checksum"]);
    let bytes = |name: &str| fs::read(folder.path().join(name)).unwrap();
    assert_eq!(bytes("one.png"), bytes("three.png"));
    assert!(bytes("one.png").starts_with(b"\x89PNG"));
    let deep = answer(&still(folder.path(), "deep.png", &["--bits", "16"]));
    assert_eq!(deep["checksum"], one["checksum"], "the checksum is the picture's, not the file's");
    assert!(bytes("deep.png").len() > bytes("one.png").len());
}

#[test]
fn a_genome_that_takes_more_memory_than_there_is_is_refused_by_name() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["orchid.flam3", "malachite.expr", "gilt.agents", "almond.plant"] {
        let genome = programs::repository().join("flock-tools/demo/genomes").join(name);
        let mut still = Command::new("sh");
        still.current_dir(folder.path()).args(["-c", "ulimit -v 700000; exec \"$0\" still \"$@\""]);
        let said = output(still.arg(programs::dreams()).arg(&genome).args(["--size", "8192x8192", "--out", "a.png"]));
        let words = String::from_utf8_lossy(&said.stderr);
        assert_eq!(said.status.code(), Some(3), "{words}");
        let named = format!("error: cannot render genome `{}`: a frame takes ", genome.display());
        assert!(words.starts_with(&named) && words.contains(" MB are free"), "{words}");
        assert!(!folder.path().join("a.png").exists());
    }
}

#[test]
fn seed_filter_size_and_frame_each_make_another_picture() {
    let folder = tempfile::tempdir().unwrap();
    let checksum = |options: &[&str]| answer(&still(folder.path(), "a.png", options))["checksum"].to_string();
    let mut seen = vec![checksum(&[])];
    assert_eq!(seen[0], checksum(&["--filter", "variance"]), "the variance filter is what is meant without a word");
    for options in [
        &["--seed", "2"][..],
        &["--filter", "none"],
        &["--filter", "flam3"],
        &["--frame", "0", "--frames", "30"],
        &["--frame", "0", "--frames", "30", "--temporal-samples", "2"],
        &["--frame", "3", "--frames", "30"],
    ] {
        let next = checksum(options);
        assert!(!seen.contains(&next), "{options:?}");
        seen.push(next);
    }
    assert_eq!(checksum(&["--frame", "0", "--frames", "30", "--temporal-samples", "1"]), seen[0]);
}

#[test]
fn a_still_takes_as_many_samples_as_its_noise_needs() {
    let folder = tempfile::tempdir().unwrap();
    let aimed = |psnr, threads| {
        answer(&still(folder.path(), "a.png", &["--psnr", psnr, "--threads", threads, "--filter", "none"]))
    };
    let (few, many) = (aimed("34", "1"), aimed("40", "2"));
    for (told, target) in [(&few, 34.0), (&many, 40.0)] {
        assert!((target..target + 3.0).contains(&told["psnr"].as_f64().unwrap()), "{told}");
    }
    assert!(many["samples"].as_u64() > few["samples"].as_u64(), "{many}, {few}");
    assert_eq!(aimed("40", "7")["checksum"], many["checksum"]);
}

#[test]
fn a_still_that_cannot_be_is_refused_with_its_reason() {
    let folder = tempfile::tempdir().unwrap();
    for (options, code) in [
        (&["--frame", "3"][..], 2),
        (&["--filter", "soft"], 2),
        (&["--frame", "3", "--frames", "0"], 2),
        (&["--spp", "0"], 2),
        (&["--psnr", "0"], 2),
        (&["--psnr", "-1"], 2),
        (&["--psnr", "200"], 2),
        (&["--psnr", "NaN"], 2),
        (&["--psnr", "40", "--spp", "9"], 2),
        (&["--psnr", "40", "--filter", "flam3"], 2),
    ] {
        let said = still(folder.path(), "a.png", options);
        assert_eq!(said.status.code(), Some(code), "{options:?}");
    }
    assert_eq!(still(folder.path(), "no/such/a.png", &[]).status.code(), Some(3));
    let run = |genome: &Path, size: &str| {
        let mut flock = Command::new(programs::dreams());
        output(flock.arg("still").arg(genome).arg("--out").arg(folder.path().join("b.png")).args(["--size", size]))
    };
    let text = folder.path().join("text");
    fs::write(&text, "no genome").unwrap();
    assert_eq!(run(&text, "16x16").status.code(), Some(2));
    assert_eq!(run(&folder.path().join("nothing"), "16x16").status.code(), Some(3));
    let orchid = programs::repository().join("flock-tools/demo/genomes/orchid.flam3");
    let huge = run(&orchid, "32768x32768");
    let error = String::from_utf8_lossy(&huge.stderr);
    assert_eq!(huge.status.code(), Some(2), "{error}");
    assert!(error.contains("expected at most 1e9 histogram cells"), "{error}");
    let limited =
        format!("ulimit -v 1000000; exec \"$0\" still \"$1\" --out {}/c.png --size 6000x6000", folder.path().display());
    let short = output(Command::new("sh").args(["-c", &limited]).arg(programs::dreams()).arg(&orchid));
    let error = String::from_utf8_lossy(&short.stderr);
    assert_eq!(short.status.code(), Some(3), "{error}");
    assert!(error.contains("MB of memory") && error.contains("hint: "), "{error}");
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1, "nothing was written");
}

#[test]
fn a_still_shows_a_moment_between_the_key_frames_of_a_file() {
    let folder = tempfile::tempdir().unwrap();
    let genome = |name: &str, time: u32| {
        let path = programs::repository().join("flock-tools/demo/genomes").join(name).with_extension("flam3");
        fs::read_to_string(path).unwrap().replace("time=\"0\"", &format!("time=\"{time}\""))
    };
    let keys = |times: [u32; 2]| format!("<keys>{}{}</keys>", genome("orchid", times[0]), genome("caldera", times[1]));
    fs::write(folder.path().join("keys.flam3"), keys([10, 20])).unwrap();
    fs::write(folder.path().join("back.flam3"), keys([20, 10])).unwrap();
    let still = |file: &str, options: &[&str]| {
        let small = ["--out", "a.png", "--size", "64x36", "--spp", "20", "--supersample", "1", "--json"];
        let mut command = Command::new(programs::dreams());
        output(command.current_dir(folder.path()).args(["still", file]).args(small).args(options))
    };
    let checksum =
        |time: &str| answer(&still("keys.flam3", &["--time", time, "--temporal-samples", "1"]))["checksum"].clone();
    let seen = ["10", "13.5", "15", "20"].map(checksum);
    assert!((1..seen.len()).all(|i| !seen[..i].contains(&seen[i])), "{seen:?}");
    assert_eq!([checksum("-3"), checksum("99")], [seen[0].clone(), seen[3].clone()], "outside it stands still");
    for (file, options, why) in [
        ("keys.flam3", &[][..], "found 2 flames, expected one"),
        ("back.flam3", &["--time", "12"], "flame 2 of the file has time 10, expected more than the 20"),
        ("keys.flam3", &["--time", "12", "--frame", "1", "--frames", "3"], "cannot be used with"),
    ] {
        let said = still(file, options);
        let told = String::from_utf8_lossy(&said.stderr).into_owned();
        assert!(said.status.code() == Some(2) && told.contains(why), "{told}");
    }
}

#[test]
fn an_expression_has_a_still_and_options_of_flames_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let text =
        "(expression 1 (picture (hsv-to-rgb (vector (warped-bw-noise x (wave 1 .25) .4 7) .8 (abs (sin (* 3 y)))))))";
    fs::write(folder.path().join("tide.expr"), text).unwrap();
    fs::write(folder.path().join("tide.txt"), text).unwrap();
    fs::write(folder.path().join("torn.expr"), &text[..40]).unwrap();
    let run = |genome: &str, options: &[&str]| {
        let mut still = Command::new(programs::dreams());
        still.current_dir(folder.path()).args(["still", genome, "--out", "a.png", "--size", "64x36", "--json"]);
        output(still.args(options))
    };
    let one = answer(&run("tide.expr", &["--spp", "16", "--threads", "1"]));
    assert!(one["samples"].as_u64().unwrap() >= 64 * 36 * 16);
    let three = answer(&run("tide.txt", &["--spp", "16", "--threads", "3"]));
    assert_eq!(one["checksum"], three["checksum"], "by how it begins, and with any number of threads");
    let first = answer(&run("tide.expr", &["--frame", "0", "--frames", "24"]));
    let next = answer(&run("tide.expr", &["--frame", "24", "--frames", "24"]));
    let other = answer(&run("tide.expr", &["--frame", "6", "--frames", "24"]));
    assert_eq!(first["checksum"], next["checksum"], "the loop is exact");
    assert_ne!(first["checksum"], other["checksum"]);
    let says = |genome: &str, options: &[&str], wanted: &[&str]| {
        let said = run(genome, options);
        let error = String::from_utf8_lossy(&said.stderr);
        assert_eq!(said.status.code(), Some(2), "{error}");
        assert!(wanted.iter().all(|wanted| error.contains(wanted)), "{error}");
    };
    says("tide.expr", &["--supersample", "2"], &["`--supersample` is for flames"]);
    says("tide.expr", &["--filter", "flam3"], &["`--filter` is for flames"]);
    assert_eq!(answer(&run("tide.expr", &["--spp", "1"]))["samples"], 64 * 36, "a sketch");
    let adaptive = answer(&run("tide.expr", &[]))["samples"].as_u64().unwrap();
    assert!((64 * 36 * 16..=64 * 36 * 64).contains(&adaptive), "{adaptive}");
    says("torn.expr", &[], &["cannot render genome `torn.expr`", "line 1"]);
}
