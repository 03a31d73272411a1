//! The brightness and the hours of the display: a thread that looks every second what they are to be.
//!
//! The settings of the unit's owner win over the config. `settings::hours` computes the brightness, `settings::owner`
//! reads the owner's settings; the flip thread takes both from [`DisplayTarget`] and applies them. Never touches a screen.
//!
//! Start at [`BrightnessControl::start`].

use player::{ClockReader, ThreadError, hold, threads};
use screen::OutputSettings;
use settings::hours::{Day, Lighting};
use settings::{FileVersion, Owner, kept};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::Duration;

/// Between two looks.
const OFTEN: Duration = Duration::from_secs(1);

/// How the display is to be, for the flip thread.
#[derive(Debug, Default)]
pub(crate) struct DisplayTarget(Mutex<Option<(Lighting, Arc<OutputSettings>)>>);

impl DisplayTarget {
    /// Sets the brightness, and what the owner has set of the display.
    pub(crate) fn set(&self, lighting: Lighting, output: &Arc<OutputSettings>) {
        *hold(&self.0) = Some((lighting, Arc::clone(output)));
    }

    /// What was set last.
    pub(crate) fn get(&self) -> Option<(Lighting, Arc<OutputSettings>)> {
        hold(&self.0).clone()
    }
}

/// The settings of brightness and hours, of the config and of the owner.
#[derive(Debug)]
pub(crate) struct BrightnessControl {
    config: Day,
    owner: PathBuf,
    /// The versions of the owner's files that `day` is made of.
    known: [Option<FileVersion>; 2],
    day: Day,
    output: Arc<OutputSettings>,
}

impl BrightnessControl {
    /// By `config`, and by what the file `owner` has instead.
    pub(crate) fn new(config: Day, owner: &Path) -> Self {
        Self { day: config.clone(), config, owner: owner.to_owned(), known: [None; 2], output: Arc::default() }
    }

    /// Keeps `target` as it is to be by `clock`, now and for as long as the process lives.
    pub(crate) fn start(mut self, target: Arc<DisplayTarget>, clock: ClockReader) -> Result<(), ThreadError> {
        let mut look = move || {
            let lighting = self.look(clock.read().known_s());
            target.set(lighting, &self.output);
        };
        look();
        let work = move || {
            loop {
                thread::park_timeout(OFTEN);
                look();
            }
        };
        threads::start("brightness", work).map(drop)
    }

    /// How bright it is to be at `known_s` seconds since 1970; `None` while the time is not known.
    pub(crate) fn look(&mut self, known_s: Option<u64>) -> Lighting {
        let found = kept::versions(&self.owner);
        if found != self.known {
            self.known = found;
            let owner = Owner::kept(&self.owner);
            self.output = Arc::new(owner.output());
            self.day = Day {
                hours: owner.hours.or_else(|| self.config.hours.clone()),
                closed: owner.closed,
                night: owner.night.unwrap_or(self.config.night),
                brightness: owner.brightness.unwrap_or_else(|| self.config.brightness.clone()),
                zone: owner.timezone.or_else(|| self.config.zone.clone()),
            };
        }
        self.day.lighting(known_s)
    }

    /// What the owner had set of the display at the last look.
    pub(crate) fn output(&self) -> &OutputSettings {
        &self.output
    }
}

#[cfg(test)]
mod tests {
    use super::BrightnessControl;
    use settings::hours::{Day, Lighting, Night};
    use settings::kept::{self, Kept};
    use settings::week::Closed;
    use std::fs;

    /// 2026-07-01 12:00 in UTC.
    const NOON_S: Option<u64> = Some(1_782_907_200);

    #[test]
    fn what_the_owner_keeps_goes_before_the_config_from_then_on_and_no_longer() {
        let folder = tempfile::tempdir().unwrap();
        let owner = folder.path().join("dreams.toml");
        let keep = |text: &str| {
            fs::write(folder.path().join("new"), text).unwrap();
            fs::rename(folder.path().join("new"), &owner).unwrap();
        };
        let (brightness, zone) = ("60".parse().unwrap(), Some("UTC".parse().unwrap()));
        let config = Day { hours: None, closed: Closed::default(), night: Night::Off, brightness, zone };
        let mut control = BrightnessControl::new(config, &owner);
        let light = |thousandths| Lighting::On { thousandths };
        assert_eq!(control.look(NOON_S), light(600));
        keep("hours = \"20:00-23:00\"");
        assert_eq!(control.look(NOON_S), Lighting::Off);
        keep("hours = \"20:00-23:00\"\ntimezone = \"Asia/Tokyo\"\nbrightness = \"30\"");
        assert_eq!(control.look(NOON_S), light(300), "nine in the evening");
        keep("hours = \"20:00-23:00\"\nnight = \"black\"\nrotate = 90");
        assert_eq!((control.look(NOON_S), control.output().rotation.degrees()), (Lighting::Black, 90));
        keep("hours = \"Sat-Tue 08:00-23:00\"");
        assert_eq!(control.look(NOON_S), Lighting::Off, "it is Wednesday");
        keep("closed = [2026-07-01]");
        assert_eq!(control.look(NOON_S), Lighting::Off);
        keep("brightness = \"40\"");
        assert_eq!(control.look(NOON_S), light(400));
        keep(
            "colour = 7\nbrightness = \"40\"\nrotate = 270\nhours = \"08:00-23:00\"\nnight = \"dusk\"\n[later]\na = 1",
        );
        assert_eq!(control.look(NOON_S), light(400), "what another version added or changed takes nothing else away");
        assert_eq!(control.output().rotation.degrees(), 270);
        fs::write(kept::resolved_path(&owner), Kept::of(&fs::read_to_string(&owner).unwrap()).resolved).unwrap();
        assert_eq!((control.look(NOON_S), control.output().rotation.degrees()), (light(400), 270));
        keep("no settings");
        assert_eq!(control.look(NOON_S), light(600));
        fs::remove_file(&owner).unwrap();
        assert_eq!(control.look(NOON_S), light(600));
    }
}
