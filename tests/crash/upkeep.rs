//! Maintenance of a unit: a clip is damaged and fetched again, a key is revoked, the owner edits the settings.
//!
//! Owns these steps, each by the real program, and what they leave on the disk. The checks are in `judge.rs`.
//!
//! Start at [`Lab::steps`].

use crate::lives::{Lab, UNIT, Way};
use crate::reports::{Script, Step};
use claims::bundle_maker::rubbish;
use claims::wait;
use std::fs::{self, File};
use std::os::unix::fs::FileExt;
use std::path::Path;
use std::process::{Command, Stdio};

/// The clip that is damaged: every flock has it.
pub(crate) const ROTTEN: &str = "loops/3.mp4";
/// The bytes that damage it, and where.
const ROT: &[u8] = b"rot";
const ROT_AT: usize = 40;
/// The number of the bundle that comes with the revocation; no unit installs it.
const CALLED_BACK: u64 = 100;
/// Where the owner's settings are on the disk.
const OWNER: &str = "owner";

/// What `dreams-owner` keeps of the owner's file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Settings {
    /// All but the password.
    pub(crate) kept: Option<String>,
    /// The Wi-Fi, with its password.
    pub(crate) wifi: Option<String>,
}

impl Settings {
    /// Those on the disk that is mounted at `mounted`.
    pub(crate) fn in_folder(mounted: &Path) -> Self {
        let read = |name: &str| fs::read_to_string(mounted.join(OWNER).join(name)).ok();
        Self { kept: read("dreams.toml"), wifi: read("wifi.conf") }
    }
}

/// The owner's file after edit number `edit`.
fn file(edit: usize) -> String {
    let hour = 6 + edit;
    format!(
        "unit = \"{UNIT}\"\nhours = \"{hour:02}:00-23:00\"\nwifi = \"Home {edit}\"\nwifi_password = \"velvet {edit}\"\n"
    )
}

/// Damages a clip.
pub(crate) fn rotten(clip: &mut [u8]) {
    clip[ROT_AT..ROT_AT + ROT.len()].copy_from_slice(ROT);
}

impl Lab {
    /// Runs the steps of `script` on the mounted disk, and reports each.
    pub(crate) fn steps(&self, script: Script, mounted: &Path, way: Way, report: &mut dyn FnMut()) {
        let store = mounted.join("store");
        let (mut editions, mut edits) = (1, 0);
        for step in script {
            match step {
                Step::Edition => {
                    self.brought(&store, &self.editions[editions], way, report);
                    editions += 1;
                }
                Step::Mended => {
                    let source = self.editions[editions - 1].source(way);
                    let answer = self.update(&store, &source, &["--scrub"]).unwrap();
                    assert_eq!(answer["mended"], 1, "{answer}");
                    report();
                }
                Step::Owner => {
                    edits += 1;
                    self.edited(mounted, edits);
                    report();
                }
                Step::Revoked => {
                    self.called_back(&store, way);
                    report();
                }
                Step::Rotten => {
                    let clip = File::options().write(true).open(store.join(bundle::CURRENT).join(ROTTEN)).unwrap();
                    clip.write_all_at(ROT, ROT_AT as u64).unwrap();
                    clip.sync_all().unwrap();
                    report();
                }
            }
        }
    }

    /// Applies the owner's file after edit number `edit`.
    pub(crate) fn edited(&self, mounted: &Path, edit: usize) {
        let at = |name: &str| self.folder.path().join(name);
        let kept = |name: &str| mounted.join(OWNER).join(name);
        fs::create_dir_all(mounted.join(OWNER)).unwrap();
        fs::create_dir_all(at("partition")).unwrap();
        fs::write(at("partition/dreams.toml"), file(edit)).unwrap();
        let mut owner = Command::new(&self.owner);
        owner.arg("take-in").arg(at("partition")).arg("--keep").arg(kept("dreams.toml"));
        owner.arg("--wifi").arg(kept("wifi.conf")).arg("--network").arg(at("")).arg("--name").arg(at("name"));
        let alone = self.alone();
        let child = owner.arg("--notice").arg(at("notice")).stdout(Stdio::null()).spawn();
        drop(alone);
        let ended = wait::ended("dreams-owner take-in", 600, &mut child.unwrap());
        assert!(ended.success(), "{owner:?} ended with {ended}");
    }

    /// The same without a temporary file and without syncs.
    pub(crate) fn edited_carelessly(&self, mounted: &Path, edit: usize) {
        let Settings { kept, wifi } = &self.settings[edit];
        for (name, text) in [("dreams.toml", kept), ("wifi.conf", wifi)] {
            fs::write(mounted.join(OWNER).join(name), text.as_deref().expect("there are some")).unwrap();
        }
    }

    /// A stick comes whose key is revoked by a statement on it.
    fn called_back(&self, store: &Path, way: Way) {
        let revoked = self.revoking.source(way);
        let refused = self.update(store, &revoked, &[]).expect_err("nobody trusts who has signed it");
        assert!(refused.contains("was revoked"), "{refused}");
    }

    /// The settings after each edit, made where no power is cut.
    pub(crate) fn all_settings(&self, count: usize) -> Vec<Settings> {
        let quiet = tempfile::tempdir().unwrap();
        let left = |edit| {
            self.edited(quiet.path(), edit);
            Settings::in_folder(quiet.path())
        };
        (0..=count).map(left).collect()
    }

    /// Writes the bundle whose key is revoked by a statement beside it.
    pub(crate) fn lay_revoking(&self, stick: &Path, form: (usize, usize)) {
        self.maker.forgery(stick, &rubbish(form.0, form.1, 1), &[], CALLED_BACK);
        self.maker.call_back(stick);
    }
}
