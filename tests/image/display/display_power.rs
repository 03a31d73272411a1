//! A display that is to switch itself off.
//!
//! Owns the claim that the player reaches the I2C bus of its display in its sandbox, and no other. QEMU's displays have no such
//! bus: that of the mainboard stands for it, which refuses the messages of a display.

use crate::machine::PAUSE;
use crate::starts::first_start::{MOVES, playing_unit};

const CONNECTOR: &str = "/sys/class/drm/card0-Virtual-1";
/// The group and the rights of the node.
const RIGHTS: &str = "stat -c '%G %a' /dev/i2c-0";

#[test]
fn the_player_asks_its_display_by_the_bus_of_that_and_by_no_other() {
    let (_unit, mut machine) = playing_unit().snapshot.wake();
    machine.run("until [ -c /dev/i2c-0 ]; do sleep 1; done; udevadm settle -t 240");
    assert!(machine.run(RIGHTS).trim().starts_with("root 600"), "it leads to the mainboard");
    machine.run(&format!("mount -t tmpfs -o mode=755 bus {CONNECTOR} && mkdir {CONNECTOR}/i2c-0"));
    machine.run("udevadm trigger --settle --action=change /sys/class/drm/card0");
    assert!(machine.run(RIGHTS).trim().starts_with("video 660"), "it is said to be a display's");
    machine.run("systemctl restart dreams-player");
    machine.run(
        "cd /var/lib/dreams/owner && rm -f dreams.toml.kept && \
         printf 'hours = \"08:00-23:00\"\\ntimezone = \"UTC\"\\nnight = \"ddc\"\\n' >> dreams.toml",
    );
    let is_told = |asked: &str| {
        format!(
            "until dreams-status | grep -A3 '\"display_power\": {{' | tr -d '\\n' | grep -q '{asked}'; do sleep 1; done"
        )
    };
    let [off, on] = ["off", "on"].map(|asked| format!("\"asked\": \"{asked}\".*cannot send `set power mode`"));
    machine.run("date -u -s '2047-03-01 23:30:00'");
    machine.run(&is_told(&off));
    machine.run("until dreams-status | grep -q '\"screen\": null'; do sleep 1; done");
    machine.run("date -u -s '2047-03-02 09:00:00'");
    machine.watch_move(PAUSE, MOVES);
    machine.run(&is_told(&on));
    machine.is_well();
}
