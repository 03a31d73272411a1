//! Recorded scenarios: a unit with one edition of a flock gets two more, and is maintained in between.
//!
//! Owns the editions, the way of each (the real updater from a stick or over HTTP, or a faulty one that skips syncs)
//! and the number of cuts. Each scenario has a flock of another size, so that the writes differ. Prints a line for each
//! scenario.
//!
//! Start at [`Lab::whole_lives`].

use crate::careless::{Careless, Carelessness};
use crate::judge;
use crate::reports::{EDITS, Progress, Script, UPDATES, UPKEEP};
use crate::rig::{Disk, Recording, marks};
use crate::upkeep::Settings;
use bundle::{CURRENT, Consent, CurrentGeneration, Folder, LocalDisk, Source, Store, Trust, UnitId, UnverifiedSeal};
use claims::block_log::BlockLog;
use claims::bundle_maker::{BundleMaker, Files, rubbish};
use claims::cuts::Cuts;
use claims::wait;
use claims::web::{Behaviour, WebServer};
use serde_json::Value;
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::{Mutex, MutexGuard};
use std::thread;
use tempfile::TempDir;

pub(crate) const UNIT: &str = "lobby";
const SETTINGS: &str = "update.toml";
/// Editions of the flock: the first one is installed, the others come.
const EDITIONS: u64 = 3;
/// The number of clips and the bytes of each for the faulty updater.
const CARELESS: Form = (6, 30_000);
/// The least number of clips and bytes; and how many numbers of clips are used before the clips grow by a block.
const LEAST: Form = (4, 10_000);
const NUMBERS: usize = 7;
const BLOCK: usize = 4096;
/// The number of cuts at least that must reveal the faulty updater.
const CAUGHT: usize = 3;
/// Faults that are printed for one scenario.
const TOLD: usize = 3;

/// How many clips a flock has, and how many bytes each of them. Of those of edition `n` the first `2 n` are its own.
type Form = (usize, usize);

/// One edition of the flock, on a stick and on a web server.
pub(crate) struct Edition {
    pub(crate) files: Files,
    stick: PathBuf,
    web: WebServer,
}

/// The laboratory.
pub(crate) struct Lab {
    updater: String,
    pub(crate) owner: String,
    /// Different ones, in the whole lives.
    states: usize,
    pub(crate) maker: BundleMaker,
    pub(crate) editions: Vec<Edition>,
    /// The bundle with the statement that revokes a key.
    pub(crate) revoking: Edition,
    /// The owner's settings before the first edit and after each edit.
    pub(crate) settings: Vec<Settings>,
    disks: [Disk; 2],
    /// The disk of a unit with the first edition.
    base: Vec<u8>,
    pub(crate) folder: TempDir,
    /// Where the editions are.
    sticks: TempDir,
    door: Mutex<()>,
}

/// The result of one scenario.
struct Findings {
    /// The number of different disks that were checked.
    states: usize,
    /// What did not hold, and how often.
    faults: BTreeMap<String, usize>,
}

/// The way of a flock to the unit.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Way {
    Stick,
    Http,
}

impl Lab {
    /// `UPDATER OWNER STATES`: the two programs, and how many different disks are checked.
    pub(crate) fn from(mut words: impl Iterator<Item = String>) -> Self {
        let mut word = |what| words.next().unwrap_or_else(|| panic!("{what} is missing: crash UPDATER OWNER STATES"));
        let (updater, owner) = (word("the updater"), word("the owner's program"));
        let states = word("the number of states").parse().unwrap();
        let (maker, folder, sticks) =
            (BundleMaker::with_new_keys(), tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
        // The disks here are smaller than what a unit keeps free.
        fs::write(folder.path().join(SETTINGS), "reserve_mib = 0\n").unwrap();
        let disks = [Disk::new(0), Disk::new(1)];
        let door = Mutex::new(());
        let (editions, settings, base) = (Vec::new(), Vec::new(), Vec::new());
        let revoking = Edition::of(rubbish(LEAST.0, LEAST.1, 1), sticks.path().join("revoking"));
        let mut lab =
            Self { updater, owner, states, maker, editions, revoking, settings, disks, base, folder, sticks, door };
        lab.settings = lab.all_settings(UPKEEP.len());
        lab
    }

    /// Makes a new flock of this size, and a disk with its first edition.
    fn raise(&mut self, (clips, bytes): Form) {
        self.editions.clear();
        self.sticks = tempfile::tempdir().unwrap();
        let edition = |number: u64| {
            let stick = self.sticks.path().join(number.to_string());
            let files = rubbish(clips, bytes, 2 * number as usize);
            self.maker.bundle(&stick, &files, &[], number);
            Edition::of(files, stick)
        };
        self.editions = (1..=EDITIONS).map(edition).collect();
        self.maker.vouch(&self.editions[0].stick);
        let revoking = self.sticks.path().join("revoking");
        self.lay_revoking(&revoking, (clips, bytes));
        self.revoking = Edition::of(Files::new(), revoking);
        let bring = |mounted: &Path| {
            self.brought(&mounted.join("store"), &self.editions[0], Way::Stick, &mut || ());
            self.edited(mounted, 0);
        };
        self.base = self.disks[0].made(bring);
    }

    /// The keys that units trust.
    pub(crate) fn trust(&self) -> Trust {
        Trust::read(&self.maker.keys()).unwrap()
    }

    /// Whether every cut in every scenario leaves a whole flock.
    pub(crate) fn whole_lives(&mut self) -> bool {
        let mut holds = true;
        let ways = [(Way::Stick, false), (Way::Stick, true), (Way::Http, false), (Way::Http, true)];
        let scripts = [("updates", UPDATES), ("upkeep", UPKEEP)];
        let lives: Vec<_> = scripts.into_iter().flat_map(|script| ways.map(|way| (script, way))).collect();
        let mut forms = (0..).map(|life| (LEAST.0 + life % NUMBERS, LEAST.1 + life / NUMBERS * BLOCK));
        for ((name, script), (way, is_noisy)) in &lives {
            // One recording has only so many different states; another flock has others.
            let mut missing = self.states.div_ceil(lives.len());
            while missing > 0 {
                self.raise(forms.next().expect("there is no end of forms"));
                let live = |mounted: &Path, report: &mut dyn FnMut()| self.steps(script, mounted, *way, report);
                let log = Recording::of(self.base.clone(), *is_noisy, live);
                let found = self.cut(&log, script, missing, Some(*way));
                let noise = if *is_noisy { "noise" } else { "quiet" };
                println!("{name}, {way:?}, {noise}: {}", found.told(&log));
                holds &= found.faults.is_empty();
                missing = missing.saturating_sub(found.states);
            }
        }
        holds
    }

    /// Whether updates that skip syncs are detected.
    pub(crate) fn careless_lives(&mut self) -> bool {
        let mut proves = true;
        self.raise(CARELESS);
        for carelessness in Carelessness::ALL {
            // Only an unsynced file needs other writes to be noticed.
            let is_noisy = carelessness == Carelessness::NoFileSync;
            let log = Recording::of(self.base.clone(), is_noisy, |mounted, report| {
                for edition in &self.editions[1..] {
                    self.brought_carelessly(&mounted.join("store"), edition, carelessness, report);
                }
            });
            let found = self.cut(&log, UPDATES, careless_cuts(carelessness), None);
            println!("{carelessness:?}, which must be caught: {}", found.told(&log));
            proves &= found.faults.values().sum::<usize>() >= CAUGHT;
        }
        let log = Recording::of(self.base.clone(), false, |mounted, report| {
            for edit in 1..=EDITS.len() {
                self.edited_carelessly(mounted, edit);
                report();
            }
        });
        let found = self.cut(&log, EDITS, careless_cuts(Carelessness::WritesInPlace), None);
        println!("settings that are not synced, which must be caught: {}", found.told(&log));
        proves && found.faults.values().sum::<usize>() >= CAUGHT
    }

    /// Cuts a recording, and checks each different disk once, on all devices in parallel.
    fn cut(&self, log: &BlockLog, script: Script, cuts: usize, completes: Option<Way>) -> Findings {
        let reports = marks(log);
        assert_eq!(reports.len(), script.len(), "each step was reported");
        let cuts = Mutex::new(Cuts::of(log, &reports, cuts, 0));
        let judged = |device: &Disk| {
            let (mut disk, mut states, mut faults) = (Vec::new(), 0, Vec::new());
            let next = |disk: &mut Vec<u8>| cuts.lock().unwrap().next(&reports, disk);
            while let Some(told) = next(&mut disk) {
                device.load(&disk);
                states += 1;
                faults.extend(judge::after(self, device, Progress::far(script, told), completes).err());
            }
            (states, faults)
        };
        let mut found = Findings { states: 0, faults: BTreeMap::new() };
        thread::scope(|scope| {
            let at_work: Vec<_> = self.disks.iter().map(|disk| scope.spawn(|| judged(disk))).collect();
            for (states, faults) in at_work.into_iter().map(|worker| worker.join().unwrap()) {
                found.states += states;
                for fault in faults {
                    *found.faults.entry(fault).or_default() += 1;
                }
            }
        });
        found
    }

    /// Installs the edition with the updater, reports it, and marks it as played.
    pub(crate) fn brought(&self, store: &Path, edition: &Edition, way: Way, report: &mut dyn FnMut()) {
        let answer = self.update(store, &edition.source(way), &[]).unwrap();
        assert_eq!(answer["outcome"], "installed");
        report();
        let playing = CurrentGeneration::of(&store.join(CURRENT)).unwrap().expect("a generation plays");
        playing.recorder().unwrap().accept(playing.number()).unwrap();
    }

    /// While the guard lives, no other thread opens a store or starts a program: until its `exec`, a new process has
    /// all open files of this one, and with them the lock of a store.
    pub(crate) fn alone(&self) -> MutexGuard<'_, ()> {
        self.door.lock().unwrap()
    }

    /// Runs the updater, which must succeed and leave nothing missing.
    pub(crate) fn update(&self, store: &Path, source: &str, options: &[&str]) -> Result<Value, String> {
        let mut command = Command::new(&self.updater);
        command.args(["--json", "--unit", UNIT, source]).arg("--store").arg(store).arg("--keys").arg(self.maker.keys());
        command.args(options).arg("--config").arg(self.folder.path().join(SETTINGS));
        let alone = self.alone();
        let started = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn();
        drop(alone);
        let started = started.unwrap_or_else(|error| panic!("cannot run {command:?}: {error}"));
        let said = wait::output("dreams-update", 600, started);
        let answer: Value = serde_json::from_slice(&said.stdout).unwrap_or_default();
        if said.status.success() && answer["missing"] == 0 {
            Ok(answer)
        } else {
            Err(format!("the updater answers {answer}: {}", String::from_utf8_lossy(&said.stderr)))
        }
    }

    /// The same by the updater's own steps, on a store that skips something.
    fn brought_carelessly(
        &self,
        store: &Path,
        edition: &Edition,
        carelessness: Carelessness,
        report: &mut dyn FnMut(),
    ) {
        let careless = Careless { disk: LocalDisk::open(store).unwrap(), carelessness, meanwhile: noise };
        let mut store = Store::open(Box::new(careless), self.trust()).unwrap();
        let mut source = Folder::open(&edition.stick).unwrap();
        let unverified = UnverifiedSeal::open(&mut source, &UnitId::new(UNIT).unwrap()).unwrap();
        let seal = unverified.verify(store.trust()).unwrap();
        store.admit(&seal, &UnitId::new(UNIT).unwrap(), Consent::Newer).unwrap();
        let bundle = seal.fetch(&mut source).unwrap();
        store.collect(Some(&bundle)).unwrap();
        for wanted in store.plan(&bundle).unwrap().wanted {
            let mut bytes = Vec::new();
            source.object(&wanted.id, wanted.size, 0).unwrap().read_to_end(&mut bytes).unwrap();
            let mut intake = store.intake(&wanted).unwrap();
            intake.append(&bytes).unwrap();
            intake.finish().unwrap();
        }
        store.install(&bundle).unwrap();
        report();
        store.accept().unwrap();
    }
}

impl Edition {
    /// The files in the folder `stick`, served over HTTP from now on as well.
    fn of(files: Files, stick: PathBuf) -> Self {
        Self { files, web: WebServer::serve(&stick, Behaviour::Good), stick }
    }

    pub(crate) fn source(&self, way: Way) -> String {
        match way {
            Way::Stick => self.stick.to_str().expect("paths here are plain").to_owned(),
            Way::Http => self.web.url(),
        }
    }
}

/// The number of cuts for a faulty updater: some faults show seldom.
fn careless_cuts(carelessness: Carelessness) -> usize {
    match carelessness {
        Carelessness::NoFileSync => 100,
        Carelessness::NoFolderSync => 200,
        Carelessness::WritesInPlace | Carelessness::BadSectors => 400,
    }
}

impl Findings {
    /// As a line of text, with the first faults.
    fn told(&self, log: &BlockLog) -> String {
        let (wrong, writes, flushes) = (self.faults.values().sum::<usize>(), log.entries.len(), log.flushes());
        let mut told = format!("{} states, of {writes} writes and {flushes} flushes, {wrong} wrong", self.states);
        for (fault, count) in self.faults.iter().take(TOLD) {
            write!(told, "\n  {count} times {fault}").expect("a text takes everything");
        }
        told
    }
}

/// Another process writes to the same disk, and syncs.
fn noise(disk: &LocalDisk) {
    for _ in 0..5 {
        let mut file = durable::Storage::append(disk, "noise").unwrap();
        file.write_all(b"noise").unwrap();
        file.sync().unwrap();
    }
}
