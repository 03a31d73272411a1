//! What is on the glass and what happens to it next: the state machine of playback.
//!
//! Owns the states, the frames that live in them, and the one function that changes them. Pure: no clock, no picture, no
//! logging; which vblank a frame is due at is `pacing.rs`, and `presenter.rs` carries the effects out.
//!
//! Start at the table of [`Playback::on`].

/// Where playback stands: with frames `F`, and with `A`, why the screen is away.
#[derive(Debug, PartialEq, Eq)]
pub(crate) enum Playback<F, A> {
    /// Nothing of ours is lit yet; what the boot left there still is.
    Dark,
    /// The first frame is on its way to the glass.
    Rising(F),
    /// A frame is lit and its time is not over.
    Lit(F, Next<F>),
    /// A frame is lit, and its successor is on its way to the glass.
    Flying(F, F),
    /// The screen was away: the frame that it had shown is on its way to the glass once more.
    Relighting(F, Next<F>),
    /// The lit frame is on its way to the glass once more, to prove that the screen still flips.
    Proving(F),
    /// The lit frame's time is over and its successor has not come: it stays lit.
    Holding(F),
    /// The screen is gone, or black. Nothing is decoded to nowhere.
    Away(Kept<F>, A),
    /// The run is over; this frame was lit last.
    Ended(Option<F>, Ending),
}

/// What follows the lit frame.
#[derive(Debug, PartialEq, Eq)]
pub(crate) enum Next<F> {
    /// Not decoded yet.
    Missing,
    /// This frame. In [`Playback::Lit`] it is staged: one commit brings it to the glass.
    Here(F),
    /// Nothing: this is the last frame of the run.
    Never,
}

/// What a screen showed when it went away, and what follows.
#[derive(Debug, PartialEq, Eq)]
pub(crate) enum Kept<F> {
    /// Nothing of ours.
    Nothing,
    /// Nothing of ours, and the first frame was on its way.
    First(F),
    /// A frame, to be shown again.
    Shown(F, Next<F>),
}

/// How a run ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Ending {
    /// The source has no more.
    Finished,
    /// Someone wanted it.
    Stopped,
}

/// What may happen to playback.
#[derive(Debug, PartialEq, Eq)]
pub(crate) enum Event<F, A> {
    /// The next frame is here.
    Ready(F),
    /// There is no playable clip at all, for now; this fault card says so.
    Barren(F),
    /// The run's last frame has been handed over.
    Finished,
    /// What was committed is on the glass.
    Flipped,
    /// A vblank has begun that the screen was asked for.
    Vblank,
    /// The screen has been silent for long: ask again, lest the request was lost.
    Idle,
    /// The last vblank before the next frame is due has begun.
    Due,
    /// The lit frame has been held for so long that the screen should prove that it still flips.
    Stale,
    /// The screen is gone, or black, for this reason.
    Lost(A),
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
    /// Ask the screen for an event at the lit frame's last vblank, unless that has begun.
    AwaitDue,
    /// The same, and copy the next frame to the back buffer.
    AwaitDueAndStage,
    /// The same, and look whether the next frame is here.
    AwaitDueAndLook,
    /// Ask the screen for an event at the next vblank.
    AwaitVblank,
    /// The same, and look whether the next frame is here.
    AwaitVblankAndLook,
    /// Look whether the next frame is here. If not, the lit one is stale, or the next vblank is awaited.
    LookOrAwaitVblank,
    /// The run is over.
    End,
}

impl<F, A> Playback<F, A> {
    /// The only place where playback changes state. Here `a`, `b` and `c` are frames, and `x` and `y` say why.
    ///
    /// ```text
    /// state                      event     -> state                     effect
    /// Dark                       Ready(c)  -> Rising(c)                 Light
    /// Dark                       Barren(c) -> Rising(c)                 Light
    /// Dark                       Finished  -> Ended(None, Finished)     End
    /// Dark                       Lost(y)   -> Away(Nothing, y)          Wait
    /// Rising(a)                  Flipped   -> Lit(a, Missing)           AwaitDueAndLook
    /// Rising(a)                  Lost(y)   -> Away(First(a), y)         Wait
    /// Rising(a)                  Recovered -> Rising(a)                 Light
    /// Lit(a, Missing)            Ready(c)  -> Lit(a, Here(c))           Stage
    /// Lit(a, Missing)            Finished  -> Lit(a, Never)             Wait
    /// Lit(a, Missing)            Vblank    -> Lit(a, Missing)           AwaitDueAndLook
    /// Lit(a, Missing)            Idle      -> Lit(a, Missing)           AwaitDue
    /// Lit(a, Missing)            Due       -> Holding(a)                AwaitVblank
    /// Lit(a, Missing)            Lost(y)   -> Away(Shown(a, Missing), y) Wait
    /// Lit(a, Missing)            Recovered -> Lit(a, Missing)           AwaitDueAndLook
    /// Lit(a, Here(b))            Vblank    -> Lit(a, Here(b))           AwaitDue
    /// Lit(a, Here(b))            Idle      -> Lit(a, Here(b))           AwaitDue
    /// Lit(a, Here(b))            Due       -> Flying(a, b)              Commit
    /// Lit(a, Here(b))            Lost(y)   -> Away(Shown(a, Here(b)), y) Wait
    /// Lit(a, Here(b))            Recovered -> Lit(a, Here(b))           AwaitDueAndStage
    /// Lit(a, Never)              Vblank    -> Lit(a, Never)             AwaitDue
    /// Lit(a, Never)              Idle      -> Lit(a, Never)             AwaitDue
    /// Lit(a, Never)              Due       -> Ended(Some(a), Finished)  End
    /// Lit(a, Never)              Lost(y)   -> Away(Shown(a, Never), y)  Wait
    /// Lit(a, Never)              Recovered -> Lit(a, Never)             AwaitDue
    /// Flying(a, b)               Flipped   -> Lit(b, Missing)           AwaitDueAndLook
    /// Flying(a, b)               Lost(y)   -> Away(Shown(a, Here(b)), y) Wait
    /// Flying(a, b)               Recovered -> Flying(a, b)              Light
    /// Relighting(a, Missing)     Flipped   -> Lit(a, Missing)           AwaitDueAndLook
    /// Relighting(a, Missing)     Lost(y)   -> Away(Shown(a, Missing), y) Wait
    /// Relighting(a, Missing)     Recovered -> Relighting(a, Missing)    Relight
    /// Relighting(a, Here(b))     Flipped   -> Lit(a, Here(b))           AwaitDueAndStage
    /// Relighting(a, Here(b))     Lost(y)   -> Away(Shown(a, Here(b)), y) Wait
    /// Relighting(a, Here(b))     Recovered -> Relighting(a, Here(b))    Relight
    /// Relighting(a, Never)       Flipped   -> Lit(a, Never)             AwaitDue
    /// Relighting(a, Never)       Lost(y)   -> Away(Shown(a, Never), y)  Wait
    /// Relighting(a, Never)       Recovered -> Relighting(a, Never)      Relight
    /// Proving(a)                 Flipped   -> Lit(a, Missing)           AwaitDueAndLook
    /// Proving(a)                 Lost(y)   -> Away(Shown(a, Missing), y) Wait
    /// Proving(a)                 Recovered -> Proving(a)                Relight
    /// Holding(a)                 Ready(c)  -> Flying(a, c)              Light
    /// Holding(a)                 Finished  -> Ended(Some(a), Finished)  End
    /// Holding(a)                 Vblank    -> Holding(a)                LookOrAwaitVblank
    /// Holding(a)                 Idle      -> Holding(a)                AwaitVblank
    /// Holding(a)                 Stale     -> Proving(a)                Relight
    /// Holding(a)                 Lost(y)   -> Away(Shown(a, Missing), y) Wait
    /// Holding(a)                 Recovered -> Holding(a)                AwaitVblankAndLook
    /// Away(Nothing, x)           Lost(y)   -> Away(Nothing, y)          Wait
    /// Away(Nothing, x)           Back      -> Dark                      Wait
    /// Away(First(a), x)          Lost(y)   -> Away(First(a), y)         Wait
    /// Away(First(a), x)          Back      -> Rising(a)                 Light
    /// Away(Shown(a, Missing), x) Lost(y)   -> Away(Shown(a, Missing), y) Wait
    /// Away(Shown(a, Missing), x) Back      -> Relighting(a, Missing)    Relight
    /// Away(Shown(a, Here(b)), x) Lost(y)   -> Away(Shown(a, Here(b)), y) Wait
    /// Away(Shown(a, Here(b)), x) Back      -> Relighting(a, Here(b))    Relight
    /// Away(Shown(a, Never), x)   Lost(y)   -> Away(Shown(a, Never), y)  Wait
    /// Away(Shown(a, Never), x)   Back      -> Relighting(a, Never)      Relight
    /// any but Ended              Stop      -> Ended                     End
    /// otherwise                            -> unchanged                 Wait
    /// ```
    #[expect(clippy::match_same_arms, reason = "the arms stand in the order of the table")]
    pub(crate) fn on(self, event: Event<F, A>) -> (Self, Effect) {
        use Effect::{
            AwaitDue, AwaitDueAndLook, AwaitDueAndStage, AwaitVblank, AwaitVblankAndLook, Commit, End, Light,
            LookOrAwaitVblank, Relight, Stage, Wait,
        };
        use Event::{Back, Barren, Due, Finished, Flipped, Idle, Lost, Ready, Recovered, Stale, Stop, Vblank};
        use Next::{Here, Missing, Never};
        use Playback::{Away, Dark, Ended, Flying, Holding, Lit, Proving, Relighting, Rising};
        match (self, event) {
            (Dark, Ready(first) | Barren(first)) => (Rising(first), Light),
            (Dark, Finished) => (Ended(None, Ending::Finished), End),
            (Dark, Lost(why)) => (Away(Kept::Nothing, why), Wait),
            (Rising(first), Lost(why)) => (Away(Kept::First(first), why), Wait),
            (Rising(first), Recovered) => (Rising(first), Light),
            (Rising(shown) | Flying(_, shown) | Relighting(shown, Missing) | Proving(shown), Flipped)
            | (Lit(shown, Missing), Vblank | Recovered) => (Lit(shown, Missing), AwaitDueAndLook),
            (Lit(shown, Missing), Ready(next)) => (Lit(shown, Here(next)), Stage),
            (Lit(shown, Missing), Finished) => (Lit(shown, Never), Wait),
            (Lit(shown, Missing), Due) | (Holding(shown), Idle) => (Holding(shown), AwaitVblank),
            (Lit(shown, Here(next)), Due) => (Flying(shown, next), Commit),
            (Lit(shown, Here(next)), Recovered) | (Relighting(shown, Here(next)), Flipped) => {
                (Lit(shown, Here(next)), AwaitDueAndStage)
            }
            (Lit(shown, Never), Due) | (Holding(shown), Finished) => (Ended(Some(shown), Ending::Finished), End),
            (Lit(shown, Never), Recovered) | (Relighting(shown, Never), Flipped) => (Lit(shown, Never), AwaitDue),
            (Lit(shown, next @ (Here(_) | Never)), Vblank) | (Lit(shown, next), Idle) => (Lit(shown, next), AwaitDue),
            (Lit(shown, next) | Relighting(shown, next), Lost(why)) => (Away(Kept::Shown(shown, next), why), Wait),
            (Flying(shown, next), Lost(why)) => (Away(Kept::Shown(shown, Here(next)), why), Wait),
            (Flying(shown, next), Recovered) | (Holding(shown), Ready(next)) => (Flying(shown, next), Light),
            (Relighting(shown, next), Recovered) => (Relighting(shown, next), Relight),
            (Proving(shown), Recovered) | (Holding(shown), Stale) => (Proving(shown), Relight),
            (Proving(shown) | Holding(shown), Lost(why)) => (Away(Kept::Shown(shown, Missing), why), Wait),
            (Holding(shown), Vblank) => (Holding(shown), LookOrAwaitVblank),
            (Holding(shown), Recovered) => (Holding(shown), AwaitVblankAndLook),
            (Away(kept, _), Lost(why)) => (Away(kept, why), Wait),
            (Away(Kept::Nothing, _), Back) => (Dark, Wait),
            (Away(Kept::First(first), _), Back) => (Rising(first), Light),
            (Away(Kept::Shown(shown, next), _), Back) => (Relighting(shown, next), Relight),
            (Dark | Rising(_) | Away(Kept::Nothing | Kept::First(_), _), Stop) => (Ended(None, Ending::Stopped), End),
            // After the run's last frame no end is before the time.
            (Lit(shown, Never) | Relighting(shown, Never) | Away(Kept::Shown(shown, Never), _), Stop) => {
                (Ended(Some(shown), Ending::Finished), End)
            }
            (
                Lit(shown, Missing | Here(_))
                | Flying(shown, _)
                | Relighting(shown, Missing | Here(_))
                | Proving(shown)
                | Holding(shown)
                | Away(Kept::Shown(shown, Missing | Here(_)), _),
                Stop,
            ) => (Ended(Some(shown), Ending::Stopped), End),
            // Late or early news: a vblank asked for before a commit, a flip of a commit that was void, a screen
            // that says twice that it is back.
            (state @ Dark, Flipped | Vblank | Idle | Due | Stale | Back | Recovered)
            | (
                state @ (Rising(_) | Flying(..) | Relighting(..) | Proving(_)),
                Ready(_) | Barren(_) | Finished | Vblank | Idle | Due | Stale | Back,
            )
            | (state @ Lit(..), Barren(_) | Flipped | Stale | Back)
            | (state @ Lit(_, Here(_) | Never), Ready(_) | Finished)
            | (state @ Holding(_), Barren(_) | Flipped | Due | Back)
            | (state @ Away(..), Ready(_) | Barren(_) | Finished | Flipped | Vblank | Idle | Due | Stale | Recovered)
            | (
                state @ Ended(..),
                Ready(_) | Barren(_) | Finished | Flipped | Vblank | Idle | Due | Stale | Lost(_) | Back | Recovered
                | Stop,
            ) => (state, Wait),
        }
    }

    /// The frame that is lit, or was when the screen went away.
    pub(crate) fn shown(&self) -> Option<&F> {
        match self {
            Self::Lit(shown, _)
            | Self::Flying(shown, _)
            | Self::Relighting(shown, _)
            | Self::Proving(shown)
            | Self::Holding(shown)
            | Self::Away(Kept::Shown(shown, _), _) => Some(shown),
            Self::Ended(last, _) => last.as_ref(),
            Self::Dark | Self::Rising(_) | Self::Away(Kept::Nothing | Kept::First(_), _) => None,
        }
    }

    /// The frame that is staged, or on its way to the glass for the first time.
    pub(crate) fn coming(&self) -> Option<&F> {
        match self {
            Self::Rising(next) | Self::Lit(_, Next::Here(next)) | Self::Flying(_, next) => Some(next),
            Self::Lit(_, Next::Missing | Next::Never) | Self::Relighting(..) | Self::Proving(_) | Self::Holding(_) => {
                None
            }
            Self::Dark | Self::Away(..) | Self::Ended(..) => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Effect, Ending, Event, Kept, Next, Playback};
    use proptest::prelude::*;
    use std::fmt::{self, Write};

    /// A frame or a reason, as the table names it.
    #[derive(Clone, Copy, PartialEq, Eq)]
    struct Name(char);

    const A: Name = Name('a');
    const B: Name = Name('b');
    const X: Name = Name('x');

    impl fmt::Debug for Name {
        fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            f.write_char(self.0)
        }
    }

    fn states() -> Vec<Playback<Name, Name>> {
        let next = || [Next::Missing, Next::Here(B), Next::Never];
        let mut states = vec![Playback::Dark, Playback::Rising(A)];
        states.extend(next().map(|next| Playback::Lit(A, next)));
        states.push(Playback::Flying(A, B));
        states.extend(next().map(|next| Playback::Relighting(A, next)));
        states.extend([Playback::Proving(A), Playback::Holding(A)]);
        states.extend([Kept::Nothing, Kept::First(A)].map(|kept| Playback::Away(kept, X)));
        states.extend(next().map(|next| Playback::Away(Kept::Shown(A, next), X)));
        states.push(Playback::Ended(Some(A), Ending::Finished));
        states
    }

    /// All but the wish that it ends.
    fn events<T>(next: T, card: T, why: T) -> Vec<Event<T, T>> {
        use Event::{Back, Barren, Due, Finished, Flipped, Idle, Lost, Ready, Recovered, Stale, Vblank};
        vec![Ready(next), Barren(card), Finished, Flipped, Vblank, Idle, Due, Stale, Lost(why), Back, Recovered]
    }

    #[test]
    fn the_table_in_the_documentation_is_the_machine() {
        let mut table = String::new();
        for at in 0..states().len() {
            let state = || states().swap_remove(at);
            for event in events(Name('c'), Name('c'), Name('y')) {
                let name = format!("{event:?}");
                let (after, effect) = state().on(event);
                if (&after, effect) != (&state(), Effect::Wait) {
                    let (state, after) = (format!("{:?}", state()), format!("{after:?}"));
                    writeln!(table, "    /// {state:26} {name:9} -> {after:25} {effect:?}").unwrap();
                }
            }
            let is_over = matches!(state(), Playback::Ended(..));
            assert_eq!(matches!(state().on(Event::Stop), (Playback::Ended(..), Effect::End)), !is_over);
        }
        let documented = include_str!("playback.rs")
            .split("    /// state                      event     -> state                     effect\n")
            .nth(1)
            .and_then(|rest| rest.split("    /// any but Ended").next())
            .expect("the table stands in the documentation of `on`");
        assert_eq!(documented, table, "the machine prints:\n{table}");
    }

    proptest! {
        /// Frames have numbers from 1. A frame comes, flips and is due most of the time, and all else happens now and then.
        #[test]
        fn once_a_frame_is_lit_nothing_but_a_lost_screen_or_the_end_takes_it_away(
            happenings in prop::collection::vec(prop_oneof![6 => prop_oneof![Just(0), Just(3), Just(6)], 1 => 0..11usize], 1..400),
        ) {
            use Playback::{Away, Dark, Flying, Holding, Lit, Proving, Relighting, Rising};
            let is_under_way = |playback: &_| matches!(playback, Rising(_) | Flying(..) | Relighting(..) | Proving(_));
            let (mut playback, mut given, mut lit) = (Dark, 0, 0);
            for at in happenings {
                let event = events(given + 1, given + 1, 0).swap_remove(at);
                let is_looking = matches!(playback, Dark | Lit(_, Next::Missing) | Holding(_));
                if matches!(event, Event::Ready(_) | Event::Barren(_)) {
                    if !is_looking {
                        continue;
                    }
                    given += u32::from(playback == Dark || matches!(event, Event::Ready(_)));
                }
                if event == Event::Flipped && matches!(playback, Rising(_) | Flying(..)) {
                    lit += 1;
                    prop_assert_eq!(playback.coming(), Some(&lit), "none is left out, none comes twice");
                }
                let (was_under_way, was_away) = (is_under_way(&playback), matches!(playback, Away(..)));
                let (is_lost, is_void) = (matches!(event, Event::Lost(_)), event == Event::Recovered);
                let (after, effect) = playback.on(event);
                prop_assert_eq!(after.shown().copied().unwrap_or(0), lit);
                prop_assert!(is_lost || was_away || !matches!(after, Away(..)));
                let is_commit = matches!(effect, Effect::Commit | Effect::Light | Effect::Relight);
                prop_assert_eq!(is_commit, is_under_way(&after) && (!was_under_way || is_void), "{:?}", after);
                playback = after;
            }
        }
    }

    #[test]
    fn a_screen_that_comes_back_shows_the_last_frame_again() {
        for state in states().into_iter().filter(|state| *state != Playback::Ended(Some(A), Ending::Finished)) {
            let (away, back) = (state.shown().copied(), state.on(Event::Lost(X)).0.on(Event::Back));
            let is_lit_again = matches!(back, (Playback::Relighting(shown, _), Effect::Relight) if away == Some(shown));
            assert!(is_lit_again || away.is_none(), "{back:?}");
        }
    }
}
