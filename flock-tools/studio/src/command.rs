//! `dreams studio DIR`: a page in the browser that does what the commands do, and shows pictures.
//!
//! Owns the command: its options, and what starts and ends with it. Never listens at another address than this machine's own.
//!
//! Start at [`run`].

use std::env;
use std::fs::{self, File};
use std::io::{self, Write};
use std::os::unix::fs::OpenOptionsExt;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

use operations::decoder::Decoder;
use operations::program::{Exit, Fatal, now, print};
use operations::render::machine;

use crate::fence::{Fence, Secrets, layer};
use crate::page::Page;
use crate::routes;
use crate::server::{Server, StudioError};
use crate::store::shipping::Shipping;
use crate::work::{go_on, own_command};
use crate::workshop::{Opening, Workshop};

/// How often the manifest is looked at: somebody else may have edited it.
const LOOK: Duration = Duration::from_secs(1);
/// The look after which what nobody needs is let go of: the first page comes first. And so many looks later, again.
const FIRST_CLEARING: u32 = 60;
const CLEARINGS: u32 = 86_400;
/// The file that leads a browser to the page.
const WAY_IN: &str = "open.html";

/// Open a flock in the browser: choose, link, balance, breed, look, render, pack
///
/// The page shows pictures of all sheep, the graph with its shares, the walk without a gap, joins frame by frame, broods and
/// their family tree. It edits the manifest as the commands do, so both may be used at once, and every edit can be taken back.
/// Only this computer's own browser reaches it, with the address that is printed. It runs until it is interrupted; jobs that
/// were not finished then go on at the next start.
#[derive(Debug, clap::Args)]
#[command(after_help = "Exit status:
  0  it was interrupted
  1  the port is taken
  2  the command line or the manifest is wrong
  3  a file could not be read or written")]
pub struct Args {
    /// Folder of the flock
    dir: PathBuf,
    /// Port of the page [default: any that is free]
    #[arg(long, value_name = "PORT", default_value_t = 0, hide_default_value = true)]
    port: u16,
    /// Only print the address
    #[arg(long)]
    no_open: bool,
    /// Folder of the pool in which accepted sheep live; made when it is needed [default: pool in the flock's folder]
    #[arg(long, value_name = "POOL")]
    pool: Option<PathBuf>,
    /// Folder of genomes from which sheep may come in
    #[arg(long, value_name = "FOLDER")]
    archive: Option<PathBuf>,
    /// A secret key that may sign, besides those that lie beside the flock's folder; may be repeated
    #[arg(long = "key", value_name = "KEY")]
    keys: Vec<PathBuf>,
    /// Take the passphrase from the first line of this file, instead of asking for it on this terminal
    #[arg(long, value_name = "FILE")]
    passphrase_file: Option<PathBuf>,
    /// Folder of the bundles [default: outbox beside the flock's folder]
    #[arg(long, value_name = "FOLDER")]
    outbox: Option<PathBuf>,
    /// A folder to publish to, besides mounted sticks; may be repeated
    #[arg(long = "to", value_name = "FOLDER")]
    targets: Vec<PathBuf>,
    /// Clips rendered at once
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u8).range(1..=64))]
    jobs: u8,
    /// Serve the files of the page from this folder: for those who write it
    #[arg(long, value_name = "FOLDER", hide = true)]
    page: Option<PathBuf>,
    /// Print the address as one JSON document
    #[arg(long)]
    json: bool,
}

/// The answer with `--json`.
#[derive(serde::Serialize)]
struct Answer<'a> {
    address: &'a str,
}

/// Runs the command, until it is interrupted.
///
/// # Errors
/// If the flock cannot be read, or the port is taken.
pub fn run(args: &Args, decoder: &'static dyn Decoder) -> Result<Exit, Fatal> {
    let start = |source| Fatal::new(Exit::Unreadable, StudioError::Start { source });
    let workshop = Arc::new(Workshop::open(args.opening(decoder))?);
    let server = Server::bind(args.port).map_err(|source| {
        Fatal::new(Exit::No, StudioError::Bind { port: args.port, source })
            .hint("without --port it takes one that is free")
    })?;
    let fence = Arc::new(Fence::new(server.port(), Secrets::from_system().map_err(start)?));
    let address = fence.address();
    let runtime = Server::runtime().map_err(start)?;
    let stop = machine::stop_on_signals()?;
    go_on(&workshop);
    let watching = watch(&workshop, Arc::clone(&stop)).map_err(start)?;
    if args.json {
        print::json(&Answer { address: &address })?;
    } else {
        print::lines([address.clone()])?;
    }
    if !args.no_open {
        open_browser(&workshop.own, &address);
    }
    let page = args.page.clone().map_or(Page::Embedded, Page::Folder);
    let router = layer(page.router().merge(Arc::clone(&workshop.hub).router()).merge(routes::all(&workshop)), fence);
    let served = runtime.block_on(server.serve(router, raised(Arc::clone(&stop))));
    stop.store(true, Ordering::Relaxed);
    // It ends within a tick of the flag.
    let _ = watching.join();
    own_command::end_all();
    // Handlers that still read files are waited for with it.
    runtime.shutdown_timeout(LOOK);
    drop(workshop);
    served.map_err(start)?;
    Ok(Exit::Fine)
}

/// Ends when `stop` is raised.
async fn raised(stop: Arc<AtomicBool>) {
    while !stop.load(Ordering::Relaxed) {
        tokio::time::sleep(Duration::from_millis(100)).await;
    }
}

/// Looks after the manifest until `stop` is raised.
fn watch(workshop: &Arc<Workshop>, stop: Arc<AtomicBool>) -> io::Result<thread::JoinHandle<()>> {
    let workshop = Arc::clone(workshop);
    let look = move || {
        for looks in (0..CLEARINGS).cycle().take_while(|_| !stop.load(Ordering::Relaxed)) {
            workshop.look();
            if looks == FIRST_CLEARING {
                let workshop = Arc::clone(&workshop);
                // Edits are noticed meanwhile. Without a thread it is for the next time.
                let _ = thread::Builder::new().name("clearing".to_owned()).spawn(move || workshop.clear());
            }
            now::pause(LOOK, &stop);
        }
    };
    thread::Builder::new().name("manifest".to_owned()).spawn(look)
}

/// Has the desktop, if there is one, open `address`: by a file in the studio's `own` folder, because other users of the
/// machine can read the command lines of programs.
fn open_browser(own: &Path, address: &str) {
    let has_desktop = ["DISPLAY", "WAYLAND_DISPLAY"].iter().any(|name| env::var_os(name).is_some());
    if !has_desktop {
        return;
    }
    let file = own.join(WAY_IN);
    let text = format!("<!doctype html><title>dreams</title><meta http-equiv=\"refresh\" content=\"0;url={address}\">");
    let opened = write_private(&file, &text).and_then(|()| {
        let mut open = Command::new("xdg-open");
        open.arg(&file).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null()).spawn()
    });
    if opened.is_err() {
        print::note("note: no browser could be started; open the address in one");
    }
}

/// Writes a file that only its owner can read.
fn write_private(path: &Path, text: &str) -> io::Result<()> {
    match fs::remove_file(path) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error),
        _ => {}
    }
    let mut file = File::options().write(true).create_new(true).mode(0o600).open(path)?;
    file.write_all(text.as_bytes())
}

impl Args {
    /// What the studio is opened with.
    fn opening(&self, decoder: &'static dyn Decoder) -> Opening<'_> {
        let (outbox, targets) = (self.outbox.clone(), self.targets.clone());
        let shipping = Shipping::new(&self.dir, &self.keys, outbox, targets, self.passphrase_file.clone());
        let (pool, archive) = (self.pool.clone(), self.archive.clone());
        Opening { folder: &self.dir, pool, archive, shipping, threads: self.jobs.into(), decoder }
    }
}
