//! Packages depend only on packages of lower layers.
//!
//! Owns the layer of every package, and the claim, for tests and build scripts as for the code. Never looks into a
//! file: [`super::sources`] does.
//!
//! Start at [`LAYERS`].

use std::collections::BTreeMap;

/// The layer of every package of ours.
const LAYERS: &[(&str, u8)] = &[
    ("durable", 0),
    ("diagnostics", 0),
    ("scaling", 0),
    ("species", 0),
    ("timing", 0),
    ("agents", 1),
    ("breeding", 1),
    ("expression", 1),
    ("plant", 1),
    ("flock", 1),
    ("screen", 1),
    ("video", 1),
    ("variations", 1),
    ("votes", 1),
    ("bundle", 2),
    ("flame", 2),
    ("operations", 3),
    ("settings", 3),
    ("commands", 4),
    ("studio", 4),
    ("fleet", 4),
    ("dreams", 5),
    ("player", 5),
    ("claims", 6),
];

/// The dependencies that do not go down, each as a sentence; and packages without a layer.
fn wrong_arrows(layers: &[(&str, u8)], arrows: &[(String, String)]) -> Vec<String> {
    let layers: BTreeMap<&str, u8> = layers.iter().copied().collect();
    let wrong = |(from, to): &(String, String)| match (layers.get(&**from), layers.get(&**to)) {
        (Some(above), Some(below)) if above > below => None,
        (Some(from_layer), Some(to_layer)) => Some(format!("{from} ({from_layer}) must not see {to} ({to_layer})")),
        _ => Some(format!("{from} sees {to}, and one of them has no layer")),
    };
    arrows.iter().filter_map(wrong).collect()
}

#[test]
fn every_arrow_goes_down() {
    let packages = super::metadata(false).packages;
    let ours = |name: &str| packages.iter().any(|package| *package.name == name);
    let arrows: Vec<_> = packages
        .iter()
        .flat_map(|package| package.dependencies.iter().map(|to| (package.name.to_string(), to.name.clone())))
        .filter(|(_, to)| ours(to))
        .collect();
    assert!(arrows.len() > LAYERS.len(), "only these arrows were seen: {arrows:?}");
    assert_eq!(wrong_arrows(LAYERS, &arrows), [""; 0]);
}

#[test]
fn an_arrow_up_or_sideways_is_found() {
    let arrow = |from: &str, to: &str| (from.to_owned(), to.to_owned());
    let arrows = [arrow("flock", "timing"), arrow("flock", "video"), arrow("timing", "player"), arrow("new", "timing")];
    assert_eq!(
        wrong_arrows(LAYERS, &arrows),
        [
            "flock (1) must not see video (1)",
            "timing (0) must not see player (5)",
            "new sees timing, and one of them has no layer",
        ]
    );
}

#[test]
fn every_package_has_a_layer_and_every_layer_its_packages() {
    let mut packages: Vec<_> = super::metadata(false).packages.iter().map(|package| package.name.to_string()).collect();
    let mut layered: Vec<_> = LAYERS.iter().map(|(name, _)| (*name).to_owned()).collect();
    packages.sort();
    layered.sort();
    assert_eq!(packages, layered);
}

#[test]
fn no_program_has_the_name_of_one_that_every_linux_machine_has() {
    let metadata = super::metadata(false);
    let roots = metadata.packages.iter().filter(|package| ["player", "dreams"].contains(&package.name.as_str()));
    let programs: Vec<_> = roots.flat_map(|package| &package.targets).filter(|target| target.is_bin()).collect();
    assert!(programs.len() > 4, "{programs:?}");
    // util-linux has `flock`, on whose place in the path ours must not depend.
    let others = |name: &str| name != "dreams" && !name.starts_with("dreams-");
    let foreign: Vec<_> = programs.iter().map(|target| &target.name).filter(|name| others(name)).collect();
    assert!(foreign.is_empty(), "{foreign:?}");
}

#[test]
fn the_layers_drawn_in_the_architecture_are_the_layers_held_here() {
    let architecture = super::read("ARCHITECTURE.md");
    let mut drawn = Vec::new();
    for line in super::section(&architecture, "## Layers") {
        let mut cells = line.split('|').skip(1).map(str::trim);
        let Some(Ok(layer)) = cells.next().map(str::parse::<u8>) else { continue };
        let packages = super::quoted(cells.next().unwrap_or_default());
        drawn.extend(packages.into_iter().map(|package| (package.to_owned(), layer)));
    }
    let mut held: Vec<_> = LAYERS.iter().map(|(name, layer)| ((*name).to_owned(), *layer)).collect();
    drawn.sort();
    held.sort();
    assert_eq!(drawn, held);
}
