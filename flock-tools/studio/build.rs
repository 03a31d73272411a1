//! Embeds the files of the studio's page.
//!
//! Owns the table of their names and bytes, which `page.rs` includes: all that lies in `page/` and is meant for a browser,
//! each as it is, compressed by gzip.
#![forbid(unsafe_code)]

use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::{env, fs};

use flate2::Compression;
use flate2::write::GzEncoder;

/// The endings of what a browser is given; the rest of the folder is for the type checker.
const ENDINGS: [&str; 6] = ["css", "html", "js", "json", "svg", "woff2"];

fn main() {
    let folder = Path::new(&env::var_os("CARGO_MANIFEST_DIR").expect("cargo sets it")).join("page");
    let out = PathBuf::from(env::var_os("OUT_DIR").expect("cargo sets it"));
    println!("cargo::rerun-if-changed={}", folder.display());
    let entries = fs::read_dir(&folder).expect("the page's folder is there");
    let mut files: Vec<PathBuf> = entries.map(|entry| entry.expect("the folder can be read").path()).collect();
    files.sort();
    let lines: String =
        files.iter().filter(|file| ENDINGS.contains(&ending(file))).map(|file| line(file, &out)).collect();
    fs::write(out.join("page_files.rs"), format!("&[\n{lines}]")).expect("cargo's folder can be written");
}

/// The line of the table for `file`, whose compressed bytes lie in the folder `out` then.
fn line(file: &Path, out: &Path) -> String {
    let bytes = fs::read(file).expect("the page's files can be read");
    let mut packed = GzEncoder::new(Vec::new(), Compression::best());
    packed.write_all(&bytes).expect("memory can be written");
    let bytes = packed.finish().expect("memory can be written");
    let name = file.file_name().and_then(|name| name.to_str()).expect("our file names are UTF-8");
    let place = out.join(format!("page_{name}"));
    fs::write(&place, bytes).expect("cargo's folder can be written");
    format!("({name:?}, include_bytes!({:?})),\n", place.display().to_string())
}

fn ending(file: &Path) -> &str {
    file.extension().and_then(|ending| ending.to_str()).unwrap_or_default()
}
