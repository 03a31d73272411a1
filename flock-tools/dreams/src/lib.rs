//! The artist's command line, in two programs.
//!
//! Owns the list of subcommands. Never does their work: `commands`, `studio` and `fleet` do. `dreams` is linked without ffmpeg, which
//! takes longer to load than most commands to answer. Where a command opens clips, `dreams` hands over to `dreams-video`,
//! which has the same commands and ffmpeg; `operations::decoder` is the line between the two.
//!
//! A folder sees only folders above it in this table; `tests/it/house/folders.rs` holds that.
//!
//! | folder | what is there |
//! |---|---|
//! | `manual` | `dreams completions`, `dreams man` |
//! | `bin` | the two programs |
//!
//! Start at [`run`].
#![forbid(unsafe_code)]

mod manual;

use std::process::ExitCode;

use clap::{CommandFactory, Parser, Subcommand};
use commands::{balance, breeding, bundles, check, credits, curate, demo, import, render, report, walks};
use operations::decoder::ffmpeg::Ffmpeg;
use operations::decoder::{Decoder, DecoderHandle, hand_over};
use operations::program::{Exit, Fatal, end, misuse, print};

/// The artist's tools for flocks: animations that loop, and the transitions between them
#[derive(Debug, Parser)]
#[command(name = "dreams", version, arg_required_else_help = true)]
struct Args {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    Add(curate::add::Args),
    Balance(balance::Args),
    Breed(breeding::breed::Args),
    Check(check::Args),
    Completions(manual::completions::Args),
    Credits(credits::Args),
    Demo(demo::Args),
    Diff(bundles::diff::Args),
    Drop(curate::drop::Args),
    Elect(breeding::elect::Args),
    Family(breeding::family::Args),
    Fleet(fleet::Args),
    Import(import::Args),
    Keygen(bundles::keygen::Args),
    Link(curate::link::Args),
    List(curate::list::Args),
    Man(manual::man::Args),
    New(curate::new::Args),
    Pack(bundles::pack::Args),
    Pool(breeding::pool::Args),
    Prune(curate::prune::Args),
    Publish(bundles::publish::Args),
    Rename(curate::rename::Args),
    Render(render::Args),
    Repeat(curate::repeat::Args),
    Report(report::Args),
    Settings(bundles::settings::Args),
    Share(walks::share::Args),
    Simulate(walks::simulate::Args),
    Still(render::still::Args),
    Studio(studio::Args),
    Unlink(curate::unlink::Args),
    Verify(bundles::verify::Args),
    Votes(breeding::votes::Args),
    Walk(walks::walk::Args),
    Want(curate::want::Args),
    Weight(curate::weight::Args),
}

/// A command that needs ffmpeg from its beginning.
type FfmpegCommand<A> = fn(&A) -> Result<Exit, Fatal>;

/// The part that needs ffmpeg: the decoder, and the commands that always need it. A program that does not call
/// [`FfmpegPart::linked`] is linked without ffmpeg.
#[derive(Clone, Copy)]
pub struct FfmpegPart {
    decoder: &'static dyn Decoder,
    demo: FfmpegCommand<demo::Args>,
    import: FfmpegCommand<import::Args>,
    pack: FfmpegCommand<bundles::pack::Args>,
    render: FfmpegCommand<render::Args>,
    studio: FfmpegCommand<studio::Args>,
}

impl FfmpegPart {
    /// The part, with ffmpeg: for `dreams-video`.
    pub fn linked() -> Self {
        Self {
            decoder: &Ffmpeg,
            demo: demo::run,
            import: |args| import::run(args, &Ffmpeg),
            pack: |args| bundles::pack::run(args, &Ffmpeg),
            render: render::run,
            studio: |args| studio::run(args, &Ffmpeg),
        }
    }
}

/// Runs the command that the command line names, with `ffmpeg` or without.
pub fn run(ffmpeg: Option<FfmpegPart>) -> ExitCode {
    if manual::completions::answer(Args::command) {
        return Exit::Fine.into();
    }
    finish(Args::try_parse().map(|args| answer(args.command, ffmpeg)))
}

fn answer(command: Command, ffmpeg: Option<FfmpegPart>) -> Result<Exit, Fatal> {
    let decoder = DecoderHandle(ffmpeg.map(|part| part.decoder));
    let part = || ffmpeg.ok_or_else(hand_over);
    match command {
        Command::Add(args) => curate::add::run(&args, decoder),
        Command::Balance(args) => balance::run(&args),
        Command::Breed(args) => breeding::breed::run(&args),
        Command::Check(args) => check::run(&args, decoder),
        Command::Completions(args) => manual::completions::run(&args),
        Command::Credits(args) => credits::run(&args),
        Command::Demo(args) => (part()?.demo)(&args),
        Command::Diff(args) => bundles::diff::run(&args),
        Command::Drop(args) => curate::drop::run(&args),
        Command::Elect(args) => breeding::elect::run(&args),
        Command::Family(args) => breeding::family::run(&args),
        Command::Fleet(args) => fleet::run(&args),
        Command::Import(args) => (part()?.import)(&args),
        Command::Keygen(args) => bundles::keygen::run(&args),
        Command::Link(args) => curate::link::run(&args, decoder),
        Command::List(args) => curate::list::run(&args),
        Command::Man(args) => manual::man::run(&args, command_line()),
        Command::New(args) => curate::new::run(&args),
        Command::Pack(args) if args.system => bundles::system::pack(&args),
        Command::Pack(args) => (part()?.pack)(&args),
        Command::Pool(args) => breeding::pool::run(&args),
        Command::Prune(args) => curate::prune::run(&args),
        Command::Publish(args) => bundles::publish::run(&args),
        Command::Rename(args) => curate::rename::run(&args),
        Command::Render(args) => (part()?.render)(&args),
        Command::Repeat(args) => curate::repeat::run(&args),
        Command::Report(args) => report::run(&args, decoder),
        Command::Settings(args) => bundles::settings::run(&args),
        Command::Share(args) => walks::share::run(&args),
        Command::Simulate(args) => walks::simulate::run(&args),
        Command::Still(args) => render::still::run(&args),
        Command::Studio(args) => (part()?.studio)(&args),
        Command::Unlink(args) => curate::unlink::run(&args),
        Command::Verify(args) => bundles::verify::run(&args),
        Command::Votes(args) => breeding::votes::run(&args),
        Command::Walk(args) => walks::walk::run(&args),
        Command::Want(args) => curate::want::run(&args),
        Command::Weight(args) => curate::weight::run(&args),
    }
}

/// Prints how a command ended, and gives the exit code of the process. `result` is a [`clap::Error`] where the command line
/// is wrong or help was asked for.
fn finish(result: Result<Result<Exit, Fatal>, clap::Error>) -> ExitCode {
    let exit = match result {
        Ok(result) => end(result),
        Err(usage) if usage.use_stderr() => misuse(&usage.render().to_string(), || usage.print()),
        // Help is an answer.
        Err(help) => end(print::finish(help.print()).map(|()| Exit::Fine)),
    };
    exit.into()
}

/// The whole command line, as clap knows it.
fn command_line() -> clap::Command {
    let mut command = Args::command();
    command.build();
    command
}

#[cfg(test)]
mod tests {
    use super::{Args, CommandFactory};

    #[test]
    fn every_subcommand_tells_its_exit_statuses() {
        let mut command = Args::command();
        for subcommand in command.get_subcommands_mut() {
            let help = subcommand.render_long_help().to_string();
            let (_, block) = help.split_once("Exit status:\n").expect("an `Exit status:` block");
            for status in 0..=3 {
                assert!(block.contains(&format!("\n  {status}  ")) || block.starts_with(&format!("  {status}  ")));
            }
        }
    }
}
