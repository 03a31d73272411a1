//! `flock`, the artist's command line.
//!
//! Owns the list of subcommands. Never does their work: each has its own module, and `report.rs` says how it ended.
#![forbid(unsafe_code)]

use std::process::ExitCode;

use clap::{Parser, Subcommand};

mod balance;
mod check;
mod clips;
mod demo;
mod now;
mod open;
mod render;
mod report;
mod save;
mod share;
mod simulate;
mod walk;

/// The artist's tools for flocks of animated flames
#[derive(Debug, Parser)]
#[command(name = "flock", version, arg_required_else_help = true)]
struct Args {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    Balance(balance::Args),
    Check(check::Args),
    Demo(demo::Args),
    Render(render::Args),
    Share(share::Args),
    Simulate(simulate::Args),
    Walk(walk::Args),
}

fn main() -> ExitCode {
    report::finish(Args::try_parse().map(|args| match args.command {
        Command::Balance(args) => balance::run(&args),
        Command::Check(args) => check::run(&args),
        Command::Demo(args) => demo::run(&args),
        Command::Render(args) => render::run(&args),
        Command::Share(args) => share::run(&args),
        Command::Simulate(args) => simulate::run(&args),
        Command::Walk(args) => walk::run(&args),
    }))
}
