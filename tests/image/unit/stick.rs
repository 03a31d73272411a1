//! A stick with a new flock, for a unit whose owner trusts its artist.
//!
//! Owns the disk of the stick, its content, and the owner's settings. The flock is on exFAT, between other partitions:
//! photographs on FAT, ext4 with links that lead out of it, and an empty one.
//!
//! Start at [`Stick::new`].

pub(crate) mod exfat;

use crate::machine::reference_frames::{ReferenceFrames, SIZE};
use bundle::KeyId;
use claims::bundle_maker::{BundleMaker, files_in};
use claims::clips::Encode;
use claims::programs::succeed;
use std::fmt::Write as _;
use std::fs::{self, File};
use std::os::unix::fs::{FileExt, symlink};
use std::path::{Path, PathBuf};
use std::process::Command;

/// The name of the stick's flock; no frame of it is equal to one of the built-in flock.
pub(crate) const AUTUMN: &str = "autumn";
/// The name of the unit.
const UNIT: &str = "lobby";
/// The partitions of the stick for `sfdisk`, and their sizes in MiB.
const TABLE: &str = "label: dos\nsize=8M, type=c\nsize=48M, type=7\nsize=8M, type=83\nsize=4M, type=83\n";
const MIB: [u64; 4] = [8, 48, 8, 4];
/// The number of clips of the flock.
pub(crate) const CLIPS: usize = 4;
/// The number of frames of each clip.
const FRAMES: u32 = 30;

/// A stick with a flock.
pub(crate) struct Stick {
    /// The stick's disk.
    pub(crate) disk: PathBuf,
    /// The owner's settings that make the unit accept the flock: the file `dreams.toml`.
    pub(crate) owner: PathBuf,
    /// The key that a statement on the stick revokes.
    pub(crate) revoked: KeyId,
    /// The frames of the flock.
    pub(crate) reference: &'static ReferenceFrames,
}

impl Stick {
    /// A stick for the unit of `owner`, made in `folder`.
    pub(crate) fn new(folder: &Path) -> Self {
        let at = |file: &str| folder.join(file);
        make_flock(&at(AUTUMN));
        let maker = BundleMaker::with_new_keys();
        maker.bundle(&at("bundle"), &files_in(&at(AUTUMN)).unwrap(), &[UNIT], 1);
        // A key that the artist took in, and calls back.
        maker.vouch(&at("bundle"));
        maker.call_back(&at("bundle"));
        let key = fs::read_to_string(maker.keys().join("artist.pub")).unwrap();
        let key = key.lines().nth(1).expect("the key stands in the second line");
        fs::write(at("dreams.toml"), format!("unit = \"{UNIT}\"\nkeys = [\"{key}\"]\n")).unwrap();

        let parts = ["photographs.img", "flock.img", "system.img"].map(at);
        for (part, mib) in parts.iter().zip(MIB) {
            File::create(part).unwrap().set_len(mib << 20).unwrap();
        }
        succeed(Command::new("mkfs.vfat").arg(&parts[0]));
        fs::write(at("IMG 0001 \u{e4}\u{308}'$(reboot).JPG"), "holiday").unwrap();
        succeed(
            Command::new("mcopy").arg("-i").arg(&parts[0]).arg(at("IMG 0001 \u{e4}\u{308}'$(reboot).JPG")).arg("::"),
        );
        exfat::make(&parts[1], MIB[1] << 20, &at("bundle"));
        fs::create_dir(at("system")).unwrap();
        symlink("/var/lib/dreams/store/objects", at("system/objects")).unwrap();
        symlink("/etc/shadow", at("system/statements")).unwrap();
        succeed(Command::new("mke2fs").args(["-q", "-t", "ext4", "-d"]).args([&at("system"), &parts[2]]));
        let disk = at("stick.img");
        join(&disk, &parts);
        let reference = Box::leak(Box::new(ReferenceFrames::of(&at(AUTUMN))));
        Self { disk, owner: at("dreams.toml"), revoked: maker.stranger(), reference }
    }
}

/// Writes the partitions `parts` to `disk`.
fn join(disk: &Path, parts: &[PathBuf]) {
    let file = File::create(disk).unwrap();
    file.set_len((MIB.iter().sum::<u64>() + 2) << 20).unwrap();
    let script = disk.with_extension("sfdisk");
    fs::write(&script, TABLE).unwrap();
    let label = "sfdisk --quiet \"$0\" < \"$1\"";
    succeed(Command::new("sh").args(["-c", label]).args([disk, &script]));
    let mut at = 1 << 20;
    for part in parts {
        let bytes = fs::read(part).unwrap();
        file.write_all_at(&bytes, at).unwrap();
        at += bytes.len() as u64;
    }
}

/// A flock of two sheep, with a transition in each direction.
fn make_flock(folder: &Path) {
    fs::create_dir(folder).unwrap();
    let (width, height) = SIZE;
    let mut manifest = format!("format = 1\nname = \"{AUTUMN}\"\nsize = [{width}, {height}]\nfps = [20, 1]\n");
    let heads: [_; CLIPS] = [
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
