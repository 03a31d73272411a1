//! What the user of the player and the updater may write to on a unit.
//!
//! Owns the attempts, and the list of all that this user may write to, `writable.txt`. The sandboxes of the services
//! restrict it further: `it` measures them.

use crate::starts::first_start::playing_unit;

/// Runs a command as this user, with the groups of the player.
const AS_DREAMS: &str =
    "setpriv --reuid=dreams --regid=dreams --groups=video,render --no-new-privs --bounding-set=-all";

/// Commands that would make this user the owner, or root.
const FENCED: [&str; 17] = [
    // Whom the unit trusts, and where it looks.
    "touch /var/lib/dreams/owner/dreams.toml.new",
    "sh -c 'echo >> /var/lib/dreams/owner/dreams.toml'",
    "rm -f /var/lib/dreams/owner/dreams.toml",
    "mv /var/lib/dreams/owner /var/lib/dreams/owners",
    "sh -c 'echo > /run/dreams-owner/wired.conf'",
    "touch /etc/dreams/keys/mine.pub",
    // Where root mounts something, or makes a link.
    "ln -s /etc /var/lib/dreams/elsewhere",
    "mv /var/lib/dreams/journal /var/lib/dreams/journals",
    "touch /var/lib/dreams/journal/mine",
    "ln -s /etc /run/dreams-mounts/sdz1",
    "mkdir /run/dreams-slot /dev/dreams",
    "mv /var/lib/dreams/store /var/lib/dreams/stores",
    // The disk below all that.
    "sh -c ': < /dev/vda'",
    "sh -c ': >> /dev/vda5'",
    "sh -c ': >> /dev/dreams/a'",
    "sh -c ': >> /dev/dreams/tries'",
    // A service of the same user, by what would hijack any process: its memory.
    "sh -c 'sleep 60 & exec 3<> /proc/$!/mem'",
];

/// The paths that this user may write to, each once, with `N` for numbers; folders that it owns are not searched.
const WRITABLE: &str = "find / \\( -path /proc -o -path '/var/lib/dreams/store/*' -o -path '/var/lib/dreams/state/*' \\) -prune \
    -o ! -type l -writable -print 2> /dev/null | sed 's/[0-9][0-9]*/N/g' | sort -u";

#[test]
fn whoever_is_the_players_user_sets_nothing_that_is_the_owners_and_replaces_nothing_that_is_roots() {
    let (_unit, mut machine) = playing_unit().snapshot.wake();
    machine.run("mkdir -p /run/dreams-mounts");
    // Whoever writes to partitions is another user, and can open its own partitions.
    let node = "stat --format '%U %a' /dev/dreams/tries";
    assert_eq!(machine.run(&format!("systemctl start dreams-learned && {node}")).trim(), "dreams-learned 600");
    for unit in ["dreams-learned.service", "dreams-system.service", "dreams-mend@due.service"] {
        let user = machine.run(&format!("systemctl show --property=User,SupplementaryGroups {unit}"));
        assert!(!user.contains("User=dreams\r") && !user.contains("User=dreams\n"), "{unit}: {user}");
        assert!(!user.contains("disk"), "{unit}: {user}");
    }
    for words in FENCED {
        let (said, status) = machine.serial.run(&format!("{AS_DREAMS} {words}"));
        assert_ne!(status, 0, "`{words}` was done: {said}");
    }
    // The commands themselves work where this user may write.
    machine.run(&format!("{AS_DREAMS} touch /var/lib/dreams/store/mine && {AS_DREAMS} rm /var/lib/dreams/store/mine"));
    machine.run(&format!("{AS_DREAMS} grep -q . /var/lib/dreams/owner/dreams.toml"));
    assert_eq!(machine.run("stat --format '%U %a' /var/lib/dreams /var/lib/dreams/owner").trim(), "root 755\nroot 775");
}

#[test]
fn all_that_the_players_and_the_updaters_user_may_write_to_stands_in_a_list() {
    let (_unit, mut machine) = playing_unit().snapshot.wake();
    let listed: Vec<&str> =
        include_str!("writable.txt").lines().filter(|line| line.starts_with('/')).map(str::trim_end).collect();
    let found = machine.run(&format!("{AS_DREAMS} sh -c \"{WRITABLE}\""));
    let found: Vec<&str> = found.lines().map(str::trim_end).collect();
    assert!(found.contains(&"/var/lib/dreams/store") && found.contains(&"/var/lib/dreams/state"), "{found:?}");
    let unlisted: Vec<_> = found.iter().filter(|path| !listed.contains(path)).collect();
    assert!(unlisted.is_empty(), "not in `writable.txt`: {unlisted:#?}");
}
