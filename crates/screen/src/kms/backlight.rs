//! The lamp behind a display: a panel's backlight.
//!
//! Owns finding it below its connector in `/sys`, and setting it. Some panels take their time over that, so that a thread
//! of its own does: whoever lights frames never waits for it. Never decides how bright.
//!
//! Start at [`Backlight::find`].

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::Path;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread;

/// Where the kernel has a folder for every connector of every card.
pub(super) const CONNECTORS: &str = "/sys/class/drm";

/// A lamp that we may set. Its thread ends with it.
pub(super) struct Backlight(Sender<u16>);

impl Backlight {
    /// The lamp behind the display at `connector` of `card`, as `/dev/dri/card0`; `None` if it has none that we may set.
    /// `connectors` is [`CONNECTORS`].
    pub(super) fn find(connectors: &Path, card: &Path, connector: &str) -> Option<Self> {
        let card = card.canonicalize().ok()?;
        let folder = connectors.join(format!("{}-{connector}", card.file_name()?.to_str()?));
        // The drivers of panels register their lamp below the connector.
        let mut entries = fs::read_dir(folder).ok()?.flatten().map(|entry| entry.path());
        let lamp = entries.find(|path| path.join("max_brightness").is_file())?;
        open(&lamp).inspect_err(|error| tracing::info!(%error, lamp = %lamp.display(), "a lamp may not be set")).ok()
    }

    /// Has it shine with so many thousandths of its power, soon, and never go out.
    pub(super) fn shine(&self, thousandths: u16) {
        // A thread that is gone has panicked, and told so.
        self.0.send(thousandths).ok();
    }
}

fn open(lamp: &Path) -> io::Result<Backlight> {
    let most: u64 = fs::read_to_string(lamp.join("max_brightness"))?.trim().parse().map_err(io::Error::other)?;
    let file = File::options().write(true).open(lamp.join("brightness"))?;
    let (sender, wanted) = channel();
    thread::Builder::new().name("backlight".to_owned()).spawn(move || set(&file, most, &wanted))?;
    Ok(Backlight(sender))
}

/// Sets the lamp to the newest of what is wanted, until nothing ever will be.
fn set(mut file: &File, most: u64, wanted: &Receiver<u16>) {
    while let Ok(first) = wanted.recv() {
        let thousandths = wanted.try_iter().last().unwrap_or(first);
        let power = (most * u64::from(thousandths.min(1000)) / 1000).max(1);
        if let Err(error) = file.write_all(power.to_string().as_bytes()) {
            tracing::warn!(%error, power, most, "the lamp behind the display cannot be set");
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

    /// Waits until the lamp was told `wanted`, last of all: a file in `/sys` begins anew with every write.
    fn await_told(lamp: &Path, wanted: &str) {
        let told = || fs::read_to_string(lamp.join("brightness")).unwrap();
        let is_told = (0..2_000).any(|_| {
            thread::park_timeout(Duration::from_millis(1));
            told().ends_with(wanted)
        });
        assert!(is_told, "wanted {wanted}, told {}", told());
    }

    #[test]
    fn the_lamp_behind_a_display_is_its_own_and_never_goes_out() {
        let folder = tempfile::tempdir().unwrap();
        let card = folder.path().join("card1");
        fs::write(&card, "").unwrap();
        let connectors = folder.path().join("drm");
        let lamp = |connector: &str| connectors.join(connector).join("panel_backlight");
        for (connector, most) in [("card1-eDP-1", "400\n"), ("card0-eDP-1", "100\n")] {
            fs::create_dir_all(lamp(connector)).unwrap();
            fs::write(lamp(connector).join("max_brightness"), most).unwrap();
            fs::write(lamp(connector).join("brightness"), "").unwrap();
        }
        fs::create_dir_all(connectors.join("card1-HDMI-A-1/power")).unwrap();
        let find = |connector: &str| Backlight::find(&connectors, &card, connector);
        let backlight = find("eDP-1").unwrap();
        for (thousandths, wanted) in [(1000, "400"), (500, "200"), (2000, "400"), (0, "1")] {
            backlight.shine(thousandths);
            await_told(&lamp("card1-eDP-1"), wanted);
        }
        assert_eq!(fs::read_to_string(lamp("card0-eDP-1").join("brightness")).unwrap(), "", "another card's");
        assert!(find("HDMI-A-1").is_none(), "it has none");
        assert!(find("DP-1").is_none(), "it is no connector");
        fs::write(lamp("card1-eDP-1").join("max_brightness"), "many").unwrap();
        assert!(find("eDP-1").is_none(), "it says nothing of use");
    }
}
