//! The lives that are recorded: a unit that plays one flock is brought two more.
//!
//! Owns the editions, how each comes (by the real updater from a stick or over HTTP, or by one that is careless on
//! purpose) and how many cuts each life gets. Says what it found, a line for each life.
//!
//! Start at [`Lab::whole_lives`].

use crate::block_log::BlockLog;
use crate::careless::{Careless, Carelessness};
use crate::cuts::Cuts;
use crate::judge;
use crate::rig::{Disk, Recording};
use bundle::{CURRENT, Consent, Folder, LocalDisk, Playing, Source, Store, Trust, UnitId, Unverified};
use claims::press::{Files, Press, rubbish};
use claims::web::{Manners, Web};
use serde_json::Value;
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::{Mutex, MutexGuard};
use std::thread;
use tempfile::TempDir;

const UNIT: &str = "lobby";
const SETTINGS: &str = "update.toml";
/// Editions of the flock: the first one plays, the others come.
const EDITIONS: u64 = 3;
/// Clips of the flock. Of those of edition `n` the first `2 n` are its own.
const CLIPS: usize = 6;
const CLIP_BYTES: usize = 30_000;
/// A careless life gets so many cuts, and must be caught so often, at least.
const CARELESS_CUTS: usize = 400;
const CAUGHT: usize = 3;
/// Faults that are told of one life.
const TOLD: usize = 3;

/// One edition of the flock, on a stick and on a web server.
pub(crate) struct Edition {
    pub(crate) files: Files,
    stick: PathBuf,
    web: Web,
}

/// The laboratory.
pub(crate) struct Lab {
    updater: String,
    /// Shared by the whole lives.
    cuts: usize,
    press: Press,
    pub(crate) editions: Vec<Edition>,
    disks: [Disk; 2],
    /// The disk of a unit that plays the first edition.
    base: Vec<u8>,
    folder: TempDir,
    door: Mutex<()>,
}

/// How a flock comes.
#[derive(Clone, Copy, Debug)]
enum Way {
    Stick,
    Http,
}

impl Lab {
    /// `UPDATER CUTS`: the updater, and how many cuts its lives get.
    pub(crate) fn from(mut words: impl Iterator<Item = String>) -> Self {
        let mut word = |what| words.next().unwrap_or_else(|| panic!("{what} is missing: crash UPDATER CUTS"));
        let (updater, cuts) = (word("the updater"), word("the number of cuts").parse().unwrap());
        let (press, folder) = (Press::with_new_keys(), tempfile::tempdir().unwrap());
        let edition = |number: u64| {
            let stick = folder.path().join(number.to_string());
            let files = rubbish(CLIPS, CLIP_BYTES, 2 * number as usize);
            press.bundle(&stick, &files, &[], number);
            Edition { files, web: Web::serve(&stick, Manners::Good), stick }
        };
        // The disks here are smaller than what a unit keeps free.
        fs::write(folder.path().join(SETTINGS), "reserve_mib = 0\n").unwrap();
        let editions = (1..=EDITIONS).map(edition).collect();
        let disks = [Disk::new(0), Disk::new(1)];
        let mut lab = Self { updater, cuts, press, editions, disks, base: Vec::new(), folder, door: Mutex::new(()) };
        lab.base =
            lab.disks[0].made(|mounted| lab.brought(&mounted.join("store"), &lab.editions[0], Way::Stick, &mut || ()));
        lab
    }

    /// Whom its units trust.
    pub(crate) fn trust(&self) -> Trust {
        Trust::read(&self.press.keys()).unwrap()
    }

    /// Whether every cut through the lives of a unit leaves it a whole flock.
    pub(crate) fn whole_lives(&self) -> bool {
        let mut holds = true;
        let lives = [(Way::Stick, false), (Way::Stick, true), (Way::Http, false), (Way::Http, true)];
        let cuts = self.cuts.div_ceil(lives.len());
        for (way, is_noisy) in lives {
            let log = Recording::of(self.base.clone(), is_noisy, |mounted, report| {
                for edition in &self.editions[1..] {
                    self.brought(&mounted.join("store"), edition, way, report);
                }
            });
            let last = self.editions.last().expect("there are some").source(way);
            let faults = self.cut(&log, cuts, Some(&last));
            println!("{way:?}, {}: {}", if is_noisy { "noise" } else { "quiet" }, told(&log, cuts, &faults));
            holds &= faults.is_empty();
        }
        holds
    }

    /// Whether lives that forget something are caught.
    pub(crate) fn careless_lives(&self) -> bool {
        let mut proves = true;
        for carelessness in Carelessness::ALL {
            // Only a file that is not synced needs others that are to come to light.
            let is_noisy = carelessness == Carelessness::NoFileSync;
            let log = Recording::of(self.base.clone(), is_noisy, |mounted, report| {
                for edition in &self.editions[1..] {
                    self.brought_carelessly(&mounted.join("store"), edition, carelessness, report);
                }
            });
            let faults = self.cut(&log, CARELESS_CUTS, None);
            println!("{carelessness:?}, which must be caught: {}", told(&log, CARELESS_CUTS, &faults));
            proves &= faults.values().sum::<usize>() >= CAUGHT;
        }
        proves
    }

    /// Cuts through a life, on all disks at once. Returns what did not hold, and how often.
    fn cut(&self, log: &BlockLog, cuts: usize, completes: Option<&str>) -> BTreeMap<String, usize> {
        let (cuts, reports) = (cuts.div_ceil(self.disks.len()), log.marks());
        let judged = |(seed, device): (usize, &Disk)| {
            let (mut disk, mut faults) = (Vec::new(), Vec::new());
            let mut cuts = Cuts::of(log, &reports, cuts, seed as u64);
            while let Some(place) = cuts.next(&mut disk) {
                device.load(&disk);
                let told = reports.iter().filter(|report| **report < place).count();
                faults.extend(judge::after(self, device, told, completes).err());
            }
            faults
        };
        let mut faults = BTreeMap::new();
        thread::scope(|scope| {
            let at_work: Vec<_> = self.disks.iter().enumerate().map(|disk| scope.spawn(move || judged(disk))).collect();
            for fault in at_work.into_iter().flat_map(|worker| worker.join().unwrap()) {
                *faults.entry(fault).or_default() += 1;
            }
        });
        faults
    }

    /// Brings the edition by the updater, reports it, and has the player find that it plays.
    fn brought(&self, store: &Path, edition: &Edition, way: Way, report: &mut dyn FnMut()) {
        let answer = self.update(store, &edition.source(way)).unwrap();
        assert_eq!(answer["outcome"], "installed");
        report();
        let playing = Playing::of(&store.join(CURRENT)).unwrap().expect("a generation plays");
        playing.judge().unwrap().won(playing.number()).unwrap();
    }

    /// While the result lives, nobody else opens a store or starts a program: what is just being started has for a
    /// moment all open files of this process, and with them the lock of a store.
    pub(crate) fn alone(&self) -> MutexGuard<'_, ()> {
        self.door.lock().unwrap()
    }

    /// Runs the updater, which must succeed and leave nothing missing.
    pub(crate) fn update(&self, store: &Path, source: &str) -> Result<Value, String> {
        let mut command = Command::new(&self.updater);
        command.args(["--json", "--unit", UNIT, source]).arg("--store").arg(store).arg("--keys").arg(self.press.keys());
        command.arg("--config").arg(self.folder.path().join(SETTINGS));
        let alone = self.alone();
        let started = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn();
        drop(alone);
        let said = started.and_then(Child::wait_with_output);
        let said = said.unwrap_or_else(|error| panic!("cannot run {command:?}: {error}"));
        let answer: Value = serde_json::from_slice(&said.stdout).unwrap_or_default();
        if said.status.success() && answer["missing"] == 0 {
            Ok(answer)
        } else {
            Err(format!("the updater answers {answer}: {}", String::from_utf8_lossy(&said.stderr)))
        }
    }

    /// The same by the steps of the updater, on a store that forgets something.
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
        let unverified = Unverified::open(&mut source, &UnitId::new(UNIT).unwrap()).unwrap();
        let seal = unverified.verify(store.trust()).unwrap();
        store.admit(&seal, &UnitId::new(UNIT).unwrap(), Consent::Newer).unwrap();
        let bundle = seal.fetch(&mut source).unwrap();
        store.collect(Some(&bundle)).unwrap();
        for wanted in store.plan(&bundle).unwrap().wanted {
            let mut bytes = Vec::new();
            source.object(&wanted.id, wanted.size, 0).unwrap().read_to_end(&mut bytes).unwrap();
            let mut intake = store.intake(&wanted).unwrap();
            intake.take(&bytes).unwrap();
            intake.finish().unwrap();
        }
        store.install(&bundle).unwrap();
        report();
        store.won().unwrap();
    }
}

impl Edition {
    fn source(&self, way: Way) -> String {
        match way {
            Way::Stick => self.stick.to_str().expect("paths here are plain").to_owned(),
            Way::Http => self.web.url(),
        }
    }
}

/// What was found in a life, and the faults that came first.
fn told(log: &BlockLog, cuts: usize, faults: &BTreeMap<String, usize>) -> String {
    let (wrong, length) = (faults.values().sum::<usize>(), log.entries.len());
    let mut told = format!("{cuts} cuts at {length} writes and {} flushes, {wrong} wrong", log.flushes());
    for (fault, count) in faults.iter().take(TOLD) {
        write!(told, "\n  {count} times {fault}").expect("a text takes everything");
    }
    told
}

/// Somebody else on the same disk writes something, and syncs it.
fn noise(disk: &LocalDisk) {
    for _ in 0..5 {
        let mut file = bundle::Disk::append(disk, "noise").unwrap();
        file.write_all(b"noise").unwrap();
        file.sync().unwrap();
    }
}
