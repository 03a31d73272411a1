//! `dreams man`: writes a man page for every command.
//!
//! Owns the command. The pages are clap's.

use std::fs;
use std::iter;
use std::path::{Path, PathBuf};

use clap::Command;
use clap_mangen::Man;
use operations::program::{Exit, Fatal, print};

/// The name of the manual, at the foot of every page.
const MANUAL: &str = "Dreams in High Fidelity";
/// The lines that clap puts above the exit codes.
const EXITS: &str = ".SH EXTRA\nExit status:\n";

/// Write man pages into a folder: `dreams.1` and one for every command
///
/// Read them with `man DIR/dreams-add.1`, or put them into a folder `man1` of the manual's path.
#[derive(Debug, clap::Args)]
#[command(after_help = "Exit status:
  0  the pages are written
  1  does not occur
  2  the command line is wrong
  3  a page could not be written")]
pub(crate) struct Args {
    /// The folder; made where it is missing
    dir: PathBuf,
    /// Answer with one JSON document: {"pages": [...]}
    #[arg(long)]
    json: bool,
}

#[derive(serde::Serialize)]
struct Answer {
    /// The pages' files, in the order of the commands.
    pages: Vec<PathBuf>,
}

/// Runs the command, for the whole `command_line`.
pub(crate) fn run(args: &Args, command_line: Command) -> Result<Exit, Fatal> {
    let pages = write(args, command_line)?;
    if args.json {
        print::json(&Answer { pages })?;
    } else {
        print::lines(pages.iter().map(|page| page.display().to_string()))?;
    }
    Ok(Exit::Fine)
}

fn write(args: &Args, command_line: Command) -> Result<Vec<PathBuf>, Fatal> {
    let cannot = |path: &Path| {
        let path = path.to_owned();
        move |source| Fatal::write(&path, source)
    };
    fs::create_dir_all(&args.dir).map_err(cannot(&args.dir))?;
    let whole = command_line.disable_help_subcommand(true);
    let commands = whole.get_subcommands().filter(|command| command.get_name() != "help");
    let source = format!("dreams {}", whole.get_version().unwrap_or_default());
    // Those of `dreams pool` have pages, too.
    let all = commands.flat_map(|command| iter::once(command).chain(command.get_subcommands()));
    let all = all.filter(|command| command.get_name() != "help");
    let pages = iter::once(&whole).chain(all).map(|command| {
        let page = Man::new(command.clone()).source(&source).manual(MANUAL);
        let path = args.dir.join(page.get_filename());
        let mut text = Vec::new();
        page.render(&mut text).map_err(cannot(&path))?;
        fs::write(&path, with_exits(&String::from_utf8_lossy(&text))).map_err(cannot(&path))?;
        Ok(path)
    });
    pages.collect()
}

/// The page `text` with the exit statuses under the heading that manuals have for them.
fn with_exits(text: &str) -> String {
    let Some((above, exits)) = text.split_once(EXITS) else { return text.to_owned() };
    let exits = exits.lines().map(|line| match line.trim_start().split_once("  ") {
        Some((code, meaning)) => format!(".TP\n.B {code}\n{meaning}\n"),
        None => format!("{line}\n"),
    });
    format!("{above}.SH EXIT STATUS\n{}", exits.collect::<String>())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exit_statuses_stand_where_a_manual_has_them() {
        let page = format!(".SH OPTIONS\nx\n{EXITS}  0  it is fine\n  1  it is not\n");
        let told = ".SH OPTIONS\nx\n.SH EXIT STATUS\n.TP\n.B 0\nit is fine\n.TP\n.B 1\nit is not\n";
        assert_eq!(with_exits(&page), told);
    }
}
