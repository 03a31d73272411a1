//! The ids of a flock's sheep, completed by the shell as people type them.
//!
//! Owns how the ids of the flock that a command line names are found. Never changes a flock.
//!
//! Start at [`completer`].

use std::borrow::Cow;
use std::env;
use std::ffi::{OsStr, OsString};
use std::fs;
use std::path::{Path, PathBuf};

use clap_complete::engine::{ArgValueCompleter, CompletionCandidate};
use flock::{FILE_NAME, Manifest};

/// A manifest in which no ids are found as `dreams` writes them is parsed if it has at most this many bytes.
const MOST_PARSED: usize = 4 << 20;

/// Completes the id of a sheep in the shell, for the flock whose folder is named in the same command line.
pub(crate) fn completer() -> ArgValueCompleter {
    ArgValueCompleter::new(|current: &OsStr| {
        let Some(begun) = current.to_str() else { return Vec::new() };
        let Some(text) = words().find_map(|word| fs::read_to_string(word.join(FILE_NAME)).ok()) else {
            return Vec::new();
        };
        let matching = ids(&text).into_iter().filter(|id| id.starts_with(begun));
        matching.map(|id| CompletionCandidate::new(id.into_owned())).collect()
    })
}

/// The words of the command line that is completed, each as the path that it may be. They come as they were typed.
fn words() -> impl Iterator<Item = PathBuf> {
    let typed = env::args_os().skip_while(|word| word != "--").skip(1);
    typed.flat_map(|word| [path(&word, env::var_os("HOME")), PathBuf::from(word)])
}

/// The path that a shell makes of `word`, without its variables and patterns.
fn path(word: &OsStr, home: Option<OsString>) -> PathBuf {
    let word = word.to_string_lossy();
    let (start, rest) = match word.strip_prefix("~/").zip(home) {
        Some((rest, home)) => (PathBuf::from(home), rest),
        None => (PathBuf::new(), &*word),
    };
    let mut is_escaped = false;
    let plain = rest.chars().filter(|&c| {
        is_escaped = !is_escaped && c == '\\';
        !is_escaped && !matches!(c, '\'' | '"')
    });
    start.join(plain.collect::<String>())
}

/// The ids of all sheep in the manifest `text`, in its order. They are searched line by line: 100 MB, a million
/// transitions, are parsed in a second, which is too long for a key press.
fn ids(text: &str) -> Vec<Cow<'_, str>> {
    let mut is_sheep = false;
    let mut found: Vec<Cow<str>> = Vec::new();
    for line in text.lines().map(str::trim_start) {
        if line.starts_with('[') {
            is_sheep = line.starts_with("[[sheep]]");
        } else if is_sheep {
            found.extend(id(line).map(Cow::Borrowed));
        }
    }
    if !found.is_empty() || text.len() > MOST_PARSED {
        return found;
    }
    let parsed = Manifest::parse(text, Path::new(FILE_NAME)).map_or(Vec::new(), |manifest| manifest.sheep);
    parsed.into_iter().map(|sheep| Cow::Owned(sheep.id.as_str().to_owned())).collect()
}

/// The id in a line `id = "..."`.
fn id(line: &str) -> Option<&str> {
    let value = line.strip_prefix("id")?.trim_start().strip_prefix('=')?.trim_start();
    let quote = value.chars().next().filter(|c| matches!(c, '\'' | '"'))?;
    value[1..].split_once(quote).map(|(id, _)| id)
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEAD: &str = "format = 1\nname = \"x\"\nsize = [64, 64]\nfps = [30, 1]\n";

    #[test]
    fn ids_are_found_in_every_form_of_a_manifest() {
        let transition = "[[transition]]\nfrom = \"a\"\nid = \"no\"\n";
        let plain = format!("{HEAD}[[sheep]]\nid = \"a\"\n{transition}\n[[sheep]] # b\n  id='b.1' # c\nwant = 2\n");
        assert_eq!(ids(&plain), ["a", "b.1"]);
        let inline = format!("{HEAD}sheep = [{{ id = \"a\" }}, {{ want = 2, id = 'b' }}]\n");
        assert_eq!(ids(&inline), ["a", "b"]);
        assert_eq!(ids("no manifest"), [""; 0]);
    }

    #[test]
    fn words_are_paths_as_a_shell_reads_them() {
        let path = |word: &str| path(OsStr::new(word), Some("/home/ada".into()));
        for (word, wanted) in
            [("aurora", "aurora"), ("~/a", "/home/ada/a"), (r"my\ flock", "my flock"), ("'my flock'/", "my flock/")]
        {
            assert_eq!(path(word), Path::new(wanted), "{word}");
        }
    }
}
