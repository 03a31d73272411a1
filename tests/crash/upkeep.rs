//! What becomes of a unit besides flocks: its disk rots and is looked at, a key is called back, its owner edits the file.
//!
//! Owns these steps, each by the real program, and what they leave. Never judges.
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

/// The clip that rots: every flock has it.
pub(crate) const ROTTEN: &str = "loops/3.mp4";
/// What stands there then, and where.
const ROT: &[u8] = b"rot";
const ROT_AT: usize = 40;
/// The number of the bundle with which a key is called back: nobody takes it.
const CALLED_BACK: u64 = 100;
/// Where the owner's settings lie on the disk.
const OWNER: &str = "owner";

/// What `dreams-owner` keeps of the owner's file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Settings {
    /// All but the password.
    pub(crate) kept: Option<String>,
    /// The Wi-Fi.
    pub(crate) wifi: Option<String>,
}

impl Settings {
    /// Those on the disk that is mounted there.
    pub(crate) fn in_folder(mounted: &Path) -> Self {
        let read = |name: &str| fs::read_to_string(mounted.join(OWNER).join(name)).ok();
        Self { kept: read("dreams.toml"), wifi: read("wifi.conf") }
    }
}

/// What the owner has written the `edit`th time.
fn file(edit: usize) -> String {
    let hour = 6 + edit;
    format!(
        "unit = \"{UNIT}\"\nhours = \"{hour:02}:00-23:00\"\nwifi = \"Home {edit}\"\nwifi_password = \"velvet {edit}\"\n"
    )
}

/// Has a clip rot.
pub(crate) fn rotten(clip: &mut [u8]) {
    clip[ROT_AT..ROT_AT + ROT.len()].copy_from_slice(ROT);
}

impl Lab {
    /// Lives by `script`, on the disk that is mounted there, and reports each step.
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

    /// Takes in what the owner has written the `edit`th time.
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

    /// The same by somebody who is careless: in place, and without seeing that it is on the disk.
    pub(crate) fn edited_carelessly(&self, mounted: &Path, edit: usize) {
        let Settings { kept, wifi } = &self.settings[edit];
        for (name, text) in [("dreams.toml", kept), ("wifi.conf", wifi)] {
            fs::write(mounted.join(OWNER).join(name), text.as_deref().expect("there are some")).unwrap();
        }
    }

    /// A stick comes whose key is called back by what lies beside it.
    fn called_back(&self, store: &Path, way: Way) {
        let revoked = self.revoking.source(way);
        let refused = self.update(store, &revoked, &[]).expect_err("nobody trusts who has signed it");
        assert!(refused.contains("was revoked"), "{refused}");
    }

    /// What every edit of the owner's file must leave, tried where nobody cuts the power.
    pub(crate) fn all_settings(&self, count: usize) -> Vec<Settings> {
        let quiet = tempfile::tempdir().unwrap();
        let left = |edit| {
            self.edited(quiet.path(), edit);
            Settings::in_folder(quiet.path())
        };
        (0..=count).map(left).collect()
    }

    /// Lays out the bundle whose key is called back by what lies beside it.
    pub(crate) fn lay_revoking(&self, stick: &Path, form: (usize, usize)) {
        self.maker.forgery(stick, &rubbish(form.0, form.1, 1), &[], CALLED_BACK);
        self.maker.call_back(stick);
    }
}
