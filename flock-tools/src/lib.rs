//! The artist's command line, in two programs.
//!
//! Owns the list of subcommands. Never does their work: each has its own module, and `report.rs` says how it ended.
//! `flock` is linked without ffmpeg, which takes longer to load than most commands to answer; what opens clips it hands
//! over to `flock-video`, the same commands with the decoder. `decoder.rs` is the line between the two.
#![forbid(unsafe_code)]

use std::process::ExitCode;

use clap::{Parser, Subcommand};
use report::{Exit, Fatal};

mod arguments;
mod balance;
mod bundles;
mod check;
mod clips;
mod curate;
mod decoder;
mod demo;
mod draft;
mod import;
mod joins;
mod manual;
mod now;
mod open;
mod page;
mod places;
mod progress;
mod render;
mod report;
mod save;
mod share;
mod simulate;
mod still;
mod thumbnail;
mod walk;

pub use decoder::Video;

/// The artist's tools for flocks of animated flames
#[derive(Debug, Parser)]
#[command(name = "flock", version, arg_required_else_help = true)]
struct Args {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    Add(curate::add::Args),
    Balance(balance::Args),
    Check(check::Args),
    Completions(manual::completions::Args),
    Demo(demo::Args),
    Diff(bundles::diff::Args),
    Drop(curate::drop::Args),
    Import(import::Args),
    Keygen(bundles::keygen::Args),
    Link(curate::link::Args),
    Man(manual::man::Args),
    New(curate::new::Args),
    Pack(bundles::pack::Args),
    Publish(bundles::publish::Args),
    Rename(curate::rename::Args),
    Render(render::Args),
    Report(page::Args),
    Share(share::Args),
    Simulate(simulate::Args),
    Still(still::Args),
    Unlink(curate::unlink::Args),
    Verify(bundles::verify::Args),
    Walk(walk::Args),
    Want(curate::want::Args),
}

/// Runs the program that was called, which has `video` here or elsewhere.
pub fn run(video: Video) -> ExitCode {
    report::finish(Args::try_parse().map(|args| answer(args.command, video)))
}

fn answer(command: Command, video: Video) -> Result<Exit, Fatal> {
    match command {
        Command::Add(args) => curate::add::run(&args, video),
        Command::Balance(args) => balance::run(&args),
        Command::Check(args) => check::run(&args, video),
        Command::Completions(args) => manual::completions::run(&args),
        Command::Demo(args) => video.decoder()?.demo(&args),
        Command::Diff(args) => bundles::diff::run(&args),
        Command::Drop(args) => curate::drop::run(&args),
        Command::Import(args) => video.decoder()?.import(&args),
        Command::Keygen(args) => bundles::keygen::run(&args),
        Command::Link(args) => curate::link::run(&args, video),
        Command::Man(args) => manual::man::run(&args),
        Command::New(args) => curate::new::run(&args),
        Command::Pack(args) if args.system => bundles::system::pack(&args),
        Command::Pack(args) => video.decoder()?.pack(&args),
        Command::Publish(args) => bundles::publish::run(&args),
        Command::Rename(args) => curate::rename::run(&args),
        Command::Render(args) => video.decoder()?.render(&args),
        Command::Report(args) => page::run(&args, video),
        Command::Share(args) => share::run(&args),
        Command::Simulate(args) => simulate::run(&args),
        Command::Still(args) => still::run(&args),
        Command::Unlink(args) => curate::unlink::run(&args),
        Command::Verify(args) => bundles::verify::run(&args),
        Command::Walk(args) => walk::run(&args),
        Command::Want(args) => curate::want::run(&args),
    }
}
