//! What draws the samples of frames: this machine's processor, or a GPU.
//!
//! Owns the choice. A back-end takes a [`Shot`] and adds whole numbers to a histogram; filters and tone mapping are the
//! processor's whatever has drawn. Without the feature `gpu` there is none but the processor.
//!
//! Start at [`Backend`].

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use super::RenderError;
use super::device::Device;
use super::draw::{self, Arithmetic};
use super::histogram::Sums;
use super::shot::Shot;

/// The version of what GPUs draw: with another one, the same genome and settings make other bits on the same GPU, though
/// [`VERSION`](super::VERSION) is the same.
pub const GPU_VERSION: u32 = 1;

/// What draws the samples of frames. The default is this machine's processor.
#[derive(Clone, Debug, Default)]
pub struct Backend {
    device: Option<Arc<dyn Device>>,
}

impl Backend {
    /// This machine's processor.
    pub const PROCESSOR: Backend = Backend { device: None };

    /// The GPU of this machine that looks fastest.
    ///
    /// # Errors
    /// [`RenderError::NotBuilt`] without the feature `gpu`; [`RenderError::NoGpu`] tells what was found.
    pub fn gpu() -> Result<Backend, RenderError> {
        #[cfg(feature = "gpu")]
        return Ok(Backend { device: Some(Arc::new(super::gpu::Gpu::find()?)) });
        #[cfg(not(feature = "gpu"))]
        Err(RenderError::NotBuilt)
    }

    /// The name of the GPU, with that of its driver; `None` for this machine's processor. Another one makes other bits of the
    /// same picture.
    pub fn name(&self) -> Option<&str> {
        self.device.as_deref().map(Device::name)
    }

    /// Draws all samples of `shot` and adds them to `sums`; once `stop` is set, fewer. Returns how many samples that were,
    /// seen or not. What is not in the fastest arithmetic is for the processor.
    pub(crate) fn draw(
        &self,
        shot: &Shot,
        sums: &mut Sums,
        arithmetic: Arithmetic,
        stop: &AtomicBool,
    ) -> Result<u64, RenderError> {
        match &self.device {
            Some(device) if arithmetic == Arithmetic::Fastest => device.draw(shot, sums, stop),
            _ => Ok(draw::draw(shot, sums, arithmetic, stop)),
        }
    }
}
