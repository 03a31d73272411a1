//! The commits that a family's driver rejects.
//!
//! Owns the rejections, each with the kernel's error number, and assertions about commits that a player must not make.
//! Values are kept in `mod.rs`.
//!
//! Start at [`Scripted::check`].

use super::family::Window;
use super::{CONNECTOR, OVERLAY, PRIMARY, Quirk, Scripted, top_of};
use crate::kms::card::{CommitMode, Id, Request};
use crate::paint::Format;
use rustix::io::Errno;
use std::io;

impl Scripted {
    /// The value that `request` sets for `name` on any object but the overlay.
    pub(super) fn wanted(&self, request: &Request, name: &str) -> Option<u64> {
        let set = request.0.iter().rev();
        let mut found = set.filter(|(object, id, _)| *object != OVERLAY && self.family.row(*id).name == name);
        found.next().map(|(_, _, value)| *value)
    }

    /// Refuses what the card's family would refuse.
    ///
    /// # Panics
    /// If `request` sets what cannot be set: the kernel would refuse that of every driver.
    pub(super) fn check(&self, how: CommitMode, request: &Request) -> io::Result<()> {
        for &(object, id, value) in &request.0 {
            let row = self.family.row(id);
            let kind =
                Self::objects().into_iter().find(|(_, known)| *known == object).expect("an object of this card").0;
            assert!(row.kinds.contains(kind), "`{}` was set of another object", row.name);
            assert!(!row.is_fixed, "`{}` cannot be set", row.name);
            assert!(row.takes(value), "`{}` does not take {value}", row.name);
        }
        if matches!(how, CommitMode::Flip | CommitMode::Settle) && self.needs_mode(request) {
            return Err(Errno::INVAL.into());
        }
        self.check_mode(request)?;
        self.check_plane(how, request)?;
        self.check_light(how, request)
    }

    /// Whether `request` takes a commit that may set a mode.
    fn needs_mode(&self, request: &Request) -> bool {
        let changes = |object: Id, name: &'static str, value| self.value(object, name) != value;
        request.0.iter().any(|&(object, id, value)| {
            let row = self.family.row(id);
            match row.name {
                "MODE_ID" => self.made.get(&value) != self.mode().as_ref(),
                "ACTIVE" => changes(object, row.name, value),
                "CRTC_ID" if object == CONNECTOR => changes(object, row.name, value),
                name => row.sets_mode && changes(object, name, value),
            }
        })
    }

    fn check_mode(&self, request: &Request) -> io::Result<()> {
        let Some(mode) = self.wanted(request, "MODE_ID").and_then(|blob| self.made.get(&blob)) else { return Ok(()) };
        let is_foreign = self.family.limits.has_one_mode && Some(mode) != self.modes.first();
        if mode.clock() > self.family.limits.fastest_khz || is_foreign {
            return Err(Errno::INVAL.into());
        }
        Ok(())
    }

    fn check_plane(&self, how: CommitMode, request: &Request) -> io::Result<()> {
        let limits = &self.family.limits;
        let now = |name: &'static str| self.wanted(request, name).unwrap_or_else(|| self.value(PRIMARY, name));
        let (refused, out_of_range) = (Err(Errno::INVAL.into()), Err(Errno::RANGE.into()));
        let top = top_of(now("SRC_Y"));
        let format = self.layouts.get(&Id(now("FB_ID") as u32)).map(|layout| layout.format);
        let moves = now("SRC_Y") != self.value(PRIMARY, "SRC_Y");
        match (limits.window, self.quirk) {
            (Window::RefusedForNv12, _) if top > 0 && format == Some(Format::Nv12) => return refused,
            (_, Some(Quirk::NoWindow)) if top > 0 => return refused,
            (_, Some(Quirk::StiffWindow)) if how == CommitMode::Flip && moves => return refused,
            (Window::Ignored, _) => assert_eq!(top, 0, "the picture would freeze, and nobody would tell"),
            _ => {}
        }
        let turned = now("rotation") & 0b1010 != 0;
        if turned && !limits.turns_linear {
            return refused;
        }
        let source = [now("SRC_W") >> 16, now("SRC_H") >> 16];
        let [across, down] = if turned { [source[1], source[0]] } else { source };
        let shown = [now("CRTC_W"), now("CRTC_H")];
        let is_scaled = [across, down] != shown;
        let is_too_small =
            across * 100 > shown[0] * u64::from(limits.shrinks) || down * 100 > shown[1] * u64::from(limits.shrinks);
        if is_scaled && is_too_small {
            return out_of_range;
        }
        let mode =
            self.wanted(request, "MODE_ID").and_then(|blob| self.made.get(&blob)).copied().or_else(|| self.mode());
        let size = mode.map(|mode| [u64::from(mode.size().0), u64::from(mode.size().1)]);
        let at = [now("CRTC_X"), now("CRTC_Y")];
        if limits.must_cover && (Some(shown) != size || at != [0, 0]) {
            return refused;
        }
        if size.is_some_and(|size| at[0] + shown[0] > size[0] || at[1] + shown[1] > size[1]) {
            return out_of_range;
        }
        Ok(())
    }

    fn check_light(&self, how: CommitMode, request: &Request) -> io::Result<()> {
        let ramp = self.wanted(request, "GAMMA_LUT").filter(|blob| *blob != 0).and_then(|blob| self.ramp(blob));
        if ramp.is_some() && how == CommitMode::Flip && self.quirk == Some(Quirk::StiffRamp) {
            return Err(Errno::INVAL.into());
        }
        let Some(ramp) = ramp else { return Ok(()) };
        let is_even = ramp.windows(2).all(|pair| pair[0] <= pair[1]);
        let fits = self.family.limits.ramps.iter().any(|entries| *entries as usize == ramp.len());
        if fits && is_even { Ok(()) } else { Err(Errno::INVAL.into()) }
    }
}
