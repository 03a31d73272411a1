//! How bright the picture is.
//!
//! Owns the choice of method. In this order: the panel's backlight; the CRTC's gamma ramp; its colour matrix; the
//! samples while they are copied into a buffer, which always works and costs processor time. If the driver rejects a
//! ramp or a matrix, the samples are dimmed. The caller of `set_light` decides how bright.
//!
//! Start at [`Dimming`].

use super::card::{Crtc, Id, Kms, Request};
use super::plan::Plan;
use crate::{DimmedBy, Light};

/// All of the light, in thousandths.
pub(super) const FULL: u16 = 1000;
/// Drivers that wait for a vblank and check all CRTCs whenever a ramp or a matrix changes: each step would cost a frame.
const SLOW_TO_DIM: [&str; 1] = ["amdgpu"];
/// Drivers whose `GAMMA_LUT` also accepts this many entries, so that a step takes 2 KiB instead of 2 MiB.
const SHORT_RAMP: [(&str, u32); 2] = [("i915", 256), ("xe", 256)];

/// The property of a CRTC by which it can be dimmed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Dimmer {
    crtc: Id,
    property: Id,
    means: DimMethod,
}

/// What a dimmer's property takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum DimMethod {
    /// `GAMMA_LUT` with this many entries, at least 2.
    Ramp { entries: u32 },
    /// `CTM`: a matrix of colours.
    Matrix,
}

impl Dimmer {
    /// How `crtc` of a card with this driver can be dimmed; `None` if it cannot, or is too slow.
    pub(crate) fn of(driver: &str, crtc: &Crtc) -> Option<Self> {
        if SLOW_TO_DIM.contains(&driver) {
            return None;
        }
        let settable = |name: &str| crtc.properties.get(name).filter(|property| property.mutable).map(|found| found.id);
        let dimmer = |property, means| Self { crtc: crtc.id, property, means };
        let entries = u32::try_from(crtc.properties.value("GAMMA_LUT_SIZE")).ok().filter(|entries| *entries >= 2);
        let ramp = settable("GAMMA_LUT").zip(entries).map(|(property, entries)| {
            let short = SHORT_RAMP.iter().find(|(named, _)| *named == driver).map_or(entries, |(_, short)| *short);
            dimmer(property, DimMethod::Ramp { entries: short.min(entries) })
        });
        ramp.or_else(|| settable("CTM").map(|property| dimmer(property, DimMethod::Matrix)))
    }

    /// Sets the CRTC's property to `blob`, or clears it.
    pub(super) fn set(self, request: &mut Request, blob: Option<Id>) {
        request.0.push((self.crtc, self.property, blob.map_or(0, |blob| blob.0.into())));
    }

    /// The blob's contents for this many thousandths of brightness.
    fn bytes(self, thousandths: u16) -> Vec<u8> {
        match self.means {
            DimMethod::Ramp { entries } => ramp(entries, thousandths),
            DimMethod::Matrix => matrix(thousandths),
        }
    }
}

/// The dimming of one output: method and brightness.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Dimming {
    /// The blob that is set on the CRTC; `None` for full brightness.
    blob: Option<Id>,
    /// It goes with the next flip.
    is_news: bool,
    /// The CRTC cannot dim, or rejects it: the samples are dimmed.
    is_by_copy: bool,
    /// The backlight is dimmed.
    has_backlight: bool,
    /// What of each sample is left.
    thousandths: u16,
}

impl Dimming {
    /// The dimming for `light` on an output that is not lit yet.
    pub(super) fn new(kms: &mut impl Kms, plan: &Plan, light: Light) -> Self {
        let has_backlight = kms.find_backlight(&plan.connector);
        let is_by_copy = !has_backlight && plan.dimmer.is_none();
        let mut dimming = Self { blob: None, is_news: false, is_by_copy, has_backlight, thousandths: FULL };
        dimming.dim(kms, plan, light);
        dimming
    }

    /// Applies `light`: to the backlight at once, to the CRTC from the next flip on, to samples from the next picture on.
    pub(super) fn renew(&mut self, kms: &mut impl Kms, plan: &Plan, light: Light) {
        self.free(kms);
        (self.blob, self.is_news) = (None, true);
        self.dim(kms, plan, light);
    }

    fn dim(&mut self, kms: &mut impl Kms, plan: &Plan, light: Light) {
        let Light::On { thousandths } = light else { return };
        self.thousandths = thousandths.min(FULL);
        if self.has_backlight {
            kms.set_backlight(self.thousandths);
        } else if let Some(dimmer) = plan.dimmer.filter(|_| !self.is_by_copy && self.thousandths < FULL) {
            let made = kms.create_blob(&dimmer.bytes(self.thousandths));
            self.blob = made.inspect_err(|error| tracing::debug!(%error, "cannot create a blob for dimming")).ok();
        }
    }

    /// What becomes less.
    pub(super) fn by(&self) -> DimmedBy {
        if self.has_backlight { DimmedBy::Backlight } else { DimmedBy::Samples }
    }

    /// The brightness of samples as they are copied, in thousandths.
    pub(super) fn software_dim(&self) -> u16 {
        if self.is_by_copy { self.thousandths } else { FULL }
    }

    /// The property and value to set with the next flip, if it has changed.
    pub(super) fn pending_change(&self, plan: &Plan) -> Option<(Dimmer, Option<Id>)> {
        plan.dimmer
            .filter(|_| self.is_news && !self.is_by_copy && !self.has_backlight)
            .map(|dimmer| (dimmer, self.blob))
    }

    /// The property and value to set with a modeset.
    pub(super) fn current_setting(&self, plan: &Plan) -> Option<(Dimmer, Id)> {
        plan.dimmer.zip(self.blob)
    }

    /// The kernel has taken it.
    pub(super) fn is_taken(&mut self) {
        self.is_news = false;
    }

    /// The driver rejects it: the samples are dimmed from now on.
    pub(super) fn is_refused(&mut self, kms: &mut impl Kms) {
        tracing::info!("the driver rejects gamma or CTM, dimming in software");
        self.free(kms);
        (self.blob, self.is_news, self.is_by_copy) = (None, false, true);
    }

    pub(super) fn free(self, kms: &mut impl Kms) {
        if let Some(blob) = self.blob {
            kms.destroy_blob(blob);
        }
    }
}

/// `struct drm_color_lut` for each entry, linear from dark to bright: red, green, blue and reserved.
fn ramp(entries: u32, thousandths: u16) -> Vec<u8> {
    let brightest = u64::from(u16::MAX) * u64::from(thousandths) / u64::from(FULL);
    let last = u64::from(entries.max(2)) - 1;
    let sample = |index: u64| ((index * brightest / last) as u16).to_ne_bytes();
    (0..=last).map(sample).flat_map(|[a, b]| [a, b, a, b, a, b, 0, 0]).collect()
}

/// `struct drm_color_ctm`: nine numbers of 32 bits before and after the point.
fn matrix(thousandths: u16) -> Vec<u8> {
    let factor = (u64::from(thousandths) << 32) / u64::from(FULL);
    (0..9).flat_map(|place: u64| (if place.is_multiple_of(4) { factor } else { 0 }).to_ne_bytes()).collect()
}

#[cfg(test)]
mod tests {
    use super::{matrix, ramp};

    #[test]
    fn a_ramp_is_even_and_as_bright_as_it_is_told() {
        for (entries, thousandths) in [(2, 0), (2, 1000), (256, 500), (4096, 999), (65_536, 1), (262_145, 700)] {
            let sample = |pair: &[u8]| u16::from_ne_bytes([pair[0], pair[1]]);
            let entry = |bytes: &[u8]| [0, 2, 4, 6].map(|at| sample(&bytes[at..]));
            let ramp: Vec<[u16; 4]> = ramp(entries, thousandths).chunks(8).map(entry).collect();
            assert_eq!((ramp.len(), ramp[0]), (entries as usize, [0; 4]));
            let brightest = u32::from(u16::MAX) * u32::from(thousandths) / 1000;
            assert_eq!(u32::from(ramp.last().unwrap()[0]), brightest);
            let steps: Vec<_> = ramp.windows(2).map(|pair| pair[1][0] - pair[0][0]).collect();
            let (least, most) = (steps.iter().min().unwrap(), steps.iter().max().unwrap());
            assert!(most - least <= 1, "{entries} entries of {thousandths} thousandths");
            assert!(ramp.iter().all(|[red, green, blue, _]| red == green && green == blue), "no tint");
        }
    }

    #[test]
    fn a_matrix_leaves_its_part_of_every_colour() {
        let bytes = matrix(250);
        let numbers: Vec<u64> = bytes.chunks(8).map(|number| u64::from_ne_bytes(number.try_into().unwrap())).collect();
        assert_eq!(numbers, [1 << 30, 0, 0, 0, 1 << 30, 0, 0, 0, 1 << 30]);
    }
}
