//! Sticks that people make wrongly, and sticks that are nobody's business.
//!
//! Owns the claims on the one sentence that the picture shows of the former, and on its silence about the latter.

use claims::bundle_maker::rubbish;
use claims::flocks::SMALL;
use claims::programs::{self, output};
use claims::unit::Unit;
use std::fs;
use std::os::unix::fs::symlink;
use std::process::Command;

#[test]
fn a_flock_that_nobody_has_signed_is_named_at_the_top_and_one_folder_down() {
    let said = "This stick has a flock that is not signed. Run dreams pack, then dreams publish.";
    let manifest = SMALL.flock().folder.join("flock.toml");
    for place in ["", "my flock"] {
        let unit = Unit::new();
        fs::create_dir_all(unit.stick().join(place)).unwrap();
        fs::copy(&manifest, unit.stick().join(place).join("flock.toml")).unwrap();
        let answer = unit.updated(&[]);
        assert_eq!((&answer["outcome"], &answer["astray"]), (&"no-bundle".into(), &"unsigned".into()), "`{place}`");
        assert_eq!(unit.notice().as_deref(), Some(said), "`{place}`");
    }
}

#[test]
fn a_bundle_one_folder_down_is_not_installed_and_its_folder_is_named() {
    let cases = [
        ("autumn", "The flock is in the folder autumn. Copy its contents to the top of the stick."),
        ("\u{1b}[2J evil", "The flock is in a folder of this stick. Copy its contents to the top of the stick."),
    ];
    for (folder, said) in cases {
        let unit = Unit::new();
        unit.maker.bundle(&unit.stick().join(folder), &rubbish(3, 5_000, 0), &[], 1);
        // The artist's flock, whose bundles are beside it.
        fs::write(unit.stick().join("flock.toml"), "format = 1").unwrap();
        assert_eq!(unit.updated(&[])["outcome"], "no-bundle");
        assert_eq!((unit.notice().as_deref(), unit.playing()), (Some(said), None));
    }
}

#[test]
fn photographs_and_links_are_nobodys_business() {
    let unit = Unit::new();
    for folder in ["DCIM/100MEDIA", "seals", "System Volume Information"] {
        fs::create_dir_all(unit.stick().join(folder)).unwrap();
    }
    fs::write(unit.stick().join("DCIM/100MEDIA/flock.toml"), "two folders down").unwrap();
    fs::write(unit.stick().join("IMG_0001.JPG"), "holiday").unwrap();
    for deleted in [".Trash-1000/files", "$RECYCLE.BIN", ".Trashes"] {
        fs::create_dir_all(unit.stick().join(deleted)).unwrap();
        fs::write(unit.stick().join(deleted.split('/').next().unwrap()).join("flock.toml"), "a flock").unwrap();
    }
    symlink(SMALL.flock().folder, unit.stick().join("link")).unwrap();
    symlink(SMALL.flock().folder.join("flock.toml"), unit.stick().join("flock.toml")).unwrap();
    let answer = unit.updated(&[]);
    assert_eq!((&answer["outcome"], &answer["astray"]), (&"no-bundle".into(), &serde_json::Value::Null));
    assert_eq!(unit.notice(), None);
}

#[test]
fn a_stick_of_windows_or_a_mac_is_named_with_the_format_that_it_needs() {
    let rule = fs::read_to_string(programs::repository().join("systemd/80-dreams-update.rules")).unwrap();
    let types = "ntfs|apfs|hfs|hfsplus";
    let starts = "dreams-unreadable@$env{ID_FS_TYPE}.service";
    assert!(
        rule.lines()
            .any(|line| line.starts_with(&format!("ENV{{ID_FS_TYPE}}==\"{types}\", ")) && line.contains(starts))
    );
    let unit = Unit::new();
    for (kind, name) in types.split('|').zip(["NTFS", "APFS", "HFS", "HFS+"]) {
        let mut command = Command::new(programs::updater());
        let said = output(command.args(["--unreadable", kind, "--notice"]).arg(unit.path("notice")));
        assert_eq!(said.status.code(), Some(1), "{}", String::from_utf8_lossy(&said.stderr));
        let notice = format!("This stick is formatted as {name}. This frame reads FAT32 and exFAT.");
        assert_eq!(unit.notice(), Some(notice));
    }
    let unknown = output(Command::new(programs::updater()).args(["--unreadable", "zfs"]));
    assert_eq!(unknown.status.code(), Some(2));
}
