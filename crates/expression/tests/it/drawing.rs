//! Threads that draw.

use expression::{ExpressionError, Moving, Settings, render};
use species::{Image, RenderError, Threads};

/// Threads, and what they refuse as what it is.
pub(crate) struct Renderer(Threads);

impl Renderer {
    pub(crate) fn new(threads: usize) -> Renderer {
        Renderer(Threads::new(threads).unwrap())
    }

    /// The picture at `frame`.
    pub(crate) fn render(
        &self,
        moving: &dyn Moving,
        frame: f64,
        settings: &Settings,
    ) -> Result<Image, ExpressionError> {
        match render(moving, frame, settings, &self.0) {
            Ok((image, _)) => Ok(image),
            Err(RenderError::Refused(refusal)) => Err(*refusal.downcast().unwrap()),
            Err(RenderError::Stopped) => unreachable!("nobody stops a test"),
        }
    }
}
