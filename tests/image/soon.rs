//! How soon a picture is there.
//!
//! Owns the measurement of a start: the very kernel and initramfs of the image, once as it is and once with a first
//! program that does nothing, by turns, in the guest's own time; and what the time between the two goes to. Never claims
//! anything of a machine that does other things, too: `make bench what=boot` runs it.
//!
//! Start at [`a_picture_takes_half_as_long_again_as_doing_nothing`].

use crate::machine::Machine;
use crate::programs::{repository, succeed};
use crate::unit::{Unit, image};
use serde_json::{Value, json};
use std::env;
use std::fs;
use std::path::Path;
use std::process::Command;

/// How often each is started, unless `ROUNDS` says so.
const ROUNDS: usize = 5;
/// The most that a start may take, as a multiple of one that does nothing.
const AT_MOST: f64 = 1.5;
/// How `image-build/init` ends.
const SYSTEMD: &str = "exec switch_root /new /usr/lib/systemd/systemd\n";
/// How it ends where nothing is to be done: in the same root, by its smallest program.
const NOTHING: &str = r#"exec switch_root /new /bin/sh -c 'read up rest < /proc/uptime; echo "HERE $up" > /dev/ttyS0; read word < /dev/ttyS0'
"#;

/// What is timed on the way, in the order in which it begins: its name, and which of systemd's times begin and end it.
const CHAIN: [(&str, &str, &str); 5] = [
    ("kernel and initramfs", "", "UserspaceTimestampMonotonic"),
    ("systemd reads its units", "UserspaceTimestampMonotonic", "UnitsLoadFinishTimestampMonotonic"),
    (
        "the display's driver",
        "InactiveExitTimestampMonotonic dreams-display",
        "ActiveEnterTimestampMonotonic dreams-display",
    ),
    (
        "the disk of the flocks",
        "InactiveExitTimestampMonotonic dreams-data",
        "ActiveEnterTimestampMonotonic dreams-data",
    ),
    ("the player", "InactiveExitTimestampMonotonic dreams-player", "ActiveEnterTimestampMonotonic dreams-player"),
];

/// What UEFI starts, taken apart: QEMU's words for a start of it without a boot loader.
fn parts(folder: &Path) -> (Vec<String>, Vec<String>) {
    let part = |name: &str| {
        let file = folder.join(name);
        let section = format!("--only-section=.{name}");
        succeed(Command::new("objcopy").args(["-O", "binary", &section]).arg(image().join("dreams.efi")).arg(&file));
        file
    };
    let (kernel, initramfs, words) = (part("linux"), part("initrd"), part("cmdline"));
    let words = fs::read_to_string(words).unwrap().trim_end_matches(['\0', '\n']).to_owned();

    // The kernel unpacks one behind the other: what comes later takes the place of what was there.
    let init = fs::read_to_string(repository().join("image-build/init")).unwrap();
    assert!(init.ends_with(SYSTEMD), "`init` ends otherwise");
    fs::write(folder.join("init"), init.replace(SYSTEMD, NOTHING)).unwrap();
    succeed(Command::new("chmod").arg("755").arg(folder.join("init")));
    let nothing = folder.join("nothing");
    let pack =
        "cp initrd nothing && truncate -s %4 nothing && echo init | cpio --create --format=newc --quiet >> nothing";
    succeed(Command::new("sh").args(["-c", pack]).current_dir(folder));

    let start = |initramfs: &Path| {
        let [kernel, initramfs] = [&kernel, initramfs].map(|file| file.display().to_string());
        ["-kernel", &kernel, "-initrd", &initramfs, "-append", &words].map(str::to_owned).to_vec()
    };
    (start(&initramfs), start(&nothing))
}

/// Seconds from the kernel's start until the first program said so.
fn nothing(words: &[String]) -> f64 {
    let mut machine = Unit::new().start_with(words);
    machine.await_word("HERE ").parse().unwrap()
}

/// Seconds from the kernel's start to what systemd calls `time`.
fn seconds(machine: &mut Machine, time: &str) -> f64 {
    if time.is_empty() {
        return 0.0;
    }
    machine.run(&format!("systemctl show -P {time}")).trim().parse::<f64>().unwrap() / 1e6
}

/// The start of a unit until its first frame is lit: the time of that, and the times on the way.
fn lit(machine: &mut Machine) -> (f64, Value) {
    machine.await_word("BENCH");
    // It is ready with the first lit frame.
    machine.run("systemctl start dreams-player.service");
    let chain = CHAIN.map(|(name, from, to)| {
        json!({
            "what": name, "from_s": seconds(machine, from), "to_s": seconds(machine, to),
        })
    });
    (seconds(machine, "ActiveEnterTimestampMonotonic dreams-player"), json!(chain))
}

fn median(times: &[f64]) -> f64 {
    let mut times = times.to_vec();
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}

#[test]
fn a_picture_takes_half_as_long_again_as_doing_nothing() {
    let folder = tempfile::tempdir_in(repository().join("target/image")).unwrap();
    let (as_it_is, doing_nothing) = parts(folder.path());
    let [mut idle, mut first, mut later] = [const { Vec::new() }; 3];
    let (mut chains, mut analysis) = (Vec::new(), Value::Null);
    let rounds = env::var("ROUNDS").map_or(ROUNDS, |rounds| rounds.parse().unwrap());
    for round in 0..rounds {
        idle.push(nothing(&doing_nothing));
        let unit = Unit::new();
        let mut machine = unit.start_with(&as_it_is);
        let (time, chain) = lit(&mut machine);
        first.push(time);
        let first_chain = chain;
        // The next start is one of a unit that has played.
        machine.run("until [ \"$(systemctl show -P SubState dreams-good)\" = exited ]; do sleep 1; done");
        drop(machine);
        let mut machine = unit.start_with(&as_it_is);
        let (time, chain) = lit(&mut machine);
        later.push(time);
        chains.push(json!({ "first": first_chain, "later": chain }));
        println!(
            "round {round}: nothing {:.2} s, first {:.2} s, later {:.2} s",
            idle[round], first[round], later[round]
        );
        if round + 1 == rounds {
            machine.run("systemctl is-system-running --wait > /dev/null; true");
            let mut said = |words: &str| json!(machine.run(words).lines().collect::<Vec<_>>());
            analysis = json!({
                "time": said("systemd-analyze"),
                "blame": said("systemd-analyze blame | head -n 20"),
                "critical_chain": said("systemd-analyze critical-chain dreams-player.service"),
            });
        }
    }
    let [first_ratio, later_ratio] = [&first, &later].map(|times| median(times) / median(&idle));
    let answer = json!({
        "nothing_s": idle, "first_s": first, "later_s": later,
        "first_ratio": first_ratio, "later_ratio": later_ratio, "chains": chains, "systemd_analyze": analysis,
    });
    let report = serde_json::to_string_pretty(&answer).unwrap();
    fs::create_dir_all(repository().join("target/bench")).unwrap();
    fs::write(repository().join("target/bench/boot.json"), &report).unwrap();
    println!("{report}");
    assert!(
        first_ratio <= AT_MOST && later_ratio <= AT_MOST,
        "{first_ratio:.2} the first time, {later_ratio:.2} later"
    );
}
