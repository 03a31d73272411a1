//! A small flock that is rendered, and its frames.
//!
//! Owns the flock of three genomes, and what `dreams render` leaves of it.
//!
//! Start at [`genomes`] and [`whole`].

use crate::programs::{self, output};
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use tempfile::TempDir;

/// Its manifest.
pub const MANIFEST: &str = "\
# Three sheep; the third is only passed through.
format = 1
name = \"three\"
size = [64, 36]
fps = [30, 1]

[[sheep]]
id = \"orchid\"   # the first
frames = 12
clip = \"loops/orchid.mp4\"
genome = \"genomes/orchid.flam3\"

[[sheep]]
id = \"rosette\"
frames = 8
clip = \"loops/rosette.mp4\"
genome = \"genomes/rosette.flam3\"

[[sheep]]
id = \"undertow\"
genome = \"genomes/undertow.flam3\"

[[transition]]
from = \"orchid\"
to = \"rosette\"
frames = 5
clip = \"transitions/orchid=rosette.mp4\"

[[transition]]
from = \"rosette\"
to = \"undertow\"
frames = 5
clip = \"transitions/rosette=undertow.mp4\"

[[transition]]
from = \"undertow\"
to = \"orchid\"
frames = 5
clip = \"transitions/undertow=orchid.mp4\"
";

pub const CLIPS: [&str; 5] = [
    "loops/orchid.mp4",
    "loops/rosette.mp4",
    "transitions/orchid=rosette.mp4",
    "transitions/rosette=undertow.mp4",
    "transitions/undertow=orchid.mp4",
];

/// A flock with the genomes of three sheep, and no clips.
pub fn genomes() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("flock.toml"), MANIFEST).unwrap();
    fs::create_dir(folder.path().join("genomes")).unwrap();
    for name in ["orchid", "rosette", "undertow"] {
        let genome = programs::repository().join("flock-tools/demo/genomes").join(name).with_extension("flam3");
        fs::copy(genome, folder.path().join("genomes").join(name).with_extension("flam3")).unwrap();
    }
    folder
}

/// The bytes of all clips.
pub fn clips(folder: &Path) -> Vec<Vec<u8>> {
    CLIPS.iter().map(|clip| fs::read(folder.join(clip)).unwrap()).collect()
}

/// The frames of the clips together.
pub const FRAMES: usize = 35;

/// `dreams render FOLDER`, which keeps its frames; each takes so many samples per pixel.
pub fn render(command: &mut Command, folder: &Path, spp: &str) {
    command.arg("render").arg(folder).args(["--temporal-samples", "4", "--spp", spp]);
}

/// The files of all frames, by their paths.
pub fn frames(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut found = BTreeMap::new();
    for clip in CLIPS {
        for entry in fs::read_dir(folder.join(".render").join(clip)).into_iter().flatten() {
            let path = entry.unwrap().path();
            // One that is being written may be renamed meanwhile.
            let bytes = fs::read(&path).unwrap_or_default();
            found.insert(path.strip_prefix(folder).unwrap().to_owned(), bytes);
        }
    }
    found
}

/// The number of frames that are there.
pub fn count(folder: &Path) -> usize {
    let is_frame = |path: &&PathBuf| path.extension().is_some_and(|ending| ending == "yuv");
    frames(folder).keys().filter(is_frame).count()
}

/// A flock that one process has rendered at once, with its frames.
pub fn whole(spp: &str) -> tempfile::TempDir {
    let flock = genomes();
    let mut command = Command::new(programs::dreams());
    render(&mut command, flock.path(), spp);
    let said = output(command.arg("--keep-frames"));
    assert_eq!(said.status.code(), Some(0), "{}", String::from_utf8_lossy(&said.stderr));
    assert_eq!(count(flock.path()), FRAMES);
    flock
}
