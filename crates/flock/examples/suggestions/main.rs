//! Suggested transitions beside the rules of thumb: how far ten of each bring the worst ratio down.
//!
//! Owns the comparison: one JSON document on stdout, a table on stderr. Exits with 1 if on any flock a rule does better
//! than the suggestions. The flocks and the rules are made in `flocks.rs`.
#![allow(clippy::print_stdout, clippy::print_stderr, reason = "the figures are this program's answer")]

use std::num::NonZeroUsize;
use std::process::ExitCode;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread;

use flock::{Balance, Suggestions, Terms};
use flocks::{Chance, Pairs};

mod flocks;

/// How many flocks, and how many transitions are added to each.
const FLOCKS: u64 = 30;
const ADDED: usize = 10;
/// Of so many sets of random transitions the best counts.
const DRAWS: usize = 8;
/// Ratios that differ by less are the same: weights are rounded.
const SAME: f64 = 1e-3;

/// A rule of thumb: the next pair to link.
type Rule = fn(&Pairs, &[f64]) -> (usize, usize);
const RULES: [(&str, Rule); 4] = [
    ("pairing", flocks::pairing),
    ("loneliest", flocks::loneliest),
    ("degree", flocks::degree),
    ("most to least shown", flocks::shown),
];

/// One flock's worst ratios: as written, balanced, and balanced after each way of adding.
struct Row {
    flock: u64,
    none: f64,
    suggested: f64,
    rules: Vec<f64>,
}

fn main() -> ExitCode {
    let rows = rows();
    let held = rows.iter().filter(|row| row.rules.iter().all(|&rule| row.suggested <= rule + SAME)).count();
    tell(&rows, held);
    if held == rows.len() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// Every flock's row, worked out on all cores.
fn rows() -> Vec<Row> {
    let (next, rows) = (AtomicU64::new(0), Mutex::new(Vec::new()));
    let cores = thread::available_parallelism().map_or(1, NonZeroUsize::get);
    thread::scope(|scope| {
        for _ in 0..cores {
            scope.spawn(|| {
                while let Some(flock) = Some(next.fetch_add(1, Ordering::Relaxed)).filter(|&flock| flock < FLOCKS) {
                    let row = compared(flock);
                    rows.lock().expect("no thread panics").push(row);
                }
            });
        }
    });
    let mut rows = rows.into_inner().expect("no thread panics");
    rows.sort_by_key(|row| row.flock);
    rows
}

/// The worst ratio of `pairs` once balanced.
fn worst(pairs: &Pairs, wants: &[f64]) -> f64 {
    let flock = flocks::made(pairs, wants);
    let balance = Balance::of(&flock, Terms::default()).expect("the flock can be walked");
    balance.worst_ratio.expect("every sheep is shown")
}

fn compared(number: u64) -> Row {
    let (pairs, wants) = flocks::flock(number);
    let added = |choose: &mut dyn FnMut(&Pairs) -> (usize, usize)| {
        let mut pairs = pairs.clone();
        for _ in 0..ADDED {
            let pair = choose(&pairs);
            pairs.insert(pair);
        }
        worst(&pairs, &wants)
    };
    let mut rules: Vec<f64> = RULES.iter().map(|(_, rule)| added(&mut |pairs| rule(pairs, &wants))).collect();
    let mut chance = Chance::new(1000 + number);
    let draws = (0..DRAWS).map(|_| added(&mut |pairs| flocks::random(pairs, &mut chance)));
    rules.push(draws.fold(f64::INFINITY, f64::min));
    let flock = flocks::made(&pairs, &wants);
    let suggestions = Suggestions::of(&flock, Terms::default(), ADDED).expect("the flock can be walked");
    let number_of = |id: &flock::SheepId| id.as_str().parse::<usize>().expect("ids are numbers");
    let mut with = pairs.clone();
    with.extend(suggestions.add.iter().map(|new| (number_of(&new.from), number_of(&new.to))));
    Row { flock: number, none: worst(&pairs, &wants), suggested: worst(&with, &wants), rules }
}

fn tell(rows: &[Row], held: usize) {
    let names: Vec<&str> = RULES.iter().map(|(name, _)| *name).chain(["random"]).collect();
    eprint!("{:>6} {:>9} {:>10}", "flock", "balanced", "suggested");
    eprintln!(" {}", columns(names.iter().map(ToString::to_string)));
    let mut told = Vec::new();
    for row in rows {
        eprint!("{:>6} {:>9.3} {:>10.3}", row.flock, row.none, row.suggested);
        eprintln!(" {}", columns(row.rules.iter().map(|worst| format!("{worst:.3}"))));
        let rules: Vec<String> =
            names.iter().zip(&row.rules).map(|(name, worst)| format!(r#""{name}":{worst}"#)).collect();
        let (flock, none, suggested) = (row.flock, row.none, row.suggested);
        let rules = rules.join(",");
        told.push(format!(r#"{{"flock":{flock},"balanced":{none},"suggested":{suggested},{rules}}}"#));
    }
    eprintln!(
        "worst ratios with {ADDED} transitions more; suggestions are at least as good on {held} of {} flocks",
        rows.len()
    );
    let (sheep, transitions, rows) = (flocks::SHEEP, flocks::TRANSITIONS, told.join(",\n"));
    println!(
        r#"{{"bench":"suggestions","sheep":{sheep},"transitions":{transitions},"added":{ADDED},"held":{held},"flocks":[
{rows}]}}"#
    );
}

fn columns(cells: impl Iterator<Item = String>) -> String {
    cells.map(|cell| format!("{cell:>20}")).collect::<Vec<_>>().join(" ")
}
