//! Choice of connector, CRTC, plane, mode, format and placement.
//!
//! Owns the order of preference, as pure functions of a survey. `bring_up.rs` tries the candidates in this order with a
//! test commit, and takes the first that the kernel accepts. The modes to try are in `modes.rs`, a candidate's geometry
//! in `candidate.rs`.
//!
//! Start at [`candidates`].

use super::candidate::{Candidate, Framebuffers, Placement, mode_size};
use super::card::{Connector, ConnectorStatus, Crtc, Id, Plane, PlaneFormat, Survey};
use super::modes::{Modes, is_near};
use crate::output::{OutputSettings, Rotation, SignalRange};
use crate::paint::Format;
use drm::control::Mode;
use timing::Rate;

/// Largest mode, in pixels, that pictures are scaled to by the processor if there is an alternative. The cost per frame
/// is proportional.
const AFFORDABLE: u64 = 1920 * 1200;

/// The pictures to light, and the owner's settings.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Request<'a> {
    /// Pixels across and down, even.
    pub(crate) size: (u32, u32),
    /// Pictures a second.
    pub(crate) fps: Rate,
    /// What the owner has set.
    pub(crate) output: &'a OutputSettings,
}

/// All candidates for the request, best first; empty if no display is connected. In this order: the mode that was asked
/// for; the panel's native one, if the plane scales to it; that of the picture's own size; the native one, scaled by
/// copying; others.
pub(crate) fn candidates(survey: &Survey, request: Request<'_>) -> Vec<Candidate> {
    let mut candidates = Vec::new();
    for connector in connectors(survey, request.output) {
        for (mode, placement) in placed_modes(connector, request) {
            for crtc in crtcs(survey, connector) {
                for plane in planes(survey, crtc) {
                    candidates.extend(on_plane(connector, crtc, plane, mode, placement, request.output));
                }
            }
        }
    }
    candidates
}

/// The settings in `output` that the chosen candidate does not fulfil, each as a sentence.
pub(crate) fn unmet(survey: &Survey, output: &OutputSettings, lit: &Candidate) -> Vec<String> {
    let mut unmet = Vec::new();
    let found = |id: Id| survey.connectors.iter().find(|connector| connector.id == id);
    let lit_at = found(lit.connector).map_or("another", |connector| connector.name.as_str());
    if let Some(wanted) = output.connector.as_deref().filter(|wanted| *wanted != lit_at) {
        let names: Vec<_> = survey.connectors.iter().map(|connector| connector.name.as_str()).collect();
        unmet.push(if names.contains(&wanted) {
            format!("No display is connected to {wanted}. The picture is on {lit_at}.")
        } else {
            format!("There is no connector {wanted}. The connectors are: {}.", names.join(", "))
        });
    }
    let has_range = found(lit.connector).is_some_and(|connector| connector.properties.get("Broadcast RGB").is_some());
    if output.range != SignalRange::Automatic && !has_range {
        unmet.push(format!(
            "The signal range of {lit_at} cannot be set to {}: its driver has no such setting.",
            output.range
        ));
    }
    if let Some(wanted) = output.mode.filter(|wanted| !is_near(&lit.mode, *wanted)) {
        let (width, height) = mode_size(&lit.mode);
        unmet.push(format!("The display does not accept the mode {wanted}. It shows {width}x{height}."));
    }
    unmet
}

/// The connectors that may have a display: the one that was asked for, then the connected ones, then those of unknown
/// status.
fn connectors<'a>(survey: &'a Survey, output: &OutputSettings) -> Vec<&'a Connector> {
    let is_named = |connector: &Connector| output.connector.as_deref() == Some(connector.name.as_str());
    // If both connector and mode are set, the display need not be detected.
    let is_forced = |connector: &Connector| is_named(connector) && output.mode.is_some();
    let mut found: Vec<&Connector> = survey
        .connectors
        .iter()
        .filter(|connector| connector.plug != ConnectorStatus::Out || is_forced(connector))
        .collect();
    found.sort_by_key(|connector| {
        let is_driven = connector.properties.object("CRTC_ID").is_some();
        (
            !is_named(connector) || connector.plug == ConnectorStatus::Out,
            connector.plug,
            connector.modes.is_empty(),
            !is_driven,
            connector.id,
        )
    });
    found
}

/// The modes to try at `connector`, each with its placement.
fn placed_modes(connector: &Connector, request: Request<'_>) -> Vec<(Mode, Placement)> {
    let rotation = rotation(connector, request.output);
    let modes = Modes::of(connector, rotation.of_size(request.size), request.fps, request.output.mode);
    let is_affordable = |mode: &Mode| u64::from(mode_size(mode).0) * u64::from(mode_size(mode).1) <= AFFORDABLE;
    let by_plane = |mode| (mode, Placement::ByPlane);
    let by_copy = |mode| (mode, Placement::ByCopy);
    let own = modes.native.into_iter().chain(modes.exact);
    let (near, far): (Vec<Mode>, Vec<Mode>) = own.clone().chain(modes.others.iter().copied()).partition(is_affordable);
    let mut placed: Vec<(Mode, Placement)> = Vec::new();
    let asked_for = modes.requested.into_iter().flat_map(|mode| [by_plane(mode), by_copy(mode)]);
    let rest = modes.others.into_iter().map(by_plane);
    for way in asked_for.chain(own.map(by_plane)).chain(near.into_iter().map(by_copy)).chain(rest) {
        if !placed.contains(&way) {
            placed.push(way);
        }
    }
    placed.extend(far.into_iter().map(by_copy));
    placed
}

/// The rotation for `connector`: that of the built-in panel plus the owner's setting.
///
/// # Source
/// `drm_client_rotation` of the kernel: its angles are counter-clockwise, ours are clockwise.
fn rotation(connector: &Connector, output: &OutputSettings) -> Rotation {
    let panel = match connector.properties.chosen("panel orientation") {
        Some("Upside Down") => Rotation::Half,
        Some("Left Side Up") => Rotation::Clockwise270,
        Some("Right Side Up") => Rotation::Clockwise90,
        _ => Rotation::None,
    };
    panel.then(output.rotation)
}

/// The candidates for `plane` in `mode`: rotated by the plane if it can, else by the processor.
fn on_plane(
    connector: &Connector,
    crtc: &Crtc,
    plane: &Plane,
    mode: Mode,
    placement: Placement,
    output: &OutputSettings,
) -> Vec<Candidate> {
    let rotation = rotation(connector, output);
    let by_copy = (Rotation::None, rotation);
    let by_plane = (rotation, Rotation::None);
    let can_rotate = rotation != Rotation::None && plane_rotation(plane, rotation).is_some();
    let rotations = match placement {
        Placement::ByPlane if can_rotate => vec![by_plane, by_copy],
        Placement::ByPlane | Placement::ByCopy => vec![by_copy],
    };
    let mut candidates = Vec::new();
    for (plane_rotation, copy_rotation) in rotations {
        candidates.extend(images(plane).into_iter().map(|(format, framebuffers)| Candidate {
            connector: connector.id,
            crtc: crtc.id,
            plane: plane.id,
            mode,
            format,
            placement,
            framebuffers,
            plane_rotation,
            copy_rotation,
            margin: output.margin,
        }));
    }
    candidates
}

/// The CRTCs that can drive `connector`, the present one first.
fn crtcs<'a>(survey: &'a Survey, connector: &Connector) -> Vec<&'a Crtc> {
    let current = connector.properties.object("CRTC_ID");
    let mut able: Vec<_> = survey.crtcs.iter().filter(|crtc| connector.crtcs >> crtc.index & 1 == 1).collect();
    able.sort_by_key(|crtc| (Some(crtc.id) != current, crtc.properties.value("ACTIVE") == 1, crtc.index));
    able
}

/// The primary planes of `crtc`, the present one first. Overlays are not used: on most hardware they need a primary
/// plane below.
fn planes<'a>(survey: &'a Survey, crtc: &Crtc) -> Vec<&'a Plane> {
    let primary = |plane: &Plane| {
        let kind = plane.properties.get("type");
        kind.is_some_and(|kind| kind.value == 1)
    };
    let mut able: Vec<_> =
        survey.planes.iter().filter(|plane| plane.crtcs >> crtc.index & 1 == 1 && primary(plane)).collect();
    able.sort_by_key(|plane| {
        let at = plane.properties.object("CRTC_ID");
        (at != Some(crtc.id), at.is_some(), plane.id)
    });
    able
}

/// The buffers that `plane` may show, best first. YUV only if the plane has a property for its conversion matrix. RGB
/// only in separate framebuffers: drivers of firmware framebuffers and simple chips (simpledrm, bochs, qxl, cirrus,
/// ast, mgag200) support nothing else, and do not report it.
pub(super) fn images(plane: &Plane) -> Vec<(PlaneFormat, Framebuffers)> {
    let coloured = colours(plane).is_some();
    let takes = |format: Format| plane.formats.iter().copied().find(|taken| taken.format == format);
    let formats = Format::ALL.into_iter().filter(|format| coloured || !format.is_yuv()).filter_map(takes);
    let framed = |format: PlaneFormat| {
        let shared = format.format.is_yuv().then_some(Framebuffers::Shared);
        shared.into_iter().chain([Framebuffers::Own]).map(move |framebuffers| (format, framebuffers))
    };
    formats.flat_map(framed).collect()
}

/// The plane's properties for BT.709 and limited range, as (property, value); `None` if it lacks them.
pub(crate) fn colours(plane: &Plane) -> Option<[(Id, u64); 2]> {
    let matrix = plane.properties.choice("COLOR_ENCODING", "ITU-R BT.709 YCbCr")?;
    let range = plane.properties.choice("COLOR_RANGE", "YCbCr limited range")?;
    Some([matrix, range])
}

/// The plane's property for `rotation`, as (property, value); `None` if it cannot rotate so.
pub(crate) fn plane_rotation(plane: &Plane, rotation: Rotation) -> Option<(Id, u64)> {
    let bits = |names: &[&str]| {
        let set = names.iter().map(|name| plane.properties.bit("rotation", name));
        set.reduce(|all, bit| Some((all?.0, all?.1 | bit?.1))).flatten()
    };
    // The kernel's angles are counter-clockwise.
    match rotation {
        Rotation::None => bits(&["rotate-0"]),
        Rotation::Clockwise90 => bits(&["rotate-270"]),
        Rotation::Half => bits(&["rotate-180"]).or_else(|| bits(&["rotate-0", "reflect-x", "reflect-y"])),
        Rotation::Clockwise270 => bits(&["rotate-90"]),
    }
}
