//! The power of a display itself, which it is asked to switch: by DDC/CI over the cable's I2C bus, or by HDMI-CEC.
//!
//! Owns both protocols, and which device of the kernel leads to the display. A display answers slowly or not at all: each
//! call may take seconds, so no frame may wait for it. Never switches the signal: `kms/light.rs` does.
//!
//! Start at [`switch_display`].

mod cec;
mod ddc;
mod find;

use crate::ConnectorId;
use std::fmt;
use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};

/// Where the kernel lists connectors, and where device nodes are.
const SYS: &str = "/sys";
const DEV: &str = "/dev";

/// By which protocol a display is asked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PowerMeans {
    /// HDMI-CEC, by an adapter of the HDMI connector.
    Cec,
    /// DDC/CI, by the I2C bus of any digital connector.
    Ddc,
}

/// Why a display was not switched.
#[derive(Debug, thiserror::Error)]
pub enum PowerError {
    /// There is no device that leads to the display.
    #[error("no {device} leads to the display at `{connector}`", device = means.device())]
    Absent {
        /// The protocol.
        means: PowerMeans,
        /// The card and its connector.
        connector: String,
    },
    /// The device cannot be opened.
    #[error("cannot open `{path}`", path = path.display())]
    Open {
        /// The device.
        path: PathBuf,
        /// The kernel's error.
        source: io::Error,
    },
    /// The display, or the device that leads to it, has refused a message.
    #[error("cannot send `{message}` to the display")]
    Send {
        /// What was to be sent.
        message: &'static str,
        /// The kernel's error.
        source: io::Error,
    },
    /// The display says that it is still in another state.
    #[error("the display says that it is not on: power mode {mode}, expected 1")]
    Unchanged {
        /// The value of its control D6.
        mode: u16,
    },
    /// The display gives no valid answer.
    #[error("the display gives no valid answer to `{message}`")]
    Unanswered {
        /// What it was asked.
        message: &'static str,
    },
}

impl PowerMeans {
    /// What leads to a display.
    fn device(self) -> &'static str {
        match self {
            Self::Cec => "CEC adapter",
            Self::Ddc => "I2C bus",
        }
    }
}

/// As the settings spell it.
impl fmt::Display for PowerMeans {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Cec => "cec",
            Self::Ddc => "ddc",
        })
    }
}

/// Asks the display at `connector` once to switch on or off. May take some seconds.
///
/// # Errors
/// [`PowerError`]; the display is as it was, or on its way.
pub fn switch_display(means: PowerMeans, connector: &ConnectorId, is_on: bool) -> Result<(), PowerError> {
    let (sys, dev) = (Path::new(SYS), Path::new(DEV));
    let folder = connector.folder();
    let absent = || PowerError::Absent { means, connector: folder.clone().unwrap_or_else(|| connector.name.clone()) };
    let folder = folder.as_deref().ok_or_else(absent)?;
    match means {
        PowerMeans::Cec => {
            let mut adapter = find::cec_adapter(sys, dev, folder).ok_or_else(absent)?;
            cec::switch(&mut adapter, is_on)
        }
        PowerMeans::Ddc => {
            let path = find::i2c_bus(sys, dev, folder).ok_or_else(absent)?;
            let mut bus = open(&path).and_then(|file| ddc::DisplayBus::new(file, &path))?;
            ddc::switch(&mut bus, is_on)
        }
    }
}

/// Opens a device for reading and writing.
fn open(path: &Path) -> Result<File, PowerError> {
    let opened = File::options().read(true).write(true).open(path);
    opened.map_err(|source| PowerError::Open { path: path.to_owned(), source })
}
