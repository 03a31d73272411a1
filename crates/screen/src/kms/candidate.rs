//! One configuration for lighting pictures, and its geometry.
//!
//! Owns the geometry: the buffer's size, where the picture lies in it, and where the buffer lands on the mode. Pure
//! arithmetic on sizes. The order of preference is in `choose.rs`.
//!
//! Start at [`Candidate`].

use super::card::{Id, PlaneFormat};
use crate::output::{Margin, Rotation};
use drm::control::Mode;

/// What scales the picture to the mode.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Placement {
    /// The plane: it scales a buffer of the picture's size, where the sizes differ.
    ByPlane,
    /// The processor: it is scaled while it is copied into a buffer of the mode's size.
    ByCopy,
}

/// How many framebuffers the buffers lie in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Framebuffers {
    /// One for all, one below the other. It stays on the plane, and a flip moves the plane's window. For atomic drivers
    /// that is an ordinary flip, event and damage included; drivers that map the framebuffer at each flip, like vkms,
    /// find it mapped already.
    Shared,
    /// One each.
    Own,
}

/// A rectangle in pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Rect {
    pub(crate) left: u32,
    pub(crate) top: u32,
    pub(crate) width: u32,
    pub(crate) height: u32,
}

/// One way to light the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Candidate {
    pub(crate) connector: Id,
    pub(crate) crtc: Id,
    pub(crate) plane: Id,
    pub(crate) mode: Mode,
    pub(crate) format: PlaneFormat,
    pub(crate) placement: Placement,
    pub(crate) framebuffers: Framebuffers,
    /// By the plane.
    pub(crate) plane_rotation: Rotation,
    /// While it is copied into the buffer, before the plane's.
    pub(crate) copy_rotation: Rotation,
    pub(crate) margin: Margin,
}

impl Candidate {
    /// The buffer's size for pictures of `size`.
    pub(crate) fn buffer_size(&self, size: (u32, u32)) -> (u32, u32) {
        match self.placement {
            Placement::ByPlane => self.copy_rotation.of_size(size),
            Placement::ByCopy => even(mode_size(&self.mode)),
        }
    }

    /// The rectangle of the mode that the buffer covers.
    pub(crate) fn destination(&self, size: (u32, u32)) -> Rect {
        match self.placement {
            Placement::ByPlane => {
                let upright = self.plane_rotation.of_size(self.buffer_size(size));
                // On a mode with odd sides the picture covers all of it.
                fit(upright, mode_size(&self.mode), self.margin)
            }
            Placement::ByCopy => {
                let (width, height) = self.buffer_size(size);
                Rect { left: 0, top: 0, width, height }
            }
        }
    }

    /// Where a picture of `size` lies in `buffer`, which may be one for pictures of another size.
    pub(crate) fn area(&self, size: (u32, u32), buffer: (u32, u32)) -> Rect {
        let margin = match self.placement {
            Placement::ByPlane => Margin::default(),
            Placement::ByCopy => self.margin,
        };
        fit(self.copy_rotation.of_size(size), buffer, margin)
    }
}

/// Pixels across and down.
pub(crate) fn mode_size(mode: &Mode) -> (u32, u32) {
    (u32::from(mode.size().0), u32::from(mode.size().1))
}

fn even((width, height): (u32, u32)) -> (u32, u32) {
    (width & !1, height & !1)
}

/// The largest rectangle of the proportions of `size` in the middle of what `margin` leaves of `room`. If it is less
/// than 1 % smaller than that, it is all of it: a thin border is visible, the distortion is not.
pub(crate) fn fit(size: (u32, u32), room: (u32, u32), margin: Margin) -> Rect {
    let used = |side: u32| u64::from(side) * u64::from(100 - 2 * u32::from(margin.percent())) / 100;
    let (across, down) = (used(room.0), used(room.1));
    let (width, height) = (u64::from(size.0), u64::from(size.1));
    let is_wide = width * down >= across * height;
    let (wanted, whole) = if is_wide { (across * height / width, down) } else { (down * width / height, across) };
    let wanted = if (whole - wanted) * 100 < whole { whole } else { wanted };
    let (width, height) = if is_wide { (across, wanted) } else { (wanted, down) };
    // Sides are even because of chroma, except where the picture covers all of an odd room.
    let side = |side: u64, room: u32| {
        let side = u32::try_from(side).expect("at most the room's");
        if side == room { side } else { side & !1 }
    };
    let (width, height) = (side(width, room.0), side(height, room.1));
    Rect { left: (room.0 - width) / 4 * 2, top: (room.1 - height) / 4 * 2, width, height }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::paint::Format;
    use proptest::prelude::*;

    fn way(size: (u16, u16), placement: Placement) -> Candidate {
        let mode = drm_ffi::drm_mode_modeinfo { hdisplay: size.0, vdisplay: size.1, ..Default::default() };
        Candidate {
            connector: Id(1),
            crtc: Id(2),
            plane: Id(3),
            mode: mode.into(),
            format: PlaneFormat { format: Format::Yu12, explicit: true },
            placement,
            framebuffers: Framebuffers::Own,
            plane_rotation: Rotation::None,
            copy_rotation: Rotation::None,
            margin: Margin::default(),
        }
    }

    fn rect(left: u32, top: u32, width: u32, height: u32) -> Rect {
        Rect { left, top, width, height }
    }

    const HD: (u32, u32) = (1280, 720);

    #[test]
    fn a_plane_scales_in_proportion_and_leaves_no_thin_border() {
        let to = |mode| way(mode, Placement::ByPlane).destination(HD);
        assert_eq!(to((1920, 1080)), rect(0, 0, 1920, 1080));
        assert_eq!(to((1366, 768)), rect(0, 0, 1366, 768));
        assert_eq!(to((640, 480)), rect(0, 60, 640, 360));
        assert_eq!(to((1920, 1200)), rect(0, 60, 1920, 1080));
        assert_eq!(to((1280, 721)), rect(0, 0, 1280, 721));
        assert_eq!(way((1920, 1080), Placement::ByPlane).destination((960, 1080)), rect(480, 0, 960, 1080));
    }

    #[test]
    fn a_copy_fills_a_buffer_of_the_modes_size() {
        let way = way((1920, 1200), Placement::ByCopy);
        assert_eq!((way.buffer_size(HD), way.destination(HD)), ((1920, 1200), rect(0, 0, 1920, 1200)));
        assert_eq!(way.area(HD, (1920, 1200)), rect(0, 60, 1920, 1080));
        assert_eq!(way.area((320, 240), (1920, 1200)), rect(160, 0, 1600, 1200));
    }

    #[test]
    fn a_rotated_picture_stands_upright_on_the_mode() {
        let mut plane = way((1280, 800), Placement::ByPlane);
        plane.plane_rotation = Rotation::Clockwise90;
        assert_eq!((plane.buffer_size(HD), plane.destination(HD)), (HD, rect(414, 0, 450, 800)));
        let mut copy = way((1280, 800), Placement::ByPlane);
        copy.copy_rotation = Rotation::Clockwise270;
        assert_eq!((copy.buffer_size(HD), copy.destination(HD)), ((720, 1280), rect(414, 0, 450, 800)));
        assert_eq!(copy.area(HD, (720, 1280)), rect(0, 0, 720, 1280));
        let mut both = way((800, 1280), Placement::ByCopy);
        both.copy_rotation = Rotation::Clockwise90;
        assert_eq!(both.area(HD, (800, 1280)), rect(40, 0, 720, 1280));
    }

    #[test]
    fn a_margin_is_left_at_each_side() {
        let margin: Margin = "5".parse().unwrap();
        let scaled = Candidate { margin, ..way((1920, 1080), Placement::ByPlane) };
        assert_eq!(scaled.destination(HD), rect(96, 54, 1728, 972));
        let copied = Candidate { margin, ..way((1920, 1080), Placement::ByCopy) };
        assert_eq!(copied.area(HD, (1920, 1080)), rect(96, 54, 1728, 972));
        assert_eq!(copied.destination(HD), rect(0, 0, 1920, 1080));
    }

    proptest! {
        #[test]
        fn a_fitted_picture_lies_in_its_room_and_reaches_two_of_its_sides(
            size in (1..=2_000u32, 1..=2_000u32), room in (32..=4_096u32, 32..=4_096u32), percent in 0..=20u8,
        ) {
            let size = (size.0 * 2, size.1 * 2);
            let margin: Margin = percent.to_string().parse().unwrap();
            let rect = fit(size, room, margin);
            prop_assert!(rect.left + rect.width <= room.0 && rect.top + rect.height <= room.1);
            let (left, top) = (room.0 - rect.width, room.1 - rect.height);
            let bordered = |short: u32, side: u32| short <= side * 2 * u32::from(percent) / 100 + 2;
            prop_assert!(bordered(left, room.0) || bordered(top, room.1), "{:?}", rect);
            if rect.width > 100 && rect.height > 100 {
                let (ours, theirs) = (f64::from(rect.width) / f64::from(rect.height), f64::from(size.0) / f64::from(size.1));
                prop_assert!((ours / theirs - 1.0).abs() < 0.04, "{:?}", rect);
            }
        }
    }
}
