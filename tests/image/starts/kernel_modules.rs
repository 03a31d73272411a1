//! The kernel modules and firmware files of a unit.
//!
//! Owns the claims that every kept module has what it needs, and that the build fails otherwise. The lists are in
//! `image-build/modules`; `image-build/prune` applies and checks them.

use crate::starts::first_start::playing_unit;
use claims::programs::{output, repository, succeed};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// The drivers of PC displays.
const DISPLAYS: &str = "i915 xe amdgpu nouveau ast mgag200 qxl bochs cirrus udl";

/// Copies of the root's modules and firmware, and of `prune` with its lists, in `folder`, to be changed.
fn copied(folder: &Path) -> PathBuf {
    let lib = folder.join("tree/usr/lib");
    fs::create_dir_all(&lib).unwrap();
    let from = repository().join("target/image/system/tree/usr/lib");
    succeed(Command::new("cp").args(["-al"]).args(["modules", "firmware"].map(|name| from.join(name))).arg(&lib));
    let build = repository().join("image-build");
    succeed(Command::new("cp").arg("-a").args(["modules", "prune"].map(|name| build.join(name))).arg(folder));
    lib
}

/// Whether `prune check` finds nothing, and its output.
fn check(folder: &Path) -> (bool, String) {
    let done = output(Command::new(folder.join("prune")).arg("check").arg(folder.join("tree")));
    (done.status.success(), String::from_utf8(done.stderr).unwrap())
}

/// The file below `folder` whose name begins with `name`.
fn find(folder: &Path, name: &str) -> PathBuf {
    let said = succeed(Command::new("find").arg(folder).args(["-name", &format!("{name}*")]));
    let mut found = std::str::from_utf8(&said).unwrap().lines();
    let first = found.next().unwrap_or_else(|| panic!("`{name}` is in the image"));
    assert_eq!(found.next(), None, "`{name}` is there once");
    first.into()
}

#[test]
fn a_module_or_a_firmware_file_that_a_kept_driver_needs_is_missed_when_it_is_absent() {
    let folder = tempfile::tempdir_in(repository().join("target/image")).unwrap();
    let lib = copied(folder.path());
    assert_eq!(check(folder.path()), (true, String::new()), "nothing is lacking in the image");

    fs::remove_file(find(&lib.join("modules"), "cec.ko")).unwrap();
    fs::remove_file(lib.join("firmware/i915/adlp_dmc.bin.zst")).unwrap();
    let (is_whole, said) = check(folder.path());
    assert!(!is_whole);
    for missed in [
        "module `drm_display_helper` needs `cec`, which is absent",
        "module `i915` needs `cec`, which is absent",
        "module `i915` needs the firmware `i915/adlp_dmc.bin`, which is absent",
    ] {
        assert!(said.contains(missed), "`{missed}` is said, found {said}");
    }
}

#[test]
fn a_line_of_the_lists_that_names_or_excuses_nothing_is_a_fault() {
    let folder = tempfile::tempdir_in(repository().join("target/image")).unwrap();
    copied(folder.path());
    let add = |list: &str, line: &str| {
        let path = folder.path().join("modules").join(list);
        fs::write(&path, format!("{}\n{line}\n", fs::read_to_string(&path).unwrap())).unwrap();
    };
    add("firmware.txt", "i915 i915/none_dmc.bin # why not");
    add("disks.txt", "drivers/ata/no_such_disk # why not");
    let (is_whole, said) = check(folder.path());
    assert!(!is_whole && said.contains("`i915 i915/none_dmc.bin` excuses nothing (firmware.txt, line "), "{said}");
    let done = output(Command::new(folder.path().join("prune")).arg("keep").arg(folder.path().join("tree")));
    let said = String::from_utf8(done.stderr).unwrap();
    assert!(!done.status.success() && said.contains("`drivers/ata/no_such_disk` names no module (disks.txt, line "));
}

#[test]
fn the_driver_of_every_display_loads_without_its_card() {
    let (_unit, mut machine) = playing_unit().snapshot.wake();
    for driver in DISPLAYS.split(' ') {
        machine.run(&format!("modprobe {driver} && [ -d /sys/module/{driver} ]"));
    }
}
