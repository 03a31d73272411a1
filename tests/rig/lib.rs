//! What the claims in `it/`, `slow/` and `image/`, the benches and the crash laboratory share.
//!
//! Owns the programs that are tried and how they are run, flocks and units to try them on, the maker of bundles, the mutator
//! of sticks, a web server that misbehaves, a browser, waits with a limit, and the disk that a power cut leaves. Makes no
//! claim.
//!
//! Start at [`programs`] and [`flocks`].
#![forbid(unsafe_code)]
#![allow(clippy::unwrap_used, clippy::panic, clippy::missing_panics_doc, reason = "a claim fails by panicking")]
#![allow(clippy::new_without_default, reason = "what is new has a folder and keys of its own")]
#![allow(missing_docs, reason = "only claims read it, and a plain field has a plain name")]

pub mod block_log;
pub mod broken_clips;
pub mod bundle_maker;
pub mod clips;
pub mod cuts;
pub mod editions;
pub mod fleet;
pub mod flocks;
pub mod mutator;
pub mod owner;
pub mod player_run;
pub mod programs;
pub mod random;
pub mod rendering;
pub mod report;
pub mod status_page;
pub mod studio {
    //! The studio, running, and a visitor of its page in a browser.

    pub mod browser;
    pub mod edits_by_chance;
    pub mod page;
    pub mod running;
    pub mod sheep;
    pub mod unreachable;
}
pub mod systems;
pub mod trace;
pub mod unit;
pub mod voting;
pub mod wait;
pub mod web;
