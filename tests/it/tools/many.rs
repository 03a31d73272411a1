//! Many sheep are handled by one command.
//!
//! Owns the claims on ids and globs of the editing commands, on `dreams list`, `prune`, `repeat` and `weight`, and on
//! balances by time. Clips are never opened, but where `dreams check` looks for them.

use crate::tools::curation::FlockFolder;
use claims::programs::{self, output};
use serde_json::{Value, json};
use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::fs;
use std::process::{Command, Stdio};

const HEAD: &str = "format = 1\nname = \"many\"\nsize = [64, 64]\nfps = [30, 1]\n";

fn sheep(id: &str) -> String {
    format!("\n[[sheep]]\nid = \"{id}\"\nframes = 300\nclip = \"loops/{id}.mp4\"\n")
}

fn transition(from: &str, to: &str) -> String {
    let clip = format!("frames = 200\nclip = \"transitions/{from}={to}.mp4\"");
    format!("\n[[transition]]\nfrom = \"{from}\"\nto = \"{to}\"\n{clip}\n")
}

/// A flock of these sheep and transitions.
fn flock(ids: &[&str], arcs: &[(&str, &str)]) -> FlockFolder {
    let all = ids.iter().map(|id| sheep(id)).chain(arcs.iter().map(|(from, to)| transition(from, to)));
    FlockFolder::of(&all.fold(HEAD.to_owned(), |text, entry| text + &entry))
}

/// A flock whose hub is linked to each of `count` sheep, there and back; their ids start with `24.`.
fn star(count: usize) -> FlockFolder {
    let mut text = format!("{HEAD}{}", sheep("hub"));
    (0..count).for_each(|at| text += &sheep(&format!("24.{at:04}")));
    for at in 0..count {
        let id = format!("24.{at:04}");
        write!(text, "{}{}", transition("hub", &id), transition(&id, "hub")).unwrap();
    }
    FlockFolder::of(&text)
}

fn words(value: &Value) -> Vec<&str> {
    value.as_array().unwrap().iter().map(|word| word.as_str().unwrap()).collect()
}

/// The ids of the sheep that `dreams list` names.
fn listed(flock_folder: &FlockFolder, options: &[&str]) -> Vec<String> {
    let answer = flock_folder.answers(0, "list", options);
    answer["sheep"].as_array().unwrap().iter().map(|row| row["id"].as_str().unwrap().to_owned()).collect()
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is no number"))
}

#[test]
fn a_thousand_ids_by_a_glob_are_one_edit() {
    let flock_folder = star(1000);
    let before = flock_folder.manifest();
    let mut want = Command::new(programs::dreams());
    want.arg("want").arg(flock_folder.folder()).args(["24.*", "2"]).stdout(Stdio::piped());
    let mut running = want.spawn().unwrap();
    let mut seen = BTreeSet::new();
    while running.try_wait().unwrap().is_none() {
        seen.insert(flock_folder.manifest());
    }
    let said = running.wait_with_output().unwrap();
    assert!(String::from_utf8(said.stdout).unwrap().starts_with("1000 sheep have want 2\n"));
    let after = flock_folder.manifest();
    let expected = before.replace(".mp4\"\n\n[[sheep]]", ".mp4\"\nwant = 2.0\n\n[[sheep]]");
    let expected = expected.replacen("hub.mp4\"\nwant = 2.0\n", "hub.mp4\"\n", 1);
    let expected = expected.replacen("24.0999.mp4\"\n\n[[tr", "24.0999.mp4\"\nwant = 2.0\n\n[[tr", 1);
    assert_eq!(after, expected, "a line for each, and nothing else");
    seen.extend([before.clone(), after]);
    assert_eq!(seen.len(), 2, "no other text was ever there");
    // The same for transitions and whole sheep.
    assert!(flock_folder.fine(&["weight", "hub", "*", "3"], &[]).starts_with("1000 transitions have weight 3\n"));
    assert!(flock_folder.fine(&["unlink", "24.09*", "hub", "--force"], &[]).starts_with("took out 100 transitions\n"));
    let dropped = flock_folder.fine(&["drop", "24.0*", "--force"], &[]);
    assert!(dropped.starts_with("dropped 1000 sheep and 1900 transitions\n"), "{dropped}");
    assert_eq!(flock_folder.manifest(), format!("{HEAD}{}", sheep("hub")));
}

#[test]
fn what_names_nothing_is_told_and_nothing_changes() {
    let flock_folder = flock(&["a.1", "a.2", "b"], &[("a.1", "a.2"), ("a.2", "a.1"), ("a.1", "b"), ("b", "a.1")]);
    let before = flock_folder.manifest();
    for (command, words, told) in [
        ("drop", &["a.1", "zz*"][..], "no sheep matches `zz*`"),
        ("drop", &["a.[0-9"], "glob `a.[0-9` is malformed"),
        ("want", &["a*", "nobody", "2"], "sheep `nobody` is not in the flock"),
        ("want", &["a*", "b"], "`b` is no want: wanted a finite number above 0"),
        ("want", &["a b", "2"], "wanted 1 to 64 of `A-Z a-z 0-9 . _ -`, found `a b`"),
        ("repeat", &["a*", "0"], "`0` is no number of loops: wanted a whole number from 1 to 10000"),
        ("repeat", &["a*", "1.5"], "`1.5` is no number of loops"),
        ("want", &["2"], "no sheep is named before the want `2`"),
        ("want", &["b"], "`b` is no want"),
        ("weight", &["b", "a.2", "2"], "there is no transition from `b` to `a.2`"),
        ("weight", &["b", "?", "2"], "from `b` to `?` there is no transition"),
        ("unlink", &["a.1", "a.2,a.1", "--force"], "there is no transition from `a.1` to `a.1`"),
        ("unlink", &["b", "b*"], "from `b` to `b*` there is no transition"),
        ("link", &["a.1", "?*"], "from `a.1` to `?*` there is no new pair"),
        ("link", &["*", "*", "--clip", "x.mp4"], "clip `x.mp4` is for one transition, found 2"),
        ("list", &["c*"], "no sheep matches `c*`"),
        ("prune", &["--keep", "c"], "sheep `c` is not in the flock"),
    ] {
        let said = flock_folder.says(2, &[command], words);
        assert!(said.contains("error: ") && said.contains(told), "{command} {words:?}: {said}");
        assert_eq!(flock_folder.manifest(), before, "{command} {words:?}");
    }
    let said = flock_folder.says(1, &["drop"], &["a.1", "b,a.2"]);
    assert!(said.contains("without 3 sheep, the flock would have no sheep"), "{said}");
}

#[test]
fn several_are_linked_and_unlinked_at_once_and_the_old_forms_stay() {
    let flock_folder = flock(&["a.1", "a.2", "a.3", "b"], &[("a.1", "b"), ("b", "a.1")]);
    let before = flock_folder.manifest();
    let said = flock_folder.fine(&["link", "a.*", "b"], &["--frames", "100"]);
    assert!(said.starts_with("linked 2 pairs\n"), "{said}");
    assert!(said.contains("note: 1 pair passed over: linked already, or a sheep with itself"), "{said}");
    flock_folder.fine(&["link", "b", "a.2", "a.3"], &["--weight", "2"]);
    let text = flock_folder.manifest();
    assert!(text.starts_with(before.trim_end()), "new transitions stand below the others");
    for pair in ["from = \"a.2\"\nto = \"b\"", "from = \"b\"\nto = \"a.3\""] {
        assert_eq!(text.matches(pair).count(), 1, "{pair}");
    }
    // All to all: six of twelve pairs are new, and no sheep is linked to itself.
    assert!(flock_folder.fine(&["link", "*", "*"], &[]).starts_with("linked 6 pairs\n"));
    let said = flock_folder.fine(&["link", "b", "b"], &[]);
    assert!(said.starts_with("linked `b` to `b`: `transitions/b=b.mp4`, 384 frames\n"), "{said}");
    let said = flock_folder.fine(&["unlink", "a.1,a.2,a.3", "a.[1-3]"], &[]);
    assert!(said.starts_with("took out 6 transitions\n"), "{said}");
    assert!(flock_folder.fine(&["unlink", "b", "b"], &[]).starts_with("unlinked `b` from `b`\n"));
    assert!(flock_folder.fine(&["unlink", "*", "a.2", "a.3"], &["--force"]).starts_with("took out 2 transitions\n"));
    assert!(flock_folder.fine(&["unlink", "a.2,a.3", "b", "--force"], &[]).starts_with("took out 2 transitions\n"));
    assert_eq!(flock_folder.manifest(), before);
    // Options stand anywhere.
    let said =
        output(Command::new(programs::dreams()).args(["want", "--json"]).arg(flock_folder.folder()).args(["b", "3"]));
    assert!(said.status.success(), "{}", String::from_utf8_lossy(&said.stderr));
    let said =
        output(Command::new(programs::dreams()).arg("want").arg(flock_folder.folder()).args(["b", "--json", "1"]));
    assert!(said.status.success(), "{}", String::from_utf8_lossy(&said.stderr));
}

#[test]
fn repeats_and_weights_are_set_in_place() {
    let odd = fs::read_to_string(programs::repository().join("crates/flock/src/edit/tests/odd.toml")).unwrap();
    let flock_folder = FlockFolder::of(&odd);
    let said = flock_folder.fine(&["repeat", "b", "3"], &[]);
    assert!(said.starts_with("`b` has repeat 3, was 1\n"), "{said}");
    assert_eq!(flock_folder.manifest(), odd.replace("want   = 0.5\n", "want   = 0.5\nrepeat = 3\n"));
    let said = flock_folder.fine(&["weight", "a.1", "b", "5"], &[]);
    assert!(said.starts_with("`a.1` to `b` has weight 5, was 2\n"), "{said}");
    let expected = odd.replace("want   = 0.5\n", "want   = 0.5\nrepeat = 3\n").replace("2_0e-1 #", "5.0 #");
    assert_eq!(flock_folder.manifest(), expected);
    let said = flock_folder.fine(&["repeat", "*", "2"], &[]);
    assert!(said.starts_with("3 sheep have repeat 2\n"), "{said}");
    let repeats = listed_repeats(&flock_folder);
    assert_eq!(repeats, [2, 2, 2]);
}

fn listed_repeats(flock_folder: &FlockFolder) -> Vec<u64> {
    let answer = flock_folder.answers(0, "list", &[]);
    answer["sheep"].as_array().unwrap().iter().map(|row| row["repeat"].as_u64().unwrap()).collect()
}

#[test]
fn sheep_are_listed_by_what_is_wrong_with_them() {
    // A ring of three; a way out of it, a way into it, a pair by itself and a sheep that nothing leads to or from.
    let arcs = [("a", "b"), ("b", "c"), ("c", "a"), ("c", "out"), ("in", "a"), ("p", "q"), ("q", "p")];
    let flock_folder = flock(&["a", "b", "c", "in", "lone", "out", "p", "q"], &arcs);
    flock_folder.fine(&["want", "a", "6"], &[]);
    fs::create_dir(flock_folder.folder().join("loops")).unwrap();
    for id in ["a", "b", "out"] {
        fs::write(flock_folder.folder().join(format!("loops/{id}.mp4")), "a clip").unwrap();
    }
    let listed = |options: &[&str]| listed(&flock_folder, options).join(" ");
    assert_eq!(listed(&[]), "a b c in lone out p q");
    assert_eq!(listed(&["--unreachable"]), "in lone p q");
    assert_eq!(listed(&["--unplayed"]), "in lone out p q");
    assert_eq!(listed(&["--loose"]), "in lone out");
    assert_eq!(listed(&["--unrendered"]), "c in lone p q");
    assert_eq!(listed(&["--loose", "--unrendered"]), "in lone");
    assert_eq!(listed(&["--above", "2"]), "b c");
    assert_eq!(listed(&["--below", "0.9"]), "a in lone out p q");
    assert_eq!(listed(&["[a-c]", "--below", "0.9"]), "a");
    // As `dreams check` has it.
    let faults = flock_folder.answers(1, "check", &[]);
    let of = |kind: &str| {
        let faults = faults["faults"].as_array().unwrap().iter().filter(|fault| fault["kind"] == kind);
        faults.map(|fault| fault["sheep"].as_str().unwrap().to_owned()).collect::<BTreeSet<_>>()
    };
    assert_eq!(of("unreachable"), BTreeSet::from(["in".to_owned(), "lone".to_owned()]));
    let row = &flock_folder.answers(0, "list", &["a"])["sheep"][0];
    let share = &flock_folder.answers(1, "share", &[])["sheep"][0];
    for field in ["visits", "time", "want", "time_want"] {
        assert_eq!(row[field], share[field], "{field}");
    }
    assert_eq!((&row["entries"], &row["exits"], &row["rendered"]), (&json!(2), &json!(1), &json!(true)));
    assert!((number(&row["ratio"]) - number(&row["visits"]) / number(&row["want"])).abs() < 1e-12);
    // The ids alone are what the other commands take.
    let ids =
        output(Command::new(programs::dreams()).arg("list").arg(flock_folder.folder()).args(["--loose", "--ids"]));
    let ids = String::from_utf8(ids.stdout).unwrap();
    flock_folder.fine(&["drop"], &ids.lines().collect::<Vec<_>>());
    assert_eq!(listed(&["--unplayed"]), "p q");
}

/// The kinds of faults that the graph has, by `dreams check`.
fn graph_faults(flock_folder: &FlockFolder) -> Vec<String> {
    let answer = flock_folder.answers(1, "check", &[]);
    let kinds = answer["faults"].as_array().unwrap().iter().map(|fault| fault["kind"].as_str().unwrap().to_owned());
    kinds.filter(|kind| kind != "missing-clip").collect()
}

#[test]
fn pruning_is_proposed_with_what_each_bridge_would_cost_and_done_when_asked() {
    let arcs = [("a", "b"), ("b", "a"), ("b", "out"), ("in", "a"), ("p", "q"), ("q", "p")];
    let flock_folder = flock(&["a", "b", "in", "out", "p", "q"], &arcs);
    let before = flock_folder.manifest();
    let answer = flock_folder.answers(0, "prune", &[]);
    assert_eq!((words(&answer["keep"]), words(&answer["ties"])), (vec!["a", "b"], vec!["p"]));
    assert_eq!((words(&answer["drop"]), &answer["changed"]), (vec!["p", "q", "in", "out"], &json!(false)));
    let parts = answer["parts"].as_array().unwrap();
    let bridge =
        |part: &Value, way: &str| Some((part[way]["from"].as_str()?.to_owned(), part[way]["to"].as_str()?.to_owned()));
    let pair = |from: &str, to: &str| Some((from.to_owned(), to.to_owned()));
    assert_eq!((bridge(&parts[0], "entry"), bridge(&parts[0], "exit")), (pair("a", "p"), pair("p", "a")));
    assert_eq!((bridge(&parts[1], "entry"), bridge(&parts[1], "exit")), (pair("a", "in"), None));
    assert_eq!((bridge(&parts[2], "entry"), bridge(&parts[2], "exit")), (None, pair("out", "a")));
    // As many frames for each as the flock's transitions have in the middle.
    assert_eq!(
        [&parts[0]["frames"], &parts[1]["frames"], &parts[2]["frames"]],
        [&json!(400), &json!(200), &json!(200)]
    );
    assert_eq!((&answer["fewest_transitions"], &answer["fewest_frames"]), (&json!(2), &json!(400)));
    assert_eq!(parts[0]["entry"]["can_be_rendered"], false, "there is no genome");
    let said = flock_folder.fine(&["prune"], &[]);
    assert!(said.contains("keep 2 sheep") && said.contains("drop 4 sheep and 4 transitions"), "{said}");
    assert!(said.contains("--keep p keeps that one") && said.contains("--write drops the rest"), "{said}");
    assert_eq!(flock_folder.manifest(), before, "nothing is changed unasked");
    // The bridges do what they promise.
    let bridged = FlockFolder::of(&before);
    bridged.fine(&["link", "a", "p"], &[]);
    bridged.fine(&["link", "p", "a"], &[]);
    assert_eq!(words(&bridged.answers(0, "prune", &[])["keep"]), ["a", "b", "p", "q"]);
    // The one or the other part is kept.
    let other = FlockFolder::of(&before);
    let answer = other.answers(0, "prune", &["--keep", "q", "--write"]);
    assert_eq!((words(&answer["keep"]), &answer["changed"]), (vec!["p", "q"], &json!(true)));
    assert_eq!(listed(&other, &[]), ["p", "q"]);
    let said = other.fine(&["prune"], &["--write"]);
    assert_eq!(said, "nothing to drop: each of 2 sheep can be reached from every other\n");
    let none = flock(&["a", "b"], &[("a", "b")]);
    let said = none.says(1, &["prune"], &["--write"]);
    assert!(said.contains("none of its transitions lies on a cycle (it has 1 transition)"), "{said}");
}

#[test]
fn what_pruning_keeps_passes_the_check_of_the_graph() {
    for seed in 0..12u64 {
        // Transitions by chance, some twice, some from or to a sheep that is not there, and a sheep that is defined twice.
        let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
        let mut below = |end: u64| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) % end
        };
        let mut text = HEAD.to_owned();
        (0..14).chain([below(14)]).for_each(|at| text += &sheep(&format!("s{at}")));
        (0..22).for_each(|_| text += &transition(&format!("s{}", below(16)), &format!("s{}", below(15))));
        text += &(transition("s1", "s2") + &transition("s2", "s1") + &transition("s2", "s1"));
        let flock_folder = FlockFolder::of(&text);
        assert!(!graph_faults(&flock_folder).is_empty(), "flock {seed}");
        let answer = flock_folder.answers(0, "prune", &["--write"]);
        assert_eq!(graph_faults(&flock_folder), [""; 0], "flock {seed}: {answer}");
        assert_eq!(listed(&flock_folder, &[]), words(&answer["keep"]), "flock {seed}");
        assert_eq!(words(&answer["keep"]).len() + words(&answer["drop"]).len(), 14, "flock {seed}");
        assert_eq!(answer["faults"], json!([]), "flock {seed}");
    }
}

#[test]
fn by_time_every_sheep_has_the_time_on_screen_that_is_wanted() {
    let ids = ["a", "b", "c", "d"];
    let pairs = ids.iter().flat_map(|from| ids.iter().map(move |to| (*from, *to)));
    let flock_folder = flock(&ids, &pairs.collect::<Vec<_>>());
    flock_folder.fine(&["repeat", "a", "5"], &[]);
    flock_folder.fine(&["want", "d", "2"], &[]);
    let before = flock_folder.answers(0, "share", &[]);
    assert!((number(&before["worst_time_ratio"]) - 3.2).abs() < 1e-9, "{before}");
    let exact = ["--fairness", "inf", "--floor", "0"];
    let balance = |words: &[&str]| flock_folder.answers(0, "balance", words);
    let promised = balance(&[&exact[..], &["--by", "time", "--write"]].concat());
    assert_eq!((&promised["by"], &promised["reachable"]), (&json!("time"), &json!(true)));
    let after = flock_folder.answers(0, "share", &["--by", "time"]);
    for (at, wanted) in [0.2, 0.2, 0.2, 0.4].into_iter().enumerate() {
        let (told, sheep) = (&promised["sheep"][at], &after["sheep"][at]);
        assert!((number(&sheep["time"]) - wanted).abs() < 1e-6, "{sheep}");
        assert!((number(&sheep["time_want"]) - wanted).abs() < 1e-12, "{sheep}");
        for field in ["visits", "time", "want", "time_want"] {
            assert!((number(&told[field]) - number(&sheep[field])).abs() < 1e-12, "{field}: {told} {sheep}");
        }
    }
    // A visit of the first takes five times as long: it has a fifth of the visits for the same time.
    let visits = |answer: &Value, at: usize| number(&answer["sheep"][at]["visits"]);
    assert!((5.0 * visits(&after, 0) / visits(&after, 1) - 1.0).abs() < 1e-6);
    // Each figure keeps its meaning, whatever was balanced.
    for answer in [&promised, &after] {
        let off = |sheep: &Value| {
            (number(&sheep["visits"]) / number(&sheep["want"])).max(number(&sheep["want"]) / number(&sheep["visits"]))
        };
        let worst = answer["sheep"].as_array().unwrap().iter().map(off).fold(1.0, f64::max);
        assert!((number(&answer["worst_ratio"]) - worst).abs() < 1e-9, "{answer}");
        assert!(number(&answer["worst_time_ratio"]) < 1.0 + 1e-6, "{answer}");
    }
    // What is printed says which measure it is.
    let said = flock_folder.fine(&["share", "--by", "time"], &[]);
    assert!(said.starts_with("worst ratio of time and want     1.000\n"), "{said}");
    let said = flock_folder.fine(&["share"], &[]);
    assert!(said.starts_with("worst ratio of visits and want   4"), "{said}");
    let said = flock_folder.fine(&["balance", "--by", "time"], &exact);
    assert!(said.contains("worst ratio of time and want             1.000\n"), "{said}");
    let report = flock_folder.answers(0, "report", &["--by", "time", "--no-pictures"]);
    assert_eq!(
        (&report["worst_ratio"], &report["worst_time_ratio"]),
        (&after["worst_ratio"], &after["worst_time_ratio"])
    );
    let page = fs::read_to_string(flock_folder.folder().join("report.html")).unwrap();
    assert!(page.contains("\"by\":\"time\"") && !page.contains("\"worst\":4"), "the page is about time");
    let again = balance(&[&exact[..], &["--by", "time", "--write"]].concat());
    assert_eq!(again["changed"], false, "what is balanced stays");
    assert!(number(&balance(&exact)["worst_ratio"]) < 1.0 + 1e-6, "by visits it is another balance");
}

#[test]
fn by_time_nothing_is_wanted_of_a_sheep_without_a_loop() {
    let text = flock(&["a", "b"], &[("hub", "a"), ("hub", "b"), ("a", "hub"), ("b", "hub")]).manifest();
    let flock_folder = FlockFolder::of(&text.replacen("\n[[sheep]]", "\n[[sheep]]\nid = \"hub\"\n\n[[sheep]]", 1));
    flock_folder.fine(&["want", "b", "3"], &[]);
    // Every second visit is the hub's, which should have a fifth of them.
    flock_folder.says(1, &["balance"], &[]);
    let said = flock_folder.fine(&["balance", "--by", "time", "--fairness", "inf", "--floor", "0"], &["--write"]);
    assert!(said.contains("\nhub      0.000%    0.000%        -\n"), "{said}");
    let answer = flock_folder.answers(0, "share", &[]);
    assert!((number(&answer["sheep"][1]["time"]) - 0.75).abs() < 1e-6, "{answer}");
    let bare = flock(&[], &[("x", "y"), ("y", "x")]).manifest();
    let bare = FlockFolder::of(&bare.replacen("\n[[tr", "\n[[sheep]]\nid = \"x\"\n\n[[sheep]]\nid = \"y\"\n\n[[tr", 1));
    let said = bare.says(1, &["balance"], &["--by", "time"]);
    assert!(said.contains("none of the 2 sheep that are played has a loop"), "{said}");
}
