//! The mode of the display under the frames: a state machine of its own, since it changes while any frame is lit.
//!
//! Owns the states and the one function that changes them. Pure: `presenter.rs` asks the screen for its mode, and fits the
//! pace to it. Never knows a frame: that is `playback.rs`.
//!
//! Start at the table of [`Glass::on`].

/// The display's mode `M`, as it is or was before the display went away.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) enum Glass<M> {
    /// There was no display yet.
    #[default]
    Unseen,
    /// It is this.
    Steady(M),
    /// It is this, and may be another with the next frame.
    Changing(M),
}

/// What may happen to the mode.
#[derive(Clone, Debug)]
pub(crate) enum Event<M> {
    /// The display is there, again or for the first time, with this mode.
    Seen(M),
    /// With the next frame the pictures or the display have another form.
    Changed,
    /// The next frame is on the glass, with this mode.
    Arrived(M),
}

impl<M> Glass<M> {
    /// The only place where the mode changes. Here `m` and `n` are modes.
    ///
    /// ```text
    /// state       event      -> state
    /// Unseen      Seen(n)    -> Steady(n)
    /// Steady(m)   Seen(n)    -> Steady(n)
    /// Steady(m)   Changed    -> Changing(m)
    /// Changing(m) Seen(n)    -> Changing(n)
    /// Changing(m) Arrived(n) -> Steady(n)
    /// otherwise              -> unchanged
    /// ```
    #[must_use]
    pub(crate) fn on(self, event: Event<M>) -> Self {
        match (self, event) {
            (Self::Unseen | Self::Steady(_), Event::Seen(mode)) | (Self::Changing(_), Event::Arrived(mode)) => {
                Self::Steady(mode)
            }
            (Self::Steady(mode), Event::Changed) | (Self::Changing(_), Event::Seen(mode)) => Self::Changing(mode),
            (glass @ Self::Unseen, Event::Changed | Event::Arrived(_))
            | (glass @ Self::Steady(_), Event::Arrived(_))
            | (glass @ Self::Changing(_), Event::Changed) => glass,
        }
    }

    /// The mode; `None` before the first display.
    pub(crate) fn mode(&self) -> Option<&M> {
        match self {
            Self::Unseen => None,
            Self::Steady(mode) | Self::Changing(mode) => Some(mode),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Event, Glass};
    use std::fmt::Write;

    #[test]
    fn the_table_in_the_documentation_is_the_glass() {
        let mut table = String::new();
        for before in [Glass::Unseen, Glass::Steady('m'), Glass::Changing('m')] {
            for event in [Event::Seen('n'), Event::Changed, Event::Arrived('n')] {
                let after = before.clone().on(event.clone());
                if after != before {
                    let [before, event] =
                        [format!("{before:?}"), format!("{event:?}")].map(|name| name.replace('\'', ""));
                    writeln!(table, "    /// {before:11} {event:10} -> {after:?}").unwrap();
                }
            }
        }
        let documented = include_str!("glass.rs").split("    /// state       event      -> state\n").nth(1);
        let documented = documented.and_then(|rest| rest.split("    /// otherwise").next()).expect("the table of `on`");
        assert_eq!(documented, table.replace('\'', ""), "the machine prints:\n{table}");
    }
}
