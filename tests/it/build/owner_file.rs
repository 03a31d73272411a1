//! The owner's file of an image, for a batch of units.
//!
//! Owns the claims on `dreams-owner check`, and on `image-build/build --owner` as far as it goes without making an image.

use claims::owner::Settings;
use claims::programs::{output, owner, repository, units};
use std::fs;
use std::path::Path;
use std::process::Command;

/// The exit status, standard output and standard error of `dreams-owner check` for a file with this text.
fn checked(file: &Path, text: &[u8]) -> (Option<i32>, String, String) {
    fs::write(file, text).unwrap();
    let said = output(Command::new(owner()).arg("check").arg(file));
    let text = |bytes: &[u8]| String::from_utf8(bytes.to_owned()).unwrap();
    (said.status.code(), text(&said.stdout), text(&said.stderr))
}

#[test]
fn an_owners_file_is_checked_as_a_unit_checks_it() {
    let settings = Settings::new();
    let file = settings.path("batch-of-ten.toml");
    let good = "wifi = \"Home\"\nwifi_password = \"velvet under\"\nhours = \"08:00-23:00\"\n";
    assert_eq!(checked(&file, good.as_bytes()), (Some(0), "hours\nwifi\nwifi_password\n".to_owned(), String::new()));
    assert_eq!(checked(&file, b"# unit = \"lobby\"\n"), (Some(0), String::new(), String::new()));
    let marked = [b"\xef\xbb\xbf", "unit = \"lobby\"\n".as_bytes()].concat();
    assert_eq!(checked(&file, &marked), (Some(0), "unit\n".to_owned(), String::new()), "as Windows saves it");
    let far_too_long = vec![b'#'; 70_000];
    for (text, code, said) in [
        (&b"unit = \"lobby\"\nhours = \"8-23\"\n"[..], 2, "batch-of-ten.toml` line 2, key `hours`"),
        (b"wifi = \"Home\"\nwifi_password = \"velvet\"\n", 2, "line 2, key `wifi_password`"),
        (b"wifi_password = \"velvet under\"\n", 2, "line 1, key `wifi_password`: it needs `wifi`"),
        (b"hour = 1\n", 2, "unknown field `hour`"),
        (b"", 2, "it is empty"),
        (b"\xff\xfeu\0n\0i\0t\0", 2, "save it as UTF-8"),
        (&far_too_long, 3, "cannot read"),
    ] {
        let (exit, out, error) = checked(&file, text);
        assert!(exit == Some(code) && out.is_empty() && error.contains(said), "{exit:?}: {error}");
        assert!(!error.contains("velvet"), "{error}");
        fs::copy(&file, settings.path("partition/dreams.toml")).unwrap();
        assert_eq!(output(&mut settings.taking()).status.code(), Some(code), "the unit says the same of it");
    }
    assert_eq!(output(Command::new(owner()).arg("check").arg(settings.path("none"))).status.code(), Some(3));
    assert_eq!(output(Command::new(owner()).arg("check").arg(settings.path("partition"))).status.code(), Some(3));
}

#[test]
fn a_build_refuses_a_wrong_owners_file_before_it_makes_anything() {
    let folder = tempfile::tempdir().unwrap();
    let [file, image] = ["batch.toml", "image"].map(|name| folder.path().join(name));
    fs::write(&file, "# For ten units.\nwifi = \"Home\"\nwifi_password = \"short\"\n").unwrap();
    let mut build = Command::new(repository().join("image-build/build"));
    build.env("BUILT", units()).arg(&image).arg("--owner").arg(&file);
    let said = output(&mut build);
    let error = String::from_utf8_lossy(&said.stderr);
    assert_eq!(said.status.code(), Some(2), "{error}");
    assert!(error.contains("batch.toml` line 3, key `wifi_password`: a password has 8 to 63"), "{error}");
    assert!(!image.exists(), "nothing was made");
}
