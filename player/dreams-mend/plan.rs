//! What is to be done with the entries on the two boot partitions.
//!
//! Owns the decisions, as functions of what lies there. New systems are written to the first partition, once, and there
//! the boot loader counts the tries of one on trial; of every other system there are two copies on each partition. Never
//! touches a file.
//!
//! Start at [`entries`].

use bundle::{COPIES, StartFile, Version};
use player::Rollback;
use std::collections::BTreeSet;
use std::fmt;

/// What every entry's name begins and ends with.
const OURS: &str = "dreams_";
const ENDING: &str = ".conf";
/// The tries that a good system always has left: one, so that a copy that does not come up is left at the next start.
const ARMED: &str = "1";

/// An entry of ours on a boot partition.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Entry {
    pub(crate) place: Place,
    /// What it starts says of itself, if all of it is whole.
    pub(crate) file: Option<StartFile>,
}

/// Where an entry lies.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Place {
    /// On which boot partition: 0, or 1 for the spare one.
    pub(crate) boot: usize,
    pub(crate) name: EntryName,
}

/// The name of an entry: `dreams_VERSION_COPY+LEFT-DONE.conf`.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct EntryName {
    pub(crate) version: Version,
    pub(crate) copy: u8,
    /// LEFT-DONE, or LEFT, or nothing: how often the boot loader may start it, and has.
    count: String,
}

/// One thing to do.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Step {
    /// Make `to` what `from` is. It was damaged there, or it is new there.
    Copy { to: Place, from: Place, was_damaged: bool },
    /// Take this entry away. It is damaged and there is no other, or there is no root for it.
    Remove { place: Place, was_damaged: bool },
    /// Give this entry the name `to`.
    Rename { place: Place, to: EntryName },
}

impl EntryName {
    /// `None` if it is none of ours.
    pub(crate) fn parse(text: &str) -> Option<Self> {
        let stem = text.strip_prefix(OURS)?.strip_suffix(ENDING)?;
        let (stem, count) = stem.split_once('+').unwrap_or((stem, ""));
        let (version, copy) = stem.split_once('_')?;
        let copy = copy.parse().ok().filter(|copy| (1..=COPIES).contains(copy))?;
        Some(Self { version: Version::parse(version).ok()?, copy, count: count.to_owned() })
    }

    /// Whether the system has not proved itself yet.
    fn is_on_trial(&self) -> bool {
        let left = self.count.split('-').next().unwrap_or_default();
        !matches!(left, "" | "0") && self.count != ARMED
    }

    /// How often the boot loader has started it in vain, if it has no tries left.
    fn vain(&self) -> Option<u32> {
        let (left, done) = self.count.split_once('-').unwrap_or((&self.count, "0"));
        done.parse().ok().filter(|_| left == "0")
    }

    /// The same entry for another copy.
    fn of_copy(&self, copy: u8) -> Self {
        Self { copy, ..self.clone() }
    }
}

impl fmt::Display for EntryName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { version, copy, count } = self;
        let plus = if count.is_empty() { "" } else { "+" };
        write!(f, "{OURS}{version}_{copy}{plus}{count}{ENDING}")
    }
}

impl Entry {
    fn is_whole(&self) -> bool {
        self.file.is_some()
    }

    fn name(&self) -> &EntryName {
        &self.place.name
    }

    fn is_of(&self, version: &Version) -> bool {
        self.name().version == *version
    }
}

/// What is damaged is mended or taken away; of what is not on trial on the first of `boots` partitions there are all
/// copies on each, with the same tries in their names.
pub(crate) fn entries(entries: &[Entry], boots: usize) -> Vec<Step> {
    let mut steps: Vec<_> =
        entries.iter().filter(|entry| !entry.is_whole()).map(|entry| mended(entry, entries)).collect();
    let mut seen = BTreeSet::new();
    for entry in entries.iter().filter(|entry| entry.place.boot == 0 && !entry.name().is_on_trial()) {
        let of_it = || entries.iter().filter(|other| other.is_of(&entry.name().version));
        let Some(source) = of_it().find(|other| other.is_whole()) else { continue };
        if !seen.insert(&entry.name().version) {
            continue;
        }
        for (boot, copy) in (0..boots).flat_map(|boot| (1..=COPIES).map(move |copy| (boot, copy))) {
            let to = entry.name().of_copy(copy);
            match of_it().find(|other| (other.place.boot, other.name().copy) == (boot, copy)) {
                None => steps.push(copied(source, Place { boot, name: to }, false)),
                Some(there) if there.place.name != to => steps.push(Step::Rename { place: there.place.clone(), to }),
                Some(_) => {}
            }
        }
    }
    steps
}

/// The newest system above the `running` one that has had its chance, and why it does not run: no entry of it is whole and
/// has a try left. The `running` one has shown its hundred frames.
pub(crate) fn left(entries: &[Entry], running: &Version) -> Option<Rollback> {
    let newest = entries.iter().map(|entry| &entry.name().version).max().filter(|version| *version > running)?;
    let of_it = || entries.iter().filter(|entry| entry.is_of(newest));
    if of_it().any(|entry| entry.is_whole() && entry.name().vain().is_none()) {
        return None;
    }
    let reason = match of_it().filter(|entry| entry.is_whole()).find_map(|entry| entry.name().vain()) {
        None => Why::Damaged,
        // `init` writes this where it gives way to the other system.
        Some(0 | 1) => Why::GaveWay,
        Some(starts) => Why::Starts(starts),
    };
    Some(Rollback { from: newest.to_string(), why: why(newest, reason) })
}

/// Why a system was left.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Why {
    /// No copy of the files that start it is whole.
    Damaged,
    /// `init` found no sound root for it, or has started it five times.
    GaveWay,
    /// The boot loader has started it so often.
    Starts(u32),
}

/// The same in a sentence.
pub(crate) fn why(version: &Version, why: Why) -> String {
    match why {
        Why::Damaged => format!("The files that start system {version} are damaged."),
        Why::GaveWay => format!("System {version} failed to start, or to show a hundred frames in 5 starts."),
        Why::Starts(starts) => format!("System {version} did not show a hundred frames in {starts} starts."),
    }
}

/// Entries for whose system there is no whole root, of which `kept` are the versions, go.
pub(crate) fn without_roots(entries: &[Entry], kept: &BTreeSet<Version>) -> Vec<Step> {
    let lost = entries.iter().filter(|entry| !kept.contains(&entry.name().version));
    lost.map(|entry| Step::Remove { place: entry.place.clone(), was_damaged: false }).collect()
}

/// What only the spare partition has, and has a root, is on the first one again.
pub(crate) fn shared(entries: &[Entry]) -> Vec<Step> {
    let has = |version: &Version| entries.iter().any(|entry| entry.place.boot == 0 && entry.is_of(version));
    let lost = entries.iter().filter(|entry| entry.is_whole() && !has(&entry.name().version));
    lost.map(|entry| copied(entry, Place { boot: 0, name: entry.place.name.clone() }, true)).collect()
}

fn mended(entry: &Entry, entries: &[Entry]) -> Step {
    match entries.iter().find(|other| other.is_whole() && other.is_of(&entry.name().version)) {
        Some(source) => copied(source, entry.place.clone(), true),
        None => Step::Remove { place: entry.place.clone(), was_damaged: true },
    }
}

fn copied(source: &Entry, to: Place, was_damaged: bool) -> Step {
    Step::Copy { to, from: source.place.clone(), was_damaged }
}

#[cfg(test)]
mod tests {
    use super::{Entry, EntryName, Place, Step, entries, left, shared, without_roots};
    use bundle::{StartFile, Version};
    use std::collections::BTreeSet;

    fn place(boot: usize, name: &str) -> Place {
        Place { boot, name: EntryName::parse(name).unwrap() }
    }

    fn entry(boot: usize, name: &str, is_whole: bool) -> Entry {
        let place = place(boot, name);
        let version = place.name.version.clone();
        let words = String::new;
        let file = StartFile { version, slot: words(), blocks: 0, salt: words(), hash: words() };
        Entry { place, file: is_whole.then_some(file) }
    }

    /// Both copies on both partitions.
    fn everywhere(version: &str) -> Vec<Entry> {
        let name = |copy| format!("dreams_{version}_{copy}+1.conf");
        [(0, 1), (0, 2), (1, 1), (1, 2)].map(|(boot, copy)| entry(boot, &name(copy), true)).into()
    }

    fn copied(to: (usize, &str), from: (usize, &str), was_damaged: bool) -> Step {
        Step::Copy { to: place(to.0, to.1), from: place(from.0, from.1), was_damaged }
    }

    fn removed(boot: usize, name: &str, was_damaged: bool) -> Step {
        Step::Remove { place: place(boot, name), was_damaged }
    }

    #[test]
    fn a_name_says_its_version_and_its_copy_and_whether_it_is_on_trial() {
        for (name, version, copy, is_on_trial) in [
            ("dreams_0.1.0_1.conf", "0.1.0", 1, false),
            ("dreams_0.1.0_2+1.conf", "0.1.0", 2, false),
            ("dreams_0.2.0_1+3.conf", "0.2.0", 1, true),
            ("dreams_0.2.0_1+2-1.conf", "0.2.0", 1, true),
            ("dreams_0.2.0_1+1-2.conf", "0.2.0", 1, true),
            ("dreams_0.2.0_1+0-3.conf", "0.2.0", 1, false),
        ] {
            let found = EntryName::parse(name).unwrap();
            assert_eq!((found.version.to_string().as_str(), found.copy), (version, copy), "{name}");
            assert_eq!((found.is_on_trial(), found.to_string().as_str()), (is_on_trial, name));
        }
        for name in ["dreams_0.2.0_1.new", "dreams_next_1.conf", "dreams_0.2.0.conf", "dreams_1_3.conf", "dreams_.conf"]
        {
            assert_eq!(EntryName::parse(name), None, "{name}");
        }
    }

    #[test]
    fn what_is_damaged_is_mended_from_any_other_copy_or_goes() {
        let whole = everywhere("1");
        assert_eq!(entries(&whole, 2), []);
        for (at, from) in [(0, (0, "dreams_1_2+1.conf")), (2, (0, "dreams_1_1+1.conf"))] {
            let mut there = whole.clone();
            there[at].file = None;
            let to = &whole[at].place;
            let name = to.name.to_string();
            assert_eq!(entries(&there, 2), [copied((to.boot, &name), from, true)]);
        }
        let trial = entry(0, "dreams_2_1+2-1.conf", false);
        assert_eq!(entries(&[&whole[..], &[trial]].concat(), 2), [removed(0, "dreams_2_1+2-1.conf", true)]);
        let mut lost = whole;
        for entry in &mut lost {
            entry.file = None;
        }
        assert_eq!(entries(&lost, 2).len(), 4);
        assert!(entries(&lost, 2).iter().all(|step| matches!(step, Step::Remove { was_damaged: true, .. })));
    }

    #[test]
    fn of_what_is_not_on_trial_there_are_all_copies_on_each_partition_with_the_same_tries() {
        let new = (0, "dreams_2_1+1.conf");
        let proved = [everywhere("1"), vec![entry(new.0, new.1, true)]].concat();
        let more = [(0, "dreams_2_2+1.conf"), (1, "dreams_2_1+1.conf"), (1, "dreams_2_2+1.conf")];
        assert_eq!(entries(&proved, 2), more.map(|to| copied(to, new, false)));
        assert_eq!(entries(&proved[4..], 1), [copied(more[0], new, false)], "there is no spare one");
        assert_eq!(entries(&[entry(0, "dreams_2_1+3.conf", true)], 2), [], "it is on trial");
        let mut gave_way = everywhere("1");
        gave_way[0] = entry(0, "dreams_1_1+0-1.conf", true);
        let renamed =
            |boot, name: &str, to: &str| Step::Rename { place: place(boot, name), to: EntryName::parse(to).unwrap() };
        let [one, two] = ["dreams_1_1+0-1.conf", "dreams_1_2+0-1.conf"];
        let all = [renamed(0, "dreams_1_2+1.conf", two), renamed(1, "dreams_1_1+1.conf", one), {
            renamed(1, "dreams_1_2+1.conf", two)
        }];
        assert_eq!(entries(&gave_way, 2), all);
    }

    #[test]
    fn a_newer_system_was_left_if_nothing_of_it_is_whole_and_has_a_try_left() {
        let running = Version::parse("1").unwrap();
        let why = |new: &[(&str, bool)]| {
            let new = new.iter().map(|(name, is_whole)| entry(0, name, *is_whole));
            let there: Vec<_> = everywhere("1").into_iter().chain(new).collect();
            left(&there, &running).map(|left| format!("{}: {}", left.from, left.why))
        };
        let is = |said: &str| Some(said.to_owned());
        assert_eq!(why(&[("dreams_2_1+0-3.conf", true)]), is("2: System 2 did not show a hundred frames in 3 starts."));
        let gave_way = is("2: System 2 failed to start, or to show a hundred frames in 5 starts.");
        assert_eq!(why(&[("dreams_2_1+0-1.conf", true), ("dreams_2_2+0-1.conf", true)]), gave_way);
        assert_eq!(why(&[("dreams_2_1+2-1.conf", false)]), is("2: The files that start system 2 are damaged."));
        for there in [
            &[][..],
            &[("dreams_2_1+3.conf", true)],
            &[("dreams_2_1+1-2.conf", true)],
            &[("dreams_2_1+0-1.conf", true), ("dreams_2_2+1.conf", true)],
            &[("dreams_0.9_1+0-3.conf", true)],
        ] {
            assert_eq!(why(there), None, "{there:?}");
        }
    }

    #[test]
    fn entries_live_as_long_as_their_root_does() {
        let [one, two] = ["dreams_1_1+1.conf", "dreams_2_1+1.conf"];
        let there = [entry(0, two, true), entry(1, one, true), entry(1, two, true)];
        let kept: BTreeSet<_> = ["2"].map(|version| Version::parse(version).unwrap()).into();
        assert_eq!(without_roots(&there, &kept), [removed(1, one, false)]);
        assert_eq!(shared(&there), [copied((0, one), (1, one), true)]);
    }
}
