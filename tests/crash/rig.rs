//! Disks that are recorded, and disks that are checked.
//!
//! Owns the devices. A recorded disk is QEMU's `blklogwrites` behind the kernel's network block device; a disk after a
//! cut is in memory behind a loop device. QEMU does not record FUA, so a loop device in front of the recorded disk
//! turns FUA writes into flushes. Knows nothing of the files on the disks.
//!
//! Start at [`Recording::of`] and [`Disk::new`].

use claims::block_log::BlockLog;
use claims::wait;
use rustix::io::Errno;
use rustix::mount::{MountFlags, UnmountFlags, mount, unmount};
use std::fs::{self, File};
use std::io::BufReader;
use std::iter;
use std::os::unix::fs::FileExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::thread;
use tempfile::TempDir;

/// The size of every disk; its file system ends before that, and marks are written behind it.
const DISK: u64 = 10 << 20;
const FILE_SYSTEM: u64 = 9 << 20;
const BLOCK: usize = 4096;
/// Bytes compared at once; a whole number of blocks.
const STRETCH: usize = 16 * BLOCK;
/// Seconds that a program of the system may take, or a device to be ready.
const LONGEST_S: u32 = 120;
/// How many network block devices the kernel has.
const DEVICES: usize = 16;
/// Number of recordings so far. They take turns with the devices, since a device is busy for a moment after its use.
static RECORDINGS: AtomicUsize = AtomicUsize::new(0);

/// A loop device with a disk in memory, and where it is mounted.
pub(crate) struct Disk {
    file: File,
    device: String,
    folder: TempDir,
}

/// A disk in use, of which everything is recorded.
pub(crate) struct Recording {
    folder: TempDir,
    base: Vec<u8>,
    device: String,
    before: String,
    server: Child,
    marks: u64,
}

/// Runs a program of the system, which must succeed; returns its output.
fn run(program: &str, words: &[&str]) -> String {
    let mut command = Command::new(program);
    command.args(words).stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let child = command.spawn().unwrap_or_else(|error| panic!("cannot run {program}: {error}"));
    let said = wait::output(&format!("{command:?}"), LONGEST_S, child);
    assert!(said.status.success(), "{program} {words:?}: {}", String::from_utf8_lossy(&said.stderr));
    String::from_utf8(said.stdout).expect("systems speak UTF-8")
}

fn text(path: &Path) -> &str {
    path.to_str().expect("paths here are plain")
}

impl Disk {
    /// The disk on loop device `number`.
    pub(crate) fn new(number: usize) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("disk");
        let file = File::options().read(true).write(true).create_new(true).open(&path).unwrap();
        file.set_len(DISK).unwrap();
        fs::create_dir(folder.path().join("mounted")).unwrap();
        let device = format!("/dev/loop{number}");
        run("losetup", &[&device, text(&path)]);
        Self { file, device, folder }
    }

    /// Makes a new file system, calls `fill` with its mount point, and returns the disk's bytes.
    pub(crate) fn made(&self, fill: impl FnOnce(&Path)) -> Vec<u8> {
        let kib = (FILE_SYSTEM >> 10).to_string();
        run(
            "mkfs.ext4",
            &[
                "-q",
                "-F",
                "-b",
                &BLOCK.to_string(),
                "-E",
                "nodiscard,lazy_itable_init=0",
                &self.device,
                &format!("{kib}k"),
            ],
        );
        let mounted = self.mount().unwrap();
        fill(&mounted);
        self.unmount();
        let mut bytes = vec![0; DISK as usize];
        self.file.read_exact_at(&mut bytes, 0).unwrap();
        bytes
    }

    /// Sets its content to `bytes`, while it is not mounted. Blocks that are right already are not written: a guest's
    /// kernel is slow at allocating memory.
    pub(crate) fn load(&self, bytes: &[u8]) {
        let mut here = vec![0; STRETCH];
        for (stretch, wanted) in bytes.chunks(STRETCH).enumerate() {
            let here = &mut here[..wanted.len()];
            self.file.read_exact_at(here, (stretch * STRETCH) as u64).unwrap();
            let blocks = here.chunks(BLOCK).zip(wanted.chunks(BLOCK)).enumerate();
            for (block, (_, wanted)) in blocks.filter(|(_, (here, wanted))| here != wanted) {
                self.file.write_all_at(wanted, (stretch * STRETCH + block * BLOCK) as u64).unwrap();
            }
        }
    }

    /// Mounts it; the journal is replayed.
    pub(crate) fn mount(&self) -> Result<PathBuf, String> {
        let folder = self.folder.path().join("mounted");
        mount(&self.device, &folder, "ext4", MountFlags::NOATIME, None)
            .map_err(|error| format!("cannot be mounted: {error}"))?;
        Ok(folder)
    }

    /// Unmounts it, after a wait for other users: until its `exec`, a new process has all open files of this one.
    pub(crate) fn unmount(&self) {
        let folder = self.folder.path().join("mounted");
        wait::until("nobody uses the disk", LONGEST_S, || match unmount(&folder, UnmountFlags::empty()) {
            Err(Errno::BUSY) => false,
            done => done.map(|()| true).unwrap(),
        });
    }

    /// The errors that ext4 has found since it was mounted. There must be none after a power cut.
    pub(crate) fn errors(&self) -> u64 {
        let name = self.device.trim_start_matches("/dev/");
        let count = fs::read_to_string(format!("/sys/fs/ext4/{name}/errors_count")).unwrap();
        count.trim().parse().unwrap()
    }
}

impl Recording {
    /// Records what `live` does on a disk that holds `base`, with or without another process that syncs all the time.
    pub(crate) fn of(base: Vec<u8>, is_noisy: bool, live: impl FnOnce(&Path, &mut dyn FnMut())) -> BlockLog {
        let mut recording = Self::new(base);
        let mounted = recording.folder.path().join("mounted");
        mount(&recording.before, &mounted, "ext4", MountFlags::NOATIME, None).unwrap();
        let is_over = AtomicBool::new(!is_noisy);
        thread::scope(|scope| {
            scope.spawn(|| noise(&mounted, &is_over));
            let _silence = NoiseEnd(&is_over);
            live(&mounted, &mut || recording.mark());
        });
        unmount(&mounted, UnmountFlags::empty()).unwrap();
        recording.ended()
    }

    fn new(base: Vec<u8>) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let device = format!("/dev/nbd{}", RECORDINGS.fetch_add(1, Ordering::Relaxed) % DEVICES);
        let path = |name: &str| folder.path().join(name);
        fs::write(path("disk"), &base).unwrap();
        fs::write(path("log"), "").unwrap();
        fs::create_dir(path("mounted")).unwrap();
        let options = format!(
            "driver=blklogwrites,file.driver=file,file.filename={},log.driver=file,log.filename={},log-sector-size=512",
            text(&path("disk")),
            text(&path("log"))
        );
        let mut server = Command::new("qemu-nbd")
            .args(["--verbose", "--connect", &device, "--socket", text(&path("socket")), "--image-opts", &options])
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap_or_else(|error| panic!("cannot run qemu-nbd: {error}"));
        let mut stderr = BufReader::new(server.stderr.take().expect("it is piped"));
        let lines = iter::repeat_with(|| wait::line("qemu-nbd is connected", LONGEST_S, &mut stderr));
        let said: Vec<String> = lines.take_while(|line| !line.is_empty() && !line.contains("now connected")).collect();
        assert!(server.try_wait().unwrap().is_none(), "{said:?}");
        let size = format!("/sys/block/{}/size", device.trim_start_matches("/dev/"));
        wait::until("the kernel knows how large the disk is", LONGEST_S, || {
            fs::read_to_string(&size).unwrap().trim() != "0"
        });
        let before = run("losetup", &["--find", "--show", "--direct-io=on", &device]).trim().to_owned();
        Self { folder, base, device, before, server, marks: 0 }
    }

    /// Writes a mark to the log, after all writes so far: a sector behind the file system, without a flush.
    fn mark(&mut self) {
        let sector = FILE_SYSTEM / claims::block_log::SECTOR as u64 + self.marks;
        run(
            "dd",
            &[
                "if=/dev/zero",
                &format!("of={}", self.device),
                "bs=512",
                "count=1",
                &format!("seek={sector}"),
                "oflag=direct",
                "conv=notrunc",
            ],
        );
        self.marks += 1;
    }

    fn ended(mut self) -> BlockLog {
        run("losetup", &["--detach", &self.before]);
        run("qemu-nbd", &["--disconnect", &self.device]);
        wait::ended("qemu-nbd, which was told to disconnect", LONGEST_S, &mut self.server);
        BlockLog::read(self.base, fs::read(self.folder.path().join("log")).unwrap())
    }
}

/// The entries of `log` that are marks.
pub(crate) fn marks(log: &BlockLog) -> Vec<usize> {
    let is_mark = |at: &usize| log.entries[*at].at as u64 >= FILE_SYSTEM;
    (0..log.entries.len()).filter(is_mark).collect()
}

/// Ends the noise when it is dropped.
struct NoiseEnd<'n>(&'n AtomicBool);

impl Drop for NoiseEnd<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

/// Syncs a file again and again, so that the journal commits whatever else is in progress.
fn noise(folder: &Path, is_over: &AtomicBool) {
    let mut count = 0u64;
    while !is_over.load(Ordering::Relaxed) {
        let file = File::options().create(true).write(true).truncate(false).open(folder.join("noise")).unwrap();
        file.write_all_at(&count.to_le_bytes(), 0).unwrap();
        file.sync_all().unwrap();
        count += 1;
    }
}
