//! Claims about manifests: what they may say, how the two ways of reading agree, and how much a unit reads.
//!
//! Owns small manifests with their defects, and large ones. Never measures memory: that is in
//! `tests/it/updates/memory_limits.rs`.

use super::{
    ClipHash, FILE_NAME, FrameCount, Manifest, ManifestError, Path, Source, UNIT_BYTES, UNIT_DOCUMENT_BYTES, parsed,
    plain,
};
use proptest::prelude::*;

const HEAD: &str = "format = 1\nname = \"aurora\"\nsize = [1280, 720]\nfps = [30000, 1001]\n";

fn parse(text: &str) -> Result<Manifest, ManifestError> {
    Manifest::parse(text, Path::new("aurora/flock.toml"))
}

fn said(body: &str) -> String {
    parse(&format!("{HEAD}{body}")).unwrap_err().to_string()
}

#[test]
fn every_key_of_the_contract_is_read() {
    let hash = ClipHash::of(&b"x"[..]).unwrap();
    let text = format!(
        "{HEAD}[[sheep]]\nid = \"a\"\nframes = 768\nclip = \"loops/a.mp4\"\ngenome = \"genomes/a.flam3\"\n\
         hash = \"{hash}\"\nwant = 2\nrepeat = 3\n[[sheep]]\nid = \"b\"\n\
         [[transition]]\nfrom = \"a\"\nto = \"b\"\nframes = 384\nclip = \"t/a=b.mp4\"\nweight = 0.25\n"
    );
    let flock = parse(&text).unwrap();
    assert_eq!((flock.name.as_str(), flock.size, flock.fps.den()), ("aurora", (1280, 720), 1001));
    let a = &flock.sheep[0];
    assert_eq!((a.want, a.repeat, a.clip.as_ref().unwrap().hash), (2.0, 3, Some(hash)));
    assert_eq!(flock.sheep[1].clip, None);
    assert_eq!((flock.transitions[0].weight, flock.transitions[0].clip.frames), (0.25, FrameCount(384)));
    assert_eq!(flock.clips().count(), 2);
}

#[test]
fn refusals_name_file_line_key_and_both_values() {
    assert_eq!(
        said("[[sheep]]\nid = \"a\"\nwant = -1.5\n"),
        "`aurora/flock.toml`, line 7, key `want`: wanted a finite number above 0, found `-1.5`"
    );
    assert_eq!(
        said("[[sheep]]\nid = \"a b\"\n"),
        "`aurora/flock.toml`, line 6, key `id`: wanted 1 to 64 of `A-Z a-z 0-9 . _ -`, found `a b`"
    );
    assert_eq!(
        said("[[sheep]]\nid = \"a\"\nwnat = 1\n"),
        "`aurora/flock.toml`, line 7: unknown key `wnat` in [[sheep]], which has `id`, `frames`, `clip`, `hash`, \
         `genome`, `want`, `repeat`"
    );
    assert_eq!(
        said("[[sheep]]\nid = \"a\"\nframes = 7\n"),
        "`aurora/flock.toml`, line 5: the key `clip` is missing from [[sheep]]"
    );
}

#[test]
fn values_outside_their_limits_are_refused() {
    for (body, part) in [
        ("[[sheep]]\nid = 7\n", "key `id`: wanted a text in quotes, found `7`"),
        ("[[sheep]]\nid = \"a\"\nrepeat = 0\n", "found `0`"),
        ("[[sheep]]\nid = \"a\"\nclip = \"../a.mp4\"\nframes = 1\n", "found `../a.mp4`"),
        ("[[sheep]]\nid = \"a\"\nclip = \"a.mp4\"\nframes = 0\n", "key `frames`"),
        ("[[sheep]]\nid = \"a\"\nclip = \"a.mp4\"\nframes = 4294967296\n", "found `4294967296`"),
        ("[[sheep]]\nid = \"a\"\nwant = nan\n", "found `nan`"),
        ("[[sheep]]\nid = \"a\"\nwant = inf\n", "found `inf`"),
        ("[[sheep]]\nid = \"a\"\nhash = \"b3:00\"\n", "`frames` is missing"),
        ("[[sheep]]\nid = \"a\"\n[[transition]]\nfrom = \"a\"\nto = \"a\"\nframes = 1\n", "`clip` is missing"),
        ("[[sheep]]\nid = \"a\"\nid = \"b\"\n", "key `id`: not TOML"),
        ("[[sheep]]\nid = \n", "key `id`: not TOML"),
        ("", "the key `sheep` is missing"),
        ("sheep = []", "the key `sheep` is missing"),
        ("sheep = 3", "wanted tables, each headed [[sheep]], found `3`"),
    ] {
        let said = said(body);
        assert!(said.contains(part), "{body:?} said {said:?}");
    }
}

#[test]
fn sizes_are_even_and_rates_are_rates() {
    let with = |size: &str, fps: &str| {
        parse(&format!("format = 1\nname = \"x\"\nsize = {size}\nfps = {fps}\n[[sheep]]\nid = \"a\"\n"))
    };
    assert!(with("[1280, 720]", "[24000, 1001]").is_ok());
    for (size, fps) in [
        ("[1281, 720]", "[30, 1]"),
        ("[0, 720]", "[30, 1]"),
        ("[1280, 99998]", "[30, 1]"),
        ("[1280]", "[30, 1]"),
        ("\"1280x720\"", "[30, 1]"),
        ("[1280, 720]", "[0, 1]"),
        ("[1280, 720]", "[30, 0]"),
        ("[1280, 720]", "[1000, 1]"),
        ("[1280, 720]", "30"),
    ] {
        assert!(with(size, fps).is_err(), "{size} {fps}");
    }
}

#[test]
fn a_key_that_is_mistyped_is_proposed_as_it_is_meant() {
    let hint = |body: &str| parse(&format!("{HEAD}{body}")).unwrap_err().hint();
    assert_eq!(hint("[[sheep]]\nid = \"a\"\nwnat = 1\n").as_deref(), Some("did you mean `want`?"));
    assert_eq!(hint("[[sheep]]\nid = \"a\"\ncolour = 1\n"), None);
    let missing = hint("[[sheep]]\nid = \"a\"\nframs = 7\nclip = \"a\"\n");
    assert_eq!(missing.as_deref(), Some("there is `frams`: did you mean `frames`?"));
    // In a form that is read as a TOML document, too.
    let inline = hint("sheep = [{ id = \"a\", rapeat = 1 }]\n");
    assert_eq!(inline.as_deref(), Some("did you mean `repeat`?"));
}

#[test]
fn a_folder_without_a_manifest_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let error = Manifest::read(folder.path()).unwrap_err();
    assert!(error.to_string().ends_with("flock.toml`"), "{error}");
    assert!(error.hint().is_some());
}

/// Tables that are fine as they stand, their lines in any order.
fn table() -> impl Strategy<Value = Vec<&'static str>> {
    let sheep = vec!["id = \"a\"", "frames = 7", "clip = \"a.mp4\"", "want = 2.5e-1", "repeat = 3 # thrice"];
    let way = vec!["from = \"a\"", "to = \"b\"", "frames = 7", "  clip\t= \"a.mp4\"\t", "weight = 3", ""];
    let headed = |header, lines: Vec<&'static str>| {
        Just(lines).prop_shuffle().prop_map(move |lines| [vec![header], lines].concat())
    };
    prop_oneof![headed("[[sheep]]", sheep), headed("[[transition]] # on", way)]
}

/// Lines that are not plain, or wrong, or wrong where they stand.
const ODD: &[&str] = &[
    "id = \"b\"",
    "clip = \"b.mp4\"",
    "want = 1",
    "frames = 9",
    "repeat = 2",
    "weight = 1",
    "hash = \"b3:00\"",
    "# a comment",
    "# a bell \u{7}",
    "#\u{7f}",
    "want = 1_000",
    "want = +1.0",
    "want = 0x10",
    "want = 01",
    "want = 1.",
    "want = .5",
    "want = 1e400",
    "want = 5e-324",
    "want = nan",
    "want = 1.0 x",
    "want = 1\r",
    "want = 1.0e",
    "want = \"1\"",
    "id = 'a'",
    "id = \"\\u0061\"",
    "id = \"\"\"a\"\"\"",
    "id = \"\"",
    "id = \"a",
    "\"id\" = \"a\"",
    "a.b = 1",
    "id",
    "= 7",
    "[sheep]",
    "[ [sheep]]",
    "[[ sheep ]]",
    "[[sheep.kid]]",
    "[[other]]",
    "[[sheep]] x\nid = \"c\"",
    "[[sheep]",
    "x = 7 = 7",
    "\u{feff}",
    "name = \"x\"",
    "format = 1",
    "genome = \"ä\"",
    "genome = \"a\tb\"",
    "\u{a0}want = 1",
    "want = 1,",
    "want = 1]",
];

proptest! {
    #![proptest_config(ProptestConfig { cases: 4000, ..ProptestConfig::default() })]

    #[test]
    fn what_is_read_in_place_is_what_the_parser_reads(
        tables in prop::collection::vec(table(), 0..4),
        odd in prop::collection::vec((prop::sample::select(ODD), any::<prop::sample::Index>()), 0..3),
        end in prop_oneof![Just("\n"), Just("\r\n"), Just("")],
    ) {
        let mut lines: Vec<&str> = HEAD.lines().chain(["[[sheep]]", "id = \"b\""]).chain(tables.concat()).collect();
        for (line, at) in odd {
            lines.insert(at.index(lines.len() + 1), line);
        }
        let text = lines.join("\n") + end;
        let source = Source { path: Path::new("flock.toml"), text: &text };
        if let Ok(manifest) = plain(source, u64::MAX) {
            prop_assert_eq!(Some(manifest), parsed(source).ok(), "{}", text);
        }
    }
}

#[test]
fn a_manifest_of_the_contract_is_read_in_place() {
    let body = "# all\n[[sheep]]\nid = \"a\"\nframes = 768\nclip = \"loops/a.mp4\"\nwant = 1.5 # more\n\n\
                [[transition]]\n  from = \"a\"\n  to = \"a\"\n  frames = 3\n  clip = \"t/a.mp4\"";
    for text in [format!("{HEAD}{body}"), format!("{HEAD}{body}\n")] {
        let source = Source { path: Path::new("flock.toml"), text: &text };
        let manifest = plain(source, u64::MAX).unwrap_or_else(|_| panic!("it is plain"));
        assert_eq!((manifest.sheep.len(), manifest.transitions.len()), (1, 1));
        assert_eq!(manifest, parsed(source).unwrap());
    }
}

#[test]
fn an_error_tells_the_beginning_of_what_stands_there_and_nothing_that_a_terminal_would_obey() {
    let long = "x".repeat(200);
    let cut = "x".repeat(80);
    for (body, part) in [
        (format!("[[sheep]]\nid = \"a {long}\"\n"), format!("found `a {}...", "x".repeat(77))),
        (format!("[[sheep]]\nid = \"a\"\nwant = \"{long}\"\n"), format!("found `\"{}...`", "x".repeat(79))),
        (format!("[[sheep]]\nid = \"a\"\n{long} = 1\n"), format!("unknown key `{cut}...`")),
        (format!("[[sheep]]\nid = \"a\"\n{long}\n"), format!("key `{cut}...`: not TOML")),
        (
            "[[sheep]]\nid = \"a\"\n\"b\\u001b[2J\\n\u{202e}\" = 1\n".to_owned(),
            "unknown key `b\\u{1b}[2J\\u{a}\\u{202e}`".to_owned(),
        ),
        ("[[sheep]]\nid = \"a\\u001b\\nb\"\n".to_owned(), "found `a\\u{1b}\\u{a}b`".to_owned()),
    ] {
        let said = said(&body);
        assert!(said.contains(&part) && said.len() < 500, "{body:?} said {said:?}, wanted {part:?}");
    }
}

/// A manifest of `bytes` bytes at most, of lines like `line` behind the first sheep.
fn filled(bytes: u64, line: &str) -> String {
    let begun = format!("{HEAD}[[sheep]]\nid = \"a\"\n");
    begun.clone() + &line.repeat((bytes as usize - begun.len()) / line.len())
}

fn said_on_unit(text: &str) -> Option<String> {
    Manifest::parse_on_unit(text, Path::new("flock.toml")).err().map(|error| error.to_string())
}

#[test]
fn a_unit_reads_so_many_plain_bytes_and_no_more() {
    let comment = "# so that it is as long as it may be\n";
    let sheep = filled(UNIT_BYTES, "[[sheep]]\nid = \"b\"\n");
    let most = sheep.clone() + &"\n".repeat(UNIT_BYTES as usize - sheep.len());
    assert_eq!(said_on_unit(&most), None);
    assert_eq!(said_on_unit(&filled(UNIT_BYTES, comment)), None);
    let more = most + "\n";
    let told = format!("`flock.toml` is too large: {} bytes, a unit reads {UNIT_BYTES} at most", UNIT_BYTES + 1);
    assert_eq!(said_on_unit(&more), Some(told));
    assert!(parse(&more).is_ok(), "the artist's tools go on");
}

#[test]
fn a_unit_builds_no_large_document() {
    let odd = "want = 1_0\n";
    let small = filled(UNIT_DOCUMENT_BYTES - odd.len() as u64, "# as long as it may be\n") + odd;
    assert!(small.len() as u64 <= UNIT_DOCUMENT_BYTES && said_on_unit(&small).is_none());
    let large = filled(2 * UNIT_DOCUMENT_BYTES, "# longer\n") + odd;
    let line = large.lines().count();
    let told = |line: usize, bytes: usize| {
        format!(
            "`flock.toml`, line {line}: not in the plain form that `dreams` writes, so {UNIT_DOCUMENT_BYTES} bytes at most \
             are read; found {bytes}"
        )
    };
    assert_eq!(said_on_unit(&large), Some(told(line, large.len())));
    // The head is a document, however plain the rest is.
    let head = format!("{HEAD}{}", "# a long word\n".repeat(10_000));
    assert_eq!(said_on_unit(&format!("{head}[[sheep]]\nid = \"a\"\n")), Some(told(1, head.len())));
    // Where lines end as on Windows, none is plain.
    let windows = filled(2 * UNIT_DOCUMENT_BYTES, "# longer\n").replace('\n', "\r\n");
    assert_eq!(said_on_unit(&windows), Some(told(1, windows.len())));
    // More keys than any table has are not looked through again for each.
    let keys: Vec<String> = (0..100_000).map(|key| format!("k{key} = 1\n")).collect();
    let many = filled(1_000, "# a word\n") + &keys.concat();
    assert!(said_on_unit(&many).is_some_and(|said| said.contains("plain form")));
    for text in [large, windows] {
        assert!(parse(&text).is_ok(), "the artist's tools go on");
    }
}

#[test]
fn what_is_wrong_in_a_large_manifest_is_named_as_in_a_small_one() {
    for (odd, part) in [
        ("[[sheep]]\nid = \"a b\"\n", "key `id`: wanted 1 to 64 of"),
        ("[[sheep]]\nid = \"c\"\nwant = 0\n", "key `want`: wanted a finite number above 0, found `0`"),
        ("[[sheep]]\nwant = 1\n", "the key `id` is missing"),
    ] {
        let text = filled(2 * UNIT_DOCUMENT_BYTES, "# longer\n") + odd;
        let said = said_on_unit(&text).unwrap();
        assert!(said.contains(part) && said.contains("line "), "{said}");
        assert_eq!(said, parse(&text).unwrap_err().to_string().replace("aurora/", ""));
    }
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join(FILE_NAME), "#".repeat(UNIT_BYTES as usize + 1)).unwrap();
    assert!(
        matches!(Manifest::read_on_unit(folder.path()), Err(ManifestError::TooLarge { bytes, .. }) if bytes > UNIT_BYTES)
    );
}
