//! Power cuts at any moment, after each of which the unit shows its picture again.
//!
//! Owns the moments, and the life of a unit from one cut to the next. QEMU is killed. The disk then has all writes, or,
//! by chance, all that were flushed and any part of the rest.
//!
//! Start at [`Life::goes_on`].

use crate::machine::clock::now;
use crate::machine::picture::{Look, only_art};
use crate::machine::{Machine, PAUSE};
use crate::starts::first_start::{MOVES, OFTEN, PlayingUnit, playing_unit};
use crate::unit::path::Path;
use crate::unit::stick::AUTUMN;
use crate::unit::{NOW, Snapshot, Unit};
use crate::updates::next_system::{FETCH, NEXT, Step, UpdatingUnit, WRITE, kept, updating_unit, version};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use std::time::Duration;

/// What the unit does when the power goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Moment {
    /// It plays.
    Play,
    /// It starts, from its box or later.
    Start,
    /// It installs a flock from a stick, with a statement that revokes a key.
    Update,
    /// It scrubs its store.
    Scrub,
    /// It applies edited settings of its owner.
    Edit,
    /// It fetches its next system.
    Fetch,
    /// It writes that system to the slot that does not run.
    Write,
}

/// For the unit's shell: edits the owner's settings and applies them.
const EDIT: &str = "mkdir -p /run/edited && mount -t vfat /dev/vda4 /run/edited && \
                    echo 'timezone = \"Europe/Zurich\"' >> /run/edited/dreams.toml && umount /run/edited && \
                    systemctl start dreams-owner@vda4";
/// For the unit's shell: the owner's settings are whole, from before or after the edit.
const IS_KEPT: &str = "until grep -qs '^unit = \"lobby\"' /var/lib/dreams/owner/dreams.toml; do sleep 1; done";

/// A unit whose power is cut again and again.
pub(crate) struct Life {
    unit: Unit,
    /// The snapshot that it is resumed from, the first time; otherwise it is off.
    snapshot: Option<&'static Snapshot>,
    path: Option<Path>,
    /// The versions that may run, and the checksum of flock and settings, while a new system comes.
    systems: Option<([&'static str; 2], &'static str)>,
    /// Random numbers for the moments of the cuts.
    moments: ChaCha8Rng,
    /// Random numbers for the lost writes.
    losses: ChaCha8Rng,
}

/// The longest time before the power is cut.
fn longest(moment: Moment) -> Duration {
    let start = playing_unit().start;
    match moment {
        Moment::Play | Moment::Scrub => start.mul_f64(0.5),
        Moment::Start => start.mul_f64(1.2),
        Moment::Update => start.mul_f64(0.8),
        Moment::Edit => start.mul_f64(0.4),
        Moment::Fetch => updating_unit().fetching.time.mul_f64(1.1),
        Moment::Write => updating_unit().writing.time.mul_f64(1.1),
    }
}

impl Life {
    /// Of the unit that plays.
    pub(crate) fn of_playing(seed: u64) -> Self {
        let PlayingUnit { snapshot, path, .. } = playing_unit();
        Self::of(snapshot.copy(), Some(snapshot), Some(path), seed)
    }

    /// Of the unit that plays and is about to do `moment`: to fetch, to write or to start its next system.
    pub(crate) fn of_a_new_system(moment: Moment, seed: u64) -> Self {
        let UpdatingUnit { fetching, writing, written, path, kept, .. } = updating_unit();
        let of = |step: &'static Step| Self::of(step.snapshot.copy(), Some(&step.snapshot), Some(&step.path), seed);
        let life = match moment {
            Moment::Fetch => of(fetching),
            Moment::Write => of(writing),
            Moment::Play | Moment::Start | Moment::Update | Moment::Scrub | Moment::Edit => {
                Self::of(written.copy(), None, Some(path), seed)
            }
        };
        Self { systems: Some(([NOW, NEXT], kept)), ..life }
    }

    /// Of a unit out of its box.
    pub(crate) fn out_of_the_box(seed: u64) -> Self {
        // The first call of `playing_unit` removes the units of earlier runs.
        let owner = &playing_unit().stick.owner;
        let unit = Unit::new();
        unit.lay_for_owner(owner);
        Self::of(unit, None, None, seed)
    }

    fn of(unit: Unit, snapshot: Option<&'static Snapshot>, path: Option<&Path>, seed: u64) -> Self {
        let [moments, losses] = [seed, !seed].map(ChaCha8Rng::seed_from_u64);
        Self { unit, snapshot, path: path.cloned(), systems: None, moments, losses }
    }

    /// Cuts the power at each of `moments`, and then lets it start and show its picture.
    pub(crate) fn goes_on(mut self, moments: &[Moment]) {
        for moment in moments {
            self.is_cut(*moment);
        }
        let mut machine = self.unit.start();
        machine.also_expect(playing_unit().stick.reference);
        let mut looks = machine.await_shell();
        looks.extend(machine.watch_move(PAUSE, MOVES));
        self.follows(false, &looks);
        machine.is_well();
        let mount = machine.run("findmnt --noheadings --output FSTYPE,OPTIONS /var/lib/dreams");
        assert!(mount.starts_with("ext4 rw,"), "{mount}");
        machine.run(IS_KEPT);
        machine.run(&has_learned());
        if let Some((systems, before)) = self.systems {
            let runs = version(&mut machine);
            println!("system {runs} runs");
            assert!(systems.contains(&&*runs) && kept(&mut machine) == before, "system {runs} runs, or a file is lost");
        }
    }

    fn is_cut(&mut self, moment: Moment) {
        let loses = self.moments.next_u32().is_multiple_of(2);
        let part = f64::from(self.moments.next_u32()) / f64::from(u32::MAX);
        let woken = self.snapshot.take().filter(|_| moment != Moment::Start);
        let is_woken = woken.is_some();
        // Either all writes are kept, or what a power cut leaves of them.
        let mut machine = match woken {
            _ if loses => self.unit.record(woken),
            Some(snapshot) => self.unit.wake(snapshot),
            None => self.unit.start(),
        };
        machine.also_expect(playing_unit().stick.reference);
        let mut looks = Vec::new();
        if moment != Moment::Start && !is_woken {
            looks = machine.watch_for(PAUSE, "the picture", Look::is_art);
        }
        match moment {
            Moment::Play | Moment::Start => {}
            Moment::Update => machine.plug(&playing_unit().stick.disk),
            Moment::Scrub => machine.serial.send("systemctl start dreams-scrub"),
            Moment::Edit => machine.serial.send(EDIT),
            Moment::Fetch => machine.serial.send(&format!("{WRITE} && {FETCH}")),
            Moment::Write => machine.serial.send(WRITE),
        }
        let time = longest(moment).mul_f64(part);
        looks.extend(lives(&mut machine, time));
        if loses {
            machine.halt();
        }
        drop(machine);
        self.follows(is_woken, &looks);
        let lost = loses.then(|| self.unit.lose(&mut self.losses));
        let lost = lost.map_or("nothing".to_owned(), |[all, late, left]| {
            format!("{} of {late} late writes of {all}", late - left)
        });
        let path = self.path.as_ref().map(ToString::to_string).unwrap_or_default();
        println!("cut {time:.1?} into {moment:?}, lost {lost}, lit {}: {path}", looks.iter().any(Look::is_art));
    }

    /// Compares the looks with what may be shown; `was_lit` says whether the screen showed the picture before.
    fn follows(&mut self, was_lit: bool, looks: &[Look]) {
        if looks.iter().any(Look::is_art) {
            only_art(looks, OFTEN);
        }
        match &mut self.path {
            Some(path) if was_lit => looks.iter().for_each(|look| path.saw(look)),
            Some(path) => {
                path.came_back_with(looks);
            }
            None => {}
        }
    }
}

/// For the unit's shell: a unit with the flock of the stick knows the revoked key.
fn has_learned() -> String {
    let states = "/var/lib/dreams/store/state.0 /var/lib/dreams/store/state.1";
    format!("! grep -qs {AUTUMN} {states} || grep -qs 'revoke {}' {states}", playing_unit().stick.revoked)
}

/// The looks at the screen during `time`.
fn lives(machine: &mut Machine, time: Duration) -> Vec<Look> {
    let end = now() + time;
    let mut looks = Vec::new();
    while now() < end {
        looks.extend(machine.look());
        machine.wait(PAUSE.min(end.saturating_sub(now())));
    }
    looks
}

#[test]
fn two_power_cuts_end_in_art() {
    // With this seed both cuts lose writes, and the start is cut near its first frame.
    Life::of_playing(138).goes_on(&[Moment::Update, Moment::Start]);
}
