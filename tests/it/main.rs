//! Claims about the whole system, tried on the real programs. What they share lies beside this file, the claims in
//! folders by subject.
#![forbid(unsafe_code)]
#![allow(clippy::unwrap_used, clippy::panic, reason = "a claim fails by panicking")]

mod build {
    mod ci_install;
    mod package_archives;
}
mod clips;
mod display {
    mod cadence;
    pub(crate) mod hot_plug;
    mod hours;
    mod joins;
    mod mode_changes;
    mod prelude;
    mod scanout;
    mod votes;
}
mod flocks;
mod guest;
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
    mod shortages;
    mod status_page;
    mod systemd;
    mod update_load;
    pub(crate) mod votes;
}
mod player_run;
mod programs;
mod slurm_cluster;
mod studio {
    mod breeding;
    mod browser;
    mod choosing;
    mod edits;
    mod fence;
    mod keys;
    mod killed;
    mod leading;
    mod news;
    mod page;
    mod playing;
    mod pool;
    mod previews;
    mod pruning;
    mod running;
    mod sending;
    mod sheep;
    mod sights;
    mod tasks;
}
mod syscall_faults;
mod tools {
    mod balance;
    mod breeding;
    mod breeding_guide;
    mod breeding_options;
    mod breeding_refusals;
    pub(crate) mod bundles;
    pub(crate) mod command_line;
    mod credits;
    pub(crate) mod curation;
    mod farm;
    mod guides;
    mod import;
    mod import_archive;
    mod import_choices;
    mod import_folders;
    mod joins;
    mod large_flocks;
    mod manual;
    mod many;
    mod messages;
    mod publish;
    pub(crate) mod render;
    mod report;
    mod report_sentences;
    mod still;
    mod tutorial;
}
mod trace;
mod unit {
    mod boot_repair;
    mod hostname;
    mod learned_state;
    mod own_disk;
    mod owner_settings;
}
mod updates {
    mod addressing;
    mod bad_servers;
    mod http;
    mod interruptions;
    mod memory_limits;
    mod mutants;
    mod old_formats;
    mod power_cuts;
    mod pulled_stick;
    pub(crate) mod sticks;
    mod stolen_key;
    pub(crate) mod systems;
    mod untrusted_text;
}
