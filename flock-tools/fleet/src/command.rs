//! `dreams fleet FOLDER`: all units on one page.
//!
//! Owns the command: its options, what is printed, and how it ends. Without --listen it opens no socket but that of the
//! webhook.
//!
//! Start at [`run`].

use std::io;
use std::net::{IpAddr, Ipv4Addr, SocketAddr, TcpListener};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use bundle::UnitId;
use ct_codecs::{Base64, Encoder};
use operations::program::{Exit, Fatal, now, print};
use operations::render::machine;

use crate::desk::{Desk, Rules};
use crate::doors::{self, Doors};
use crate::folder::{self, MOST_UNITS, Refused};
use crate::page::{Form, page};
use crate::record::{UnitView, views};
use crate::webhook::{self, Webhook};
use crate::{server, table};

/// Seconds of an hour.
const HOUR_S: u64 = 3600;

/// Show all units on one page: what hangs there, what is wrong, and when each was last seen
///
/// With --listen it receives the status reports that units send to `report_to`, keeps the newest of each in the folder,
/// and serves the page at `/`, JSON at `/fleet.json` and `OpenMetrics` at `/metrics`, until it is interrupted. Without it,
/// it prints a table of the reports in the folder. Reports are not signed: do not trust what they say.
#[derive(Debug, clap::Args)]
#[command(after_help = "Exit status:
  0  nothing is wrong with any unit; with --listen: it was interrupted
  1  something is wrong with a unit, or a file is no report; the address is taken, or another one works with the folder
  2  the command line or a file in the folder is wrong
  3  a file could not be read or written, or the webhook not be reached")]
pub struct Args {
    /// Folder of the reports; with --listen it is made
    folder: PathBuf,
    /// Receive reports here: a port of this machine's own address, or an address that other machines reach, with a port
    #[arg(long, value_name = "ADDR:PORT", value_parser = address)]
    listen: Option<SocketAddr>,
    /// A name by which the server is asked, besides addresses and localhost; may be repeated
    #[arg(long = "host", value_name = "NAME", requires = "listen", value_parser = doors::name)]
    hosts: Vec<String>,
    /// Take reports only at this path [default: at any]
    #[arg(long, value_name = "PATH", requires = "listen", value_parser = doors::path)]
    path: Option<String>,
    /// A unit that must be there; if any is named, only named ones may report; may be repeated
    #[arg(long = "unit", value_name = "NAME", value_parser = unit)]
    units: Vec<UnitId>,
    /// Most units that may report, where none is named
    #[arg(long, value_name = "N", default_value_t = 100, requires = "listen",
        value_parser = clap::value_parser!(u16).range(1..=MOST_UNITS as i64))]
    most: u16,
    /// Hours without a report after which a unit is wrong
    #[arg(long, value_name = "HOURS", default_value_t = 26, value_parser = clap::value_parser!(u16).range(1..=8760))]
    silent_after: u16,
    /// Send alarms to this address, as JSON by POST, when something becomes wrong and when all is right again
    #[arg(long, value_name = "URL", env = "DREAMS_FLEET_ALARM", hide_env_values = true,
        value_parser = webhook::address)]
    alarm: Option<String>,
    /// Write the page into this file
    #[arg(long, value_name = "PAGE", conflicts_with = "listen")]
    out: Option<PathBuf>,
    /// Answer with one JSON document
    #[arg(long)]
    json: bool,
}

/// The answer with `--json`.
#[derive(serde::Serialize)]
struct Answer<'a> {
    ok: bool,
    units: &'a [UnitView],
    /// Files that are no reports.
    refused: &'a [Refused],
}

/// The same with `--listen`.
#[derive(serde::Serialize)]
struct Listening<'a> {
    address: &'a str,
}

#[derive(Debug, thiserror::Error)]
enum CommandError {
    #[error("cannot listen at {address}")]
    Bind { address: SocketAddr, source: io::Error },
    #[error("cannot start the server")]
    Start { source: io::Error },
}

/// Runs the command.
///
/// # Errors
/// If the folder cannot be used, the address is taken, or the webhook cannot be reached.
pub fn run(args: &Args) -> Result<Exit, Fatal> {
    match args.listen {
        Some(address) => args.listen(address),
        None => args.answer(),
    }
}

impl Args {
    fn silent_after_s(&self) -> u64 {
        u64::from(self.silent_after) * HOUR_S
    }

    /// Prints the units, writes their page, sends the alarms.
    fn answer(&self) -> Result<Exit, Fatal> {
        let (records, refused) = folder::read(&self.folder)?;
        let units = views(&records, &self.units, now::since_1970_ms() / 1000, self.silent_after_s());
        if let Some(file) = &self.out {
            let picture = |view: &UnitView| {
                let bytes = records.get(&UnitId::new(&view.unit).ok()?)?.facts.picture.as_ref()?;
                Some(format!("data:image/jpeg;base64,{}", Base64::encode_to_string(bytes).ok()?))
            };
            let page = page(&units, Form::File, picture);
            durable::save(file, page.as_bytes()).map_err(|source| Fatal::write(file, source))?;
        }
        let ok = units.iter().all(|view| view.ok) && refused.is_empty();
        if self.json {
            print::json(&Answer { ok, units: &units, refused: &refused })?;
        } else {
            print::lines(table::lines(&units))?;
            for file in &refused {
                print::note(&format!("refused: {}", file.line()));
            }
        }
        if let Some(url) = &self.alarm {
            let _held = folder::take(&self.folder)?;
            let sending = Webhook::open(url, &self.folder)?.send(&units, &AtomicBool::new(false));
            if let Some(error) = sending.failed.into_iter().next() {
                return Err(Fatal::new(Exit::Unreadable, error).hint("the next run tries again"));
            }
        }
        Ok(if ok { Exit::Fine } else { Exit::No })
    }

    /// Serves until it is interrupted.
    fn listen(&self, address: SocketAddr) -> Result<Exit, Fatal> {
        let start = |source| Fatal::new(Exit::Unreadable, CommandError::Start { source });
        let _held = folder::take(&self.folder)?;
        let (records, refused) = folder::read(&self.folder)?;
        for file in &refused {
            print::note(&format!("note: no report: {}", file.line()));
        }
        let webhook = self.alarm.as_ref().map(|url| Webhook::open(url, &self.folder)).transpose()?;
        let listener = TcpListener::bind(address)
            .map_err(|source| Fatal::new(Exit::No, CommandError::Bind { address, source }))?;
        let url = format!("http://{}/", listener.local_addr().map_err(start)?);
        let (named, most) = (self.units.clone(), usize::from(self.most));
        let rules = Rules { named, most, silent_after_s: self.silent_after_s() };
        let desk = Arc::new(Desk::new(self.folder.clone(), rules, records));
        let stop = machine::stop_on_signals()?;
        let watching = webhook.map(|webhook| webhook::watch(webhook, Arc::clone(&desk), Arc::clone(&stop)));
        let watching = watching.transpose().map_err(start)?;
        let runtime = tokio::runtime::Builder::new_multi_thread().worker_threads(2).enable_all().build();
        let runtime = runtime.map_err(start)?;
        if self.json {
            print::json(&Listening { address: &url })?;
        } else {
            print::lines([url])?;
        }
        let doors = Doors { names: self.hosts.clone(), path: self.path.clone() };
        let served = runtime.block_on(server::serve(listener, server::router(desk, doors), raised(Arc::clone(&stop))));
        stop.store(true, Ordering::Relaxed);
        // A report that is being written is waited for.
        drop(runtime);
        // It ends within a tick of the flag, or when the webhook has answered once.
        let _ = watching.map(std::thread::JoinHandle::join);
        served.map_err(start)?;
        Ok(Exit::Fine)
    }
}

/// Ends when `stop` is raised.
async fn raised(stop: Arc<AtomicBool>) {
    while !stop.load(Ordering::Relaxed) {
        tokio::time::sleep(Duration::from_millis(100)).await;
    }
}

/// `7181`, `127.0.0.1:7181` or `[::1]:7181`: where to listen. A port alone is of this machine's own address.
fn address(text: &str) -> Result<SocketAddr, String> {
    let own = |port| SocketAddr::new(IpAddr::V4(Ipv4Addr::LOCALHOST), port);
    let wanted = "wanted a port, or an address with a port, such as 7181 or 192.168.1.5:7181";
    text.parse().map(own).or_else(|_| text.parse()).map_err(|_: std::net::AddrParseError| wanted.to_owned())
}

fn unit(text: &str) -> Result<UnitId, String> {
    UnitId::new(text).map_err(|error| error.to_string())
}

#[cfg(test)]
mod tests {
    use super::address;

    #[test]
    fn a_port_alone_is_of_this_machine_only() {
        let found = |text| address(text).map(|address| address.to_string());
        assert_eq!(found("7181").as_deref(), Ok("127.0.0.1:7181"));
        assert_eq!(found("0.0.0.0:80").as_deref(), Ok("0.0.0.0:80"));
        assert_eq!(found("[::1]:80").as_deref(), Ok("[::1]:80"));
        for bad in ["", "70000", "localhost:80", "0.0.0.0", ":80"] {
            assert!(found(bad).is_err(), "{bad}");
        }
    }
}
