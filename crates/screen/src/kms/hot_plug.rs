//! Cables that come and go while a picture is lit.
//!
//! Owns what a probe of the connector means: a display that is gone, one with a better mode, one whose link has failed; and
//! how a connector that toggles is damped. The connector is probed by another thread, and no other connector is asked: no
//! frame is late for it. Never probes by itself: the card does.
//!
//! Start at [`KmsScreen::probed`].

use super::card::{Connector, Kms, Plug};
use super::{Flight, KmsScreen, Phase};
use std::time::Duration;
use timing::Nanos;

/// How long a display must be gone to be taken for gone: some drop the line for a moment when they wake.
const CONFIRMED_AFTER: Duration = Duration::from_millis(150);
/// A display that was lit for less than this, and goes, is one that toggles.
const STEADY: Duration = Duration::from_secs(2);
/// So often it may toggle before the next attempt waits.
const TOGGLES: u32 = 2;
/// The first wait, which doubles with each toggle.
const WAIT: Duration = Duration::from_millis(500);
/// The longest wait.
const LONGEST_WAIT: Duration = Duration::from_secs(10);

/// What is known of the cable.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Cable {
    /// The connector is being probed.
    is_probing: bool,
    /// Something has changed since that began.
    has_changed: bool,
    /// When the display was first seen to be gone.
    gone: Option<Nanos>,
    /// When the connector is to be probed again.
    look_at: Option<Nanos>,
    /// Since when a picture is lit.
    lit: Option<Nanos>,
    /// How often in a row the display went soon after it was lit.
    toggles: u32,
    /// No attempt before this.
    not_before: Nanos,
}

impl Cable {
    /// When the connector is to be probed without being told.
    pub(super) fn look_at(&self) -> Option<Nanos> {
        self.look_at
    }

    /// The earliest time from `now` on at which an attempt to light something makes sense.
    pub(super) fn not_before(&self, now: Nanos) -> Nanos {
        now.max(self.not_before)
    }

    /// A picture is lit. The clock is read once for each time that something is.
    pub(super) fn lights(&mut self, now: impl FnOnce() -> Nanos) {
        self.lit.get_or_insert_with(now);
    }

    /// Nothing is lit from `now` on. The earliest time for the next attempt.
    pub(super) fn goes_dark(&mut self, now: Nanos) -> Nanos {
        let was_lit = self.lit.take().map(|lit| now.since(lit));
        match was_lit {
            Some(lit_ns) if u128::from(lit_ns) < STEADY.as_nanos() => self.toggles = self.toggles.saturating_add(1),
            Some(_) => self.toggles = 0,
            None => {}
        }
        let doublings = self.toggles.saturating_sub(TOGGLES + 1).min(10);
        let wait = if self.toggles > TOGGLES { (WAIT * (1 << doublings)).min(LONGEST_WAIT) } else { Duration::ZERO };
        self.not_before = now.after(wait.as_nanos() as u64);
        (self.gone, self.look_at, self.is_probing, self.has_changed) = (None, None, false, false);
        self.not_before
    }

    /// The display was seen to be gone at `now`. Whether that is certain; else it is looked at again.
    fn is_gone(&mut self, now: Nanos) -> bool {
        let since = *self.gone.get_or_insert(now);
        let confirmed = since.after(CONFIRMED_AFTER.as_nanos() as u64);
        self.look_at = (now < confirmed).then_some(confirmed);
        self.look_at.is_none()
    }
}

impl<K: Kms> KmsScreen<K> {
    /// Has the connector of what is lit probed.
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

    /// A probe has found `connector` as it is now.
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
        let (had, forced) = (known.modes.clone(), known.plug == Plug::Out);
        if connector.plug == Plug::Out && !forced {
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
            output.flight = Flight::Lighting { next: now, since: now };
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
    use super::{Cable, LONGEST_WAIT};
    use timing::Nanos;

    const MS: u64 = 1_000_000;

    #[test]
    fn a_display_that_toggles_is_lit_again_ever_later_and_one_that_stays_at_once() {
        let mut cable = Cable::default();
        let mut now = Nanos(0);
        let mut waits_ms = Vec::new();
        for _ in 0..9 {
            cable.lights(|| now);
            now = now.after(300 * MS);
            let next = cable.goes_dark(now);
            waits_ms.push(next.since(now) / MS);
            assert_eq!(cable.not_before(now), next, "a cable that moves meanwhile changes nothing");
            now = next;
        }
        assert_eq!(waits_ms, [0, 0, 500, 1000, 2000, 4000, 8000, 10_000, 10_000]);
        assert_eq!(u128::from(waits_ms[8]), LONGEST_WAIT.as_millis());
        cable.lights(|| now);
        now = now.after(2_000 * MS);
        assert_eq!(cable.goes_dark(now), now, "two seconds of light");
    }

    #[test]
    fn a_display_is_gone_when_it_was_gone_for_a_while() {
        let mut cable = Cable::default();
        assert!(!cable.is_gone(Nanos(0)));
        assert_eq!(cable.look_at(), Some(Nanos(150 * MS)));
        assert!(!cable.is_gone(Nanos(100 * MS)));
        assert!(cable.is_gone(Nanos(150 * MS)));
    }
}
