//! A stick is plugged in, and its flock plays.
//!
//! Owns the claim on the screen: the picture, the notice on it, the new picture.

use crate::machine::PAUSE;
use crate::machine::picture::{Look, only_art};
use crate::starts::first_start::{MOVES, OFTEN, PlayingUnit, playing_unit};
use crate::unit::stick::{AUTUMN, CLIPS};

/// Whether the look shows the flock of the stick, without a notice.
pub(crate) fn is_autumn(look: &Look) -> bool {
    look.place.as_ref().is_some_and(|place| &*place.flock == AUTUMN && !place.has_notice)
}

/// Whether all of these files have fs-verity, by the output of `lsattr`.
fn is_verified(objects: &str) {
    let flags = objects.lines().map(|line| line.split(' ').next().unwrap_or_default());
    assert!(flags.clone().count() > CLIPS && flags.clone().all(|flags| flags.contains('V')), "{objects}");
}

#[test]
fn a_stick_brings_a_flock_and_says_so_on_the_running_picture() {
    let PlayingUnit { snapshot, stick, .. } = playing_unit();
    let (_unit, mut machine) = snapshot.wake();
    machine.also_expect(stick.reference);
    machine.plug(&stick.disk);
    let looks = machine.watch_for(PAUSE, "the flock of the stick", is_autumn);
    let since = only_art(&looks, OFTEN);
    let places = || since.iter().filter_map(|look| look.place.as_ref());
    assert!(places().any(|place| place.has_notice && &*place.flock == "demo"), "the notice is on the running picture");
    // Photographs on FAT cause no message; ext4 and empty partitions are not mounted.
    for part in 1..=2 {
        for service in ["update", "settings"] {
            machine.run(&format!("until systemctl --quiet is-active dreams-{service}@sda{part}; do sleep 1; done"));
        }
    }
    machine.run("! systemctl list-units --all --plain --no-legend 'dreams-update@*' | grep 'sda[34]'");
    machine.run("! grep /run/dreams-mounts/ /proc/mounts");
    is_verified(&machine.run("find /var/lib/dreams/store/objects -type f -exec lsattr {} +"));
    machine.pull();
    only_art(&machine.watch_move(PAUSE, MOVES), OFTEN);
    machine.run("[ -L /var/lib/dreams/store/current ]");
    machine.is_well();
}
