//! Signed settings on a stick, for a unit that plays.
//!
//! Owns the claim on a whole machine: udev, the services, the owner's partition and the notice, without a restart. What is
//! refused is tried in `it/unit/settings_stick.rs`.

use crate::machine::PAUSE;
use crate::machine::picture::only_art;
use crate::owner::settings_error::has_notice;
use crate::starts::first_start::{OFTEN, playing_unit};
use claims::programs::{self, repository, succeed};
use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::process::Command;

/// For the unit's shell: waits until nobody works on the settings.
const IS_THROUGH: &str = "until ! systemctl list-units --all --plain --no-legend 'dreams-owner*@vda4.service' | grep -q activating; do sleep 1; done";
/// Which start of the machine this is.
const START: &str = "cat /proc/sys/kernel/random/boot_id";
/// Mounts the owner's partition, read-only.
const OPEN: &str = "mkdir -p /run/owner && mount -o ro /dev/vda4 /run/owner";

/// A FAT stick with the owner's file `text`, signed for the unit `lobby` by the key that the bench image trusts.
fn stick(folder: &Path, text: &str) -> std::path::PathBuf {
    let at = |name: &str| folder.join(name);
    fs::write(at("dreams.toml"), text).unwrap();
    fs::write(at("passphrase"), "velvet\n").unwrap();
    fs::copy(repository().join("tests/fixtures/keys/artist.key"), at("artist.key")).unwrap();
    for secret in ["passphrase", "artist.key"] {
        fs::set_permissions(at(secret), fs::Permissions::from_mode(0o600)).unwrap();
    }
    let mut sign = Command::new(programs::dreams());
    sign.arg("settings").arg(at("dreams.toml")).args(["--unit", "lobby", "--key"]).arg(at("artist.key"));
    succeed(sign.arg("--passphrase-file").arg(at("passphrase")).arg("--out").arg(at("stick")));
    let disk = at("stick.img");
    fs::File::create(&disk).unwrap().set_len(64 << 20).unwrap();
    succeed(Command::new("mkfs.vfat").args(["-F", "32"]).arg(&disk));
    succeed(Command::new("mcopy").arg("-s").arg("-i").arg(&disk).arg(at("stick/settings")).arg("::"));
    disk
}

#[test]
fn settings_on_a_stick_are_in_use_without_a_restart() {
    let before = fs::read_to_string(&playing_unit().stick.owner).unwrap();
    let new = format!("{before}wifi = \"Hall\"\nwifi_password = \"satin above\"\ndns = [\"192.0.2.53\"]\n");
    let folder = tempfile::tempdir().unwrap();
    let disk = stick(folder.path(), &new);
    let (_unit, mut machine) = playing_unit().snapshot.wake();
    let start = machine.run(START);

    machine.plug(&disk);
    let mut looks = machine.watch_for(PAUSE, "a notice", has_notice);
    let notice = "until grep -q 'New settings are in use. You may remove the stick.' /run/dreams-update/notice; do sleep 1; done";
    looks.extend(machine.watch_while(PAUSE, notice));
    let kept = "until grep -q Hall /var/lib/dreams/owner/dreams.toml.kept; do sleep 1; done";
    looks.extend(machine.watch_while(PAUSE, &format!("{kept}; {IS_THROUGH}")));
    assert!(machine.run("cat /var/lib/dreams/owner/wifi.conf").contains("psk=\"satin above\""));
    machine.run("grep -q 'DNS=192.0.2.53' /run/dreams-owner/wired.conf");
    let read = |name: &str| format!("{OPEN} && cat /run/owner/{name}; umount /run/owner");
    assert_eq!(machine.run(&read("dreams.toml")), new.trim());
    assert_eq!(machine.run(&read("dreams-before.toml")), before.trim());
    machine.run("! grep /run/dreams-mounts/ /proc/mounts && [ ! -e /var/lib/dreams/owner/arrived.json ]");
    // Nobody but their own user reads the password there.
    machine.run("! setpriv --reuid=dreams --regid=dreams --clear-groups grep -rqs satin /var/lib/dreams/owner");

    machine.pull();
    machine.take_stick();
    machine.plug(&disk);
    let known = "until grep -q 'has had these settings already' /run/dreams-update/notice; do sleep 1; done";
    looks.extend(machine.watch_while(PAUSE, &format!("{known}; {IS_THROUGH}")));
    assert_eq!(machine.run(&read("dreams-before.toml")), before.trim(), "nothing is written again");
    assert_eq!(machine.run(START), start, "the machine was not started again");
    only_art(&looks, OFTEN);
    machine.is_well();
}
