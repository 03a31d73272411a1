//! A panel with a backlight.
//!
//! Owns the claim that the player can set the backlight in its sandbox. QEMU has no panel: files like those of the
//! kernel's backlight class replace a folder of the connector that is not used.

use crate::starts::first_start::playing_unit;

const BACKLIGHT: &str = "/sys/class/drm/card0-Virtual-1/power";

#[test]
fn a_panel_is_dimmed_by_its_backlight_as_its_owner_has_set() {
    let (_unit, mut machine) = playing_unit().snapshot.wake();
    machine.run(&format!(
        "mount -t tmpfs -o mode=755 backlight {BACKLIGHT} && cd {BACKLIGHT} && echo 400 > max_brightness"
    ));
    machine.run("echo 7 > brightness && chgrp video brightness && chmod 660 brightness && cd /");
    machine.run("systemctl restart dreams-player");
    // A regular file is appended to, unlike one in `/sys`.
    let is_told = |power: &str| format!("until grep -q '{power}$' {BACKLIGHT}/brightness; do sleep 1; done");
    machine.run(&is_told("400"));
    // The player takes the two files of the settings only as they belong together, or the first without the second.
    machine.run("cd /var/lib/dreams/owner && rm -f dreams.toml.kept && echo 'brightness = \"30\"' >> dreams.toml");
    machine.run(&is_told("120"));
    machine.is_well();
}
