//! Nothing unsigned is accepted, whatever is on a stick or a server, and a unit keeps its flock.
//!
//! Owns the claim on thousands of mutants, each of which is given to the real `dreams verify` and to a unit with a good
//! flock, on a stick, and in part over HTTP. `MUTANTS` in the environment sets their number, and `MUTANT` chooses one.
//! `tests/rig/mutator` makes them.
//!
//! Start at [`Worker::judge`].

use crate::metering::{Measurement, Meter, PEAK_KIB};
use claims::bundle_maker::files_in;
use claims::mutator::{Detection, Good, Level, Mutant, Mutator};
use claims::programs::{self, repository};
use claims::web::{Behaviour, WebServer};
use serde_json::Value;
use std::collections::BTreeMap;
use std::env;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread;
use tempfile::TempDir;

/// The number of mutants, unless `MUTANTS` sets another.
const MUTANTS: u64 = 300;
/// The most processor time of a program for one mutant, in seconds.
const CPU_S: f64 = 10.0;
/// One in so many mutants is served over HTTP as well.
const BY_HTTP: u64 = 4;
/// The least percentage of mutants that are refused; the others lead to what was signed.
const REFUSED: usize = 75;
/// Workers at once. Most of the time one waits for the disk, or for a server's next answer.
const WORKERS: usize = 4;

/// Gives mutants to `dreams verify` and to a unit.
struct Worker<'m> {
    mutator: &'m Mutator,
    scratch: TempDir,
    web: WebServer,
    meter: Meter,
}

/// The result of a program.
struct ProgramRun {
    code: i64,
    answer: Value,
    error: String,
    peak_kib: u64,
    cpu_s: f64,
}

/// The results of many mutants.
#[derive(Debug, Default)]
struct Tally {
    refused: usize,
    /// Those that led to what was signed, and nothing else.
    harmless: usize,
    faults: Vec<String>,
    peak_kib: u64,
    cpu_s: f64,
    all_cpu_s: f64,
    /// By level, how many were refused, and how many were harmless.
    levels: BTreeMap<Level, (usize, usize)>,
}

impl<'m> Worker<'m> {
    /// A worker whose unit has the installed flock and the learned keys.
    fn new(mutator: &'m Mutator) -> Self {
        let scratch = tempfile::tempdir_in(programs::claims_folder()).unwrap();
        let at = |name: &str| scratch.path().join(name);
        for folder in ["keys", "stick", "web"] {
            fs::create_dir(at(folder)).unwrap();
        }
        for (name, text) in mutator.trusted() {
            fs::write(at("keys").join(name), text).unwrap();
        }
        fs::write(at("os-release"), "ID=dreams\nVERSION_ID=0.1.0\n").unwrap();
        let os = at("os-release");
        fs::write(at("update.toml"), format!("system = \"{}\"\nowner = \"/nowhere\"\nreserve_mib = 0\n", os.display()))
            .unwrap();
        let web = WebServer::serve(&at("web"), Behaviour::Good);
        let mut worker = Self { mutator, scratch, web, meter: Meter::new() };
        mutator.played().stick.lay(&worker.at("stick"));
        let ran = worker.update(&worker.at("stick"));
        assert_eq!((ran.code, &ran.answer["outcome"]), (0, &"installed".into()), "{}", ran.error);
        let playing = bundle::CurrentGeneration::of(&worker.at("store/current")).unwrap().unwrap();
        playing.recorder().unwrap().accept(playing.number()).unwrap();
        fs::rename(worker.at("store"), worker.at("kept")).unwrap();
        worker
    }

    fn at(&self, name: &str) -> PathBuf {
        self.scratch.path().join(name)
    }

    /// Runs a program to its end.
    fn run(&mut self, words: &[&str]) -> ProgramRun {
        let Measurement { code, stdout, stderr: error, peak_kib, cpu_s } = self.meter.run(words);
        ProgramRun { code, answer: serde_json::from_str(&stdout).unwrap_or_default(), error, peak_kib, cpu_s }
    }

    fn verify(&mut self) -> ProgramRun {
        let [stick, keys] = [self.at("stick"), self.at("keys")].map(|path| text(&path));
        let dreams = text(&programs::dreams());
        self.run(&[&dreams, "verify", &stick, "--trust", &keys, "--unit", "lobby", "--json"])
    }

    fn unit(&mut self, words: &[&str]) -> ProgramRun {
        let [config, store, keys] = ["update.toml", "store", "keys"].map(|name| text(&self.at(name)));
        let updater = text(&programs::updater());
        let always = ["--json", "--unit", "lobby", "--config", &config, "--store", &store, "--keys", &keys];
        self.run(&[&[&*updater], &always[..], words].concat())
    }

    fn update(&mut self, from: &Path) -> ProgramRun {
        self.unit(&[&text(from)])
    }

    /// Resets the unit to its state before any mutant.
    fn reset(&self) {
        fs::remove_dir_all(self.at("store")).ok();
        let copied = Command::new("cp").arg("-a").arg(self.at("kept")).arg(self.at("store")).status().unwrap();
        assert!(copied.success());
    }

    /// Gives `mutant` to all programs that may read it.
    fn judge(&mut self, mutant: &Mutant, tally: &mut Tally) {
        let good = self.mutator.good(mutant);
        mutant.stick.lay(&self.at("stick"));
        let mut is_refused = true;
        if mutant.detection != Detection::ByUnits {
            let ran = self.verify();
            is_refused = ran.code != 0;
            let found = is_as_documented(&ran, &[0, 1, 2, 3]).and_then(|()| verified(&ran, mutant, good));
            tally.note(mutant, "dreams verify", &ran, found.err());
        }
        let mut sources = vec![self.at("stick")];
        if mutant.seed.is_multiple_of(BY_HTTP) && mutant.stick.is_plain() {
            mutant.stick.lay(&self.at("web"));
            sources.push(PathBuf::from(self.web.url()));
        }
        for source in sources {
            self.reset();
            let ran = self.update(&source);
            let found = is_as_documented(&ran, &[0, 1, 3]).and_then(|()| self.kept(&ran, mutant, good));
            is_refused &= found.as_ref().is_ok_and(|is_refused| *is_refused);
            let found = found.err().or_else(|| self.started(tally, mutant, good).err());
            let found = found.or_else(|| self.takes_the_next(good).err());
            tally.note(mutant, &text(&source), &ran, found);
        }
        let (refused, harmless) = tally.levels.entry(mutant.level).or_default();
        *if is_refused { refused } else { harmless } += 1;
        *if is_refused { &mut tally.refused } else { &mut tally.harmless } += 1;
    }

    /// Whether the unit has refused the mutant; fails unless it has the old flock, or exactly what was signed.
    fn kept(&self, ran: &ProgramRun, mutant: &Mutant, good: &Good) -> Result<bool, String> {
        let playing = files_in(&self.at("store/current")).map_err(|error| format!("nothing plays: {error}"))?;
        let staged = fs::read(self.at("store/system/staged")).unwrap_or_default();
        let is_old = playing == self.mutator.played().files;
        if !is_old && playing != good.files {
            return Err(format!("it plays neither flock, but {:?}", playing.keys()));
        }
        if !is_old && mutant.detection == Detection::ByAll && !is_of_the_system(mutant) {
            return Err(format!("it was taken in: {}", ran.answer));
        }
        let says = ran.answer["outcome"].as_str();
        if is_old && says == Some("installed") || !is_old && says.is_some_and(|says| says != "installed") {
            return Err(format!("it says {}, and plays the old flock: {is_old}", ran.answer));
        }
        let is_good = staged == good.stick.bytes("systems/all.seal");
        if !staged.is_empty() && !is_good && mutant.detection != Detection::ByUnits {
            return Err(format!("a system was taken in: {}", ran.answer));
        }
        Ok(if is_of_the_system(mutant) { staged.is_empty() || !is_good } else { is_old })
    }

    /// Checks that no system but the good one gets an entry of the boot loader.
    fn started(&mut self, tally: &mut Tally, mutant: &Mutant, good: &Good) -> Result<(), String> {
        let Ok(staged) = fs::read(self.at("store/system/staged")) else { return Ok(()) };
        fs::remove_dir_all(self.at("boot")).ok();
        fs::create_dir(self.at("boot")).unwrap();
        let [slot, boot] = [self.at("slot"), self.at("boot")].map(|path| text(&path));
        let ran = self.unit(&["--slot", &slot, "--boot", &boot]);
        tally.note(mutant, "--slot", &ran, is_as_documented(&ran, &[0, 1, 3]).err());
        let entries = fs::read_dir(self.at("boot/loader/entries")).unwrap().map(|entry| entry.unwrap().file_name());
        let begun: Vec<_> = entries.filter(|name| name.to_string_lossy().ends_with(".conf")).collect();
        let is_good = staged == good.stick.bytes("systems/all.seal");
        if is_good == (ran.code == 0 && begun.len() == 1) {
            return Ok(());
        }
        Err(format!("after {} the boot loader would start {begun:?}, and the system is good: {is_good}", ran.code))
    }

    /// Checks that the unit accepts the good stick afterwards, or plays what is on it: nothing is left of the mutant.
    fn takes_the_next(&mut self, good: &Good) -> Result<(), String> {
        // The artist's seal of another bundle may have brought the same flock with the same number.
        let is_there = files_in(&self.at("store/current")).is_ok_and(|playing| playing == good.files);
        good.stick.lay(&self.at("stick"));
        let ran = self.update(&self.at("stick"));
        let playing = files_in(&self.at("store/current")).map_err(|error| format!("nothing plays: {error}"))?;
        if (ran.code == 0 || is_there && ran.code == 1) && playing == good.files {
            return Ok(());
        }
        Err(format!("the good stick behind it is not taken: {} {}", ran.answer, ran.error))
    }
}

/// Whether only the system can be wrong.
fn is_of_the_system(mutant: &Mutant) -> bool {
    mutant.level == Level::Starts || mutant.what.starts_with("the system's seal")
}

fn text(path: &Path) -> String {
    path.to_str().expect("paths here are plain").to_owned()
}

/// Checks that a program ended with a documented code, and within its limits.
fn is_as_documented(ran: &ProgramRun, codes: &[i64]) -> Result<(), String> {
    let ProgramRun { code, error, peak_kib, cpu_s, .. } = ran;
    if !codes.contains(code) || error.contains("panicked") {
        return Err(format!("it ended with {code}: {error}"));
    }
    if *peak_kib > PEAK_KIB || *cpu_s > CPU_S {
        return Err(format!("it took {peak_kib} KiB and {cpu_s:.1} CPU-s: {error}"));
    }
    Ok(())
}

fn is_seal_of_system(path: &str) -> bool {
    path.starts_with("systems/") && Path::new(path).extension().is_some_and(|suffix| suffix == "seal")
}

/// Checks that `dreams verify` accepts only what was signed.
fn verified(ran: &ProgramRun, mutant: &Mutant, good: &Good) -> Result<(), String> {
    // What the good bundle and the good system have, beside statements, must all be there; of a stick without seals of
    // flocks only the system, which is all that the answer lists then, and of one without seals of systems only the flock.
    let of_system = good.release();
    let names_system = mutant.stick.0.keys().any(|path: &String| is_seal_of_system(path));
    let is_listed = |path: &str| {
        let id = path.trim_start_matches("objects/").replace('/', "");
        let is_of_system = path.starts_with("systems/") || of_system.contains(&id);
        if is_of_system { names_system } else { ran.answer["bundles"] != Value::Array(vec![]) }
    };
    let signed = good.stick.0.iter().filter(|(path, _)| path.as_str() != "statements" && is_listed(path));
    let mut other = signed.filter(|(path, item)| mutant.stick.0.get(*path) != Some(item)).map(|(path, _)| path);
    match (ran.code, other.next()) {
        (0, _) if mutant.detection == Detection::ByAll => Err(format!("it was taken for good: {}", ran.answer)),
        (0, Some(path)) => Err(format!("it was taken for good, though `{path}` is another: {}", ran.answer)),
        _ => Ok(()),
    }
}

impl Tally {
    fn note(&mut self, mutant: &Mutant, whom: &str, ran: &ProgramRun, fault: Option<String>) {
        self.peak_kib = self.peak_kib.max(ran.peak_kib);
        self.cpu_s = self.cpu_s.max(ran.cpu_s);
        self.all_cpu_s += ran.cpu_s;
        let Mutant { seed, level, what, .. } = mutant;
        self.faults.extend(fault.map(|fault| format!("MUTANT={seed} ({level:?}; {what}) before {whom}: {fault}")));
    }

    fn with(mut self, other: Self) -> Self {
        self.refused += other.refused;
        self.harmless += other.harmless;
        self.faults.extend(other.faults);
        self.peak_kib = self.peak_kib.max(other.peak_kib);
        self.cpu_s = self.cpu_s.max(other.cpu_s);
        self.all_cpu_s += other.all_cpu_s;
        for (level, (refused, harmless)) in other.levels {
            let here = self.levels.entry(level).or_default();
            *here = (here.0 + refused, here.1 + harmless);
        }
        self
    }
}

/// A number from the environment.
fn number(name: &str) -> Option<u64> {
    env::var(name).ok().map(|number| number.parse().unwrap_or_else(|_| panic!("{name}: `{number}` is no number")))
}

#[test]
fn no_mutant_is_accepted_or_costs_much_or_leaves_a_unit_without_its_flock() {
    let mutator = Mutator::new(&repository().join("tests/fixtures"));
    let (first, last) = match (number("MUTANT"), number("MUTANTS")) {
        (Some(single), _) => (single, single + 1),
        (None, count) => (0, count.unwrap_or(MUTANTS)),
    };
    let next = AtomicU64::new(first);
    let work = || {
        let (mut worker, mut tally) = (Worker::new(&mutator), Tally::default());
        loop {
            let seed = next.fetch_add(1, Ordering::Relaxed);
            if seed >= last {
                return tally;
            }
            let mutant = mutator.mutant(seed);
            worker.judge(&mutant, &mut tally);
            if last == first + 1 {
                println!("{:?} of {:?}: {}", mutant.detection, mutant.level, mutant.what);
            }
        }
    };
    let workers = WORKERS.min((last - first) as usize);
    let tally = thread::scope(|scope| {
        let workers: Vec<_> = (0..workers).map(|_| scope.spawn(work)).collect();
        workers.into_iter().map(|worker| worker.join().unwrap()).fold(Tally::default(), Tally::with)
    });
    let Tally { refused, harmless, faults, peak_kib, cpu_s, all_cpu_s, levels } = tally;
    println!("{refused} mutants refused, {harmless} came to what was signed: {levels:?}");
    println!("at most {peak_kib} KiB and {cpu_s:.2} CPU-s for one, {all_cpu_s:.1} CPU-s for all");
    for fault in &faults {
        println!("{fault}");
    }
    assert!(faults.is_empty(), "{} faults", faults.len());
    assert!(last == first + 1 || refused * 100 >= REFUSED * (refused + harmless), "{refused} were refused");
}

#[test]
fn what_mutants_are_made_of_is_good() {
    let mutator = Mutator::new(&repository().join("tests/fixtures"));
    let mut worker = Worker::new(&mutator);
    for good in mutator.goods() {
        good.stick.lay(&worker.at("stick"));
        let ran = worker.verify();
        assert_eq!(ran.code, 0, "{} {}", ran.answer, ran.error);
        worker.reset();
        assert_eq!(worker.takes_the_next(good), Ok(()));
        assert_eq!(worker.at("store/system/staged").exists(), !good.release().is_empty());
    }
    let again = Mutator::new(&repository().join("tests/fixtures"));
    // All that are tried, so that hours of trying do not end at one that cannot be made.
    for seed in 0..number("MUTANTS").unwrap_or(MUTANTS) {
        let [one, two] = [&mutator, &again].map(|mutator| mutator.mutant(seed));
        assert_eq!((one.what, one.level), (two.what, two.level), "mutant {seed} is the same each time");
    }
}
