//! What keys say about keys, as it lies beside bundles.
//!
//! Owns reading it and having the store learn it, before anybody looks at who has signed what; and that a seal counts
//! only when all that it expects was learned. Who may say what, the store decides.
//!
//! Start at [`heeded`].

use crate::fatal::Fatal;
use bundle::{Refusal, STATEMENTS, Source, Store, TrustUpdate, limits};
use diagnostics::chain;
use std::io::{ErrorKind, Read};
use tracing::{info, warn};

/// What `verify` opens, once the store has learned what keys say at `source` about keys, and then what is `expected` by
/// what was opened.
/// Errors: [`Fatal`] if that cannot be read or kept, or is withheld; or what `verify` refuses.
pub(crate) fn heeded<S>(
    store: &mut Store,
    source: &mut dyn Source,
    verify: impl Fn(&Store) -> Result<S, Refusal>,
    expected: impl Fn(&S, &mut dyn Source) -> Result<Vec<u8>, Refusal>,
) -> Result<S, Fatal> {
    let said = read(source)?;
    learn(store, &said)?;
    let opened = verify(store).map_err(Fatal::Refused)?;
    let said = expected(&opened, source).map_err(Fatal::Refused)?;
    if said.is_empty() {
        return Ok(opened);
    }
    learn(store, &said)?;
    verify(store).map_err(Fatal::Refused)
}

fn learn(store: &mut Store, said: &[u8]) -> Result<(), Fatal> {
    let TrustUpdate { news, refused } = store.learn(said)?;
    for learned in news {
        info!(?learned, "learned about a key");
    }
    if let Some(first) = refused.first() {
        warn!(refused = refused.len(), error = chain(first), "some statements about keys are refused");
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
