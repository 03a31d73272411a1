//! How the machine is that a unit runs on: its system, heat, disk and address.
//!
//! Owns the field `machine` of the status report. Reads what the kernel says in `/sys`, with no rights on any device, and
//! what `dreams-mend` remembers. What cannot be read is left open; nothing of it is an error.
//!
//! Start at [`Machine::of`].

use crate::options::Order;
use crate::system::running;
use bundle::Version;
use durable::read_plain_text;
use player::{Rollback, rollback};
use rustix::fs::{major, minor, statvfs};
use serde::Serialize;
use std::fs;
use std::net::{IpAddr, SocketAddr, ToSocketAddrs, UdpSocket};
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};
use std::sync::mpsc::channel;
use std::thread;
use std::time::Duration;
use ureq::http::Uri;

/// Bytes of a file in `/sys` that are read, at most.
const LARGEST: u64 = 4 << 10;
/// How long the name of a server may take until it is found.
const RESOLVE: Duration = Duration::from_secs(5);
/// Temperatures that a sensor may mean, in thousandths of a degree Celsius: one that has failed says less, or more.
const PLAUSIBLE_MC: std::ops::RangeInclusive<i32> = -40_000..=150_000;

/// The state of the machine.
#[derive(Debug, Serialize)]
pub(crate) struct Machine {
    /// The version of the running system; none if it is none of ours.
    system: Option<Version>,
    /// The version of our programs.
    programs: &'static str,
    /// The slot that the system runs from, `a` or `b`.
    slot: Option<char>,
    /// The newer system that was tried and left.
    rolled_back: Option<Rollback>,
    /// Seconds since the start of the machine.
    uptime_s: u64,
    /// What the hottest sensor measures, in degrees Celsius.
    temperature_c: Option<f64>,
    disk: Option<Disk>,
    /// The local address by which the report goes.
    address: Option<IpAddr>,
    /// Whether the unit knows the time.
    time_known: bool,
}

/// The file system of the store.
#[derive(Debug, Serialize)]
struct Disk {
    total_bytes: u64,
    /// What our programs may still write.
    free_bytes: u64,
    /// How much of its life the disk has used at least, in percent; none if it does not say.
    worn_percent: Option<u64>,
}

impl Machine {
    /// The machine as it is now, of a unit that reports to the URL `address`.
    pub(crate) fn of(order: &Order, address: &str) -> Self {
        let (root, clock) = (&order.config.machine, order.clock.read());
        let system = running(&order.config.system);
        let is_newer = |left: &Rollback| Version::parse(&left.from).ok() > system;
        Self {
            programs: env!("CARGO_PKG_VERSION"),
            slot: system.as_ref().and_then(|_| slot(root)),
            rolled_back: system.as_ref().and_then(|_| Rollback::read(&root.join(rollback::FILE))).filter(is_newer),
            uptime_s: clock.up_s,
            temperature_c: hottest(root),
            disk: disk(root, &order.config.store),
            address: local_address(order.config.proxy.as_deref().unwrap_or(address)),
            time_known: clock.known_s().is_some(),
            system,
        }
    }
}

/// The slot below the verified root.
fn slot(root: &Path) -> Option<char> {
    let events = listed(&root.join("sys/class/block/dm-0/slaves")).into_iter().map(|slot| slot.join("uevent"));
    let named = |text: String| {
        let name = text.lines().find_map(|line| line.strip_prefix("PARTNAME=dreams_"))?;
        ['a', 'b'].into_iter().find(|slot| *name == slot.to_string())
    };
    events.filter_map(|event| read_plain_text(&event, LARGEST).ok()).find_map(named)
}

/// What the hottest sensor measures, in degrees Celsius, to a tenth.
fn hottest(root: &Path) -> Option<f64> {
    let zones = listed(&root.join("sys/class/thermal")).into_iter().map(|zone| zone.join("temp"));
    let chips = listed(&root.join("sys/class/hwmon")).into_iter().flat_map(|chip| listed(&chip));
    let is_input = |path: &PathBuf| {
        let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default();
        name.starts_with("temp") && name.ends_with("_input")
    };
    let read = |path: PathBuf| read_plain_text(&path, LARGEST).ok()?.trim().parse().ok();
    let measured = zones.chain(chips.filter(is_input)).filter_map(read).filter(|mc| PLAUSIBLE_MC.contains(mc));
    measured.max().map(|mc| (f64::from(mc) / 100.0).round() / 10.0)
}

/// The file system of the folder `store`.
fn disk(root: &Path, store: &Path) -> Option<Disk> {
    let status = statvfs(store).ok()?;
    let bytes = |blocks: u64| blocks.saturating_mul(status.f_frsize);
    let device = fs::metadata(store).ok()?.dev();
    let device = root.join("sys/dev/block").join(format!("{}:{}", major(device), minor(device)));
    Some(Disk {
        total_bytes: bytes(status.f_blocks),
        free_bytes: bytes(status.f_bavail),
        worn_percent: worn_percent(&device),
    })
}

/// How worn the disk is that has this block device or partition: an eMMC says so, in tenths, of each of two kinds of cells.
///
/// # Source
/// JEDEC JESD84-B51, `DEVICE_LIFE_TIME_EST_TYP_A` and `_B`: 1 is up to 10 % of the life, 11 beyond all of it.
fn worn_percent(device: &Path) -> Option<u64> {
    // The link of a partition leads below its disk.
    let files = ["device/life_time", "../device/life_time"].map(|file| device.join(file));
    let text = files.iter().find_map(|file| read_plain_text(file, LARGEST).ok())?;
    let tenths =
        |word: &str| u64::from_str_radix(word.strip_prefix("0x")?, 16).ok().filter(|said| (1..=11).contains(said));
    text.split_whitespace().filter_map(tenths).max().map(|tenths| (tenths - 1) * 10)
}

/// The address of this machine by which the server of `url` is reached. Nothing is sent.
fn local_address(url: &str) -> Option<IpAddr> {
    let uri: Uri = url.parse().ok()?;
    let host = uri.host()?.trim_matches(['[', ']']).to_owned();
    let port = uri.port_u16().unwrap_or(if uri.scheme_str() == Some("https") { 443 } else { 80 });
    let (sender, found) = channel();
    // It may take longer, and then ends unheard.
    thread::spawn(move || sender.send((host.as_str(), port).to_socket_addrs().map(Vec::from_iter)).ok());
    let servers: Vec<SocketAddr> = found.recv_timeout(RESOLVE).ok()?.ok()?;
    servers.into_iter().find_map(|server| {
        let any: &str = if server.is_ipv4() { "0.0.0.0:0" } else { "[::]:0" };
        let socket = UdpSocket::bind(any).ok()?;
        socket.connect(server).ok()?;
        socket.local_addr().ok().map(|local| local.ip())
    })
}

/// What is in a folder; nothing if it cannot be read.
fn listed(folder: &Path) -> Vec<PathBuf> {
    fs::read_dir(folder).into_iter().flatten().filter_map(|entry| entry.ok().map(|entry| entry.path())).collect()
}
