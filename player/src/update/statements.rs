//! What keys say about keys, as it lies beside bundles.
//!
//! Owns reading it and having the store learn it, before anybody looks at who has signed what. Who may say what, the
//! store decides.

use crate::report::Fatal;
use bundle::{STATEMENTS, Source, Store, limits};
use std::io::{ErrorKind, Read};
use tracing::info;

/// Learns what keys say at `source` about keys.
///
/// # Errors
/// [`Fatal`] if it cannot be read or kept.
pub(crate) fn learn(store: &mut Store, source: &mut dyn Source) -> Result<(), Fatal> {
    for learned in store.learn(&read(source)?)? {
        info!(?learned, "learned about a key");
    }
    Ok(())
}

/// What lies there; nothing if the source has no such file.
fn read(source: &mut dyn Source) -> Result<Vec<u8>, Fatal> {
    let read = source.small(STATEMENTS, limits::STATEMENTS).and_then(|reader| {
        let mut bytes = Vec::new();
        reader.take(limits::STATEMENTS).read_to_end(&mut bytes).map(|_| bytes)
    });
    match read {
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(Vec::new()),
        read => read.map_err(|source| Fatal::Read { name: STATEMENTS.to_owned(), source }),
    }
}
