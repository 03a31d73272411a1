//! Clips of other people come into a flock.
//!
//! Owns the claims on `dreams import`: frame for frame, with tags, without damaged or unknown files. ffmpeg makes the
//! clips and compares the frames.

use crate::tools::import_folders::ImportFolders;
use claims::clips::framemd5;
use claims::flocks::SMALL;
use claims::programs::{self, output, succeed};
use claims::wait::{self, ends_within};
use rustix::process::{Pid, Signal, kill_process};
use serde_json::{Value, json};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// The number of frames of most clips here.
const FRAMES: usize = 30;
/// The least PSNR of a copy in a flock, in dB.
const FAITHFUL_DB: f64 = 38.0;

/// Makes `name` in the inbox: `frames` frames of a moving picture of `size`, `rate` per second.
fn film(folders: &ImportFolders, name: &str, size: &str, rate: &str, frames: usize, settings: &[&str]) -> PathBuf {
    folders.film(name, &format!("testsrc2=size={size}:rate={rate},boxblur=1"), frames, settings)
}

/// The form of Electric Sheep's own clips.
const SHEEP: &[&str] = &["-c:v", "mpeg4", "-q:v", "3", "-bf", "2"];

/// The PSNR of every frame of `copy` compared with `original`, scaled to the copy's size.
fn psnr(original: &Path, copy: &Path) -> Vec<f64> {
    let scratch = tempfile::NamedTempFile::new().unwrap();
    let scaled = "[0:v]setpts=N/TB,scale=in_color_matrix=bt601:out_color_matrix=bt709:out_range=tv,format=yuv420p[a];";
    let beside = format!("{scaled}[1:v]setpts=N/TB[b];[a][b]scale2ref=flags=lanczos[c][d];");
    let graph = format!("{beside}[c][d]psnr=stats_file={}", scratch.path().display());
    let mut ffmpeg = Command::new("ffmpeg");
    ffmpeg.args(["-v", "error", "-nostdin", "-i"]).arg(original).arg("-i").arg(copy);
    succeed(ffmpeg.args(["-lavfi", &graph, "-fps_mode", "passthrough", "-f", "null", "-"]));
    let stats = fs::read_to_string(scratch.path()).unwrap();
    let of_line = |line: &str| {
        let word = line.split_whitespace().find_map(|word| word.strip_prefix("psnr_y:")).unwrap().to_owned();
        if word == "inf" { 99.0 } else { word.parse().unwrap() }
    };
    stats.lines().map(of_line).collect()
}

fn reasons(answer: &Value) -> Vec<(String, String)> {
    let left_out = answer["left_out"].as_array().unwrap().iter();
    left_out
        .map(|one| (one["source"].as_str().unwrap().to_owned(), one["reason"].as_str().unwrap().to_owned()))
        .collect()
}

/// Makes a content folder of Electric Sheep: three sheep, one without a loop, and other files beside them. Returns a
/// loop with tags, and a transition.
fn content(folders: &ImportFolders) -> [PathBuf; 2] {
    let tags = ["-metadata", "title=Aurora", "-metadata", "copyright=CC BY 4.0", "-metadata", "artist=Ram"];
    let loop_of = |number: &str| format!("content/mpeg/00202={number}={number}={number}.avi");
    let first = film(folders, &loop_of("67501"), "320x180", "23", FRAMES, &[SHEEP, &tags].concat());
    film(folders, &loop_of("00033"), "320x180", "23", FRAMES, SHEEP);
    let there = film(folders, "content/mpeg/deep/00202=70000=67501=00033.avi", "320x180", "23", 20, SHEEP);
    film(folders, "content/mpeg/00202=70001=00033=67501.avi", "320x180", "23", 20, SHEEP);
    film(folders, "content/mpeg/00202=70002=00033=00044.avi", "320x180", "23", 20, SHEEP);
    let at = |name: &str| folders.inbox().join("content/mpeg").join(name);
    let whole = fs::read(&first).unwrap();
    fs::write(at("00202=1=1=1.avi"), &whole[..whole.len() / 2]).unwrap();
    fs::write(at("00202=2=2=2.avi"), "").unwrap();
    fs::write(at("00202=3=3=3.avi"), "no video").unwrap();
    fs::write(at("00202=4=4=4.xxx"), "").unwrap();
    fs::write(at("00202=67501=67501=67501 (copy).avi"), &whole).unwrap();
    fs::write(at("00202=5=5=5.avi.tmp"), &whole).unwrap();
    fs::write(at("202=67501=67501=67501.avi"), &whole).unwrap();
    fs::write(at("list.xml"), "<list/>").unwrap();
    [first, there]
}

/// The tags of origin of a clip, as ffmpeg reads them.
fn tags(clip: &Path) -> Value {
    let mut probe = Command::new("ffprobe");
    probe.args(["-v", "error", "-show_entries", "format_tags", "-of", "json"]);
    let told: Value = serde_json::from_slice(&succeed(probe.arg(clip))).unwrap();
    told["format"]["tags"].clone()
}

#[test]
fn a_content_folder_becomes_a_flock_and_what_is_odd_is_named() {
    let folders = ImportFolders::new("320x180");
    let [first, there] = content(&folders);
    let dry = folders.answer(1, &["content", "--dry-run"]);
    assert_eq!((dry["clips"].as_array().unwrap().len(), dry["clips"][0]["state"].as_str()), (5, Some("encode")));
    assert!(!folders.manifest().contains("[[sheep]]"), "a dry run writes nothing");
    let answer = folders.answer(1, &["content"]);
    let names: Vec<_> = answer["clips"].as_array().unwrap().iter().map(|clip| clip["clip"].as_str().unwrap()).collect();
    assert_eq!(
        names,
        [
            "loops/202.33.mp4",
            "loops/202.67501.mp4",
            "transitions/202.33=202.67501.mp4",
            "transitions/202.33=202.44.mp4",
            "transitions/202.67501=202.33.mp4",
        ]
    );
    assert_eq!((&answer["added"], &answer["tombstones"]), (&json!(["202.44"]), &json!(1)));
    let reasons = reasons(&answer);
    for (name, why) in [
        ("00202=1=1=1.avi", "is cut short"),
        ("00202=2=2=2.avi", "is empty"),
        ("00202=3=3=3.avi", "is not a readable video"),
        ("(copy).avi", "(expected four numbers: GENERATION=ID=FIRST=LAST)"),
        ("5.avi.tmp", "it was not fetched to its end"),
        ("202=67501=67501=67501.avi", "as does `content/mpeg/00202=67501=67501=67501.avi`"),
    ] {
        assert!(
            reasons.iter().any(|(source, reason)| source.ends_with(name) && reason.contains(why)),
            "{name}: {reasons:?}"
        );
    }
    assert_eq!(reasons.len(), 6, "{reasons:?}");
    assert_eq!(folders.clip_faults(), [] as [Value; 0]);
    for (original, copy) in [(&first, "loops/202.67501.mp4"), (&there, "transitions/202.67501=202.33.mp4")] {
        let copy = folders.flock().join(copy);
        let psnr = psnr(original, &copy);
        assert_eq!(psnr.len(), framemd5(original).len());
        assert_eq!(psnr.len(), framemd5(&copy).len());
        assert!(psnr.iter().all(|db| *db > FAITHFUL_DB), "{}: {psnr:?}", copy.display());
    }
    let told = tags(&folders.flock().join("loops/202.67501.mp4"));
    assert_eq!((&told["title"], &told["artist"]), (&json!("Aurora"), &json!("Ram")));
    assert_eq!(told["copyright"], "CC BY 4.0", "the licence stays with the clip");

    let before = folders.manifest();
    let again = folders.answer(1, &["content"]);
    let states: Vec<_> = again["clips"].as_array().unwrap().iter().map(|clip| &clip["state"]).collect();
    assert_eq!((states, folders.manifest()), (vec![&json!("stood"); 5], before), "what is there is passed over");
}

#[test]
fn as_many_frames_come_out_as_went_in_whatever_the_codec_size_and_rate() {
    let folders = ImportFolders::new("320x180");
    let films: [(&str, &str, &str, &[&str]); 7] = [
        ("film.mp4", "640x360", "24000/1001", &["-c:v", "libx264", "-bf", "3"]),
        ("odd.avi", "641x361", "25", SHEEP),
        ("b-frames.mkv", "320x180", "60", &["-c:v", "mpeg4", "-bf", "4", "-q:v", "3"]),
        ("old.mpg", "320x180", "25", &["-c:v", "mpeg1video", "-q:v", "3"]),
        ("lossless.mkv", "320x180", "30", &["-c:v", "ffv1", "-pix_fmt", "yuv444p"]),
        ("stills.avi", "320x180", "10", &["-c:v", "mjpeg", "-q:v", "2"]),
        (
            "uneven.mkv",
            "320x180",
            "30",
            &["-vf", "setpts=(N+0.3*mod(N\\,3))/30/TB", "-fps_mode", "vfr", "-c:v", "libx264"],
        ),
    ];
    for (name, size, rate, settings) in films {
        let film = film(&folders, name, size, rate, FRAMES, settings);
        let id = name.split_once('.').unwrap().0;
        let answer = folders.answer(0, &[name, "--from", id, "--to", id]);
        let clip = &answer["clips"][0];
        assert_eq!((clip["state"].as_str(), clip["frames"].as_u64()), (Some("encoded"), Some(FRAMES as u64)), "{name}");
        let copy = folders.flock().join(clip["clip"].as_str().unwrap());
        assert_eq!(framemd5(&copy).len(), FRAMES, "{name}");
        let psnr = psnr(&film, &copy);
        assert!(psnr.len() == FRAMES && psnr.iter().all(|db| *db > FAITHFUL_DB - 4.0), "{name}: {psnr:?}");
    }
    assert_eq!(folders.clip_faults(), [] as [Value; 0]);
}

#[test]
fn a_clip_in_the_form_is_copied_byte_for_byte() {
    let folders = ImportFolders::new("320x240");
    let from = SMALL.flock().folder;
    fs::copy(from.join("s0=s1.mp4"), folders.inbox().join("s0=s1.mp4")).unwrap();
    let answer = folders.answer(0, &["s0=s1.mp4"]);
    assert_eq!(answer["clips"][0]["state"], "copied");
    assert_eq!(answer["added"], json!(["s0", "s1"]));
    let bytes = |path: PathBuf| fs::read(path).unwrap();
    assert_eq!(bytes(folders.flock().join("transitions/s0=s1.mp4")), bytes(from.join("s0=s1.mp4")));
    // A sheep that was only passed through gets its loop, and one that waits to be rendered has no need to be.
    fs::copy(from.join("s0.mp4"), folders.inbox().join("any name.mp4")).unwrap();
    let refused = folders.answer(1, &["any name.mp4"]);
    assert!(reasons(&refused)[0].1.contains("--from and --to"), "{refused}");
    folders.answer(0, &["any name.mp4", "--from", "s0", "--to", "s0"]);
    let manifest = folders.manifest();
    assert_eq!(manifest.matches("[[sheep]]").count(), 2, "{manifest}");
    assert!(manifest.contains("id = \"s0\"\nframes = 6\nclip = \"loops/s0.mp4\"\nhash = \"b3:"), "{manifest}");
}

#[test]
fn pace_and_shape_change_only_when_told() {
    let folders = ImportFolders::new("320x180");
    film(&folders, "slow=fast.mkv", "320x180", "15", FRAMES, &["-c:v", "ffv1"]);
    let twice = folders.answer(0, &["slow=fast.mkv", "--fps", "15"]);
    assert_eq!(twice["clips"][0]["frames"], FRAMES * 2);
    let slow = framemd5(&folders.flock().join("transitions/slow=fast.mp4"));
    assert_eq!(slow.len(), FRAMES * 2);
    film(&folders, "fast=slow.mkv", "320x180", "60", FRAMES, &["-c:v", "ffv1"]);
    assert_eq!(folders.answer(0, &["fast=slow.mkv", "--fps", "60"])["clips"][0]["frames"], FRAMES / 2);

    film(&folders, "a=b.avi", "320x240", "30", FRAMES, SHEEP);
    let refused = reasons(&folders.answer(1, &["a=b.avi"]));
    assert!(refused[0].1.contains("320x240") && refused[0].1.contains("320x180"), "{refused:?}");
    assert!(!folders.flock().join("transitions/a=b.mp4").exists());
    folders.answer(0, &["a=b.avi", "--fit", "crop"]);
    film(&folders, "b=a.avi", "320x240", "30", FRAMES, SHEEP);
    folders.answer(0, &["b=a.avi", "--fit", "pad"]);
    let shape = |clip: &str, filter: &str, original: &str, cut: &str| {
        let colours = "scale=in_color_matrix=bt601:out_color_matrix=bt709:out_range=tv,format=yuv420p";
        let graph = format!("[0:v]setpts=N/TB,{cut},{colours}[a];[1:v]setpts=N/TB,{filter}[b];[a][b]psnr=stats_file=-");
        let mut ffmpeg = Command::new("ffmpeg");
        ffmpeg
            .args(["-v", "error", "-i"])
            .arg(folders.inbox().join(original))
            .arg("-i")
            .arg(folders.flock().join(clip));
        let stats = String::from_utf8(succeed(ffmpeg.args(["-lavfi", &graph, "-f", "null", "-"]))).unwrap();
        let worst = |line: &str| line.split("psnr_y:").nth(1)?.split(' ').next()?.parse::<f64>().ok();
        stats.lines().filter_map(worst).fold(99.0, f64::min)
    };
    let cropped = shape("transitions/a=b.mp4", "null", "a=b.avi", "crop=320:180");
    let padded = shape("transitions/b=a.mp4", "crop=240:180:40:0", "b=a.avi", "scale=240:180:flags=lanczos");
    assert!(cropped > 30.0 && padded > 30.0, "{cropped:.1} dB and {padded:.1} dB");
    assert_eq!(folders.clip_faults(), [] as [Value; 0]);
}

#[test]
fn every_flame_of_a_file_becomes_a_sheep_with_its_own_text() {
    let folders = ImportFolders::new("320x180");
    let genome = |name: &str| {
        let path = programs::repository().join("flock-tools/demo/genomes").join(name).with_extension("flam3");
        let text = fs::read_to_string(path).unwrap();
        text[text.find("<flame").unwrap()..].trim_end().to_owned()
    };
    let licensed = genome("orchid").replacen("<flame ", "<flame licence=\"CC BY 4.0\" ", 1);
    let named = genome("caldera").replacen("name=\"caldera\"", "name=\"electricsheep.247.00505\"", 1);
    let (licensed, named) = (licensed.trim_end_matches("</flames>").trim(), named.trim_end_matches("</flames>").trim());
    fs::write(folders.inbox().join("best.flam3"), format!("<flames>\n{licensed}\n{named}\n</flames>\n")).unwrap();
    fs::write(folders.inbox().join("half.flam3"), &licensed[..licensed.len() / 2]).unwrap();
    film(&folders, "00247=505=505=505.avi", "320x180", "23", FRAMES, SHEEP);
    let answer = folders.answer(1, &[".", "--frames", "90"]);
    let flames: Vec<_> = answer["genomes"].as_array().unwrap().iter().map(|g| (&g["sheep"], &g["state"])).collect();
    assert_eq!(flames, [(&json!("orchid"), &json!("added")), (&json!("247.505"), &json!("given"))], "{answer}");
    let reasons = reasons(&answer);
    assert!(reasons.len() == 1 && reasons[0].0.ends_with("half.flam3"), "{reasons:?}");
    let kept = fs::read_to_string(folders.flock().join("genomes/orchid.flam3")).unwrap();
    assert_eq!(kept.trim(), licensed, "byte for byte, with its licence");
    let manifest = folders.manifest();
    assert!(
        manifest.contains("frames = 90\nclip = \"loops/orchid.mp4\"\ngenome = \"genomes/orchid.flam3\""),
        "{manifest}"
    );
    assert!(manifest.contains("genome = \"genomes/247.505.flam3\""), "{manifest}");
    let again = folders.answer(1, &[".", "--frames", "90"]);
    assert!(again["genomes"].as_array().unwrap().iter().all(|genome| genome["state"] == "stood"), "{again}");
    assert_eq!(folders.manifest(), manifest);
}

#[test]
fn an_import_that_is_interrupted_or_finds_the_disk_full_leaves_a_whole_flock_and_goes_on() {
    let folders = ImportFolders::new("320x180");
    for name in ["a=b.avi", "b=c.avi", "c=a.avi"] {
        film(&folders, name, "320x180", "23", 300, SHEEP);
    }
    let parts = || {
        let inside = fs::read_dir(folders.flock().join("transitions")).unwrap().map(|file| file.unwrap().path());
        inside.filter(|path| path.extension().is_none_or(|ending| ending != "mp4")).count()
    };
    let mut running = folders.import(&["."]).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    let part = folders.flock().join("transitions/a=b.mp4.new.part");
    wait::until("the first part of a clip", 60, || part.exists());
    kill_process(Pid::from_child(&running), Signal::INT).unwrap();
    assert!(ends_within(&running, 20), "a signal is heard within a frame");
    assert_eq!((running.wait().unwrap().code(), parts()), (Some(1), 0));
    assert_eq!(folders.clip_faults(), [] as [Value; 0]);

    // No file may grow beyond some blocks: to a program that is the same as a full disk.
    let before = folders.manifest();
    let mut shell = Command::new("bash");
    shell.args(["-c", "trap '' XFSZ; ulimit -f 20; exec \"$@\"", "bash"]).arg(programs::dreams()).arg("import");
    let full = output(shell.arg(folders.flock()).arg(folders.inbox()));
    let error = String::from_utf8_lossy(&full.stderr);
    assert_eq!((full.status.code(), parts()), (Some(3), 0), "{error}");
    assert!(error.contains("error: cannot encode `"), "{error}");
    assert!(folders.manifest() == before && folders.clip_faults().is_empty());

    // What a power cut between the clip and the manifest leaves: the very file, which nothing names.
    let other = ImportFolders::new("320x180");
    fs::copy(folders.inbox().join("a=b.avi"), other.inbox().join("a=b.avi")).unwrap();
    other.answer(0, &["a=b.avi"]);
    let place = folders.flock().join("transitions/a=b.mp4");
    if !place.exists() {
        fs::copy(other.flock().join("transitions/a=b.mp4"), &place).unwrap();
    }
    fs::write(folders.flock().join("transitions/b=c.mp4"), "another film").unwrap();
    let answer = folders.answer(1, &["."]);
    let left_out = reasons(&answer);
    assert!(left_out.len() == 1 && left_out[0].1.contains("--force replaces it"), "{left_out:?}");
    assert_eq!(fs::read_to_string(folders.flock().join("transitions/b=c.mp4")).unwrap(), "another film");
    folders.answer(0, &[".", "--force"]);
    assert_eq!((folders.manifest().matches("[[transition]]").count(), folders.clip_faults().len(), parts()), (3, 0, 0));
}

#[test]
fn every_way_to_end_an_import_has_its_exit_status() {
    let folders = ImportFolders::new("320x180");
    let code = |words: &[&str]| output(&mut folders.import(words)).status.code();
    assert_eq!(code(&[]), Some(2), "nothing to import");
    assert_eq!(code(&["none.avi"]), Some(3), "a file that is not there");
    assert_eq!(code(&[".", "--from", "a"]), Some(2), "a start without an end");
    assert_eq!(code(&[".", "--fps", "0"]), Some(2), "no rate");
    assert_eq!(code(&["."]), Some(0), "an empty folder has nothing to leave out");
    fs::write(folders.inbox().join("notes.txt"), "x").unwrap();
    assert_eq!((code(&["."]), code(&["notes.txt"])), (Some(0), Some(1)), "a named file is not passed over in silence");
}
