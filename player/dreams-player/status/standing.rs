//! The state of the store on the status page: the flock that plays, and the result of the last update run.
//!
//! Owns the ages. Read anew for everyone who asks; a flock in a plain folder has none of it.

use bundle::CurrentGeneration;
use jiff::Timestamp;
use player::Contact;
use serde::Serialize;
use std::path::Path;

/// The flock that is to be played.
#[derive(Debug, Serialize)]
pub(crate) struct GenerationFacts {
    /// Its number among those of its key.
    pub(crate) sequence: u64,
    /// When it was signed, and how long ago that is; none while this machine does not know the time.
    pub(crate) created: String,
    pub(crate) age_s: Option<u64>,
    /// Who signed it.
    pub(crate) signer: String,
    /// Whether it has to prove itself.
    pub(crate) is_on_trial: bool,
}

/// The last look at a stick or a server.
#[derive(Debug, Serialize)]
pub(crate) struct ContactFacts {
    pub(crate) source: String,
    pub(crate) result: String,
    /// How long ago; none where that is unknown.
    pub(crate) age_s: Option<u64>,
    /// Ids of the keys that were trusted then, and of those that were called back.
    pub(crate) trusted: Vec<String>,
    pub(crate) revoked: Vec<String>,
}

/// Both, of the store whose `current` lies at `path`, at `known_s` seconds since 1970; `None` while the time is not known.
pub(crate) fn read(path: &Path, known_s: Option<u64>) -> (Option<GenerationFacts>, Option<ContactFacts>) {
    let since = |then_s: u64| known_s.map(|known_s| known_s.saturating_sub(then_s));
    let playing = CurrentGeneration::of(path).ok().flatten();
    let generation = playing.as_ref().and_then(CurrentGeneration::status).map(|(seal, is_on_trial)| {
        let letter = seal.letter();
        let signed_s = letter.created.parse::<Timestamp>().ok().and_then(|at| u64::try_from(at.as_second()).ok());
        GenerationFacts {
            sequence: letter.sequence.0,
            created: letter.created.clone(),
            age_s: signed_s.and_then(since),
            signer: seal.signer().to_string(),
            is_on_trial,
        }
    });
    let contact =
        path.parent().filter(|_| playing.is_some() || path.ends_with(bundle::CURRENT)).and_then(Contact::last);
    let contact = contact.map(|contact| ContactFacts {
        source: contact.source,
        result: contact.result,
        age_s: contact.clock_s.and_then(since),
        trusted: contact.trusted,
        revoked: contact.revoked,
    });
    (generation, contact)
}
