//! The one interface between the tools and what they render.
//!
//! Owns the notion of a species: something in motion that becomes a frame. Flames are the first; others need
//! nothing from this crate but this trait. Never says how a frame is made.
//!
//! Start at [`Species`].

use crate::animate::Motion;
use crate::image::Image;
use crate::render::{RenderError, Renderer, Settings};

/// What turns a phase into a frame.
pub trait Species: Sync {
    /// The picture at `frame`, in frames from the clip's start; fractions lie between frames.
    ///
    /// # Errors
    /// [`RenderError`] says what cannot be drawn.
    fn frame(&self, frame: f64, settings: &Settings) -> Result<Image, RenderError>;
}

/// The first species: a flame in motion, and the threads that draw it.
#[derive(Debug)]
pub struct Flame<'a, M> {
    /// How the genome moves.
    pub motion: M,
    /// Who draws it.
    pub renderer: &'a Renderer,
}

impl<M: Motion> Species for Flame<'_, M> {
    fn frame(&self, frame: f64, settings: &Settings) -> Result<Image, RenderError> {
        self.renderer.render(&self.motion, frame, settings)
    }
}
