//! `dreams completions`: prints the completions for a shell.
//!
//! Owns the command, and the answers to the shells' questions. Scripts and answers are clap's: a script asks `dreams`
//! itself at every key press, so it stays right when `dreams` or a flock changes. To a script for bash and zsh is added
//! what clap's lack: names of files with spaces and `~`.

use std::env;
use std::ffi::OsStr;
use std::path::Path;

use clap::Command;
use clap_complete::env::Shells;
use clap_complete::{CompleteEnv, Shell};
use operations::program::{Exit, Fatal, print};

/// The variable by which a script asks for completions.
const VARIABLE: &str = "DREAMS_COMPLETE";

/// How clap's script for bash names its function, and what is done with it instead.
const CLAPS_BASH: &str = "-F _clap_complete_dreams";
const OUR_BASH: &str = "-o default -F _dreams";
/// Names of files are left to bash, which quotes them.
const BASH: &str = r#"_dreams() {
    _clap_complete_dreams "$@"
    if [[ "$2" == "~"* || -e "${COMPREPLY-}" ]]; then COMPREPLY=(); fi
}
"#;
/// The same for zsh, and the way in for a file of `fpath`, which is the function itself.
const CLAPS_ZSH: &str = "compdef _clap_dynamic_completer_dreams dreams";
const OUR_ZSH: &str = r#"function _dreams() {
    [[ "$PREFIX" == "~"* ]] || _clap_dynamic_completer_dreams
    (( compstate[nmatches] )) || _files
}
if [[ "$funcstack[1]" == _dreams ]]; then _dreams "$@"; else compdef _dreams dreams; fi"#;

/// Print what a shell needs to complete the words of `dreams`, and the ids of a flock's sheep
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

/// Runs the command.
pub(crate) fn run(args: &Args) -> Result<Exit, Fatal> {
    let shells = Shells::builtins();
    let shell = shells.completer(&args.shell.to_string()).expect("clap completes for the shells that it lists");
    let mut script = Vec::new();
    let written = shell.write_registration(VARIABLE, "dreams", "dreams", &program(), &mut script);
    written.map_err(|error| Fatal::new(Exit::Unreadable, error))?;
    let script = String::from_utf8_lossy(&script);
    let script = match args.shell {
        Shell::Bash => format!("{BASH}{}", script.replace(CLAPS_BASH, OUR_BASH)),
        Shell::Zsh => script.replace(CLAPS_ZSH, OUR_ZSH),
        Shell::Elvish | Shell::Fish | Shell::PowerShell | _ => script.into_owned(),
    };
    print::text(script.trim())?;
    Ok(Exit::Fine)
}

/// Answers the shell if it asks for completions of a command line, and says whether it did.
pub(crate) fn answer(command_line: fn() -> Command) -> bool {
    let asked = CompleteEnv::with_factory(command_line).var(VARIABLE);
    // An error would be printed in the middle of the line that is being typed.
    asked.try_complete(env::args_os(), env::current_dir().ok().as_deref()).unwrap_or(true)
}

/// This program, as a script finds it: by its name where it was, too, so that another version may take its place.
fn program() -> String {
    let called = env::args_os().next().unwrap_or_default();
    let is_path = Path::new(&called).components().count() > 1;
    let own = env::current_exe().ok().filter(|_| is_path);
    own.as_deref().map_or(OsStr::new("dreams"), Path::as_os_str).to_string_lossy().into_owned()
}
