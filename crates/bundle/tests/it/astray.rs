//! Paths that no unit may follow.
//!
//! Owns the one list of them. Each breaks a rule also when a trusted key has signed it, in any list that has `flock.toml` and
//! `loops/0.mp4`. Shared with the mutator of the whole project. Never judges a path: `bundle` does.

/// They lead out of the folder, or to what is there already, or are spelled as no path of ours.
pub(crate) const ASTRAY: &[&str] = &[
    "../escape",
    "/etc/passwd",
    "loops/../../escape",
    "loops/./x",
    "loops//x",
    "loops/",
    "loops/..",
    "./x",
    "",
    ".",
    "..",
    "\0",
    "a\\b",
    "a\tb",
    "a\u{7f}b",
    "a\u{85}b",
    "~/x\r",
    "a/b/c/d/e/f/g/h/i",
    // A file that is there, a folder that is one, and a file that is none.
    "flock.toml",
    "loops",
    "flock.toml/x",
    "loops/0.mp4/x",
];
