//! Draws the samples of frames on a GPU.
//!
//! Owns the choice of the GPU, its shaders once compiled, and what becomes of its failures. `tape.rs` writes formulas as text,
//! `program.rs` a frame's shader and its numbers, `frame.rs` runs it. The pictures agree with the processor's, but not in
//! every bit: they are another draw of the same samples.
//!
//! Start at [`Gpu::find`].

mod frame;
mod program;
mod tape;

use std::collections::HashMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Mutex, PoisonError};

use wgpu::{
    Adapter, Backends, ComputePipeline, ComputePipelineDescriptor, DeviceDescriptor, DeviceType, ErrorFilter, Instance,
    InstanceDescriptor, Limits, PipelineCompilationOptions, PollType, Queue, ShaderModuleDescriptor, ShaderSource,
};

use super::RenderError;
use super::device::Device;
use super::histogram::Sums;
use super::shot::Shot;
use frame::Frame;
use program::Program;

/// Most shaders that are kept: more than a clip has.
const MOST_SHADERS: usize = 64;

/// A GPU, ready to draw. Frames take turns on it.
#[derive(Debug)]
pub(crate) struct Gpu {
    device: wgpu::Device,
    queue: Queue,
    name: String,
    limits: Limits,
    /// Whether it is a program that runs on the processor.
    is_software: bool,
    /// By their texts. Whoever has the lock draws.
    shaders: Mutex<HashMap<String, ComputePipeline>>,
    /// What made it useless.
    failure: Arc<Mutex<Option<String>>>,
}

impl Gpu {
    /// The GPU of this machine that looks fastest.
    /// Errors: [`RenderError::NoGpu`] tells what was found.
    pub(crate) fn find() -> Result<Gpu, RenderError> {
        let descriptor =
            InstanceDescriptor { backends: Backends::VULKAN, ..InstanceDescriptor::new_without_display_handle() };
        let instance = Instance::new(descriptor);
        let mut adapters = pollster::block_on(instance.enumerate_adapters(Backends::VULKAN));
        adapters.sort_by_key(|adapter| slowness(adapter.get_info().device_type));
        let mut refused = Vec::new();
        for adapter in adapters {
            match Gpu::new(&adapter) {
                Ok(gpu) => return Ok(gpu),
                Err(refusal) => refused.push(refusal),
            }
        }
        let found =
            if refused.is_empty() { "Vulkan knows none on this machine".to_owned() } else { refused.join("; ") };
        Err(RenderError::NoGpu { found })
    }

    fn new(adapter: &Adapter) -> Result<Gpu, String> {
        let info = adapter.get_info();
        let name = [&info.name, &info.driver, &info.driver_info].map(|part| part.trim().to_owned()).join(" ");
        let limits = adapter.limits();
        let wanted = DeviceDescriptor { required_limits: limits.clone(), ..DeviceDescriptor::default() };
        let opened = pollster::block_on(adapter.request_device(&wanted));
        let (device, queue) = opened.map_err(|error| format!("`{name}`: {error}"))?;
        let failure = Arc::new(Mutex::new(None));
        let fail = |failure: &Arc<Mutex<Option<String>>>| {
            let failure = Arc::clone(failure);
            move |reason: String| {
                failure.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(reason);
            }
        };
        let lost = fail(&failure);
        device.set_device_lost_callback(move |_, reason| lost(reason));
        let wrong = fail(&failure);
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| wrong(error.to_string())));
        let is_software = info.device_type == DeviceType::Cpu;
        Ok(Gpu { device, queue, name, limits, is_software, shaders: Mutex::default(), failure })
    }

    /// Does `work`, which uses the device.
    /// Errors: [`RenderError`] if the device refuses any of it, or has failed.
    fn checked<T>(&self, work: impl FnOnce() -> T) -> Result<T, RenderError> {
        let filters = [ErrorFilter::OutOfMemory, ErrorFilter::Internal, ErrorFilter::Validation];
        let scopes = filters.map(|filter| self.device.push_error_scope(filter));
        let done = work();
        // The last one that was pushed ends first.
        let refused = scopes.into_iter().rev().filter_map(|scope| pollster::block_on(scope.pop()));
        let refused: Vec<String> = refused.map(|error| error.to_string()).collect();
        self.is_fine()?;
        match refused.first() {
            Some(reason) => Err(self.failed(reason)),
            None => Ok(done),
        }
    }

    /// Waits until the device has done all that it was given.
    /// Errors: [`RenderError::Gpu`] if it has failed.
    fn wait(&self) -> Result<(), RenderError> {
        // Where the device is gone, `wgpu` has no error to return here.
        let waited = catch_unwind(AssertUnwindSafe(|| self.device.poll(PollType::wait_indefinitely())));
        self.is_fine()?;
        match waited {
            Ok(Ok(_)) => Ok(()),
            Ok(Err(error)) => Err(self.failed(&error.to_string())),
            Err(_) => Err(self.failed("it is gone")),
        }
    }

    fn is_fine(&self) -> Result<(), RenderError> {
        let failure = self.failure.lock().unwrap_or_else(PoisonError::into_inner);
        failure.as_deref().map_or(Ok(()), |reason| Err(self.failed(reason)))
    }

    fn failed(&self, reason: &str) -> RenderError {
        // Messages of several lines end in one that tells the cause.
        let reason = reason.lines().map(str::trim).filter(|line| !line.is_empty()).collect::<Vec<_>>().join(": ");
        RenderError::Gpu { name: self.name.clone(), reason }
    }

    fn compiled(&self, text: &str) -> Result<ComputePipeline, RenderError> {
        self.checked(|| {
            let source = ShaderSource::Wgsl(text.into());
            let module = self.device.create_shader_module(ShaderModuleDescriptor { label: None, source });
            self.device.create_compute_pipeline(&ComputePipelineDescriptor {
                label: None,
                layout: None,
                module: &module,
                entry_point: Some("draw"),
                compilation_options: PipelineCompilationOptions::default(),
                cache: None,
            })
        })
    }
}

impl Device for Gpu {
    fn name(&self) -> &str {
        &self.name
    }

    fn draw(&self, shot: &Shot, sums: &mut Sums, stop: &AtomicBool) -> Result<u64, RenderError> {
        let Program { text, words } = Program::new(shot)?;
        let mut shaders = self.shaders.lock().unwrap_or_else(PoisonError::into_inner);
        let shader = if let Some(shader) = shaders.get(&text) {
            shader.clone()
        } else {
            if shaders.len() == MOST_SHADERS {
                shaders.clear();
            }
            shaders.entry(text.clone()).or_insert(self.compiled(&text)?).clone()
        };
        let frame = Frame::new(self, &shader, shot, &words)?;
        frame.draw(stop)?;
        frame.read(sums)
    }
}

/// A guess, smaller for the faster.
fn slowness(kind: DeviceType) -> u8 {
    match kind {
        DeviceType::DiscreteGpu => 0,
        DeviceType::IntegratedGpu => 1,
        DeviceType::VirtualGpu => 2,
        DeviceType::Other => 3,
        DeviceType::Cpu => 4,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::genome::Genome;
    use crate::render::filter::Moment;
    use crate::render::view::View;

    fn shot() -> (Shot, usize) {
        let genome = Genome::parse(include_str!("../../../tests/genomes/xaos.flam3")).unwrap();
        let view = View::new(&genome).unwrap();
        let cells = view.cells[0] * view.cells[1];
        let moments = [Moment { offset: 0.0, light: 1.0 }];
        (Shot::new(&[(genome, view)], &moments, 1_500_000, 1).unwrap(), cells)
    }

    #[test]
    fn rounds_of_a_gpu_add_up_in_one_histogram() {
        let (gpu, (shot, cells)) = (Gpu::find().unwrap(), shot());
        let draw =
            |seed: u64, sums: &mut Sums| gpu.draw(&shot.again(700_000, seed), sums, &AtomicBool::new(false)).unwrap();
        let [mut one, mut other, mut both] = [0; 3].map(|_| Sums::new(cells));
        let samples = [draw(1, &mut one), draw(2, &mut other), draw(1, &mut both), draw(2, &mut both)];
        assert!(samples[0] >= 699_000 && samples[..2] == samples[2..], "{samples:?}");
        assert!((0..cells).any(|cell| one.at(cell) != other.at(cell)));
        for cell in 0..cells {
            let added: [f32; 4] = std::array::from_fn(|at| one.at(cell)[at] + other.at(cell)[at]);
            assert_eq!(both.at(cell), added, "cell {cell}");
        }
    }

    #[test]
    fn a_gpu_that_is_gone_is_an_error_for_this_frame_and_the_next() {
        let (gpu, (shot, cells)) = (Gpu::find().unwrap(), shot());
        let draw = || gpu.draw(&shot, &mut Sums::new(cells), &AtomicBool::new(false));
        assert!(draw().is_ok());
        gpu.device.destroy();
        for _ in 0..2 {
            let refused = draw().err().map(|error| error.to_string()).unwrap_or_default();
            assert!(refused.starts_with(&format!("the GPU `{}` failed: ", gpu.name)), "{refused}");
        }
    }
}
