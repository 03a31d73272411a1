//! Claims about the whole system that need a guest kernel, a browser or a cluster: `make check-all` tries them.
//!
//! Owns this list, in folders by subject, as `it/` has them. Whole emulated machines are in `image/`.
#![forbid(unsafe_code)]
#![allow(clippy::unwrap_used, clippy::panic, reason = "a claim fails by panicking")]

mod display {
    mod broken_clips;
    mod cadence;
    mod choice;
    pub(crate) mod hot_plug;
    mod hours;
    mod joins;
    mod mode_changes;
    mod owner_hours;
    mod prelude;
    mod scanout;
    mod still;
    mod votes;
}
mod guest;
mod player {
    mod status_page;
    mod systemd;
    mod trial;
    mod update_load;
}
mod slurm_cluster;
mod studio {
    mod breeding;
    mod choosing;
    mod keys;
    mod killed;
    mod leading;
    mod news;
    mod playing;
    mod previews;
    mod pruning;
    mod sending;
    mod sights;
    mod stranger;
    mod tasks;
    mod visitor;
}
mod tools {
    mod cluster;
    mod fleet;
    mod report;
    mod report_sentences;
}
mod updates {
    mod bad_servers;
    mod power_cuts;
    mod pulled_stick;
}
