//! A machine that runs a unit's system.
//!
//! Owns QEMU's command line, what is done to a machine from outside, and the looks on the screen. QEMU emulates every
//! instruction, so that it runs anywhere; its clock is this machine's. Never judges: the claims do.
//!
//! Start at [`Machine`]; a unit and its disk are in `unit/mod.rs`.

pub(crate) mod clock;
pub(crate) mod direct_boot;
pub(crate) mod disk;
pub(crate) mod hardware;
mod monitor;
pub(crate) mod picture;
mod qemu;
pub(crate) mod reference_frames;
mod serial;
pub(crate) mod write_loss;

use crate::machine::clock::now;
use crate::machine::disk::Disk;
use crate::machine::hardware::{Hardware, USUAL};
use crate::machine::monitor::Monitor;
use crate::machine::picture::Look;
use crate::machine::qemu::{Qemu, Socket};
use crate::machine::reference_frames::ReferenceFrames;
use crate::machine::serial::Serial;
use crate::programs::repository;
use serde_json::json;
use std::fs;
use std::os::unix::net::UnixDatagram;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::{LazyLock, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// Between two looks at the screen where nothing is claimed of it.
pub(crate) const PAUSE: Duration = Duration::from_millis(200);
/// The longest that anything may take.
const PATIENCE: Duration = Duration::from_mins(10);

/// One machine at a time: each takes all processors.
static TURN: Mutex<()> = Mutex::new(());

/// A unit that runs. It loses its power when this is dropped.
pub(crate) struct Machine {
    _qemu: Qemu,
    monitor: Monitor,
    pub(crate) serial: Serial,
    shot: PathBuf,
    /// The flocks whose frames may be shown.
    references: Vec<&'static ReferenceFrames>,
    /// The frame that was found last.
    near: usize,
    has_shown_art: bool,
    /// Whether its pictures are copied to where they are shown, and not swapped between two frames.
    pub(crate) may_tear: bool,
    /// Whether it stands still while it is looked at, so that the looks are as close in its own time as they are to be.
    pub(crate) stands_still: bool,
    /// For how long it stood still.
    stood: Duration,
    _turn: MutexGuard<'static, ()>,
}

/// The flock that is part of every unit's system.
pub(crate) fn built_in() -> &'static ReferenceFrames {
    static BUILT_IN: LazyLock<ReferenceFrames> =
        LazyLock::new(|| ReferenceFrames::of(&repository().join("flock-tools/demo/small")));
    &BUILT_IN
}

impl Machine {
    /// A machine of these parts with this disk, its other things in `folder`; `more` are words of QEMU's.
    pub(crate) fn start(folder: &Path, disk: &Disk, hardware: Hardware, more: &[String]) -> Self {
        let turn = TURN.lock().unwrap_or_else(PoisonError::into_inner);
        // Before its clock runs.
        let references = vec![built_in()];
        let drive = |file: &Path, what: &str| format!("file={},{what}", file.display());
        let (serial, monitor) = (Socket::new(folder.join("serial")), Socket::new(folder.join("monitor")));
        let mut command = Command::new(hardware.program());
        command.args(["-accel", "tcg,thread=multi", "-smp", "2"]);
        command.args(["-nodefaults", "-display", "none", "-device", "virtio-rng-pci"]);
        // A network with the world on one port; there are others.
        command.args(["-netdev", "user,id=world", "-netdev", "hubport,id=port,hubid=0,netdev=world"]);
        command.args(["-netdev", "hubport,id=net,hubid=0", "-device", "virtio-net-pci,netdev=net"]);
        command.args(["-chardev", &serial.argument("serial"), "-serial", "chardev:serial"]);
        command.args(["-chardev", &monitor.argument("monitor"), "-mon", "monitor,mode=control"]);
        command.args(disk.words()).args(hardware.words());
        command.args(["-drive", &drive(&folder.join("variables"), "if=pflash,format=raw")]);
        let mut qemu = Qemu::start(command.args(more), folder.join("said"));
        let serial = Serial::new(serial.accept(&mut qemu), qemu.said());
        let monitor = Monitor::new(monitor.accept(&mut qemu), qemu.said());
        let shot = folder.join("shot.ppm");
        Self {
            _qemu: qemu,
            monitor,
            serial,
            shot,
            references,
            near: 0,
            has_shown_art: false,
            may_tear: hardware.display.may_tear(),
            stands_still: false,
            stood: Duration::ZERO,
            _turn: turn,
        }
    }

    /// A machine like that one, which goes on where `state` was left.
    pub(crate) fn wake(folder: &Path, disk: &Disk, state: &Path) -> Self {
        let from = ["-incoming".to_owned(), format!("exec:cat '{}'", state.display())];
        let mut machine = Self::start(folder, disk, USUAL, &from);
        machine.await_status("paused");
        machine.monitor.ask("cont", &json!({}));
        machine
    }

    /// Stops it and leaves all that it has in mind in `state`. Its disk is then as it was left; it runs no more.
    pub(crate) fn freeze(mut self, state: &Path) {
        self.monitor.ask("stop", &json!({}));
        self.monitor.ask("migrate", &json!({ "uri": format!("exec:cat > '{}'", state.display()) }));
        self.await_status("postmigrate");
    }

    /// Stands still from now on; what it was just saying to its disk is said.
    pub(crate) fn halt(&mut self) {
        self.monitor.ask("stop", &json!({}));
    }

    fn await_status(&mut self, wanted: &str) {
        let end = now() + PATIENCE;
        while self.monitor.ask("query-status", &json!({}))["status"] != wanted {
            assert!(now() < end, "the machine is not `{wanted}`");
            self.serial.pass(Duration::from_millis(20));
        }
    }

    /// Accepts the frames of `reference`, too.
    pub(crate) fn also_expect(&mut self, reference: &'static ReferenceFrames) {
        self.references.push(reference);
    }

    /// What is on the screen; `None` while the display is off.
    pub(crate) fn look(&mut self) -> Option<Look> {
        let shot = json!({ "filename": self.shot });
        if self.stands_still {
            self.monitor.ask("stop", &json!({}));
        }
        let at = now();
        let shown = self.monitor.try_to("screendump", &shot);
        let at_its_time = at.saturating_sub(self.stood);
        let judged = |_| Look::new(&self.shot, at_its_time, &self.references, &mut self.near, self.may_tear);
        let look = shown.map(judged);
        if self.stands_still {
            self.stood += now().saturating_sub(at);
            self.monitor.ask("cont", &json!({}));
        }
        let look = look.ok()?;
        self.has_shown_art |= look.is_art();
        if self.has_shown_art && !look.is_art() {
            fs::copy(&self.shot, repository().join("target/image/odd.ppm")).unwrap();
        }
        Some(look)
    }

    /// Looks at the screen every `pause` until the serial port says a line that `is_it`, which is called `what`. All looks, the
    /// last one included.
    pub(crate) fn watch(&mut self, pause: Duration, what: &str, is_it: impl Fn(&str) -> bool) -> Vec<Look> {
        let end = now() + PATIENCE;
        let mut looks = Vec::new();
        while now() < end {
            let (began, stood) = (now(), self.stood);
            looks.extend(self.look());
            let next = began + pause + self.stood.saturating_sub(stood);
            loop {
                match self.serial.line(next.saturating_sub(now())) {
                    Some(line) if is_it(&line) => return looks,
                    Some(_) => {}
                    None => break,
                }
            }
        }
        panic!("not said in ten minutes: {what}; on the screen: {:?}; {}", looks.last(), self.serial.lately());
    }

    /// Waits until its serial port says `word`; what it says behind that.
    pub(crate) fn await_word(&mut self, word: &str) -> String {
        let end = now() + PATIENCE;
        while now() < end {
            let line = self.serial.line(end.saturating_sub(now()));
            // The firmware moves about on the same line.
            if let Some((_, rest)) = line.as_deref().and_then(|line| line.split_once(word)) {
                return rest.trim().to_owned();
            }
        }
        panic!("`{word}` is not said in ten minutes; {}", self.serial.lately());
    }

    /// Looks at the screen every `pause` while its shell runs `command`, which must succeed.
    pub(crate) fn watch_while(&mut self, pause: Duration, command: &str) -> Vec<Look> {
        self.serial.send(command);
        let looks = self.watch(pause, command, |line| line.starts_with("DONE "));
        assert_eq!(self.serial.status(), 0, "`{command}`: {}", self.serial.lately());
        looks
    }

    /// Looks at the screen every `pause` until a look `is_it`, which is called `what`. All looks, the last one included.
    pub(crate) fn watch_for(&mut self, pause: Duration, what: &str, mut is_it: impl FnMut(&Look) -> bool) -> Vec<Look> {
        let end = now() + PATIENCE;
        let mut looks = Vec::new();
        while now() < end {
            let (began, stood) = (now(), self.stood);
            looks.extend(self.look());
            let next = began + pause + self.stood.saturating_sub(stood);
            if looks.last().is_some_and(&mut is_it) {
                return looks;
            }
            self.wait(next.saturating_sub(now()));
        }
        panic!("not shown in ten minutes: {what}; on the screen: {:?}; {}", looks.last(), self.serial.lately());
    }

    /// Looks at the screen every `pause` until the picture has moved on so many times.
    pub(crate) fn watch_move(&mut self, pause: Duration, mut times: u32) -> Vec<Look> {
        let (what, mut before) = (format!("the picture moves on, {times} times more"), None);
        self.watch_for(pause, &what, |look| {
            let has_moved = look.is_art() && before.is_some() && before != look.place;
            before.clone_from(&look.place);
            times -= u32::from(has_moved);
            times == 0
        })
    }

    /// Looks until its shell is there.
    pub(crate) fn await_shell(&mut self) -> Vec<Look> {
        self.watch(PAUSE, "its shell", |line| line.contains("BENCH"))
    }

    /// Lets this much time pass.
    pub(crate) fn wait(&mut self, time: Duration) {
        let end = now() + time;
        while now() < end {
            self.serial.pass(end.saturating_sub(now()));
        }
    }

    /// Has its shell run `command`, which must succeed; what it says.
    pub(crate) fn run(&mut self, command: &str) -> String {
        let (said, status) = self.serial.run(command);
        assert_eq!(status, 0, "`{command}`: {said}");
        said
    }

    /// Has it say that none of its services has failed, and that systemd left none out to find an order.
    pub(crate) fn is_well(&mut self) {
        let failed = "systemctl --failed --no-legend --plain | while read -r unit _; do echo $unit; \
            journalctl --boot --no-pager --quiet --output=short-monotonic --lines=20 --unit=$unit; done";
        assert_eq!(self.run(failed), "");
        let said = self.run("journalctl --boot --identifier=systemd --output=cat");
        assert!(!said.is_empty() && !said.contains("ordering cycle"), "{said}");
    }

    /// A cable to its network, in the place of the world: that answers for everybody.
    pub(crate) fn wire(&mut self) -> UnixDatagram {
        let [theirs, ours] = ["wire.qemu", "wire"].map(|end| self.shot.with_file_name(end));
        let wire = UnixDatagram::bind(&ours).unwrap();
        self.monitor.ask("netdev_del", &json!({ "id": "port" }));
        let [local, remote] = [&theirs, &ours].map(|path| json!({ "type": "unix", "path": path }));
        let end = json!({ "type": "dgram", "id": "wire", "local": local, "remote": remote });
        self.monitor.ask("netdev_add", &end);
        let port = json!({ "type": "hubport", "id": "neighbour", "hubid": 0, "netdev": "wire" });
        self.monitor.ask("netdev_add", &port);
        wire.connect(theirs).unwrap();
        wire
    }

    /// Starts it anew, as its button would.
    pub(crate) fn reset(&mut self) {
        self.monitor.ask("system_reset", &json!({}));
    }

    /// Presses these keys at once, by QEMU's names.
    pub(crate) fn press(&mut self, keys: &[&str]) {
        let keys: Vec<_> = keys.iter().map(|key| json!({ "type": "qcode", "data": key })).collect();
        self.monitor.ask("send-key", &json!({ "keys": keys }));
    }

    /// Puts in a stick, to which nobody may write.
    pub(crate) fn plug(&mut self, stick: &Path) {
        self.plug_stick(stick, true);
    }

    /// Puts in a stick that can be written to.
    pub(crate) fn plug_to_write(&mut self, stick: &Path) {
        self.plug_stick(stick, false);
    }

    fn plug_stick(&mut self, stick: &Path, is_protected: bool) {
        let file = json!({ "driver": "file", "filename": stick, "read-only": is_protected });
        let node = json!({ "driver": "raw", "node-name": "stick", "read-only": is_protected, "file": file });
        self.monitor.ask("blockdev-add", &node);
        let device =
            json!({ "driver": "usb-storage", "id": "stick", "drive": "stick", "bus": "xhci.0", "removable": true });
        self.monitor.ask("device_add", &device);
    }

    /// Pulls it.
    pub(crate) fn pull(&mut self) {
        self.monitor.ask("device_del", &json!({ "id": "stick" }));
    }

    /// Takes its disk back, once it is pulled: another one can be put in, and this machine may read what was written.
    pub(crate) fn take_stick(&mut self) {
        let there = "ls -d /sys/block/sd* 2> /dev/null; systemctl list-units --all --plain --no-legend 'dreams-*@sd*'";
        self.run(&format!("until [ -z \"$({there})\" ]; do sleep 1; done"));
        self.monitor.ask("blockdev-del", &json!({ "node-name": "stick" }));
    }
}
