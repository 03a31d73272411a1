//! A thread that sees to it that the display is as its owner and the hour want it.
//!
//! Owns when it looks, every second, and that what the owner of the unit has set goes before what the config says. What
//! the hour wants is `player::hours`, what the owner has set `player::owner`; the flip thread takes it from the glass and
//! tells the screen. Never touches a screen.
//!
//! Start at [`LightingControl::start`].

use crate::control::notice_watcher::{Telling, telling};
use crate::fatal::Fatal;
use crate::stream::glass::Glass;
use player::hours::{Day, Lighting};
use player::owner::Owner;
use screen::OutputSettings;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::thread;
use std::time::Duration;

/// Between two looks.
const OFTEN: Duration = Duration::from_secs(1);

/// What the unit was told about its days, and by whom.
#[derive(Debug)]
pub(crate) struct LightingControl {
    config: Day,
    owner: PathBuf,
    /// Which of the owner's settings `day` is made of.
    known: Option<Telling>,
    day: Day,
    output: Arc<OutputSettings>,
}

impl LightingControl {
    /// One that goes by `config`, and by what the file `owner` has instead.
    pub(crate) fn new(config: Day, owner: &Path) -> Self {
        Self { day: config.clone(), config, owner: owner.to_owned(), known: None, output: Arc::default() }
    }

    /// Has the display be as it is to be at `clock`, by way of `glass`, now and for as long as the process lives.
    ///
    /// # Errors
    /// [`Fatal`] if the thread cannot be started.
    pub(crate) fn start(mut self, glass: Arc<Glass>, clock: fn() -> u64) -> Result<(), Fatal> {
        let mut look = move || {
            glass.set_lighting(self.look(clock()));
            glass.set_output(&self.output);
        };
        look();
        let work = move || {
            loop {
                thread::park_timeout(OFTEN);
                look();
            }
        };
        let thread = thread::Builder::new().name("lighting".to_owned()).spawn(work);
        thread.map(drop).map_err(|source| Fatal::Thread { name: "lighting", source })
    }

    /// How bright it is to be when the clock shows `clock_s`.
    pub(crate) fn look(&mut self, clock_s: u64) -> Lighting {
        let found = telling(&self.owner);
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
    use crate::settings::config::Config;
    use player::hours::Lighting;
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
        let mut config = Config::default().day();
        config.zone = Some("UTC".parse().unwrap());
        config.brightness = "60".parse().unwrap();
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
