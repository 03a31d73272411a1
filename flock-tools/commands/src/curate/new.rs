//! `dreams new`: a flock without sheep.
//!
//! Owns the first manifest. Never changes a folder that is not empty.

use std::fs;
use std::path::{Path, PathBuf};

use flock::{Edit, FILE_NAME};
use operations::flock_folder::paths;
use operations::program::{Exit, Fatal, print};
use timing::Rate;

use crate::arguments;

/// The comment at the top of a new manifest.
pub(crate) const HEADING: &str =
    "# A flock: sheep, and the transitions between them. `dreams add` and `dreams link` put them in below.\n";

/// Start a flock: a folder with a manifest, and a place for genomes, loops and transitions
///
/// All clips of a flock have one size and one rate, which are set here.
#[derive(Debug, clap::Args)]
#[command(after_help = "Exit status:
  0  the flock is there, without sheep
  1  the folder is not empty; nothing was changed
  2  the command line is wrong
  3  a file could not be read or written")]
pub struct Args {
    /// The folder; made where it is missing
    dir: PathBuf,
    /// The name of the flock [default: that of its folder]
    #[arg(long)]
    name: Option<String>,
    /// Width and height in pixels, both even
    #[arg(long, value_name = "WxH", default_value = "1280x720", value_parser = arguments::size)]
    size: (u32, u32),
    /// Frames per second
    #[arg(long, value_name = "N[/D]", default_value = "30", value_parser = arguments::rate)]
    fps: Rate,
    /// Answer with one JSON document
    #[arg(long)]
    json: bool,
}

#[derive(serde::Serialize)]
struct Answer {
    changed: bool,
    name: String,
}

/// A folder that is not empty.
#[derive(Debug, thiserror::Error)]
#[error("folder `{folder}` is not empty: it has `{found}`")]
struct NotEmpty {
    folder: PathBuf,
    found: String,
}

/// Runs the command.
pub fn run(args: &Args) -> Result<Exit, Fatal> {
    let name = args.name.clone().unwrap_or_else(|| name_of(&args.dir));
    let text = format!("{HEADING}{}", Edit::blank(&name, args.size, args.fps).text());
    start(&args.dir, &text, || Ok(()))?;
    if args.json {
        print::json(&Answer { changed: true, name })?;
    } else {
        let (width, height) = args.size;
        let line = format!("flock `{name}` is there, {width}x{height} at {} frames per second", args.fps);
        print::lines([line])?;
        print::note("note: it has no sheep yet; `dreams add` puts them in");
    }
    Ok(Exit::Fine)
}

/// Makes the folders, what `fill` puts into them and, last, the manifest.
/// Errors: If the folder is not empty, or cannot be written; what `fill` says.
pub(crate) fn start(folder: &Path, text: &str, fill: impl FnOnce() -> Result<(), Fatal>) -> Result<(), Fatal> {
    let cannot = |path: &Path| {
        let path = path.to_owned();
        move |source| Fatal::write(&path, source)
    };
    fs::create_dir_all(folder).map_err(cannot(folder))?;
    if let Some(found) = fs::read_dir(folder).map_err(cannot(folder))?.next() {
        let found = found.map_err(cannot(folder))?.file_name().to_string_lossy().into_owned();
        return Err(Fatal::new(Exit::No, NotEmpty { folder: folder.to_owned(), found }));
    }
    for name in paths::FOLDERS {
        let path = folder.join(name);
        fs::create_dir(&path).map_err(cannot(&path))?;
    }
    fill()?;
    let path = folder.join(FILE_NAME);
    durable::save(&path, text.as_bytes()).map_err(cannot(&path))
}

/// The name of a folder, as people call it.
pub(crate) fn name_of(folder: &Path) -> String {
    let whole = fs::canonicalize(folder).unwrap_or_else(|_| folder.to_owned());
    whole.file_name().map_or_else(|| "flock".to_owned(), |name| name.to_string_lossy().into_owned())
}
