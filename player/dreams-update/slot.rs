//! From the store into a slot, and to the boot loader.
//!
//! Owns the order in which a system becomes one that is started: what the boot loader knows of the other slot is taken
//! back first, so that nothing points to what is half written; then the root, read back from the disk; then what the
//! firmware starts, beside its place, read back too; and in the end it is moved there, with its tries in its name.
//! A power cut at any step leaves the system that runs, and the next attempt begins anew. Never touches the slot that
//! runs, never looks for devices: the caller names them.
//!
//! Start at [`write`].

use crate::answer::SystemOutcome;
use crate::fatal::Fatal;
use crate::options::Order;
use crate::system::running;
use bundle::{
    BootFiles, ENTRIES, FileEntry, ObjectId, SYSTEMS, StagedSystems, Version, copy_folder, copy_object, lay_out,
};
use diagnostics::chain;
use durable::{FlushedWriter, persist, sync_folder};
use std::fs::{self, File};
use std::io::{self, ErrorKind, Seek, SeekFrom, Write};
use std::path::Path;
use tracing::{info, warn};

/// What every entry of ours begins with.
const OURS: &str = "dreams_";
/// A system on trial lies there once, as this copy.
const COPY: u8 = 1;
/// How often the boot loader starts a system before it goes back to the other one, unless that shows a picture.
const TRIES: u32 = 3;
/// Writes the staged system, if there is one, to the slot in `device`, and lays it before the boot loader in `boot`.
/// Errors: [`Fatal`]. The system that runs stays what is started.
pub(crate) fn write(order: &Order, store: &StagedSystems, device: &Path, boot: &Path) -> Result<SystemOutcome, Fatal> {
    let (Some(running), Some(system)) = (running(&order.config.system), store.staged()?) else {
        return Ok(SystemOutcome::None);
    };
    let version = &system.release().version;
    // It may have been staged for the system before this one.
    if version <= &running {
        store.drop_staged()?;
        return Ok(SystemOutcome::NoNews);
    }
    forget_others(boot, &running)?;
    let [start, root] = system.halves();
    info!(%version, device = %device.display(), "writing a system to the other slot");
    let laid = lay(store, &root, device).and_then(|()| announce(store, &start, version, boot));
    if let Err(fatal) = laid {
        give_up(store, &fatal);
        return Err(fatal);
    }
    store.mark_written(&system)?;
    Ok(SystemOutcome::Written(version.clone()))
}

/// Takes away what the boot loader knows of any system but the one that runs: the entries, then what they start.
fn forget_others(boot: &Path, running: &Version) -> Result<(), Fatal> {
    let is_others = |name: &str| name.rsplit_once('_').is_some_and(|(version, _)| version != running.to_string());
    for folder in [ENTRIES, SYSTEMS] {
        let folder = boot.join(folder);
        fs::create_dir_all(&folder).map_err(at("make", &folder))?;
        for entry in fs::read_dir(&folder).map_err(at("read", &folder))? {
            let name = entry.map_err(at("read", &folder))?.file_name();
            let name = name.to_string_lossy();
            let path = folder.join(&*name);
            if path.is_dir() && is_others(&name) {
                fs::remove_dir_all(&path).map_err(at("remove", &path))?;
            } else if name.strip_prefix(OURS).is_some_and(is_others) {
                fs::remove_file(&path).map_err(at("remove", &path))?;
            }
        }
        sync_folder(&folder).map_err(at("sync", &folder))?;
    }
    Ok(())
}

/// Lays what is started before the boot loader: the kernel and what it needs, then the entry, which gets its name last.
fn announce(store: &StagedSystems, start: &FileEntry, version: &Version, boot: &Path) -> Result<(), Fatal> {
    let mut bytes = Vec::new();
    let mut from = store.object(&start.id)?;
    copy_object(&start.id, start.size, &mut *from, &mut bytes).map_err(at("write", boot))?;
    let no_start_file = || io::Error::new(ErrorKind::InvalidData, format!("{} is no start file", start.id));
    let BootFiles { entry, parts } = lay_out(&bytes, COPY).ok_or_else(no_start_file).map_err(at("write", boot))?;
    let folder = boot.join(SYSTEMS).join(copy_folder(version, COPY));
    fs::create_dir_all(&folder).map_err(at("make", &folder))?;
    for (path, part) in parts {
        put(&boot.join(path), part)?;
    }
    sync_folder(&folder).map_err(at("sync", &folder))?;
    let entries = boot.join(ENTRIES);
    let new = entries.join(format!("{OURS}{version}_{COPY}.new"));
    put(&new, entry.as_bytes())?;
    let name = entries.join(format!("{OURS}{version}_{COPY}+{TRIES}.conf"));
    persist(&new, &name).map_err(at("make", &name))
}

/// Makes the file at `path` hold `bytes`, and reads it back from the disk.
fn put(path: &Path, bytes: &[u8]) -> Result<(), Fatal> {
    let file = File::options().read(true).write(true).create(true).truncate(true).open(path);
    let file = file.map_err(at("open", path))?;
    let mut writer = FlushedWriter::new(&file);
    writer.write_all(bytes).and_then(|()| writer.flush()).map_err(at("write", path))?;
    if fs::read(path).map_err(at("read back", path))? != bytes {
        let other = io::Error::new(ErrorKind::InvalidData, "other bytes were read back than were written");
        return Err(at("read back", path)(other));
    }
    Ok(())
}

/// Writes an object of the store to the device at `path`, and reads it back from the disk.
fn lay(store: &StagedSystems, object: &FileEntry, path: &Path) -> Result<(), Fatal> {
    let mut from = store.object(&object.id)?;
    let open = File::options().read(true).write(true).create(true).truncate(false).open(path);
    let mut file = open.map_err(at("open", path))?;
    let room = room(&mut file).map_err(at("measure", path))?;
    if room.is_some_and(|room| room < object.size) {
        let small = io::Error::new(ErrorKind::StorageFull, format!("{} bytes do not fit", object.size));
        return Err(at("write", path)(small));
    }
    let mut writer = FlushedWriter::new(&file);
    copy_object(&object.id, object.size, &mut *from, &mut writer).map_err(at("write", path))?;
    // What is read from now on comes from the disk and not from memory.
    writer.flush().map_err(at("sync", path))?;
    file.seek(SeekFrom::Start(0)).map_err(at("read back", path))?;
    let found = ObjectId::of_reader(io::Read::take(&file, object.size)).map_err(at("read back", path))?;
    if found != (object.id, object.size) {
        let other = io::Error::new(ErrorKind::InvalidData, format!("expected {}, found {}", object.id, found.0));
        return Err(at("read back", path)(other));
    }
    Ok(())
}

/// How much fits into a device; `None` for a file, which is emptied.
fn room(file: &mut File) -> io::Result<Option<u64>> {
    if file.metadata()?.is_file() {
        file.set_len(0)?;
        return Ok(None);
    }
    let room = file.seek(SeekFrom::End(0))?;
    file.seek(SeekFrom::Start(0))?;
    Ok(Some(room))
}

/// What is damaged in the store is fetched anew; whatever else went wrong may pass.
fn give_up(store: &StagedSystems, fatal: &Fatal) {
    let is_damaged = matches!(fatal, Fatal::Slot { doing: "write", source, .. } if source.kind() == ErrorKind::InvalidData)
        || matches!(fatal, Fatal::Store(_));
    if is_damaged && let Err(error) = store.drop_staged() {
        warn!(error = chain(&error), "cannot drop a damaged system");
    }
}

/// The error of trying `doing` on `path`.
fn at(doing: &'static str, path: &Path) -> impl FnOnce(io::Error) -> Fatal {
    let path = path.to_owned();
    move |source| Fatal::Slot { doing, path, source }
}
