//! Claims about the whole system, tried on the real programs: those that `make check` tries.
//!
//! Owns this list, in folders by subject. None of them needs a guest kernel, an image, a browser or a cluster: those that do
//! are in `slow/` and `image/`. What all share is in `rig/`.
#![forbid(unsafe_code)]
#![allow(clippy::unwrap_used, clippy::panic, reason = "a claim fails by panicking")]

mod build {
    mod ci_install;
    mod owner_file;
    mod package_archives;
    mod packed_image;
}
mod house;
mod metering;
mod player {
    mod bad_clips;
    mod daemon;
    mod fallbacks;
    pub(crate) mod flock_switch;
    mod notices;
    mod rendered_meanwhile;
    pub(crate) mod resume;
    mod settings;
    mod shortages;
    mod status_page;
    pub(crate) mod votes;
}
mod studio {
    mod edits;
    mod fence;
    mod pool;
    mod pruning;
}
mod species;
mod syscall_faults;
mod tools {
    mod balance;
    mod breeding;
    mod breeding_guide;
    mod breeding_options;
    mod breeding_refusals;
    pub(crate) mod bundles;
    mod command_line;
    mod credits;
    pub(crate) mod curation;
    mod farm;
    mod fleet;
    mod foreign_flock;
    mod guides;
    mod import;
    mod import_archive;
    mod import_choices;
    mod import_folders;
    mod import_genomes;
    mod joins;
    mod killed_edits;
    mod large_flocks;
    mod manual;
    mod many;
    mod messages;
    mod publish;
    pub(crate) mod render;
    mod report;
    mod settings;
    mod still;
    mod tutorial;
    mod undrawn_genomes;
}
mod unit {
    mod boot_repair;
    mod damages;
    mod display_bus;
    mod hostname;
    mod installer;
    mod learned_state;
    mod own_disk;
    mod owner_settings;
    mod settings_stick;
}
mod updates {
    mod addressing;
    mod astray;
    mod certificates;
    mod http;
    mod interruptions;
    mod machine_report;
    mod memory_limits;
    mod mutants;
    mod old_formats;
    pub(crate) mod sticks;
    mod stolen_key;
    mod store_places;
    mod systems;
    mod untrusted_text;
}
