//! Help, man pages, completions and colours of the artist's command line.
//!
//! Owns the claims that they have one source, and that every command is in each of them.

use claims::programs::{self, output, repository, succeed};
use std::fs;
use std::path::Path;
use std::process::Command;

/// Commands whose answer is a text for machines.
const WITHOUT_JSON: [&str; 1] = ["completions"];

/// Every command with its line in the help.
fn commands() -> Vec<(String, String)> {
    let help = String::from_utf8(succeed(Command::new(programs::dreams()).arg("--help"))).unwrap();
    let (_, list) = help.split_once("\nCommands:\n").expect("a list of commands");
    let entry = |line: &str| {
        let (name, about) = line.trim().split_once("  ").unwrap();
        (name.to_owned(), about.trim().to_owned())
    };
    list.lines().take_while(|line| !line.is_empty()).map(entry).filter(|(name, _)| name != "help").collect()
}

/// The help of `dreams COMMAND`.
fn help(command: &str) -> String {
    String::from_utf8(succeed(Command::new(programs::dreams()).args([command, "--help"]))).unwrap()
}

#[test]
fn the_readme_lists_every_command_as_the_help_does() {
    let readme = fs::read_to_string(repository().join("README.md")).unwrap();
    let row = |line: &str| {
        let (name, about) = line.strip_prefix("| `dreams ")?.split_once("` | ")?;
        Some((name.to_owned(), about.strip_suffix(" |")?.to_owned()))
    };
    let listed: Vec<_> = readme.lines().filter_map(row).collect();
    assert_eq!(listed, commands());
}

#[test]
fn no_document_calls_the_artists_program_flock() {
    let listed =
        output(Command::new("git").args(["ls-files", "*.md", "*.service", "config"]).current_dir(repository()));
    let files = String::from_utf8(listed.stdout).unwrap();
    assert!(files.lines().count() > 10, "{files}");
    let names: Vec<_> = commands().into_iter().map(|(name, _)| name).collect();
    for file in files.lines() {
        let text = fs::read_to_string(repository().join(file)).unwrap();
        for (number, line) in text.lines().enumerate() {
            let called = names.iter().any(|name| {
                ["`", "$ ", "/", "    "].iter().any(|before| line.contains(&format!("{before}flock {name}")))
            });
            assert!(!called && !line.contains("flock-video"), "{file}, line {}: {line}", number + 1);
        }
    }
}

#[test]
fn every_command_has_a_page_with_its_words_and_its_exit_statuses() {
    let scratch = tempfile::tempdir().unwrap();
    let said = succeed(Command::new(programs::dreams()).arg("man").arg(scratch.path()));
    let told = String::from_utf8(said).unwrap().lines().count();
    let commands = commands();
    let pool = help("pool");
    let actions = pool.lines().skip_while(|line| *line != "Commands:").skip(1).take_while(|line| !line.is_empty());
    let actions: Vec<&str> =
        actions.filter_map(|line| line.split_whitespace().next()).filter(|it| *it != "help").collect();
    assert!(
        actions.iter().all(|action| scratch.path().join(format!("dreams-pool-{action}.1")).is_file()),
        "{actions:?}"
    );
    assert_eq!(told, commands.len() + actions.len() + 1, "a page each, and one for all");
    for (name, about) in &commands {
        let page = fs::read_to_string(scratch.path().join(format!("dreams-{name}.1"))).unwrap();
        let plain = page.replace("\\-", "-").replace("\\*(Aq", "'");
        assert!(plain.contains(&format!("dreams-{name} - {about}\n")), "{plain}");
        for option in help(name).lines().filter_map(|line| line.trim().strip_prefix("--")?.split([' ', '[']).next()) {
            assert!(plain.contains(&format!("--{option}")), "{name} --{option}");
        }
        let (_, exits) = page.split_once(".SH EXIT STATUS\n").expect("exit statuses");
        assert!((0..=3).all(|code| exits.contains(&format!(".TP\n.B {code}\n"))), "{exits}");
    }
    let index = fs::read_to_string(scratch.path().join("dreams.1")).unwrap();
    assert!(commands.iter().all(|(name, _)| index.contains(&format!("dreams\\-{name}(1)"))), "{index}");
}

/// What bash completes the last word of `line` to, in `folder`, by the script of `program`.
fn completed(program: &Path, folder: &Path, line: &str) -> String {
    let script = folder.join("completions.bash");
    fs::write(&script, succeed(Command::new(program).args(["completions", "bash"]))).unwrap();
    // The function that `complete` was told of is called as bash does it.
    let asked = format!(
        "source '{}'; COMP_WORDS=({line}); COMP_CWORD=$((${{#COMP_WORDS[@]}} - 1)); spec=$(complete -p dreams); \
         spec=${{spec##*-F }}; ${{spec%% *}} dreams \"${{COMP_WORDS[COMP_CWORD]}}\" ''; echo \"${{COMPREPLY[@]}}\"",
        script.display()
    );
    let said = output(Command::new("bash").args(["-c", &asked]).current_dir(folder));
    assert!(said.stderr.is_empty(), "{}", String::from_utf8_lossy(&said.stderr));
    String::from_utf8(said.stdout).unwrap().trim().to_owned()
}

#[test]
fn a_shell_completes_commands_options_and_the_ids_of_a_flock() {
    let scratch = tempfile::tempdir().unwrap();
    let folder = scratch.path().join("my flock");
    fs::create_dir(&folder).unwrap();
    let sheep = |id: &str| format!("[[sheep]]\nid = \"{id}\"\n");
    let many: String = (0..100_000).map(|at| sheep(&format!("s{at:06}"))).collect();
    let head = "format = 1\nname = \"x\"\nsize = [64, 64]\nfps = [30, 1]\n";
    fs::write(folder.join("flock.toml"), format!("{head}{}{}{many}", sheep("191.21054"), sheep("orchid"))).unwrap();
    // By itself: no ffmpeg is at hand, and none is asked for.
    let program = scratch.path().join("dreams");
    programs::copy_program(&programs::dreams(), &program);
    let completed = |line: &str| completed(&program, scratch.path(), line);
    assert_eq!(completed("dreams unl"), "unlink");
    assert_eq!(completed("dreams want --j"), "--json");
    assert_eq!(completed("dreams want 'my flock' or"), "orchid");
    assert_eq!(completed(r"dreams link my\ flock orchid 19"), "191.21054");
    assert_eq!(
        completed("dreams render 'my flock' orchid s09999"),
        (0..10).map(|n| format!("s09999{n}")).collect::<Vec<_>>().join(" ")
    );
    assert_eq!(
        completed("dreams unlink 'my flock' --force s0500 s05000"),
        (0..10).map(|n| format!("s05000{n}")).collect::<Vec<_>>().join(" ")
    );
    assert_eq!(completed("dreams want nowhere or"), "");
    assert_eq!(completed("dreams rename 'my flock' orchid or"), "", "its new id is nobody's");
    assert_eq!(completed("dreams check my"), "", "names of files are left to bash, which quotes them");
}

#[test]
fn the_scripts_for_all_shells_ask_the_program() {
    let scratch = tempfile::tempdir().unwrap();
    for (shell, asks) in [("bash", "complete "), ("zsh", "#compdef dreams"), ("fish", "complete ")] {
        let script = String::from_utf8(succeed(Command::new(programs::dreams()).args(["completions", shell]))).unwrap();
        assert!(script.contains(asks) && script.contains("DREAMS_COMPLETE"), "{shell}: {script}");
        let asked = |line: &[&str]| {
            let mut program = Command::new(programs::dreams());
            program.env("DREAMS_COMPLETE", shell).env("_CLAP_COMPLETE_INDEX", (line.len() - 1).to_string());
            String::from_utf8(succeed(program.arg("--").args(line).current_dir(scratch.path()))).unwrap()
        };
        for (name, _) in commands() {
            assert!(asked(&["dreams", ""]).contains(&name), "{shell} knows {name}");
        }
        assert!(asked(&["dreams", "want", "--j"]).contains("--json"), "{shell}");
    }
    // Called by its name alone the script calls the program by its name, too.
    let path = programs::dreams().parent().unwrap().display().to_string();
    let named = succeed(Command::new("bash").args(["-c", &format!("PATH='{path}':$PATH; dreams completions bash")]));
    assert!(String::from_utf8(named).unwrap().contains("\"dreams\" -- "), "the script stays right when it is moved");
}

#[test]
fn every_command_answers_with_json() {
    for (name, _) in commands().iter().filter(|(name, _)| !WITHOUT_JSON.contains(&name.as_str())) {
        assert!(help(name).contains("\n      --json\n"), "{name}");
    }
}

#[test]
fn colours_are_for_terminals_and_for_those_who_want_them() {
    const ESCAPE: u8 = 0x1b;
    let program = programs::dreams();
    for words in [&["--help"][..], &["nonsense"], &["add", "--help"], &["new"], &["check", "no-such-flock"]] {
        let said = output(Command::new(&program).args(words));
        assert!(!said.stdout.contains(&ESCAPE) && !said.stderr.contains(&ESCAPE), "{words:?} into a pipe");
        let on_a_terminal = |no_colour: &str| {
            let words = format!("'{}' {}", program.display(), words.join(" "));
            let mut script = Command::new("script");
            script.args(["-qec", &words, "/dev/null"]).env("TERM", "xterm-256color").env_remove("NO_COLOR");
            if !no_colour.is_empty() {
                script.env("NO_COLOR", no_colour);
            }
            output(&mut script).stdout
        };
        assert!(!on_a_terminal("1").contains(&ESCAPE), "{words:?} with NO_COLOR");
        assert_eq!(on_a_terminal("").contains(&ESCAPE), words[0] != "check", "{words:?} on a terminal");
    }
}
