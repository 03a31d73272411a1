//! A mistake in the owner's settings, and its correction.
//!
//! Owns the claim on the screen: the picture with a notice on the mistake, until it is corrected.

use crate::machine::PAUSE;
use crate::machine::picture::{Look, only_art};
use crate::starts::first_start::{MOVES, OFTEN, playing_unit};

/// The owner's settings that the unit has applied.
const KEPT: &str = "cat /var/lib/dreams/owner/dreams.toml";
/// Mounts the owner's partition at /run/owner.
pub(crate) const OPEN: &str = "mkdir -p /run/owner && mount /dev/vda4 /run/owner";
/// Unmounts it and has the unit apply the settings, as at a start; an earlier run is waited for.
pub(crate) const TAKE_IN: &str = "umount /run/owner && \
    until [ \"$(systemctl show -P ActiveState dreams-owner@vda4)\" != activating ]; do sleep 1; done && \
    systemctl start --no-block dreams-owner@vda4";

/// Whether there is a notice.
pub(crate) fn has_notice(look: &Look) -> bool {
    look.place.as_ref().is_some_and(|place| place.has_notice)
}

#[test]
fn what_is_wrong_in_the_owners_file_is_told_over_the_running_picture_until_it_is_right() {
    let (_unit, mut machine) = playing_unit().snapshot.wake();
    let before = machine.run(KEPT);
    let file = "/run/owner/dreams.toml";
    machine.run(&format!("{OPEN} && echo 'brightness = 400' >> {file}"));
    machine.run(TAKE_IN);
    let mut looks = machine.watch_for(PAUSE, "a notice", has_notice);
    let notice = machine.run("cat /run/dreams-update/notice.settings; echo");
    assert!(notice.contains("dreams.toml line 3: brightness is 1 to 100, or as"), "{notice}");
    assert_eq!(machine.run(KEPT), before, "what was right before stays");
    looks.extend(machine.watch_move(PAUSE, MOVES));

    machine.run(&format!("mount /dev/vda4 /run/owner && sed -i 's/= 400/= \"100\"/' {file} && {TAKE_IN}"));
    looks.extend(machine.watch_for(PAUSE, "the picture without a notice", |look| look.is_art() && !has_notice(look)));
    machine.run("[ ! -e /run/dreams-update/notice.settings ]");
    assert_eq!(machine.run(KEPT), format!("{before}\nbrightness = \"100\""));
    only_art(&looks, OFTEN);
    machine.is_well();
}
