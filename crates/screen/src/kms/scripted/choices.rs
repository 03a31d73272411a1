//! In which order ways to light a picture are tried.
//!
//! Owns the claims on the order, on cards of several families with real modes.

use super::Scripted;
use super::families::{generic::GENERIC, i915};
use super::family::{Family, ModeRow, mode};
use crate::kms::candidate::{Candidate, Rect, mode_size};
use crate::kms::card::{Connector, ConnectorStatus, Id, Kms, Survey};
use crate::kms::choose::{Request, candidates, images, unmet};
use crate::kms::modes::refresh;
use crate::output::{OutputSettings, RequestedMode, Rotation, SignalRange};
use drm::control::ModeFlags;
use timing::Rate;

const P: ModeFlags = ModeFlags::empty();
const HD60: ModeRow = (1280, 720, 74_250, 1650, 750, P, false);
const HD5994: ModeRow = (1280, 720, 74_176, 1650, 750, P, false);
const HD50: ModeRow = (1280, 720, 74_250, 1980, 750, P, false);
const FULL60: ModeRow = (1920, 1080, 148_500, 2200, 1125, P, true);
const FULL5994: ModeRow = (1920, 1080, 148_352, 2200, 1125, P, true);
const FULL50: ModeRow = (1920, 1080, 148_500, 2640, 1125, P, false);
const FULL_I: ModeRow = (1920, 1080, 74_250, 2200, 1125, ModeFlags::INTERLACE, false);
const WXGA60: ModeRow = (1366, 768, 85_500, 1792, 796, P, true);
const VGA: ModeRow = (640, 480, 25_200, 800, 525, P, false);
const UHD60: ModeRow = (3840, 2160, 594_000, 4400, 2250, P, true);

const HD: (u32, u32) = (1280, 720);

fn hz(n: u64, d: u64) -> Rate {
    Rate::new(n, d).unwrap()
}

/// A card of this family, with one display that has these modes.
fn survey(family: &'static Family, rows: &[ModeRow]) -> Survey {
    let mut card = Scripted::of(family);
    card.modes = rows.iter().map(|&row| mode(row)).collect();
    card.open().unwrap();
    card.survey().unwrap()
}

/// In which order ways are tried, as mode and placement, without those that differ in nothing else.
fn order(survey: &Survey, fps: Rate, output: &OutputSettings) -> Vec<String> {
    let candidates = candidates(survey, Request { size: HD, fps, output });
    let mut told: Vec<String> = Vec::new();
    for way in candidates {
        let (width, height) = mode_size(&way.mode);
        let way = format!("{width}x{height}@{} {:?}", refresh(&way.mode).unwrap(), way.placement);
        if told.last() != Some(&way) {
            told.push(way);
        }
    }
    told
}

fn best(rows: &[ModeRow], fps: Rate) -> String {
    order(&survey(&GENERIC, rows), fps, &OutputSettings::default()).swap_remove(0)
}

#[test]
fn the_panels_own_mode_comes_first_then_the_pictures_and_last_what_costs_most() {
    let all = [FULL60, HD60, VGA, FULL_I];
    assert_eq!(
        order(&survey(&GENERIC, &all), hz(30, 1), &OutputSettings::default()),
        [
            "1920x1080@60 ByPlane",
            "1280x720@60 ByPlane",
            "1920x1080@60 ByCopy",
            "1280x720@60 ByCopy",
            "640x480@60 ByCopy",
            "640x480@60 ByPlane",
        ]
    );
    let far = order(&survey(&GENERIC, &[UHD60, HD60]), hz(30, 1), &OutputSettings::default());
    assert_eq!(far.last().unwrap(), "3840x2160@60 ByCopy", "scaling to it costs most: {far:?}");
}

#[test]
fn of_one_size_the_refresh_is_taken_that_frames_are_even_at() {
    let all = [FULL60, FULL50, HD60];
    assert_eq!(best(&all, hz(30, 1)), "1920x1080@60 ByPlane");
    assert_eq!(best(&all, hz(25, 1)), "1920x1080@50 ByPlane");
    assert_eq!(best(&[FULL50, FULL5994], hz(30, 1)), "1920x1080@148352/2475 ByPlane", "a thousandth is even, too");
    assert_eq!(best(&[HD5994, HD60], hz(30, 1)), "1280x720@60 ByPlane");
    assert_eq!(best(&[HD5994, HD60, HD50], hz(30_000, 1_001)), "1280x720@148352/2475 ByPlane");
}

#[test]
fn interlaced_modes_are_the_last_resort() {
    assert_eq!(best(&[FULL_I, VGA], hz(30, 1)), "640x480@60 ByPlane");
    assert_eq!(best(&[VGA, WXGA60], hz(30, 1)), "1366x768@2671875/44576 ByPlane");
    assert!(best(&[FULL_I], hz(30, 1)).starts_with("1920x1080"));
}

#[test]
fn a_display_that_tells_of_no_mode_gets_one() {
    let told = order(&survey(&GENERIC, &[]), hz(30, 1), &OutputSettings::default());
    assert!(told[0].starts_with("1024x768@"), "{told:?}");
}

#[test]
fn the_mode_that_is_asked_for_comes_first_also_where_the_display_does_not_tell_of_it() {
    let asked =
        |text: &str| OutputSettings { mode: Some(text.parse::<RequestedMode>().unwrap()), ..OutputSettings::default() };
    let all = survey(&GENERIC, &[FULL60, HD60, HD50, VGA]);
    assert_eq!(order(&all, hz(30, 1), &asked("1280x720@50"))[0], "1280x720@50 ByPlane");
    assert_eq!(order(&all, hz(30, 1), &asked("640x480"))[..2], ["640x480@60 ByPlane", "640x480@60 ByCopy"]);
    let computed = order(&all, hz(30, 1), &asked("1440x900@60"));
    assert!(computed[0].starts_with("1440x900@") && computed[2] == "1920x1080@60 ByPlane", "{computed:?}");
    let candidates = candidates(&all, Request { size: HD, fps: hz(30, 1), output: &asked("1440x900@60") });
    assert!(unmet(&all, &asked("1440x900@60"), &candidates[0]).is_empty());
    let else_where = candidates.iter().find(|way| mode_size(&way.mode) == (1920, 1080)).unwrap();
    assert_eq!(
        unmet(&all, &asked("1440x900@60"), else_where),
        ["The display does not accept the mode 1440x900@60. It shows 1920x1080."]
    );
}

#[test]
fn the_connector_that_is_asked_for_comes_first_and_one_that_cannot_tell_last() {
    let mut all = survey(&GENERIC, &[FULL60]);
    for (id, name, plug) in [
        (31, "HDMI-A-2", ConnectorStatus::In),
        (32, "VGA-1", ConnectorStatus::Unknown),
        (33, "DP-1", ConnectorStatus::Out),
    ] {
        let more = Connector { id: Id(id), name: name.to_owned(), plug, ..all.connectors[0].clone() };
        all.connectors.push(more);
    }
    let named = |output: &OutputSettings| {
        let candidates = candidates(&all, Request { size: HD, fps: hz(30, 1), output });
        let name =
            |way: &Candidate| all.connectors.iter().find(|found| found.id == way.connector).unwrap().name.clone();
        let mut names: Vec<_> = candidates.iter().map(name).collect();
        names.dedup();
        (names, unmet(&all, output, &candidates[0]))
    };
    let at = |connector: &str, mode: Option<&str>| OutputSettings {
        connector: Some(connector.to_owned()),
        mode: mode.map(|mode| mode.parse().unwrap()),
        ..OutputSettings::default()
    };
    assert_eq!(named(&OutputSettings::default()).0, ["HDMI-A-1", "HDMI-A-2", "VGA-1"]);
    assert_eq!(named(&at("HDMI-A-2", None)), (["HDMI-A-2", "HDMI-A-1", "VGA-1"].map(str::to_owned).to_vec(), vec![]));
    let (order, told) = named(&at("DP-1", None));
    assert_eq!(order, ["HDMI-A-1", "HDMI-A-2", "VGA-1"]);
    assert_eq!(told, ["No display is connected to DP-1. The picture is on HDMI-A-1."]);
    assert_eq!(named(&at("DP-1", Some("1280x720"))).0, ["HDMI-A-1", "HDMI-A-2", "VGA-1", "DP-1"]);
    let (_, told) = named(&at("HDMI-A-9", None));
    assert_eq!(told, ["There is no connector HDMI-A-9. The connectors are: HDMI-A-1, HDMI-A-2, VGA-1, DP-1."]);
    let range = OutputSettings { range: SignalRange::Limited, ..OutputSettings::default() };
    assert_eq!(
        named(&range).1,
        ["The signal range of HDMI-A-1 cannot be set to limited: its driver has no such setting."]
    );
}

#[test]
fn a_panel_that_is_built_in_on_its_side_is_rotated_for_and_the_owners_rotation_adds_up() {
    let panel = survey(&i915::ALDER_LAKE_N, &[(720, 1280, 74_250, 800, 1547, P, true)]);
    let first = |rotation| {
        let output = OutputSettings { rotation, ..OutputSettings::default() };
        let candidates = candidates(&panel, Request { size: HD, fps: hz(30, 1), output: &output });
        (candidates[0].plane_rotation, candidates[0].copy_rotation, candidates[0].destination(HD))
    };
    let whole = Rect { left: 0, top: 0, width: 720, height: 1280 };
    // Its right side is up: by a quarter clockwise the picture stands upright. The plane turns it by a half at most.
    assert_eq!(first(Rotation::None), (Rotation::None, Rotation::Clockwise90, whole));
    assert_eq!(first(Rotation::Half), (Rotation::None, Rotation::Clockwise270, whole));
    assert_eq!(first(Rotation::Clockwise90).0, Rotation::Half, "the plane does it");
}

#[test]
fn a_plane_without_a_colour_matrix_gets_rgb() {
    let formats = |family: &'static Family| {
        let survey = survey(family, &[HD60]);
        let plane = survey.planes.iter().find(|plane| plane.properties.value("type") == 1).unwrap();
        let named = images(plane)
            .into_iter()
            .map(|(format, framebuffers)| format!("{} {framebuffers:?}", format.format.name()));
        named.collect::<Vec<_>>()
    };
    assert_eq!(formats(&GENERIC), ["YU12 Shared", "YU12 Own", "NV12 Shared", "NV12 Own", "XR24 Own"]);
    assert_eq!(formats(&i915::KABY_LAKE), ["NV12 Shared", "NV12 Own", "XR24 Own"]);
    assert_eq!(formats(&i915::HASWELL), ["XR24 Own"]);
}
