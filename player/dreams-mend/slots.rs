//! The two slots: what is damaged in one is mended from the other.
//!
//! Owns the reading of every byte of both, and the order in which a slot is written: its superblock is taken away first
//! and comes last, so that a slot that is half written is never started. Only blocks that differ are written. Never
//! touches what the firmware starts.
//!
//! Start at [`look`] and [`refill`].

use crate::fatal::{Answer, Fatal, at};
use crate::plan::Entry;
use crate::verity::{BLOCK, Root};
use bundle::Version;
use durable::{FlushedWriter, drop_cache};
use std::fs::File;
use std::io::{self, Write};
use std::os::unix::fs::FileExt;
use std::path::{Path, PathBuf};
use tracing::{info, warn};

/// How much is compared at once.
const AT_ONCE: usize = 1 << 20;

/// A slot, and what was found in it.
#[derive(Debug)]
pub(crate) struct Slot {
    path: PathBuf,
    /// The root whose superblock it has, of those that a start file starts.
    root: Option<(Version, Root)>,
    /// Whether every bit of that root is there.
    pub(crate) is_whole: bool,
}

impl Slot {
    pub(crate) fn version(&self) -> Option<Version> {
        self.root.as_ref().map(|(version, _)| version.clone())
    }
}

/// Reads every byte of the slots at `paths` that counts.
pub(crate) fn look(paths: &[PathBuf], files: &[Entry]) -> Result<Vec<Slot>, Fatal> {
    let files = files.iter().filter_map(|entry| entry.file.as_ref());
    let roots: Vec<_> = files.filter_map(|file| Some((file.version.clone(), Root::of(file)?))).collect();
    let slot = |path: &PathBuf| {
        let file = File::open(path)?;
        // What is read from now on comes from the disk.
        drop_cache(&file)?;
        let mut found = None;
        for (version, root) in &roots {
            if root.is_named_in(&file)? {
                found = Some((version.clone(), root.clone()));
            }
        }
        let is_whole = found.as_ref().map_or(Ok(false), |(_, root)| root.is_whole_in(&file))?;
        drop_cache(&file)?;
        Ok(Slot { path: path.clone(), root: found, is_whole })
    };
    paths.iter().map(|path| slot(path).map_err(at("read", path))).collect()
}

/// Makes every slot that is not whole hold what a whole one holds: the system that it held, or the one that is `running`.
pub(crate) fn refill(slots: &[Slot], running: &Version, answer: &mut Answer) -> Result<(), Fatal> {
    let whole =
        |version: Option<&Version>| slots.iter().find(|slot| slot.is_whole && slot.version().as_ref() == version);
    for slot in slots.iter().filter(|slot| !slot.is_whole) {
        let version = slot.version();
        let same = version.as_ref().and_then(|version| whole(Some(version)));
        let Some(source) = same.or_else(|| whole(Some(running))) else { continue };
        let Some((version, root)) = &source.root else { continue };
        warn!(slot = %slot.path.display(), from = %source.path.display(), %version, "repaired a damaged slot");
        copy(root, &source.path, &slot.path)?;
        info!(slot = %slot.path.display(), %version, "a slot is whole again");
        answer.mended.push(slot.path.display().to_string());
    }
    Ok(())
}

/// Tells of what cannot be mended now.
pub(crate) fn report(slots: &[Slot], answer: &mut Answer) {
    for slot in slots.iter().filter(|slot| !slot.is_whole) {
        warn!(slot = %slot.path.display(), "a slot is damaged, and there is no whole copy of its system");
        answer.lost.push(slot.path.display().to_string());
    }
}

/// Makes the slot `to` hold `root`, which is whole in the slot `from`.
fn copy(root: &Root, from: &Path, to: &Path) -> Result<(), Fatal> {
    let source = File::open(from).map_err(at("read", from))?;
    let target = File::options().read(true).write(true).open(to).map_err(at("write", to))?;
    let superblock = root.superblock_at();
    let mut writer = FlushedWriter::new(&target);
    writer.write_at(&[0; BLOCK], superblock).and_then(|()| writer.flush()).map_err(at("write", to))?;
    let (mut wanted, mut found) = (vec![0; AT_ONCE], vec![0; AT_ONCE]);
    let mut at_byte = 0;
    while at_byte < root.size() {
        // Up to the superblock, and from behind it.
        let end = if at_byte < superblock { superblock } else { root.size() };
        let length = AT_ONCE.min((end - at_byte) as usize);
        let (wanted, found) = (&mut wanted[..length], &mut found[..length]);
        source.read_exact_at(wanted, at_byte).map_err(at("read", from))?;
        // What can't be read is written.
        let is_there = target.read_exact_at(found, at_byte).is_ok() && found == wanted;
        if !is_there {
            writer.write_at(wanted, at_byte).map_err(at("write", to))?;
        }
        at_byte += length as u64;
        if at_byte == superblock {
            at_byte += BLOCK as u64;
        }
    }
    writer.flush().map_err(at("sync", to))?;
    let mut block = [0; BLOCK];
    source.read_exact_at(&mut block, superblock).map_err(at("read", from))?;
    writer.write_at(&block, superblock).and_then(|()| writer.flush()).map_err(at("write", to))?;
    drop_cache(&source).map_err(at("read", from))?;
    if root.is_whole_in(&target).map_err(at("read back", to))? {
        return Ok(());
    }
    let other = io::Error::new(io::ErrorKind::InvalidData, "other bytes were read back than were written");
    Err(at("read back", to)(other))
}
