//! The conversation with the person before the display: what is asked, and what a key means.
//!
//! Owns the state machine. Nothing is written without a press of Enter on a page that names the disk and has been visible for
//! a while, so that a key that was held since the firmware's menu is no answer. Pure: time, keys, disks and the progress come
//! in as arguments; `run.rs` acts, `page.rs` has the words.
//!
//! Start at [`State::on`].

use crate::copying::Phase;
use crate::disks::{Disk, Fitness};

/// For how long a page must be visible before Enter counts on it, in milliseconds.
pub(crate) const VISIBLE_MS: u64 = 2_000;

/// A key that means something.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Key {
    /// 1 to 9.
    Digit(u8),
    Enter,
    Delete,
}

/// What happens.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Input {
    /// The disks that are there now.
    Disks(Vec<Disk>),
    /// A key was pressed; the page had been visible for so many milliseconds, `None` if it is not yet.
    Key { key: Key, visible_ms: Option<u64> },
    /// So many thousandths of a phase are done.
    Progress { phase: Phase, thousandths: u16 },
    /// The work on the disk has ended.
    Ended(Result<(), Trouble>),
    /// The stick was removed.
    StickGone,
}

/// Why a disk was not installed, as far as a person can do something about it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Trouble {
    /// Something else uses the disk, or it is another one by now.
    Busy,
    /// What was read from the disk is not what was written.
    Differs,
    /// The disk cannot be written.
    Disk,
    /// The stick is damaged, or cannot be read.
    Stick,
}

/// What the page says.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum State {
    /// The disks are not known yet.
    Looking,
    /// No disk fits; these are there.
    NoDisk { disks: Vec<Disk> },
    /// Several fit.
    Choose { disks: Vec<Disk> },
    /// This one is asked for; `stay`: the flocks and settings of the unit on it stay. The others are there, too.
    Confirm { disk: Disk, stay: bool, disks: Vec<Disk> },
    /// It is written.
    Working { disk: Disk, phase: Phase, thousandths: u16 },
    /// It was not installed.
    Failed { disk: Disk, trouble: Trouble },
    /// The unit is on the disk.
    Installed,
}

/// What is to be done.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Action {
    /// Nothing.
    Wait,
    /// Write to the disk of the state.
    Install { stay: bool },
    /// Start the machine again.
    Restart,
}

impl State {
    /// What follows, and what is to be done.
    ///
    /// | state | `Disks` | `Key` | `Progress` | `Ended` | `StickGone` |
    /// |---|---|---|---|---|---|
    /// | `Looking` | asks | - | - | - | - |
    /// | `NoDisk` | asks anew, if they are others | - | - | - | - |
    /// | `Choose` | asks anew, if they are others | digit: `Confirm` | - | - | - |
    /// | `Confirm` | asks anew, if they are others | Delete: the other `stay`; Enter: `Working`, `Install` | - | - | - |
    /// | `Working` | - | - | shows it | `Installed` or `Failed` | - |
    /// | `Failed` | - | Enter: asks anew | - | - | - |
    /// | `Installed` | - | - | - | - | `Restart` |
    pub(crate) fn on(self, input: Input) -> (Self, Action) {
        match (self, input) {
            (Self::Looking, Input::Disks(now)) => (Self::ask(now), Action::Wait),
            (Self::NoDisk { disks } | Self::Choose { disks } | Self::Confirm { disks, .. }, Input::Disks(now))
                if disks != now =>
            {
                (Self::ask(now), Action::Wait)
            }
            (Self::Choose { disks }, Input::Key { key: Key::Digit(digit), .. }) => {
                (Self::chosen(disks, digit), Action::Wait)
            }
            (Self::Confirm { disk, stay, disks }, Input::Key { key, visible_ms }) => match key {
                Key::Enter if visible_ms.is_some_and(|ms| ms >= VISIBLE_MS) => {
                    (Self::Working { disk, phase: Phase::Check, thousandths: 0 }, Action::Install { stay })
                }
                Key::Delete if disk.fitness == Fitness::HasUnit => {
                    (Self::Confirm { disk, stay: !stay, disks }, Action::Wait)
                }
                Key::Enter | Key::Delete | Key::Digit(_) => (Self::Confirm { disk, stay, disks }, Action::Wait),
            },
            (Self::Working { disk, .. }, Input::Progress { phase, thousandths }) => {
                (Self::Working { disk, phase, thousandths }, Action::Wait)
            }
            (Self::Working { .. }, Input::Ended(Ok(()))) => (Self::Installed, Action::Wait),
            (Self::Working { disk, .. }, Input::Ended(Err(trouble))) => (Self::Failed { disk, trouble }, Action::Wait),
            (Self::Failed { .. }, Input::Key { key: Key::Enter, visible_ms: Some(VISIBLE_MS..) }) => {
                (Self::Looking, Action::Wait)
            }
            (Self::Installed, Input::StickGone) => (Self::Installed, Action::Restart),
            (
                state @ (Self::Looking
                | Self::NoDisk { .. }
                | Self::Choose { .. }
                | Self::Confirm { .. }
                | Self::Working { .. }
                | Self::Failed { .. }
                | Self::Installed),
                Input::Disks(_) | Input::Key { .. } | Input::Progress { .. } | Input::Ended(_) | Input::StickGone,
            ) => (state, Action::Wait),
        }
    }

    /// The question that these disks call for.
    fn ask(disks: Vec<Disk>) -> Self {
        let fitting = fitting(&disks);
        match &fitting[..] {
            [] => Self::NoDisk { disks },
            [disk] => Self::confirm((*disk).clone(), disks.clone()),
            [_, _, ..] => Self::Choose { disks },
        }
    }

    fn chosen(disks: Vec<Disk>, digit: u8) -> Self {
        let chosen =
            usize::from(digit).checked_sub(1).and_then(|at| fitting(&disks).get(at).map(|disk| (*disk).clone()));
        match chosen {
            Some(disk) => Self::confirm(disk, disks),
            None => Self::Choose { disks },
        }
    }

    fn confirm(disk: Disk, disks: Vec<Disk>) -> Self {
        Self::Confirm { stay: disk.fitness == Fitness::HasUnit, disk, disks }
    }
}

/// The disks on which a unit can be installed; the first is number 1.
pub(crate) fn fitting(disks: &[Disk]) -> Vec<&Disk> {
    disks.iter().filter(|disk| matches!(disk.fitness, Fitness::Fits | Fitness::HasUnit)).take(9).collect()
}

#[cfg(test)]
mod tests {
    use super::{Action, Input, Key, Phase, State, Trouble, VISIBLE_MS};
    use crate::disks::{Disk, Fitness};
    use proptest::prelude::{Just, Strategy, any, prop, prop_oneof, proptest};

    fn disk(name: &str, fitness: Fitness) -> Disk {
        Disk { name: name.to_owned(), model: String::new(), bytes: 1 << 40, fitness }
    }

    fn key(key: Key) -> Input {
        Input::Key { key, visible_ms: Some(VISIBLE_MS) }
    }

    /// Where these inputs lead, and what is to be done at the last of them; before it there is nothing to do.
    fn after(inputs: &[Input]) -> (State, Action) {
        let mut last = (State::Looking, Action::Wait);
        for input in inputs {
            assert_eq!(last.1, Action::Wait, "before {input:?}");
            last = last.0.on(input.clone());
        }
        last
    }

    #[test]
    fn one_disk_is_written_after_enter_and_starts_without_the_stick() {
        let disks = Input::Disks(vec![disk("nvme0n1", Fitness::Fits), disk("sda", Fitness::TooSmall)]);
        let mut inputs = vec![disks.clone(), key(Key::Digit(1)), key(Key::Delete), disks, Input::StickGone];
        let (state, action) = after(&inputs);
        assert!(matches!(&state, State::Confirm { disk, stay: false, .. } if disk.name == "nvme0n1"), "{state:?}");
        assert_eq!(action, Action::Wait);
        inputs.push(key(Key::Enter));
        let (state, action) = after(&inputs);
        assert_eq!(action, Action::Install { stay: false });
        let (state, _) = state.on(Input::Progress { phase: Phase::Compare, thousandths: 7 });
        assert!(matches!(state, State::Working { phase: Phase::Compare, thousandths: 7, .. }));
        let (state, action) = state.on(Input::Ended(Ok(())));
        assert_eq!((&state, action), (&State::Installed, Action::Wait));
        assert_eq!(state.on(Input::StickGone), (State::Installed, Action::Restart));
    }

    #[test]
    fn enter_counts_only_on_a_page_that_is_visible_for_a_while() {
        let disks = Input::Disks(vec![disk("sda", Fitness::Fits)]);
        for visible_ms in [None, Some(0), Some(VISIBLE_MS - 1)] {
            let (state, action) = after(&[disks.clone(), Input::Key { key: Key::Enter, visible_ms }]);
            assert!(matches!(state, State::Confirm { .. }) && action == Action::Wait, "{visible_ms:?}");
        }
    }

    #[test]
    fn what_an_earlier_unit_has_stays_unless_delete_is_pressed() {
        let mut inputs = vec![Input::Disks(vec![disk("sda", Fitness::HasUnit)]), key(Key::Enter)];
        assert_eq!(after(&inputs).1, Action::Install { stay: true });
        inputs.insert(1, key(Key::Delete));
        assert_eq!(after(&inputs).1, Action::Install { stay: false });
        inputs.insert(1, key(Key::Delete));
        assert_eq!(after(&inputs).1, Action::Install { stay: true });
    }

    #[test]
    fn one_of_several_disks_is_chosen_by_its_number() {
        let several = ["nvme0n1", "sda", "sdb"]
            .map(|name| disk(name, if name == "sda" { Fitness::OtherSectors } else { Fitness::Fits }));
        let disks = Input::Disks(several.to_vec());
        for wrong in [Key::Enter, Key::Delete, Key::Digit(0), Key::Digit(3), Key::Digit(9)] {
            let (state, action) = after(&[disks.clone(), key(wrong), key(Key::Enter)]);
            assert!(matches!(state, State::Choose { .. }) && action == Action::Wait, "{wrong:?}");
        }
        let (state, action) = after(&[disks.clone(), key(Key::Digit(2))]);
        assert!(matches!(&state, State::Confirm { disk, .. } if disk.name == "sdb") && action == Action::Wait);
        let (state, _) = state.on(Input::Disks(several[..1].to_vec()));
        assert!(matches!(&state, State::Confirm { disk, .. } if disk.name == "nvme0n1"), "the other was unplugged");
    }

    #[test]
    fn a_failure_is_shown_and_enter_asks_anew() {
        let disks = Input::Disks(vec![disk("sda", Fitness::Fits)]);
        let failed = [disks.clone(), key(Key::Enter)].into_iter();
        let (state, _) = failed.fold((State::Looking, Action::Wait), |(state, _), input| state.on(input));
        let (state, action) = state.on(Input::Ended(Err(Trouble::Stick)));
        assert!(matches!(state, State::Failed { trouble: Trouble::Stick, .. }) && action == Action::Wait);
        let (state, _) = state.on(Input::StickGone);
        let (state, _) = state.on(key(Key::Enter));
        assert_eq!(state.clone(), State::Looking);
        assert!(matches!(state.on(disks).0, State::Confirm { .. }));
    }

    fn inputs_without_enter() -> impl Strategy<Value = Vec<Input>> {
        let fitness = prop_oneof![
            Just(Fitness::Fits),
            Just(Fitness::HasUnit),
            Just(Fitness::OtherSectors),
            Just(Fitness::TooSmall)
        ];
        let disks =
            prop::collection::vec(fitness.prop_map(|fitness| disk("sda", fitness)), 0..3).prop_map(Input::Disks);
        let keys = prop_oneof![(0..10_u8).prop_map(Key::Digit), Just(Key::Delete)];
        let pressed = (keys, any::<Option<u64>>()).prop_map(|(key, visible_ms)| Input::Key { key, visible_ms });
        let too_early = (0..VISIBLE_MS).prop_map(|ms| Input::Key { key: Key::Enter, visible_ms: Some(ms) });
        let others = prop_oneof![Just(Input::Ended(Ok(()))), Just(Input::StickGone)];
        prop::collection::vec(prop_oneof![disks, pressed, too_early, others], 0..40)
    }

    proptest! {
        #[test]
        fn without_enter_nothing_is_ever_written(inputs in inputs_without_enter()) {
            after(&inputs);
        }
    }
}
