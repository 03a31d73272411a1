//! The time from the start to the first picture.
//!
//! Owns the measurement: the image's kernel and initramfs, once as they are and once with a first program that does
//! nothing, in turns, in the guest's own time, on equal disks: out of the box, and of a unit that has played. And the
//! parts of the time between. Only meaningful on a quiet machine: `make bench what=boot` runs it.
//!
//! Start at [`a_picture_takes_half_as_long_again_as_doing_nothing`].

use crate::machine::Machine;
use crate::starts::first_start::PROVEN;
use crate::unit::Unit;
use crate::unit::direct_boot::parts;
use claims::programs::{repository, succeed};
use serde_json::{Value, json};
use std::env;
use std::fs;
use std::path::Path;
use std::process::Command;

/// The number of starts of each kind, unless `ROUNDS` sets it.
const ROUNDS: usize = 5;
/// The longest start, as a multiple of one that does nothing.
const AT_MOST: f64 = 1.5;
/// The end of `image-build/init`: what the picture needs, then systemd.
const ALL: &str = "\
chroot /new /usr/bin/nice -n -20 /usr/bin/dreams-early
exec switch_root /new /usr/lib/systemd/systemd
";
/// The end that does nothing: in the same root, with its smallest program.
const NOTHING: &str = r#"exec switch_root /new /bin/sh -c 'read up rest < /proc/uptime; echo "HERE $up" > /dev/ttyS0; read word < /dev/ttyS0'
"#;

/// Lines of `dreams-early` in the kernel's log.
const BEGUN: &str = "dreams: the picture is begun";
const LIT: &str = "dreams: the first picture is lit";

/// The parts that are timed, in the order of their beginning: name, beginning and end, as lines of `dreams-early` or
/// properties of systemd. The second to the fourth run in parallel, with systemd beside them.
const CHAIN: [(&str, &str, &str); 7] = [
    ("kernel and initramfs", "", BEGUN),
    ("the display's driver", BEGUN, "dreams: the display is there"),
    ("the disk of the flocks", BEGUN, "dreams: the flocks are there"),
    ("the first picture, these two included", BEGUN, LIT),
    ("systemd begins", "UserspaceTimestampMonotonic", "UnitsLoadStartTimestampMonotonic"),
    ("systemd reads its units", "UnitsLoadStartTimestampMonotonic", "UnitsLoadFinishTimestampMonotonic"),
    (
        "the player goes on from it",
        "InactiveExitTimestampMonotonic dreams-player",
        "ActiveEnterTimestampMonotonic dreams-player",
    ),
];

/// QEMU's options for a start without a boot loader: of the image as it is, and with a first program that does nothing.
fn starts(folder: &Path) -> (Vec<String>, Vec<String>) {
    let is = parts(folder);
    // The kernel unpacks concatenated archives in order: later files replace earlier ones.
    let init = fs::read_to_string(repository().join("image-build/init")).unwrap();
    assert!(init.ends_with(ALL), "`init` ends otherwise");
    fs::write(folder.join("init"), init.replace(ALL, NOTHING)).unwrap();
    succeed(Command::new("chmod").arg("755").arg(folder.join("init")));
    let pack =
        "cp initramfs nothing && truncate -s %4 nothing && echo init | cpio --create --format=newc --quiet >> nothing";
    succeed(Command::new("sh").args(["-c", pack]).current_dir(folder));
    let (initramfs, nothing) = (folder.join("initramfs"), folder.join("nothing"));
    let does_nothing =
        is.iter().map(|word| if Path::new(word) == initramfs { nothing.display().to_string() } else { word.clone() });
    let does_nothing = does_nothing.collect();
    (is, does_nothing)
}

/// Seconds from the kernel's start to the first program of `unit`.
fn nothing(unit: &Unit, words: &[String]) -> f64 {
    unit.start_with(words).await_word("HERE ").parse().unwrap()
}

/// Seconds from the kernel's start to `time`, named as in [`CHAIN`].
pub(crate) fn seconds(machine: &mut Machine, time: &str) -> f64 {
    if time.is_empty() {
        return 0.0;
    }
    if !time.starts_with("dreams: ") {
        return machine.run(&format!("systemctl show -P {time}")).trim().parse::<f64>().unwrap() / 1e6;
    }
    let told = machine.run(&format!(r"dmesg | sed -n 's/^\[ *\([0-9.]*\)\] {time}$/\1/p'"));
    told.trim().parse().unwrap_or_else(|_| panic!("`{time}` is told once, found `{told}`"))
}

/// A start until the first frame is shown: its time, and the times of the parts.
fn lit(machine: &mut Machine) -> (f64, Value) {
    machine.await_word("BENCH");
    // The player is up with its first frame, which the prelude has shown before.
    machine.run("systemctl start dreams-player.service");
    let chain = CHAIN.map(|(name, from, to)| {
        json!({
            "what": name, "from_s": seconds(machine, from), "to_s": seconds(machine, to),
        })
    });
    (seconds(machine, LIT), json!(chain))
}

fn median(times: &[f64]) -> f64 {
    let mut times = times.to_vec();
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}

/// Waits until systemd has nothing left to start: `systemd-analyze` refuses before.
const FINISHED: &str = "until [ \"$(systemctl show -P FinishTimestampMonotonic)\" != 0 ]; do sleep 1; done";

/// The results of one round.
struct Round {
    /// Of a unit out of its box: the start that does nothing, and the first frame.
    first: (f64, f64),
    /// The same of a unit that has played.
    later: (f64, f64),
    chains: Value,
    /// The output of `systemd-analyze` for the last start.
    analysis: Value,
}

impl Round {
    fn of(as_it_is: &[String], doing_nothing: &[String]) -> Self {
        let idle_first = nothing(&Unit::new(), doing_nothing);
        let unit = Unit::new();
        let mut machine = unit.start_with(as_it_is);
        let (first, first_chain) = lit(&mut machine);
        machine.run(PROVEN);
        drop(machine);
        let idle_later = nothing(&unit, doing_nothing);
        let mut machine = unit.start_with(as_it_is);
        let (later, later_chain) = lit(&mut machine);
        machine.run(FINISHED);
        let mut said = |words: &str| json!(machine.run(words).lines().collect::<Vec<_>>());
        let analysis = json!({
            "time": said("systemd-analyze"),
            "blame": said("systemd-analyze blame | head -n 20"),
            "critical_chain": said("systemd-analyze critical-chain dreams-player.service"),
        });
        let chains = json!({ "first": first_chain, "later": later_chain });
        Self { first: (idle_first, first), later: (idle_later, later), chains, analysis }
    }
}

#[test]
fn a_picture_takes_half_as_long_again_as_doing_nothing() {
    let folder = tempfile::tempdir_in(repository().join("target/image")).unwrap();
    let (as_it_is, doing_nothing) = starts(folder.path());
    let count = env::var("ROUNDS").map_or(ROUNDS, |rounds| rounds.parse().unwrap());
    let mut rounds = Vec::new();
    for number in 0..count {
        let round = Round::of(&as_it_is, &doing_nothing);
        let [first, later] = [round.first, round.later].map(|(idle, lit)| format!("{lit:.2} s beside {idle:.2} s"));
        println!("round {number}: the first time {first} of nothing, later {later}");
        rounds.push(round);
    }
    let ratio = |of: fn(&Round) -> (f64, f64)| {
        let (idle, lit): (Vec<_>, Vec<_>) = rounds.iter().map(of).unzip();
        median(&lit) / median(&idle)
    };
    let (first, later) = (ratio(|round| round.first), ratio(|round| round.later));
    let each = |of: fn(&Round) -> Value| rounds.iter().map(of).collect::<Vec<_>>();
    let answer = json!({
        "first_ratio": first, "later_ratio": later,
        "first_s": each(|round| json!({ "nothing": round.first.0, "lit": round.first.1 })),
        "later_s": each(|round| json!({ "nothing": round.later.0, "lit": round.later.1 })),
        "chains": each(|round| round.chains.clone()),
        "systemd_analyze": rounds.last().map(|round| &round.analysis),
    });
    let report = serde_json::to_string_pretty(&answer).unwrap();
    fs::create_dir_all(repository().join("target/bench")).unwrap();
    fs::write(repository().join("target/bench/boot.json"), &report).unwrap();
    println!("{report}");
    assert!(first <= AT_MOST && later <= AT_MOST, "{first:.2} the first time, {later:.2} later");
}
