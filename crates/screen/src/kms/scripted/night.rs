//! The night, and dimming, on a scripted card.
//!
//! Owns the claims of `light.rs` that take a card. The rules that no run may break are asserted by the card itself.

use super::families::generic::MATRIX;
use super::fault_matrix::{CARDS, Player, at};
use super::{Effect, Fault, Kind, MS, Quirk, Scripted, now};
use crate::kms::Phase;
use crate::{DimmedBy, Event, Light, Screen};
use rustix::io::Errno;
use std::time::Duration;

const DIM: Light = Light::On { thousandths: 500 };

/// Whether the screen sleeps, in good order.
fn sleeps(player: &Player) -> bool {
    let card = &player.screen.kms;
    matches!(player.screen.phase, Phase::Asleep) && !card.is_on() && card.fbs.is_empty() && card.blobs.is_empty()
}

#[test]
fn a_display_sleeps_in_good_order_and_is_lit_again_when_it_is_woken() {
    for quirk in CARDS {
        let mut card = Scripted::new();
        card.quirk = quirk;
        let mut player = Player::on(card);
        for day in 1..=20 {
            player.play(at(10_000 * day));
            // At any moment: a flip is in flight, or is not.
            player.screen.set_light(Light::Off);
            player.play(at(10_000 * day + 3_000 + 7 * day));
            assert!(sleeps(&player), "day {day}");
            assert_eq!((player.screen.info(), player.screen.next_event(Duration::ZERO)), (None, Event::Idle));
            player.screen.set_light(Light::FULL);
            let before = player.flips.len();
            player.play(at(10_000 * day + 5_000));
            assert!(player.screen.kms.is_on() && player.flips.len() > before + 50, "day {day}");
        }
        let told = |wanted: Event| player.events.iter().filter(|event| **event == wanted).count();
        assert_eq!((told(Event::Asleep), told(Event::Back), player.lost().len()), (20, 20, 0));
    }
}

#[test]
fn a_run_that_begins_at_night_switches_off_what_the_boot_left_there() {
    let mut player = Player::on(Scripted::new());
    player.screen.set_light(Light::Off);
    player.play(at(60_000));
    assert!(sleeps(&player));
    assert_eq!((player.flips.len(), player.screen.kms.modesets), (0, 0), "nothing was lit");
}

#[test]
fn whatever_is_plugged_at_night_is_left_alone_until_the_day() {
    let mut card = Scripted::new();
    card.plugs.extend([(at(3000), false), (at(4000), true), (at(5000), false)]);
    let mut player = Player::on(card);
    player.play(at(2000));
    player.screen.set_light(Light::Off);
    player.play(at(6000));
    assert!(sleeps(&player));
    player.screen.set_light(Light::FULL);
    player.play(at(7000));
    assert_eq!(player.lost(), ["no display is connected to /dev/dri/scripted"]);
    player.screen.kms.plugs.push_back((at(8000), true));
    player.play(at(11_000));
    assert!(player.flips.iter().any(|flip| *flip > at(8000)), "the day shows what is there by then");
}

#[test]
fn every_error_on_the_way_into_the_night_and_out_of_it_is_survived() {
    for errno in [Errno::BUSY, Errno::ACCESS, Errno::INVAL, Errno::NODEV, Errno::IO] {
        for (kind, nth) in [(Kind::Darken, 0), (Kind::Light, 1), (Kind::Test, 5), (Kind::Flip, 30)] {
            for ns in [0, 50 * MS, 400 * MS] {
                let mut player =
                    Player::on(Scripted::new().fail(Fault { kind, nth, effect: Effect::Refused(errno), ns }));
                for day in 1..=3 {
                    player.play(at(3_000 * day));
                    player.screen.set_light(Light::Off);
                    player.play(at(3_000 * day + 1_000));
                    assert!(sleeps(&player), "{errno:?} at {kind:?}, day {day}");
                    player.screen.set_light(DIM);
                }
                player.play(at(20_000));
                let steady = player.flips.iter().filter(|flip| **flip > at(19_000)).count();
                assert!(steady >= 29, "{errno:?} at {kind:?}: {steady} flips in the last second");
            }
        }
    }
}

#[test]
fn a_display_is_dimmed_with_a_flip_and_stays_dimmed_across_a_cable_that_is_pulled() {
    let mut card = Scripted::new();
    card.plugs.extend([(at(5000), false), (at(5700), true)]);
    let mut player = Player::on(card);
    player.play(at(2000));
    let modesets = player.screen.kms.modesets;
    for (step, thousandths) in (1..=999).rev().step_by(37).enumerate() {
        player.screen.set_light(Light::On { thousandths });
        player.play(at(2100 + 50 * step as u64));
        let expected = u32::from(u16::MAX) * u32::from(thousandths) / 1000;
        assert_eq!(u32::from(player.screen.kms.brightest()), expected);
    }
    player.screen.set_light(DIM);
    player.play(at(4900));
    assert_eq!(player.screen.kms.modesets, modesets, "no mode was set for it");
    player.play(at(8000));
    let card = &player.screen.kms;
    assert_eq!((card.brightest(), card.blobs.len()), (u16::MAX / 2, 2), "dimmed from its first picture on");
    player.screen.set_light(Light::FULL);
    player.play(at(9000));
    let card = &player.screen.kms;
    assert_eq!((card.brightest(), card.blobs.len()), (u16::MAX, 1));
}

#[test]
fn a_card_that_takes_no_ramp_has_its_samples_dimmed() {
    let mut card = Scripted::new();
    card.quirk = Some(Quirk::StiffRamp);
    let mut player = Player::on(card);
    player.play(at(2000));
    for step in 0..100 {
        player.screen.set_light(Light::On { thousandths: 900 - step });
        player.play(now().after(30 * MS));
    }
    assert_eq!((player.screen.kms.brightest(), player.screen.kms.blobs.len()), (u16::MAX, 1));
    let Phase::Up(output) = &player.screen.phase else { panic!("the screen is up") };
    assert_eq!(output.dimming.software_dim(), 801);
    assert_eq!(player.screen.info().unwrap().dimmed_by, DimmedBy::Samples);
    assert!(player.lost().is_empty() && player.longest_pause_ms() < 50, "{:?}", player.lost());
}

#[test]
fn a_card_with_a_matrix_and_no_ramp_is_dimmed_by_that() {
    let mut player = Player::on(Scripted::of(&MATRIX));
    for (second, thousandths) in [(2, 700), (3, 250), (4, 1000)] {
        player.screen.set_light(Light::On { thousandths });
        player.play(at(1_000 * second));
        let expected = u32::from(u16::MAX) * u32::from(thousandths) / 1000;
        assert!(u32::from(player.screen.kms.brightest()).abs_diff(expected) <= 1, "{thousandths}");
    }
    assert_eq!(player.screen.kms.modesets, 1);
}

#[test]
fn a_display_with_a_backlight_is_dimmed_by_it_and_its_samples_stay_as_they_are() {
    let mut card = Scripted::new();
    card.quirk = Some(Quirk::Backlight);
    card.plugs.extend([(at(5000), false), (at(5700), true)]);
    let mut player = Player::on(card);
    for (until, thousandths) in [(2_000, 1000), (3_000, 999), (4_000, 300), (8_000, 500), (9_000, 1000)] {
        player.screen.set_light(Light::On { thousandths });
        player.play(at(until));
        let card = &player.screen.kms;
        assert_eq!((card.backlight, card.brightest(), card.blobs.len()), (thousandths, u16::MAX, 1));
    }
    assert_eq!(player.screen.info().unwrap().dimmed_by, DimmedBy::Backlight);
}
