//! The files that a renamed sheep leaves under its old name and needs under its new one.
//!
//! Owns the copies. The old files stay: an undo needs them, and the studio deletes nothing.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

use flock::ClipPath;

/// Has every file of `renamed` that is there lie under its new name, too.
/// Errors: A sentence, if another file has the new name, or a file cannot be copied. Some may be copied then.
pub(super) fn copy_renamed(folder: &Path, renamed: &BTreeMap<ClipPath, ClipPath>) -> Result<(), String> {
    for (old, new) in renamed {
        let (from, to) = (old.inside(folder), new.inside(folder));
        if !from.exists() {
            continue;
        }
        let copied = if to.exists() {
            let same = same_bytes(&from, &to).map_err(|error| format!("cannot read `{new}`: {error}"))?;
            if same { Ok(()) } else { return Err(format!("cannot rename `{old}`: `{new}` is another file")) }
        } else {
            durable::copy(&from, &to)
        };
        copied.map_err(|error| format!("cannot copy `{old}` to `{new}`: {error}"))?;
    }
    Ok(())
}

fn same_bytes(a: &Path, b: &Path) -> io::Result<bool> {
    let (mut a, mut b) = (File::open(a)?, File::open(b)?);
    if a.metadata()?.len() != b.metadata()?.len() {
        return Ok(false);
    }
    let (mut from_a, mut from_b) = (vec![0; 1 << 16], vec![0; 1 << 16]);
    loop {
        let count = a.read(&mut from_a)?;
        b.read_exact(&mut from_b[..count])?;
        if from_a[..count] != from_b[..count] {
            return Ok(false);
        }
        if count == 0 {
            return Ok(true);
        }
    }
}
