//! Whose certificates a unit accepts, and what it makes of their dates.
//!
//! Owns the claims on TLS. The certificates are in `tests/fixtures/certificates`, each named for its defect: all are of one
//! authority, which only those know who are told.

use claims::bundle_maker::rubbish;
use claims::programs::output;
use claims::unit::Unit;
use claims::web::WebServer;
use std::fs;
use std::path::{Path, PathBuf};

/// The date of a system that is older than this machine's start, and that of one that is of the future.
const OLD: &str = "2026-01-01T00:00:00Z";
const FUTURE: &str = "2096-01-01T00:00:00Z";

/// A unit for which there is a bundle, and what it knows.
struct Visitor {
    unit: Unit,
    /// Its system's date.
    made: &'static str,
    /// Whether a time server has set its clock.
    is_synchronised: bool,
    /// The file of its system's authorities.
    authorities: PathBuf,
}

/// The file of the authority.
fn authority() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/certificates/authority.pem")
}

impl Visitor {
    fn new() -> Self {
        let unit = Unit::new();
        unit.maker.bundle(&unit.stick(), &rubbish(2, 500, 0), &["lobby"], 1);
        Self { unit, made: OLD, is_synchronised: true, authorities: authority() }
    }

    /// Writes the owner's settings.
    fn owner_sets(&self, text: &str) {
        fs::write(self.unit.path("owner.toml"), text).unwrap();
    }

    /// Updates from a server with this certificate; returns the exit code, and what was said.
    fn looks(&self, certificate: &str) -> (Option<i32>, String) {
        let at = |name: &str| self.unit.path(name);
        fs::write(at("os-release"), format!("ID=other\nDREAMS_DATE={}\n", self.made)).unwrap();
        fs::write(at("set"), "").unwrap();
        let settings = [
            ("system", at("os-release")),
            ("synchronised", at(if self.is_synchronised { "set" } else { "nothing" })),
            ("authorities", self.authorities.clone()),
            ("owner", at("owner.toml")),
        ];
        let config: String = settings.map(|(key, path)| format!("{key} = \"{}\"\n", path.display())).concat();
        fs::write(at("update.toml"), config).unwrap();
        let web = WebServer::serve_by_tls(&self.unit.stick(), certificate);
        let mut look = self.unit.update_from(Some(Path::new(&web.url())));
        let said = output(look.arg("--config").arg(at("update.toml")));
        (said.status.code(), String::from_utf8(said.stderr).unwrap())
    }
}

#[test]
fn authorities_of_the_system_and_of_the_owner_vouch_for_a_server_and_what_cannot_be_read_is_told() {
    const UNREAD: &str = "cannot read the system's certificate authorities";
    let mut visitor = Visitor::new();
    let (code, said) = visitor.looks("good.pem");
    assert!(code == Some(0) && !said.contains("authorities"), "of the system: {code:?} {said}");
    visitor.authorities = visitor.unit.path("nothing.pem");
    let (code, said) = visitor.looks("good.pem");
    assert!(code == Some(3) && said.contains("its issuer is not trusted") && said.contains(UNREAD), "{code:?} {said}");
    let pem = fs::read_to_string(authority()).unwrap();
    visitor.owner_sets(&format!("authorities = \"\"\"\n{pem}\"\"\"\n"));
    let (code, said) = visitor.looks("good.pem");
    assert!(code == Some(0) && said.contains(UNREAD), "of the owner: {code:?} {said}");
    visitor.owner_sets("");
    fs::write(&visitor.authorities, pem + "-----BEGIN CERTIFICATE-----\nAAAA\n-----END CERTIFICATE-----\n").unwrap();
    let (code, said) = visitor.looks("good.pem");
    assert!(code == Some(0) && said.contains("not all of the system's"), "those that can be read: {code:?} {said}");
}

#[test]
fn chain_and_name_of_a_certificate_count_whatever_a_unit_knows_of_the_time() {
    let mut visitor = Visitor::new();
    for (made, is_synchronised) in [(OLD, true), (OLD, false), (FUTURE, false)] {
        (visitor.made, visitor.is_synchronised) = (made, is_synchronised);
        visitor.authorities = authority();
        let (code, said) = visitor.looks("for-another-name.pem");
        assert!(
            code == Some(3) && said.contains("it is for another name"),
            "{made} {is_synchronised}: {code:?} {said}"
        );
        visitor.authorities = "/dev/null".into();
        let (code, said) = visitor.looks("good.pem");
        assert!(code == Some(3) && said.contains("issuer is not trusted"), "{made} {is_synchronised}: {code:?} {said}");
    }
}

#[test]
fn a_unit_whose_clock_nobody_has_set_takes_a_certificate_of_the_future_and_none_that_has_expired() {
    let mut visitor = Visitor::new();
    for (certificate, made, is_synchronised, refused) in [
        ("good.pem", OLD, true, None),
        ("good.pem", OLD, false, None),
        ("good.pem", FUTURE, false, None),
        ("not-yet-valid.pem", OLD, true, Some("it is not valid yet")),
        ("not-yet-valid.pem", OLD, false, None),
        ("not-yet-valid.pem", FUTURE, false, None),
        ("expired.pem", OLD, true, Some("it has expired")),
        ("expired.pem", OLD, false, Some("it has expired")),
        ("expired.pem", FUTURE, false, Some("it has expired")),
        // By the clock alone it would be valid.
        ("good.pem", "2121-01-01T00:00:00Z", false, Some("it has expired")),
    ] {
        (visitor.made, visitor.is_synchronised) = (made, is_synchronised);
        let (code, said) = visitor.looks(certificate);
        let case = format!("{certificate}, {made}, {is_synchronised}");
        match refused {
            None => assert_eq!(code, Some(0), "{case}: {said}"),
            Some(why) => assert!(code == Some(3) && said.contains(why), "{case}: {code:?} {said}"),
        }
    }
}
