//! Every error at every kind of commit: the same screen recovers, and leaves nothing behind.
//!
//! Owns a small player on a scripted card. The rules that no run may break (no bound framebuffer removed, no mode set
//! by a flip, no second commit in flight, no busy wait) are asserted by `scripted.rs` itself.

use super::families::generic::UNCOUNTED;
use super::family::mode;
use super::{Effect, Fault, Kind, MS, Quirk, Scripted, now};
use crate::kms::candidate::Framebuffers;
use crate::kms::{FdStore, KmsScreen, KmsSettings, Phase};
use crate::{Event, Light, OutputSettings, Picture, Screen};
use proptest::prelude::*;
use rustix::io::Errno;
use std::time::Duration;
use timing::{Nanos, Rate, Vblank};

/// Plays 30 frames per second: a flip, a vblank waited for, a commit, a flip.
pub(in crate::kms) struct Player {
    pub(in crate::kms) screen: KmsScreen<Scripted>,
    pub(in crate::kms) flips: Vec<Nanos>,
    pub(in crate::kms) events: Vec<Event>,
    /// Size and rate of the pictures to come.
    pub(in crate::kms) form: ((u32, u32), Rate),
    frame: u8,
}

impl Player {
    pub(in crate::kms) fn on(card: Scripted) -> Self {
        Self::with(card, (64, 48), OutputSettings::default())
    }

    /// With pictures of `size`, and these settings of the display's owner.
    pub(super) fn with(card: Scripted, size: (u32, u32), output: OutputSettings) -> Self {
        let form @ (size, fps) = (size, Rate::new(30, 1).unwrap());
        let settings = KmsSettings { device: Some("scripted".into()), size, fps, now, keeper: FdStore::NOBODY, output };
        let screen = KmsScreen::on(card, settings).unwrap();
        let mut player = Self { screen, flips: Vec::new(), events: Vec::new(), form, frame: 0 };
        player.stage();
        player.screen.commit();
        player
    }

    fn stage(&mut self) {
        self.frame = self.frame.wrapping_add(1);
        let ((width, height), fps) = self.form;
        let [pixels, row, half] = [width * height, width, width / 2].map(|count| count as usize);
        // The upper half is the brighter one.
        let level = 40 + self.frame % 60;
        let luma: Vec<u8> = (0..pixels).map(|at| if at < pixels / 2 { level + 100 } else { level }).collect();
        let chroma = vec![128; pixels / 4];
        let picture = Picture { width, height, planes: [&luma, &chroma, &chroma], strides: [row, half, half] };
        self.screen.set_format((width, height), fps);
        self.screen.stage(&picture).unwrap();
    }

    pub(in crate::kms) fn play(&mut self, until: Nanos) {
        while now() < until {
            let event = self.screen.next_event(Duration::from_nanos(until.since(now())));
            match &event {
                Event::Flip { vblank, .. } => {
                    self.flips.push(now());
                    self.stage();
                    self.screen.notify_at(vblank.after(1));
                }
                Event::Vblank { .. } | Event::Recovered { .. } => self.screen.commit(),
                Event::Back => {
                    self.stage();
                    self.screen.commit();
                }
                Event::Lost { .. } | Event::Asleep | Event::Changed | Event::Idle => {}
            }
            self.events.push(event);
        }
    }

    pub(in crate::kms) fn longest_pause_ms(&self) -> u64 {
        self.flips.windows(2).map(|pair| pair[1].since(pair[0]) / MS).max().unwrap_or(u64::MAX)
    }

    /// How many framebuffers the way that is lit takes.
    pub(in crate::kms) fn framebuffers(&self) -> usize {
        let Phase::Up(output) = &self.screen.phase else { panic!("the screen is up") };
        match output.plan.way.framebuffers {
            Framebuffers::Shared => 1,
            Framebuffers::Own => 3,
        }
    }

    pub(in crate::kms) fn lost(&self) -> Vec<&str> {
        let reasons = self.events.iter().filter_map(|event| match event {
            Event::Lost { reason } => Some(reason.as_str()),
            Event::Flip { .. }
            | Event::Vblank { .. }
            | Event::Back
            | Event::Recovered { .. }
            | Event::Asleep
            | Event::Changed
            | Event::Idle => None,
        });
        reasons.collect()
    }
}

pub(in crate::kms) fn at(ms: u64) -> Nanos {
    Nanos(ms * MS)
}

/// Ten seconds with two pulls of the plug, and one fault.
fn survives(fault: Fault, quirk: Option<Quirk>) {
    let mut card = Scripted::new().fail(fault);
    card.quirk = quirk;
    card.plugs.extend([(at(2003), false), (at(2403), true), (at(5000), false), (at(5400), true)]);
    let mut player = Player::on(card);
    player.play(at(11_000));
    let card = &player.screen.kms;
    let injected_at = card.injected_at.unwrap_or_else(|| panic!("{fault:?} never struck"));
    let pause = player.longest_pause_ms();
    assert!(pause <= 2000, "{fault:?} at {injected_at:?}: dark for {pause} ms, {:?}", player.events);
    let steady = player.flips.iter().filter(|flip| **flip > at(10_000)).count();
    assert!(steady >= 29, "{fault:?}: {steady} flips in the last second");
    assert_eq!((card.fbs.len(), card.blobs.len()), (player.framebuffers(), 1), "{fault:?} left framebuffers or blobs");
}

/// Cards that take the buffers in one framebuffer, and in one each.
pub(in crate::kms) const CARDS: [Option<Quirk>; 2] = [None, Some(Quirk::NoWindow)];

const KINDS: [(Kind, [u32; 3]); 4] =
    [(Kind::Test, [0, 1, 2]), (Kind::Light, [0, 1, 2]), (Kind::Flip, [0, 1, 40]), (Kind::Darken, [0, 1, 1])];

#[test]
fn every_error_at_every_kind_of_commit_is_survived() {
    let errors = [Errno::BUSY, Errno::ACCESS, Errno::INVAL, Errno::NODEV, Errno::NOMEM, Errno::NOSPC, Errno::IO];
    for (kind, places) in KINDS {
        for nth in places {
            for errno in errors {
                for (ns, card) in [0, 50 * MS, 400 * MS].into_iter().flat_map(|ns| CARDS.map(|card| (ns, card))) {
                    survives(Fault { kind, nth, effect: Effect::Refused(errno), ns }, card);
                }
            }
        }
    }
}

#[test]
fn a_flip_lost_after_every_kind_of_commit_is_survived() {
    for (kind, places) in KINDS {
        for nth in places {
            for effect in [Effect::LostFlip, Effect::LostEvent, Effect::LateEvent] {
                for (ns, card) in [0, 500 * MS].into_iter().flat_map(|ns| CARDS.map(|card| (ns, card))) {
                    survives(Fault { kind, nth, effect, ns }, card);
                }
            }
        }
    }
}

#[test]
fn a_lost_event_is_told_and_costs_a_tenth_of_a_second() {
    let mut player =
        Player::on(Scripted::new().fail(Fault { kind: Kind::Flip, nth: 9, effect: Effect::LostEvent, ns: 0 }));
    player.play(at(3000));
    assert!(player.events.iter().any(|event| matches!(event, Event::Recovered { .. })));
    assert!(player.longest_pause_ms() <= 200, "{} ms", player.longest_pause_ms());
    assert_eq!(player.screen.kms.modesets, 1, "nothing was lit anew");
}

#[test]
fn an_event_that_comes_late_is_not_taken_for_the_next_flips() {
    for nth in 0..40 {
        let fault = Fault { kind: Kind::Flip, nth, effect: Effect::LateEvent, ns: 0 };
        let mut player = Player::on(Scripted::new().fail(fault));
        player.play(at(4000));
        assert!(holds(&player).iter().all(|&held| held >= 1), "{fault:?}: {:?}", holds(&player));
    }
}

#[test]
fn a_flip_given_up_is_measured_from_the_last_flip_and_not_from_long_ago() {
    for effect in [Effect::LostEvent, Effect::LateEvent] {
        let mut player = Player::on(Scripted::new().fail(Fault { kind: Kind::Flip, nth: 9, effect, ns: 0 }));
        player.play(at(4000));
        assert!(player.events.iter().any(|event| matches!(event, Event::Recovered { .. })));
        let Phase::Up(output) = &player.screen.phase else { panic!("the screen is up") };
        // Kept, it would make every flip an old one when the counter has gone half around.
        let flips = player.events.iter().rev();
        let mut last =
            flips.filter_map(|event| if let Event::Flip { vblank, .. } = event { Some(*vblank) } else { None });
        assert_eq!(output.gave_up_at, last.next(), "{effect:?}");
    }
}

#[test]
fn a_kernel_that_cannot_tell_the_first_vblank_makes_nothing_late() {
    let mut card = Scripted::new();
    card.quirk = Some(Quirk::LateVblanks);
    let mut player = Player::on(card);
    player.play(at(4000));
    assert!(player.flips.len() > 80);
    assert!(holds(&player).iter().all(|&held| held == 2), "{:?}", holds(&player));
}

#[test]
fn whoever_looks_at_another_console_has_the_display_until_he_is_back() {
    for night in [false, true] {
        let mut card = Scripted::new();
        card.switches.extend([(at(3_000), false), (at(20_000), true), (at(23_000), false), (at(23_010), true)]);
        let mut player = Player::on(card);
        player.play(at(2_000));
        if night {
            player.screen.set_light(Light::Off);
            player.play(at(4_000));
            player.screen.set_light(Light::FULL);
        }
        player.play(at(19_000));
        let card = &player.screen.kms;
        assert!(
            card.has_released_console && card.on_screen.is_none() && card.fbs.is_empty(),
            "nothing of ours is left"
        );
        assert!(!player.flips.iter().any(|flip| *flip > at(3_100)));
        player.play(at(26_000));
        let steady = player.flips.iter().filter(|flip| **flip > at(25_000)).count();
        assert!(steady >= 29 && player.screen.kms.is_on(), "{steady} flips in the last second");
    }
}

#[test]
fn another_master_is_named_and_waited_for() {
    let (kind, effect) = (Kind::Flip, Effect::Refused(Errno::ACCESS));
    let mut player = Player::on(Scripted::new().fail(Fault { kind, nth: 30, effect, ns: 60_000 * MS }));
    player.play(at(60_000));
    assert_eq!(player.lost(), ["another process is DRM master of /dev/dri/scripted"]);
    assert!(player.events.len() < 200, "{} events: a crash loop", player.events.len());
    player.play(at(65_000));
    assert!(player.flips.len() > 60, "the picture is back");
}

#[test]
fn no_display_at_the_start_is_waited_for() {
    let mut card = Scripted::new();
    card.plugs.extend([(at(0), false), (at(3_600_000), true)]);
    let _ = crate::kms::card::Kms::wait(&mut card, Duration::ZERO);
    let mut player = Player::on(card);
    assert_eq!(player.screen.info(), None);
    player.play(at(3_600_000));
    assert_eq!(player.lost(), ["no display is connected to /dev/dri/scripted"]);
    player.play(at(3_603_000));
    assert!(player.flips.len() > 60);
}

#[test]
fn what_other_processes_left_is_put_back_and_nothing_else_is_touched_by_flips() {
    let mut player = Player::on(Scripted::new());
    let (primary, overlay) = Scripted::planes();
    assert_eq!(player.screen.kms.value(overlay, "FB_ID"), 7, "the previous picture stays until ours is ready");
    player.play(at(2000));
    let card = &player.screen.kms;
    assert_eq!(card.value(overlay, "FB_ID"), 0);
    for (name, value) in [("rotation", 1), ("alpha", 0xffff), ("COLOR_ENCODING", 1), ("COLOR_RANGE", 0)] {
        assert_eq!(card.value(primary, name), value, "{name}");
    }
    assert_eq!(player.screen.info().unwrap().format, "YU12");
    assert_eq!(card.modesets, 1);
}

#[test]
fn a_plane_that_forgets_our_colours_gets_rgb() {
    let mut card = Scripted::new();
    card.quirk = Some(Quirk::ForgetsColours);
    let mut player = Player::on(card);
    player.play(at(3000));
    assert_eq!(player.screen.info().unwrap().format, "XR24");
    assert!(player.flips.len() > 30);
    assert_eq!(player.screen.kms.modesets, 3, "two formats lost their colours and one has none");
}

#[test]
fn a_healthy_card_gets_one_framebuffer_and_shows_its_parts_by_turns() {
    let mut player = Player::on(Scripted::new());
    let mut tops = std::collections::BTreeSet::new();
    for step in 0..60 {
        player.play(at(1000 + 33 * step));
        tops.extend(player.screen.kms.on_screen.map(|source| source.top));
    }
    assert_eq!((player.screen.kms.fbs.len(), tops), (1, [0, 48].into()));
}

#[test]
fn a_card_that_moves_no_window_gets_framebuffers_of_their_own() {
    for quirk in [Quirk::NoTallFramebuffers, Quirk::NoWindow, Quirk::StiffWindow] {
        let mut card = Scripted::new();
        card.quirk = Some(quirk);
        let mut player = Player::on(card);
        player.play(at(4000));
        let (card, format) = (&player.screen.kms, player.screen.info().unwrap().format);
        assert_eq!((card.fbs.len(), format.as_str()), (3, "YU12"), "{quirk:?}");
        assert!(player.flips.len() > 80, "{quirk:?}: {} flips", player.flips.len());
        assert_eq!(player.lost().is_empty(), quirk != Quirk::StiffWindow, "{quirk:?}: {:?}", player.lost());
    }
}

#[test]
fn a_display_that_comes_back_smaller_is_lit_in_its_own_mode() {
    let mut card = Scripted::new();
    card.plugs.push_back((at(2000), false));
    let mut player = Player::on(card);
    player.play(at(2500));
    let row = (48, 36, 250, 80, 52, drm::control::ModeFlags::empty(), true);
    player.screen.kms.modes = vec![mode(row)];
    player.screen.kms.plugs.push_back((at(2600), true));
    player.play(at(4000));
    assert_eq!(player.screen.info().unwrap().size, (48, 36));
    assert_eq!(player.screen.kms.fbs.len(), player.framebuffers());
}

/// From one flip of the screen to the next, in vblanks.
fn holds(player: &Player) -> Vec<i32> {
    let vblanks: Vec<Vblank> = player
        .events
        .iter()
        .filter_map(|event| if let Event::Flip { vblank, .. } = event { Some(*vblank) } else { None })
        .collect();
    vblanks.windows(2).map(|pair| pair[1].since(pair[0])).collect()
}

#[test]
fn frames_flip_at_every_second_vblank_of_a_healthy_card() {
    let mut player = Player::on(Scripted::new());
    player.play(at(5000));
    assert!(player.flips.len() > 110);
    assert!(holds(&player).iter().all(|&held| held == 2), "{:?}", holds(&player));
}

#[test]
fn a_card_without_vblanks_is_paced_by_our_own() {
    let mut player = Player::on(Scripted::of(&UNCOUNTED));
    player.play(at(5000));
    assert!((118..=121).contains(&player.flips.len()), "{} flips in four seconds", player.flips.len());
    assert!(holds(&player).iter().all(|&held| held == 2), "{:?}", holds(&player));
}

#[test]
fn a_player_that_was_late_itself_blames_no_flip() {
    let mut player = Player::on(Scripted::new());
    player.play(at(2000));
    for _ in 0..5 {
        super::oversleep(300 * MS);
        player.play(now().after(100 * MS));
    }
    assert!(!player.events.iter().any(|event| matches!(event, Event::Recovered { .. })), "{:?}", player.events);
}

#[test]
fn a_commit_before_its_predecessors_flip_is_ignored() {
    let mut player = Player::on(Scripted::new());
    player.play(at(2000));
    player.stage();
    player.screen.commit();
    player.stage();
    player.screen.commit();
    player.play(at(4000));
    assert!(!player.events.iter().any(|event| matches!(event, Event::Recovered { .. })), "{:?}", player.events);
    assert!(player.flips.len() > 85);
}

#[test]
fn a_screen_may_move_to_its_own_thread() {
    fn sendable<T: Send>() {}
    sendable::<KmsScreen>();
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(64) })]

    #[test]
    fn plugs_at_any_moment_with_a_fault_at_any_commit_leave_nothing_behind(
        gaps in prop::collection::vec(0..400 * MS, 0..40),
        kind in prop::sample::select(vec![Kind::Test, Kind::Light, Kind::Flip, Kind::Darken]),
        errno in prop::sample::select(vec![Errno::BUSY, Errno::ACCESS, Errno::INVAL, Errno::NODEV, Errno::IO]),
        (nth, ns) in (0..60u32, 0..600 * MS),
    ) {
        let mut card = Scripted::new().fail(Fault { kind, nth, effect: Effect::Refused(errno), ns });
        let mut time = now();
        for (index, gap) in gaps.iter().enumerate() {
            time = time.after(*gap);
            card.plugs.push_back((time, index % 2 == 1));
        }
        card.plugs.push_back((time, true));
        let mut player = Player::on(card);
        // A cable that toggled that often is waited for.
        player.play(time.after(16_000 * MS));
        let steady = player.flips.iter().filter(|flip| **flip > time.after(15_000 * MS)).count();
        prop_assert!(steady >= 29, "{} flips in the last second: {:?}", steady, player.events);
        prop_assert_eq!((player.screen.kms.fbs.len(), player.screen.kms.blobs.len()), (player.framebuffers(), 1));
    }
}
