//! A unit that plays gets its next system.
//!
//! Owns how that system is made, signed and served, and snapshots of the unit before each step: fetching, writing,
//! starting. Failures while a slot is written are in `tests/it/updates/systems.rs`, too.
//!
//! Start at [`updating_unit`].

use crate::machine::clock::now;
use crate::machine::picture::{Look, only_art};
use crate::machine::{Machine, PAUSE, light_flock};
use crate::starts::first_start::{MOVES, OFTEN, PlayingUnit, playing_unit};
use crate::unit::path::Path;
use crate::unit::stick::Stick;
use crate::unit::{Snapshot, Unit};
use crate::updates::flock_from_stick::is_autumn;
use claims::programs::{self, repository, succeed};
use claims::web::{Behaviour, WebServer};
use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::process::Command;
use std::sync::LazyLock;
use std::time::Duration;

/// The version that comes next.
pub(crate) const NEXT: &str = "9.0.0";
/// Commands for the steps, with the owner's settings in force.
pub(crate) const FETCH: &str = "systemctl start dreams-update.service";
pub(crate) const WRITE: &str = "systemctl start dreams-system.path";
/// The service that restarts it into its next system, which these claims do themselves.
pub(crate) const RESTART: &str = "dreams-restart.service";
/// For the unit's shell: the checksum of its flock and its owner's settings.
const KEPT: &str = "cd /var/lib/dreams && find -H owner store/current -type f | sort | xargs sha256sum | sha256sum";
/// For the unit's shell: whether the next system is in the store, ready to be written.
const IS_FETCHED: &str = "[ -e /var/lib/dreams/store/system/staged ]";

/// A step on the way to the next system, with a snapshot from before it.
pub(crate) struct Step {
    pub(crate) snapshot: Snapshot,
    /// The place in its walk at that moment.
    pub(crate) path: Path,
    /// The duration of the step.
    pub(crate) time: Duration,
}

/// A unit that gets its next system while it plays a flock from its store.
pub(crate) struct UpdatingUnit {
    _web: WebServer,
    pub(crate) fetching: Step,
    pub(crate) writing: Step,
    /// It is off, and starts that system next.
    pub(crate) written: Unit,
    pub(crate) path: Path,
    /// The checksum of its flock and its owner's settings.
    pub(crate) kept: String,
}

/// For the unit's shell: writes the next system, and waits for the end.
pub(crate) fn until_written() -> String {
    let is_over = "[ \"$(systemctl show -P ActiveState dreams-system)\" = inactive ]";
    format!("{WRITE}; until ! {IS_FETCHED} && {is_over}; do sleep 1; done")
}

/// Makes the next system and serves it, signed with the key that the bench image trusts.
fn served(unit: &Unit) -> WebServer {
    let target = repository().join("target/image");
    let key = repository().join("tests/fixtures/keys/artist.pub");
    let mut build = Command::new(repository().join("image-build/build"));
    succeed(
        build
            .arg(&target)
            .args(["--profile", "bench", "--version", NEXT, "--key"])
            .arg(&key)
            .arg("--flock")
            .arg(light_flock()),
    );
    let (outbox, passphrase) = (unit.path("outbox"), unit.path("passphrase"));
    fs::create_dir(&outbox).unwrap();
    fs::write(&passphrase, "velvet\n").unwrap();
    let secret = unit.path("artist.key");
    fs::copy(key.with_extension("key"), &secret).unwrap();
    for file in [&passphrase, &secret] {
        fs::set_permissions(file, fs::Permissions::from_mode(0o600)).unwrap();
    }
    let mut pack = Command::new(programs::dreams());
    pack.arg("pack").arg(target.join(format!("bench-{NEXT}"))).arg(&outbox).args(["--system", "--sequence", "2"]);
    succeed(pack.arg("--key").arg(&secret).arg("--passphrase-file").arg(&passphrase));
    WebServer::serve(&outbox, Behaviour::Good)
}

/// Sets the owner's settings so that it looks for systems at `web`.
fn settings(unit: &Unit, stick: &Stick, web: &WebServer) {
    // QEMU's network shows this machine's own address under that one.
    let url = web.url().replace("127.0.0.1", "10.0.2.2");
    let settings = format!("{}url = \"{url}\"\n", fs::read_to_string(&stick.owner).unwrap());
    let file = unit.path("dreams.toml");
    fs::write(&file, settings).unwrap();
    unit.lay_for_owner(&file);
}

/// The unit that all claims on new systems begin with; it is prepared once.
pub(crate) fn updating_unit() -> &'static UpdatingUnit {
    static UPDATING_UNIT: LazyLock<UpdatingUnit> = LazyLock::new(|| {
        let PlayingUnit { snapshot, path, stick, .. } = playing_unit();
        let (unit, mut path) = (snapshot.copy(), path.clone());
        let web = served(&unit);
        settings(&unit, stick, &web);
        let mut machine = unit.wake(snapshot);
        machine.also_expect(stick.reference);
        for look in is_ready(&mut machine, stick) {
            path.saw(&look);
        }
        let kept = kept(&mut machine);
        let fetching = (unit.freeze(machine), path.clone());

        let (unit, machine, fetch) = goes(&fetching.0, &mut path, &format!("{FETCH}; {IS_FETCHED}"));
        let writing = (unit.freeze(machine), path.clone());

        let (written, machine, write) = goes(&writing.0, &mut path, &until_written());
        drop(machine);

        println!("the next system is fetched in {fetch:.1?}, and written in {write:.1?}");
        let step = |(snapshot, path), time| Step { snapshot, path, time };
        UpdatingUnit { _web: web, fetching: step(fetching, fetch), writing: step(writing, write), written, path, kept }
    });
    &UPDATING_UNIT
}

/// Makes the unit play the flock of `stick`, and disables what would do the steps by itself.
fn is_ready(machine: &mut Machine, stick: &Stick) -> Vec<Look> {
    machine.run("systemctl stop dreams-update.timer dreams-system.path && systemctl start dreams-owner@vda4");
    machine.run(&format!("systemctl mask --runtime {RESTART}"));
    machine.run("grep -q ^url /var/lib/dreams/owner/dreams.toml");
    machine.plug(&stick.disk);
    let mut looks = machine.watch_for(PAUSE, "the flock of the stick", is_autumn);
    machine.pull();
    let is_proved = "journalctl --unit=dreams-player --output=cat | grep -q 'passed its trial'";
    looks.extend(machine.watch_while(PAUSE, &format!("until {is_proved}; do sleep 5; done")));
    machine.run("rm -f /run/dreams-update/schedule");
    looks
}

/// The unit resumed from `snapshot`, on a copy of its disk, after `command`, while it plays; and how long that took.
fn goes(snapshot: &Snapshot, path: &mut Path, command: &str) -> (Unit, Machine, Duration) {
    let unit = snapshot.copy();
    let mut machine = unit.wake(snapshot);
    machine.also_expect(playing_unit().stick.reference);
    machine.watch_move(PAUSE, 1).iter().for_each(|look| path.saw(look));
    let began = now();
    let mut looks = machine.watch_while(PAUSE, command);
    let time = now().saturating_sub(began);
    looks.extend(machine.watch_move(PAUSE, MOVES));
    for look in &looks {
        path.saw(look);
    }
    only_art(&looks, OFTEN);
    (unit, machine, time)
}

/// The checksum of its flock and its owner's settings.
pub(crate) fn kept(machine: &mut Machine) -> String {
    let kept = machine.run(KEPT);
    assert!(machine.run("find -H /var/lib/dreams/store/current -type f | wc -l").trim() == "5", "a flock is there");
    kept
}

/// The version that runs.
pub(crate) fn version(machine: &mut Machine) -> String {
    machine.run("sed 's/.*dreams.version=\\([^ ]*\\).*/\\1/' /proc/cmdline").trim().to_owned()
}
