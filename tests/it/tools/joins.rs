//! Joins are judged alike at every size of the picture.
//!
//! Owns the claim on `dreams check --joins` that one flock meets or jumps at every size, the demo's joins and breaks that
//! are planted. The figures themselves are tested beside their code, in `flock-tools/operations/src/joins`.

use claims::clips::{SETPARAMS, TAGS};
use claims::programs::{self, json, output, repository, succeed};
use std::collections::BTreeSet;
use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Small, middle, as rendered, and upright.
const SIZES: [(u32, u32); 4] = [(320, 180), (640, 360), (1280, 720), (360, 640)];
/// Frames at either end of a clip that a join is judged by.
const END: u32 = 12;
/// The clips that continue `take`, of the demo's tempest from frame 20 to 31: their frames there, and whether they jump.
const AFTER_TAKE: [(&str, &str, bool); 6] = [
    ("met", "between(n,32,43)", false),
    ("missing", "between(n,33,44)", true),
    ("doubled", "between(n,31,42)", true),
    ("faster", "between(n,32,55)*not(mod(n,2))", true),
    ("back", "between(n,19,30),reverse", true),
    ("cut", "between(n,90,101)", true),
];
/// The same for `fast`, which has every second frame from 20 to 42.
const AFTER_FAST: [(&str, &str, bool); 2] =
    [("as-fast", "between(n,44,67)*not(mod(n,2))", false), ("slower", "between(n,44,55)", true)];

/// Writes the frames of the demo's clip `from` that `select` chooses, in every size.
fn make(folder: &Path, from: &str, select: &str, to: &str) {
    let mut graph = format!("[0:v]select={select},setpts=N/30/TB,split={}", SIZES.len());
    let scale = |(at, (width, height))| format!("[s{at}]scale={width}:{height}:flags=area,setsar=1,{SETPARAMS}[{at}]");
    graph.extend((0..SIZES.len()).map(|at| format!("[s{at}]")));
    graph.extend(SIZES.iter().enumerate().map(|(at, size)| format!(";{}", scale((at, *size)))));
    let mut ffmpeg = Command::new("ffmpeg");
    let from = repository().join("flock-tools/demo/small").join(from);
    ffmpeg.args(["-v", "error", "-nostdin", "-i"]).arg(from).args(["-filter_complex", &graph]);
    for (at, size) in SIZES.iter().enumerate() {
        ffmpeg.args(["-map", &format!("[{at}]"), "-r", "30", "-c:v", "libx264", "-profile:v", "high"]);
        ffmpeg.args([
            "-preset",
            "ultrafast",
            "-crf",
            "12",
            "-x264-params",
            "open-gop=0:8x8dct=1",
            "-movflags",
            "+faststart",
        ]);
        ffmpeg.args(["-bsf:v", "dump_extra=freq=keyframe"]).args(TAGS).arg(of(folder, *size).join(to));
    }
    succeed(&mut ffmpeg);
}

/// The folder of the flock of this size.
fn of(folder: &Path, (width, height): (u32, u32)) -> PathBuf {
    folder.join(format!("{width}x{height}"))
}

/// Makes the demo with the ends of its clips only; returns its manifest without the head.
fn demo(folder: &Path) -> String {
    let text = fs::read_to_string(repository().join("flock-tools/demo/small/flock.toml")).unwrap();
    let (_, body) = text.split_once("fps = [30, 1]\n").unwrap();
    let mut manifest = String::new();
    let mut frames = 0;
    for line in body.lines().filter(|line| !line.starts_with("hash") && !line.starts_with("genome")) {
        match line.split_once(" = ") {
            Some(("frames", count)) => {
                frames = count.parse::<u32>().unwrap();
                writeln!(manifest, "frames = {}", 2 * END).unwrap();
            }
            Some(("clip", clip)) => {
                let clip = clip.trim_matches('"');
                make(folder, clip, &format!("'lt(n,{END})+gte(n,{})'", frames - END), clip);
                writeln!(manifest, "{line}").unwrap();
            }
            _ => writeln!(manifest, "{line}").unwrap(),
        }
    }
    manifest
}

/// Makes the sheep `id` of `frames` of the tempest, and its transitions to these; returns their part of the manifest.
fn planted(folder: &Path, id: &str, frames: &str, after: &[(&str, &str, bool)]) -> String {
    let clip = |name: &str| format!("planted/{name}.mp4");
    let select = |frames: &str| {
        let (chosen, then) = frames
            .split_once("),")
            .map_or((frames.to_owned(), String::new()), |(chosen, then)| (format!("{chosen})"), format!(",{then}")));
        format!("'{chosen}'{then}")
    };
    make(folder, "loops/tempest.mp4", &select(frames), &clip(id));
    let mut manifest = format!("[[sheep]]\nid = \"{id}\"\nframes = {END}\nclip = \"{}\"\n", clip(id));
    for (name, frames, _) in after {
        make(folder, "loops/tempest.mp4", &select(frames), &clip(name));
        // A sheep without a loop, and a way back that is not looked at.
        write!(manifest, "[[sheep]]\nid = \"{name}\"\n").unwrap();
        for (from, to) in [(id, *name), (*name, id)] {
            let clip = clip(name);
            write!(manifest, "[[transition]]\nfrom = \"{from}\"\nto = \"{to}\"\nframes = {END}\nclip = \"{clip}\"\n")
                .unwrap();
        }
    }
    manifest
}

#[test]
fn the_same_joins_jump_at_every_size_of_the_picture() {
    let scratch = tempfile::tempdir_in(programs::claims_folder()).unwrap();
    for size in SIZES {
        for folder in ["loops", "transitions", "planted"] {
            fs::create_dir_all(of(scratch.path(), size).join(folder)).unwrap();
        }
    }
    let body = demo(scratch.path())
        + &planted(scratch.path(), "take", "between(n,20,31)", &AFTER_TAKE)
        + &planted(scratch.path(), "fast", "between(n,20,43)*not(mod(n,2))", &AFTER_FAST);
    let due: BTreeSet<String> = AFTER_TAKE
        .iter()
        .chain(&AFTER_FAST)
        .filter(|(.., jumps)| *jumps)
        .map(|(name, ..)| format!("planted/{name}.mp4"))
        .collect();
    for (width, height) in SIZES {
        let folder = of(scratch.path(), (width, height));
        let head = format!("format = 1\nname = \"demo\"\nsize = [{width}, {height}]\nfps = [30, 1]\n");
        fs::write(folder.join("flock.toml"), head + &body).unwrap();
        let answer =
            json(&output(Command::new(programs::dreams()).arg("check").arg(&folder).args(["--joins", "--json"])));
        let faults = answer["faults"].as_array().unwrap();
        // `split` and its like: the planted sheep are on their own.
        assert!(faults.iter().all(|fault| !fault["kind"].as_str().unwrap().ends_with("-clip")), "{answer:#}");
        let jumps = faults.iter().filter(|fault| fault["kind"] == "jump");
        let ends = jumps.map(|jump| [&jump["before"], &jump["after"]].map(|clip| clip.as_str().unwrap().to_owned()));
        // Of the planted ones only what comes after the two takes.
        let is_ours = |before: &str| ["planted/take.mp4", "planted/fast.mp4"].contains(&before);
        let is_looked_at = |[before, _]: &[String; 2]| !before.starts_with("planted/") || is_ours(before);
        let found: BTreeSet<String> = ends.filter(is_looked_at).map(|[_, after]| after).collect();
        assert_eq!(found, due, "{width}x{height}: {answer:#}");
    }
}
