//! An emulated machine that runs a unit's system.
//!
//! Owns QEMU's command line, actions from outside, and looks at the screen. QEMU emulates every instruction, so that it
//! runs anywhere; its clock is this machine's. The claims judge what it shows.
//!
//! Start at [`Machine`]; a unit and its disk are in `unit/mod.rs`.

pub(crate) mod bios_screen;
pub(crate) mod clock;
pub(crate) mod disk;
pub(crate) mod hardware;
mod monitor;
pub(crate) mod open_ports;
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
use claims::programs::repository;
use serde_json::json;
use std::fs;
use std::os::unix::net::UnixDatagram;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::{LazyLock, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// Between two looks at the screen where no frequency is claimed.
pub(crate) const PAUSE: Duration = Duration::from_millis(200);
/// The longest wait.
const PATIENCE: Duration = Duration::from_mins(10);

/// One machine at a time: each uses all processors.
static TURN: Mutex<()> = Mutex::new(());

/// A running machine. Its power is cut when this is dropped.
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
    /// Whether its display copies pictures while they are shown, instead of swapping buffers.
    pub(crate) may_tear: bool,
    /// Whether it is stopped during each look, so that the looks are close in its own time.
    pub(crate) stands_still: bool,
    /// For how long it was stopped.
    stood: Duration,
    _turn: MutexGuard<'static, ()>,
}

/// The flock that is part of the claims' image, as `light-flock` makes it.
pub(crate) fn light_flock() -> PathBuf {
    repository().join("target/light-flock")
}

/// Its frames.
pub(crate) fn built_in() -> &'static ReferenceFrames {
    static BUILT_IN: LazyLock<ReferenceFrames> = LazyLock::new(|| ReferenceFrames::of(&light_flock()));
    &BUILT_IN
}

impl Machine {
    /// Starts a machine with this disk and hardware, its other files in `folder`; `more` are further options of QEMU.
    pub(crate) fn start(folder: &Path, disk: &Disk, hardware: Hardware, more: &[String]) -> Self {
        let turn = TURN.lock().unwrap_or_else(PoisonError::into_inner);
        // Before its clock runs.
        let references = vec![built_in()];
        let drive = |file: &Path, what: &str| format!("file={},{what}", file.display());
        let (serial, monitor) = (Socket::new(folder.join("serial")), Socket::new(folder.join("monitor")));
        let mut command = Command::new(hardware.program());
        command.args(["-accel", "tcg,thread=multi", "-smp", "2"]);
        command.args(["-nodefaults", "-display", "none", "-device", "virtio-rng-pci"]);
        // A hub with QEMU's user network on one port, so that others can be added.
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

    /// The same, resumed from the memory in `state`.
    pub(crate) fn wake(folder: &Path, disk: &Disk, state: &Path) -> Self {
        let from = ["-incoming".to_owned(), format!("exec:cat '{}'", state.display())];
        let mut machine = Self::start(folder, disk, USUAL, &from);
        machine.await_status("paused");
        machine.monitor.ask("cont", &json!({}));
        machine
    }

    /// Stops it and saves its memory to `state`. It does not run again.
    pub(crate) fn freeze(mut self, state: &Path) {
        self.monitor.ask("stop", &json!({}));
        self.monitor.ask("migrate", &json!({ "uri": format!("exec:cat > '{}'", state.display()) }));
        self.await_status("postmigrate");
    }

    /// Stops it; writes in progress are completed.
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

    /// A look at the screen; `None` while the display is off.
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

    /// Looks at the screen every `pause` until the serial port has a line for which `is_it` is true; `what` names it.
    /// Returns all looks.
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

    /// Waits for `word` on the serial port; returns the rest of its line.
    pub(crate) fn await_word(&mut self, word: &str) -> String {
        let end = now() + PATIENCE;
        while now() < end {
            let line = self.serial.line(end.saturating_sub(now()));
            // The firmware moves the cursor within the line.
            if let Some((_, rest)) = line.as_deref().and_then(|line| line.split_once(word)) {
                return rest.trim().to_owned();
            }
        }
        panic!("`{word}` is not said in ten minutes; {}", self.serial.lately());
    }

    /// Looks at the screen every `pause` while the shell runs `command`, which must succeed.
    pub(crate) fn watch_while(&mut self, pause: Duration, command: &str) -> Vec<Look> {
        self.serial.send(command);
        let looks = self.watch(pause, command, |line| line.starts_with("DONE "));
        assert_eq!(self.serial.status(), 0, "`{command}`: {}", self.serial.lately());
        looks
    }

    /// Looks at the screen every `pause` until `is_it` is true of a look; `what` names it. Returns all looks.
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

    /// Looks at the screen every `pause` until the picture has changed `times` times.
    pub(crate) fn watch_move(&mut self, pause: Duration, mut times: u32) -> Vec<Look> {
        let (what, mut before) = (format!("the picture moves on, {times} times more"), None);
        self.watch_for(pause, &what, |look| {
            let has_moved = look.is_art() && before.is_some() && before != look.place;
            before.clone_from(&look.place);
            times -= u32::from(has_moved);
            times == 0
        })
    }

    /// Looks at the screen until the shell is there.
    pub(crate) fn await_shell(&mut self) -> Vec<Look> {
        self.watch(PAUSE, "its shell", |line| line.contains("BENCH"))
    }

    /// Waits for `time`.
    pub(crate) fn wait(&mut self, time: Duration) {
        let end = now() + time;
        while now() < end {
            self.serial.pass(end.saturating_sub(now()));
        }
    }

    /// Runs `command` in the shell, which must succeed; returns its output.
    pub(crate) fn run(&mut self, command: &str) -> String {
        let (said, status) = self.serial.run(command);
        assert_eq!(status, 0, "`{command}`: {said}");
        said
    }

    /// Checks that no service has failed, and that systemd found no ordering cycle.
    pub(crate) fn is_well(&mut self) {
        let failed = "systemctl --failed --no-legend --plain | while read -r unit _; do echo $unit; \
            journalctl --boot --no-pager --quiet --output=short-monotonic --lines=20 --unit=$unit; done";
        assert_eq!(self.run(failed), "");
        let said = self.run("journalctl --boot --identifier=systemd --output=cat");
        assert!(!said.is_empty() && !said.contains("ordering cycle"), "{said}");
    }

    /// Connects its network card to a socket, in place of QEMU's user network, which answers for every address.
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

    /// Resets it.
    pub(crate) fn reset(&mut self) {
        self.monitor.ask("system_reset", &json!({}));
    }

    /// Presses these keys together, by QEMU's names.
    pub(crate) fn press(&mut self, keys: &[&str]) {
        let keys: Vec<_> = keys.iter().map(|key| json!({ "type": "qcode", "data": key })).collect();
        self.monitor.ask("send-key", &json!({ "keys": keys }));
    }

    /// Plugs in a stick, read-only.
    pub(crate) fn plug(&mut self, stick: &Path) {
        self.plug_stick(stick, true);
    }

    /// Plugs in a stick that can be written to.
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

    /// Unplugs the stick.
    pub(crate) fn pull(&mut self) {
        self.monitor.ask("device_del", &json!({ "id": "stick" }));
    }

    /// Releases the stick's file, once it is unplugged: it can be read here, and another one plugged in.
    pub(crate) fn take_stick(&mut self) {
        let there = "ls -d /sys/block/sd* 2> /dev/null; systemctl list-units --all --plain --no-legend 'dreams-*@sd*'";
        self.run(&format!("until [ -z \"$({there})\" ]; do sleep 1; done"));
        self.monitor.ask("blockdev-del", &json!({ "node-name": "stick" }));
    }
}
