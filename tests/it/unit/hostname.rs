//! The host name of a unit.
//!
//! Owns the claims on `dreams-name`, tried on folders that stand for the `/sys` and `/proc` of machines. What the
//! network sees of the name is tried on a whole machine, in `image/network/dhcp_request.rs`.

use claims::programs::{repository, succeed};
use claims::wait;
use std::fs;
use std::path::Path;
use std::process::Command;
use tempfile::TempDir;

/// The `/sys` and `/proc` of a machine.
struct Machine {
    root: TempDir,
}

impl Machine {
    /// One whose machine id is not derived from its cards.
    fn new() -> Self {
        let machine = Self { root: tempfile::tempdir().unwrap() };
        machine.says("proc/sys/kernel/hostname", "dreams");
        machine.says("etc/machine-id", "03000200040005000006000700abcdef");
        fs::create_dir_all(machine.root.path().join("var/lib/dreams")).unwrap();
        machine
    }

    fn says(&self, path: &str, text: &str) {
        let path = self.root.path().join(path);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, format!("{text}\n")).unwrap();
    }

    /// Adds a card on the PCI bus, with its address in `file`.
    fn has_card(&self, place: &str, class: &str, file: &str, address: &str) {
        self.says(&format!("sys/bus/pci/devices/{place}/class"), class);
        self.says(&format!("sys/bus/pci/devices/{place}/{file}"), address);
    }

    fn naming(&self) -> Command {
        let mut command = Command::new(repository().join("image-build/system/usr/bin/dreams-name"));
        command.arg(self.root.path());
        command
    }

    fn name(&self) -> String {
        succeed(&mut self.naming());
        self.is_called()
    }

    fn is_called(&self) -> String {
        fs::read_to_string(self.root.path().join("proc/sys/kernel/hostname")).unwrap().trim().to_owned()
    }
}

const CABLE: &str = "0x020000";
const RADIO: &str = "0x028000";

#[test]
fn a_unit_is_called_by_its_own_digits_unless_its_owner_has_named_it() {
    let machine = Machine::new();
    assert_eq!(machine.name(), "dreams-abcdef", "it has no card");
    machine.says("sys/bus/pci/devices/0000:00:02.0/class", "0x030000");
    machine.has_card("0000:02:00.0", RADIO, "net/wlan0/address", "0c:9a:3c:00:00:01");
    assert_eq!(machine.name(), "dreams-000001", "a radio and no cable");
    machine.has_card("0000:03:00.0", CABLE, "virtio1/net/enp3s0/address", "52:54:00:12:34:56");
    assert_eq!(machine.name(), "dreams-123456", "a cable before a radio");
    machine.has_card("0000:01:00.0", CABLE, "net/enp1s0/address", "00:e0:4c:68:00:0f");
    assert_eq!(machine.name(), "dreams-68000f", "the first of two, whichever driver was first");
    machine.says("proc/device-tree/serial-number", "10000000a3b2c1d0\0");
    assert_eq!(machine.name(), "dreams-b2c1d0", "a board with a number of its own");
    machine.says("var/lib/dreams/owner/name", "lobby");
    assert_eq!(machine.name(), "lobby");
}

#[test]
fn a_machine_without_any_number_of_its_own_keeps_the_name_of_its_first_start() {
    let machine = Machine::new();
    let made = "net/enp1s0/addr_assign_type";
    machine.has_card("0000:01:00.0", CABLE, "net/enp1s0/address", "32:11:22:33:44:55");
    machine.has_card("0000:01:00.0", CABLE, made, "1");
    assert_eq!(machine.name(), "dreams-abcdef", "an address by chance is none");
    machine.has_card("0000:01:00.0", CABLE, "net/enp1s0/address", "9a:66:77:88:99:aa");
    machine.says("etc/machine-id", "4a1f0c60b52e4d8fa1c7d1b3e9123456");
    assert_eq!(machine.name(), "dreams-abcdef", "another machine id, another address by chance");
    machine.has_card("0000:01:00.0", CABLE, made, "0");
    assert_eq!(machine.name(), "dreams-8899aa", "its own address");
    machine.has_card("0000:01:00.0", CABLE, made, "1");
    assert_eq!(machine.name(), "dreams-8899aa", "a start at which its address is not found");
    machine.says("var/lib/dreams/name", "../../etc\n");
    assert_eq!(machine.name(), "dreams-123456", "what is kept is no digits");
    fs::remove_dir_all(machine.root.path().join("var/lib/dreams")).unwrap();
    assert_eq!(machine.name(), "dreams-123456", "a disk that keeps nothing");
}

/// A card gets its driver while the unit is being named, after so many seconds.
fn a_late_card(machine: &Machine, seconds: u32) {
    machine.says("sys/bus/pci/devices/0000:01:00.0/class", CABLE);
    let mut naming = machine.naming().spawn().unwrap();
    assert!(!wait::ends_within(&naming, seconds), "it waits");
    let address = Path::new("sys/bus/pci/devices/0000:01:00.0/net/enp1s0");
    machine.says(address.with_extension("new").join("address").to_str().unwrap(), "52:54:00:12:34:56");
    let at = |path: &Path| machine.root.path().join(path);
    fs::rename(at(&address.with_extension("new")), at(address)).unwrap();
    assert!(wait::ended("dreams-name, which waits for the card", 120, &mut naming).success());
    assert_eq!(machine.is_called(), "dreams-123456");
}

#[test]
fn a_card_whose_driver_comes_late_is_waited_for() {
    a_late_card(&Machine::new(), 0);
}

#[test]
fn a_slow_machine_has_the_same_name_as_when_it_is_fast() {
    let machine = Machine::new();
    machine.says("run/udev/queue", "");
    a_late_card(&machine, 12);
}
