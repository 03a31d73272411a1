//! The sentences of `dreams report` about flocks of a few sheep.
//!
//! Owns the claim that each of them holds, for no sheep, for one and two, and where sheep are never shown: every sentence and
//! figure of each page is in a file of `tests/fixtures/sentences`. The page itself is in [`super::report`].
//!
//! Start at [`sentences`].

use super::report::{DESK, seen_by};
use claims::flocks::SMALL;
use claims::programs::repository;
use claims::report::{report, written};
use std::fs;

/// Answers with every sentence and figure on the page, in its order; then those about each sheep.
const PROBE: &str = r"<body><script>
  const complaints = []
  addEventListener('error', event => complaints.push(String(event.message ?? event.target)), true)
  addEventListener('load', () => {
    const all = selector => [...document.querySelectorAll(selector)].filter(element => !element.closest('[hidden]'))
    const texts = (...selectors) => selectors.flatMap(selector => all(selector).map(element => element.textContent))
    const pairs = selector => all(selector).map(name => `${name.textContent}: ${name.nextElementSibling.textContent}`)
    const page = [...texts('#lead', '#faults li'), ...pairs('#figures dt'),
      ...texts('#graph-title', '.note', '#suggested li', 'caption', 'footer')]
    const panels = all('.disc').map(disc => {
      disc.dispatchEvent(new MouseEvent('click', { bubbles: true }))
      return [...texts('#panel .id', '#panel .against'), ...pairs('#panel dt'), ...texts('#panel h3:not(.id)')].join('; ')
    })
    const images = all('img')
    const probe = document.createElement('pre')
    probe.id = 'probe'
    probe.textContent = JSON.stringify({
      complaints, page, panels, asked: [], broken: 0, silent: 0, foreign: 0,
      wide: document.documentElement.scrollWidth > innerWidth,
    })
    document.body.append(probe)
  })
</script>";

/// A manifest: sheep by their ids, those with a capital letter without a loop; `arcs` as `ab`, from `a` to `b`. Loops take
/// 30 seconds, transitions as many frames as are given, of 30 a second.
fn manifest(sheep: &[(&str, f64)], arcs: &[&str], frames: u32) -> String {
    let mut text = "format = 1\nname = \"few\"\nsize = [1280, 720]\nfps = [30, 1]\n".to_owned();
    for (id, want) in sheep {
        let clip =
            if id.starts_with(char::is_uppercase) { String::new() } else { format!("frames = 900\nclip = \"{id}\"\n") };
        text = format!("{text}[[sheep]]\nid = \"{id}\"\nwant = {want:?}\n{clip}");
    }
    for (from, to) in arcs.iter().map(|arc| arc.split_at(1)) {
        text = format!(
            "{text}[[transition]]\nfrom = \"{from}\"\nto = \"{to}\"\nframes = {frames}\nclip = \"{from}{to}\"\n"
        );
    }
    text
}

/// Every sentence and figure on the page about this flock, then those about each sheep, with plain spaces.
fn sentences(manifest: &str, status: i32) -> Vec<String> {
    let folder = written(manifest);
    let (_scratch, page) = report(folder.path(), status);
    let told = seen_by(PROBE, &page, DESK);
    let list = |part: &str| {
        let texts = told[part].as_array().unwrap().iter().map(|text| text.as_str().unwrap().replace('\u{a0}', " "));
        texts.collect::<Vec<_>>()
    };
    [list("page"), list("panels")].concat()
}

/// The flocks of the fixtures: name, manifest, and with which status the report ends.
fn flocks() -> Vec<(&'static str, String, i32)> {
    vec![
        ("a-flock-without-sheep", manifest(&[], &[], 300), 0),
        ("a-sheep-alone", manifest(&[("a", 1.0)], &[], 300), 1),
        ("a-sheep-that-leads-to-itself", manifest(&[("a", 1.0)], &["aa"], 300), 0),
        ("two-sheep-without-a-way-back", manifest(&[("a", 1.0), ("b", 1.0)], &["ab"], 300), 1),
        ("two-sheep-with-nothing-to-show", manifest(&[("A", 1.0), ("B", 1.0)], &["AB"], 300), 1),
        ("two-sheep-in-turn", manifest(&[("a", 1.0), ("b", 1.0)], &["ab", "ba"], 300), 0),
        ("three-sheep-in-a-ring", manifest(&[("a", 1.0), ("b", 1.0), ("c", 4.0)], &["ab", "bc", "ca"], 300), 0),
        (
            "three-sheep-with-a-choice",
            manifest(&[("a", 1.0), ("b", 1.0), ("c", 4.0)], &["ab", "bc", "ca", "ba", "cb", "ac"], 300),
            0,
        ),
        (
            "sheep-that-are-never-shown",
            manifest(
                &[("a", 1.0), ("b", 1.0), ("c", 1.0), ("d", 1.0), ("e", 1.0)],
                &["ab", "bc", "ca", "ba", "cb", "ac", "da", "ae"],
                300,
            ),
            1,
        ),
        (
            "sheep-that-are-stuck",
            manifest(&[("a", 1.0), ("b", 1.0), ("c", 1.0), ("d", 1.0)], &["ac", "bc", "ca", "cb", "da"], 300),
            1,
        ),
        (
            "weights-that-balancing-would-make-worse",
            manifest(&[("a", 4.0), ("b", 1.0), ("c", 1.0)], &["ab", "ba", "bc", "ca"], 300)
                .replace("clip = \"bc\"", "clip = \"bc\"\nweight = 8"),
            0,
        ),
        (
            "clips-of-one-frame",
            manifest(&[("A", 1.0), ("B", 1.0), ("C", 1.0)], &["AB", "BC", "CA", "BA", "CB", "AC"], 1),
            0,
        ),
    ]
}

#[test]
fn every_sentence_of_a_report_holds_for_the_smallest_and_the_oddest_flocks() {
    let fixtures = repository().join("tests/fixtures/sentences");
    for (name, manifest, status) in flocks() {
        let expected = fs::read_to_string(fixtures.join(name).with_extension("txt")).unwrap();
        assert_eq!(sentences(&manifest, status), expected.lines().collect::<Vec<_>>(), "{name}");
    }
    assert_eq!(fs::read_dir(fixtures).unwrap().count(), flocks().len(), "each file is about one of the flocks");
}

#[test]
fn one_join_is_told_as_one() {
    let folder = tempfile::tempdir().unwrap();
    let small = SMALL.flock();
    let text = fs::read_to_string(small.folder.join("flock.toml")).unwrap();
    let one = text.split_once("[[sheep]]\nid = \"s1\"").expect("s0 comes first").0;
    fs::write(folder.path().join("flock.toml"), one).unwrap();
    fs::copy(small.folder.join("s0.mp4"), folder.path().join("s0.mp4")).unwrap();
    let (_scratch, page) = report(folder.path(), 1);
    let told = seen_by(PROBE, &page, DESK)["page"].to_string();
    let ways = [
        "The one join jumps. Below is the worst: the last frame of the one clip, the first of the next, and how much of what \
         is allowed it takes.",
        "The one join meets. Below is the one that comes nearest to a jump: the last frame of the one clip, the first of the \
         next, and how much of what is allowed it takes.",
    ];
    assert!(ways.iter().any(|way| told.contains(way)), "{told}");
}
