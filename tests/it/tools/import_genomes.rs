//! Files of genomes as people have them: in any encoding and under any name, with a flame that is broken, in a hidden folder.
//!
//! Owns the claims on `dreams import` for such files; what is in a transform is for `crates/flame`.

use super::import_folders::ImportFolders;
use claims::programs::{self, output, succeed};
use serde_json::{Value, json};
use std::collections::BTreeSet;
use std::fs;
use std::os::unix::fs::symlink;
use std::path::Path;
use std::process::Command;

/// The digits of so many colours.
fn palette(colours: usize) -> String {
    let colours: Vec<String> = (0..colours).map(|i| format!("{:02X}8040", i * 255 / (colours - 1))).collect();
    colours.concat()
}

/// A flame with attributes, and a palette of its own; another `place` makes another picture.
fn flame(attributes: &str, place: f64) -> String {
    let palette = palette(256);
    format!(
        "<flame {attributes} scale=\"20\" quality=\"1\">\n\
         <xform weight=\"1\" color=\"0\" linear=\"1\" coefs=\"0.5 0 0 0.5 {place} 0\"/>\n\
         <xform weight=\"1\" color=\"1\" linear=\"1\" coefs=\"0.5 0 0 0.5 -0.5 0.5\"/>\n\
         <palette count=\"256\" format=\"RGB\">{palette}</palette>\n</flame>"
    )
}

fn named(name: &str, place: f64) -> String {
    flame(&format!("name=\"{name}\" size=\"64 48\" center=\"0 0\""), place)
}

fn utf16(text: &str, bytes: fn(u16) -> [u8; 2]) -> Vec<u8> {
    text.encode_utf16().flat_map(bytes).collect()
}

/// The sheep of the genomes in an answer, with their states.
fn sheep(answer: &Value) -> Vec<(String, String)> {
    let text = |value: &Value| value.as_str().unwrap().to_owned();
    answer["genomes"].as_array().unwrap().iter().map(|own| (text(&own["sheep"]), text(&own["state"]))).collect()
}

fn added(ids: &[&str]) -> Vec<(String, String)> {
    ids.iter().map(|id| ((*id).to_owned(), "added".to_owned())).collect()
}

fn reasons(answer: &Value) -> Vec<&str> {
    answer["left_out"].as_array().unwrap().iter().map(|file| file["reason"].as_str().unwrap()).collect()
}

/// The checksum of the picture of a genome that `dreams still` draws.
fn drawn(folders: &ImportFolders, genome: &Path, words: &[&str]) -> String {
    let mut still = Command::new(programs::dreams());
    still.arg("still").arg(genome).arg("--out").arg(folders.scratch.path().join("still.png"));
    let said = succeed(still.args(["--spp", "1", "--json"]).args(words));
    serde_json::from_slice::<Value>(&said).unwrap()["checksum"].as_str().unwrap().to_owned()
}

#[test]
fn a_genome_comes_in_from_every_encoding_and_is_drawn() {
    let folders = ImportFolders::new("64x48");
    let text = named("Z\u{fc}rich", 0.5);
    let declared = |encoding: &str| format!("<?xml version=\"1.0\" encoding=\"{encoding}\"?>\n<flames>{text}</flames>");
    let latin: fn(String) -> Vec<u8> = |text| text.chars().map(|c| u8::try_from(u32::from(c)).unwrap()).collect();
    let marked = format!("\u{feff}{text}");
    let mut pictures = BTreeSet::new();
    for (name, bytes) in [
        ("mark", marked.clone().into_bytes()),
        ("little", utf16(&marked, u16::to_le_bytes)),
        ("big", utf16(&marked, u16::to_be_bytes)),
        ("little-unmarked", utf16(&declared("UTF-16"), u16::to_le_bytes)),
        ("big-unmarked", utf16(&text, u16::to_be_bytes)),
        ("little-blank", utf16(&format!("\r\n{}", declared("UTF-16")), u16::to_le_bytes)),
        ("big-blank", utf16(&format!(" \t\n{text}"), u16::to_be_bytes)),
        ("latin", latin(declared("ISO-8859-1"))),
        ("windows", latin(declared("windows-1252"))),
        ("type", declared("UTF-8").replace("<flames>", "<!DOCTYPE flames>\n<flames>").into_bytes()),
        ("zeros", [text.as_bytes(), &[0; 512]].concat()),
    ] {
        let path = folders.inbox().join(format!("{name}.flame"));
        fs::write(&path, bytes).unwrap();
        let answer = folders.answer(0, &[&format!("{name}.flame")]);
        let state = if name == "mark" { "added" } else { "stood" };
        assert_eq!(sheep(&answer), [("Zurich".to_owned(), state.to_owned())], "{name}");
        pictures.insert(drawn(&folders, &path, &[]));
    }
    assert_eq!(pictures.len(), 1, "{pictures:?}");
    assert_eq!(fs::read_to_string(folders.flock().join("genomes/Zurich.flam3")).unwrap(), format!("{text}\n"));
    fs::write(folders.inbox().join("lost.flame"), b"<flame\nname='Z\xfcrich'/>").unwrap();
    let answer = folders.answer(1, &["lost.flame"]);
    assert_eq!(reasons(&answer), ["cannot be read: line 2 has bytes that are not UTF-8; save it as UTF-8"]);
}

#[test]
fn a_bad_flame_is_named_and_the_good_ones_of_its_file_come_in() {
    let folders = ImportFolders::new("64x48");
    let bad = named("bad", 0.2).replace("size=\"64 48\"", "size=\"64 x\"");
    let good = ["a", "b"].map(|name| named(name, 0.5));
    fs::write(
        folders.inbox().join("all.flame"),
        format!("<Flames name=\"all\">\n{}\n{bad}\n{}\n</Flames>", good[0], good[1]),
    )
    .unwrap();
    let torn = format!("<flames>{}\n<flame name=\"torn\"><xform></flame>\n{}", named("c", 0.5), named("d", 0.5));
    fs::write(folders.inbox().join("torn.flame"), torn).unwrap();
    let answer = folders.answer(1, &["."]);
    assert_eq!(sheep(&answer), added(&["a", "b", "c", "d"]), "{answer}");
    assert_eq!(
        reasons(&answer),
        [
            "flame 2 is not readable: line 7, column 19: attribute `size` of `flame` is `64 x`, expected two whole numbers",
            "flame 2 is not readable: not well-formed XML: expected 'xform' tag, not 'flame' at 6:27",
        ]
    );
}

#[test]
fn names_of_any_script_become_ids_and_equal_ones_get_numbers() {
    let folders = ImportFolders::new("64x48");
    let names = [
        "\u{41c}\u{43e}\u{441}\u{43a}\u{432}\u{430}",
        "\u{5317}\u{4eac}",
        "-----",
        "*****",
        "ewe",
        "ewe",
        "ewe",
        "",
        &"n".repeat(90),
    ];
    let flames: Vec<String> = (1..).zip(names).map(|(at, name)| named(name, f64::from(at) / 8.0)).collect();
    let write = |flames: &[String]| {
        fs::write(folders.inbox().join("best.flame"), format!("<flames>{}</flames>", flames.concat())).unwrap();
    };
    write(&flames);
    let (answer, notes) = folders.answer_and_notes(0, &["best.flame"]);
    let long = "n".repeat(64);
    let wanted = ["Moskva", "Bei-Jing", "best.3", "best.4", "ewe", "ewe.2", "ewe.3", "best.8", &long];
    assert_eq!(sheep(&answer), added(&wanted));
    assert!(!notes.contains("--force"), "{notes}");
    let manifest = folders.manifest();

    // Again, and in another order: each finds its own.
    write(&[flames[6].clone(), flames[5].clone(), flames[4].clone()]);
    let again = folders.answer(0, &["best.flame"]);
    let stood = ["ewe.3", "ewe.2", "ewe"].map(|id| (id.to_owned(), "stood".to_owned()));
    assert_eq!((sheep(&again).as_slice(), folders.manifest()), (stood.as_slice(), manifest));
    write(&[named("ewe", 0.9)]);
    assert_eq!(sheep(&folders.answer(0, &["best.flame", "--dry-run"])), added(&["ewe.4"]));
    assert_eq!(sheep(&folders.answer(0, &["best.flame"])), added(&["ewe.4"]));
}

#[test]
fn ids_that_differ_in_capitals_only_get_numbers() {
    let folders = ImportFolders::new("64x48");
    let flames: Vec<String> =
        (1..).zip(["ewe", "EWE", "Ewe"]).map(|(at, name)| named(name, f64::from(at) / 8.0)).collect();
    let write = |name: &str, flames: &[&str]| {
        fs::write(folders.inbox().join(name), format!("<flames>{}</flames>", flames.concat())).unwrap();
    };
    write("best.flame", &[&flames[0], &flames[1], &flames[2]]);
    let wanted = ["ewe", "EWE.2", "Ewe.3"];
    assert_eq!(sheep(&folders.answer(0, &["best.flame", "--dry-run"])), added(&wanted));
    assert_eq!(sheep(&folders.answer(0, &["best.flame"])), added(&wanted));
    let files = fs::read_dir(folders.flock().join("genomes")).unwrap();
    let files: BTreeSet<String> =
        files.map(|file| file.unwrap().file_name().to_str().unwrap().to_lowercase()).collect();
    assert_eq!(files.len(), 3, "on a disk that knows no capitals: {files:?}");
    let manifest = folders.manifest();

    // Again, in another order, and even where other genomes are replaced: each finds its own.
    write("best.flame", &[&flames[2], &flames[1], &flames[0]]);
    let stood = ["Ewe.3", "EWE.2", "ewe"].map(|id| (id.to_owned(), "stood".to_owned()));
    for options in [&["best.flame"][..], &["best.flame", "--force"]] {
        let again = folders.answer(0, options);
        assert_eq!((sheep(&again).as_slice(), folders.manifest()), (stood.as_slice(), manifest.clone()), "{options:?}");
    }
    write("EWE=ram.flame", &[&named("", 0.9), &named("ram", 0.7)]);
    let answer = folders.answer(0, &["EWE=ram.flame"]);
    assert_eq!(answer["transitions"][0]["clip"], "transitions/ewe=ram.mp4", "{answer}");
}

#[test]
fn key_frames_are_one_animation_and_the_artist_decides() {
    let folders = ImportFolders::new("64x48");
    let at = |time: u32| {
        let attributes = format!("time=\"{time}\" name=\"{time}.000000\" size=\"64 48\" center=\"0 0\"");
        flame(&attributes, 0.5 + f64::from(time) / 8.0)
    };
    fs::write(folders.inbox().join("wave.flam3"), [at(0), at(1), at(2)].concat()).unwrap();
    let refused = folders.answer(1, &["wave.flam3"]);
    let [reason] = reasons(&refused)[..] else { panic!("{refused}") };
    assert!(reason.starts_with("its 3 flames are the key frames of one animation, of times 0 to 2"), "{reason}");
    assert!(reason.contains("--key-frames first") && reason.contains("--key-frames all"), "{reason}");
    assert_eq!((sheep(&refused), &refused["key_frames"]), (Vec::new(), &json!(0)));
    let first = folders.answer(0, &["wave.flam3", "--key-frames", "first"]);
    assert_eq!((sheep(&first), &first["key_frames"]), (added(&["wave"]), &json!(1)));
    let all = folders.answer(0, &["wave.flam3", "--key-frames", "all"]);
    assert_eq!((sheep(&all), &all["key_frames"]), (added(&["wave.1", "wave.2", "wave.3"]), &json!(1)));
    drawn(&folders, &folders.inbox().join("wave.flam3"), &["--time", "0.5"]);
    let said = output(&mut folders.import(&["wave.flam3", "--key-frames", "all"]));
    let notes = String::from_utf8_lossy(&said.stderr).into_owned();
    let note = "note: 1 file with the key frames of one animation: the motion from one to the next is not imported";
    assert!(notes.contains(note), "{notes}");
}

#[test]
fn hidden_files_and_folders_are_passed_over_and_counted_and_never_win() {
    let folders = ImportFolders::new("64x48");
    let hidden =
        [".Trashes/501", "$RECYCLE.BIN", "System Volume Information", "@eaDir", "works/.old", "#recycle", "__MACOSX"];
    let film = |folder: &str, frames| {
        folders.film(&format!("{folder}/a=a.avi"), "testsrc2=size=64x48:rate=30", frames, &["-c:v", "ffv1"]);
        fs::write(folders.inbox().join(folder).join("ram.flame"), named("ram", frames as f64 / 16.0)).unwrap();
    };
    for folder in hidden {
        film(folder, 3);
    }
    film("works", 5);
    fs::write(folders.inbox().join("works/._ram.flame"), b"\0\x05\x16\x07 of macOS").unwrap();
    symlink("@eaDir", folders.inbox().join("thumbs")).unwrap();
    let (answer, notes) = folders.answer_and_notes(0, &["."]);
    assert_eq!((&answer["clips"].as_array().unwrap().len(), &answer["clips"][0]["frames"]), (&1, &json!(5)));
    assert!(answer["clips"][0]["source"].as_str().unwrap().ends_with("works/a=a.avi"), "{answer}");
    assert_eq!((sheep(&answer), &answer["hidden"]), (added(&["ram"]), &json!(9)));
    assert!(!notes.contains("left out"), "{notes}");
    let said = output(&mut folders.import(&["."]));
    let notes = String::from_utf8_lossy(&said.stderr).into_owned();
    assert!(
        notes.contains("note: 9 items passed over: hidden, deleted or of a system; name one to import it"),
        "{notes}"
    );
    let given = folders.answer(0, &[".Trashes"]);
    assert_eq!((sheep(&given), &given["hidden"]), (added(&["ram.2"]), &json!(0)));
}

#[test]
fn flames_as_other_programs_write_them_come_in_with_notes() {
    let folders = ImportFolders::new("64x48");
    let write = |name: &str, text: &str| fs::write(folders.inbox().join(name), text).unwrap();
    let odd = "name=\"odd\" size=\"64.0 48.0\" temporal_samples=\"1.0\" filter_shape=\"Gaussian\" center=\"nan nan\" \
               palette_interpolation=\"hsv2\" zoom=\"\"";
    let colours = palette(512);
    let (head, _) = flame(odd, 0.5).split_once("<palette").map(|(a, b)| (a.to_owned(), b.to_owned())).unwrap();
    write("odd.flame", &format!("{head}<palette count=\"512\" format=\"RGB\">{colours}</palette></flame>"));
    let movie =
        format!("<jwf-movie><jwf-movie-part frame_count=\"60\">{}</jwf-movie-part></jwf-movie>", named("part", 0.4));
    write("film.jwfmovie", &movie);
    write("layers.flame", "<jwf-flame name=\"two\"><layer/><layer/></jwf-flame>");
    write("works.chaos", "<world><IFS/></world>");
    write("renamed.flame", "<world><IFS/></world>");
    let numbered = named("twice", 0.3)
        .replace("linear=\"1\" coefs", "linear=\"1\" linear#1#=\"0\" linear#1#_fx_priority=\"0\" coefs");
    write("twice.flame", &numbered);
    let (answer, notes) = folders.answer_and_notes(1, &["."]);
    assert_eq!(sheep(&answer), added(&["part", "odd", "twice"]), "{answer}");
    let of_genome = ["its center is `nan nan`, read as `0 0`", "its palette has 512 colours, drawn as 256"];
    assert_eq!(answer["genomes"][1]["notes"], json!(of_genome));
    assert!(notes.is_empty() || !notes.contains("error"), "{notes}");
    let reasons = reasons(&answer);
    assert_eq!(reasons.len(), 3, "{reasons:?}");
    let chaotica = "is a file of Chaotica, a format that is not read (expected flam3 XML); import the `.flame` file of the \
                    same flame";
    assert!(reasons.iter().filter(|reason| **reason == chaotica).count() == 2, "{reasons:?}");
    assert!(reasons.iter().any(|reason| reason.contains("a `jwf-flame` has layers")), "{reasons:?}");
    let kept = fs::read_to_string(folders.flock().join("genomes/twice.flam3")).unwrap();
    assert!(kept.contains("linear.2 =\"0\" linear.2_fx_priority =\"0\""), "{kept}");
    drawn(&folders, &folders.flock().join("genomes/odd.flam3"), &[]);
}

#[test]
fn a_flame_of_one_layer_is_drawn_as_the_flame_that_it_is() {
    let folders = ImportFolders::new("64x48");
    let write = |name: &str, text: &str| fs::write(folders.inbox().join(name), text).unwrap();
    let plain = named("one", 0.5);
    let (head, rest) = plain.split_once(">\n").unwrap();
    let inside = rest.replace("</flame>", "");
    let layered = |layers: &[&str]| {
        let layers: Vec<String> = layers.iter().map(|own| format!("<layer {own}>{inside}</layer>")).collect();
        let layers = layers.concat();
        format!("{}>\n{layers}</jwf-flame>", head.replace("<flame", "<jwf-flame"))
    };
    let full = "weight=\"1.0\" density=\"1.0\" visible=\"1\" name=\"Layer 1\"";
    write("one.flame", &layered(&[full]));
    write("plain.flame", &plain);
    for (name, layers) in [
        ("two", &[full, full][..]),
        ("none", &[]),
        ("hidden", &["weight=\"1.0\" density=\"1.0\" visible=\"0\""]),
        ("thin", &["weight=\"0.4\" density=\"1.0\" visible=\"1\""]),
    ] {
        write(&format!("{name}.flame"), &layered(layers));
        let answer = folders.answer(1, &[&format!("{name}.flame")]);
        let reasons = reasons(&answer);
        assert!(reasons.len() == 1 && reasons[0].contains("a `jwf-flame` has layers"), "{name}: {reasons:?}");
    }
    assert_eq!(sheep(&folders.answer(0, &["one.flame"])), added(&["one"]));
    let pictures = [folders.flock().join("genomes/one.flam3"), folders.inbox().join("plain.flame")];
    let [one, other] = pictures.map(|genome| drawn(&folders, &genome, &[]));
    assert_eq!(one, other);
    write("far.flame", &named("far", 0.2).replace("center=\"0 0\"", "center=\"inf 0\""));
    let far = folders.answer(0, &["far.flame"]);
    assert_eq!(far["genomes"][0]["notes"], json!(["its center is `inf 0`, read as `0 0`"]), "{far}");
}
