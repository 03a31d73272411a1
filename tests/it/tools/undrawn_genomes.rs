//! Genomes that ask for what is not drawn: each command names all of it, and none draws another picture in silence.
//!
//! Owns the claims on `dreams` and the studio for genomes in the forms of other programs. What is drawn of a genome is
//! tested in `crates/flame`.

use super::import_folders::ImportFolders;
use claims::programs::{self, json, output};
use claims::studio::running::Studio;
use serde_json::{Value, json};
use std::fs;
use std::path::Path;
use std::process::{Command, Output};

/// A flame called `name`, with these attributes and these of its first transform.
fn flame(name: &str, own: &str, of_first: &str) -> String {
    let palette = ["108040", "F08040"].map(|colour| colour.repeat(128)).concat();
    format!(
        "<flame name=\"{name}\" {own} size=\"64 48\" center=\"0 0\" scale=\"20\" quality=\"1\">\n\
         <xform weight=\"1\" color=\"0\" linear=\"1\" coefs=\"0.5 0 0 0.5 0.5 0\" {of_first}/>\n\
         <xform weight=\"1\" color=\"1\" linear=\"1\" coefs=\"0.5 0 0 0.5 -0.5 0.5\"/>\n\
         <palette count=\"256\" format=\"RGB\">{palette}</palette>\n</flame>"
    )
}

/// Two unknown variations and a solid rendering, as `JWildfire` writes them.
fn three_reasons(name: &str) -> String {
    flame(
        name,
        "version=\"JWildfire V7.30 (27.11.2021)\" sld_render_enabled=\"1\"",
        "waltz=\"0.5\" waltz_beat=\"3\" waltz_fx_priority=\"0\" polka=\"1\"",
    )
}

/// An unknown variation, as Apophysis writes it.
fn unknown_variation(name: &str) -> String {
    flame(name, "version=\"Apophysis 7X.15C\" new_linear=\"1\"", "waltz=\"0.5\" waltz_beat=\"3\"")
}

/// The reasons for [`three_reasons`].
fn all_three() -> Value {
    json!([
        { "place": "transform 0", "name": "waltz", "value": "0.5", "why": "variation" },
        { "place": "transform 0", "name": "polka", "value": "1", "why": "variation" },
        { "place": "the flame", "name": "sld_render_enabled", "value": "1", "why": "solid" },
    ])
}

fn dreams(words: &[&str], folder: &Path) -> Output {
    output(Command::new(programs::dreams()).args(words).current_dir(folder))
}

fn stderr(said: &Output) -> String {
    String::from_utf8_lossy(&said.stderr).into_owned()
}

/// A flock of two good sheep and one that cannot be drawn, with transitions around, in which nothing is rendered.
fn flock_with_one_undrawn() -> ImportFolders {
    let folders = ImportFolders::new("64x48");
    let good = ["ash", "elm"].map(|name| flame(name, "", &format!("opacity=\"{}\"", name.len() - 2)));
    let [ash, elm] = [good[0].clone(), good[1].replace("0.5 0.5\"", "0.4 0.3\"")];
    fs::write(folders.inbox().join("good.flame"), format!("<flames>{ash}{elm}</flames>")).unwrap();
    folders.answer(0, &["good.flame", "--frames", "4"]);
    fs::write(folders.flock().join("genomes/oak.flam3"), three_reasons("oak")).unwrap();
    let mut text = folders.manifest();
    text.push_str("\n[[sheep]]\nid = \"oak\"\nframes = 4\nclip = \"loops/oak.mp4\"\ngenome = \"genomes/oak.flam3\"\n");
    for (from, to) in [("ash", "elm"), ("elm", "oak"), ("oak", "ash"), ("elm", "ash")] {
        let clip = format!("transitions/{from}={to}.mp4");
        let part = format!("\n[[transition]]\nfrom = \"{from}\"\nto = \"{to}\"\nframes = 3\nclip = \"{clip}\"\n");
        text.push_str(&part);
    }
    fs::write(folders.flock().join("flock.toml"), text).unwrap();
    folders
}

#[test]
fn an_import_names_all_reasons_and_ends_with_1_where_nothing_could_be_taken() {
    let folders = ImportFolders::new("64x48");
    fs::write(folders.inbox().join("oak.flame"), three_reasons("oak")).unwrap();
    let (answer, notes) = folders.answer_and_notes(1, &["oak.flame"]);
    assert_eq!(answer["genomes"], json!([]), "{answer}");
    assert_eq!(answer["left_out"][0]["reasons"], all_three(), "{answer}");
    assert!(!folders.manifest().contains("[[sheep]]"));
    for part in ["variation `waltz`", "variation `polka`", "`sld_render_enabled`"] {
        let reason = answer["left_out"][0]["reason"].as_str().unwrap();
        assert!(reason.contains(part) && notes.is_empty(), "{reason}{notes}");
        let said = output(&mut folders.import(&["oak.flame"]));
        assert!(stderr(&said).contains(part), "{}", stderr(&said));
    }
}

#[test]
fn unknown_variations_are_left_out_where_that_is_asked_for_and_the_genome_says_so() {
    let folders = ImportFolders::new("64x48");
    fs::write(folders.inbox().join("elm.flame"), unknown_variation("elm")).unwrap();
    fs::write(folders.inbox().join("oak.flame"), three_reasons("oak")).unwrap();
    let plain = folders.answer(1, &["elm.flame"]);
    let reason = plain["left_out"][0]["reason"].as_str().unwrap();
    assert!(reason.contains("--as-far-as-possible"), "{reason}");
    let answer = folders.answer(0, &["elm.flame", "--as-far-as-possible"]);
    let without = json!([{ "place": "transform 0", "name": "waltz", "value": "0.5", "why": "left-out" }]);
    assert_eq!(answer["genomes"][0]["without"], without, "{answer}");
    let there = fs::read_to_string(folders.flock().join("genomes/elm.flam3")).unwrap();
    let marked = unknown_variation("elm").replacen("<flame", "<flame drawn_without=\"waltz\"", 1);
    assert_eq!(there, format!("{marked}\n"));
    let again = folders.answer(0, &["elm.flame", "--as-far-as-possible"]);
    assert_eq!(again["genomes"][0]["state"], "stood");
    let run = output(&mut folders.import(&["elm.flame", "--as-far-as-possible"]));
    assert!(stderr(&run).contains("note: genome `elm` is drawn without the variation `waltz`"), "{}", stderr(&run));
    let other = folders.answer(1, &["oak.flame", "--as-far-as-possible"]);
    let solid = &all_three()[2];
    assert_eq!(other["left_out"][0]["reasons"], json!([solid]), "solid rendering is no variation");
    let pictures = [there, flame("elm", "", "")].map(|text| {
        fs::write(folders.inbox().join("still.flam3"), text).unwrap();
        let said = dreams(&["still", "still.flam3", "--out", "still.png", "--spp", "2", "--json"], &folders.inbox());
        json(&said)["checksum"].clone()
    });
    assert_eq!(pictures[0], pictures[1], "the rest of the flame is drawn");
}

#[test]
fn a_variation_with_an_unknown_parameter_is_never_drawn_by_another_formula() {
    let folders = ImportFolders::new("64x48");
    let odd = "fdisc=\"0.5\" fdisc_ashift=\"0.3\" fdisc#1#=\"0.2\" pre_fdisc=\"0.1\" pre_fdisc_ashift=\"0.1\"";
    fs::write(folders.inbox().join("elm.flame"), flame("elm", "", odd)).unwrap();
    let plain = folders.answer(1, &["elm.flame"]);
    let reason = plain["left_out"][0]["reason"].as_str().unwrap();
    assert_eq!(
        reason,
        "cannot be drawn: this renderer does not draw the unknown parameter `ashift` of the variation `fdisc` (`0.3`, \
         transform 0), the unknown parameter `ashift` of the variation `pre_fdisc` (`0.1`, transform 0); \
         --as-far-as-possible leaves the variations out"
    );
    let refused = json!({
        "place": "transform 0", "name": "fdisc_ashift", "value": "0.3", "variation": "fdisc", "why": "parameter",
    });
    assert_eq!(plain["left_out"][0]["reasons"][0], refused, "{plain}");
    let run = output(&mut folders.import(&["elm.flame", "--as-far-as-possible"]));
    let wanted = "note: genome `elm` is drawn without the variation `fdisc`, whose parameter `ashift` is unknown (`0.3`, \
                  transform 0), the variation `pre_fdisc`, whose parameter `ashift` is unknown (`0.1`, transform 0)";
    assert!(stderr(&run).contains(wanted), "{}", stderr(&run));
    let there = folders.flock().join("genomes/elm.flam3");
    let text = fs::read_to_string(&there).unwrap();
    assert!(text.starts_with("<flame drawn_without=\"fdisc_ashift pre_fdisc_ashift\" name=\"elm\""), "{text}");
    let again = folders.answer(0, &["elm.flame", "--as-far-as-possible"]);
    assert_eq!(again["genomes"][0]["state"], "stood", "{again}");
    let pictures = [text, flame("elm", "", "fdisc.2=\"0.2\"")].map(|text| {
        fs::write(folders.inbox().join("still.flam3"), text).unwrap();
        let said = dreams(&["still", "still.flam3", "--out", "still.png", "--spp", "2", "--json"], &folders.inbox());
        json(&said)["checksum"].clone()
    });
    assert!(pictures[0].is_string() && pictures[0] == pictures[1], "the second `fdisc` is known in full");
}

#[test]
fn a_priority_that_is_not_drawn_is_named_with_what_is_expected() {
    let folders = ImportFolders::new("64x48");
    fs::write(folders.inbox().join("elm.flame"), flame("elm", "", "swirl=\"0.5\" swirl_fx_priority=\"0.5\"")).unwrap();
    let answer = folders.answer(1, &["elm.flame"]);
    let reason = answer["left_out"][0]["reason"].as_str().unwrap();
    let expected = "cannot be drawn: this renderer does not draw the priority `swirl_fx_priority` (`0.5`, transform 0; \
                    expected a whole number)";
    assert_eq!(reason, expected);
}

#[test]
fn a_flame_of_which_a_part_is_not_drawn_is_imported_and_says_so() {
    let folders = ImportFolders::new("64x48");
    fs::write(folders.inbox().join("elm.flame"), flame("elm", "wobble=\"1\"", "")).unwrap();
    let (answer, _) = folders.answer_and_notes(0, &["elm.flame"]);
    assert_eq!(answer["genomes"][0]["without"][0]["why"], "attribute", "{answer}");
    let run = output(&mut folders.import(&["elm.flame"]));
    assert!(stderr(&run).contains("is drawn without the attribute `wobble`"), "{}", stderr(&run));
}

#[test]
fn a_sheep_that_is_added_though_its_genome_cannot_be_drawn_says_why() {
    let folders = ImportFolders::new("64x48");
    fs::write(folders.inbox().join("oak.flame"), three_reasons("oak")).unwrap();
    fs::write(folders.inbox().join("elm.flame"), flame("elm", "wobble=\"1\"", "")).unwrap();
    let add = |id: &str| {
        let words = ["add", "aurora", id, "--genome", &format!("inbox/{id}.flame"), "--json"];
        let said = dreams(&words, folders.scratch.path());
        (json(&said), stderr(&said))
    };
    let (oak, notes) = add("oak");
    assert_eq!(
        (&oak["changed"], &oak["reasons"], &oak["without"]),
        (&json!(true), &all_three(), &Value::Null),
        "{oak}"
    );
    assert!(notes.contains("cannot be drawn"), "{notes}");
    let (elm, _) = add("elm");
    assert_eq!((&elm["reasons"], &elm["without"][0]["why"]), (&Value::Null, &json!("attribute")), "{elm}");
}

#[test]
fn check_and_list_name_the_genomes_of_a_flock_that_cannot_be_drawn() {
    let folders = flock_with_one_undrawn();
    let said = dreams(&["check", "aurora", "--json"], folders.scratch.path());
    let answer = json(&said);
    assert_eq!(said.status.code(), Some(1));
    assert_eq!(answer["genomes"][0]["refused"], all_three(), "{answer}");
    let faults: Vec<_> = answer["faults"].as_array().unwrap().iter().filter(|own| own["sheep"] == "oak").collect();
    assert!(faults.iter().any(|fault| fault["kind"] == "undrawn-genome"), "{answer}");
    let words = dreams(&["check", "aurora"], folders.scratch.path());
    let lines = String::from_utf8_lossy(&words.stdout).into_owned();
    let line = lines.lines().find(|line| line.starts_with("undrawn-genome: ")).expect("a line");
    assert!(["oak", "waltz", "polka", "sld_render_enabled"].iter().all(|part| line.contains(part)), "{line}");
    let listed = json(&dreams(&["list", "aurora", "--json"], folders.scratch.path()));
    let oak = listed["sheep"].as_array().unwrap().iter().find(|row| row["id"] == "oak").unwrap();
    assert_eq!(oak["undrawn"]["refused"], all_three(), "{oak}");
    let table = dreams(&["list", "aurora"], folders.scratch.path());
    assert!(String::from_utf8_lossy(&table.stdout).contains("its genome cannot be drawn"));
    assert!(stderr(&table).contains("the variation `polka`"), "{}", stderr(&table));
}

#[test]
fn a_render_goes_on_with_the_others_and_ends_with_1() {
    let folders = flock_with_one_undrawn();
    for options in [&["--dry-run"][..], &[]] {
        let words = [&["render", "aurora", "--spp", "2", "--temporal-samples", "1", "--json"], options].concat();
        let said = dreams(&words, folders.scratch.path());
        let answer = json(&said);
        assert_eq!(said.status.code(), Some(1), "{options:?}: {}", stderr(&said));
        let left_out: Vec<_> = answer["left_out"].as_array().unwrap().iter().collect();
        let names: Vec<_> = left_out.iter().map(|clip| clip["clip"].as_str().unwrap()).collect();
        assert_eq!(names, ["loops/oak.mp4", "transitions/elm=oak.mp4", "transitions/oak=ash.mp4"], "{answer}");
        assert!(left_out.iter().all(|clip| clip["reasons"] == all_three()), "{answer}");
        assert!(names.iter().all(|name| stderr(&said).contains(&format!("`{name}`"))), "{}", stderr(&said));
        assert_eq!(answer["clips"].as_array().unwrap().len(), 4, "{answer}");
    }
    for there in ["loops/ash.mp4", "loops/elm.mp4", "transitions/ash=elm.mp4", "transitions/elm=ash.mp4"] {
        assert!(folders.flock().join(there).is_file(), "{there}");
    }
}

#[test]
fn a_torn_or_missing_genome_is_named_and_the_others_are_rendered() {
    let folders = flock_with_one_undrawn();
    let oak = folders.flock().join("genomes/oak.flam3");
    let run = |words: &[&str]| dreams(&[words, &["--json"]].concat(), folders.scratch.path());
    for (text, why, exit) in [(Some("<flame><xform"), "not well-formed XML", 2), (None, "No such file", 3)] {
        match text {
            Some(text) => fs::write(&oak, text).unwrap(),
            None => fs::remove_file(&oak).unwrap(),
        }
        let checked = json(&run(&["check", "aurora"]));
        assert!(checked["genomes"][0]["unusable"].as_str().unwrap().contains(why), "{checked}");
        let listed = json(&run(&["list", "aurora", "oak"]));
        assert!(listed["sheep"][0]["undrawn"]["unusable"].as_str().unwrap().contains(why), "{listed}");
        let studio = Studio::with(&folders.flock(), &[]);
        let state = studio.get("/api/state");
        let shown = state["sheep"].as_array().unwrap().iter().find(|sheep| sheep["id"] == "oak").unwrap();
        assert!(shown["refused"].as_str().unwrap().contains(why), "{shown}");
        let said = run(&["render", "aurora", "--spp", "2", "--temporal-samples", "1"]);
        let answer = json(&said);
        assert_eq!(said.status.code(), Some(exit), "{}", stderr(&said));
        let left_out: Vec<_> = answer["left_out"].as_array().unwrap().iter().collect();
        assert_eq!(left_out.len(), 3, "{answer}");
        assert!(left_out.iter().all(|clip| clip["reason"].as_str().unwrap().contains(why)), "{answer}");
        for there in ["loops/ash.mp4", "loops/elm.mp4", "transitions/ash=elm.mp4", "transitions/elm=ash.mp4"] {
            assert!(folders.flock().join(there).is_file(), "{there}");
        }
    }
}

#[test]
fn a_still_names_all_reasons_and_else_the_program_and_the_tone() {
    let scratch = tempfile::tempdir().unwrap();
    let still = |text: String| {
        fs::write(scratch.path().join("a.flam3"), text).unwrap();
        dreams(&["still", "a.flam3", "--out", "a.png", "--spp", "2", "--json"], scratch.path())
    };
    let refused = still(three_reasons("oak"));
    assert_eq!(refused.status.code(), Some(2));
    let error = &json(&refused)["error"];
    assert_eq!(error["reasons"], all_three(), "{error}");
    assert!(["waltz", "polka", "sld_render_enabled"].iter().all(|name| stderr(&refused).contains(name)));
    let notes = |version: &str| {
        let said = still(flame("a", version, ""));
        assert_eq!(said.status.code(), Some(0), "{}", stderr(&said));
        json(&said)
    };
    let jwildfire = notes("version=\"JWildfire V7.30 (27.11.2021)\"");
    assert_eq!(jwildfire["program"], "JWildfire");
    assert!(jwildfire["tone"].as_array().unwrap().iter().any(|name| name == "JWildfire's light"), "{jwildfire}");
    let flam3 = notes("version=\"FLAM3-LNX-3.1.1\"");
    assert_eq!((&flam3["program"], &flam3["tone"], &flam3["without"]), (&json!("flam3"), &json!([]), &json!([])));
    assert_eq!(notes("")["program"], Value::Null);
}

#[test]
fn the_studio_shows_what_is_not_drawn_and_takes_in_no_such_candidate() {
    let folders = flock_with_one_undrawn();
    let archive = folders.scratch.path().join("archive");
    fs::create_dir(&archive).unwrap();
    fs::write(archive.join("fir.flam3"), three_reasons("fir")).unwrap();
    let studio = Studio::with(&folders.flock(), &["--archive", archive.to_str().unwrap()]);
    let state = studio.get("/api/state");
    let faults = state["faults"].as_array().unwrap();
    let fault = faults.iter().find(|fault| fault["kind"] == "undrawn-genome").expect("a fault");
    assert!(fault["message"].as_str().unwrap().contains("the variation `polka`"), "{fault}");
    let oak = state["sheep"].as_array().unwrap().iter().find(|sheep| sheep["id"] == "oak").unwrap();
    assert!(oak["refused"].as_str().unwrap().contains("the variation `waltz`"), "{oak}");
    let edits = json!([{ "do": "add", "candidates": ["fir"] }]);
    let body = json!({ "revision": state["revision"], "edits": edits });
    let refused = studio.ask("POST", "/api/edits", Some(&body));
    let notes = refused.json().to_string();
    assert!(refused.status >= 400 && notes.contains("polka") && notes.contains("sld_render_enabled"), "{notes}");
    assert!(!folders.manifest().contains("fir"));
}
