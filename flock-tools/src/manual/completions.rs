//! `dreams completions`: prints the completions for a shell.
//!
//! Owns the command. The scripts are clap's.

use clap::Command;
use clap_complete::Shell;

use crate::program::{Exit, Fatal, print};

/// Print what a shell needs to complete the words of `dreams`
///
/// For bash, put the output into ~/.local/share/bash-completion/completions/dreams; for zsh, into a file `_dreams` in a
/// folder of its `fpath`; for fish, into ~/.config/fish/completions/dreams.fish.
#[derive(Debug, clap::Args)]
#[command(after_help = "Exit status:
  0  the script is printed
  1  does not occur
  2  the command line is wrong
  3  the script could not be written")]
pub(crate) struct Args {
    /// The shell
    shell: Shell,
}

/// Runs the command, for the whole `command_line`.
pub(crate) fn run(args: &Args, mut command_line: Command) -> Result<Exit, Fatal> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut command_line, "dreams", &mut script);
    print::lines([String::from_utf8_lossy(&script).trim_end().to_owned()])?;
    Ok(Exit::Fine)
}
