//! What a unit keeps of what its owner has set.
//!
//! Owns the two files of it, and their reading. `dreams-owner` alone reads the owner's file strictly, once. What it kept is
//! read by programs of other versions, too: by a newer system after an update, by an older one after its return. So all
//! that is not understood here is left out, by itself: a key, a value, a part of a list.
//!
//! - `dreams.toml` is the owner's text, for the systems before [`FORMAT`] 1. These look nowhere else, and refuse the whole
//!   text for one key that they do not know: it is without such keys, and without the password of the Wi-Fi.
//! - `dreams.toml.kept`, beside it, has every key with its value, but no password; as `format` the number of its form; and
//!   as `of` the checksum of the `dreams.toml` that was written with it.
//!
//! The second is read if its form is known, and it belongs to the first. Otherwise the first is read: an older system has
//! written it since, or a newer one has given the second another form. Clocks are not asked which of the two is newer: a
//! unit's may be wrong.
//!
//! Start at [`Owner::kept`].

use crate::config_file::{ConfigError, text_of};
use crate::day::Window;
use crate::file_version::FileVersion;
use crate::owner::Owner;
use bundle::ObjectId;
use std::ffi::OsString;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use toml::{Table, Value};

/// The form of the second file. A version that gives a key of it another meaning has another number.
const FORMAT: i64 = 1;
/// The members of the second file that no owner sets.
const NUMBER: &str = "format";
const OF: &str = "of";
/// What stands in neither file.
const PASSWORD: &str = "wifi_password";
/// The keys that are older than some of their values, and the values of the second that are as old.
const HOURS: &str = "hours";
const NIGHT: &str = "night";
const FIRST_NIGHTS: [&str; 2] = ["off", "black"];
/// The keys that the systems before [`FORMAT`] 1 know.
const FIRST_KEYS: [&str; 27] = [
    "acknowledge",
    "address",
    "brightness",
    "button",
    "button_down",
    "button_up",
    "connector",
    "dns",
    "gateway",
    HOURS,
    "keys",
    "margin",
    "mode",
    NIGHT,
    "presence",
    "proxy",
    "range",
    "report_to",
    "report_votes",
    "rotate",
    "timezone",
    "unit",
    "url",
    "vote_noise",
    "wifi",
    "wifi_country",
    PASSWORD,
];

/// The texts of both files.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Kept {
    /// Of `dreams.toml`.
    pub first: String,
    /// Of the file beside it.
    pub resolved: String,
}

impl Kept {
    /// What is kept of the owner's file `text`, which is right, and has no password any more. If it is no TOML it is kept
    /// as it is.
    pub fn of(text: &str) -> Self {
        let mut settings: Table = text.parse().unwrap_or_default();
        let first = if settings.iter().all(|(key, value)| is_first(key, value)) {
            text.to_owned()
        } else {
            settings.clone().into_iter().filter(|(key, value)| is_first(key, value)).collect::<Table>().to_string()
        };
        settings.remove(PASSWORD);
        let head = format!("{NUMBER} = {FORMAT}\n{OF} = \"{}\"\n", ObjectId::of(first.as_bytes()));
        Self { first, resolved: head + &settings.to_string() }
    }
}

/// Whether the systems before [`FORMAT`] 1 understand this setting.
fn is_first(key: &str, value: &Value) -> bool {
    let has = |is_known: fn(&str) -> bool| value.as_str().is_some_and(is_known);
    FIRST_KEYS.contains(&key)
        && match key {
            // Those know only hours that are the same on all days.
            HOURS => has(|hours| Window::parse(hours).is_some()),
            NIGHT => has(|night| FIRST_NIGHTS.contains(&night)),
            _ => true,
        }
}

/// The file beside the one at `first`.
pub fn resolved_path(first: &Path) -> PathBuf {
    let mut name = OsString::from(first);
    name.push(".kept");
    name.into()
}

/// Both files as they are now, for whoever waits for a change.
pub fn versions(first: &Path) -> [Option<FileVersion>; 2] {
    [FileVersion::of(first), FileVersion::of(&resolved_path(first))]
}

impl Owner {
    /// What `dreams-owner` has kept at `path`, as far as this version understands it: nothing, if it has kept nothing.
    pub fn kept(path: &Path) -> Self {
        let Ok(first) = text_of(path) else { return Self::default() };
        let second = text_of(&resolved_path(path)).map_or(Second::Apart, |text| Second::of(&text, &first));
        understood(match second {
            Second::Whole(settings) => settings,
            Second::OtherForm | Second::Apart => first.parse().unwrap_or_default(),
        })
    }

    /// The same for a program that runs, whose settings change: `None` while the files are no settings, cannot be read, or
    /// do not belong together, as between the writing of the first and of the second.
    pub fn kept_whole(path: &Path) -> Option<Self> {
        let Some(first) = text_if_any(path).ok()? else { return Some(Self::default()) };
        let alone: Table = first.parse().ok()?;
        let Some(second) = text_if_any(&resolved_path(path)).ok()? else { return Some(understood(alone)) };
        match Second::of(&second, &first) {
            Second::Whole(settings) => Some(understood(settings)),
            Second::OtherForm => Some(understood(alone)),
            Second::Apart => None,
        }
    }
}

/// The text of the file at `path`; `None` if there is no file.
fn text_if_any(path: &Path) -> Result<Option<String>, ConfigError> {
    match text_of(path) {
        Err(ConfigError::Read { source, .. }) if source.kind() == ErrorKind::NotFound => Ok(None),
        text => text.map(Some),
    }
}

/// The second file.
enum Second {
    /// It belongs to the first, and has these settings.
    Whole(Table),
    /// A version that writes another form has written it.
    OtherForm,
    /// It does not belong to the first, or is not whole.
    Apart,
}

impl Second {
    /// What `text` is beside the `first` file.
    fn of(text: &str, first: &str) -> Self {
        let read = || {
            let mut settings: Table = text.parse().ok()?;
            let number = settings.remove(NUMBER)?.as_integer()?;
            let is_of_first = settings.remove(OF)?.as_str()? == ObjectId::of(first.as_bytes()).to_string();
            Some((settings, number, is_of_first))
        };
        match read() {
            Some((_, number, _)) if number != FORMAT => Self::OtherForm,
            Some((settings, _, true)) => Self::Whole(settings),
            Some((_, _, false)) | None => Self::Apart,
        }
    }
}

/// What this version understands of `settings`.
fn understood(settings: Table) -> Owner {
    let each = settings.into_iter().filter_map(|(key, value)| understood_of(&key, value).map(|value| (key, value)));
    let mut settings: Table = each.collect();
    loop {
        let owner: Owner = settings.clone().try_into().expect("each of its settings was understood by itself");
        // What it was for may have been left out.
        let Some(alone) = owner.alone() else { return owner };
        settings.remove(alone.key);
    }
}

/// The `value` of `key`, or those parts of a list that are understood.
fn understood_of(key: &str, value: Value) -> Option<Value> {
    let is_understood = |value: &Value| Table::from_iter([(key.to_owned(), value.clone())]).try_into::<Owner>().is_ok();
    if is_understood(&value) {
        return Some(value);
    }
    let Value::Array(parts) = value else { return None };
    let parts: Vec<_> = parts.into_iter().filter(|part| is_understood(&vec![part.clone()].into())).collect();
    (!parts.is_empty()).then_some(parts.into())
}

#[cfg(test)]
mod tests {
    use super::{FIRST_KEYS, FORMAT, Kept, Owner, resolved_path};
    use std::fs;
    use std::path::{Path, PathBuf};

    const SAMPLE: &str = include_str!("../../../config/dreams.toml");
    const SET: &str = "unit = \"lobby\" # by the lift\nhours = '08:00-23:00'\nrotate = 90\n\
        address = \"192.0.2.7/24\"\ngateway = \"192.0.2.1\"\ndns = [\"192.0.2.53\"]\nproxy = \"http://192.0.2.9:3128\"\n\
        keys = [\"RWQy3+khO/aeoan0+vYoGE2vsmEBxY8VExI8+6bTi1Y6xEJXDYvODn+o\"]\nbutton = \"any\"\nreport_votes = false\n";

    fn strict(text: &str) -> Owner {
        Owner::parse(Path::new("dreams.toml"), text).unwrap()
    }

    /// A folder with these two files.
    fn laid(first: Option<&str>, resolved: Option<&str>) -> (tempfile::TempDir, PathBuf) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("dreams.toml");
        for (path, text) in [(path.clone(), first), (resolved_path(&path), resolved)] {
            if let Some(text) = text {
                fs::write(&path, text).unwrap();
            }
        }
        (folder, path)
    }

    fn read(first: Option<&str>, resolved: Option<&str>) -> Owner {
        let (_folder, path) = laid(first, resolved);
        Owner::kept(&path)
    }

    #[test]
    fn what_is_kept_is_read_as_it_was_set_by_this_version_and_by_those_before() {
        let Kept { first, resolved } = Kept::of(SET);
        assert_eq!(first, SET, "older systems find what they have always found");
        assert!(resolved.starts_with(&format!("format = {FORMAT}\n")) && !resolved.contains("lift"), "{resolved}");
        assert_eq!(read(Some(&first), Some(&resolved)), strict(SET));
        assert_eq!(read(Some(SET), None), strict(SET), "the form of the systems before");
        assert_eq!(read(None, None), Owner::default());
        assert_eq!(read(None, Some(&resolved)), Owner::default());
    }

    #[test]
    fn what_only_another_version_understands_is_left_out_by_itself_and_the_rest_stays() {
        let later = "colour = \"warm\"\nlevels = [1, { a = 2 }]\nscenes.evening.colour = 1\n";
        for text in [
            format!("{later}{SET}"),
            format!("{SET}{later}[picture]\ncolour = 1\n[picture.night]\nrotate = 7\n[[walls]]\nunit = \"attic\"\n"),
            format!(
                "{SET}night = \"dusk\"\nbrightness = {{ at = 7 }}\nmargin = \"wide\"\nwifi = 7\nurl = \"ipfs://a\"\n"
            ),
            format!("{SET}wifi_country = \"CH\"\nwifi_password = 7\nreport_to = []\nmode = 2026-07-01\n"),
        ] {
            assert_eq!(read(Some(&text), None), strict(SET), "{text}");
            let resolved = Kept::of(&text).resolved;
            assert_eq!(read(Some(&Kept::of(&text).first), Some(&resolved)), strict(SET), "{resolved}");
        }
        let key = "RWQy3+khO/aeoan0+vYoGE2vsmEBxY8VExI8+6bTi1Y6xEJXDYvODn+o";
        let lists = format!("keys = [\"ed448:7\", \"{key}\", 7]\ndns = [\"dns.example.org\", \"192.0.2.53\"]\n");
        assert_eq!(read(Some(&lists), None), strict(&format!("keys = [\"{key}\"]\ndns = [\"192.0.2.53\"]\n")));
        let lacking = "address = \"later\"\ngateway = \"192.0.2.1\"\nreport_votes = true\nunit = \"lobby\"\n";
        assert_eq!(read(Some(lacking), None), strict("unit = \"lobby\"\n"), "a gateway is for an address");
    }

    #[test]
    fn systems_before_find_only_keys_that_they_know() {
        let later = format!("colour = \"warm\"\n{SET}[picture]\nlevels = 7\n");
        let Kept { first, resolved } = Kept::of(&later);
        assert_eq!(strict(&first), strict(SET));
        assert!(resolved.contains("colour = \"warm\"") && resolved.contains("[picture]\nlevels = 7"), "{resolved}");
        let by_weekday = "rotate = 90\nhours = \"Tue-Sun 08:00-23:00\"\nclosed = [\"12-25\", 2026-12-24]\n";
        let Kept { first, resolved } = Kept::of(by_weekday);
        assert_eq!(strict(&first), strict("rotate = 90\n"));
        assert_eq!(read(Some(&first), Some(&resolved)), strict(by_weekday));
        for (night, is_old) in [("off", true), ("black", true), ("ddc", false), ("cec", false)] {
            let text = format!("rotate = 90\nnight = \"{night}\"\n");
            let Kept { first, resolved } = Kept::of(&text);
            assert_eq!(strict(&first), strict(if is_old { &text } else { "rotate = 90\n" }), "{night}");
            assert_eq!(read(Some(&first), Some(&resolved)), strict(&text));
        }
    }

    #[test]
    fn the_keys_of_the_systems_before_are_still_explained() {
        let explained: Vec<_> = SAMPLE.lines().filter_map(|line| line.strip_prefix("# ")?.split_once(" = ")).collect();
        let is_explained = |key: &str| explained.iter().any(|(explained, _)| *explained == key);
        assert!(FIRST_KEYS.iter().all(|key| is_explained(key)) && FIRST_KEYS.is_sorted());
    }

    #[test]
    fn the_file_beside_counts_only_with_the_text_that_it_was_made_of_and_in_a_form_that_is_known() {
        let old = Kept::of("unit = \"attic\"\n");
        let edited = "unit = \"lobby\"\nrotate = 90\n";
        assert_eq!(read(Some(edited), Some(&old.resolved)), strict(edited), "an older system has written since");
        let later = Kept::of(edited).resolved.replace("format = 1", "format = 2").replace("90", "180");
        assert_eq!(read(Some(edited), Some(&later)), strict(edited), "a newer form");
        for rubbish in ["", "format = 1\n", "unit = \"attic\"\n", "of = 7\nformat = 1\n", "of another version"] {
            assert_eq!(read(Some(edited), Some(rubbish)), strict(edited), "{rubbish}");
        }
        assert_eq!(read(Some("of another version"), Some(&old.resolved)), Owner::default());
    }

    #[test]
    fn a_running_program_takes_only_files_that_are_whole_and_belong_together() {
        let whole = |first: Option<&str>, resolved: Option<&str>| {
            let (_folder, path) = laid(first, resolved);
            Owner::kept_whole(&path)
        };
        let (old, new) = (Kept::of("unit = \"attic\"\nrotate = 180\n"), Kept::of(SET));
        assert_eq!(whole(Some(&new.first), Some(&new.resolved)), Some(strict(SET)));
        assert_eq!(whole(Some(&new.first), Some(&old.resolved)), None, "the second is still to be written");
        assert_eq!(whole(Some(&old.first), Some(&new.resolved)), None);
        for end in 1..new.first.len() {
            assert_eq!(whole(Some(&new.first[..end]), Some(&new.resolved)), None, "the first is cut off at {end}");
        }
        let head = new.resolved.match_indices('\n').nth(1).unwrap().0;
        for end in 0..head {
            assert_eq!(whole(Some(&new.first), Some(&new.resolved[..end])), None, "the second is cut off at {end}");
        }
        assert_eq!(whole(Some("no settings"), None), None);
        assert_eq!((whole(None, None), whole(Some(SET), None)), (Some(Owner::default()), Some(strict(SET))));
        let newer = new.resolved.replace("format = 1", "format = 2");
        assert_eq!(whole(Some(&new.first), Some(&newer)), Some(strict(SET)), "a newer form");
    }

    #[test]
    fn no_password_is_in_the_file_beside() {
        let kept = Kept::of("wifi = \"Home\"\nwifi_password = \"velvet under\"\n");
        assert!(kept.resolved.contains("wifi = \"Home\"") && !kept.resolved.contains("velvet"), "{}", kept.resolved);
    }
}
