//! The disk of a machine.
//!
//! Owns QEMU's options for it. Never writes to it.

use std::path::PathBuf;

/// A disk, in a file.
#[derive(Debug)]
pub(crate) struct Disk {
    pub(crate) file: PathBuf,
    /// QEMU's name of its format.
    pub(crate) format: &'static str,
    /// The file in which QEMU records all writes and flushes, as `claims::block_log` reads it.
    pub(crate) log: Option<PathBuf>,
}

impl Disk {
    /// One in `file`, without a record.
    pub(crate) fn new(file: PathBuf, format: &'static str) -> Self {
        Self { file, format, log: None }
    }

    /// QEMU's options for the node `disk`.
    pub(crate) fn words(&self) -> Vec<String> {
        // When QEMU is killed, its writes are in this machine's page cache, and are not lost.
        let node = |name: &str, words: &str| ["-blockdev".to_owned(), format!("node-name={name},{words}")];
        let file = |file: &PathBuf| format!("driver=file,cache.no-flush=on,filename={}", file.display());
        let form = format!("driver={},cache.no-flush=on,file=file", self.format);
        let Some(log) = &self.log else {
            return [node("file", &file(&self.file)), node("disk", &form)].concat();
        };
        let whole = "driver=blklogwrites,file=form,log=log,log-sector-size=512,log-super-update-interval=1";
        let nodes = [("file", &file(&self.file)), ("form", &form), ("log", &file(log)), ("disk", &whole.to_owned())];
        nodes.into_iter().flat_map(|(name, words)| node(name, words)).collect()
    }
}
