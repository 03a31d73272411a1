//! Writes the `flock.toml` and the genomes of the finished demo.
//!
//! Owns their text; the manifest is written last. `plan.rs` says what the flock is.
//!
//! Start at [`write`].

use std::fmt::Write as _;
use std::fs;
use std::io;
use std::path::Path;

use flock::{ClipHash, FILE_NAME};
use operations::render::plan::ClipRole;
use video::Form;

use super::plan::{DemoSheep, Plan, SHEEP};

/// Writes the genomes and then the manifest of `plan`, whose clips hash to `hashes`, into `folder`.
/// Errors: The system's error; a manifest that was there before is then still there.
pub(crate) fn write(plan: &Plan, hashes: &[ClipHash], folder: &Path) -> io::Result<()> {
    let genomes = folder.join("genomes");
    fs::create_dir_all(&genomes)?;
    for sheep in &SHEEP {
        fs::write(genomes.join(sheep.file()), sheep.genome)?;
    }
    durable::save(&folder.join(FILE_NAME), text(plan, hashes).as_bytes())
}

/// The manifest of `plan`, whose clips hash to `hashes`.
pub(crate) fn text(plan: &Plan, hashes: &[ClipHash]) -> String {
    let Form { size: (width, height), fps } = plan.edition.look.form;
    let mut text =
        format!("format = 1\nname = \"demo\"\nsize = [{width}, {height}]\nfps = [{}, {}]\n", fps.num(), fps.den());
    for (clip, hash) in plan.clips.iter().zip(hashes) {
        let names = match &clip.role {
            ClipRole::Loop(id) => {
                let file = DemoSheep::find(id.as_str()).file();
                format!("[[sheep]]\nid = \"{id}\"\ngenome = \"genomes/{file}\"\nrepeat = {}\n", plan.edition.repeat)
            }
            ClipRole::Transition(from, to) => format!("[[transition]]\nfrom = \"{from}\"\nto = \"{to}\"\n"),
        };
        write!(text, "\n{names}frames = {}\nclip = \"{}\"\nhash = \"{hash}\"\n", clip.frames.0, clip.path)
            .expect("writing to a string does not fail");
    }
    text
}
