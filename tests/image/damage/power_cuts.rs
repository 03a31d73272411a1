//! The power goes, at any moment, and the unit comes back to its art.
//!
//! Owns the moments, and the life of a unit from one cut to the next. QEMU is killed. Then its disk has all that it was
//! told, or, as the dice fall, what it had flushed and any part of the rest: that is what a disk may lose.
//!
//! Start at [`Life::goes_on`].

use crate::machine::clock::now;
use crate::machine::picture::{Look, only_art};
use crate::machine::{Machine, PAUSE};
use crate::starts::first_start::{MOVES, OFTEN, PlayingUnit, playing_unit};
use crate::unit::path::Path;
use crate::unit::stick::AUTUMN;
use crate::unit::{Snapshot, Unit};
use crate::updates::next_system::{FETCH, NEXT, NOW, Step, UpdatingUnit, WRITE, kept, updating_unit, version};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use std::time::Duration;

/// While what the power goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Moment {
    /// It plays.
    Play,
    /// It starts, out of its box or not.
    Start,
    /// It takes in a flock from a stick, and that a key is called back.
    Update,
    /// It reads every byte of its flocks.
    Scrub,
    /// It takes in what its owner has edited.
    Edit,
    /// It fetches its next system.
    Fetch,
    /// It writes that to the slot that does not run.
    Write,
}

/// For its shell: its owner edits the settings, and the unit takes them in.
const EDIT: &str = "mkdir -p /run/edited && mount -t vfat /dev/vda4 /run/edited && \
                    echo 'timezone = \"Europe/Zurich\"' >> /run/edited/dreams.toml && umount /run/edited && \
                    systemctl start dreams-owner@vda4";
/// For its shell: what the owner has set is kept, whole, as it was or as it is.
const IS_KEPT: &str = "until grep -qs '^unit = \"lobby\"' /var/lib/dreams/owner/dreams.toml; do sleep 1; done";

/// A unit whose power goes again and again.
pub(crate) struct Life {
    unit: Unit,
    /// As what it is woken, once; else it is off.
    snapshot: Option<&'static Snapshot>,
    path: Option<Path>,
    /// Which systems may run, and the flock and the settings that no cut may take, where one is on its way.
    systems: Option<([&'static str; 2], &'static str)>,
    /// Of when its power goes.
    moments: ChaCha8Rng,
    /// Of what its disk loses then.
    losses: ChaCha8Rng,
}

/// The longest that a unit has until its power goes.
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

    /// Of the unit that plays and is about to do `moment` of what brings its next system: to fetch, to write or to start it.
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

    /// Of one that comes out of its box.
    pub(crate) fn out_of_the_box(seed: u64) -> Self {
        // The first that asks for what plays clears away the units of claims before.
        let owner = &playing_unit().stick.owner;
        let unit = Unit::new();
        unit.lay_for_owner(owner);
        Self::of(unit, None, None, seed)
    }

    fn of(unit: Unit, snapshot: Option<&'static Snapshot>, path: Option<&Path>, seed: u64) -> Self {
        let [moments, losses] = [seed, !seed].map(ChaCha8Rng::seed_from_u64);
        Self { unit, snapshot, path: path.cloned(), systems: None, moments, losses }
    }

    /// It lives until its power goes, at some moment of these; and so on, and comes back to its art in the end.
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
        // All of its writes are kept, or what a cut leaves of them.
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

    /// Holds what was seen against what may be, on a screen that was lit before or not.
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

/// For its shell: whoever has the flock of the stick has learned what lies beside it, and not forgotten it.
fn has_learned() -> String {
    let states = "/var/lib/dreams/store/state.0 /var/lib/dreams/store/state.1";
    format!("! grep -qs {AUTUMN} {states} || grep -qs 'revoke {}' {states}", playing_unit().stick.revoked)
}

/// What is on its screen while it is let live so long.
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
fn five_power_cuts_end_in_art() {
    let starts = [Moment::Start; 4];
    // By this seed all but the third lose what was not flushed, and the first start is cut about when its art comes.
    Life::of_playing(138).goes_on(&[[Moment::Update].as_slice(), &starts].concat());
}
