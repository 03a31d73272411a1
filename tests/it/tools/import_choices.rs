//! What the artist chooses about clips that come in: colours, pace, what is replaced; and what an import costs.
//!
//! Owns the claims on `--matrix`, `--fps`, `--force`, `--threads` and `--dry-run` of `dreams import`, on clips that their
//! files turn, on the plan that it prints before it encodes the first clip, and on what a power cut or a kill leaves.
//! ffmpeg makes the clips and measures the colours.

use crate::syscall_faults::{at_every_step, traced};
use crate::tools::import_folders::ImportFolders;
use claims::clips::framemd5;
use claims::programs::{self, output, succeed};
use serde_json::{Value, json};
use std::fs;
use std::path::Path;
use std::process::{Command, Output};

/// A green, as red, green and blue of 255.
const GREEN: [u8; 3] = [32, 192, 64];

/// Makes `name` in the inbox, of the pictures of the filter `source`.
fn film(folders: &ImportFolders, name: &str, source: &str, frames: usize, settings: &str) {
    folders.film(name, source, frames, &settings.split_whitespace().collect::<Vec<_>>());
}

/// The colour in the middle of the first frame of a clip of a flock, as a display shows it.
fn colour(clip: &Path) -> [u8; 3] {
    let filter = "scale=in_color_matrix=bt709:in_range=tv:flags=accurate_rnd+full_chroma_int,format=rgb24,crop=2:2";
    let mut ffmpeg = Command::new("ffmpeg");
    ffmpeg.args(["-v", "error", "-nostdin", "-i"]).arg(clip).args(["-vf", filter, "-frames:v", "1"]);
    succeed(ffmpeg.args(["-f", "rawvideo", "-"]))[..3].try_into().unwrap()
}

fn is_green(colour: [u8; 3]) -> bool {
    colour.iter().zip(GREEN).all(|(found, due)| found.abs_diff(due) <= 2)
}

#[test]
fn a_known_green_comes_in_as_that_green_whoever_made_the_clip_and_whatever_its_size() {
    // Some versions of ffmpeg write the tag of the pictures into the file, others that of `-colorspace`.
    let tagged = |size: &str, matrix: &str, tag: &str| {
        let [r, g, b] = GREEN;
        let turn = format!(
            "format=rgb24,scale=out_color_matrix={matrix}:out_range=tv:flags=accurate_rnd,format=yuv420p,\
             setparams=colorspace={tag}"
        );
        format!("color=c=0x{r:02X}{g:02X}{b:02X}:size={size}:rate=30,{turn}")
    };
    let green = |size: &str, matrix: &str| tagged(size, matrix, "unknown");
    let x264 = |tag: &str| format!("-c:v libx264 -crf 5 -colorspace {tag}");
    // One that is not scaled, and one that is.
    for size in ["800x592", "400x296"] {
        let folders = ImportFolders::new("800x592");
        let untagged = "-c:v mpeg4 -q:v 2";
        film(&folders, "00244=1=1=1.avi", &green(size, "bt601"), 2, untagged);
        film(&folders, "00244=2=2=2.mp4", &green(size, "bt601"), 2, "-c:v libx264 -crf 5");
        film(&folders, "10244=3=3=3.mp4", &tagged(size, "bt709", "bt709"), 2, &x264("bt709"));
        film(&folders, "a=a.mp4", &tagged(size, "bt601", "smpte170m"), 2, &x264("smpte170m"));
        film(&folders, "b=b.avi", &green(size, if size == "800x592" { "bt709" } else { "bt601" }), 2, untagged);
        film(&folders, "c=c.mkv", &green(size, "bt601"), 2, "-c:v ffv1 -pix_fmt yuv444p10le");
        let (answer, told) = folders.answer_and_notes(0, &[".", "--dry-run"]);
        let by: Vec<_> = answer["clips"].as_array().unwrap().iter().map(|c| (&c["matrix"], &c["matrix_by"])).collect();
        let of_size = if size == "800x592" { "bt709" } else { "bt601" };
        let due = [("bt601", "origin"), ("bt601", "origin"), ("bt709", "file"), ("bt601", "file"), (of_size, "size")];
        assert_eq!(
            by[..5],
            due.map(|(matrix, by)| (json!(matrix), json!(by))).each_ref().map(|(a, b)| (a, b)),
            "{answer}"
        );
        assert!(told.contains("2 clips without a tag are read by BT.601, as Electric Sheep made them"), "{told}");
        fs::remove_file(folders.inbox().join("c=c.mkv")).unwrap();
        let (answer, _) = folders.answer_and_notes(0, &["."]);
        for clip in answer["clips"].as_array().unwrap() {
            let found = colour(&folders.flock().join(clip["clip"].as_str().unwrap()));
            assert!(is_green(found), "{size}: {clip} is {found:?}");
        }
    }
    let folders = ImportFolders::new("800x592");
    film(&folders, "00244=1=1=1.avi", &green("800x592", "bt709"), 2, "-c:v mpeg4 -q:v 2");
    film(&folders, "c=c.mkv", &green("800x592", "bt601"), 2, "-c:v ffv1 -pix_fmt yuv444p10le");
    let clip = folders.flock().join("loops/244.1.mp4");
    folders.answer(0, &["00244=1=1=1.avi"]);
    assert!(!is_green(colour(&clip)), "the origin was wrong");
    let (answer, told) = folders.answer_and_notes(0, &["00244=1=1=1.avi", "--matrix", "bt709", "--force"]);
    assert_eq!((&answer["clips"][0]["matrix_by"], &answer["clips"][0]["replaces"]), (&json!("option"), &json!(true)));
    assert!(told.contains("read by BT.709, as --matrix tells"), "{told}");
    assert!(is_green(colour(&clip)), "the artist knows better: {:?}", colour(&clip));
    folders.answer(0, &["c=c.mkv", "--matrix", "bt601"]);
    assert!(
        is_green(colour(&folders.flock().join("loops/c.mp4"))),
        "{:?}",
        colour(&folders.flock().join("loops/c.mp4"))
    );
}

/// The first frame of a clip as ffmpeg shows it, `[height][width][3]` of 8 bits.
fn first_frame(clip: &Path) -> Vec<u8> {
    let mut ffmpeg = Command::new("ffmpeg");
    ffmpeg.args(["-v", "error", "-nostdin", "-i"]).arg(clip).args(["-vf", "scale=64:64,format=rgb24"]);
    succeed(ffmpeg.args(["-frames:v", "1", "-f", "rawvideo", "-"]))
}

#[test]
fn a_clip_that_its_file_turns_comes_in_turned_even_in_form() {
    let folders = ImportFolders::new("64x64");
    let form = "-c:v libx264 -crf 4 -pix_fmt yuv420p -color_primaries bt709 -color_trc bt709 -colorspace bt709 \
                -color_range tv -x264-params repeat-headers=1 -movflags +faststart";
    let bt709 = "setparams=range=tv:color_primaries=bt709:color_trc=bt709:colorspace=bt709";
    let source = format!("testsrc2=size=64x64:rate=30,boxblur=4,{bt709}");
    film(&folders, "a=a.mp4", &source, 3, form);
    film(&folders, "b=b.mp4", &source, 3, form);
    let path = folders.inbox().join("b=b.mp4");
    let mut bytes = fs::read(&path).unwrap();
    // The display matrix of a track, `0 1 0, -1 0 0`: turned by 90 degrees.
    let start = bytes.windows(4).position(|name| name == b"tkhd").unwrap() + 44;
    for (at, number) in [0_i32, 1, 0, -1, 0].into_iter().enumerate() {
        bytes[start + 4 * at..][..4].copy_from_slice(&(number << 16).to_be_bytes());
    }
    fs::write(&path, bytes).unwrap();
    let (answer, _) = folders.answer_and_notes(0, &["."]);
    let states: Vec<_> = answer["clips"].as_array().unwrap().iter().map(|clip| &clip["state"]).collect();
    assert_eq!(states, ["copied", "encoded"], "{answer}");
    let [upright, due] = ["a=a.mp4", "b=b.mp4"].map(|name| first_frame(&folders.inbox().join(name)));
    let found = first_frame(&folders.flock().join("loops/b.mp4"));
    let mean = |other: &[u8]| {
        let off = found.iter().zip(other).map(|(a, b)| f64::from(a.abs_diff(*b)));
        off.sum::<f64>() / found.len() as f64
    };
    assert!(mean(&due) < 8.0 && mean(&upright) > 20.0, "{} from turned, {} from upright", mean(&due), mean(&upright));
}

#[test]
fn clips_of_many_rates_keep_their_pace_as_told_and_the_plan_says_what_becomes_of_each() {
    let folders = ImportFolders::new("64x64");
    for (name, rate) in [("a=b.avi", "15"), ("b=c.avi", "30"), ("c=d.avi", "60"), ("d=a.mkv", "23")] {
        film(&folders, name, &format!("testsrc2=size=64x64:rate={rate}"), 12, "-c:v ffv1");
    }
    let (frame_for_frame, told) = folders.answer_and_notes(0, &[".", "--dry-run"]);
    let of = |answer: &Value, key: &str| -> Vec<Value> {
        answer["clips"].as_array().unwrap().iter().map(|clip| clip[key].clone()).collect()
    };
    assert_eq!(of(&frame_for_frame, "frames"), [12, 12, 12, 12]);
    assert!(
        told.contains("1 clip of 15 frames per second: frame for frame, faster at the flock's 30: 2.000"),
        "{told}"
    );
    assert!(
        told.contains("1 clip of 60 frames per second: frame for frame, slower at the flock's 30: 0.500"),
        "{told}"
    );
    assert!(told.contains("1 clip of 30 frames per second: frame for frame, at their pace"), "{told}");
    assert_eq!(told.matches("--fps as-told keeps their pace").count(), 3, "{told}");

    let (as_told, told) = folders.answer_and_notes(0, &[".", "--fps", "as-told"]);
    assert_eq!(of(&as_told, "frames"), [24, 12, 6, 16]);
    assert!(of(&as_told, "speed").iter().all(|speed| *speed == 1.0), "{as_told}");
    assert!(
        told.contains("1 clip of 15 frames per second: resampled to the flock's 30, 2.000 frames for each"),
        "{told}"
    );
    let rates: Vec<_> = as_told["plan"]["rates"].as_array().unwrap().iter().map(|r| &r["frames_for_each"]).collect();
    assert_eq!(rates.len(), 4, "{as_told}");
    assert_eq!(framemd5(&folders.flock().join("transitions/c=d.mp4")).len(), 6);
}

#[test]
fn a_dry_run_tells_sheep_hours_and_gigabytes_and_writes_nothing() {
    let folders = ImportFolders::new("320x180");
    for (name, frames) in [("00247=1=1=1.avi", 60), ("00247=2=2=2.avi", 60), ("00247=3=1=2.avi", 120)] {
        film(&folders, name, "testsrc2=size=320x180:rate=30", frames, "-c:v mpeg4 -q:v 3");
    }
    let before = folders.manifest();
    let (answer, _) = folders.answer_and_notes(0, &[".", "--dry-run"]);
    let plan = &answer["plan"];
    assert_eq!(
        (&plan["clips"], &plan["sheep"], &plan["encode"], &plan["frames"]),
        (&3.into(), &2.into(), &3.into(), &240.into())
    );
    let [cpu_hours, hours, gigabytes] = ["cpu_hours", "hours", "gigabytes"].map(|key| plan[key].as_f64().unwrap());
    assert!(cpu_hours > 0.0 && hours > 0.0 && hours <= cpu_hours, "{plan}");
    let line = String::from_utf8(output(&mut folders.import(&[".", "--dry-run"])).stdout).unwrap();
    assert!(line.contains("total 3 clips of 2 sheep, 240 frames, ") && line.trim_end().ends_with(" GB"), "{line}");
    assert_eq!(folders.manifest(), before);
    assert_eq!(fs::read_dir(folders.flock().join("loops")).unwrap().count(), 0);
    // The estimate is of the right size.
    folders.answer(0, &["."]);
    let clips = ["loops/247.1.mp4", "loops/247.2.mp4", "transitions/247.1=247.2.mp4"];
    let bytes: u64 = clips.iter().map(|clip| fs::metadata(folders.flock().join(clip)).unwrap().len()).sum();
    let ratio = gigabytes * 1e9 / bytes as f64;
    assert!((0.3..3.0).contains(&ratio), "{gigabytes} GB were expected, {bytes} bytes came");
    let (nothing, _) = folders.answer_and_notes(0, &[".", "--dry-run"]);
    assert_eq!((&nothing["plan"]["clips"], &nothing["plan"]["gigabytes"]), (&0.into(), &json!(0.0)));
}

#[test]
fn force_replaces_what_the_flock_has_in_its_place_and_nothing_else() {
    let folders = ImportFolders::new("64x64");
    film(&folders, "a=a.avi", "testsrc2=size=64x64:rate=30", 4, "-c:v ffv1");
    film(&folders, "a=b.avi", "testsrc2=size=64x64:rate=30", 4, "-c:v ffv1");
    folders.answer(0, &["."]);
    // The artist has named and weighed it.
    let edited =
        folders.manifest().replace("loops/a.mp4", "art/first.mp4").replace("to = \"b\"", "to = \"b\"\nweight = 3");
    fs::create_dir(folders.flock().join("art")).unwrap();
    fs::rename(folders.flock().join("loops/a.mp4"), folders.flock().join("art/first.mp4")).unwrap();
    fs::write(folders.flock().join("flock.toml"), &edited).unwrap();
    film(&folders, "a=a.avi", "testsrc2=size=64x64:rate=30,negate", 6, "-c:v ffv1");
    let (stood, _) = folders.answer_and_notes(0, &["."]);
    assert_eq!((&stood["clips"][0]["state"], &stood["clips"][1]["state"]), (&json!("stood"), &json!("stood")));
    assert_eq!(folders.manifest(), edited);
    let (replaced, told) = folders.answer_and_notes(0, &[".", "--force"]);
    assert_eq!(replaced["clips"][0]["clip"], "art/first.mp4");
    assert_eq!((&replaced["clips"][0]["frames"], &replaced["clips"][0]["replaces"]), (&6.into(), &json!(true)));
    assert!(told.contains("2 to encode, 0 to copy, 2 to replace"), "{told}");
    let manifest = folders.manifest();
    assert!(manifest.contains("frames = 6\nclip = \"art/first.mp4\"") && manifest.contains("weight = 3"), "{manifest}");
    assert!(!folders.flock().join("loops/a.mp4").exists());
    assert_eq!(folders.clip_faults(), [] as [Value; 0]);

    let genome = fs::read_to_string(programs::repository().join("flock-tools/demo/genomes/orchid.flam3")).unwrap();
    fs::write(folders.inbox().join("a.flam3"), &genome).unwrap();
    folders.answer(0, &["a.flam3"]);
    fs::write(folders.inbox().join("a.flam3"), genome.replacen("nick=\"dreams\"", "nick=\"Ram\"", 1)).unwrap();
    let (second, _) = folders.answer_and_notes(0, &["a.flam3"]);
    assert_eq!((&second["genomes"][0]["sheep"], &second["genomes"][0]["state"]), (&json!("orchid.2"), &json!("added")));
    let (replaced, _) = folders.answer_and_notes(0, &["a.flam3", "--force"]);
    assert_eq!(replaced["genomes"][0]["state"], "replaced");
    assert!(fs::read_to_string(folders.flock().join("genomes/orchid.flam3")).unwrap().contains("nick=\"Ram\""));
}

#[test]
fn an_import_syncs_the_disk_at_most_once_a_clip_and_comes_out_the_same_on_all_cores() {
    let folders = ImportFolders::new("64x64");
    for at in 0..12 {
        film(
            &folders,
            &format!("a{at}=a{}.avi", at + 1),
            &format!("testsrc2=size=64x64:rate=30,hue=h={at}"),
            3,
            "-c:v ffv1",
        );
    }
    let log = folders.scratch.path().join("calls");
    let said = traced(
        &folders.import(&[&folders.inbox().display().to_string()]),
        &log,
        &["-e", "trace=fsync,fdatasync,sync,syncfs,sync_file_range,msync"],
    );
    assert!(said.status.success(), "{}", String::from_utf8_lossy(&said.stderr));
    let calls = fs::read_to_string(&log).unwrap();
    let syncs = calls.lines().filter(|line| line.contains("sync") && line.contains('(')).count();
    assert!((1..=12).contains(&syncs), "{calls}");
    let many = folders.manifest();
    fs::remove_dir_all(folders.flock()).unwrap();
    folders.start("64x64");
    folders.answer(0, &[".", "--threads", "1"]);
    assert_eq!(folders.manifest(), many, "with one thread and with all, to the byte");
}

#[test]
fn a_kill_or_a_failing_disk_at_any_step_leaves_a_whole_flock_and_the_next_import_ends_it() {
    let folders = ImportFolders::new("64x64");
    film(&folders, "a=a.avi", "testsrc2=size=64x64:rate=30", 2, "-c:v ffv1");
    film(&folders, "a=b.avi", "testsrc2=size=64x64:rate=30,negate", 2, "-c:v ffv1");
    let log = folders.scratch.path().join("calls");
    let inbox = folders.inbox().display().to_string();
    let prepare = || {
        let _ = fs::remove_dir_all(folders.flock());
        folders.start("64x64");
        folders.import(&[&inbox, "--threads", "1"])
    };
    let tries = at_every_step(&["rename", "syncfs", "fsync"], &log, prepare, |step| {
        if folders.manifest().contains("[[sheep]]") {
            assert_eq!(folders.clip_faults(), [] as [Value; 0], "{step}");
        }
        let said: Output = output(&mut folders.import(&["."]));
        assert!(said.status.success(), "{step}: {}", String::from_utf8_lossy(&said.stderr));
        assert_eq!((folders.manifest().matches("frames = 2").count(), folders.clip_faults().len()), (2, 0), "{step}");
        let inside = ["loops", "transitions"].map(|name| fs::read_dir(folders.flock().join(name)).unwrap().count());
        assert_eq!(inside, [1, 1], "{step}: nothing lies beside the clips");
    });
    assert!(tries >= 16, "{tries} faults");
}
