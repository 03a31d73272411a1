//! A thread that sees to it that the display is as its owner and the hour want it.
//!
//! Owns when it looks, every second, and that what the owner of the unit has set goes before what the config says. What
//! the hour wants is `player::hours`, what the owner has set `player::owner`; the flip thread takes it from
//! [`DisplayTarget`] and tells the screen. Never touches a screen.
//!
//! Start at [`LightingControl::start`].

use player::file_version::FileVersion;
use player::hours::{Day, Lighting};
use player::lock::hold;
use player::owner::Owner;
use player::threads::{self, ThreadError};
use screen::OutputSettings;
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
    /// Has the display be as the hour wants it, and go by what its owner has set.
    pub(crate) fn set(&self, lighting: Lighting, output: &Arc<OutputSettings>) {
        *hold(&self.0) = Some((lighting, Arc::clone(output)));
    }

    /// What was set last. It is held for the moment of a copy only.
    pub(crate) fn get(&self) -> Option<(Lighting, Arc<OutputSettings>)> {
        hold(&self.0).clone()
    }
}

/// What the unit was told about its days, and by whom.
#[derive(Debug)]
pub(crate) struct LightingControl {
    config: Day,
    owner: PathBuf,
    /// Which of the owner's settings `day` is made of.
    known: Option<FileVersion>,
    day: Day,
    output: Arc<OutputSettings>,
}

impl LightingControl {
    /// One that goes by `config`, and by what the file `owner` has instead.
    pub(crate) fn new(config: Day, owner: &Path) -> Self {
        Self { day: config.clone(), config, owner: owner.to_owned(), known: None, output: Arc::default() }
    }

    /// Has the display be as it is to be at `clock`, by way of `target`, now and for as long as the process lives.
    ///
    /// # Errors
    /// [`ThreadError`].
    pub(crate) fn start(mut self, target: Arc<DisplayTarget>, clock: fn() -> u64) -> Result<(), ThreadError> {
        let mut look = move || {
            let lighting = self.look(clock());
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

    /// How bright it is to be when the clock shows `clock_s`.
    pub(crate) fn look(&mut self, clock_s: u64) -> Lighting {
        let found = FileVersion::of(&self.owner);
        if found != self.known {
            self.known = found;
            let owner = Owner::kept(&self.owner);
            self.output = Arc::new(owner.output());
            self.day = Day {
                hours: owner.hours.or(self.config.hours),
                night: owner.night.unwrap_or(self.config.night),
                brightness: owner.brightness.unwrap_or_else(|| self.config.brightness.clone()),
                zone: owner.timezone.or_else(|| self.config.zone.clone()),
            };
        }
        self.day.lighting(clock_s)
    }

    /// What the owner had set of the display at the last look.
    pub(crate) fn output(&self) -> &OutputSettings {
        &self.output
    }
}

#[cfg(test)]
mod tests {
    use super::LightingControl;
    use player::hours::{Day, Lighting, Night};
    use std::fs;

    /// 2026-07-01 12:00 in UTC.
    const NOON_S: u64 = 1_782_907_200;

    #[test]
    fn what_the_owner_keeps_goes_before_the_config_from_then_on_and_no_longer() {
        let folder = tempfile::tempdir().unwrap();
        let owner = folder.path().join("dreams.toml");
        let keep = |text: &str| {
            fs::write(folder.path().join("new"), text).unwrap();
            fs::rename(folder.path().join("new"), &owner).unwrap();
        };
        let (brightness, zone) = ("60".parse().unwrap(), Some("UTC".parse().unwrap()));
        let config = Day { hours: None, night: Night::Off, brightness, zone };
        let mut control = LightingControl::new(config, &owner);
        let light = |thousandths| Lighting::On { thousandths };
        assert_eq!(control.look(NOON_S), light(600));
        keep("hours = \"20:00-23:00\"");
        assert_eq!(control.look(NOON_S), Lighting::Off);
        keep("hours = \"20:00-23:00\"\ntimezone = \"Asia/Tokyo\"\nbrightness = \"30\"");
        assert_eq!(control.look(NOON_S), light(300), "nine in the evening");
        keep("hours = \"20:00-23:00\"\nnight = \"black\"\nrotate = 90");
        assert_eq!((control.look(NOON_S), control.output().rotation.degrees()), (Lighting::Black, 90));
        keep("brightness = \"40\"");
        assert_eq!(control.look(NOON_S), light(400));
        keep("of another version");
        assert_eq!(control.look(NOON_S), light(600));
        fs::remove_file(&owner).unwrap();
        assert_eq!(control.look(NOON_S), light(600));
    }
}
