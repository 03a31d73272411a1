//! The memory behind a framebuffer, mapped for writing.
//!
//! Owns every `unsafe` of this crate: two mappings, one descriptor, one ioctl, one field of a union. Never says what is
//! written. Dumb buffers may share one allocation: a driver that maps what it is to light (virtual displays do) then
//! finds it mapped already. On vkms that is worth 1.4 ms of a frame's 10.
//!
//! Start at [`Memory::allocate`].
#![allow(unsafe_code)]

use gbm::{BufferObject, BufferObjectFlags};
use memmap2::{MmapMut, MmapOptions};
use rustix::ioctl::{Setter, ioctl, opcode};
use std::fs::File;
use std::io;
use std::os::fd::{AsFd, AsRawFd, FromRawFd, OwnedFd};
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Arc, Mutex, PoisonError, Weak};

/// `DMA_BUF_IOCTL_SYNC` of `linux/dma-buf.h`; its argument is one `u64` of flags.
const DMA_BUF_SYNC: rustix::ioctl::Opcode = opcode::write::<u64>(b'b', 0);
const SYNC_WRITE: u64 = 2;
const SYNC_END: u64 = 4;

/// An allocation that a card can scan out.
pub(super) enum Memory {
    /// The kernel's own, on every KMS driver: one part of an allocation.
    Dumb { block: Arc<Block>, part: u32 },
    /// The GPU driver's, through its dma-buf. Dropped in this order: mapping, descriptor, object.
    Gbm { map: MmapMut, dma_buf: OwnedFd, object: BufferObject<()> },
}

/// A dumb buffer in equal parts, each the memory of one framebuffer.
pub(super) struct Block {
    handle: u32,
    pitch: u32,
    /// Asked-for width, height and bits per pixel of a part.
    shape: (u32, u32, u32),
    /// Bytes of a part.
    part: u32,
    parts: u32,
    /// How many parts were handed out.
    taken: AtomicU32,
    map: Mutex<MmapMut>,
}

/// Rows of a part are a multiple of this: parts then begin on a page where rows are a multiple of 64 bytes.
const ROWS: u32 = 64;

impl Memory {
    /// Linear memory of `width` by `height` at `bits` (8 or 32) per pixel: from `gbm` if there is one and it can,
    /// else the next part of the dumb buffer `block`, or the first of a new one of `parts`.
    ///
    /// # Errors
    /// What the kernel says about the dumb buffer.
    pub(super) fn allocate(
        card: &File,
        gbm: Option<&gbm::Device<OwnedFd>>,
        shape @ (width, height, bits): (u32, u32, u32),
        block: &mut Weak<Block>,
        parts: u32,
    ) -> io::Result<Self> {
        match gbm.map(|gbm| Self::from_gbm(card, gbm, width, height, bits)) {
            Some(Ok(memory)) => return Ok(memory),
            Some(Err(error)) => tracing::debug!(%error, "gbm has no such buffer, taking a dumb one"),
            None => {}
        }
        let begun = block.upgrade().filter(|block| block.shape == shape && block.parts == parts);
        if let Some(memory) = begun.and_then(Block::next) {
            return Ok(memory);
        }
        let fresh = Arc::new(Block::new(card, shape, parts)?);
        *block = Arc::downgrade(&fresh);
        Ok(Block::next(fresh).expect("a new block has its first part"))
    }
    fn from_gbm(card: &File, gbm: &gbm::Device<OwnedFd>, width: u32, height: u32, bits: u32) -> io::Result<Self> {
        let format = if bits == 8 { gbm::Format::R8 } else { gbm::Format::Xrgb8888 };
        let usage = BufferObjectFlags::SCANOUT | BufferObjectFlags::LINEAR;
        let object: BufferObject<()> = gbm.create_buffer_object(width, height, format, usage)?;
        // Not by `gbm`: some of its drivers hand out descriptors that cannot be mapped for writing.
        let flags = drm_ffi::DRM_CLOEXEC | drm_ffi::DRM_RDWR;
        let exported = drm_ffi::gem::handle_to_fd(card.as_fd(), gem_handle(&object), flags)?;
        // SAFETY: the kernel just made this descriptor for us, and nobody else has it.
        let dma_buf = unsafe { OwnedFd::from_raw_fd(exported.fd) };
        let length = object.stride() as usize * height as usize;
        // SAFETY: the object is at least stride x height bytes, it is ours alone, and the mapping keeps it alive.
        let map = unsafe { MmapOptions::new().len(length).map_mut(dma_buf.as_raw_fd()) }?;
        Ok(Self::Gbm { map, dma_buf, object })
    }

    /// The GEM handle, to make a framebuffer of.
    pub(super) fn handle(&self) -> u32 {
        match self {
            Self::Dumb { block, .. } => block.handle,
            Self::Gbm { object, .. } => gem_handle(object),
        }
    }

    /// Bytes from one row to the next.
    pub(super) fn pitch(&self) -> u32 {
        match self {
            Self::Dumb { block, .. } => block.pitch,
            Self::Gbm { object, .. } => object.stride(),
        }
    }

    /// Where in the handle's bytes this memory begins.
    pub(super) fn offset(&self) -> u32 {
        match self {
            Self::Dumb { block, part } => block.part * part,
            Self::Gbm { .. } => 0,
        }
    }

    /// Lets `paint` write the memory.
    ///
    /// # Errors
    /// The GPU driver does not hand it over.
    pub(super) fn write(&mut self, paint: &mut dyn FnMut(&mut [u8])) -> io::Result<()> {
        match self {
            Self::Dumb { block, part } => {
                let (first, length) = ((block.part * *part) as usize, block.part as usize);
                let mut map = block.map.lock().unwrap_or_else(PoisonError::into_inner);
                paint(&mut map[first..first + length]);
            }
            Self::Gbm { map, dma_buf, .. } => {
                sync(dma_buf, SYNC_WRITE)?;
                paint(map);
                sync(dma_buf, SYNC_WRITE | SYNC_END)?;
            }
        }
        Ok(())
    }

    /// Unmaps and frees it, with its last part. Its framebuffer must be gone.
    pub(super) fn free(self, card: &File) {
        let Self::Dumb { block, .. } = self else { return };
        if let Some(Block { handle, map, .. }) = Arc::into_inner(block) {
            drop(map);
            release(card, handle);
        }
    }
}

impl Block {
    fn new(card: &File, shape @ (width, height, bits): (u32, u32, u32), parts: u32) -> io::Result<Self> {
        use drm_ffi::mode::dumbbuffer::{create, map};
        let rows = if parts > 1 { height.next_multiple_of(ROWS) } else { height };
        let made = create(card.as_fd(), width, rows * parts, bits, 0)?;
        let mapped = map(card.as_fd(), made.handle, 0, 0).and_then(|place| {
            let length = usize::try_from(made.size).map_err(io::Error::other)?;
            // SAFETY: the kernel gave this offset and size for a buffer that we just made: nobody else maps it, and
            // the mapping keeps its pages alive until it is dropped.
            unsafe { MmapOptions::new().offset(place.offset).len(length).map_mut(card) }
        });
        let map = Mutex::new(mapped.inspect_err(|_| release(card, made.handle))?);
        let (part, taken) = (made.pitch * rows, AtomicU32::new(0));
        Ok(Self { handle: made.handle, pitch: made.pitch, shape, part, parts, taken, map })
    }

    /// The next part, if one is left.
    fn next(block: Arc<Self>) -> Option<Memory> {
        let part = block.taken.fetch_add(1, Ordering::Relaxed);
        (part < block.parts).then_some(Memory::Dumb { block, part })
    }
}

fn release(card: &File, handle: u32) {
    if let Err(error) = drm_ffi::mode::dumbbuffer::destroy(card.as_fd(), handle) {
        tracing::debug!(%error, handle, "cannot free a buffer");
    }
}

fn gem_handle(object: &BufferObject<()>) -> u32 {
    // SAFETY: gbm fills the 32-bit field of this union, its handles are GEM handles.
    unsafe { object.handle().u32_ }
}

/// Begins or ends writing by the processor, for GPUs whose caches do not follow it.
fn sync(dma_buf: &OwnedFd, flags: u64) -> io::Result<()> {
    // SAFETY: `DMA_BUF_IOCTL_SYNC` reads one u64 and keeps no pointer to it.
    rustix::io::retry_on_intr(|| unsafe { ioctl(dma_buf, Setter::<DMA_BUF_SYNC, u64>::new(flags)) })?;
    Ok(())
}
