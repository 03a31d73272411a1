//! The player under systemd.
//!
//! Owns the claims on a player that crashes, hangs or cannot play: the real unit files and systemd, with a real display
//! driver, in virtual time, without the sandbox. `house/units.rs` and the claims on the image try the sandbox.

use crate::guest::{script, succeed_in_virtual_time, word};
use claims::flocks::SMALL;
use claims::player_run::VKMS;
use claims::programs::{self, claims_folder};
use std::fs;
use std::path::Path;

/// The keys of a unit file that say when things start and end; the others are sandbox and limits.
const KEPT: [&str; 24] = [
    "AccuracySec",
    "After",
    "Conflicts",
    "DefaultDependencies",
    "Description",
    "ExecStart",
    "NotifyAccess",
    "OnActiveSec",
    "OnFailure",
    "PartOf",
    "RemainAfterElapse",
    "Restart",
    "RestartMaxDelaySec",
    "RestartPreventExitStatus",
    "RestartSec",
    "RestartSteps",
    "StartLimitBurst",
    "StartLimitIntervalSec",
    "TimeoutStartSec",
    "TimeoutStopSec",
    "Type",
    "Unit",
    "Wants",
    "WatchdogSec",
];

/// Starts systemd as a user's manager, with the unit files in `$units`, and defines the functions below.
const MANAGER: &str = r#"
mkdir -p /run/systemd/system /run/u/systemd /run/u/config/systemd
mount -t cgroup2 cgroup2 /sys/fs/cgroup
export XDG_RUNTIME_DIR=/run/u XDG_CONFIG_HOME=/run/u/config
ln -s "$units" /run/u/config/systemd/user
/lib/systemd/systemd --user --log-target=null --unit=dreams-player.service &
ctl() { systemctl --user "$@" || true; }
pid() { ctl show --property MainPID --value dreams-player; }
tell() {
  lit=$(sed -n 's/^\tactive=//p' /sys/kernel/debug/dri/vkms/state)
  echo "$1: player $(ctl is-active dreams-player), still $(ctl is-active dreams-still), lit $lit" >> "$told"
}
"#;

/// Writes the unit files to `folder`, without their sandbox, for the built program and the flock at `flock`.
fn lay(folder: &Path, flock: &Path) {
    fs::create_dir(folder).unwrap();
    let (player, scratch) = (programs::player(), flock.parent().unwrap());
    let on_a_unit = "/usr/bin/dreams-player --config /etc/dreams/player.toml --screen kms";
    let here = format!(
        "\"{player}\" --screen {VKMS} --status off --seed 1 --flock \"{flock}\" --state \"{scratch}/state\" \
         --spare \"{scratch}/none\" --owner \"{scratch}/none\"",
        player = player.display(),
        flock = flock.display(),
        scratch = scratch.display()
    );
    let still =
        ("/usr/bin/dreams-player --still --screen kms", format!("\"{}\" --still --screen {VKMS}", player.display()));
    for name in ["dreams-player.service", "dreams-still.service", "dreams-again.timer"] {
        let text = fs::read_to_string(programs::repository().join("systemd").join(name)).unwrap();
        let is_kept =
            |line: &&str| line.starts_with('[') || line.split('=').next().is_some_and(|key| KEPT.contains(&key));
        let text = text.lines().filter(is_kept).collect::<Vec<_>>().join("\n");
        fs::write(folder.join(name), text.replace(on_a_unit, &here).replace(still.0, &still.1)).unwrap();
    }
}

/// The player's log in a guest that runs `acts`.
fn told(acts: &str) -> String {
    let scratch = tempfile::tempdir_in(claims_folder()).unwrap();
    let (units, told, flock) =
        (scratch.path().join("units"), scratch.path().join("told"), scratch.path().join("flock"));
    lay(&units, &flock);
    let text = format!(
        "units={units} told={told} flock={flock} good={good}\nln -s \"$good\" \"$flock\"\n{MANAGER}{acts}",
        units = word(&units),
        told = word(&told),
        flock = word(&flock),
        good = word(&SMALL.flock().folder)
    );
    succeed_in_virtual_time(300, &script(&text));
    fs::read_to_string(told).unwrap()
}

#[test]
fn a_player_that_is_killed_or_hangs_is_started_again() {
    let acts = "sleep 5; tell begun
        kill -9 $(pid); sleep 5; tell killed
        before=$(pid); kill -STOP $before; sleep 40; tell stopped; [ $before != $(pid) ]
        kill -TERM $(pid); sleep 5; tell ended";
    let lit = |what: &str| format!("{what}: player active, still inactive, lit 1\n");
    assert_eq!(told(acts), ["begun", "killed", "stopped", "ended"].map(lit).concat());
}

#[test]
fn a_player_without_a_flock_gives_way_to_a_still_picture_and_comes_back_when_there_is_one() {
    for (what, spoil) in [("rubbish", r#"mkdir "$flock"; echo rubbish > "$flock/flock.toml""#), ("gone", "true")] {
        let acts = format!(
            "sleep 5; rm \"$flock\"; {spoil}; kill -9 $(pid); sleep 100; tell {what}
            rm -r -f \"$flock\"; sleep 60; ln -s \"$good\" \"$flock\"; sleep 20; tell mended
            until [ $(ctl is-active dreams-player) = active ]; do sleep 5; done; sleep 5; tell played"
        );
        let still = |when: &str| format!("{when}: player failed, still active, lit 1\n");
        let expected = [still(what), still("mended"), "played: player active, still inactive, lit 1\n".to_owned()];
        assert_eq!(told(&acts), expected.concat(), "{what}");
    }
}
