//! Who made what in a flock, and under which licences.
//!
//! Owns the claims on genomes of Electric Sheep's edges, on `credits.toml`, on `dreams credits` and on bundles that are for
//! sale. Never renders: the genomes are small, and clips are copies.

use crate::tools::bundles::Artist;
use claims::programs::{self, json, output, succeed};
use serde_json::{Value, json};
use std::fmt::Write as _;
use std::fs;
use std::path::PathBuf;
use std::process::Command;

/// An empty flock, and a folder with what is imported.
struct Folders {
    scratch: tempfile::TempDir,
}

impl Folders {
    fn new() -> Self {
        let folders = Self { scratch: tempfile::tempdir().unwrap() };
        fs::create_dir(folders.inbox()).unwrap();
        succeed(Command::new(programs::dreams()).arg("new").arg(folders.flock()).args(["--size", "320x180"]));
        folders
    }

    fn flock(&self) -> PathBuf {
        self.scratch.path().join("aurora")
    }

    fn inbox(&self) -> PathBuf {
        self.scratch.path().join("inbox")
    }

    /// Writes a file of these flames into the inbox.
    fn genomes(&self, name: &str, flames: &[String]) {
        fs::write(self.inbox().join(name), flames.concat()).unwrap();
    }

    fn file(&self, name: &str) -> String {
        fs::read_to_string(self.flock().join(name)).unwrap()
    }

    /// What `dreams COMMAND FLOCK WORDS...` prints on both streams; it must end with `code`.
    fn says(&self, code: i32, command: &str, words: &[&str]) -> String {
        let mut dreams = Command::new(programs::dreams());
        let said = output(dreams.arg(command).arg(self.flock()).args(words).current_dir(self.inbox()));
        let text = [said.stdout, said.stderr].map(|text| String::from_utf8(text).unwrap()).concat();
        assert_eq!(said.status.code(), Some(code), "{command} {words:?}: {text}");
        text
    }

    fn answers(&self, code: i32, command: &str, words: &[&str]) -> Value {
        let mut dreams = Command::new(programs::dreams());
        let said = output(dreams.arg(command).arg(self.flock()).args(words).arg("--json").current_dir(self.inbox()));
        assert_eq!(said.status.code(), Some(code), "{command} {words:?}: {}", String::from_utf8_lossy(&said.stderr));
        json(&said)
    }
}

/// A flame that differs from those of other `hue`, with more attributes, and elements below its transforms.
fn flame(hue: u32, attributes: &str, elements: &str) -> String {
    let xform = "<xform weight=\"1\" color=\"0\" linear=\"0.5\" coefs=\"1 0 0 1 0 0\"/>";
    let colours = (0..256).fold(String::new(), |mut text, index| {
        write!(text, "<color index=\"{index}\" rgb=\"{hue} {index} 0\"/>").unwrap();
        text
    });
    format!("<flame {attributes} size=\"640 360\">{xform}{colours}{elements}</flame>\n")
}

/// The transitions of an answer: from, to, state.
fn pairs(answer: &Value) -> Vec<(String, String, String)> {
    let text = |one: &Value, key: &str| one[key].as_str().unwrap().to_owned();
    let transitions = answer["transitions"].as_array().unwrap().iter();
    transitions.map(|one| (text(one, "from"), text(one, "to"), text(one, "state"))).collect()
}

/// The sheep that an import answers with genomes for: id and state.
fn sheep(answer: &Value) -> Vec<(String, String)> {
    let text = |one: &Value, key: &str| one[key].as_str().unwrap().to_owned();
    answer["genomes"].as_array().unwrap().iter().map(|one| (text(one, "sheep"), text(one, "state"))).collect()
}

/// The credit of a sheep in an answer.
fn credit<'a>(answer: &'a Value, id: &str) -> &'a Value {
    answer["sheep"]
        .as_array()
        .unwrap()
        .iter()
        .find(|sheep| sheep["id"] == id)
        .unwrap_or_else(|| panic!("{id}: {answer}"))
}

/// The genealogy of a sheep that a person has designed, and of one that a program has bred from it.
const DESIGNED: &str = "<edit nick=\"Ursitti\" url=\"jam.example\" id=\"76\" action=\"clone upload\"/>";
const BRED: &str = "<edit action=\"clone\"><edit id=\"99\" gen=\"242\" action=\"clone brood\"><edit id=\"76\" gen=\"242\" \
                    nick=\"Ursitti\" action=\"clone upload\"/></edit></edit>";

/// A public archive in small: two sheep, their edge, and an edge of an old generation with the one sheep that is its start.
/// In the edges the flames are copies with another time.
fn archive(folders: &Folders) {
    let ram = "name=\"electricsheep.242.00076\" nick=\"Ursitti\" url=\"jam.example\"";
    let ewe = "name=\"electricsheep.242.00099\"";
    folders.genomes("electricsheep.242.00076.flam3", &[flame(10, &format!("{ram} time=\"0\""), DESIGNED)]);
    folders.genomes("electricsheep.242.00099.flam3", &[flame(20, &format!("{ewe} time=\"0\""), BRED)]);
    let ends = [flame(10, &format!("{ram} time=\"0\""), ""), flame(20, &format!("{ewe} time=\"180\""), "")];
    folders.genomes("electricsheep.242.00050.flam3", &ends);
    folders.genomes("electricsheep.165.00123.flam3", &[flame(30, "time=\"0\"", "")]);
    folders.genomes("favourites.flam3", &[flame(10, &format!("{ram} time=\"7\""), ""), flame(20, ewe, "")]);
    folders.genomes("electricsheep.165.00002.flam3", &[flame(40, "time=\"0\"", ""), flame(30, "time=\"128\"", "")]);
}

#[test]
fn a_genome_of_an_edge_becomes_the_transition_between_its_sheep() {
    let folders = Folders::new();
    archive(&folders);
    let added = |from: &str, to: &str| (from.to_owned(), to.to_owned(), "added".to_owned());
    let wanted = [added("165.2.1", "165.123"), added("242.76", "242.99")];
    let dry = folders.answers(0, "import", &[".", "--dry-run"]);
    assert_eq!((pairs(&dry), folders.file("flock.toml").contains("[[sheep]]")), (wanted.to_vec(), false));
    let (planned, left_out) = (sheep(&dry), &dry["left_out"]);
    assert_eq!(left_out, &json!([]));
    assert!(!folders.flock().join("credits.toml").exists(), "a dry run writes nothing");
    let answer = folders.answers(0, "import", &[".", "--frames", "90"]);
    assert_eq!((pairs(&answer), &answer["left_out"]), (wanted.to_vec(), &json!([])), "{answer}");
    assert_eq!(sheep(&answer), planned, "as the dry run said");
    let manifest = folders.file("flock.toml");
    assert_eq!(manifest.matches("[[sheep]]").count(), 4, "each sheep once: {manifest}");
    let edge = "from = \"242.76\"\nto = \"242.99\"\nframes = 90\nclip = \"transitions/242.76=242.99.mp4\"";
    assert!(manifest.contains(edge), "{manifest}");
    let own = fs::read_to_string(folders.inbox().join("electricsheep.242.00099.flam3")).unwrap();
    assert_eq!(folders.file("genomes/242.99.flam3"), own, "a sheep's own file, not the copy in the edge");
    let again = folders.answers(0, "import", &["."]);
    assert!(pairs(&again).iter().all(|(_, _, state)| state == "stood"), "{again}");
    assert_eq!(folders.file("flock.toml"), manifest);

    // What can be no transition is named.
    folders.genomes(
        "242=7=76=98.flam3",
        &[flame(1, "name=\"electricsheep.242.76\"", ""), flame(2, "name=\"electricsheep.242.99\"", "")],
    );
    folders.genomes("electricsheep.242.00008.flam3", &[flame(3, "name=\"dusk\"", ""), flame(4, "name=\"dusk\"", "")]);
    let odd = folders.answers(1, "import", &["242=7=76=98.flam3", "electricsheep.242.00008.flam3"]);
    let reasons: Vec<&str> =
        odd["left_out"].as_array().unwrap().iter().map(|one| one["reason"].as_str().unwrap()).collect();
    let names = "flame 2 is `242.99` (expected `242.98`, by the name of the file)";
    assert_eq!(reasons, [names, "both its flames are `dusk` (expected two sheep)"]);
    // Where the flock has another genome of a sheep, its loop was made from that one.
    fs::remove_file(folders.inbox().join("electricsheep.242.00099.flam3")).unwrap();
    let variant =
        [flame(20, "name=\"electricsheep.242.00099\"", ""), flame(99, "name=\"electricsheep.242.00076\"", "")];
    folders.genomes("electricsheep.242.00051.flam3", &variant);
    let back = folders.answers(0, "import", &["electricsheep.242.00051.flam3"]);
    assert_eq!(pairs(&back), [added("242.99", "242.76")]);
    assert!(!folders.file("genomes/242.76.flam3").contains("rgb=\"99"));
}

#[test]
fn authors_parents_and_licences_are_told_of_every_sheep_and_transition() {
    let folders = Folders::new();
    archive(&folders);
    folders.answers(0, "import", &["."]);
    let credits = folders.answers(0, "credits", &[]);
    let designed = credit(&credits, "242.76");
    assert_eq!(
        (&designed["authors"], &designed["licence"]),
        (&json!(["Ursitti <jam.example>"]), &json!("CC-BY-3.0-US"))
    );
    assert_eq!((&designed["sale"], &designed["source"]), (&json!("permitted"), &json!("electricsheep.242.00076")));
    let bred = credit(&credits, "242.99");
    assert_eq!((&bred["licence"], &bred["sale"]), (&json!("CC-BY-NC-3.0"), &json!("forbidden")));
    assert_eq!((&bred["parents"], &bred["authors"]), (&json!(["242.76"]), &json!(["Ursitti"])));
    let edges = credits["transitions"].as_array().unwrap();
    let edge = edges.iter().find(|edge| edge["from"] == "242.76").unwrap();
    assert_eq!(edge["licence"], "CC-BY-3.0-US AND CC-BY-NC-3.0", "it is made of both");
    assert_eq!(edge["authors"], json!(["Ursitti <jam.example>"]));
    assert_eq!((&edge["source"], &edge["sale"]), (&json!("electricsheep.242.00050"), &json!("forbidden")));
    assert_eq!(credits["attributions"], json!(["artwork by Scott Draves and the Electric Sheep"]));
    let told = folders.says(0, "credits", &[]);
    let row = "242.99 CC-BY-NC-3.0 Ursitti, from electricsheep.242.00099, bred from 242.76";
    assert!(told.lines().any(|line| line.split_whitespace().eq(row.split_whitespace())), "{told}");
    assert!(told.contains("CC-BY-NC-3.0: 3 sheep, 1 transition, not for sale\n"), "{told}");
    let some = folders.answers(0, "credits", &["--licence", "cc-by"]);
    let ids: Vec<_> = some["sheep"].as_array().unwrap().iter().map(|sheep| &sheep["id"]).collect();
    assert_eq!((ids, some["transitions"].as_array().unwrap().len()), (vec![&json!("242.76")], 1), "{some}");
    assert_eq!(folders.answers(0, "credits", &["--licence", "none"])["sheep"], json!([]));
    assert_eq!(folders.says(0, "list", &["--licence", "cc-by", "--ids"]), "242.76\n");
    assert_eq!(folders.says(0, "list", &["--licence", "none", "--ids"]), "");
    let sold = folders.says(1, "credits", &["--for-sale"]);
    assert!(sold.contains("`loops/242.99.mp4` is under CC-BY-NC-3.0: not for sale\n"), "{sold}");
    assert!(!sold.contains("loops/242.76.mp4"), "{sold}");

    // The artist's own, without a word about them but this.
    let own = format!("[default]\nauthors = [\"Ada\"]\nlicence = \"CC BY 4.0\"\n\n{}", folders.file("credits.toml"));
    fs::write(folders.flock().join("credits.toml"), own).unwrap();
    fs::write(folders.inbox().join("own.flam3"), flame(50, "", "")).unwrap();
    folders.says(0, "add", &["own", "--genome", "own.flam3"]);
    let credits = folders.answers(0, "credits", &[]);
    let own = credit(&credits, "own");
    assert_eq!((&own["authors"], &own["licence"]), (&json!(["Ada"]), &json!("CC-BY-4.0")));
    assert_eq!(credit(&credits, "242.76")["authors"], json!(["Ursitti <jam.example>"]), "others' stay theirs");
}

#[test]
fn what_the_artist_writes_into_the_credits_outlives_imports_and_follows_edits() {
    let folders = Folders::new();
    archive(&folders);
    folders.answers(0, "import", &["."]);
    let first = folders.file("credits.toml");
    let edited = first.replacen("licence = \"CC-BY-3.0-US\"", "licence = \"CC0-1.0\" # asked her in 2026", 1);
    assert_ne!(first, edited);
    fs::write(folders.flock().join("credits.toml"), &edited).unwrap();
    folders.answers(0, "import", &["."]);
    assert_eq!(folders.file("credits.toml"), edited, "a second import changes nothing");
    folders.says(0, "rename", &["242.76", "ram"]);
    let renamed = edited.replace("id = \"242.76\"", "id = \"ram\"").replace("from = \"242.76\"", "from = \"ram\"");
    assert_eq!(folders.file("credits.toml"), renamed);
    assert_eq!(credit(&folders.answers(0, "credits", &[]), "ram")["licence"], "CC0-1.0");
    folders.says(0, "unlink", &["ram", "242.99"]);
    assert!(!folders.file("credits.toml").contains("from = \"ram\""));
    folders.says(0, "drop", &["ram"]);
    let credits = folders.file("credits.toml");
    assert!(!credits.contains("\"ram\"") && credits.contains("id = \"242.99\""), "{credits}");
    assert_eq!(folders.answers(0, "credits", &[])["strangers"], json!([]));

    let before = (folders.file("flock.toml"), credits);
    fs::write(folders.flock().join("credits.toml"), before.1.clone() + "\n[[sheep]]\nid = \"x\"\nlisence = \"MIT\"\n")
        .unwrap();
    let line = before.1.lines().count() + 4;
    let wanted = format!("credits.toml`, line {line}, key `lisence`: unknown field `lisence`, expected one of `id`,");
    for (command, words) in [
        ("credits", &[][..]),
        ("import", &["."]),
        ("drop", &["242.99", "--force"]),
        ("rename", &["242.99", "ewe"]),
        ("report", &[]),
    ] {
        let said = folders.says(2, command, words);
        assert!(said.contains(&wanted), "{command}: {said}");
    }
    assert_eq!(folders.file("flock.toml"), before.0, "nothing was changed");
    folders.says(0, "want", &["242.99", "2"]);
}

#[test]
fn clips_bring_the_credits_in_their_names_and_tags() {
    let folders = Folders::new();
    let film = |name: &str, tags: &[&str]| {
        let mut ffmpeg = Command::new("ffmpeg");
        ffmpeg.args([
            "-v",
            "error",
            "-nostdin",
            "-f",
            "lavfi",
            "-i",
            "testsrc2=size=320x180:rate=30",
            "-frames:v",
            "6",
        ]);
        succeed(ffmpeg.args(tags).arg(folders.inbox().join(name)));
    };
    film("00202=67501=67501=67501.avi", &[]);
    film("00202=70000=67501=00033.avi", &[]);
    film("10247=5=5=5.avi", &[]);
    let tags = ["-metadata", "artist=Ram", "-metadata", "copyright=https://creativecommons.org/licenses/by/4.0/"];
    film("dusk=dusk.mkv", &tags);
    folders.answers(0, "import", &["."]);
    let credits = folders.answers(0, "credits", &[]);
    let told = |id| {
        let credit = credit(&credits, id);
        (credit["source"].clone(), credit["licence"].clone(), credit["sale"].clone())
    };
    assert_eq!(told("202.67501"), (json!("electricsheep.202.67501"), json!("CC-BY-NC-3.0"), json!("forbidden")));
    assert_eq!(told("10247.5").1, "LicenseRef-Electric-Sheep-Gold");
    assert_eq!(told("dusk"), (json!("dusk=dusk.mkv"), json!("CC-BY-4.0"), json!("permitted")));
    assert_eq!(credit(&credits, "dusk")["authors"], json!(["Ram"]));
    assert_eq!(credits["transitions"][0]["source"], "electricsheep.202.70000");
}

#[test]
fn a_bundle_for_sale_names_what_is_not_and_carries_the_credits() {
    let artist = Artist::new();
    let own = "[default]\nauthors = [\"Ada\"]\nlicence = \"CC-BY-4.0\"\n";
    let other = "[[sheep]]\nid = \"s1\"\nauthors = [\"Ram\"]\nlicence = \"CC-BY-NC-3.0\"\n\
                 [[transition]]\nfrom = \"s0\"\nto = \"s1\"\nlicence = \"LicenseRef-by-letter\"\n";
    fs::write(artist.at("flock/credits.toml"), format!("{own}{other}")).unwrap();
    let sold = artist.pack(&["--for-sale"]);
    let clips: Vec<_> =
        sold["not_for_sale"].as_array().unwrap().iter().map(|one| (&one["clip"], &one["sale"])).collect();
    assert!(clips.contains(&(&json!("s1.mp4"), &json!("forbidden"))), "{clips:?}");
    assert!(clips.contains(&(&json!("s0=s1.mp4"), &json!("unknown"))), "{clips:?}");
    assert!(!clips.iter().any(|(clip, _)| **clip == json!("s0.mp4")), "{clips:?}");
    assert_eq!(fs::read(artist.object("credits.toml")).unwrap(), fs::read(artist.at("flock/credits.toml")).unwrap());
    assert_eq!(artist.verify(0)["ok"], true);
    let mut unit = Command::new(programs::updater());
    unit.arg(artist.at("bundle")).arg("--store").arg(artist.at("store")).arg("--keys").arg(artist.at("artist.pub"));
    succeed(&mut unit);
    let taken_in = fs::read(artist.at("store/current/credits.toml")).unwrap();
    assert_eq!(taken_in, fs::read(artist.at("flock/credits.toml")).unwrap(), "a unit takes it as any other file");
    let words = ["pack", "flock", "bundle", "--key", "artist.key", "--passphrase-file", "passphrase", "--allow-jumps"];
    let said = artist.says(0, &[&words[..], &["--for-sale"]].concat());
    assert!(said.contains("warning: `s1.mp4` is under CC-BY-NC-3.0: not for sale\n"), "{said}");
    let given = artist.pack(&[]);
    assert_eq!(given["not_for_sale"], Value::Null, "{given}");
}

/// The text of a genome that was made here by chance, as if `author` had made it and given it `licence`.
fn signed(text: &str, author: &str, licence: &str) -> String {
    let forms = [
        ("licence=\"LicenseRef-ours\"", format!("nick=\"{author}\" licence=\"{licence}\"")),
        ("(licence \"LicenseRef-ours\")", format!("(authors \"{author}\") (licence \"{licence}\")")),
        ("licence = \"LicenseRef-ours\"", format!("authors = [\"{author}\"]\nlicence = \"{licence}\"")),
    ];
    let signed = forms.iter().fold(text.to_owned(), |text, (ours, own)| text.replace(ours, own));
    assert!(signed.contains(author) && signed.contains(licence), "{text}");
    signed
}

#[test]
fn a_bred_sheep_of_any_species_has_its_parents_authors_and_is_sold_only_if_both_may_be() {
    let folders = Folders::new();
    fs::remove_dir_all(folders.flock()).unwrap();
    let here = folders.scratch.path();
    let answer = |words: &[&str]| {
        let said = output(Command::new(programs::dreams()).current_dir(here).args(words).arg("--json"));
        assert_eq!(said.status.code(), Some(0), "{words:?}: {}", String::from_utf8_lossy(&said.stderr));
        json(&said)
    };
    let born = |brood: &Value| -> Vec<String> {
        brood["born"].as_array().unwrap().iter().map(|sheep| sheep["id"].as_str().unwrap().to_owned()).collect()
    };
    let mut families = Vec::new();
    // Pools of one seed would give their sheep the same ids.
    for (seed, species) in [("3", "flam3"), ("4", "expr"), ("5", "agents"), ("6", "plant")] {
        answer(&["pool", "new", species, "--seed", seed, "--species", species]);
        let parents = born(&answer(&["breed", species, "--brood", "2"]));
        for (parent, author, licence) in [(&parents[0], "Ada", "CC-BY-4.0"), (&parents[1], "Ram", "CC-BY-NC-4.0")] {
            let genome = here.join(format!("{species}/genomes/{parent}.{species}"));
            fs::write(&genome, signed(&fs::read_to_string(&genome).unwrap(), author, licence)).unwrap();
        }
        let child = born(&answer(&["breed", species, "--brood", "1", "--from", &parents.join(",")])).remove(0);
        answer(&["pool", "mark", species, "keep", &parents[0], &parents[1], &child]);
        let form = ["--size", "160x90", "--loop-frames", "30", "--transition-frames", "15"];
        answer(&[&["elect", species, "aurora", "--sheep", "3", "--for", species, "--write"][..], &form].concat());
        families.push((parents, child));
    }
    let credits = folders.answers(0, "credits", &[]);
    assert_eq!(credits["sheep"].as_array().unwrap().len(), 12, "{credits}");
    let sold = folders.says(1, "credits", &["--for-sale"]);
    for (parents, child) in families {
        let told = credit(&credits, &child);
        assert_eq!((&told["parents"], &told["authors"]), (&json!(parents), &json!(["Ada", "Ram"])), "{told}");
        assert_eq!((&told["licence"], &told["sale"]), (&json!("CC-BY-NC-4.0"), &json!("forbidden")), "{told}");
        assert!(sold.contains(&format!("`loops/{child}.mp4` is under CC-BY-NC-4.0: not for sale\n")), "{sold}");
        let designed = credit(&credits, &parents[0]);
        assert_eq!((&designed["authors"], &designed["sale"]), (&json!(["Ada"]), &json!("permitted")), "{designed}");
        assert!(!sold.contains(&format!("loops/{}.mp4", parents[0])), "{sold}");
    }
}

#[test]
fn a_licence_of_twenty_thousand_terms_is_shown_by_its_start_and_whole_in_json() {
    let folders = Folders::new();
    let licence = vec!["CC-BY-4.0"; 20_000].join(" AND ");
    folders.genomes("ram.flam3", &[flame(10, "name=\"ram\"", "")]);
    folders.answers(0, "import", &["ram.flam3"]);
    fs::write(folders.flock().join("credits.toml"), format!("[default]\nlicence = \"{licence}\"\n")).unwrap();
    let lines = folders.says(0, "credits", &[]);
    assert!(lines.contains("CC-BY-4.0 AND CC-BY-4.0") && lines.lines().all(|line| line.len() < 300), "{lines}");
    assert_eq!(folders.answers(0, "credits", &[])["sheep"][0]["licence"], licence);
}
