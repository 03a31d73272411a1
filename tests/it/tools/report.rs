//! `dreams report` for other programs.
//!
//! Owns the claims on its answer, its file and the graph for other programs. The page in a browser is in
//! `slow/tools/report.rs`.

use claims::flocks::SMALL;
use claims::report::{bare, dreams, report, written};
use serde_json::Value;
use std::collections::HashSet;
use std::fs;

#[test]
fn the_same_flock_gives_the_same_bytes() {
    let folder = SMALL.flock().folder;
    let read = || fs::read(report(&folder, 0).1).unwrap();
    let page = read();
    assert_eq!(page, read());
    assert!(page.len() < 1_000_000, "{} bytes", page.len());
}

#[test]
fn the_answer_tells_the_file_and_an_unwritable_one_ends_with_3() {
    let folder = written(&bare(4, 1));
    let said = dreams(&["report", "--json"], folder.path());
    let answer: Value = serde_json::from_slice(&said.stdout).unwrap();
    let page = folder.path().join("report.html");
    assert_eq!(answer["file"], page.to_str().unwrap());
    assert_eq!(answer["bytes"], fs::metadata(&page).unwrap().len());
    assert_eq!((&answer["sheep"], &answer["clips_there"]), (&4.into(), &0.into()));
    let said = dreams(&["report", "--out", "/no/such/folder/page.html"], folder.path());
    assert_eq!(said.status.code(), Some(3), "{}", String::from_utf8_lossy(&said.stderr));
}

#[test]
fn graphml_is_xml_with_every_sheep_and_every_transition() {
    let flock_folder = written(&bare(30, 3).replace("\"bare\"", "\"<&>\\\" \\u0001\""));
    let text = String::from_utf8(dreams(&["report", "--graphml"], flock_folder.path()).stdout).unwrap();
    let document = roxmltree::Document::parse(&text).unwrap();
    let named = |tag: &'static str| {
        document.descendants().filter(move |node| node.has_tag_name(("http://graphml.graphdrawing.org/xmlns", tag)))
    };
    let keys: HashSet<_> = named("key").filter_map(|key| key.attribute("id")).collect();
    assert!(named("data").all(|data| keys.contains(data.attribute("key").unwrap())));
    let ids: HashSet<_> = named("node").filter_map(|node| node.attribute("id")).collect();
    assert_eq!(ids.len(), 30);
    let ends = named("edge").flat_map(|edge| ["source", "target"].map(|end| edge.attribute(end).unwrap()));
    assert!(ends.clone().count() >= 2 * 100 && ends.clone().all(|id| ids.contains(id)));
    let visits: f64 = named("node")
        .flat_map(|node| node.children())
        .filter(|data| data.attribute("key") == Some("visits"))
        .map(|data| data.text().unwrap().parse::<f64>().unwrap())
        .sum();
    assert!((visits - 1.0).abs() < 1e-6, "{visits}");
}

#[test]
fn dot_has_a_line_for_every_sheep_and_every_transition_and_balanced_quotes() {
    let flock_folder = written(&bare(30, 3).replace("\"bare\"", "\"a\\\"] -> \\\\ b\\n\""));
    let text = String::from_utf8(dreams(&["report", "--dot"], flock_folder.path()).stdout).unwrap();
    assert!(text.starts_with("digraph \"a\\\"] -> \\\\ b \" {\n") && text.ends_with("\n}\n"), "{text}");
    let arrows = text.lines().skip(1).filter(|line| line.contains("\" -> \"")).count();
    let sheep = text.lines().filter(|line| line.starts_with("  \"s.") && line.contains(" [pos=")).count();
    assert_eq!(sheep, 30);
    assert!(arrows >= 100 && text.lines().count() == 4 + sheep + arrows, "{text}");
    let plain = text.replace("\\\\", "").replace("\\\"", "");
    assert!(plain.lines().all(|line| line.matches('"').count().is_multiple_of(2)), "{text}");
    let said = dreams(&["report", "--dot", "--out", "/no/such/folder/graph.dot"], flock_folder.path());
    assert_eq!(said.status.code(), Some(3));
}
