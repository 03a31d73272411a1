//! A chosen candidate as property values.
//!
//! Owns the requests: light, flip, darken; and the properties that are reset, because a previous process may have left
//! an overlay, a rotation or a colour matrix. They are committed elsewhere.

use super::candidate::Candidate;
use super::card::{Connector, Crtc, Id, Plane, Properties, Property, Request, Source, Survey, Values};
use super::choose::{colours, plane_rotation, unmet};
use super::dimming::Dimmer;
use super::modes::refresh;
use crate::output::{OutputSettings, SignalRange};
use timing::Rate;

/// Minimum bits per colour channel on the cable.
const BITS_PER_CHANNEL: u64 = 8;
/// Connector properties that are reset, with their neutral choices, the best first. i915 has no `None` among its
/// scaling modes.
const NEUTRAL_CHOICES: [(&str, &[&str]); 7] = [
    ("link-status", &["Good"]),
    ("Colorspace", &["Default"]),
    ("content type", &["No Data"]),
    ("underscan", &["off"]),
    ("scaling mode", &["None", "Full aspect"]),
    ("aspect ratio", &["Automatic"]),
    ("dithering mode", &["auto"]),
];
/// The same for numbers and blobs.
const NEUTRAL_NUMBERS: [&str; 7] = [
    "HDR_OUTPUT_METADATA",
    "underscan hborder",
    "underscan vborder",
    "left margin",
    "right margin",
    "top margin",
    "bottom margin",
];

/// The data to light one candidate.
#[derive(Clone, Debug)]
pub(crate) struct Plan {
    pub(crate) way: Candidate,
    /// Of the pictures that it is for.
    pub(crate) size: (u32, u32),
    /// `HDMI-A-1`.
    pub(crate) connector: String,
    /// The CRTC's index, for vblank calls.
    pub(crate) crtc: u32,
    pub(crate) refresh: Rate,
    /// The CRTC drives this mode to this connector already: no modeset is needed.
    pub(crate) same_mode: bool,
    /// How the CRTC can be dimmed; `None` if it cannot.
    pub(crate) dimmer: Option<Dimmer>,
    /// The owner's settings that it does not fulfil, each as a sentence.
    pub(crate) unmet: Vec<String>,
    light: Request,
    darken: Request,
    /// The properties that say what the plane shows: the framebuffer, and its first row.
    fb: Id,
    top: Id,
}

impl Plan {
    /// The plan to light `way`, for pictures of `size`, with the mode in `blob` and the settings in `output`; `None` if
    /// the survey lacks one of its objects.
    pub(crate) fn new(
        survey: &Survey,
        way: Candidate,
        size: (u32, u32),
        blob: Id,
        output: &OutputSettings,
    ) -> Option<Self> {
        let connector = survey.connectors.iter().find(|connector| connector.id == way.connector)?;
        let crtc = survey.crtcs.iter().find(|crtc| crtc.id == way.crtc)?;
        let plane = survey.planes.iter().find(|plane| plane.id == way.plane)?;
        let (fb, top) = (plane.properties.get("FB_ID")?.id, plane.properties.get("SRC_Y")?.id);

        let mut light = Request::default();
        connect(&mut light, connector, crtc, output.range);
        light.set(crtc.id, &crtc.properties, "MODE_ID", blob.0.into());
        light.set(crtc.id, &crtc.properties, "ACTIVE", 1);
        for neutral in ["VRR_ENABLED", "CTM", "DEGAMMA_LUT", "GAMMA_LUT"] {
            light.set(crtc.id, &crtc.properties, neutral, 0);
        }
        light.choose(crtc.id, &crtc.properties, "SCALING_FILTER", "Default");
        let mut darken = Request::default();
        detach_others(&mut light, survey, &way);
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
            dimmer: Dimmer::of(&survey.driver, crtc),
            unmet: unmet(survey, output, &way),
            same_mode: driven && crtc.mode == Some(way.mode),
            light,
            darken,
            fb,
            top,
        })
    }

    /// All properties, with `source` on the plane.
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

    /// Whether the `plane` has kept our colour matrix and range; true for RGB.
    pub(crate) fn keeps_colours(&self, plane: &Properties, survey: &Survey) -> bool {
        let known = survey.planes.iter().find(|known| known.id == self.way.plane);
        let value = |id: Id| plane.0.iter().find(|property| property.id == id).map(|found| found.value);
        let stands = |set: [(Id, u64); 2]| set.iter().all(|&(id, wanted)| value(id) == Some(wanted));
        !self.way.format.format.is_yuv() || known.and_then(colours).is_some_and(stands)
    }
}

/// Pixels as 16.16 fixed point.
fn fixed(pixels: u32) -> u64 {
    u64::from(pixels) << 16
}

/// Connects the connector to the CRTC, resets its properties, and sets the signal range.
fn connect(light: &mut Request, connector: &Connector, crtc: &Crtc, range: SignalRange) {
    let (id, properties) = (connector.id, &connector.properties);
    light.set(id, properties, "CRTC_ID", crtc.id.0.into());
    for (name, neutral) in NEUTRAL_CHOICES {
        let choice = neutral.iter().find(|choice| properties.choice(name, choice).is_some());
        if let Some(choice) = choice {
            light.choose(id, properties, name, choice);
        }
    }
    for name in NEUTRAL_NUMBERS {
        light.set(id, properties, name, 0);
    }
    // A higher value is kept: changing it could need a modeset.
    if let Some(Property { value, values: Values::UpTo { max }, .. }) = properties.get("max bpc")
        && *value < BITS_PER_CHANNEL
    {
        light.set(id, properties, "max bpc", BITS_PER_CHANNEL.min(*max));
    }
    light.choose(id, properties, "Broadcast RGB", broadcast_rgb(range));
}

/// The choice of the property `Broadcast RGB` for `range`.
fn broadcast_rgb(range: SignalRange) -> &'static str {
    match range {
        SignalRange::Automatic => "Automatic",
        SignalRange::Full => "Full",
        SignalRange::Limited => "Limited 16:235",
    }
}

/// Disables every other plane of the CRTC, and detaches every other connector from it.
fn detach_others(light: &mut Request, survey: &Survey, way: &Candidate) {
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

/// Places the buffer on the mode, with our colour properties and all others reset. `zpos` stays: there is no other plane.
fn place(light: &mut Request, plane: &Plane, crtc: &Crtc, way: &Candidate, size: (u32, u32)) {
    let (source, on_mode) = (way.buffer_size(size), way.destination(size));
    let values = [
        ("CRTC_ID", crtc.id.0.into()),
        ("SRC_X", 0),
        ("SRC_W", fixed(source.0)),
        ("SRC_H", fixed(source.1)),
        ("CRTC_X", on_mode.left.into()),
        ("CRTC_Y", on_mode.top.into()),
        ("CRTC_W", on_mode.width.into()),
        ("CRTC_H", on_mode.height.into()),
        ("FB_DAMAGE_CLIPS", 0),
    ];
    for (name, value) in values {
        light.set(plane.id, &plane.properties, name, value);
    }
    if let Some((id, value)) = plane_rotation(plane, way.plane_rotation) {
        light.0.push((plane.id, id, value));
    }
    if let Some(Property { values: Values::UpTo { max }, .. }) = plane.properties.get("alpha") {
        light.set(plane.id, &plane.properties, "alpha", *max);
    }
    light.choose(plane.id, &plane.properties, "pixel blend mode", "None");
    light.choose(plane.id, &plane.properties, "SCALING_FILTER", "Default");
    let set = colours(plane).into_iter().flatten();
    light.0.extend(set.map(|(id, value)| (plane.id, id, value)));
}
