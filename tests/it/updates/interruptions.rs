//! Failures in the middle of an update: of the process, the disk, the stick.
//!
//! Owns the claims that the unit keeps a whole flock, old or new, that it reports the failure in one sentence, and that
//! the next attempt completes the update. `strace` kills the real program at a system call, or makes the call fail, one
//! call after the other. What the order of calls guarantees after a power cut is tested in `crates/bundle`.
//!
//! Start at [`Breakage`].

use crate::syscall_faults;
use crate::updates::sticks::object;
use bundle::CurrentGeneration;
use claims::bundle_maker::{Files, rubbish};
use claims::programs::{json, output, succeed};
use claims::unit::Unit;
use std::fs;
use std::os::unix::fs::{PermissionsExt, symlink};
use std::path::Path;
use std::process::{Command, Output};

/// The system calls that change the disk.
const CHANGES: [&str; 7] = ["write", "fsync", "renameat", "linkat", "mkdirat", "unlinkat", "symlinkat"];
/// The exit code of a program whose libraries cannot be read.
const NOT_STARTED: i32 = 127;

/// A unit that plays `old`, and a stick with `new`, to be interrupted in many ways.
struct Breakage {
    unit: Unit,
    old: Files,
    new: Files,
}

impl Breakage {
    fn new() -> Self {
        let (unit, old, new) = (Unit::new(), rubbish(3, 9_000, 0), rubbish(3, 9_000, 2));
        unit.maker.bundle(&unit.stick(), &old, &[], 1);
        unit.updated(&[]);
        unit.maker.bundle(&unit.stick(), &new, &[], 2);
        fs::rename(unit.path("store"), unit.path("kept")).unwrap();
        Self { unit, old, new }
    }

    /// The unit as it was before the update.
    fn reset(&self) {
        fs::remove_dir_all(self.unit.path("store")).ok();
        fs::remove_file(self.unit.path("notice")).ok();
        succeed(Command::new("cp").arg("-a").arg(self.unit.path("kept")).arg(self.unit.path("store")));
    }

    fn update(&self) -> Command {
        self.unit.update_from(Some(&self.unit.stick()))
    }

    /// The update under `strace` with these options.
    fn strace(&self, options: &[&str]) -> Output {
        syscall_faults::traced(&self.update(), &self.unit.path("strace"), options)
    }

    /// The number of these calls in an update without failures.
    fn steps(&self, call: &str) -> usize {
        self.reset();
        let said = self.strace(&["-e", &format!("trace={call}")]);
        assert_eq!(said.status.code(), Some(0), "{}", String::from_utf8_lossy(&said.stderr));
        let log = fs::read_to_string(self.unit.path("strace")).unwrap();
        let thread = log.split_once(' ').expect("each line begins with a thread").0;
        let is_call = |line: &&str| line.starts_with(thread) && line.contains(&format!(" {call}("));
        log.lines().filter(is_call).count()
    }

    /// Fails the update at call number `step`, in this way.
    fn broken(&self, call: &str, how: &str, step: &str) -> Output {
        self.reset();
        self.broken_as_it_is(call, how, step)
    }

    /// The same, without a new unit.
    fn broken_as_it_is(&self, call: &str, how: &str, step: &str) -> Output {
        syscall_faults::broken(&self.update(), &self.unit.path("strace"), call, how, step)
    }

    /// Checks that a whole flock is installed, old or new, and that the next attempt completes the update.
    fn recovers(&self, case: &str) {
        let playing = self.unit.playing();
        assert!(playing.as_ref() == Some(&self.old) || playing.as_ref() == Some(&self.new), "{case}");
        let answer = self.unit.updated(&[]);
        assert_eq!(self.unit.playing().as_ref(), Some(&self.new), "{case}: {answer}");
        assert_eq!(self.unit.updated(&["--scrub"])["missing"], 0, "{case}: the store is whole");
    }
}

#[test]
fn an_updater_killed_at_every_step_leaves_a_whole_flock_and_the_next_one_goes_on() {
    let breakage = Breakage::new();
    let mut killed = 0;
    for call in CHANGES {
        for step in 1..=breakage.steps(call) {
            let case = format!("killed at {call} {step}");
            let said = breakage.broken(call, "signal=KILL", &step.to_string());
            assert_eq!(said.status.code(), None, "{case}");
            breakage.recovers(&case);
            killed += 1;
        }
    }
    assert!(killed > 50, "only {killed} steps were seen");
}

#[test]
fn a_disk_that_is_full_from_any_write_on_costs_nothing_but_the_update() {
    let breakage = Breakage::new();
    for call in ["write", "linkat", "mkdirat", "symlinkat"] {
        for step in 1..=breakage.steps(call) {
            let case = format!("full from {call} {step} on");
            let said = breakage.broken(call, "error=ENOSPC", &format!("{step}+"));
            let error = String::from_utf8_lossy(&said.stderr);
            assert!(matches!(said.status.code(), Some(0 | 3)), "{case}: {:?} {error}", said.status);
            breakage.recovers(&case);
        }
    }
}

#[test]
fn a_disk_that_fails_at_any_sync_costs_nothing_but_the_update() {
    let breakage = Breakage::new();
    for call in ["fsync", "renameat"] {
        for step in 1..=breakage.steps(call) {
            let case = format!("{call} {step} fails");
            let said = breakage.broken(call, "error=EIO", &step.to_string());
            assert!(matches!(said.status.code(), Some(0 | 3)), "{case}: {:?}", said.status);
            breakage.recovers(&case);
        }
    }
}

#[test]
fn a_stick_that_cannot_be_read_at_any_read_or_from_any_on_is_told_in_one_sentence_and_read_again() {
    let breakage = Breakage::new();
    let steps = breakage.steps("read");
    for step in 1..=steps {
        for (case, when) in [("fails once", step.to_string()), ("is gone", format!("{step}+"))] {
            let case = format!("{case} at read {step} of {steps}");
            let said = breakage.broken("read", "error=EIO", &when);
            let code = said.status.code();
            assert!(matches!(code, Some(0..=3 | NOT_STARTED)), "{case}: {:?}", said.status);
            let told = breakage.unit.notice();
            assert!(told.as_ref().is_none_or(|told| told.lines().count() == 1), "{case}: {told:?}");
            breakage.recovers(&case);
        }
    }
}

#[test]
fn what_was_fetched_again_is_put_back_also_if_the_updater_was_killed_before_it_could() {
    let (unit, files) = (Unit::new(), rubbish(3, 9_000, 0));
    unit.maker.bundle(&unit.stick(), &files, &[], 1);
    unit.updated(&[]);
    fs::rename(unit.path("store"), unit.path("kept")).unwrap();
    let breakage = Breakage { unit, old: files.clone(), new: files };
    let clip = "loops/0.mp4";
    for (call, how) in [("linkat", "signal=KILL"), ("linkat", "error=EIO"), ("renameat", "signal=KILL")] {
        breakage.reset();
        // As a scrub leaves a damaged object.
        for name in [format!("current/{clip}"), object(&breakage.old[clip])] {
            fs::remove_file(breakage.unit.path("store").join(name)).unwrap();
        }
        let said = breakage.broken_as_it_is(call, how, "1");
        assert!(!said.status.success(), "{call} {how}");
        assert_ne!(breakage.unit.playing().as_ref(), Some(&breakage.old), "{call} {how}");
        let answer = breakage.unit.updated(&[]);
        assert_eq!(breakage.unit.playing().as_ref(), Some(&breakage.old), "{call} {how}: {answer}");
    }
}

#[test]
fn a_look_at_a_disk_that_does_not_give_what_it_holds_takes_nothing_away() {
    let (unit, files) = (Unit::new(), rubbish(20, 9_000, 0));
    unit.maker.bundle(&unit.stick(), &files, &["lobby"], 5);
    unit.updated(&[]);
    CurrentGeneration::of(&unit.path("store/current")).unwrap().unwrap().recorder().unwrap().accept(1).unwrap();
    let objects: Vec<String> =
        files.values().map(|bytes| unit.path("store").join(object(bytes)).display().to_string()).collect();
    let look = |silent: &[String]| {
        let update = unit.update_from(None);
        let mut command = Command::new("strace");
        command.args(["-f", "-qq", "-e", "trace=read", "-e", "inject=read:error=EIO", "-o"]).arg(unit.path("strace"));
        command.args(silent.iter().flat_map(|path| ["-P", path]));
        output(command.arg(update.get_program()).args(update.get_args()).arg("--scrub"))
    };
    let said = look(&objects);
    let error = String::from_utf8_lossy(&said.stderr);
    assert!(said.status.code() == Some(3) && error.contains("cannot read 8 files of the store"), "{error}");
    assert_eq!(unit.playing().as_ref(), Some(&files));
    assert!(objects.iter().all(|path| Path::new(path).exists()), "what may be whole is left as it is");
    assert_eq!(unit.updated(&["--scrub"])["outcome"], "no-news");

    // A bad sector: its file stays too, and is fetched again unless the disk gives it after all.
    let said = look(&objects[..1]);
    let error = String::from_utf8_lossy(&said.stderr);
    assert!(said.status.code() == Some(0) && error.contains("cannot read a file, it stays"), "{error}");
    assert_eq!((json(&said)["missing"].as_u64(), unit.playing().as_ref()), (Some(1), Some(&files)));
    let answer = unit.updated(&[]);
    assert_eq!((answer["mended"].as_u64(), answer["fetched_bytes"].as_u64()), (Some(1), Some(0)), "{answer}");
    assert_eq!((unit.updated(&["--scrub"])["missing"].as_u64(), unit.playing()), (Some(0), Some(files)));
}

/// `command` run by a user who is bound by file modes, as on a unit.
fn unprivileged(command: &Command) -> Command {
    if !rustix::process::geteuid().is_root() {
        let mut same = Command::new(command.get_program());
        same.args(command.get_args());
        return same;
    }
    let mut unprivileged = Command::new("setpriv");
    unprivileged.arg("--bounding-set=-dac_override,-dac_read_search").arg(command.get_program());
    unprivileged.args(command.get_args());
    unprivileged
}

#[test]
fn what_was_frozen_when_the_power_failed_is_taken_as_it_is_or_begun_again() {
    let (unit, files) = (Unit::new(), rubbish(3, 9_000, 0));
    unit.maker.bundle(&unit.stick(), &files, &[], 1);
    let frozen = |clip: &str, bytes: &[u8]| {
        let part = unit.path("store/incoming").join(bundle::ObjectId::of(&files[clip]).to_string());
        fs::create_dir_all(part.parent().unwrap()).unwrap();
        fs::write(&part, bytes).unwrap();
        fs::set_permissions(&part, fs::Permissions::from_mode(0o444)).unwrap();
        let written = output(&mut unprivileged(Command::new("cp").arg("/dev/null").arg(&part)));
        assert!(!written.status.success(), "`{clip}` can be written to");
    };
    frozen("loops/0.mp4", &files["loops/0.mp4"]);
    frozen("loops/1.mp4", &[7; 9_000]);
    frozen("loops/2.mp4", &files["loops/2.mp4"][..4_000]);
    let said = output(&mut unprivileged(&unit.update_from(Some(&unit.stick()))));
    assert_eq!(said.status.code(), Some(0), "{}", String::from_utf8_lossy(&said.stderr));
    let toml = files["flock.toml"].len();
    assert_eq!(json(&said)["fetched_bytes"], 2 * 9_000 + toml, "what was whole is not read again");
    assert_eq!(unit.playing(), Some(files));
}

#[test]
fn a_stick_for_others_whose_list_cannot_be_read_is_told_so_and_is_not_taken_for_an_empty_one() {
    let breakage = Breakage::new();
    let stick = breakage.unit.stick();
    fs::rename(stick.join("seals/all.seal"), stick.join("seals/attic.seal")).unwrap();
    let seals = stick.join("seals").display().to_string();
    let look = |more: &[&str]| {
        breakage.reset();
        let said = breakage.strace(&[&["-P", &*seals, "-e", "trace=getdents64"], more].concat());
        (said.status.code(), breakage.unit.notice().unwrap_or_default())
    };
    assert_eq!(look(&[]), (Some(1), "This stick is for attic. This frame is lobby.".to_owned()));
    let again = "The stick could not be read to its end. Put it in again, and the rest follows.";
    assert_eq!(look(&["-e", "inject=getdents64:error=EIO"]), (Some(3), again.to_owned()));
}

#[test]
fn a_stick_of_ten_thousand_strange_files_leads_nowhere() {
    let unit = Unit::new();
    let (stick, secret) = (unit.stick(), unit.path("secret"));
    fs::write(&secret, "the host's own").unwrap();
    for at in 0..10_000 {
        fs::write(stick.join(format!("{at}\u{301} \n'$(reboot)'.mp4")), "").unwrap();
    }
    fs::create_dir_all(stick.join("seals")).unwrap();
    for at in 0..200 {
        fs::write(stick.join(format!("seals/attic{at:03}.seal")), "rubbish").unwrap();
    }
    let said = unit.update(&[]);
    let error = String::from_utf8_lossy(&said.stderr);
    assert_eq!(said.status.code(), Some(1), "{error}");
    assert_eq!(
        unit.notice().as_deref(),
        Some("This stick is for attic000, attic001, attic002 and 197 more. This frame is lobby.")
    );
    assert!(error.len() < 600, "it names a few of them: {error}");
    // Links out of the stick, in place of everything that is read.
    let good = rubbish(2, 3_000, 0);
    let clip = object(&good["loops/1.mp4"]);
    let ways = [("seals/all.seal", "secret"), ("seals", ""), (&*clip, "secret"), ("objects", "store")];
    for (way, target) in ways {
        fs::remove_dir_all(&stick).unwrap();
        unit.maker.bundle(&stick, &good, &[], 1);
        link(&stick.join(way), &unit.path(target));
        let said = unit.update(&[]);
        assert_eq!(said.status.code(), Some(3), "{way}: {}", String::from_utf8_lossy(&said.stderr));
        assert_eq!(unit.playing(), None, "{way}");
    }
    assert_eq!(fs::read_to_string(&secret).unwrap(), "the host's own");
}

/// Replaces the file at `path` by a symbolic link.
fn link(path: &Path, target: &Path) {
    if path.is_dir() {
        fs::remove_dir_all(path).unwrap();
    } else {
        fs::remove_file(path).unwrap();
    }
    symlink(target, path).unwrap();
}
