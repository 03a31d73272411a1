//! The programs that the claims try, and the running of commands.
//!
//! Owns where the built programs are, the check that they are newer than their sources, and the running of a command to
//! its end. A unit's programs are in `$DREAMS_PROGRAMS`: `make check-all` names those in the image for its slow part. Otherwise
//! they are those that cargo built here, in the profile of the claims. Never builds anything: a missing or outdated program fails the claim.
//!
//! Start at [`player`] and [`dreams`].

use crate::wait;
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::SystemTime;

/// `dreams-player`.
pub fn player() -> PathBuf {
    fresh(&units().join("dreams-player"))
}

/// `dreams-update`.
pub fn updater() -> PathBuf {
    fresh(&units().join("dreams-update"))
}

/// `dreams-owner`.
pub fn owner() -> PathBuf {
    fresh(&units().join("dreams-owner"))
}

/// `dreams-votes`.
pub fn votes() -> PathBuf {
    fresh(&units().join("dreams-votes"))
}

/// `dreams-mend`.
pub fn mender() -> PathBuf {
    fresh(&units().join("dreams-mend"))
}

/// `dreams-install`.
pub fn installer() -> PathBuf {
    fresh(&units().join("dreams-install"))
}

/// `dreams`, beside `dreams-video`.
pub fn dreams() -> PathBuf {
    fresh(&built().join("dreams-video"));
    fresh(&built().join("dreams"))
}

/// The crash laboratory, `crash`.
pub fn laboratory() -> PathBuf {
    fresh(&built().join("crash"))
}

/// The repository's folder.
pub fn repository() -> PathBuf {
    let tests = Path::new(env!("CARGO_MANIFEST_DIR"));
    tests.parent().expect("tests/ lies in the repository").to_owned()
}

/// The folder of built programs: this test binary lies in its `deps/`.
fn built() -> PathBuf {
    let me = std::env::current_exe().unwrap();
    me.parent().and_then(Path::parent).expect("a test binary lies in target/PROFILE/deps").to_owned()
}

/// The folder of a unit's programs.
pub fn units() -> PathBuf {
    std::env::var_os("DREAMS_PROGRAMS").map_or_else(built, PathBuf::from)
}

/// A folder for what claims make once and use again.
pub fn claims_folder() -> PathBuf {
    let folder = built().parent().expect("the profile lies in the target folder").join("claims");
    fs::create_dir_all(&folder).unwrap();
    folder
}

/// `program`, if it is newer than every source in its compiler's list of dependencies.
fn fresh(program: &Path) -> PathBuf {
    let remedy = "build it first, as `make check` does";
    let changed = |path: &Path| fs::metadata(path).and_then(|file| file.modified());
    let made: SystemTime =
        changed(program).unwrap_or_else(|_| panic!("`{}` is not built: {remedy}", program.display()));
    let list = fs::read_to_string(program.with_extension("d")).unwrap_or_default();
    // A space within a name is escaped there.
    let sources = list.split_once(": ").map_or("", |(_, sources)| sources).replace("\\ ", "\0");
    for source in sources.split_whitespace().map(|source| source.replace('\0', " ")) {
        let newer = changed(Path::new(&source)).is_ok_and(|time| time > made);
        assert!(!newer, "`{}` is older than `{source}`: {remedy}", program.display());
    }
    program.to_owned()
}

/// The longest time for a command, in seconds: the whole run of a guest, the making of an image.
const LONGEST_S: u32 = 1_800;

/// Runs `command` to its end, with an empty standard input; returns its output.
pub fn output(command: &mut Command) -> Output {
    output_to(Stdio::piped(), command)
}

/// The same, with its standard output going to `stdout`.
pub fn output_to(stdout: impl Into<Stdio>, command: &mut Command) -> Output {
    let child = command.stdin(Stdio::null()).stdout(stdout).stderr(Stdio::piped()).spawn();
    let child = child.unwrap_or_else(|error| panic!("cannot run {command:?}: {error}"));
    wait::output(&format!("{command:?}"), LONGEST_S, child)
}

/// Runs `command`, which must succeed; returns its standard output.
pub fn succeed(command: &mut Command) -> Vec<u8> {
    let said = output(command);
    assert!(said.status.success(), "{command:?} ended with {}: {}", said.status, String::from_utf8_lossy(&said.stderr));
    said.stdout
}

/// Writes a copy of `program` to `to`, executable.
///
/// Another process writes it. A file that this one writes is open for writing, until its `exec`, in each child that
/// another test forks meanwhile; no one can run it then ("Text file busy").
pub fn copy_program(program: &Path, to: &Path) {
    succeed(Command::new("install").args(["--mode", "755", "--"]).args([program, to]));
}

/// Writes `text` to `to` as an executable script; see [`copy_program`].
pub fn write_script(to: &Path, text: &str) {
    let source = tempfile::NamedTempFile::new().unwrap();
    fs::write(&source, text).unwrap();
    copy_program(source.path(), to);
}

/// The one JSON document on the standard output of `said`.
pub fn json(said: &Output) -> Value {
    let text = String::from_utf8_lossy(&said.stdout);
    serde_json::from_str(&text).unwrap_or_else(|error| panic!("standard output is no JSON: {error}: {text}"))
}
