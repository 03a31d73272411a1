//! One frame on a GPU: its buffers, its batches and its sums.
//!
//! Owns what lies in the GPU's memory while a frame is drawn. Orbits stay there between batches, so that how large these are
//! changes nothing of the picture. Sums have 64 bits, in two buffers. Never knows what a transform is: `program.rs` does.
//!
//! Start at [`Frame::new`].

use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc;

use wgpu::{
    BindGroup, BindGroupDescriptor, BindGroupEntry, Buffer, BufferDescriptor, BufferUsages, CommandEncoderDescriptor,
    ComputePassDescriptor, ComputePipeline, MapMode,
};

use super::Gpu;
use crate::render::RenderError;
use crate::render::histogram::{Sums, UNIT};
use crate::render::pool::ORBITS;
use crate::render::shot::Shot;
use species::Rng;

/// Orbits that run together.
pub(super) const ORBITS_OF_WORKGROUP: u32 = 128;

/// Most streams of a frame: with so many, every lane of the largest GPUs has an orbit.
const MOST_STREAMS: u64 = 128;

/// Samples of a batch, on a GPU and on a software driver: a tenth of a second or less of a GPU that has a display to draw, too,
/// and of a second on two cores.
const BATCH: u64 = 1 << 25;
const BATCH_OF_SOFTWARE: u64 = 1 << 20;

/// Words of an orbit: its place, its colour, its last transform, its generator, and how many samples it has drawn.
const WORDS: u64 = 9;

/// Which of them is the number of samples.
const SAMPLES: u64 = 8;

/// Words of what a batch is told.
const SETTING: usize = 11;

/// Bytes of a word.
const WORD: u64 = size_of::<u32>() as u64;

/// Bytes of a cell's sums.
const CELL: u64 = 4 * WORD;

/// Most bytes that are read at a time.
const CHUNK: u64 = 1 << 26;

/// A frame that is being drawn.
pub(super) struct Frame<'a> {
    gpu: &'a Gpu,
    shader: &'a ComputePipeline,
    shot: &'a Shot,
    /// How many streams of random numbers its samples come from.
    streams: u32,
    /// Whether a sum may have more than 32 bits.
    carries: bool,
    setting: Buffer,
    orbits: Buffer,
    sums: Buffer,
    carried: Buffer,
    group: BindGroup,
}

impl<'a> Frame<'a> {
    /// The frame of `shot`, before its first sample. `words` are the program's.
    /// Errors: [`RenderError`] if there is no memory for it, or the GPU fails.
    pub(super) fn new(
        gpu: &'a Gpu,
        shader: &'a ComputePipeline,
        shot: &'a Shot,
        words: &[u32],
    ) -> Result<Frame<'a>, RenderError> {
        let carries = shot.samples() * u64::from(UNIT) > u64::from(u32::MAX);
        let [width, height] = shot.plans[0].cells;
        let size_of_sums = (width * height) as u64 * CELL;
        let streams = (shot.all_steps / shot.least_steps()).clamp(1, MOST_STREAMS) as u32;
        let begun = begun(shot.seed, streams);
        let largest = size_of_sums.max(size_of_val(words) as u64).max(size_of_val(&shot.palette[..]) as u64);
        let most = gpu.limits.max_storage_buffer_binding_size.min(gpu.limits.max_buffer_size);
        let too_large =
            || RenderError::GpuMemory { name: gpu.name.clone(), needed: largest / 1_000_000, most: most / 1_000_000 };
        if largest > most {
            return Err(too_large());
        }
        gpu.checked(|| {
            let sums_of = |size| {
                let usage = BufferUsages::STORAGE | BufferUsages::COPY_SRC;
                gpu.device.create_buffer(&BufferDescriptor { label: None, size, usage, mapped_at_creation: false })
            };
            // Not by `create_buffer_init`, which panics where the GPU is gone.
            let filled = |contents: &[u8], usage| {
                let (size, usage) = (contents.len() as u64, usage | BufferUsages::COPY_DST);
                let descriptor = BufferDescriptor { label: None, size, usage, mapped_at_creation: false };
                let buffer = gpu.device.create_buffer(&descriptor);
                gpu.queue.write_buffer(&buffer, 0, contents);
                buffer
            };
            let setting = filled(&[0; SETTING * WORD as usize], BufferUsages::UNIFORM);
            let plans = filled(&bytes(words), BufferUsages::STORAGE);
            let palette = filled(&bytes(shot.palette.as_flattened()), BufferUsages::STORAGE);
            let orbits = filled(&bytes(&begun), BufferUsages::STORAGE | BufferUsages::COPY_SRC);
            let sums = sums_of(size_of_sums);
            let carried = sums_of(if carries { size_of_sums } else { CELL });
            let buffers = [&setting, &plans, &palette, &orbits, &sums, &carried];
            let entries: Vec<_> = (0..)
                .zip(buffers)
                .map(|(binding, buffer)| BindGroupEntry { binding, resource: buffer.as_entire_binding() })
                .collect();
            let layout = shader.get_bind_group_layout(0);
            let group =
                gpu.device.create_bind_group(&BindGroupDescriptor { label: None, layout: &layout, entries: &entries });
            Frame { gpu, shader, shot, streams, carries, setting, orbits, sums, carried, group }
        })
    }

    /// Draws all samples; once `stop` is set, fewer.
    pub(super) fn draw(&self, stop: &AtomicBool) -> Result<(), RenderError> {
        let orbits = self.orbits();
        let steps = self.shot.fuse + self.shot.all_steps.div_ceil(self.streams.into());
        let samples = if self.gpu.is_software { BATCH_OF_SOFTWARE } else { BATCH };
        let count = (samples / u64::from(orbits)).max(1);
        let mut first = 0;
        while first < steps && !stop.load(Ordering::Relaxed) {
            let begins = first.saturating_sub(self.shot.fuse) * u64::from(self.streams);
            let moment = self.shot.begins.partition_point(|moment| *moment <= begins) - 1;
            let [width, height] = self.shot.plans[0].cells;
            let setting = [
                width as u32,
                height as u32,
                first as u32,
                count.min(steps - first) as u32,
                self.shot.fuse as u32,
                ORBITS as u32,
                self.streams,
                self.shot.all_steps as u32,
                self.shot.begins.len() as u32,
                moment as u32,
                orbits,
            ];
            self.gpu.checked(|| self.submit(&setting))?;
            self.gpu.wait()?;
            first += count;
        }
        Ok(())
    }

    fn submit(&self, setting: &[u32; SETTING]) {
        self.gpu.queue.write_buffer(&self.setting, 0, &bytes(setting));
        let mut encoder = self.gpu.device.create_command_encoder(&CommandEncoderDescriptor::default());
        {
            let mut pass = encoder.begin_compute_pass(&ComputePassDescriptor::default());
            pass.set_pipeline(self.shader);
            pass.set_bind_group(0, &self.group, &[]);
            pass.dispatch_workgroups(self.orbits().div_ceil(ORBITS_OF_WORKGROUP), 1, 1);
        }
        self.gpu.queue.submit([encoder.finish()]);
    }

    /// Adds what was drawn to `sums`. Returns how many samples that were, seen or not.
    pub(super) fn read(&self, sums: &mut Sums) -> Result<u64, RenderError> {
        let words = [(&self.sums, 0), (&self.carried, u32::BITS)];
        for (buffer, shift) in &words[..=usize::from(self.carries)] {
            let mut at = 0;
            self.read_words(buffer, 0..buffer.size(), &mut |word| {
                if word > 0 {
                    sums.add(at / 4, at % 4, u64::from(word) << shift);
                }
                at += 1;
            })?;
        }
        let mut samples = 0;
        let (orbits, begin) = (u64::from(self.orbits()), SAMPLES * u64::from(self.orbits()) * WORD);
        self.read_words(&self.orbits, begin..begin + orbits * WORD, &mut |word| samples += u64::from(word))?;
        Ok(samples)
    }

    /// Gives the words in `range` of `buffer`, in bytes, to `take`.
    fn read_words(&self, buffer: &Buffer, range: Range<u64>, take: &mut dyn FnMut(u32)) -> Result<(), RenderError> {
        let Gpu { device, queue, .. } = self.gpu;
        let usage = BufferUsages::COPY_DST | BufferUsages::MAP_READ;
        let size = CHUNK.min(range.end - range.start);
        let staging = self.gpu.checked(|| {
            device.create_buffer(&BufferDescriptor { label: None, size, usage, mapped_at_creation: false })
        })?;
        let mut begin = range.start;
        while begin < range.end {
            let size = size.min(range.end - begin);
            let (sender, receiver) = mpsc::channel();
            self.gpu.checked(|| {
                let mut encoder = device.create_command_encoder(&CommandEncoderDescriptor::default());
                encoder.copy_buffer_to_buffer(buffer, begin, &staging, 0, size);
                queue.submit([encoder.finish()]);
                staging.map_async(MapMode::Read, 0..size, move |mapped| {
                    // Whoever waits for it may have given up.
                    let _ = sender.send(mapped);
                });
            })?;
            self.gpu.wait()?;
            let is_mapped = receiver.try_recv().is_ok_and(|mapped| mapped.is_ok());
            let view = is_mapped.then(|| staging.get_mapped_range(0..size).ok()).flatten();
            let view = view.ok_or_else(|| self.gpu.failed("its memory cannot be read"))?;
            for word in view.as_chunks().0 {
                take(u32::from_le_bytes(*word));
            }
            drop(view);
            staging.unmap();
            begin += size;
        }
        Ok(())
    }

    fn orbits(&self) -> u32 {
        self.streams * ORBITS as u32
    }
}

/// Orbits at random points, one word of all beside the other.
fn begun(seed: u64, streams: u32) -> Vec<u32> {
    let orbits = streams as usize * ORBITS;
    let mut words = vec![0; orbits * WORDS as usize];
    for stream in 0..streams as usize {
        let mut random = Rng::stream(seed, stream as u64);
        for orbit in stream * ORBITS..(stream + 1) * ORBITS {
            let place = [random.signed(), random.signed(), random.unit()];
            for (word, value) in place.into_iter().enumerate() {
                words[word * orbits + orbit] = (value as f32).to_bits();
            }
            for word in 4..8 {
                words[word * orbits + orbit] = (random.bits() >> 32) as u32;
            }
        }
    }
    words
}

fn bytes(words: &[u32]) -> Vec<u8> {
    words.iter().flat_map(|word| word.to_le_bytes()).collect()
}
