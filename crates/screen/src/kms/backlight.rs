//! A panel's backlight.
//!
//! Finds it below its connector in `/sys`, and sets it. Some panels are slow, so that a separate thread writes and no
//! frame waits for it. The caller decides how bright.
//!
//! Start at [`Backlight::find`].

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::Path;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread;

/// The kernel's folder of all connectors.
pub(super) const CONNECTORS: &str = "/sys/class/drm";

/// A backlight that may be written. Its thread ends when it is dropped.
pub(super) struct Backlight(Sender<u16>);

impl Backlight {
    /// The backlight of the display at `connector` of `card`, as `/dev/dri/card0`; `None` if it has none that may be
    /// written. `connectors` is [`CONNECTORS`].
    pub(super) fn find(connectors: &Path, card: &Path, connector: &str) -> Option<Self> {
        let card = card.canonicalize().ok()?;
        let folder = connectors.join(format!("{}-{connector}", card.file_name()?.to_str()?));
        // The drivers of panels register their backlight below the connector.
        let mut entries = fs::read_dir(folder).ok()?.flatten().map(|entry| entry.path());
        let backlight = entries.find(|path| path.join("max_brightness").is_file())?;
        open(&backlight)
            .inspect_err(|error| tracing::info!(%error, backlight = %backlight.display(), "cannot open the backlight for writing"))
            .ok()
    }

    /// Sets it to this many thousandths of its maximum, at least 1; returns at once.
    pub(super) fn set(&self, thousandths: u16) {
        // If the thread is gone it has panicked, which was logged.
        self.0.send(thousandths).ok();
    }
}

fn open(backlight: &Path) -> io::Result<Backlight> {
    let most: u64 = fs::read_to_string(backlight.join("max_brightness"))?.trim().parse().map_err(io::Error::other)?;
    let file = File::options().write(true).open(backlight.join("brightness"))?;
    let (sender, wanted) = channel();
    thread::Builder::new().name("backlight".to_owned()).spawn(move || write_newest(&file, most, &wanted))?;
    Ok(Backlight(sender))
}

/// Writes the newest requested value, until the sender is dropped.
fn write_newest(mut file: &File, most: u64, wanted: &Receiver<u16>) {
    while let Ok(first) = wanted.recv() {
        let thousandths = wanted.try_iter().last().unwrap_or(first);
        let power = (most * u64::from(thousandths.min(1000)) / 1000).max(1);
        if let Err(error) = file.write_all(power.to_string().as_bytes()) {
            tracing::warn!(%error, power, most, "cannot set the backlight");
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Backlight;
    use std::fs;
    use std::path::Path;
    use std::thread;
    use std::time::Duration;

    /// Waits until the backlight was told `wanted`, last of all: a file in `/sys` begins anew with every write.
    fn await_told(backlight: &Path, wanted: &str) {
        let told = || fs::read_to_string(backlight.join("brightness")).unwrap();
        let is_told = (0..2_000).any(|_| {
            thread::park_timeout(Duration::from_millis(1));
            told().ends_with(wanted)
        });
        assert!(is_told, "wanted {wanted}, told {}", told());
    }

    #[test]
    fn a_display_has_its_own_backlight_which_never_goes_off() {
        let folder = tempfile::tempdir().unwrap();
        let card = folder.path().join("card1");
        fs::write(&card, "").unwrap();
        let connectors = folder.path().join("drm");
        let folder_of = |connector: &str| connectors.join(connector).join("panel_backlight");
        for (connector, most) in [("card1-eDP-1", "400\n"), ("card0-eDP-1", "100\n")] {
            fs::create_dir_all(folder_of(connector)).unwrap();
            fs::write(folder_of(connector).join("max_brightness"), most).unwrap();
            fs::write(folder_of(connector).join("brightness"), "").unwrap();
        }
        fs::create_dir_all(connectors.join("card1-HDMI-A-1/power")).unwrap();
        let find = |connector: &str| Backlight::find(&connectors, &card, connector);
        let backlight = find("eDP-1").unwrap();
        for (thousandths, wanted) in [(1000, "400"), (500, "200"), (2000, "400"), (0, "1")] {
            backlight.set(thousandths);
            await_told(&folder_of("card1-eDP-1"), wanted);
        }
        assert_eq!(fs::read_to_string(folder_of("card0-eDP-1").join("brightness")).unwrap(), "", "another card's");
        assert!(find("HDMI-A-1").is_none(), "it has none");
        assert!(find("DP-1").is_none(), "it is no connector");
        fs::write(folder_of("card1-eDP-1").join("max_brightness"), "many").unwrap();
        assert!(find("eDP-1").is_none(), "it says nothing of use");
    }
}
