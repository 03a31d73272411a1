//! The licences of our dependencies.
//!
//! Owns the claim that every dependency may be used under a licence that `deny.toml` allows. The list is there, with
//! its reasons, so that `cargo deny` and this test read the same one. Dependencies for other operating systems are left
//! out: they are never built.
//!
//! Start at [`refused`].

use spdx::{Expression, LicenseReq, ParseMode};

/// Why a package under `licence` is not allowed, if it is not: `allowed` are SPDX identifiers.
fn refused(allowed: &[String], licence: Option<&str>) -> Option<String> {
    let Some(licence) = licence else { return Some("names no licence".to_owned()) };
    let Ok(expression) = Expression::parse_mode(licence, ParseMode::LAX) else {
        return Some(format!("`{licence}` is not an SPDX expression"));
    };
    let agreed = |requirement: &LicenseReq| allowed.contains(&requirement.to_string());
    (!expression.evaluate(agreed)).then(|| format!("`{licence}` is not allowed"))
}

fn allowed() -> Vec<String> {
    let deny: toml::Table = super::read("deny.toml").parse().unwrap();
    let list = deny["licenses"]["allow"].as_array().expect("`allow` is a list");
    list.iter().map(|licence| licence.as_str().unwrap().to_owned()).collect()
}

#[test]
fn every_package_is_under_a_licence_that_we_allow() {
    let metadata = super::metadata(true);
    let built: Vec<_> = metadata.resolve.as_ref().unwrap().nodes.iter().map(|node| &node.id).collect();
    let allowed = allowed();
    let packages = metadata.packages.iter().filter(|package| built.contains(&&package.id));
    let faults: Vec<_> = packages
        .filter_map(|package| Some(format!("{}: {}", package.name, refused(&allowed, package.license.as_deref())?)))
        .collect();
    assert_eq!(faults, [""; 0]);
}

#[test]
fn a_licence_that_is_not_allowed_is_refused() {
    let allowed = ["MIT".to_owned(), "Zlib".to_owned()];
    let judge = |licence| refused(&allowed, licence);
    assert_eq!(judge(Some("MIT OR GPL-3.0-only")), None);
    assert_eq!(judge(Some("GPL-2.0/MIT")), None);
    assert_eq!(judge(Some("MIT AND GPL-3.0-only")).unwrap(), "`MIT AND GPL-3.0-only` is not allowed");
    assert_eq!(judge(Some("ours")).unwrap(), "`ours` is not an SPDX expression");
    assert_eq!(judge(None).unwrap(), "names no licence");
}

#[test]
fn every_allowed_licence_is_used_and_the_unusual_ones_say_why() {
    let deny = super::read("deny.toml");
    let packages = super::metadata(true).packages;
    for licence in allowed() {
        let used = packages.iter().any(|package| package.license.as_ref().is_some_and(|text| text.contains(&licence)));
        assert!(used, "no package is under `{licence}`");
        let line = deny.lines().find(|line| line.contains(&format!("\"{licence}\""))).unwrap();
        assert!(line.contains('#'), "`{licence}` is allowed without a reason");
    }
}

#[test]
fn our_own_licence_is_either_of_two_and_both_texts_lie_here() {
    let packages = super::metadata(false).packages;
    assert!(packages.iter().all(|package| package.license.as_deref() == Some("MIT OR Apache-2.0")));
    assert!(super::read("LICENSE-MIT").starts_with("MIT License"));
    assert!(super::read("LICENSE-APACHE").contains("Apache License\n                           Version 2.0"));
}
