//! A unit: its disk, and a machine that starts from it.
//!
//! Owns the copies of the image, QEMU's command line, and the looks on the glass. QEMU emulates every instruction,
//! so that it runs anywhere; its clock is this machine's. Never judges: the claims do.
//!
//! Start at [`Unit::new`] and [`Unit::start`].

use crate::monitor::Monitor;
use crate::picture::Look;
use crate::serial::Serial;
use serde_json::json;
use std::fs;
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::{Path, PathBuf};
use std::process::{Child, Command};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;
use tempfile::TempDir;

/// The disk that a unit is given: larger than the image, which is to take all of it.
const DISK_MIB: u64 = 1_200;
/// The firmware of Debian's `ovmf`.
const FIRMWARE: &str = "/usr/share/OVMF/OVMF_CODE_4M.fd";
const VARIABLES: &str = "/usr/share/OVMF/OVMF_VARS_4M.fd";
/// Between two looks at the glass.
pub(crate) const PAUSE: Duration = Duration::from_millis(200);

/// One at a time: each takes all processors.
static TURN: Mutex<()> = Mutex::new(());

/// A unit that can be started, again and again.
pub(crate) struct Unit {
    folder: TempDir,
    _turn: MutexGuard<'static, ()>,
}

/// A unit that runs. It loses its power when this is dropped.
pub(crate) struct Machine {
    qemu: Child,
    monitor: Monitor,
    pub(crate) serial: Serial,
    shot: PathBuf,
}

/// The repository's folder.
pub(crate) fn repository() -> PathBuf {
    let tests = Path::new(env!("CARGO_MANIFEST_DIR"));
    tests.parent().expect("tests/ lies in the repository").to_owned()
}

/// What `image-build/build` made for the bench.
pub(crate) fn image() -> PathBuf {
    let image = repository().join("target/image").join(concat!("bench-", env!("CARGO_PKG_VERSION")));
    assert!(image.is_dir(), "`{}` is missing: `make image profile=bench` makes it", image.display());
    image
}

/// Runs `command`, which must succeed.
pub(crate) fn succeed(command: &mut Command) {
    let said = command.output().unwrap_or_else(|error| panic!("cannot run {command:?}: {error}"));
    assert!(said.status.success(), "{command:?}: {}", String::from_utf8_lossy(&said.stderr));
}

impl Unit {
    /// A unit as it comes out of its box.
    pub(crate) fn new() -> Self {
        let folder = tempfile::tempdir_in(repository().join("target")).unwrap();
        let unit = Self { folder, _turn: TURN.lock().unwrap_or_else(PoisonError::into_inner) };
        succeed(Command::new("cp").arg("--sparse=always").arg(image().join("disk.img")).arg(unit.disk()));
        let disk = fs::File::options().write(true).open(unit.disk()).unwrap();
        disk.set_len(DISK_MIB << 20).unwrap();
        fs::copy(VARIABLES, unit.path("variables")).unwrap();
        unit
    }

    /// Its disk.
    pub(crate) fn disk(&self) -> PathBuf {
        self.path("disk.img")
    }

    /// A file beside it.
    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Gives it power.
    pub(crate) fn start(&self) -> Machine {
        let drive = |file: &Path, what: &str| format!("format=raw,file={},{what}", file.display());
        let (serial, monitor) = (Socket::new(self.path("serial")), Socket::new(self.path("monitor")));
        let mut qemu = Command::new("qemu-system-x86_64");
        qemu.args(["-accel", "tcg,thread=multi", "-cpu", "max", "-machine", "q35", "-smp", "2", "-m", "1024"]);
        qemu.args(["-nodefaults", "-display", "none", "-device", "virtio-vga,xres=1280,yres=720"]);
        qemu.args(["-device", "qemu-xhci,id=xhci", "-device", "virtio-rng-pci"]);
        qemu.args(["-netdev", "user,id=net", "-device", "virtio-net-pci,netdev=net"]);
        qemu.args(["-chardev", &serial.argument("serial"), "-serial", "chardev:serial"]);
        qemu.args(["-chardev", &monitor.argument("monitor"), "-mon", "monitor,mode=control"]);
        qemu.args(["-drive", &drive(Path::new(FIRMWARE), "if=pflash,readonly=on")]);
        qemu.args(["-drive", &drive(&self.path("variables"), "if=pflash")]);
        qemu.args(["-drive", &drive(&self.disk(), "if=none,id=disk"), "-device", "virtio-blk-pci,drive=disk"]);
        let qemu = qemu.spawn().expect("QEMU starts");
        let (serial, monitor) = (Serial::new(serial.accept()), Monitor::new(monitor.accept()));
        Machine { qemu, monitor, serial, shot: self.path("shot.ppm") }
    }
}

/// A socket to which QEMU connects.
struct Socket {
    path: PathBuf,
    listener: UnixListener,
}

impl Socket {
    fn new(path: PathBuf) -> Self {
        fs::remove_file(&path).ok();
        Self { listener: UnixListener::bind(&path).unwrap(), path }
    }

    fn argument(&self, id: &str) -> String {
        format!("socket,id={id},path={}", self.path.display())
    }

    fn accept(self) -> UnixStream {
        self.listener.accept().unwrap().0
    }
}

impl Machine {
    /// What is on the glass; `None` while the display is off.
    pub(crate) fn look(&mut self) -> Option<Look> {
        let shot = json!({ "filename": self.shot });
        self.monitor.try_to("screendump", &shot).ok().map(|_| Look::at(&self.shot))
    }

    /// Waits until the player has shown so many frames. Every look at the glass on the way, the last one included.
    pub(crate) fn await_flips(&mut self, flips: u32) -> Vec<Look> {
        let command = format!("until [ \"$(dreams-flips)\" -ge {flips} ]; do sleep 0.5; done; echo SHOWN");
        self.serial.send(&command);
        let mut looks = Vec::new();
        for _ in 0..3_000 {
            looks.extend(self.look());
            if self.serial.line(PAUSE).is_some_and(|line| line == "SHOWN") {
                self.serial.until("DONE ", 60);
                return looks;
            }
        }
        panic!("no {flips} flips in ten minutes; on the glass: {:?}", looks.last());
    }

    /// Waits for its shell, looking at the glass.
    pub(crate) fn await_shell(&mut self) -> Vec<Look> {
        let mut looks = Vec::new();
        for _ in 0..3_000 {
            looks.extend(self.look());
            if self.serial.line(PAUSE).is_some_and(|line| line.contains("BENCH")) {
                return looks;
            }
        }
        panic!("no shell in ten minutes; on the glass: {:?}", looks.last());
    }

    /// Has its shell run `command`, which must succeed; what it says.
    pub(crate) fn run(&mut self, command: &str) -> String {
        let (said, status) = self.serial.run(command);
        assert_eq!(status, 0, "`{command}`: {said}");
        said
    }
}

impl Drop for Machine {
    fn drop(&mut self) {
        // A machine that is gone is gone.
        self.qemu.kill().ok();
        self.qemu.wait().ok();
    }
}
