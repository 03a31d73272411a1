//! Connects a radio with the Wi-Fi that the owner has set, for as long as the radio is there.
//!
//! Owns the order: `wpa_supplicant` runs while there is a Wi-Fi to connect with, is started again when the settings
//! change or it ends, and a notice says what people can mend. Without such settings nothing is run.
//!
//! Start at [`run`].

use crate::link::{Effect, Link, event};
use crate::supplicant::Supplicant;
use crate::take_in::is_there;
use clap::Args;
use diagnostics::{chain, print_error};
use player::{Lasting, Notice, now};
use settings::owner::FILE_NAME;
use settings::wifi::CONTROL;
use settings::{FileVersion, Owner};
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::thread;
use std::time::Duration;

/// Between two looks whether the settings have changed.
const OFTEN: Duration = Duration::from_secs(2);
/// How long a supplicant that ended is left alone.
const PAUSE: Duration = Duration::from_secs(10);

/// Connect a radio with the Wi-Fi that the owner has set
#[derive(Debug, Args)]
#[command(after_help = super::EXIT_STATUS)]
pub(crate) struct Options {
    /// The radio, as wlan0
    interface: String,
    /// Where the Wi-Fi is kept, with its password
    #[arg(long, value_name = "FILE")]
    wifi: PathBuf,
    /// Where the last good settings are kept
    #[arg(long, value_name = "FILE")]
    keep: PathBuf,
    /// Where notices are written: what is wrong is told beside it, until it is right
    #[arg(long, alias = "card", value_name = "FILE")]
    notice: PathBuf,
    /// The folder of the control sockets of `wpa_supplicant`
    #[arg(long, value_name = "FOLDER", default_value = CONTROL)]
    control: PathBuf,
}

/// Connects, again and again.
pub(crate) fn run(options: &Options) -> ! {
    let mut said = String::new();
    loop {
        take_back(&options.notice);
        let Some(settings) = FileVersion::of(&options.wifi) else {
            thread::park_timeout(OFTEN);
            continue;
        };
        if let Err(error) = connect(options, settings) {
            // The same thing again and again is said once.
            let why = chain(&error);
            if why != said {
                print_error(&error, Some("trying again in ten seconds"));
                said = why;
            }
            thread::park_timeout(PAUSE);
        }
    }
}

/// Connects with these `settings`, until there are others.
fn connect(options: &Options, settings: FileVersion) -> io::Result<()> {
    let mut supplicant = Supplicant::start(&options.interface, &options.wifi, &options.control)?;
    let mark = options.wifi.with_extension("joined");
    let is_known = is_there(&mark, &marked(settings));
    let mut link = if is_known { Link::Known { refused: 0 } } else { Link::New { unseen_since: None } };
    while FileVersion::of(&options.wifi) == Some(settings) {
        if let Some(status) = supplicant.ended()? {
            return Err(io::Error::other(format!("`wpa_supplicant` has ended: {status}")));
        }
        let told = supplicant.told_within(OFTEN)?;
        let Some(event) = told.as_deref().and_then(event) else { continue };
        let (next, effect) = link.on(event, now());
        link = next;
        match effect {
            Effect::Nothing => {}
            Effect::TakeBack => {
                take_back(&options.notice);
                // Without it a power cut only makes us believe less.
                fs::write(&mark, marked(settings)).ok();
            }
            Effect::TellName => tell(options, "is not there. Its name stands in"),
            Effect::TellPassword => tell(options, "does not take the password in"),
            Effect::TellServer => tell(options, "has a server without an authority in"),
        }
    }
    Ok(())
}

/// Writes the notice that says what is wrong with the Wi-Fi.
fn tell(options: &Options, what: &str) {
    let name = Owner::kept(&options.keep).wifi().map(|wifi| wifi.name.as_str().to_owned()).unwrap_or_default();
    let text = format!("The Wi-Fi {name} {what} {FILE_NAME}.");
    eprintln!("{text}");
    if let Err(error) = (Notice { text, thousandths: None }).tell(&Lasting::Wifi.path(&options.notice)) {
        print_error(&error, Some("cannot write the notice over the picture"));
    }
}

fn take_back(notice: &Path) {
    if let Err(error) = Lasting::Wifi.take_back(notice) {
        eprintln!("{}", chain(&error));
    }
}

/// What is written down of settings with which the Wi-Fi was joined.
fn marked(FileVersion { inode, written_s, written_ns }: FileVersion) -> String {
    format!("{inode} {written_s} {written_ns}\n")
}
