//! From one way to light pictures to another, without a dark moment: pictures of another form, other settings of the owner, a
//! better mode that a display tells of late.
//!
//! Owns the output that is prepared while the other one is lit, and how it takes its place: with one commit, which sets a
//! mode only if the new pictures have a better one. What was on the glass is freed when the new picture is there. A card
//! that cannot do it goes on as it is: pictures of another size then lie in the middle. Never leaves the display: where
//! another one would be better, the next start finds it.
//!
//! Start at [`KmsScreen::prepare_better`].

use super::candidate::Candidate;
use super::card::Kms;
use super::plan::Plan;
use super::recovery::free;
use super::{Flight, KmsScreen, Phase};
use crate::Event;
use crate::output::OutputSettings;
use timing::Rate;

impl<K: Kms> KmsScreen<K> {
    /// Prepares for pictures of `size` at `fps`.
    pub(super) fn prepare_for(&mut self, size: (u32, u32), fps: Rate) {
        if (size, fps) != (self.settings.size, self.settings.fps) {
            (self.settings.size, self.settings.fps) = (size, fps);
            self.prepare_better();
        }
    }

    /// Goes by other settings of the display's owner. Another connector is another display: the picture leaves this one.
    pub(super) fn change_output(&mut self, output: &OutputSettings) {
        if *output == self.settings.output {
            return;
        }
        self.settings.output = output.clone();
        // What was refused may be allowed now.
        self.refused.clear();
        let Phase::Up(lit) = &self.phase else {
            if let Phase::Dark { retry } = &mut self.phase {
                *retry = (self.settings.now)();
            }
            return;
        };
        let best = self.ways(&lit.survey).first().map(|way| way.connector);
        if best.is_some_and(|connector| connector != lit.plan.way.connector) {
            return self.leave("the display's owner has chosen another connector");
        }
        self.prepare_better();
    }

    /// Prepares the best way to light the pictures to come at the connector that is lit, if that is not as they are lit now.
    pub(super) fn prepare_better(&mut self) {
        self.forget_coming();
        let Phase::Up(output) = &self.phase else { return };
        let (here, survey) = (output.plan.way, output.survey.clone());
        let size = self.settings.size;
        let is_here = |way: &Candidate| (way.connector, way.crtc, way.plane) == (here.connector, here.crtc, here.plane);
        let mut ways: Vec<Candidate> = self.ways(&survey).into_iter().filter(is_here).collect();
        // The same with other levels or another state of the connector is a commit that lights it anew.
        let is_same = |way: &Candidate| is_same(&output.plan, way, size) && output.made_for == self.settings.output;
        let stays = ways.iter().position(is_same);
        // What is not as good as what is lit need not be tried.
        ways.truncate(stays.unwrap_or(ways.len()));
        match self.accepted(&survey, ways) {
            Ok(Some(mut coming)) => {
                // The CRTC is ours, whatever it drove when the card was looked at.
                coming.plan.same_mode = coming.plan.way.mode == here.mode;
                self.coming = Some(Box::new(coming));
            }
            Ok(None) if stays.is_some() => {}
            Ok(None) => tracing::warn!(?size, "there is no other way to light the picture"),
            Err(error) => tracing::warn!(%error, ?size, "cannot prepare to light other pictures"),
        }
    }

    /// Has the output that is prepared take the place of the other, if there is one with a picture.
    pub(super) fn change_over(&mut self) {
        let Phase::Up(output) = &mut self.phase else { return };
        if output.flight != Flight::Landed {
            return;
        }
        let Some(mut coming) = self.coming.take_if(|coming| coming.ring.is_staged()) else { return };
        if coming.plan.refresh == output.plan.refresh {
            coming.beat = output.beat;
        }
        let (new, old) = (&coming.plan.way, &output.plan.way);
        coming.has_colours = output.has_colours && new.format.format.is_yuv() == old.format.format.is_yuv();
        coming.gave_up_at = output.gave_up_at;
        let before = std::mem::replace(output, coming);
        self.notices.push_back(Event::Changed);
        if before.lit {
            self.leaving = Some(before);
        } else {
            free(&mut self.kms, *before);
        }
    }

    /// Frees what was on the glass before.
    pub(super) fn retire(&mut self) {
        if let Some(before) = self.leaving.take() {
            free(&mut self.kms, *before);
        }
    }

    /// Frees what was prepared.
    pub(super) fn forget_coming(&mut self) {
        if let Some(coming) = self.coming.take() {
            free(&mut self.kms, *coming);
        }
    }

    /// Closes the card, which frees everything.
    pub(super) fn close(&mut self) {
        (self.coming, self.leaving) = (None, None);
        self.kms.close();
    }
}

/// Whether `plan` lights pictures of `size` just as `way` would.
fn is_same(plan: &Plan, way: &Candidate, size: (u32, u32)) -> bool {
    let lies = |size| (way.buffer_size(size), way.destination(size));
    plan.way == *way && lies(plan.size) == lies(size)
}

#[cfg(test)]
mod tests {
    use super::super::candidate::mode_size;
    use super::super::scripted::families::generic::{GENERIC, UNSCALED};
    use super::super::scripted::family::{Family, mode};
    use super::super::scripted::fault_matrix::{CARDS, Player, at};
    use super::super::scripted::{Fault, Ill, Kind, MS, Scripted};
    use drm::control::ModeFlags;
    use rustix::io::Errno;
    use timing::Rate;

    /// A card with a display that likes 64x48, and takes 32x24 as well.
    fn card(family: &'static Family) -> Scripted {
        let mut card = Scripted::of(family);
        card.modes.push(mode((32, 24, 250, 80, 52, ModeFlags::empty(), false)));
        card
    }

    type Size = (u32, u32);

    /// Forms that come one after the other, with the mode that each is lit by where the plane does not scale.
    fn forms() -> [((Size, Rate), Size); 7] {
        let hz = |rate| Rate::new(rate, 1).unwrap();
        [
            (((48, 36), hz(30)), (64, 48)),
            (((48, 36), hz(20)), (64, 48)),
            (((32, 24), hz(20)), (32, 24)),
            (((16, 12), hz(30)), (64, 48)),
            (((80, 60), hz(30)), (64, 48)),
            (((32, 24), hz(30)), (32, 24)),
            (((64, 48), hz(30)), (64, 48)),
        ]
    }

    #[test]
    fn pictures_of_another_form_come_in_their_time_and_a_mode_is_set_only_for_a_better_one() {
        for (family, quirk) in [&UNSCALED, &GENERIC].into_iter().flat_map(|family| CARDS.map(|quirk| (family, quirk))) {
            let mut card = card(family);
            card.quirk = quirk;
            let mut player = Player::on(card);
            player.play(at(2_000));
            for (second, (form, lit)) in (2..).zip(forms()) {
                // A plane that scales lights them all in the panel's own mode.
                let lit = if family.limits.shrinks > 0 { (64, 48) } else { lit };
                let (before, set) = (player.screen.kms.mode(), player.screen.kms.modesets);
                player.form = form;
                player.play(at(1_000 * second + 1_000));
                let card = &player.screen.kms;
                assert_eq!(card.mode().map(|mode| mode_size(&mode)), Some(lit), "{form:?}");
                assert_eq!(card.modesets - set, u32::from(before != card.mode()), "{form:?}");
                assert_eq!((card.fbs.len(), card.blobs.len()), (player.framebuffers(), 1), "{form:?} left something");
            }
            assert!(player.lost().is_empty() && player.longest_pause_ms() <= 50, "{:?}", player.lost());
        }
    }

    #[test]
    fn every_error_while_pictures_of_another_form_come_is_survived() {
        let kinds = [(Kind::Test, 3..12), (Kind::Light, 1..4), (Kind::Flip, 28..32)];
        for (kind, nth) in kinds.into_iter().flat_map(|(kind, places)| places.map(move |nth| (kind, nth))) {
            for errno in [Errno::BUSY, Errno::ACCESS, Errno::INVAL, Errno::NODEV, Errno::NOMEM, Errno::IO] {
                for (ns, quirk) in [0, 50 * MS, 400 * MS].into_iter().flat_map(|ns| CARDS.map(|quirk| (ns, quirk))) {
                    let fault = Fault { kind, nth, ill: Ill::Refused(errno), ns };
                    let mut card = card(&UNSCALED).fail(fault);
                    card.quirk = quirk;
                    let mut player = Player::on(card);
                    for (second, (form, _)) in (2..).zip(forms()) {
                        player.play(at(1_000 * second));
                        player.form = form;
                    }
                    player.play(at(12_000));
                    let pause = player.longest_pause_ms();
                    assert!(pause <= 2000, "{fault:?}: dark for {pause} ms, {:?}", player.events);
                    let steady = player.flips.iter().filter(|flip| **flip > at(11_000)).count();
                    assert!(steady >= 29, "{fault:?}: {steady} flips in the last second");
                    let card = &player.screen.kms;
                    assert!(card.struck.is_some(), "{fault:?} never struck");
                    assert_eq!((card.fbs.len(), card.blobs.len()), (player.framebuffers(), 1), "{fault:?}");
                }
            }
        }
    }

    #[test]
    fn a_cable_pulled_while_pictures_of_another_form_come_leaves_nothing_behind() {
        for moment in 0..40 {
            let mut card = card(&UNSCALED);
            card.plugs.extend([(at(2_000 + 2 * moment), false), (at(2_700 + moment), true)]);
            let mut player = Player::on(card);
            player.play(at(2_010));
            player.form = forms()[2].0;
            player.play(at(5_000));
            let card = &player.screen.kms;
            assert_eq!(card.mode().map(|mode| mode_size(&mode)), Some((32, 24)));
            assert_eq!((card.fbs.len(), card.blobs.len()), (player.framebuffers(), 1), "pulled at {moment}");
            assert!(player.flips.iter().filter(|flip| **flip > at(4_000)).count() >= 29);
        }
    }
}
