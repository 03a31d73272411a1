//! The power of the display itself, where the owner has set that it is switched by DDC/CI or by HDMI-CEC.
//!
//! Owns the order: at night the display is asked to switch off while it still has a signal, then the signal goes off; in the
//! morning the signal comes back, and the display is asked until it is on, or for a limit of tries. A display that does not
//! follow has lost nothing: the signal goes off and on in time all the same. Displays answer slowly, so a thread asks them.
//! Never switches the signal: the flip thread does, by what [`DisplayPower::look`] returns.
//!
//! Start at [`Stage::on`].

use diagnostics::chain;
use player::{ThreadError, hold, threads};
use screen::{ConnectorId, PowerError, PowerMeans, switch_display};
use settings::hours::Lighting;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex};
use std::time::Duration;
use timing::Nanos;
use tracing::{info, warn};

/// How long the signal stays for a display that was asked to switch off and does not answer.
const PATIENCE: Duration = Duration::from_secs(10);
/// Between two tries, and before the first one to switch on: displays take some seconds to wake.
const PAUSE: Duration = Duration::from_secs(1);
/// Tries to switch off, and on.
const TRIES_OFF: u32 = 3;
const TRIES_ON: u32 = 20;

/// What a display is asked.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Request {
    means: PowerMeans,
    is_on: bool,
}

/// What became of the newest request.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct PowerAnswer {
    pub(crate) means: PowerMeans,
    /// Whether the display was asked to switch on.
    pub(crate) is_on: bool,
    /// Why the display has not done so; `None` if it has.
    pub(crate) error: Option<String>,
    /// Of which request.
    number: u64,
}

/// The answer to the newest request, for the control and for people.
#[derive(Debug, Default)]
pub(crate) struct PowerAnswers(Mutex<Option<PowerAnswer>>);

impl PowerAnswers {
    /// `None` before the first.
    pub(crate) fn newest(&self) -> Option<PowerAnswer> {
        hold(&self.0).clone()
    }
}

/// Where the power of the display stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stage {
    /// It is to be switched on: as it was switched off, if that is known.
    Waking { by: Option<PowerMeans> },
    /// It is on.
    Day,
    /// It was asked to switch off, at this time; the signal stays until it has answered.
    Leaving { by: PowerMeans, since: Nanos },
    /// The signal is off.
    Night { by: Option<PowerMeans> },
}

/// What is so at one look.
#[derive(Clone, Copy, Debug)]
struct Look {
    /// The signal is to be off.
    is_night: bool,
    /// How the owner wants the display to be switched.
    means: Option<PowerMeans>,
    /// Where the display is plugged in is known.
    has_connector: bool,
    /// The newest request is answered.
    is_answered: bool,
    now: Nanos,
}

impl Stage {
    /// The only place where the stage changes. Returns what the display is asked besides.
    fn on(self, look: Look) -> (Self, Option<Request>) {
        let means = look.means.filter(|_| look.has_connector);
        match (self, look.is_night) {
            (Self::Waking { .. } | Self::Day, true) => match means {
                Some(means) => (Self::Leaving { by: means, since: look.now }, Some(Request { means, is_on: false })),
                None => (Self::Night { by: None }, None),
            },
            (Self::Leaving { by, since }, true) => {
                let is_over = look.is_answered || u128::from(look.now.since(since)) >= PATIENCE.as_nanos();
                (if is_over { Self::Night { by: Some(by) } } else { self }, None)
            }
            (Self::Leaving { by: means, .. }, false) => (Self::Day, Some(Request { means, is_on: true })),
            (Self::Night { .. }, true) | (Self::Day, false) => (self, None),
            (Self::Night { by } | Self::Waking { by }, false) => match by.or(look.means) {
                Some(means) if look.has_connector => (Self::Day, Some(Request { means, is_on: true })),
                Some(_) => (Self::Waking { by }, None),
                None => (Self::Day, None),
            },
        }
    }
}

/// The control of the power, as a part of the thread that looks at hours and brightness.
pub(crate) struct DisplayPower {
    stage: Stage,
    /// The connector that was lit last: a display that sleeps may seem to be unplugged.
    connector: Option<ConnectorId>,
    /// How the display was to be before the night.
    day: Lighting,
    requests: Sender<(Request, ConnectorId, u64)>,
    answers: Arc<PowerAnswers>,
    number: u64,
}

impl DisplayPower {
    /// Starts the thread that asks displays, and gives their `answers`. A run that begins by day switches the display on: it
    /// may be off since an earlier run.
    pub(crate) fn start(answers: Arc<PowerAnswers>) -> Result<Self, ThreadError> {
        let (requests, inbox) = channel();
        let given = Arc::clone(&answers);
        threads::start("display power", move || answer_all(&inbox, &given, PAUSE, switch))?;
        let stage = Stage::Waking { by: None };
        Ok(Self { stage, connector: None, day: Lighting::FULL, requests, answers, number: 0 })
    }

    /// What the signal is to be now, where the owner wants it to be `wanted` and the display to be switched by `means`. `lit`
    /// is where a display is lit.
    pub(crate) fn look(
        &mut self,
        wanted: Lighting,
        means: Option<PowerMeans>,
        lit: Option<ConnectorId>,
        now: Nanos,
    ) -> Lighting {
        self.connector = lit.or_else(|| self.connector.take());
        let (is_night, has_connector) = (wanted == Lighting::Off, self.connector.is_some());
        let is_answered = self.answers.newest().is_some_and(|answer| answer.number == self.number);
        let (stage, request) = self.stage.on(Look { is_night, means, has_connector, is_answered, now });
        self.stage = stage;
        if let (Some(request), Some(connector)) = (request, &self.connector) {
            self.number += 1;
            // If the thread is gone it has panicked, which was logged.
            self.requests.send((request, connector.clone(), self.number)).ok();
        }
        if matches!(self.stage, Stage::Leaving { .. }) {
            return self.day;
        }
        if !is_night {
            self.day = wanted;
        }
        wanted
    }
}

fn switch(request: &Request, connector: &ConnectorId) -> Result<(), PowerError> {
    switch_display(request.means, connector, request.is_on)
}

/// Asks the display for what is in the `inbox`, with `pause` between the tries, until the sender is gone. A newer request
/// ends an older one.
fn answer_all(
    inbox: &Receiver<(Request, ConnectorId, u64)>,
    answers: &PowerAnswers,
    pause: Duration,
    mut switch: impl FnMut(&Request, &ConnectorId) -> Result<(), PowerError>,
) {
    let mut known = None;
    let mut next = inbox.recv().ok();
    while let Some((request, connector, number)) = next.take() {
        let mut tries = if request.is_on { TRIES_ON } else { TRIES_OFF };
        let mut outcome = Ok(());
        if request.is_on {
            next = inbox.recv_timeout(pause).ok();
        }
        while next.is_none() && tries > 0 {
            outcome = switch(&request, &connector);
            tries = if outcome.is_ok() { 0 } else { tries - 1 };
            if tries > 0 {
                next = inbox.recv_timeout(pause).ok();
            }
        }
        let error = outcome.err().map(|error| chain(&error));
        if next.is_none() {
            report(&request, error.as_deref(), &mut known);
            *hold(&answers.0) = Some(PowerAnswer { means: request.means, is_on: request.is_on, error, number });
            next = inbox.recv().ok();
        }
    }
}

/// Logs what is news: an error that is not the `known` one, and that there is none any more.
fn report(request: &Request, error: Option<&str>, known: &mut Option<String>) {
    let Request { means, is_on } = request;
    match error {
        Some(error) if known.as_deref() != Some(error) => {
            warn!(%means, is_on, error, "cannot switch the display; its signal goes off and on all the same");
        }
        None if known.is_some() => info!(%means, is_on, "the display is switched again"),
        Some(_) | None => {}
    }
    *known = error.map(str::to_owned);
}

#[cfg(test)]
mod tests {
    use super::{
        DisplayPower, Look, PATIENCE, PowerAnswer, PowerAnswers, Request, Stage, TRIES_OFF, TRIES_ON, answer_all, hold,
    };
    use screen::{ConnectorId, PowerError, PowerMeans};
    use settings::hours::Lighting;
    use std::sync::Arc;
    use std::sync::mpsc::channel;
    use std::thread;
    use std::time::Duration;
    use timing::Nanos;

    const BY: PowerMeans = PowerMeans::Ddc;
    const DAY: Lighting = Lighting::On { thousandths: 300 };

    fn connector() -> ConnectorId {
        ConnectorId { card: "/dev/dri/card0".into(), name: "HDMI-A-1".to_owned() }
    }

    fn look(is_night: bool, means: Option<PowerMeans>) -> Look {
        Look { is_night, means, has_connector: true, is_answered: false, now: Nanos(5) }
    }

    #[test]
    fn every_stage_goes_where_the_hours_and_the_answers_lead() {
        let (on, off) = (Some(Request { means: BY, is_on: true }), Some(Request { means: BY, is_on: false }));
        let (day, night) = (look(false, Some(BY)), look(true, Some(BY)));
        let late = Look { now: Nanos(5 + PATIENCE.as_nanos() as u64), ..night };
        let leaving = Stage::Leaving { by: BY, since: Nanos(5) };
        let (by_it, by_nothing) = (Stage::Night { by: Some(BY) }, Stage::Night { by: None });
        let begun = Stage::Waking { by: None };
        for (before, look, after, asked) in [
            (begun, day, Stage::Day, on.clone()),
            (begun, Look { has_connector: false, ..day }, begun, None),
            (begun, Look { has_connector: false, ..night }, by_nothing, None),
            (begun, Look { means: None, ..day }, Stage::Day, None),
            (Stage::Day, day, Stage::Day, None),
            (Stage::Day, night, leaving, off),
            (Stage::Day, Look { means: None, ..night }, by_nothing, None),
            (leaving, night, leaving, None),
            (leaving, Look { is_answered: true, ..night }, by_it, None),
            (leaving, late, by_it, None),
            (leaving, day, Stage::Day, on.clone()),
            (by_it, night, by_it, None),
            (by_it, day, Stage::Day, on.clone()),
            (by_it, Look { means: None, ..day }, Stage::Day, on.clone()),
            (by_it, Look { has_connector: false, ..day }, Stage::Waking { by: Some(BY) }, None),
            (by_nothing, day, Stage::Day, on),
            (by_nothing, Look { means: None, ..day }, Stage::Day, None),
        ] {
            assert_eq!(before.on(look), (after, asked), "{before:?} at {look:?}");
        }
    }

    #[test]
    fn the_signal_stays_until_the_display_has_answered_and_comes_back_at_once() {
        let (requests, asked) = channel();
        let answers: Arc<PowerAnswers> = Arc::default();
        let mut power = DisplayPower {
            stage: Stage::Day,
            connector: None,
            day: Lighting::FULL,
            requests,
            answers: Arc::clone(&answers),
            number: 0,
        };
        let mut look = |wanted, lit: Option<ConnectorId>, now| power.look(wanted, Some(BY), lit, Nanos(now));
        assert_eq!(look(DAY, Some(connector()), 0), DAY);
        assert_eq!([1, 2].map(|now| look(Lighting::Off, Some(connector()), now)), [DAY, DAY]);
        let (request, at, number) = asked.try_recv().unwrap();
        assert_eq!((request, at), (Request { means: BY, is_on: false }, connector()));
        *hold(&answers.0) = Some(PowerAnswer { means: BY, is_on: false, error: None, number });
        assert_eq!([3, 4].map(|now| look(Lighting::Off, None, now)), [Lighting::Off; 2]);
        // A display that sleeps may seem to be unplugged: it is asked all the same.
        assert_eq!(look(DAY, None, 5), DAY);
        assert_eq!(asked.try_recv().map(|(request, at, _)| (request.is_on, at)), Ok((true, connector())));
        assert!(asked.try_recv().is_err(), "and once");
        for black in [Lighting::Black, DAY] {
            assert_eq!(look(black, Some(connector()), 6), black);
        }
        assert!(asked.try_recv().is_err(), "a night in black is none for the display");
    }

    /// How often the display is asked that fails so many times, and the answers.
    fn asked(requests: &[Request], failures: u32) -> (u32, Option<PowerAnswer>) {
        let (sender, inbox) = channel();
        let (answers, mut tries) = (PowerAnswers::default(), 0);
        for (request, number) in requests.iter().zip(1..) {
            sender.send((request.clone(), connector(), number)).unwrap();
        }
        drop(sender);
        answer_all(&inbox, &answers, Duration::ZERO, |_, _| {
            tries += 1;
            if tries > failures { Ok(()) } else { Err(PowerError::Unchanged { mode: 4 }) }
        });
        (tries, answers.newest())
    }

    #[test]
    fn a_display_is_asked_until_it_follows_or_for_a_limit_of_tries() {
        let [on, off] = [true, false].map(|is_on| Request { means: BY, is_on });
        let (tries, answer) = asked(std::slice::from_ref(&on), 7);
        assert_eq!((tries, answer.map(|answer| answer.error)), (8, Some(None)));
        for (request, limit) in [(on.clone(), TRIES_ON), (off.clone(), TRIES_OFF)] {
            let (tries, answer) = asked(&[request], u32::MAX);
            let error = answer.and_then(|answer| answer.error).unwrap();
            assert_eq!((tries, error.contains("power mode 4")), (limit, true), "{error}");
        }
        let (tries, answer) = asked(&[on, off], 0);
        assert_eq!((tries, answer.map(|answer| answer.number)), (1, Some(2)), "the newest counts");
    }

    #[test]
    fn a_newer_request_ends_the_tries_of_an_older_one() {
        let (sender, inbox) = channel();
        let (first_try, tried) = channel();
        let answers: Arc<PowerAnswers> = Arc::default();
        let given = Arc::clone(&answers);
        let switch = move |request: &Request, _: &ConnectorId| {
            if request.is_on {
                first_try.send(()).ok();
                return Err(PowerError::Unchanged { mode: 4 });
            }
            Ok(())
        };
        let thread = thread::spawn(move || answer_all(&inbox, &given, Duration::from_millis(20), switch));
        sender.send((Request { means: BY, is_on: true }, connector(), 1)).unwrap();
        tried.recv_timeout(Duration::from_mins(1)).expect("the display is asked");
        sender.send((Request { means: BY, is_on: false }, connector(), 2)).unwrap();
        drop((sender, tried));
        thread.join().unwrap();
        let answer = answers.newest().unwrap();
        assert_eq!((answer.is_on, answer.number, answer.error), (false, 2, None));
    }
}
