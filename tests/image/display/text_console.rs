//! A player that is started by hand on a text console.
//!
//! Owns the claims that one can switch to another console and read it, that the picture returns with the player's
//! console, and that the console shows text after the player has ended.

use crate::machine::picture::{Look, only_art};
use crate::machine::{Machine, PAUSE};
use crate::starts::first_start::{MOVES, OFTEN, UP};
use crate::unit::Unit;
use crate::unit::direct_boot::parts;
use claims::programs::repository;

const BY_HAND: &str = "setsid --ctty dreams-player --config /etc/dreams/player.toml --screen kms \
    < /dev/tty1 > /run/player.log 2>&1 &";

/// Waits until console `name` is shown without the picture.
fn shows_text(machine: &mut Machine, name: &str) {
    machine.watch_for(PAUSE, "an empty console", Look::is_dark);
    assert_eq!(machine.run("cat /sys/class/tty/tty0/active").trim(), name);
    machine.run(&format!("echo text > /dev/{name}"));
    // White on black, and little of it.
    machine.watch_for(PAUSE, "text", |look| !look.is_dark() && !look.is_art());
    machine.run(&format!("printf '\\033[2J' > /dev/{name}"));
    machine.watch_for(PAUSE, "an empty console", Look::is_dark);
}

#[test]
fn a_player_on_a_text_console_leaves_it_to_others_and_as_it_was() {
    let unit = Unit::new();
    let folder = tempfile::tempdir_in(repository().join("target/image")).unwrap();
    let mut words = parts(folder.path());
    // A unit draws no text; other machines do.
    let line = words.last_mut().unwrap();
    *line = line.replace("drm_kms_helper.fbdev_emulation=0", "");
    let mut machine = unit.start_with(&words);
    machine.await_shell();
    machine.run(UP);
    machine.run("systemctl set-property --runtime dreams.slice CPUWeight=20; systemctl stop dreams-player");
    machine.run(BY_HAND);
    machine.watch_move(PAUSE, MOVES);

    machine.press(&["alt", "f2"]);
    shows_text(&mut machine, "tty2");
    machine.press(&["alt", "f1"]);
    machine.watch_for(PAUSE, "the picture", Look::is_art);
    only_art(&machine.watch_move(PAUSE, MOVES), OFTEN);

    machine.run("kill -INT $(pidof dreams-player)");
    shows_text(&mut machine, "tty1");
    // The console is no longer in graphics mode.
    machine.press(&["alt", "f2"]);
    machine.run("until [ \"$(cat /sys/class/tty/tty0/active)\" = tty2 ]; do sleep 1; done");
}
