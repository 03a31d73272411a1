//! What lies over the picture: panes, drawn for one size of pictures.
//!
//! Owns the two places for panes, a notice and an acknowledgement, and the laying of both over a picture. The flip thread
//! takes them from [`Overlay`] and never waits for whoever draws them. Never draws: `notice_pane.rs` and
//! `acknowledgement.rs` do.
//!
//! Start at [`Overlay`].

use player::hold;
use screen::{Dim, Picture};
use std::sync::{Arc, Mutex};

/// Luma of a pixel that leaves the picture as it is: blacker than black.
pub(crate) const CLEAR: u8 = 0;
/// All of the light, in thousandths.
pub(crate) const FULL: u16 = 1000;
/// No colour.
const GREY: u8 = 128;

/// A drawing without colour.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Pane {
    /// The size of the pictures that it was drawn for.
    pub(crate) picture: (u32, u32),
    /// The first pixel across and down, even.
    pub(crate) at: (u32, u32),
    /// Pixels across and down, even.
    pub(crate) size: (u32, u32),
    /// Row by row.
    pub(crate) luma: Vec<u8>,
}

/// Memory for a picture under a pane: it is allocated once.
#[derive(Debug, Default)]
pub(crate) struct PaneBuffer {
    /// The number of the acknowledgement over the last picture.
    pub(crate) mark: Option<u32>,
    planes: [Vec<u8>; 3],
}

/// What lies over the picture, shared between threads.
#[derive(Debug, Default)]
pub(crate) struct Overlay(Mutex<Panes>);

/// What lies over the picture at a moment.
#[derive(Clone, Debug, Default)]
pub(crate) struct Panes {
    notice: Option<Arc<Pane>>,
    /// An acknowledgement and its number.
    mark: Option<(u32, Arc<Pane>)>,
}

impl Overlay {
    /// Lays a notice over the picture from the next frame on, or none.
    pub(crate) fn set_notice(&self, pane: Option<Arc<Pane>>) {
        hold(&self.0).notice = pane;
    }

    /// The same for an acknowledgement.
    pub(crate) fn set_mark(&self, mark: Option<(u32, Arc<Pane>)>) {
        hold(&self.0).mark = mark;
    }

    /// What lies there.
    pub(crate) fn get(&self) -> Panes {
        hold(&self.0).clone()
    }
}

impl Panes {
    /// Whether there is a notice.
    pub(crate) fn has_notice(&self) -> bool {
        self.notice.is_some()
    }

    /// Lays them over `picture`, of whose samples so many `thousandths` are left, in the memory of `into`. Over a picture that
    /// they were not drawn for there is nothing.
    pub(crate) fn over<'a>(&self, picture: &Picture<'a>, thousandths: u16, into: &'a mut PaneBuffer) -> Picture<'a> {
        into.mark = self.mark.as_ref().map(|(number, _)| *number);
        let size = (picture.width, picture.height);
        let panes = [self.notice.as_ref(), self.mark.as_ref().map(|(_, pane)| pane)];
        let mut panes = panes.into_iter().flatten().filter(|pane| pane.picture == size).peekable();
        let is_dimmed = thousandths < FULL;
        if panes.peek().is_none() && !is_dimmed {
            return *picture;
        }
        let dim = Dim::to(thousandths);
        for (plane, bytes) in into.planes.iter_mut().enumerate() {
            bytes.clear();
            for row in picture.rows(plane) {
                bytes.extend_from_slice(row);
                if is_dimmed {
                    let at = bytes.len() - row.len();
                    dim.row(plane, row, &mut bytes[at..]);
                }
            }
        }
        panes.for_each(|pane| pane.lay(&mut into.planes));
        let [luma, blue, red] = &into.planes;
        let width = picture.width as usize;
        Picture { planes: [luma, blue, red], strides: [width, width / 2, width / 2], ..*picture }
    }
}

impl Pane {
    /// Lays it over planes of its own size of pictures, without padding.
    fn lay(&self, planes: &mut [Vec<u8>; 3]) {
        let (left, top) = (self.at.0 as usize, self.at.1 as usize);
        let (across, width) = (self.size.0 as usize, self.picture.0 as usize);
        let [luma, chroma @ ..] = planes;
        for (y, row) in self.luma.chunks(across).enumerate() {
            let under = &mut luma[(top + y) * width + left..][..across];
            under.iter_mut().zip(row).filter(|(_, over)| **over != CLEAR).for_each(|(under, over)| *under = *over);
        }
        for (y, rows) in self.luma.chunks(2 * across).enumerate() {
            let is_clear = |x: usize| [0, 1, across, across + 1].iter().all(|at| rows[2 * x + at] == CLEAR);
            for x in (0..across / 2).filter(|x| !is_clear(*x)) {
                let at = (top / 2 + y) * (width / 2) + left / 2 + x;
                for plane in chroma.iter_mut() {
                    plane[at] = GREY;
                }
            }
        }
    }
}
