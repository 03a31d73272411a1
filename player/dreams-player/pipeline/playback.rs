//! What is on the glass and what happens to it next: the state machine of playback.
//!
//! Owns the states and the one function that changes them. Pure: no clock, no picture, no logging; which vblank
//! a frame is due at is `pacing.rs`, and `presenter.rs` carries the effects out.
//!
//! Start at the table of [`Playback::on`].

/// Where playback stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Playback {
    /// Nothing of ours is lit yet; what the boot left there still is.
    Dark,
    /// The first frame is on its way to the glass.
    Rising,
    /// A frame is lit and its time is not over.
    Lit(Next),
    /// A frame's successor is on its way to the glass.
    Flying,
    /// The lit frame is on its way to the glass once more.
    Relighting,
    /// The lit frame's time is over and its successor has not come: it stays lit.
    Holding,
    /// The screen is gone, and had a frame of ours lit or not. Nothing is decoded to nowhere.
    Away(LastLit),
    /// The run is over.
    Ended,
}

/// What follows the lit frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Next {
    /// Not decoded yet.
    Missing,
    /// Staged: one commit brings it to the glass.
    Staged,
    /// Nothing: this is the last frame of the run.
    Never,
}

/// What a screen had lit when it went away.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum LastLit {
    /// Nothing of ours.
    Nothing,
    /// A frame, to be lit again.
    Frame,
}

/// What may happen to playback.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Event {
    /// The next frame is here.
    Ready,
    /// There is no playable clip at all, for now.
    Barren,
    /// The run's last frame has been handed over.
    Finished,
    /// What was committed is on the glass.
    Flipped,
    /// The last vblank before the next frame is due has begun.
    Due,
    /// The lit frame has been held for so long that the screen should prove that it still flips.
    Stale,
    /// The screen is gone.
    Lost,
    /// The screen is back, with nothing lit.
    Back,
    /// The screen repaired itself: commits and requests are void.
    Recovered,
    /// Someone wants the run to end.
    Stop,
}

/// What is to be done about it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Effect {
    /// Nothing.
    Wait,
    /// Copy the next frame to the back buffer.
    Stage,
    /// Send what is staged to the glass.
    Commit,
    /// Copy the next frame to the back buffer and send it to the glass.
    Light,
    /// Copy the lit frame to the back buffer and send it to the glass.
    Relight,
    /// Draw the fault card and send it to the glass.
    LightFaultCard,
    /// Ask the screen to tell when the next frame is due, or for the next vblank if that is past.
    AwaitDue,
    /// The run is over.
    End,
}

impl Playback {
    /// The only place where playback changes state.
    ///
    /// ```text
    /// state         event      -> state         effect
    /// Dark          Ready      -> Rising        Light
    /// Dark          Barren     -> Rising        LightFaultCard
    /// Dark          Finished   -> Ended         End
    /// Dark          Lost       -> Away(Nothing) Wait
    /// Rising        Flipped    -> Lit(Missing)  AwaitDue
    /// Rising        Lost       -> Away(Nothing) Wait
    /// Rising        Recovered  -> Rising        Light
    /// Lit(Missing)  Ready      -> Lit(Staged)   Stage
    /// Lit(Missing)  Finished   -> Lit(Never)    Wait
    /// Lit(Missing)  Due        -> Holding       AwaitDue
    /// Lit(Missing)  Lost       -> Away(Frame)   Wait
    /// Lit(Missing)  Recovered  -> Lit(Missing)  AwaitDue
    /// Lit(Staged)   Due        -> Flying        Commit
    /// Lit(Staged)   Lost       -> Away(Frame)   Wait
    /// Lit(Staged)   Recovered  -> Lit(Missing)  AwaitDue
    /// Lit(Never)    Due        -> Ended         End
    /// Lit(Never)    Lost       -> Away(Frame)   Wait
    /// Lit(Never)    Recovered  -> Lit(Never)    AwaitDue
    /// Flying        Flipped    -> Lit(Missing)  AwaitDue
    /// Flying        Lost       -> Away(Frame)   Wait
    /// Flying        Recovered  -> Flying        Light
    /// Relighting    Flipped    -> Lit(Missing)  AwaitDue
    /// Relighting    Lost       -> Away(Frame)   Wait
    /// Relighting    Recovered  -> Relighting    Relight
    /// Holding       Ready      -> Flying        Light
    /// Holding       Finished   -> Ended         End
    /// Holding       Due        -> Holding       AwaitDue
    /// Holding       Stale      -> Relighting    Relight
    /// Holding       Lost       -> Away(Frame)   Wait
    /// Holding       Recovered  -> Holding       AwaitDue
    /// Away(Nothing) Back       -> Dark          Wait
    /// Away(Frame)   Back       -> Relighting    Relight
    /// any           Stop       -> Ended         End
    /// otherwise                -> unchanged     Wait
    /// ```
    #[expect(clippy::match_same_arms, reason = "the arms stand in the order of the table")]
    pub(crate) fn on(self, event: Event) -> (Self, Effect) {
        use Effect::{AwaitDue, Commit, End, Light, LightFaultCard, Relight, Stage, Wait};
        use Event::{Back, Barren, Due, Finished, Flipped, Lost, Ready, Recovered, Stale, Stop};
        use Next::{Missing, Never, Staged};
        use Playback::{Away, Dark, Ended, Flying, Holding, Lit, Relighting, Rising};
        match (self, event) {
            (Dark, Ready) => (Rising, Light),
            (Dark, Barren) => (Rising, LightFaultCard),
            (Dark | Holding, Finished) | (Lit(Never), Due) => (Ended, End),
            (Dark | Rising, Lost) => (Away(LastLit::Nothing), Wait),
            (Rising | Flying | Relighting, Flipped) => (Lit(Missing), AwaitDue),
            (Rising, Recovered) => (Rising, Light),
            (Lit(Missing), Ready) => (Lit(Staged), Stage),
            (Lit(Missing), Finished) => (Lit(Never), Wait),
            (Lit(Missing) | Holding, Due) => (Holding, AwaitDue),
            (Lit(_) | Flying | Relighting | Holding, Lost) => (Away(LastLit::Frame), Wait),
            (Lit(Missing | Staged), Recovered) => (Lit(Missing), AwaitDue),
            (Lit(Staged), Due) => (Flying, Commit),
            (Lit(Never), Recovered) => (Lit(Never), AwaitDue),
            (Flying, Recovered) | (Holding, Ready) => (Flying, Light),
            (Relighting, Recovered) | (Holding, Stale) | (Away(LastLit::Frame), Back) => (Relighting, Relight),
            (Holding, Recovered) => (Holding, AwaitDue),
            (Away(LastLit::Nothing), Back) => (Dark, Wait),
            (Dark | Rising | Lit(_) | Flying | Relighting | Holding | Away(_) | Ended, Stop) => (Ended, End),
            // Late or early news: a vblank asked for before a commit, a flip of a commit that was void, a screen
            // that says twice that it is gone.
            (Dark, Flipped | Due | Stale | Back | Recovered)
            | (Rising | Flying | Relighting, Ready | Barren | Finished | Due | Stale | Back)
            | (Lit(_), Barren | Flipped | Stale | Back)
            | (Lit(Staged | Never), Ready | Finished)
            | (Holding, Barren | Flipped | Back)
            | (Away(_), Ready | Barren | Finished | Flipped | Due | Stale | Lost | Recovered)
            | (Ended, Ready | Barren | Finished | Flipped | Due | Stale | Lost | Back | Recovered) => (self, Wait),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Effect, Event, LastLit, Next, Playback};
    use std::fmt::Write;

    const STATES: [Playback; 11] = [
        Playback::Dark,
        Playback::Rising,
        Playback::Lit(Next::Missing),
        Playback::Lit(Next::Staged),
        Playback::Lit(Next::Never),
        Playback::Flying,
        Playback::Relighting,
        Playback::Holding,
        Playback::Away(LastLit::Nothing),
        Playback::Away(LastLit::Frame),
        Playback::Ended,
    ];
    const EVENTS: [Event; 9] = [
        Event::Ready,
        Event::Barren,
        Event::Finished,
        Event::Flipped,
        Event::Due,
        Event::Stale,
        Event::Lost,
        Event::Back,
        Event::Recovered,
    ];

    #[test]
    fn the_table_in_the_documentation_is_the_machine() {
        let mut table = String::new();
        for state in STATES {
            for event in EVENTS {
                let (after, effect) = state.on(event);
                if (after, effect) != (state, Effect::Wait) {
                    let (state, event, after) = (format!("{state:?}"), format!("{event:?}"), format!("{after:?}"));
                    writeln!(table, "    /// {state:13} {event:10} -> {after:13} {effect:?}").unwrap();
                }
            }
            assert_eq!(state.on(Event::Stop), (Playback::Ended, Effect::End));
        }
        table += "    /// any           Stop       -> Ended         End\n";
        let documented = include_str!("playback.rs")
            .split("    /// state         event      -> state         effect\n")
            .nth(1)
            .and_then(|rest| rest.split("    /// otherwise").next())
            .expect("the table stands in the documentation of `on`");
        assert_eq!(documented, table, "the machine prints:\n{table}");
    }

    #[test]
    fn once_a_frame_is_lit_nothing_but_a_lost_screen_or_the_end_takes_it_away() {
        let mut seen = vec![Playback::Lit(Next::Missing)];
        let mut at = 0;
        while let Some(&state) = seen.get(at) {
            for event in EVENTS {
                let (after, effect) = state.on(event);
                assert!(!matches!(after, Playback::Dark | Playback::Rising), "{state:?} {event:?}");
                assert_ne!(effect, Effect::LightFaultCard, "{state:?} {event:?}");
                if !seen.contains(&after) {
                    seen.push(after);
                }
            }
            at += 1;
        }
    }

    #[test]
    fn a_screen_that_comes_back_shows_the_last_frame_again() {
        for state in STATES {
            let (away, _) = state.on(Event::Lost);
            if away == Playback::Away(LastLit::Frame) {
                assert_eq!(away.on(Event::Back), (Playback::Relighting, Effect::Relight));
            }
        }
    }
}
