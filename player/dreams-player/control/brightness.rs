//! The brightness and the hours of the display: a thread that looks every second what they are to be.
//!
//! The settings of the unit's owner win over the config, and are in use as soon as they are stored. `settings::hours`
//! computes the brightness, `settings::kept` reads the owner's settings; the flip thread takes both from [`DisplayTarget`]
//! and applies them. Never touches a screen.
//!
//! Start at [`BrightnessControl::start`].

use crate::control::display_power::{DisplayPower, PowerAnswers};
use crate::recording::SharedView;
use player::{ClockReader, ThreadError, hold, now, threads};
use screen::OutputSettings;
use settings::hours::{Day, Lighting};
use settings::{FileVersion, Owner, kept};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::Duration;
use timing::Nanos;
use tracing::{info, warn};

/// Between two looks.
const OFTEN: Duration = Duration::from_secs(1);

/// How the display is to be, for the flip thread, and since when, for people.
#[derive(Debug, Default)]
pub(crate) struct DisplayTarget {
    wanted: Mutex<Option<(Lighting, Arc<OutputSettings>)>>,
    change: Mutex<Option<SettingsChange>>,
    /// What the display itself has answered.
    pub(crate) power: Arc<PowerAnswers>,
}

/// A change of the owner's settings while the player runs.
#[derive(Clone, Debug)]
pub(crate) struct SettingsChange {
    /// The keys that have another value now.
    pub(crate) keys: Vec<&'static str>,
    /// When the player saw it.
    pub(crate) at: Nanos,
}

impl DisplayTarget {
    /// Sets the brightness, and what the owner has set of the display.
    pub(crate) fn set(&self, lighting: Lighting, output: &Arc<OutputSettings>) {
        *hold(&self.wanted) = Some((lighting, Arc::clone(output)));
    }

    /// What was set last.
    pub(crate) fn get(&self) -> Option<(Lighting, Arc<OutputSettings>)> {
        hold(&self.wanted).clone()
    }

    /// The newest change of settings that concern the player; `None` if there was none since it began.
    pub(crate) fn change(&self) -> Option<SettingsChange> {
        hold(&self.change).clone()
    }
}

/// The settings of brightness and hours, of the config and of the owner.
#[derive(Debug)]
pub(crate) struct BrightnessControl {
    config: Day,
    path: PathBuf,
    /// The versions of the owner's files at the last look; `None` before the first.
    known: Option<[Option<FileVersion>; 2]>,
    /// Those were refused, and nobody was told yet.
    is_refused: bool,
    owner: Owner,
    day: Day,
    output: Arc<OutputSettings>,
    /// The keys that have changed since they were asked for.
    changed: Vec<&'static str>,
}

impl BrightnessControl {
    /// By `config`, and by what the file at `path` has instead.
    pub(crate) fn new(config: Day, path: &Path) -> Self {
        Self {
            day: config.clone(),
            config,
            path: path.to_owned(),
            known: None,
            is_refused: false,
            owner: Owner::default(),
            output: Arc::default(),
            changed: Vec::new(),
        }
    }

    /// Keeps `target` as it is to be by `clock`, now and for as long as the process lives; `view` says where a display is
    /// lit.
    pub(crate) fn start(
        mut self,
        target: Arc<DisplayTarget>,
        view: Arc<SharedView>,
        clock: ClockReader,
    ) -> Result<(), ThreadError> {
        let mut power = DisplayPower::start(Arc::clone(&target.power))?;
        let mut look = move || {
            let wanted = self.look(clock.read().known_s());
            let lighting = power.look(wanted, self.day.night.power(), view.connector(), now());
            target.set(lighting, &self.output);
            let keys = std::mem::take(&mut self.changed);
            if !keys.is_empty() {
                info!(keys = keys.join(", "), "the owner's settings have changed and are in use");
                *hold(&target.change) = Some(SettingsChange { keys, at: now() });
            }
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
        let found = kept::versions(&self.path);
        if self.known == Some(found) {
            if std::mem::take(&mut self.is_refused) {
                warn!("the owner's settings are not whole, using those from before");
            }
        } else if self.known.replace(found).is_none() {
            self.use_settings(Owner::kept(&self.path));
        } else if let Some(owner) = Owner::kept_whole(&self.path) {
            self.is_refused = false;
            self.changed.extend(changed(&self.owner, &owner));
            self.use_settings(owner);
        } else {
            // They may be in the middle of being written: the next look decides.
            self.is_refused = true;
        }
        self.day.lighting(known_s)
    }

    fn use_settings(&mut self, owner: Owner) {
        let set = owner.clone();
        self.day = Day {
            hours: set.hours.or_else(|| self.config.hours.clone()),
            closed: set.closed,
            night: set.night.unwrap_or(self.config.night),
            brightness: set.brightness.unwrap_or_else(|| self.config.brightness.clone()),
            zone: set.timezone.or_else(|| self.config.zone.clone()),
        };
        if owner.output() != *self.output {
            self.output = Arc::new(owner.output());
        }
        self.owner = owner;
    }

    /// What the owner had set of the display at the last look.
    pub(crate) fn output(&self) -> &OutputSettings {
        &self.output
    }
}

/// The keys that concern the player and have another value `now` than `before`.
fn changed(before: &Owner, now: &Owner) -> Vec<&'static str> {
    let keys = [
        ("brightness", before.brightness != now.brightness),
        ("closed", before.closed != now.closed),
        ("connector", before.connector != now.connector),
        ("hours", before.hours != now.hours),
        ("margin", before.margin != now.margin),
        ("mode", before.mode != now.mode),
        ("night", before.night != now.night),
        ("range", before.range != now.range),
        ("rotate", before.rotate != now.rotate),
        ("timezone", before.timezone != now.timezone),
    ];
    keys.into_iter().filter(|(_, has_changed)| *has_changed).map(|(key, _)| key).collect()
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
        assert_eq!(control.look(NOON_S), light(400), "what is not whole changes nothing");
        fs::remove_file(&owner).unwrap();
        assert_eq!(control.look(NOON_S), light(600));
    }

    #[test]
    fn a_change_of_settings_names_its_keys_once_and_settings_at_the_start_are_no_change() {
        let folder = tempfile::tempdir().unwrap();
        let owner = folder.path().join("dreams.toml");
        let keep = |text: &str| {
            let kept = Kept::of(text);
            for (path, text) in [(owner.clone(), kept.first), (kept::resolved_path(&owner), kept.resolved)] {
                fs::write(folder.path().join("new"), text).unwrap();
                fs::rename(folder.path().join("new"), path).unwrap();
            }
        };
        let brightness = "60".parse().unwrap();
        let config = Day { hours: None, closed: Closed::default(), night: Night::Off, brightness, zone: None };
        let mut control = BrightnessControl::new(config, &owner);
        let mut changed = || {
            control.look(NOON_S);
            std::mem::take(&mut control.changed)
        };
        keep("rotate = 90\nmargin = 3");
        assert_eq!(changed(), Vec::<&str>::new());
        keep("rotate = 180\nclosed = [\"Mon\"]\nurl = \"https://example.org\"");
        assert_eq!([changed(), changed()], [vec!["closed", "margin", "rotate"], vec![]]);
        keep("rotate = 180\nclosed = [\"Mon\"]");
        assert_eq!(changed(), Vec::<&str>::new(), "a web address is no matter of the player's");
        fs::write(kept::resolved_path(&owner), "format = 1\nof = \"of another\"\nrotate = 270\n").unwrap();
        assert_eq!(changed(), Vec::<&str>::new());
        keep("rotate = 270\nmode = \"640x480\"\nrange = \"full\"\nconnector = \"DP-1\"\nhours = \"08:00-23:00\"");
        assert_eq!(changed(), ["closed", "connector", "hours", "mode", "range", "rotate"]);
        keep("brightness = 30\ntimezone = \"UTC\"\nnight = \"black\"");
        assert_eq!(changed().len(), 8, "a key that is taken back has changed, too");
    }
}
