//! Changes of the display configuration without a dark moment: for pictures of another size or rate, new settings of
//! the owner, or a better mode that the display reports late.
//!
//! Owns the output that is prepared while the present one is lit, and the change: one commit, which sets a mode only if
//! there is a better one for the new pictures. The old buffers are freed once the new picture is on the screen. If the
//! card cannot do it, the old configuration stays and pictures of another size are centred. Another connector is lit
//! like a display that is plugged in.
//!
//! Start at [`KmsScreen::prepare_better`].

use super::candidate::Candidate;
use super::card::Kms;
use super::plan::Plan;
use super::recovery::free;
use super::{CommitState, KmsScreen, Phase};
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

    /// Applies new settings of the owner. For another connector the present display goes dark.
    pub(super) fn change_output(&mut self, output: &OutputSettings) {
        if *output == self.settings.output {
            return;
        }
        self.settings.output = output.clone();
        // Candidates that were rejected may be accepted now.
        self.refused.clear();
        let Phase::Up(lit) = &self.phase else {
            if let Phase::Dark { retry } = &mut self.phase {
                *retry = (self.settings.now)();
            }
            return;
        };
        let best = self.candidates(&lit.survey).first().map(|way| way.connector);
        if best.is_some_and(|connector| connector != lit.plan.way.connector) {
            return self.leave("another connector was chosen in the settings");
        }
        self.prepare_better();
    }

    /// Prepares the best candidate at the lit connector, unless it equals the present one.
    pub(super) fn prepare_better(&mut self) {
        self.drop_prepared();
        let Phase::Up(output) = &self.phase else { return };
        let (here, survey) = (output.plan.way, output.survey.clone());
        let size = self.settings.size;
        let is_here = |way: &Candidate| (way.connector, way.crtc, way.plane) == (here.connector, here.crtc, here.plane);
        let mut candidates: Vec<Candidate> = self.candidates(&survey).into_iter().filter(is_here).collect();
        // Another signal range or connector state needs a new commit with the same configuration.
        let is_same = |way: &Candidate| is_same(&output.plan, way, size) && output.made_for == self.settings.output;
        let stays = candidates.iter().position(is_same);
        // Only candidates that are better than the present one are tried.
        candidates.truncate(stays.unwrap_or(candidates.len()));
        match self.first_accepted(&survey, candidates) {
            Ok(Some(mut coming)) => {
                // The CRTC is in use by us, whatever it drove at the time of the survey.
                coming.plan.same_mode = coming.plan.way.mode == here.mode;
                self.coming = Some(Box::new(coming));
            }
            Ok(None) if stays.is_some() => {}
            Ok(None) => tracing::warn!(
                ?size,
                "no display configuration for the new pictures or settings, keeping the present one"
            ),
            Err(error) => tracing::warn!(%error, ?size, "cannot prepare another display configuration"),
        }
    }

    /// Replaces the output by the prepared one, if that has a picture.
    pub(super) fn change_over(&mut self) {
        let Phase::Up(output) = &mut self.phase else { return };
        if output.flight != CommitState::Landed {
            return;
        }
        let Some(mut coming) = self.coming.take_if(|coming| coming.ring.is_staged()) else { return };
        if coming.plan.refresh == output.plan.refresh {
            coming.own_vblanks = output.own_vblanks;
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

    /// Frees the buffers of the previous output.
    pub(super) fn free_previous(&mut self) {
        if let Some(before) = self.leaving.take() {
            free(&mut self.kms, *before);
        }
    }

    /// Frees what was prepared.
    pub(super) fn drop_prepared(&mut self) {
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
    use super::super::scripted::{Effect, Fault, Kind, MS, Scripted};
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
                    let fault = Fault { kind, nth, effect: Effect::Refused(errno), ns };
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
                    assert!(card.injected_at.is_some(), "{fault:?} never struck");
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
