//! Our genomes over time against those of `flam3-genome`, used as a black box.
//!
//! Owns claims about numbers that flam3 prints; what pictures look like is for `flam3.rs`. Where `flam3-genome` (Debian:
//! `flam3-utils`) is missing these tests fail: install it.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use flame::genome::{Genome, GenomeError, Library, Xform};
use flame::{KeyFrames, Loop, Motion};

/// `text` in a file of that name.
fn file(name: &str, text: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    fs::write(&path, text).unwrap();
    path
}

/// What `flam3-genome` prints for the settings `verb`, as genomes; none if it refuses.
fn theirs(verb: &[(&str, &str)]) -> Vec<Genome> {
    let run = Command::new("flam3-genome")
        .envs(verb.iter().copied())
        .output()
        .expect("`flam3-genome` runs: install the package `flam3-utils`");
    Genome::parse_all(&String::from_utf8(run.stdout).unwrap()).unwrap_or_default()
}

/// The genome that `flam3-genome` prints for `frame` of the loop of `path`.
fn frame_of_loop(path: &Path, frame: u32, frames: u32) -> Option<Genome> {
    let (frame, frames) = (frame.to_string(), frames.to_string());
    let printed = theirs(&[("rotate", path.to_str().unwrap()), ("frame", &frame), ("nframes", &frames)]);
    printed.into_iter().find(|genome| genome.time.to_string() == frame)
}

/// All numbers of a transform.
fn numbers(xform: &Xform) -> Vec<f64> {
    let mut out = vec![xform.weight, xform.color, xform.color_speed, xform.animate, xform.opacity];
    for affine in [xform.affine, xform.post] {
        out.extend([affine.a, affine.b, affine.c, affine.d, affine.e, affine.f]);
    }
    let mut variations: Vec<_> = xform.variations.iter().filter(|variation| variation.weight.abs() > 1e-9).collect();
    variations.sort_by_key(|variation| variation.kind);
    for variation in variations {
        out.extend([f64::from(variation.kind as u8), variation.weight]);
        out.extend(variation.params);
    }
    out
}

/// Whether the transforms of both have the same numbers, as far as flam3 prints them.
fn assert_alike(ours: &Genome, theirs: &Genome, what: &str) {
    let all = |genome: &Genome| -> Vec<f64> {
        // `animate` of a final transform is not printed.
        let last = genome.finals.last().cloned().map(|last| Xform { animate: 1.0, ..last });
        genome.xforms.iter().chain(&last).flat_map(numbers).collect()
    };
    let (ours, theirs) = (all(ours), all(theirs));
    assert_eq!(ours.len(), theirs.len(), "{what}: {ours:?}, {theirs:?}");
    for (at, (a, b)) in ours.iter().zip(&theirs).enumerate() {
        assert!((a - b).abs() <= 1e-5 * (1.0 + b.abs()), "{what}, number {at}: {a}, flam3 has {b}");
    }
}

/// A flame of three transforms with `motions` in the first and `last` in the final one.
fn flame(motions: &str, last: &str) -> String {
    format!(
        r#"<flame time="0" size="100 100" scale="50">
           <xform weight="1" color="0.25" color_speed="0.5" animate="1" opacity="0.5" coefs="1 0.2 0 1 0.5 0.25"
             linear="1" julian="0.5" julian_power="2" julian_dist="1">{motions}</xform>
           <xform weight="1" color="1" coefs="0.5 0 0 1 0 0" linear="1" animate="0"/>
           <finalxform color="0" coefs="1 0 0 1 0 0" linear="1">{last}</finalxform>
           <color index="0" rgb="255 0 0"/></flame>"#
    )
}

#[test]
fn loops_wave_as_flam3_genome_says() {
    let motion = |attributes: &str| format!("<motion {attributes}/>");
    let sine = motion(
        r#"motion_frequency="1" motion_function="sin" linear="0.1" julian_dist="0.2" coefs="1 0 0.3 1 0.3 0" color="0.1" weight="0.5""#,
    );
    let triangle = motion(r#"motion_frequency="2" motion_function="triangle" spherical="1" opacity="0.1""#);
    let hill =
        motion(r#"motion_frequency="1" motion_function="hill" post="0 0 0 0 1 0" color_speed="0.1" animate="1""#);
    for (name, motions, last) in [
        ("three", [&*sine, &triangle, &hill].concat(), ""),
        ("twice", [&*sine, &sine].concat(), &*motion(r#"motion_frequency="3" motion_function="sin" linear="1""#)),
        ("backwards", motion(r#"motion_frequency="-1" motion_function="sin" weight="1""#), &*hill),
        (
            "out-of-range",
            motion(r#"motion_frequency="1" motion_function="sin" weight="-3" color="3" opacity="-4""#),
            "",
        ),
        ("no-function", motion(r#"motion_frequency="1" weight="1""#), ""),
        ("no-frequency", motion(r#"motion_function="sin" weight="1""#), ""),
        ("stands-still", motion(r#"motion_frequency="1" motion_function="hill" animate="-1""#), ""),
        ("symmetry", motion(r#"motion_frequency="1" motion_function="sin" symmetry="1""#), ""),
        ("parameter-alone", motion(r#"motion_frequency="1" motion_function="sin" blob="1" blob_high="0.5""#), ""),
    ] {
        let text = flame(&motions, last);
        let path = file(&format!("wave-{name}.flam3"), &text);
        let turning = Loop::new(&Genome::parse(&text).unwrap(), 8.0);
        for frame in 0..=8 {
            let theirs = frame_of_loop(&path, frame, 8).unwrap();
            assert_alike(&turning.at(f64::from(frame)), &theirs, &format!("{name}, frame {frame}"));
        }
    }
}

#[test]
fn a_motion_that_flam3_refuses_is_refused() {
    for attributes in [
        r#"motion_frequency="1.7" motion_function="sin" weight="1""#,
        r#"motion_frequency="1" motion_function="saw" weight="1""#,
        r#"motion_frequency="1" motion_function="sin" chaos="1""#,
        r#"motion_frequency="1" motion_function="sin" coefs="1""#,
    ] {
        let text = flame(&format!("<motion {attributes}/>"), "");
        assert!(frame_of_loop(&file("refused.flam3", &text), 1, 8).is_none(), "flam3 reads {attributes}");
        let refused = Genome::parse(&text).unwrap_err().to_string();
        assert!(refused.starts_with("line 3, column ") && refused.contains("of `motion` is"), "{refused}");
    }
}

/// flam3's own library, as Debian's `flam3-palette` installs it.
fn library() -> Library {
    let text = fs::read_to_string("/usr/share/flam3/flam3-palettes.xml").expect("`flam3-palette` is installed");
    Library::parse(&text).unwrap()
}

#[test]
fn palettes_of_a_library_are_those_of_flam3_with_the_same_hue_and_the_same_blend() {
    let blend = |numbers: [i32; 2], hues: [f64; 2], blend: f64| {
        let ([first, second], [from, to]) = (numbers, hues);
        format!(r#"<palette index0="{first}" index1="{second}" hue0="{from}" hue1="{to}" blend="{blend}"/>"#)
    };
    for (name, attributes, element) in [
        ("first", "palette=\"0\"", String::new()),
        ("last", "palette=\"700\"", String::new()),
        ("turned", "palette=\"15\" hue=\"0.3\"", String::new()),
        ("turned-back", "hue=\"-1.3\" palette=\"15\"", String::new()),
        ("blended", "", blend([1, 2], [0.0, 0.0], 0.5)),
        ("blended-and-turned", "", blend([29, 411], [0.1, 0.7], 0.25)),
        ("all-of-second", "hue=\"0.4\"", blend([3, 4], [0.0, 0.9], 1.0)),
        ("number-first", "palette=\"7\"", blend([3, 4], [0.0, 0.9], 1.0)),
    ] {
        let text = flame("", "").replace("<flame ", &format!("<flame {attributes} "));
        let text = text.replace(r#"<color index="0" rgb="255 0 0"/>"#, &element);
        let genome = Genome::parse(&text).unwrap();
        assert_eq!(Genome::parse(&genome.to_xml()).unwrap(), genome, "{name}");
        assert!(genome.needs_library(), "{name}");
        let ours = genome.with_library(&library()).unwrap();
        let theirs = frame_of_loop(&file(&format!("palette-{name}.flam3"), &text), 0, 8).unwrap();
        let pairs = ours.palette.unwrap().entries.concat().into_iter().zip(theirs.palette.unwrap().entries.concat());
        for (at, (a, b)) in pairs.enumerate() {
            assert!((a - b).abs() < 0.01, "{name}, entry {}, channel {}: {a}, flam3 has {b}", at / 4, at % 4);
        }
    }
}

#[test]
fn a_palette_that_no_library_has_is_refused_by_its_number() {
    let genome = |attributes: &str| Genome::parse(&format!("<flame {attributes}/>")).unwrap();
    let refused = genome("palette=\"701\"").with_library(&library()).unwrap_err();
    assert_eq!(refused, GenomeError::NoSuchPalette { number: 701, found: 701 });
    for names_none in ["", "palette=\"-1\"", "hue=\"0.5\""] {
        assert!(!genome(names_none).needs_library(), "{names_none}");
    }
    let own = Genome::parse("<flame palette=\"701\"><color index=\"0\" rgb=\"9 9 9\"/></flame>").unwrap();
    assert_eq!(own.with_library(&library()).unwrap(), own);
    let wrong = Library::parse("<palettes>\n<palette number=\"x\" data=\"00\"/></palettes>").unwrap_err().to_string();
    assert!(wrong.starts_with("line 2, column 1: palette `palette` has 2 digits"), "{wrong}");
}

#[test]
fn attributes_of_old_files_mean_what_they_mean_to_flam3() {
    let all = |weights: &[&str]| [weights, &vec!["0"; 99 - weights.len()]].concat().join(" ");
    let var = format!("linear=\"1\" var=\"{}\"", all(&["0", "0.5", "0", "0.25"]));
    let var_first = format!("var=\"{}\" linear=\"1\"", all(&["0", "0.5", "0", "0.25"]));
    for (of_flame, of_xform) in [
        ("", "linear=\"1\" symmetry=\"1\""),
        ("", "linear=\"1\" symmetry=\"-0.5\""),
        ("", "linear=\"1\" symmetry=\"0\""),
        ("", "linear=\"1\" symmetry=\"0.5\" color_speed=\"0.1\""),
        ("", "linear=\"1\" color_speed=\"0.1\" symmetry=\"0.5\""),
        ("", "linear=\"1\" animate=\"1\" symmetry=\"1\""),
        ("", "linear=\"1\" symmetry=\"1\" animate=\"1\""),
        ("", "linear=\"1\" plotmode=\"off\""),
        ("", "linear=\"1\" plotmode=\"on\""),
        ("", "linear=\"1\" opacity=\"0.5\" plotmode=\"off\""),
        ("", "linear=\"1\" plotmode=\"off\" opacity=\"0.5\""),
        ("", &*var),
        ("", &*var_first),
        ("", "linear=\"0.5\" var1=\"13\""),
        ("", "var1=\"13\" linear=\"0.5\""),
        ("soloxform=\"0\"", "linear=\"1\""),
        ("soloxform=\"1\"", "linear=\"1\" opacity=\"0.5\""),
        ("soloxform=\"5\"", "linear=\"1\""),
        ("soloxform=\"-1\"", "linear=\"1\" opacity=\"0.5\""),
        ("oversample=\"3\"", "linear=\"1\""),
        ("supersample=\"2\" oversample=\"3\"", "linear=\"1\""),
    ] {
        let text = format!(
            r#"<flame {of_flame} size="100 100"><xform weight="1" color="0" coefs="1 0 0 1 0 0" {of_xform}/>
               <xform weight="1" color="1" coefs="1 0 0 1 0 0" linear="1"/>
               <finalxform color="0" coefs="1 0 0 1 0 0" linear="1"/><color index="0" rgb="255 0 0"/></flame>"#
        );
        let (ours, what) = (Genome::parse(&text).unwrap(), format!("{of_flame}, {of_xform}"));
        let theirs = frame_of_loop(&file("old.flam3", &text), 0, 8).unwrap();
        assert_alike(&ours, &theirs, &what);
        assert_eq!(ours.sampling.supersample, theirs.sampling.supersample, "{what}");
        assert!(ours.xforms.iter().all(|xform| xform.extra.is_empty()), "{what}");
        assert_eq!(Genome::parse(&ours.to_xml()).unwrap(), ours, "{what}");
    }
    for wrong in ["soloxform=\"x\"", "oversample=\"0.5x\""] {
        assert!(Genome::parse(&format!("<flame {wrong}/>")).unwrap_err().to_string().starts_with("line 1, column 8: "));
    }
    assert_eq!(Genome::parse("<flame batches=\"4\"/>").unwrap().sampling.passes, 4);
}

/// Key frames that differ in everything that moves: each is a time, attributes of the flame, transforms and a colour.
fn key_frames(keys: &[(u32, &str, &str, &str)]) -> String {
    let flame = |(time, attributes, xforms, colour): &(u32, &str, &str, &str)| {
        format!(
            "<flame time=\"{time}\" size=\"100 100\" {attributes}>{xforms}<color index=\"0\" rgb=\"{colour}\"/></flame>"
        )
    };
    format!("<flames>{}</flames>", keys.iter().map(flame).collect::<String>())
}

const WIDE: &str = r#"<xform weight="1" color="0" coefs="1 0.2 0 1 0.5 0.25" linear="1"/>"#;
const TURNED: &str = r#"<xform weight="2" color="1" coefs="-0.5 0.2 0.3 -1 0 0.25" post="0.5 0.1 0 1 1 0" julian="1" julian_power="3" julian_dist="2" opacity="0.5"/>"#;
const RINGS: &str = r#"<xform weight="0.1" color="0.3" animate="0" coefs="-1 0 0 -1 0 0.25" rings2="1" rings2_val="0.4" linear="0.5"/>"#;
const CURL: &str =
    r#"<finalxform color="0" animate="0" coefs="0.5 0.2 0 1 0.5 0.25" curl="1" curl_c1="0.3" curl_c2="0"/>"#;

#[test]
fn key_frames_are_interpolated_as_flam3_genome_does() {
    for space in ["log", "linear", "old", "older"] {
        for path in ["rgb", "hsv", "hsv_circular", "sweep"] {
            for time in ["linear", "smooth"] {
                let attributes = |scale: u32, rotate: u32| {
                    format!(
                        r#"interpolation_type="{space}" palette_interpolation="{path}" interpolation="{time}" scale="{scale}"
                           rotate="{rotate}" center="{rotate} 1" gamma="{}" hsv_rgb_palette_blend="0.25""#,
                        f64::from(rotate) + 2.0
                    )
                };
                let heads = [attributes(50, 0), attributes(60, 3), attributes(30, 1), attributes(90, 2)];
                let text = key_frames(&[
                    (0, &heads[0], &[WIDE, TURNED].concat(), "255 0 0"),
                    (4, &heads[1], &[WIDE, RINGS, CURL].concat(), "0 255 60"),
                    (10, &heads[2], &[TURNED, RINGS, TURNED, CURL].concat(), "80 80 200"),
                    (14, &heads[3], &[RINGS, WIDE].concat(), "100 100 100"),
                ]);
                let keys = KeyFrames::new(Genome::parse_all(&text).unwrap()).unwrap();
                let path = file("keys.flam3", &text);
                let printed = theirs(&[("animate", path.to_str().unwrap())]);
                assert_eq!(printed.len(), 15);
                for theirs in printed {
                    let ours = keys.at(theirs.time);
                    let what = format!("{space}, {time}, {:?}, time {}", ours.hue_path, theirs.time);
                    assert_alike(&ours, &theirs, &what);
                    let numbers = |genome: &Genome| {
                        let camera = &genome.camera;
                        [camera.scale, camera.rotate, camera.center[0], camera.center[1], genome.tone.gamma]
                    };
                    for (a, b) in numbers(&ours).into_iter().zip(numbers(&theirs)) {
                        assert!((a - b).abs() < 1e-4 * (1.0 + b.abs()), "{what}: {a}, flam3 has {b}");
                    }
                    let colours = |genome: &Genome| genome.palette.clone().unwrap().entries.concat();
                    for (a, b) in colours(&ours).into_iter().zip(colours(&theirs)) {
                        assert!((a - b).abs() < 0.01, "{what}: colour {a}, flam3 has {b}");
                    }
                }
            }
        }
    }
}

#[test]
fn key_frames_out_of_order_are_refused_by_both() {
    for times in [[4, 0], [3, 3]] {
        let text = key_frames(&[(times[0], "", WIDE, "9 9 9"), (times[1], "", WIDE, "9 9 9")]);
        let path = file("unordered.flam3", &text);
        assert!(theirs(&[("animate", path.to_str().unwrap())]).is_empty());
        let refused = KeyFrames::new(Genome::parse_all(&text).unwrap()).unwrap_err();
        let (found, before) = (f64::from(times[1]), f64::from(times[0]));
        assert_eq!(refused, GenomeError::Order { number: 2, found, before });
    }
    assert_eq!(KeyFrames::new(Vec::new()).unwrap_err(), GenomeError::Count { found: 0 });
}
