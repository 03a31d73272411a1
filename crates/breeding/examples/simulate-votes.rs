//! Rules of breeding beside each other, in worlds whose voters have a hidden taste.
//!
//!     simulate-votes [--json]
//!
//! Prints for every rule and number of showings the mean percentile of the pool among random sheep after 10, 20 and 40
//! broods, that of the worst of 16 worlds at 20, and diversity, founding families and the living at 40.
#![allow(clippy::print_stdout, reason = "the table is what it is for")]

#[path = "../tests/it/simulation/mod.rs"]
mod simulation;

use simulation::{Outcome, Rules, Trial};

const WORLDS: u64 = 16;
const SHOWINGS: [u64; 3] = [30, 10, 5];

fn main() {
    let trials = SHOWINGS.into_iter().flat_map(|showings| Rules::ALL.map(|rules| Trial { rules, showings }));
    let outcomes: Vec<(Trial, Outcome)> = trials.map(|trial| (trial, trial.run(WORLDS))).collect();
    if std::env::args().any(|word| word == "--json") {
        println!("{}", json(&outcomes));
    } else {
        print!("{}", table(&outcomes));
    }
}

fn json(outcomes: &[(Trial, Outcome)]) -> String {
    let row = |(trial, outcome): &(Trial, Outcome)| {
        let (rules, showings) = (trial.rules.name(), trial.showings);
        serde_json::json!({ "rules": rules, "showings": showings, "outcome": outcome })
    };
    serde_json::Value::Array(outcomes.iter().map(row).collect()).to_string()
}

fn table(outcomes: &[(Trial, Outcome)]) -> String {
    let head = format!("{:18} shown   10   20   40  worst  div   fam  living\n", "rules");
    let row = |(trial, outcome): &(Trial, Outcome)| {
        let [ten, twenty, forty] = outcome.percentiles;
        let Outcome { worst, diversity, families, living, .. } = outcome;
        let name = trial.rules.name();
        let shown = trial.showings;
        format!(
            "{name:18} {shown:5} {ten:.2} {twenty:.2} {forty:.2}  {worst:.2}  {diversity:.2} {families:5.1} {living:5.0}\n"
        )
    };
    head + &outcomes.iter().map(row).collect::<String>()
}
