//! Votes at a button that the owner has set up, from the key to the owner's partition.
//!
//! Owns the claim on a whole machine: a keyboard that is plugged in, the settings, the totals, and the file that any
//! computer can read. `it` has the claims on what a press counts for.

use crate::machine::PAUSE;
use crate::machine::picture::only_art;
use crate::owner::settings_error::{OPEN, TAKE_IN};
use crate::starts::first_start::{MOVES, OFTEN, playing_unit};

/// Waits until the buttons are read.
const READ: &str = "until ls -l /proc/$(systemctl show -P MainPID dreams-votes)/fd 2> /dev/null | grep -q /dev/input/event; do sleep 1; done";
/// What would be sent.
const SHOW: &str = "dreams-votes --config /etc/dreams/votes.toml --show";

#[test]
fn a_button_that_the_owner_sets_up_is_counted_and_the_votes_come_to_the_owners_partition() {
    let (_unit, mut machine) = playing_unit().snapshot.wake();
    let (said, status) = machine.serial.run("systemctl is-active dreams-votes");
    assert!(status != 0, "nobody counts before a button is set up: {said}");
    machine.run(&format!("{OPEN} && echo 'button = \"any\"' >> /run/owner/dreams.toml"));
    machine.run(TAKE_IN);
    let mut looks = machine.watch_while(PAUSE, READ);
    looks.extend(machine.watch_move(PAUSE, MOVES));
    machine.press(&["ret"]);
    // The showing counts when it is over.
    looks.extend(
        machine.watch_while(PAUSE, &format!("until {SHOW} 2> /dev/null | grep -q '\"up\": 1'; do sleep 5; done")),
    );
    let copy = "systemctl start dreams-votes-copy@vda4 && mount -o ro /dev/vda4 /run/owner";
    looks.extend(machine.watch_while(PAUSE, copy));
    let copied = machine.run("cat /run/owner/votes.json");
    assert_eq!(copied.matches("\"up\": 1").count(), 1, "{copied}");
    assert!(copied.contains("\"ledger\"") && copied.contains("\"since_day\""), "{copied}");
    machine.run("grep -q '^button = \"any\"' /run/owner/dreams.toml && umount /run/owner");
    machine.run("! grep /run/dreams-mounts/ /proc/mounts");
    only_art(&looks, OFTEN);
    assert!(looks.iter().any(|look| look.place.as_ref().is_some_and(|place| place.has_mark)), "the press is answered");
    machine.is_well();
}
