//! The sentences of `dreams report` about flocks of a few sheep.
//!
//! Owns the claim that each of them holds, for no sheep, for one and two, and where sheep are never shown. The page itself
//! is in [`super::report`].
//!
//! Start at [`sentences`].

use super::report::{DESK, seen_by};
use claims::flocks::SMALL;
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

/// Every sentence and figure on the page of each of [`flocks`]. Those that explain a drawing are shortened: see
/// [`in_full`].
const TABLE: &str = r"# a_flock_without_sheep
There are no sheep yet: dreams add puts them in.
worst ratio: –
evenness: –
unique material: 0 s
a sheep comes back after: –
clips there: 0 of 0
footer
# a_sheep_alone
1 sheep and no transitions. No transitions lead round, so there is nothing to walk yet: a unit shows the loop of a again and again.
dead-end sheep `a` has no transition that leaves it
worst ratio: 1.00 ×
evenness: 1 of 1
unique material: 30 s
a sheep comes back after: –
clips there: 0 of 1
few: 1 sheep, no transitions. The table below tells the same in figures.
bars: 1.4 times.
The one sheep of few
footer
a; as often as wished; share: 100.0 %; want: 100.0 %; lit a day: 24.0 h; comes back after: 30 s; a visit: 30 s; leads nowhere; nothing leads to it
# a_sheep_that_leads_to_itself
1 sheep and 1 transition; a visit every 40 s, on average; always of the same sheep. It is shown as often as wished.
worst ratio: 1.00 ×
evenness: 1 of 1
unique material: 40 s
a sheep comes back after: 40 s
clips there: 0 of 2
few: 1 sheep, 1 transition. The table below tells the same in figures.
Balancing does not change the worst ratio, which is 1.
bars: 1.4 times.
dots: a walk of 5.6 days.
No transition more would bring the flock nearer to its wants than dreams balance does.
The first 24 hours of the walk with seed 1, as a unit plays them: 2,160 visits of 1 sheep. Each row is 60 min.
The one sheep of few
footer
a; as often as wished; share: 100.0 %; want: 100.0 %; lit a day: 18.0 h; comes back after: 40 s; soonest, longest: 40 s, 40 s; a visit: 30 s; leads to 1; comes from 1
# two_sheep_without_a_way_back
2 sheep and 1 transition. No transitions lead round, so there is nothing to walk yet: a unit shows the loop of a again and again.
dead-end sheep `b` has no transition that leaves it
worst ratio: a sheep is never shown
evenness: 1 of 2
unique material: 70 s
a sheep comes back after: –
clips there: 0 of 3
few: 2 sheep, 1 transition. The table below tells the same in figures.
bars: 16 times. 1 sheep is never shown.
The 2 sheep of few
footer
a; 2 times as often as wished; share: 100.0 %; want: 50.0 %; lit a day: 24.0 h; comes back after: 30 s; a visit: 30 s; leads to 1; nothing leads to it
b; never shown; share: 0 %; want: 50.0 %; lit a day: 0 s; comes back after: never; a visit: 30 s; leads nowhere; comes from 1
# two_sheep_with_nothing_to_show
2 sheep and 1 transition. No transitions lead round, so there is nothing to walk yet: a unit shows nothing.
dead-end sheep `B` has no transition that leaves it
worst ratio: a sheep is never shown
evenness: –
unique material: 10 s
a sheep comes back after: –
clips there: 0 of 1
few: 2 sheep, 1 transition. The table below tells the same in figures.
bars: 16 times. 2 sheep are never shown.
The 2 sheep of few
footer
A; never shown; share: 0 %; want: 50.0 %; lit a day: no loop; comes back after: never; leads to 1; nothing leads to it
B; never shown; share: 0 %; want: 50.0 %; lit a day: no loop; comes back after: never; leads nowhere; comes from 1
# two_sheep_in_turn
2 sheep and 2 transitions; a visit every 40 s, on average; always the same 2 sheep in the same order, for there is no choice of transitions. Every sheep is shown as often as wished.
worst ratio: 1.00 ×
evenness: 2 of 2
unique material: 80 s
a sheep comes back after: 80 s
clips there: 0 of 4
few: 2 sheep, 2 transitions. The table below tells the same in figures.
Balancing does not change the worst ratio, which is 1.
bars: 1.4 times.
dots: a walk of 5.6 days.
No transition more would bring the flock nearer to its wants than dreams balance does.
The first 24 hours of the walk with seed 1, as a unit plays them: 2,160 visits of 2 sheep. Each row is 60 min.
The 2 sheep of few
footer
a; as often as wished; share: 50.0 %; want: 50.0 %; lit a day: 9.0 h; comes back after: 80 s; soonest, longest: 80 s, 80 s; a visit: 30 s; leads to 1; comes from 1
b; as often as wished; share: 50.0 %; want: 50.0 %; lit a day: 9.0 h; comes back after: 80 s; soonest, longest: 80 s, 80 s; a visit: 30 s; leads to 1; comes from 1
# three_sheep_in_a_ring
3 sheep and 3 transitions; a visit every 40 s, on average; always the same 3 sheep in the same order, for there is no choice of transitions. Furthest from its want is c, shown 2 times less than wished.
worst ratio: 2.00 ×
evenness: 3 of 3
unique material: 2.0 min
a sheep comes back after: 2.0 min
clips there: 0 of 6
few: 3 sheep, 3 transitions. The table below tells the same in figures.
Balancing does not change the worst ratio, which is 2. No weights reach every want: 1 sheep is wanted 66.7 % of all visits, all that it leads to, 1 sheep, only 16.7 %.
bars: 2 times.
dots: a walk of 5.6 days.
No transition more would bring the flock nearer to its wants than dreams balance does.
The first 24 hours of the walk with seed 1, as a unit plays them: 2,160 visits of 3 sheep. Each row is 60 min.
The 3 sheep of few
footer
a; 2 times as often as wished; share: 33.3 %; want: 16.7 %; lit a day: 6.0 h; comes back after: 2.0 min; soonest, longest: 2.0 min, 2.0 min; a visit: 30 s; leads to 1; comes from 1
b; 2 times as often as wished; share: 33.3 %; want: 16.7 %; lit a day: 6.0 h; comes back after: 2.0 min; soonest, longest: 2.0 min, 2.0 min; a visit: 30 s; leads to 1; comes from 1
c; 2 times less than wished; share: 33.3 %; want: 66.7 %; lit a day: 6.0 h; comes back after: 2.0 min; soonest, longest: 2.0 min, 2.0 min; a visit: 30 s; leads to 1; comes from 1
# three_sheep_with_a_choice
3 sheep and 6 transitions; a visit every 40 s, on average; in a walk of 5.6 days the longest part that came twice takes about 15 min. Furthest from its want is c, shown 2 times less than wished.
worst ratio: 2.00 ×
evenness: 3 of 3
unique material: 2.5 min
a sheep comes back after: 2.0 min
clips there: 0 of 9
few: 3 sheep, 6 transitions. The table below tells the same in figures.
With the weights of dreams balance the worst ratio would be 1.67 instead of 2. No weights reach every want: 1 sheep is wanted 66.7 % of all visits, all that it leads to, 2 sheep, only 33.3 %.
bars: 2 times.
dots: a walk of 5.6 days.
No transition more would bring the flock nearer to its wants than dreams balance does.
The first 24 hours of the walk with seed 1, as a unit plays them: 2,160 visits of 3 sheep. Each row is 60 min.
The 3 sheep of few
footer
a; 2 times as often as wished; share: 33.3 %; want: 16.7 %; lit a day: 6.0 h; comes back after: 2.0 min; soonest, longest: 80 s, 4.7 min; a visit: 30 s; leads to 2; comes from 2
b; 2 times as often as wished; share: 33.3 %; want: 16.7 %; lit a day: 6.0 h; comes back after: 2.0 min; soonest, longest: 80 s, 4.7 min; a visit: 30 s; leads to 2; comes from 2
c; 2 times less than wished; share: 33.3 %; want: 66.7 %; lit a day: 6.0 h; comes back after: 2.0 min; soonest, longest: 80 s, 4.0 min; a visit: 30 s; leads to 2; comes from 2
# sheep_that_are_never_shown
5 sheep and 8 transitions; a visit every 40 s, on average; in a walk of 5.6 days the longest part that came twice takes about 15 min. 2 sheep are never shown.
unreachable sheep `d` cannot be reached from the part that is played
dead-end sheep `e` has no transition that leaves it
worst ratio: a sheep is never shown
evenness: 3 of 5
unique material: 3.8 min
a sheep comes back after: 2.0 min
clips there: 0 of 13
few: 5 sheep, 8 transitions. The table below tells the same in figures.
2 sheep are never shown, whatever the weights.
bars: 16 times. 2 sheep are never shown.
dots: a walk of 5.6 days.
suggestions
The first 24 hours of the walk with seed 1, as a unit plays them: 2,160 visits of 3 sheep. Each row is 60 min.
e to d: worst ratio 1.5; 300 frames, 10 s
d to e: worst ratio 1.22; 300 frames, 10 s
d to b: worst ratio 1.18; 300 frames, 10 s
c to e: worst ratio 1.1; 300 frames, 10 s
The 5 sheep of few
footer
a; 1.67 times as often as wished; share: 33.3 %; want: 20.0 %; lit a day: 6.0 h; comes back after: 2.0 min; soonest, longest: 80 s, 4.7 min; a visit: 30 s; leads to 3; comes from 3
b; 1.67 times as often as wished; share: 33.3 %; want: 20.0 %; lit a day: 6.0 h; comes back after: 2.0 min; soonest, longest: 80 s, 4.7 min; a visit: 30 s; leads to 2; comes from 2
c; 1.67 times as often as wished; share: 33.3 %; want: 20.0 %; lit a day: 6.0 h; comes back after: 2.0 min; soonest, longest: 80 s, 4.0 min; a visit: 30 s; leads to 2; comes from 2
d; never shown; share: 0 %; want: 20.0 %; lit a day: 0 s; comes back after: never; a visit: 30 s; leads to 1; nothing leads to it
e; never shown; share: 0 %; want: 20.0 %; lit a day: 0 s; comes back after: never; a visit: 30 s; leads nowhere; comes from 1
# sheep_that_are_stuck
4 sheep and 5 transitions; a visit every 40 s, on average; in a walk of 5.6 days the longest part that came twice takes about 72 min. d is never shown.
unreachable sheep `d` cannot be reached from the part that is played
worst ratio: a sheep is never shown
evenness: 2.8 of 4
unique material: 2.8 min
a sheep comes back after: 2.7 min
clips there: 0 of 9
few: 4 sheep, 5 transitions. The table below tells the same in figures.
d is never shown, whatever the weights. No weights reach every want: 2 sheep are wanted 50.0 % of all visits, all that they lead to, 1 sheep, only 25.0 %.
bars: 16 times. 1 sheep is never shown.
dots: a walk of 5.6 days.
suggestions
The first 24 hours of the walk with seed 1, as a unit plays them: 2,160 visits of 3 sheep. Each row is 60 min.
c to d: worst ratio 1.64; 300 frames, 10 s
b to d: worst ratio 1.37; 300 frames, 10 s
a to b: worst ratio 1.22; 300 frames, 10 s
d to b: worst ratio 1.07; 300 frames, 10 s
a to d: worst ratio 1; 300 frames, 10 s
The 4 sheep of few
footer
a; as often as wished; share: 25.0 %; want: 25.0 %; lit a day: 4.5 h; comes back after: 2.7 min; soonest, longest: 80 s, 5.3 min; a visit: 30 s; leads to 1; comes from 2
b; as often as wished; share: 25.0 %; want: 25.0 %; lit a day: 4.5 h; comes back after: 2.7 min; soonest, longest: 80 s, 6.7 min; a visit: 30 s; leads to 1; comes from 1
c; 2 times as often as wished; share: 50.0 %; want: 25.0 %; lit a day: 9.0 h; comes back after: 80 s; soonest, longest: 80 s, 80 s; a visit: 30 s; leads to 2; comes from 2
d; never shown; share: 0 %; want: 25.0 %; lit a day: 0 s; comes back after: never; a visit: 30 s; leads to 1; nothing leads to it
# weights_that_balancing_would_make_worse
3 sheep and 4 transitions; a visit every 40 s, on average; in a walk of 5.6 days the longest part that came twice takes about 1.8 h. Furthest from its want is b, shown 2.08 times as often as wished.
worst ratio: 2.08 ×
evenness: 3 of 3
unique material: 2.2 min
a sheep comes back after: 1.9 min
clips there: 0 of 7
few: 3 sheep, 4 transitions. The table below tells the same in figures.
With the weights of dreams balance the worst ratio would be 2.27, so dreams balance --write leaves the weights as they are, with 2.08. No weights reach every want: 1 sheep is wanted 66.7 % of all visits, all that it leads to, 1 sheep, only 16.7 %.
bars: 2.1 times.
dots: a walk of 5.6 days.
The transition that would bring the flock nearest to its wants, balanced by dreams balance.
The first 24 hours of the walk with seed 1, as a unit plays them: 2,160 visits of 3 sheep. Each row is 60 min.
a to c: worst ratio 1.72; 300 frames, 10 s
The 3 sheep of few
footer
a; 1.93 times less than wished; share: 34.6 %; want: 66.7 %; lit a day: 6.2 h; comes back after: 1.9 min; soonest, longest: 80 s, 2.0 min; a visit: 30 s; leads to 1; comes from 2
b; 2.08 times as often as wished; share: 34.6 %; want: 16.7 %; lit a day: 6.2 h; comes back after: 1.9 min; soonest, longest: 80 s, 2.0 min; a visit: 30 s; leads to 2; comes from 1
c; 1.85 times as often as wished; share: 30.8 %; want: 16.7 %; lit a day: 5.5 h; comes back after: 2.2 min; soonest, longest: 2.0 min, 4.7 min; a visit: 30 s; leads to 1; comes from 1
# clips_of_one_frame
3 sheep and 6 transitions; a visit every 0.03 s, on average; in a walk of 11 min the longest part that came twice takes about 1 s. Every sheep is shown as often as wished.
worst ratio: 1.00 ×
evenness: 3 of 3
unique material: 0.2 s
a sheep comes back after: 0.1 s
clips there: 0 of 6
few: 3 sheep, 6 transitions. The table below tells the same in figures.
Balancing does not change the worst ratio, which is 1.
bars: 1.4 times.
dots: a walk of 11 min.
No transition more would bring the flock nearer to its wants than dreams balance does.
The first 11 min of the walk with seed 1, as a unit plays them: 20,000 visits of 3 sheep. Each row is 28 s.
The 3 sheep of few
footer
A; as often as wished; share: 33.3 %; want: 33.3 %; lit a day: no loop; comes back after: 0.1 s; soonest, longest: 0.06 s, 0.2 s; leads to 2; comes from 2
B; as often as wished; share: 33.3 %; want: 33.3 %; lit a day: no loop; comes back after: 0.1 s; soonest, longest: 0.06 s, 0.2 s; leads to 2; comes from 2
C; as often as wished; share: 33.3 %; want: 33.3 %; lit a day: no loop; comes back after: 0.1 s; soonest, longest: 0.06 s, 0.2 s; leads to 2; comes from 2
";

/// How the sentences that explain a drawing begin in [`TABLE`], and how on the page.
const EXPLANATIONS: [(&str, &str); 4] = [
    (
        "bars: ",
        "Bars to the right are shown more often than wished, bars to the left more seldom; the end of the scale is ",
    ),
    (
        "dots: ",
        "The dot is the mean time from one visit to the next, the line runs from the soonest to the longest in ",
    ),
    (
        "suggestions",
        "Transitions that would bring the flock nearer to its wants, balanced by dreams balance. Each is the best one after \
         those above it; the worst ratio is that with all of them.",
    ),
    ("footer", "few · 1280 × 720 · 30 frames per second · drawn by dreams report"),
];

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

/// The flocks of [`TABLE`], in its order: name, manifest, and with which status the report ends.
fn flocks() -> Vec<(&'static str, String, i32)> {
    vec![
        ("a_flock_without_sheep", manifest(&[], &[], 300), 0),
        ("a_sheep_alone", manifest(&[("a", 1.0)], &[], 300), 1),
        ("a_sheep_that_leads_to_itself", manifest(&[("a", 1.0)], &["aa"], 300), 0),
        ("two_sheep_without_a_way_back", manifest(&[("a", 1.0), ("b", 1.0)], &["ab"], 300), 1),
        ("two_sheep_with_nothing_to_show", manifest(&[("A", 1.0), ("B", 1.0)], &["AB"], 300), 1),
        ("two_sheep_in_turn", manifest(&[("a", 1.0), ("b", 1.0)], &["ab", "ba"], 300), 0),
        ("three_sheep_in_a_ring", manifest(&[("a", 1.0), ("b", 1.0), ("c", 4.0)], &["ab", "bc", "ca"], 300), 0),
        (
            "three_sheep_with_a_choice",
            manifest(&[("a", 1.0), ("b", 1.0), ("c", 4.0)], &["ab", "bc", "ca", "ba", "cb", "ac"], 300),
            0,
        ),
        (
            "sheep_that_are_never_shown",
            manifest(
                &[("a", 1.0), ("b", 1.0), ("c", 1.0), ("d", 1.0), ("e", 1.0)],
                &["ab", "bc", "ca", "ba", "cb", "ac", "da", "ae"],
                300,
            ),
            1,
        ),
        (
            "sheep_that_are_stuck",
            manifest(&[("a", 1.0), ("b", 1.0), ("c", 1.0), ("d", 1.0)], &["ac", "bc", "ca", "cb", "da"], 300),
            1,
        ),
        (
            "weights_that_balancing_would_make_worse",
            manifest(&[("a", 4.0), ("b", 1.0), ("c", 1.0)], &["ab", "ba", "bc", "ca"], 300)
                .replace("clip = \"bc\"", "clip = \"bc\"\nweight = 8"),
            0,
        ),
        (
            "clips_of_one_frame",
            manifest(&[("A", 1.0), ("B", 1.0), ("C", 1.0)], &["AB", "BC", "CA", "BA", "CB", "AC"], 1),
            0,
        ),
    ]
}

/// A line of [`TABLE`] as it is on the page.
fn in_full(line: &str) -> String {
    let full = EXPLANATIONS.iter().find_map(|(short, full)| Some(format!("{full}{}", line.strip_prefix(short)?)));
    full.unwrap_or_else(|| line.to_owned())
}

#[test]
fn every_sentence_of_a_report_holds_for_the_smallest_and_the_oddest_flocks() {
    for (name, manifest, status) in flocks() {
        let part = TABLE.split("# ").find_map(|part| part.strip_prefix(name)?.strip_prefix('\n'));
        let expected: Vec<String> = part.expect("every flock is in the table").lines().map(in_full).collect();
        assert_eq!(sentences(&manifest, status), expected, "{name}");
    }
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
