//! Locks on files.
//!
//! Owns [`Locked`], which ends a lock when it should. A process that was just forked has all open files of this one until
//! it runs its own program, and would keep the lock for that long.

use std::fs::File;

/// A locked file. Dropping it ends the lock, even while a forked process has the file open, too.
#[derive(Debug)]
pub struct Locked(File);

impl Locked {
    /// The guard of the lock that `file` holds.
    pub fn new(file: File) -> Self {
        Self(file)
    }
}

impl Drop for Locked {
    fn drop(&mut self) {
        // Closing it does the same, a little later.
        let _ = self.0.unlock();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lock_ends_though_a_forked_process_still_has_the_file() {
        let file = tempfile::NamedTempFile::new().unwrap();
        let open = || File::open(file.path()).unwrap();
        let held = open();
        held.lock().unwrap();
        // What a fork copies.
        let copy = held.try_clone().unwrap();
        let held = Locked::new(held);
        assert!(open().try_lock().is_err());
        drop(held);
        assert!(open().try_lock().is_ok());
        drop(copy);
    }
}
