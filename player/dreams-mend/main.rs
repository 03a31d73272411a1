//! `dreams-mend`: looks through what a unit starts from, and mends what is damaged from what is whole.
//!
//! Owns the order: what the firmware starts on the two boot partitions, the two slots, what was damaged put right from
//! the copy that is whole. Never decides which system is started: the names of the entries say that, and others write
//! them. Never mounts, and never looks for devices: who calls it says which they are.
//!
//! Start at [`mend`].
#![forbid(unsafe_code)]

mod boot_partitions;
mod fatal;
mod memory;
mod options;
mod plan;
mod slots;
mod verity;

use boot_partitions::Boots;
use clap::Parser;
use fatal::{Answer, Fatal};
use options::{Look, Options};
use player::{LogLevel, Output, journal};
use slots::Slot;
use std::collections::BTreeSet;
use std::process::ExitCode;
use tracing::Level;

fn main() -> ExitCode {
    let options = Options::parse();
    journal::open(LogLevel(Level::INFO));
    fatal::finish(mend(&options))
}

/// Looks at what `options` name, and mends it.
fn mend(options: &Options) -> Result<Output<Answer>, Fatal> {
    let mut answer = Answer::default();
    let boots = Boots::new(&options.boot, options.spare.as_deref(), &options.loader);
    boots.sweep()?;
    boots.mend_loaders(&mut answer)?;
    let entries = boots.read()?;
    let left = plan::left(&entries, &options.running);
    boots.apply(plan::entries(&entries, boots.count()), &mut answer)?;
    if options.look == Look::All {
        mend_slots(options, &boots, &mut answer)?;
    }
    fatal::tell_people(&answer, options.notice.as_deref());
    if let Some(path) = &options.rollback {
        memory::remember(left.as_ref(), &options.running, path, options.notice.as_deref());
    }
    Ok(Output { answer, json: options.json })
}

/// Reads the slots, and mends them if the system that runs is whole in one of them.
fn mend_slots(options: &Options, boots: &Boots<'_>, answer: &mut Answer) -> Result<(), Fatal> {
    let files = boots.read()?;
    let slots = slots::look(&options.slot, &files)?;
    let kept: BTreeSet<_> = slots.iter().filter(|slot| slot.is_whole).filter_map(Slot::version).collect();
    if !kept.contains(&options.running) {
        slots::report(&slots, answer);
        return Ok(());
    }
    // What points to a slot goes before what is in the slot does.
    boots.apply(plan::without_roots(&files, &kept), answer)?;
    slots::refill(&slots, &options.running, answer)?;
    boots.apply(plan::shared(&boots.read()?), answer)
}
