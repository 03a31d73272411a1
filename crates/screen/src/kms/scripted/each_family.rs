//! Every family of drivers, from bring-up to the night.
//!
//! Owns the claims that hold on each of them: what is lit and how, that it plays evenly, that a cable, a night, a dimmer
//! light and a rotation cost no frame and leave nothing behind. The rules that no run may break are asserted by the card
//! itself.
//!
//! Start at [`each`].

use super::families::generic::GENERIC;
use super::families::{ALL, amdgpu, i915, simple, vc4};
use super::family::{Family, ValueRange, mode};
use super::fault_matrix::{Player, at};
use super::{MS, Scripted};
use crate::kms::Phase;
use crate::kms::candidate::{Placement, mode_size};
use crate::kms::card::ConnectorStatus;
use crate::output::{OutputSettings, SignalRange};
use crate::{Event, Light, Screen};
use drm::control::{Mode, ModeFlags};
use timing::Nanos;

/// Pictures, and a display whose own mode is half as large again.
const SIZE: (u32, u32) = (128, 72);
const NATIVE: (u16, u16) = (192, 108);

fn row((width, height): (u16, u16), preferred: bool) -> Mode {
    // 60 Hz: 100 lines and columns of blanking, and a clock in whole kilohertz near to that.
    let (across, down) = (width + 100, height + 100);
    let khz = u32::from(across) * u32::from(down) * 60 / 1000;
    mode((width, height, khz, across, down, ModeFlags::empty(), preferred))
}

/// A card of `family` with that display.
fn card(family: &'static Family) -> Scripted {
    let mut card = Scripted::of(family);
    card.modes = vec![row(NATIVE, true), row((128, 72), false), row((96, 54), false)];
    card
}

/// Runs `claim` with a player on each family.
fn each(output: &OutputSettings, mut claim: impl FnMut(&'static Family, Player)) {
    for family in ALL {
        claim(family, Player::with(card(family), SIZE, output.clone()));
    }
}

/// How the picture is lit: mode, who scales it, format, number of framebuffers.
fn lit(player: &Player) -> ((u32, u32), Placement, &'static str, usize) {
    let Phase::Up(output) = &player.screen.phase else { panic!("the screen is up") };
    let way = &output.plan.way;
    (mode_size(&way.mode), way.placement, way.format.format.name(), player.screen.kms.fbs.len())
}

/// Whether every flip since `from` came two vblanks after the one before.
fn is_even(player: &Player, from: Nanos) -> bool {
    let flips: Vec<_> = player.flips.iter().filter(|flip| **flip > from).collect();
    let period = 2 * player.screen.kms.period();
    let off = |pair: &[&Nanos]| pair[1].since(*pair[0]).abs_diff(period) < MS;
    flips.len() > 20 && flips.windows(2).all(off)
}

#[test]
fn each_family_lights_the_picture_in_the_way_that_suits_it() {
    let (native, own) = ((192, 108), (128, 72));
    let expected = [
        (&i915::HASWELL, (own, Placement::ByPlane, "XR24", 3)),
        (&i915::SKYLAKE, (native, Placement::ByPlane, "XR24", 3)),
        (&i915::KABY_LAKE, (native, Placement::ByPlane, "NV12", 1)),
        (&i915::TIGER_LAKE, (native, Placement::ByPlane, "NV12", 1)),
        (&i915::ALDER_LAKE_N, (native, Placement::ByPlane, "NV12", 1)),
        (&amdgpu::DCN1, (native, Placement::ByPlane, "NV12", 3)),
        (&amdgpu::DCN2, (native, Placement::ByPlane, "NV12", 1)),
        (&amdgpu::DCE, (native, Placement::ByPlane, "XR24", 3)),
        (&vc4::PI4, (native, Placement::ByPlane, "YU12", 1)),
        (&simple::SIMPLEDRM, (native, Placement::ByCopy, "XR24", 3)),
        (&simple::VIRTIO_GPU, (own, Placement::ByPlane, "XR24", 3)),
        (&simple::BOCHS, (own, Placement::ByPlane, "XR24", 3)),
    ];
    let mut ways = expected.iter();
    each(&OutputSettings::default(), |family, mut player| {
        player.play(at(4_000));
        let (known, way) = ways.next().unwrap();
        assert!(std::ptr::eq(*known, family), "{}", family.about);
        assert_eq!(lit(&player), *way, "{}", family.about);
        assert!(player.lost().is_empty(), "{}: {:?}", family.about, player.lost());
        assert!(is_even(&player, at(1_200)), "{}: {} flips", family.about, player.flips.len());
        assert_eq!(player.screen.info().unwrap().notes, [""; 0], "{}", family.about);
    });
}

#[test]
fn what_others_left_is_put_into_a_known_state() {
    each(&OutputSettings::default(), |family, mut player| {
        player.play(at(3_000));
        for (kind, object) in Scripted::objects().into_iter().filter(|(kind, _)| *kind != 'o') {
            let ours = ["CRTC_ID", "FB_ID", "SRC_", "CRTC_", "ACTIVE", "MODE_ID"];
            let settable = |row: &&super::family::Row| row.kinds.contains(kind) && !row.is_fixed;
            for row in family.all().filter(settable).filter(|row| !ours.iter().any(|our| row.name.starts_with(our))) {
                let value = player.screen.kms.value(object, row.name);
                match (row.name, row.takes) {
                    ("max bpc", _) => assert!(value >= 8, "{}: `max bpc` is {value}", family.about),
                    // As the panel is built in, or as its kind has it.
                    ("rotation", ValueRange::Bits(_)) => assert!(row.takes(value) && value != 0, "{}", family.about),
                    _ => assert_eq!(value, row.neutral, "{}: `{}`", family.about, row.name),
                }
            }
        }
        if family.has_overlay {
            let overlay = Scripted::planes().1;
            assert_eq!(player.screen.kms.value(overlay, "FB_ID"), 0, "{}", family.about);
        }
    });
}

#[test]
fn a_cable_that_is_pulled_brings_the_picture_back_on_each_family() {
    for family in ALL {
        let mut card = card(family);
        card.plugs.extend([(at(3_000), false), (at(4_500), true), (at(7_000), false), (at(7_050), true)]);
        let mut player = Player::with(card, SIZE, OutputSettings::default());
        player.play(at(10_000));
        let lost = player.lost().len();
        assert_eq!(lost, 1, "{}: a moment without a display is none: {:?}", family.about, player.lost());
        assert!(is_even(&player, at(8_000)), "{}", family.about);
        let (ways, blobs) = (player.framebuffers(), player.screen.kms.blobs.len());
        assert_eq!((player.screen.kms.fbs.len(), blobs), (ways, 1), "{}", family.about);
    }
}

#[test]
fn connectors_that_change_all_the_time_make_no_frame_late() {
    for family in ALL {
        let mut card = card(family);
        // Told again and again, each time with a probe of 40 ms, while the display stays.
        card.plugs.extend((0..60).map(|time| (at(2_000 + 50 * time), true)));
        let mut player = Player::with(card, SIZE, OutputSettings::default());
        player.play(at(6_000));
        assert!(is_even(&player, at(1_500)), "{}: {:?}", family.about, player.flips);
    }
}

#[test]
fn each_family_sleeps_at_night_and_is_lit_again() {
    each(&OutputSettings::default(), |family, mut player| {
        player.play(at(2_000));
        player.screen.set_light(Light::Off);
        player.play(at(4_000));
        let card = &player.screen.kms;
        assert!(!card.is_on() && card.fbs.is_empty() && card.blobs.is_empty(), "{}", family.about);
        player.screen.set_light(Light::FULL);
        player.play(at(8_000));
        assert!(is_even(&player, at(5_000)), "{}", family.about);
        let told = |wanted: Event| player.events.iter().filter(|event| **event == wanted).count();
        assert_eq!((told(Event::Asleep), told(Event::Back)), (1, 1), "{}", family.about);
    });
}

/// How bright the brightest sample is: by the CRTC's ramp or matrix, times what was left of it in the buffer.
fn brightness(player: &Player) -> f64 {
    let card = &player.screen.kms;
    let Phase::Up(output) = &player.screen.phase else { panic!("the screen is up") };
    f64::from(card.brightest()) / f64::from(u16::MAX) * f64::from(output.dimming.software_dim()) / 1000.0
}

#[test]
fn each_family_is_dimmed_and_no_frame_is_late_for_it() {
    each(&OutputSettings::default(), |family, mut player| {
        player.play(at(2_000));
        for (step, thousandths) in (300..=1000_u16).rev().step_by(50).enumerate() {
            player.screen.set_light(Light::On { thousandths });
            player.play(at(2_100 + 100 * step as u64));
            let wanted = f64::from(thousandths) / 1000.0;
            assert!((brightness(&player) - wanted).abs() < 0.001, "{} at {thousandths}", family.about);
        }
        assert!(is_even(&player, at(1_500)), "{}", family.about);
        assert!(player.lost().is_empty() && player.screen.kms.modesets == 1, "{}", family.about);
    });
}

#[test]
fn each_family_shows_the_picture_upright_whichever_way_the_display_hangs() {
    for degrees in ["0", "90", "180", "270"] {
        let output = OutputSettings { rotation: degrees.parse().unwrap(), ..OutputSettings::default() };
        each(&output, |family, mut player| {
            player.play(at(2_500));
            let about = format!("{} at {degrees}", family.about);
            assert!(is_even(&player, at(1_200)), "{about}");
            assert_eq!(player.screen.info().unwrap().notes, [""; 0], "{about}");
            let Phase::Up(lit) = &player.screen.phase else { panic!("{about}") };
            let way = &lit.plan.way;
            let panel = if family.connector == "eDP-1" { 90 } else { 0 };
            let turned = way.copy_rotation.then(way.plane_rotation).degrees();
            assert_eq!(turned, (degrees.parse::<u32>().unwrap() + panel) % 360, "{about}");
            let set = player.screen.kms.value(Scripted::planes().0, "rotation");
            let by_plane = [1, 8, 4, 2][(way.plane_rotation.degrees() / 90) as usize];
            assert!(set == by_plane || set == 0 && by_plane == 1, "{about}: the plane is told {set}");
            let buffer = way.buffer_size(SIZE);
            let area = way.area(SIZE, buffer);
            let (across, down) = (area.left + area.width / 2, area.top + area.height / 2);
            let sides = [
                (across, area.top + 2),
                (area.left + area.width - 3, down),
                (across, area.top + area.height - 3),
                (area.left + 2, down),
            ];
            let levels = sides.map(|side| player.screen.kms.sample(side));
            // The picture's upper half is the brighter one.
            let bright = (way.copy_rotation.degrees() / 90) as usize;
            assert!(levels[bright] > levels[(bright + 2) % 4] + 60, "{about}: {levels:?}");
            let is_quarter = turned % 180 == 90;
            let on_mode = way.destination(SIZE);
            if way.placement == Placement::ByPlane {
                assert_eq!(on_mode.width < on_mode.height, is_quarter, "{about}: {on_mode:?}");
            }
        });
    }
}

#[test]
fn portrait_pictures_fill_a_display_that_hangs_on_its_side() {
    let output = OutputSettings { rotation: "90".parse().unwrap(), ..OutputSettings::default() };
    for family in ALL.into_iter().filter(|family| family.connector != "eDP-1") {
        let mut player = Player::with(card(family), (72, 128), output.clone());
        player.play(at(2_500));
        let Phase::Up(lit) = &player.screen.phase else { panic!("{}", family.about) };
        let (mode, on_mode) = (mode_size(&lit.plan.way.mode), lit.plan.way.destination((72, 128)));
        assert_eq!((on_mode.width, on_mode.height), mode, "{}", family.about);
        assert!(is_even(&player, at(1_200)), "{}", family.about);
    }
}

#[test]
fn the_levels_are_forced_where_the_driver_can_and_told_where_it_cannot() {
    for (range, value) in [(SignalRange::Full, 1), (SignalRange::Limited, 2)] {
        let output = OutputSettings { range, ..OutputSettings::default() };
        each(&output, |family, mut player| {
            player.play(at(2_000));
            let connector = Scripted::objects()[0].1;
            let notes = player.screen.info().unwrap().notes;
            if family.named('n', "Broadcast RGB").is_some() {
                assert_eq!(player.screen.kms.value(connector, "Broadcast RGB"), value, "{}", family.about);
                assert_eq!(notes, [""; 0]);
            } else {
                let told = format!(
                    "The signal range of {} cannot be set to {range}: its driver has no such setting.",
                    family.connector
                );
                assert_eq!(notes, [told]);
            }
        });
    }
}

#[test]
fn what_the_owner_changes_holds_from_the_next_picture_on_without_a_dark_moment() {
    each(&OutputSettings::default(), |family, mut player| {
        player.play(at(2_000));
        for (second, rotation, margin) in [(3, "180", "0"), (4, "0", "5"), (5, "90", "10"), (6, "0", "0")] {
            let (rotation, margin) = (rotation.parse().unwrap(), margin.parse().unwrap());
            player.screen.set_output(&OutputSettings { rotation, margin, ..OutputSettings::default() });
            player.play(at(1_000 * second));
            let Phase::Up(lit) = &player.screen.phase else { panic!("{}", family.about) };
            assert_eq!(lit.plan.way.margin, margin, "{}", family.about);
        }
        assert!(player.lost().is_empty(), "{}: {:?}", family.about, player.lost());
        assert!(player.longest_pause_ms() <= 120, "{}: {} ms", family.about, player.longest_pause_ms());
        assert_eq!((player.screen.kms.fbs.len(), player.screen.kms.blobs.len()), (player.framebuffers(), 1));
    });
}

#[test]
fn a_better_mode_that_is_told_of_late_is_taken() {
    for family in ALL.into_iter().filter(|family| !family.limits.has_one_mode) {
        let mut all = card(family);
        let modes = std::mem::replace(&mut all.modes, vec![row((96, 54), false)]);
        let known = all.modes[0];
        all.late_modes = Some((at(3_000), modes.into_iter().chain([known]).collect()));
        let mut player = Player::with(all, SIZE, OutputSettings::default());
        player.play(at(2_500));
        assert_eq!(lit(&player).0, (96, 54), "{}", family.about);
        player.play(at(5_000));
        let best = if family.limits.shrinks > 0 { (192, 108) } else { (128, 72) };
        assert_eq!(lit(&player).0, best, "{}", family.about);
        assert!(player.lost().is_empty() && player.longest_pause_ms() < 120, "{}", family.about);
    }
}

#[test]
fn a_display_that_does_not_answer_gets_a_picture() {
    for family in ALL.into_iter().filter(|family| !family.limits.has_one_mode) {
        let mut silent = card(family);
        (silent.plug, silent.modes) = (ConnectorStatus::Unknown, Vec::new());
        let mut player = Player::with(silent, SIZE, OutputSettings::default());
        player.play(at(3_000));
        assert_eq!(lit(&player).0, (1024, 768), "{}", family.about);
        assert!(player.flips.len() > 40, "{}", family.about);
    }
}

#[test]
fn the_native_driver_takes_over_from_the_firmwares_picture() {
    for native in ALL.into_iter().filter(|family| family.driver != "simpledrm") {
        let mut early = card(&simple::SIMPLEDRM);
        early.handover = Some((at(3_000), native));
        let mut player = Player::with(early, SIZE, OutputSettings::default());
        player.play(at(7_000));
        assert!(is_even(&player, at(4_500)), "{}", native.about);
        assert!(player.longest_pause_ms() < 1_000, "{}: {} ms", native.about, player.longest_pause_ms());
        assert_eq!(player.lost().len(), 1, "{}: {:?}", native.about, player.lost());
    }
}

#[test]
fn a_mode_that_is_too_fast_for_the_port_gives_way_to_the_next() {
    let mut pi = card(&vc4::PI4);
    pi.modes.insert(0, mode((3840, 2160, 594_000, 4400, 2250, ModeFlags::empty(), true)));
    let mut player = Player::with(pi, SIZE, OutputSettings::default());
    player.play(at(3_000));
    assert_eq!(lit(&player).0, (128, 72), "the panel's own is refused");
    assert_eq!(GENERIC.limits.fastest_khz, 600_000);
}
