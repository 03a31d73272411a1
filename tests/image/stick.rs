//! A stick with a new flock, for a unit whose owner trusts its artist.
//!
//! Owns the disk of the stick, what is on it, and the owner's words. Never plugs it in.
//!
//! Start at [`Stick::new`].

use crate::clips::Encode;
use crate::gallery::{Gallery, SIZE};
use crate::programs::succeed;
use claims::press::{Press, files_in};
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// What the flock on the stick is called; no frame of it is one of the built-in flock.
pub(crate) const AUTUMN: &str = "autumn";
/// What the unit is called.
const UNIT: &str = "lobby";
/// Frames of each of its clips, at least.
const FRAMES: u32 = 30;

/// A flock on its way.
pub(crate) struct Stick {
    /// The stick's own disk.
    pub(crate) disk: PathBuf,
    /// What the owner of the unit sets, so that it takes the flock: the file `dreams.toml`.
    pub(crate) owner: PathBuf,
    /// What is to be seen then.
    pub(crate) gallery: &'static Gallery,
}

impl Stick {
    /// A stick for the unit of `owner`, made in `folder`.
    pub(crate) fn new(folder: &Path) -> Self {
        let at = |file: &str| folder.join(file);
        make_flock(&at(AUTUMN));
        let press = Press::with_new_keys();
        press.bundle(&at("bundle"), &files_in(&at(AUTUMN)).unwrap(), &[UNIT], 1);
        let key = fs::read_to_string(press.keys().join("artist.pub")).unwrap();
        let key = key.lines().nth(1).expect("the key stands in the second line");
        fs::write(at("dreams.toml"), format!("unit = \"{UNIT}\"\nkeys = [\"{key}\"]\n")).unwrap();

        let disk = at("stick.img");
        fs::File::create(&disk).unwrap().set_len(64 << 20).unwrap();
        succeed(Command::new("mkfs.vfat").args(["-n", "FLOCK"]).arg(&disk));
        let files: Vec<_> = fs::read_dir(at("bundle")).unwrap().map(|entry| entry.unwrap().path()).collect();
        succeed(Command::new("mcopy").args(["-s", "-i"]).arg(&disk).args(files).arg("::"));
        Self { disk, owner: at("dreams.toml"), gallery: Box::leak(Box::new(Gallery::of(&at(AUTUMN)))) }
    }
}

/// Two sheep, and the ways between them.
fn make_flock(folder: &Path) {
    fs::create_dir(folder).unwrap();
    let (width, height) = SIZE;
    let mut manifest = format!("format = 1\nname = \"{AUTUMN}\"\nsize = [{width}, {height}]\nfps = [20, 1]\n");
    let heads = [
        "[[sheep]]\nid = \"oak\"",
        "[[sheep]]\nid = \"elm\"",
        "[[transition]]\nfrom = \"oak\"\nto = \"elm\"",
        "[[transition]]\nfrom = \"elm\"\nto = \"oak\"",
    ];
    for (number, head) in heads.into_iter().enumerate() {
        let name = format!("{number}.mp4");
        let size = (width.try_into().unwrap(), height.try_into().unwrap());
        Encode { size, fps: (20, 1), frames: FRAMES, number }.make(&folder.join(&name));
        write!(manifest, "\n{head}\nframes = {FRAMES}\nclip = \"{name}\"\n").unwrap();
    }
    fs::write(folder.join("flock.toml"), manifest).unwrap();
}
