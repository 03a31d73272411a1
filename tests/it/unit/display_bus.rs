//! Which I2C buses of a machine belong to its displays.
//!
//! Owns the claim on `display-bus`, tried on a folder that stands for the `/sys` of a machine, and that the udev rules and
//! the player's sandbox give away no others.

use claims::programs::{output, repository};
use std::fs;
use std::os::unix::fs::symlink;
use std::process::Command;

#[test]
fn only_the_buses_of_connectors_are_a_displays() {
    let root = tempfile::tempdir().unwrap();
    let at = |path: &str| root.path().join("sys").join(path);
    let card = "devices/pci0000:00/0000:00:02.0";
    let connector = |name: &str| at(&format!("{card}/drm/card1/card1-{name}"));
    // The SMBus of the mainboard, and the buses of a card: of a connector, of its AUX channel, of the card's regulator.
    for bus in ["devices/pci0000:00/0000:00:1f.4/i2c-0", &format!("{card}/i2c-3"), &format!("{card}/i2c-33")] {
        fs::create_dir_all(at(bus)).unwrap();
    }
    fs::create_dir_all(connector("DP-1").join("i2c-7/i2c-dev")).unwrap();
    fs::create_dir_all(connector("HDMI-A-1")).unwrap();
    fs::create_dir_all(at("class/drm")).unwrap();
    symlink(at(&format!("{card}/i2c-3")), connector("HDMI-A-1").join("ddc")).unwrap();
    for name in ["DP-1", "HDMI-A-1"] {
        symlink(connector(name), at("class/drm").join(format!("card1-{name}"))).unwrap();
    }
    let is_a_displays = |name: &&str| {
        let mut command = Command::new(repository().join("systemd/display-bus"));
        let said = output(command.arg(name).arg(root.path()));
        assert!(said.stderr.is_empty(), "{}", String::from_utf8_lossy(&said.stderr));
        said.status.success()
    };
    let buses = ["i2c-0", "i2c-3", "i2c-33", "i2c-7", "i2c", "ddc", "i2c-dev"];
    assert_eq!(buses.into_iter().filter(is_a_displays).collect::<Vec<_>>(), ["i2c-3", "i2c-7"]);
}

#[test]
fn no_rule_gives_the_player_an_i2c_bus_that_is_not_a_displays() {
    let rules = fs::read_dir(repository().join("systemd")).unwrap().map(|entry| entry.unwrap().path());
    let rules = rules.filter(|path| path.extension().is_some_and(|extension| extension == "rules"));
    let lines: Vec<String> = rules
        .flat_map(|path| fs::read_to_string(path).unwrap().lines().map(str::to_owned).collect::<Vec<_>>())
        .collect();
    let giving: Vec<_> = lines.iter().filter(|line| line.contains("i2c") && line.contains("GROUP=")).collect();
    assert!(matches!(giving[..], [line] if line.contains("PROGRAM==\"/usr/lib/dreams/display-bus %k\"")), "{giving:?}");
}
