//! Arrows between the rooms of the player go one way.
//!
//! Owns the list of the rooms and of what each may see, and the claim that the sources see just that, in tests no more than
//! in the code. A room is a program or what all share; of `dreams-player` each folder is one, and each file that lies
//! beside them. Packages are [`super::layers`]'.
//!
//! Start at [`ROOMS`].

use std::collections::BTreeSet;

use super::tokens::{Token, read};

/// Every room, and the rooms that it sees: only such as stand above it, so that there is no circle.
const ROOMS: &[(&str, &[&str])] = &[
    ("src", &[]),
    ("dreams-mend", &["src"]),
    ("dreams-owner", &["src"]),
    ("dreams-update", &["src"]),
    ("fatal", &["src"]),
    ("settings", &["src"]),
    ("stream", &["src"]),
    ("recording", &["src", "stream"]),
    ("control", &["recording", "src"]),
    ("pipeline", &["control", "recording", "src", "stream"]),
    ("startup", &["control", "fatal", "recording", "settings", "src", "stream"]),
    ("status", &["control", "recording", "settings", "src", "stream"]),
    ("dreams-player", &["control", "fatal", "pipeline", "recording", "settings", "src", "startup", "status", "stream"]),
];
/// As many rooms, and arrows between them, as a reader keeps in mind.
const MOST_ROOMS: usize = 15;
const MOST_ARROWS: usize = 35;

/// The room of the file at `path`, seen from the player's folder.
fn room(path: &str) -> &str {
    let (program, rest) = path.split_once('/').unwrap_or(("build.rs", ""));
    match rest.split_once('/') {
        Some((room, _)) if program == "dreams-player" => room,
        None if program == "dreams-player" && !["main.rs", "run.rs"].contains(&rest) => rest.trim_end_matches(".rs"),
        _ => program,
    }
}

/// Whether `room` is one of `dreams-player`: there `crate::` leads to another.
fn is_inner(room: &str) -> bool {
    room == "dreams-player" || room != "src" && !room.starts_with("dreams-")
}

/// The rooms that the file of `room` names: by `crate::`, by `player::`, and as the player's root by `mod`.
fn seen<'t>(room: &str, tokens: &'t [Token]) -> BTreeSet<&'t str> {
    let mut seen = BTreeSet::new();
    for (at, token) in tokens.iter().enumerate() {
        let next = |by: usize| tokens.get(at + by).map_or("", |token| &*token.text);
        match (&*token.text, next(1), next(2)) {
            ("player", ":", ":") => drop(seen.insert("src")),
            ("crate", ":", ":") if is_inner(room) && next(3) == "{" => {
                let inside = tokens[at + 4..].iter().take_while(|inner| inner.depth > token.depth);
                let names = inside.filter(|inner| inner.depth == token.depth + 1);
                seen.extend(names.map(|name| &*name.text).filter(|text| is_room(text)));
            }
            ("crate", ":", ":") if is_inner(room) => drop(seen.insert(next(3))),
            ("mod", name, ";") if room == "dreams-player" => drop(seen.insert(name)),
            _ => {}
        }
    }
    seen
}

fn is_room(name: &str) -> bool {
    ROOMS.iter().any(|(room, _)| *room == name)
}

/// Every arrow between two rooms of the player.
fn arrows() -> BTreeSet<(String, String)> {
    let mut arrows = BTreeSet::new();
    for (path, text) in super::files(".rs") {
        let Some(path) = path.strip_prefix("player/").filter(|path| path.contains('/')) else { continue };
        let (from, tokens) = (room(path), read(path, &text));
        let others = seen(from, &tokens).into_iter().filter(|to| is_room(to) && *to != from);
        arrows.extend(others.map(|to| (from.to_owned(), to.to_owned())));
    }
    arrows
}

#[test]
fn the_rooms_of_the_player_see_what_is_listed_and_nothing_else() {
    let listed: BTreeSet<_> =
        ROOMS.iter().flat_map(|(from, to)| to.iter().map(|to| ((*from).to_owned(), (*to).to_owned()))).collect();
    let found = arrows();
    assert_eq!(found.difference(&listed).collect::<Vec<_>>(), Vec::<&(String, String)>::new(), "not listed");
    assert_eq!(listed.difference(&found).collect::<Vec<_>>(), Vec::<&(String, String)>::new(), "not there");
    assert!(ROOMS.len() <= MOST_ROOMS && found.len() <= MOST_ARROWS, "{} rooms, {} arrows", ROOMS.len(), found.len());
}

#[test]
fn every_room_is_listed_below_what_it_sees() {
    for (at, (room, sees)) in ROOMS.iter().enumerate() {
        let above: Vec<_> = ROOMS[..at].iter().map(|(above, _)| *above).collect();
        assert!(sees.iter().all(|seen| above.contains(seen)), "`{room}` sees a room that stands below it");
    }
    let files = super::files(".rs");
    let rooms: BTreeSet<_> = files
        .iter()
        .filter_map(|(path, _)| path.strip_prefix("player/"))
        .map(room)
        .filter(|r| *r != "build.rs")
        .collect();
    assert_eq!(rooms, ROOMS.iter().map(|(room, _)| *room).collect());
}

#[test]
fn an_arrow_is_seen_however_it_is_written() {
    let text = "use crate::stream::plan::Plan;\nuse crate::{control::brightness, status};\nuse player::now::now;\n\
                mod fatal;\nfn a() { crate::recording::b(\"crate::settings\") } // crate::startup\n";
    let tokens = read("a.rs", text);
    assert_eq!(
        seen("pipeline", &tokens).into_iter().collect::<Vec<_>>(),
        ["control", "recording", "src", "status", "stream"]
    );
    assert!(seen("dreams-player", &tokens).contains("fatal"));
    assert_eq!(seen("dreams-mend", &tokens).into_iter().collect::<Vec<_>>(), ["src"], "its own `crate::` is another");
    for (path, expected) in [
        ("dreams-player/pipeline/presenter/tests.rs", "pipeline"),
        ("dreams-player/run.rs", "dreams-player"),
        ("dreams-player/fatal.rs", "fatal"),
        ("dreams-mend/plan.rs", "dreams-mend"),
        ("src/now.rs", "src"),
    ] {
        assert_eq!(room(path), expected);
    }
}
