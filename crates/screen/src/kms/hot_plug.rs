//! Hot-plug while a picture is lit.
//!
//! Owns the evaluation of a probe (a display that was unplugged, has a better mode, or a failed link) and the debouncing of
//! connectors that toggle. Only the connector in use is probed, on another thread, so that no frame is late.
//!
//! Start at [`KmsScreen::probed`].

use super::card::{Connector, ConnectorStatus, Kms};
use super::{CommitState, KmsScreen, Phase};
use std::time::Duration;
use timing::Nanos;

/// How long a display must be gone to count as unplugged: some drop the line for a moment when they wake.
const CONFIRMED_AFTER: Duration = Duration::from_millis(150);
/// A display that goes after being lit for less than this is toggling.
const STEADY: Duration = Duration::from_secs(2);
/// How often it may toggle before attempts are delayed.
const TOGGLES: u32 = 2;
/// The first delay, which doubles with each toggle.
const WAIT: Duration = Duration::from_millis(500);
/// The longest wait.
const MAX_WAIT: Duration = Duration::from_secs(10);

/// The connection state of the lit connector.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct HotPlug {
    /// The connector is being probed.
    is_probing: bool,
    /// An event came after the running probe had started.
    has_changed: bool,
    /// When the display was first seen to be gone.
    gone: Option<Nanos>,
    /// When the connector is to be probed again.
    look_at: Option<Nanos>,
    /// Since when a picture is lit.
    lit: Option<Nanos>,
    /// How often in a row the display went shortly after it was lit.
    toggles: u32,
    /// No attempt before this.
    not_before: Nanos,
}

impl HotPlug {
    /// When the connector is probed without an event.
    pub(super) fn look_at(&self) -> Option<Nanos> {
        self.look_at
    }

    /// The earliest time for the next attempt, not before `now`.
    pub(super) fn not_before(&self, now: Nanos) -> Nanos {
        now.max(self.not_before)
    }

    /// A picture is lit. The clock is read only the first time.
    pub(super) fn on_lit(&mut self, now: impl FnOnce() -> Nanos) {
        self.lit.get_or_insert_with(now);
    }

    /// Nothing is lit from `now` on. Returns the earliest time for the next attempt.
    pub(super) fn on_dark(&mut self, now: Nanos) -> Nanos {
        let was_lit = self.lit.take().map(|lit| now.since(lit));
        match was_lit {
            Some(lit_ns) if u128::from(lit_ns) < STEADY.as_nanos() => self.toggles = self.toggles.saturating_add(1),
            Some(_) => self.toggles = 0,
            None => {}
        }
        let doublings = self.toggles.saturating_sub(TOGGLES + 1).min(10);
        let wait = if self.toggles > TOGGLES { (WAIT * (1 << doublings)).min(MAX_WAIT) } else { Duration::ZERO };
        self.not_before = now.after(wait.as_nanos() as u64);
        (self.gone, self.look_at, self.is_probing, self.has_changed) = (None, None, false, false);
        self.not_before
    }

    /// The display was found unplugged at `now`. Returns whether that is confirmed; else it is probed again.
    fn is_gone(&mut self, now: Nanos) -> bool {
        let since = *self.gone.get_or_insert(now);
        let confirmed = since.after(CONFIRMED_AFTER.as_nanos() as u64);
        self.look_at = (now < confirmed).then_some(confirmed);
        self.look_at.is_none()
    }
}

impl<K: Kms> KmsScreen<K> {
    /// Starts a probe of the lit connector.
    pub(super) fn probe(&mut self) {
        self.cable.look_at = None;
        let Phase::Up(output) = &self.phase else { return };
        if self.cable.is_probing {
            self.cable.has_changed = true;
            return;
        }
        self.cable.is_probing = true;
        self.kms.probe(output.plan.way.connector);
    }

    /// Evaluates the result of a probe.
    pub(super) fn probed(&mut self, connector: Connector) {
        self.cable.is_probing = false;
        let now = self.now();
        let Phase::Up(output) = &mut self.phase else { return };
        let way = &output.plan.way;
        let Some(known) = output.survey.connectors.iter_mut().find(|known| known.id == connector.id) else { return };
        if known.id != way.connector {
            return;
        }
        let was_listed = known.modes.contains(&way.mode);
        let is_listed = connector.modes.contains(&way.mode);
        let (had, forced) = (known.modes.clone(), known.plug == ConnectorStatus::Out);
        if connector.plug == ConnectorStatus::Out && !forced {
            if self.cable.is_gone(now) {
                let reason = format!("the display at {} of {} was unplugged", output.plan.connector, self.kms.name());
                return self.leave(&reason);
            }
            return;
        }
        self.cable.gone = None;
        let bad = connector.properties.choice("link-status", "Bad").map(|(_, value)| value);
        let has_bad_link = bad == Some(connector.properties.value("link-status"));
        let has_news = connector.modes != had;
        *known = connector;
        if was_listed && !is_listed {
            let reason = format!("another display was plugged in at {}", output.plan.connector);
            return self.leave(&reason);
        }
        if output.lit && has_bad_link && output.ring.commit().is_some() {
            output.flight = CommitState::Lighting { next: now, since: now };
        }
        if has_news {
            self.prepare_better();
        }
        if std::mem::take(&mut self.cable.has_changed) {
            self.probe();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{HotPlug, MAX_WAIT};
    use timing::Nanos;

    const MS: u64 = 1_000_000;

    #[test]
    fn a_display_that_toggles_is_lit_again_ever_later_and_one_that_stays_at_once() {
        let mut cable = HotPlug::default();
        let mut now = Nanos(0);
        let mut waits_ms = Vec::new();
        for _ in 0..9 {
            cable.on_lit(|| now);
            now = now.after(300 * MS);
            let next = cable.on_dark(now);
            waits_ms.push(next.since(now) / MS);
            assert_eq!(cable.not_before(now), next, "a cable that moves meanwhile changes nothing");
            now = next;
        }
        assert_eq!(waits_ms, [0, 0, 500, 1000, 2000, 4000, 8000, 10_000, 10_000]);
        assert_eq!(u128::from(waits_ms[8]), MAX_WAIT.as_millis());
        cable.on_lit(|| now);
        now = now.after(2_000 * MS);
        assert_eq!(cable.on_dark(now), now, "two seconds of light");
    }

    #[test]
    fn a_display_is_gone_when_it_was_gone_for_a_while() {
        let mut cable = HotPlug::default();
        assert!(!cable.is_gone(Nanos(0)));
        assert_eq!(cable.look_at(), Some(Nanos(150 * MS)));
        assert!(!cable.is_gone(Nanos(100 * MS)));
        assert!(cable.is_gone(Nanos(150 * MS)));
    }
}
