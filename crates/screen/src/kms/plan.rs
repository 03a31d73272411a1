//! A chosen way to light the picture, as property values.
//!
//! Owns the requests: light, flip, darken; and which properties that are not ours are put back to neutral, because a
//! process before us may have left an overlay, a rotation or a colour matrix. Never commits them.

use super::card::{Crtc, Id, Plane, Property, Request, Source, Survey, Values};
use super::choose::{Candidate, colours, refresh};
use timing::Rate;

/// All that it takes to light one candidate.
#[derive(Clone, Debug)]
pub(crate) struct Plan {
    pub(crate) way: Candidate,
    /// Of the pictures that it is for.
    pub(crate) size: (u32, u32),
    /// `HDMI-A-1`.
    pub(crate) connector: String,
    /// The CRTC's index, which vblank calls count by.
    pub(crate) crtc: u32,
    pub(crate) refresh: Rate,
    /// The CRTC drives this mode to this connector already: no mode need be set, and nothing flashes.
    pub(crate) same_mode: bool,
    /// How it can be dimmed; `None` if it cannot.
    pub(crate) dimmer: Option<Dimmer>,
    light: Request,
    darken: Request,
    /// The properties that say what the plane shows: the framebuffer, and its first row.
    fb: Id,
    top: Id,
}

/// The property of a CRTC that says what becomes of each sample.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Dimmer {
    crtc: Id,
    property: Id,
    /// How many entries its ramp has, at least 2.
    pub(crate) entries: u16,
}

impl Dimmer {
    fn of(crtc: &Crtc) -> Option<Self> {
        let property = crtc.properties.get("GAMMA_LUT").filter(|property| property.mutable)?.id;
        let entries = u16::try_from(crtc.properties.value("GAMMA_LUT_SIZE")).ok().filter(|entries| *entries >= 2)?;
        Some(Self { crtc: crtc.id, property, entries })
    }

    /// Has the CRTC go by the ramp in `blob`, or by none.
    pub(crate) fn set(self, request: &mut Request, blob: Option<Id>) {
        request.0.push((self.crtc, self.property, blob.map_or(0, |blob| blob.0.into())));
    }
}

impl Plan {
    /// The plan to light `way`, for pictures of `size`, with the mode in `blob`; `None` if the survey does not have it.
    pub(crate) fn new(survey: &Survey, way: Candidate, size: (u32, u32), blob: Id) -> Option<Self> {
        let connector = survey.connectors.iter().find(|connector| connector.id == way.connector)?;
        let crtc = survey.crtcs.iter().find(|crtc| crtc.id == way.crtc)?;
        let plane = survey.planes.iter().find(|plane| plane.id == way.plane)?;
        let (fb, top) = (plane.properties.get("FB_ID")?.id, plane.properties.get("SRC_Y")?.id);

        let mut light = Request::default();
        light.set(connector.id, &connector.properties, "CRTC_ID", crtc.id.0.into());
        light.choose(connector.id, &connector.properties, "link-status", "Good");
        light.choose(connector.id, &connector.properties, "Colorspace", "Default");
        light.set(connector.id, &connector.properties, "HDR_OUTPUT_METADATA", 0);
        light.set(crtc.id, &crtc.properties, "MODE_ID", blob.0.into());
        light.set(crtc.id, &crtc.properties, "ACTIVE", 1);
        for neutral in ["VRR_ENABLED", "CTM", "DEGAMMA_LUT", "GAMMA_LUT"] {
            light.set(crtc.id, &crtc.properties, neutral, 0);
        }
        let mut darken = Request::default();
        clear_rivals(&mut light, survey, &way);
        place(&mut light, plane, crtc, &way, size);
        darken.set(connector.id, &connector.properties, "CRTC_ID", 0);
        darken.set(crtc.id, &crtc.properties, "ACTIVE", 0);
        darken.set(crtc.id, &crtc.properties, "MODE_ID", 0);
        darken.set(plane.id, &plane.properties, "FB_ID", 0);
        darken.set(plane.id, &plane.properties, "CRTC_ID", 0);

        let driven = crtc.properties.value("ACTIVE") == 1 && connector.properties.object("CRTC_ID") == Some(crtc.id);
        Some(Self {
            way,
            size,
            connector: connector.name.clone(),
            crtc: crtc.index,
            refresh: refresh(&way.mode)?,
            dimmer: Dimmer::of(crtc),
            same_mode: driven && crtc.mode == Some(way.mode),
            light,
            darken,
            fb,
            top,
        })
    }

    /// Everything, with `source` on the plane.
    pub(crate) fn light(&self, source: Source) -> Request {
        let mut request = self.light.clone();
        request.0.extend(self.flip(source).0);
        request
    }

    /// Only `source` on the plane.
    pub(crate) fn flip(&self, source: Source) -> Request {
        let plane = self.way.plane;
        Request(vec![(plane, self.fb, source.fb.0.into()), (plane, self.top, fixed(source.top))])
    }

    /// The CRTC off, and the plane empty.
    pub(crate) fn darken(&self) -> &Request {
        &self.darken
    }

    /// Whether `survey` shows that the plane took our colour matrix and range; true for RGB.
    pub(crate) fn colours_stand(&self, survey: &Survey) -> bool {
        let plane = survey.planes.iter().find(|plane| plane.id == self.way.plane);
        let stands = |plane: &Plane| {
            let value = |id: Id| plane.properties.0.iter().find(|property| property.id == id).map(|found| found.value);
            colours(plane).is_some_and(|set| set.iter().all(|&(id, wanted)| value(id) == Some(wanted)))
        };
        !self.way.format.format.is_yuv() || plane.is_some_and(stands)
    }
}

/// Pixels as the kernel counts them within a framebuffer, in 65536ths.
fn fixed(pixels: u32) -> u64 {
    u64::from(pixels) << 16
}

/// Empties every other plane that the CRTC shows, and unplugs every other connector from it.
fn clear_rivals(light: &mut Request, survey: &Survey, way: &Candidate) {
    for plane in survey.planes.iter().filter(|plane| plane.id != way.plane) {
        if plane.properties.object("CRTC_ID") == Some(way.crtc) {
            light.set(plane.id, &plane.properties, "FB_ID", 0);
            light.set(plane.id, &plane.properties, "CRTC_ID", 0);
        }
    }
    for connector in survey.connectors.iter().filter(|connector| connector.id != way.connector) {
        if connector.properties.object("CRTC_ID") == Some(way.crtc) {
            light.set(connector.id, &connector.properties, "CRTC_ID", 0);
        }
    }
}

/// Puts the buffer onto the mode, with our colours and all else neutral. `zpos` stays: nothing lies above or below.
fn place(light: &mut Request, plane: &Plane, crtc: &Crtc, way: &Candidate, size: (u32, u32)) {
    /// `DRM_MODE_ROTATE_0`: the picture upright.
    const UPRIGHT: u64 = 1;
    let (source, (left, top, width, height)) = (way.buffer_size(size), way.destination(size));
    let values = [
        ("CRTC_ID", crtc.id.0.into()),
        ("SRC_X", 0),
        ("SRC_W", fixed(source.0)),
        ("SRC_H", fixed(source.1)),
        ("CRTC_X", left.into()),
        ("CRTC_Y", top.into()),
        ("CRTC_W", width.into()),
        ("CRTC_H", height.into()),
        ("rotation", UPRIGHT),
        ("FB_DAMAGE_CLIPS", 0),
    ];
    for (name, value) in values {
        light.set(plane.id, &plane.properties, name, value);
    }
    if let Some(Property { values: Values::UpTo { max }, .. }) = plane.properties.get("alpha") {
        light.set(plane.id, &plane.properties, "alpha", *max);
    }
    light.choose(plane.id, &plane.properties, "pixel blend mode", "None");
    light.choose(plane.id, &plane.properties, "SCALING_FILTER", "Default");
    if way.format.format.is_yuv() {
        let set = colours(plane).into_iter().flatten();
        light.0.extend(set.map(|(id, value)| (plane.id, id, value)));
    }
}
