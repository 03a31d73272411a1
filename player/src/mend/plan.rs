//! What is to be done with the start files of the two boot partitions.
//!
//! Owns the decisions, as functions of what lies there. New systems are written to the first partition, and there the boot
//! loader counts the tries of one on trial; the spare one holds a copy of what is not on trial. Never touches a file.
//!
//! Start at [`entries`].

use bundle::{StartFile, Version};
use std::collections::BTreeSet;

/// What every start file's name begins and ends with.
const OURS: &str = "dreams_";
const ENDING: &str = ".efi";

/// A file that the boot loader takes for one of ours.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Entry {
    /// On which boot partition it lies: 0, or 1 for the spare one.
    pub(crate) boot: usize,
    pub(crate) name: EntryName,
    /// What it says of itself, if it is whole.
    pub(crate) file: Option<StartFile>,
}

/// The name of such a file: `dreams_VERSION.efi`, or `dreams_VERSION+LEFT-DONE.efi` while its tries are counted.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct EntryName {
    pub(crate) text: String,
    pub(crate) version: Version,
    /// Whether it may be started no more often than that: it is on trial.
    is_on_trial: bool,
}

/// One thing to do.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Step {
    /// Make the start file `name` on `boot` what `from_name` on `from` is. It was damaged there, or it is new there.
    Copy { boot: usize, name: String, from: usize, from_name: String, was_damaged: bool },
    /// Take the start file `name` away from `boot`. It is damaged and there is no other, or there is no root for it.
    Remove { boot: usize, name: String, was_damaged: bool },
    /// Call it `to`.
    Rename { boot: usize, name: String, to: String },
}

impl EntryName {
    /// `None` if it is none of ours.
    pub(crate) fn parse(text: &str) -> Option<Self> {
        let stem = text.strip_prefix(OURS)?.strip_suffix(ENDING)?;
        let (version, count) = stem.split_once('+').map_or((stem, None), |(version, count)| (version, Some(count)));
        let is_on_trial = count.is_some_and(|count| count != "0" && !count.starts_with("0-"));
        Some(Self { text: text.to_owned(), version: Version::parse(version).ok()?, is_on_trial })
    }
}

impl Entry {
    fn is_whole(&self) -> bool {
        self.file.is_some()
    }
}

/// What is damaged is mended or taken away; what is not on trial on the first partition is on the spare one, too, where
/// there is one, under the same name.
pub(crate) fn entries(entries: &[Entry], has_spare: bool) -> Vec<Step> {
    let mut steps: Vec<_> =
        entries.iter().filter(|entry| !entry.is_whole()).map(|entry| mended(entry, entries)).collect();
    let good = entries.iter().filter(|entry| entry.boot == 0 && !entry.name.is_on_trial && has_spare);
    for entry in good {
        let of_it = || entries.iter().filter(|other| other.name.version == entry.name.version);
        let Some(source) = of_it().find(|other| other.is_whole()) else { continue };
        let to = &entry.name.text;
        match of_it().find(|other| other.boot == 1) {
            None => steps.push(copy(source, 1, to, false)),
            Some(there) if there.name != entry.name => {
                steps.push(Step::Rename { boot: 1, name: there.name.text.clone(), to: to.clone() });
            }
            Some(_) => {}
        }
    }
    steps
}

/// Start files for whose system there is no whole root, of which `kept` are the versions, go.
pub(crate) fn without_roots(entries: &[Entry], kept: &BTreeSet<Version>) -> Vec<Step> {
    let lost = entries.iter().filter(|entry| !kept.contains(&entry.name.version));
    lost.map(|entry| Step::Remove { boot: entry.boot, name: entry.name.text.clone(), was_damaged: false }).collect()
}

/// What only the spare partition has, and has a root, is on the first one again.
pub(crate) fn shared(entries: &[Entry]) -> Vec<Step> {
    let has = |version: &Version| entries.iter().any(|entry| entry.boot == 0 && entry.name.version == *version);
    let lost = entries.iter().filter(|entry| entry.is_whole() && !has(&entry.name.version));
    lost.map(|entry| copy(entry, 0, &entry.name.text, true)).collect()
}

fn mended(entry: &Entry, entries: &[Entry]) -> Step {
    let same = entries.iter().find(|other| other.is_whole() && other.name.version == entry.name.version);
    match same {
        Some(source) => copy(source, entry.boot, &entry.name.text, true),
        None => Step::Remove { boot: entry.boot, name: entry.name.text.clone(), was_damaged: true },
    }
}

fn copy(source: &Entry, boot: usize, name: &str, was_damaged: bool) -> Step {
    let (from, from_name) = (source.boot, source.name.text.clone());
    Step::Copy { boot, name: name.to_owned(), from, from_name, was_damaged }
}

#[cfg(test)]
mod tests {
    use super::{Entry, EntryName, Step, entries, shared, without_roots};
    use bundle::{StartFile, Version};
    use std::collections::BTreeSet;

    fn entry(boot: usize, name: &str, is_whole: bool) -> Entry {
        let name = EntryName::parse(name).unwrap();
        let version = name.version.clone();
        let words = || String::new();
        let file = StartFile { version, slot: words(), blocks: 0, salt: words(), hash: words() };
        Entry { boot, name, file: is_whole.then_some(file) }
    }

    fn copied(boot: usize, name: &str, from: usize, from_name: &str, was_damaged: bool) -> Step {
        let (name, from_name) = (name.to_owned(), from_name.to_owned());
        Step::Copy { boot, name, from, from_name, was_damaged }
    }

    fn removed(boot: usize, name: &str, was_damaged: bool) -> Step {
        Step::Remove { boot, name: name.to_owned(), was_damaged }
    }

    #[test]
    fn a_name_says_its_version_and_whether_it_is_on_trial() {
        for (name, version, is_on_trial) in [
            ("dreams_0.1.0.efi", "0.1.0", false),
            ("dreams_0.2.0+3.efi", "0.2.0", true),
            ("dreams_0.2.0+2-1.efi", "0.2.0", true),
            ("dreams_0.2.0+0-3.efi", "0.2.0", false),
        ] {
            let found = EntryName::parse(name).unwrap();
            assert_eq!((found.version.to_string().as_str(), found.is_on_trial), (version, is_on_trial), "{name}");
        }
        for name in ["dreams_0.2.0.new", "dreams_next.efi", "linux.efi", "dreams_.efi"] {
            assert_eq!(EntryName::parse(name), None, "{name}");
        }
    }

    #[test]
    fn what_is_damaged_is_mended_from_the_other_partition_or_goes() {
        let (old, new) = ("dreams_1.efi", "dreams_2+2-1.efi");
        let whole = [entry(0, old, true), entry(0, new, true), entry(1, old, true)];
        assert_eq!(entries(&whole, true), []);
        let first = [entry(0, old, false), entry(0, new, true), entry(1, old, true)];
        assert_eq!(entries(&first, true), [copied(0, old, 1, old, true)]);
        let spare = [entry(0, old, true), entry(0, new, true), entry(1, old, false)];
        assert_eq!(entries(&spare, true), [copied(1, old, 0, old, true)]);
        let trial = [entry(0, old, true), entry(0, new, false), entry(1, old, true)];
        assert_eq!(entries(&trial, true), [removed(0, new, true)]);
        let both = [entry(0, old, false), entry(1, old, false)];
        assert_eq!(entries(&both, true), [removed(0, old, true), removed(1, old, true)]);
    }

    #[test]
    fn what_is_not_on_trial_is_on_the_spare_partition_under_the_same_name() {
        let proved = [entry(0, "dreams_1.efi", true), entry(0, "dreams_2.efi", true), entry(1, "dreams_1.efi", true)];
        assert_eq!(entries(&proved, true), [copied(1, "dreams_2.efi", 0, "dreams_2.efi", false)]);
        assert_eq!(entries(&proved[..2], false), [], "there is no spare one");
        let gave_way = [entry(0, "dreams_2+0-1.efi", true), entry(1, "dreams_2.efi", true)];
        let renamed = Step::Rename { boot: 1, name: "dreams_2.efi".to_owned(), to: "dreams_2+0-1.efi".to_owned() };
        assert_eq!(entries(&gave_way, true), [renamed]);
    }

    #[test]
    fn start_files_live_as_long_as_their_root_does() {
        let there = [entry(0, "dreams_2.efi", true), entry(1, "dreams_1.efi", true), entry(1, "dreams_2.efi", true)];
        let kept: BTreeSet<_> = ["2"].map(|version| Version::parse(version).unwrap()).into();
        assert_eq!(without_roots(&there, &kept), [removed(1, "dreams_1.efi", false)]);
        assert_eq!(shared(&there), [copied(0, "dreams_1.efi", 1, "dreams_1.efi", true)]);
    }
}
