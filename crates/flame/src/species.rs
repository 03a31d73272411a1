//! The interface between the tools and what they render.
//!
//! Owns the notion of a species: something moving that can be rendered as a frame. Flames are the only one so far;
//! others need only this trait.
//!
//! Start at [`Species`].

use crate::animate::Motion;
use crate::render::{RenderError, Renderer, Settings};
use species::Image;

/// Something that can be rendered frame by frame.
pub trait Species: Sync {
    /// The picture at `frame`, in frames from the clip's start; fractions lie between frames.
    ///
    /// # Errors
    /// [`RenderError`] says what cannot be drawn.
    fn frame(&self, frame: f64, settings: &Settings) -> Result<Image, RenderError>;
}

/// A moving flame, and the threads that render it.
#[derive(Debug)]
pub struct Flame<'a, M> {
    /// The moving genome.
    pub motion: M,
    /// The threads that render it.
    pub renderer: &'a Renderer,
}

impl<M: Motion> Species for Flame<'_, M> {
    fn frame(&self, frame: f64, settings: &Settings) -> Result<Image, RenderError> {
        self.renderer.render(&self.motion, frame, settings)
    }
}
