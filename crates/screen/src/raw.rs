//! The `unsafe` code: mappings of framebuffers, and ioctls that no crate wraps.
//!
//! Owns every `unsafe` of this crate: two mappings, one descriptor, twelve ioctls, one field of a union. Start at
//! [`Memory::allocate`].
#![allow(unsafe_code)]

use gbm::{BufferObject, BufferObjectFlags};
use memmap2::{MmapMut, MmapOptions};
use rustix::ioctl::{Getter, IntegerSetter, Setter, Updater, ioctl, opcode};
use std::fs::File;
use std::io;
use std::os::fd::{AsFd, AsRawFd, FromRawFd, OwnedFd, RawFd};

/// `DMA_BUF_IOCTL_SYNC` of `linux/dma-buf.h`; its argument is one `u64` of flags.
const DMA_BUF_SYNC: rustix::ioctl::Opcode = opcode::write::<u64>(b'b', 0);
/// `linux/fb.h`, where these numbers do not encode their arguments.
const FBIOGET_VSCREENINFO: rustix::ioctl::Opcode = 0x4600;
const FBIOGET_FSCREENINFO: rustix::ioctl::Opcode = 0x4602;
/// `linux/kd.h` and `linux/vt.h`, likewise.
const KDSETMODE: rustix::ioctl::Opcode = 0x4B3A;
const VT_SETMODE: rustix::ioctl::Opcode = 0x5602;
const VT_RELDISP: rustix::ioctl::Opcode = 0x5605;
const KD_TEXT: usize = 0;
const KD_GRAPHICS: usize = 1;
const VT_AUTO: u8 = 0;
const VT_PROCESS: u8 = 1;
/// Answers to a console switch: allowed; acknowledged.
pub(crate) const VT_ALLOWED: usize = 1;
pub(crate) const VT_ACKNOWLEDGED: usize = 2;
/// `linux/i2c-dev.h`, likewise.
const I2C_SLAVE: rustix::ioctl::Opcode = 0x0703;
/// `linux/cec.h`.
const CEC_ADAP_G_PHYS_ADDR: rustix::ioctl::Opcode = opcode::read::<u16>(b'a', 1);
const CEC_ADAP_G_LOG_ADDRS: rustix::ioctl::Opcode = opcode::read::<CecAddresses>(b'a', 3);
const CEC_ADAP_S_LOG_ADDRS: rustix::ioctl::Opcode = opcode::read_write::<CecAddresses>(b'a', 4);
const CEC_TRANSMIT: rustix::ioctl::Opcode = opcode::read_write::<CecMessage>(b'a', 5);
const CEC_ADAP_G_CONNECTOR_INFO: rustix::ioctl::Opcode = opcode::read::<CecConnector>(b'a', 10);
const SYNC_WRITE: u64 = 2;
const SYNC_END: u64 = 4;

/// `struct cec_log_addrs`, `struct cec_msg` and `struct cec_connector_info` of `linux/cec.h`, as their bytes or words.
pub(crate) type CecAddresses = [u8; 92];
pub(crate) type CecMessage = [u8; 56];
pub(crate) type CecConnector = [u32; 17];

/// An allocation that a card can scan out.
pub(crate) enum Memory {
    /// A dumb buffer, which every KMS driver has.
    Dumb { handle: u32, pitch: u32, map: MmapMut },
    /// A GBM buffer, through its dma-buf. Dropped in this order: mapping, descriptor, object.
    Gbm { map: MmapMut, dma_buf: OwnedFd, object: BufferObject<()> },
}

impl Memory {
    /// Linear memory of `width` by `height` at `bits` (8 or 32) per pixel: from `gbm` if there is one and it can,
    /// else a dumb buffer.
    /// Errors: The kernel's error for the dumb buffer.
    pub(crate) fn allocate(
        card: &File,
        gbm: Option<&gbm::Device<OwnedFd>>,
        (width, height, bits): (u32, u32, u32),
    ) -> io::Result<Self> {
        match gbm.map(|gbm| Self::from_gbm(card, gbm, width, height, bits)) {
            Some(Ok(memory)) => Ok(memory),
            Some(Err(error)) => {
                tracing::debug!(%error, "cannot allocate a GBM buffer, using a dumb buffer");
                Self::dumb(card, width, height, bits)
            }
            None => Self::dumb(card, width, height, bits),
        }
    }

    fn dumb(card: &File, width: u32, height: u32, bits: u32) -> io::Result<Self> {
        use drm_ffi::mode::dumbbuffer::{create, destroy, map};
        let made = create(card.as_fd(), width, height, bits, 0)?;
        let mapped = map(card.as_fd(), made.handle, 0, 0).and_then(|place| {
            let length = usize::try_from(made.size).map_err(io::Error::other)?;
            // SAFETY: the kernel gave this offset and size for a buffer that we just made: nobody else maps it, and
            // the mapping keeps its pages alive until it is dropped.
            unsafe { MmapOptions::new().offset(place.offset).len(length).map_mut(card) }
        });
        match mapped {
            Ok(map) => Ok(Self::Dumb { handle: made.handle, pitch: made.pitch, map }),
            Err(error) => {
                let _ = destroy(card.as_fd(), made.handle);
                Err(error)
            }
        }
    }

    fn from_gbm(card: &File, gbm: &gbm::Device<OwnedFd>, width: u32, height: u32, bits: u32) -> io::Result<Self> {
        let format = if bits == 8 { gbm::Format::R8 } else { gbm::Format::Xrgb8888 };
        let usage = BufferObjectFlags::SCANOUT | BufferObjectFlags::LINEAR;
        let object: BufferObject<()> = gbm.create_buffer_object(width, height, format, usage)?;
        // Not by `gbm`: some of its drivers return descriptors that cannot be mapped for writing.
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
    pub(crate) fn handle(&self) -> u32 {
        match self {
            Self::Dumb { handle, .. } => *handle,
            Self::Gbm { object, .. } => gem_handle(object),
        }
    }

    /// Bytes from one row to the next.
    pub(crate) fn pitch(&self) -> u32 {
        match self {
            Self::Dumb { pitch, .. } => *pitch,
            Self::Gbm { object, .. } => object.stride(),
        }
    }

    /// Lets `paint` write the memory.
    /// Errors: The GPU driver cannot synchronise it.
    pub(crate) fn write(&mut self, paint: &mut dyn FnMut(&mut [u8])) -> io::Result<()> {
        match self {
            Self::Dumb { map, .. } => paint(map),
            Self::Gbm { map, dma_buf, .. } => {
                sync(dma_buf, SYNC_WRITE)?;
                paint(map);
                sync(dma_buf, SYNC_WRITE | SYNC_END)?;
            }
        }
        Ok(())
    }

    /// Unmaps and frees it. Its framebuffer must be gone.
    pub(crate) fn free(self, card: &File) {
        if let Self::Dumb { handle, map, .. } = self {
            drop(map);
            if let Err(error) = drm_ffi::mode::dumbbuffer::destroy(card.as_fd(), handle) {
                tracing::debug!(%error, handle, "cannot free a buffer");
            }
        }
    }
}

/// The properties of the firmware's framebuffer, from fbdev.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Framebuffer {
    /// Pixels across and down.
    pub(crate) size: (u32, u32),
    /// Bytes from one row to the next.
    pub(crate) pitch: u32,
    /// Bits of a pixel.
    pub(crate) bits: u32,
    /// The offset and length of each channel in bits.
    pub(crate) red: (u32, u32),
    pub(crate) green: (u32, u32),
    pub(crate) blue: (u32, u32),
}

/// Reads the properties of the framebuffer `file`.
///
/// # Errors
/// It is none, or it is gone.
///
/// # Source
/// `struct fb_var_screeninfo` and `struct fb_fix_screeninfo` of `linux/fb.h`.
pub(crate) fn framebuffer(file: &File) -> io::Result<Framebuffer> {
    // SAFETY: `FBIOGET_VSCREENINFO` fills the 160 bytes of its structure, all of numbers, and keeps no pointer.
    let var = unsafe { ioctl(file, Getter::<FBIOGET_VSCREENINFO, [u32; 40]>::new()) }?;
    // SAFETY: `FBIOGET_FSCREENINFO` fills the 80 bytes of its structure, and keeps no pointer. As eight-byte words they are
    // aligned as it is.
    let fix = unsafe { ioctl(file, Getter::<FBIOGET_FSCREENINFO, [u64; 10]>::new()) }?;
    // `line_length` follows a name of 16 bytes, an address, four `u32` and three `u16`.
    let pitch = fix[6].to_ne_bytes();
    let pitch = u32::from_ne_bytes([pitch[0], pitch[1], pitch[2], pitch[3]]);
    let channel = |first: usize| (var[first], var[first + 1]);
    Ok(Framebuffer {
        size: (var[0], var[1]),
        pitch,
        bits: var[6],
        red: channel(8),
        green: channel(11),
        blue: channel(14),
    })
}

/// Sets the `console` to graphics or text mode.
/// Errors: It is no console.
pub(crate) fn set_graphics(console: &File, is_graphics: bool) -> io::Result<()> {
    let mode = if is_graphics { KD_GRAPHICS } else { KD_TEXT };
    // SAFETY: `KDSETMODE` takes a number, and no pointer.
    unsafe { ioctl(console, IntegerSetter::<KDSETMODE>::new_usize(mode)) }?;
    Ok(())
}

/// Sets the signals by which the kernel asks this process before it switches away from the `console`, and when it is
/// back; `None` for automatic switching.
/// Errors: It is no console.
pub(crate) fn set_switching(console: &File, signals: Option<(i32, i32)>) -> io::Result<()> {
    // `struct vt_mode`: two bytes and three `u16`.
    let (release, acquire) = signals.unwrap_or_default();
    let [release, acquire] = [release, acquire].map(|signal| i16::try_from(signal).unwrap_or_default().to_ne_bytes());
    let mode = if signals.is_some() { VT_PROCESS } else { VT_AUTO };
    let vt_mode = [mode, 0, release[0], release[1], acquire[0], acquire[1], 0, 0];
    // SAFETY: `VT_SETMODE` reads the eight bytes of its structure, and keeps no pointer.
    unsafe { ioctl(console, Setter::<VT_SETMODE, [u8; 8]>::new(vt_mode)) }?;
    Ok(())
}

/// Answers the kernel's request to switch consoles.
/// Errors: It has not asked.
pub(crate) fn answer_switch(console: &File, answer: usize) -> io::Result<()> {
    // SAFETY: `VT_RELDISP` takes a number, and no pointer.
    unsafe { ioctl(console, IntegerSetter::<VT_RELDISP>::new_usize(answer)) }?;
    Ok(())
}

/// Has the open I2C `bus` talk to the device at `address`.
/// Errors: It is no I2C bus, or a driver of the kernel uses the address.
pub(crate) fn set_i2c_address(bus: &File, address: usize) -> io::Result<()> {
    // SAFETY: `I2C_SLAVE` takes a number, and no pointer.
    unsafe { ioctl(bus, IntegerSetter::<I2C_SLAVE>::new_usize(address)) }?;
    Ok(())
}

/// The physical address of the CEC `adapter`: where it is plugged in.
/// Errors: It is no CEC adapter.
pub(crate) fn cec_physical_address(adapter: &File) -> io::Result<u16> {
    // SAFETY: `CEC_ADAP_G_PHYS_ADDR` fills one `u16`, and keeps no pointer.
    Ok(unsafe { ioctl(adapter, Getter::<CEC_ADAP_G_PHYS_ADDR, u16>::new()) }?)
}

/// The logical addresses of the CEC `adapter`.
/// Errors: It is no CEC adapter.
pub(crate) fn cec_addresses(adapter: &File) -> io::Result<CecAddresses> {
    // SAFETY: `CEC_ADAP_G_LOG_ADDRS` fills the 92 bytes of its structure, all of numbers, and keeps no pointer.
    Ok(unsafe { ioctl(adapter, Getter::<CEC_ADAP_G_LOG_ADDRS, CecAddresses>::new()) }?)
}

/// Has the CEC `adapter` claim the logical addresses that are asked for; waits until it has.
/// Errors: It is no CEC adapter, or has addresses.
pub(crate) fn claim_cec_addresses(adapter: &File, addresses: &mut CecAddresses) -> io::Result<()> {
    // SAFETY: `CEC_ADAP_S_LOG_ADDRS` reads and fills the 92 bytes of its structure, and keeps no pointer.
    unsafe { ioctl(adapter, Updater::<CEC_ADAP_S_LOG_ADDRS, CecAddresses>::new(addresses)) }?;
    Ok(())
}

/// Sends `message` by the CEC `adapter`, and waits until it is sent; its status says how that went.
/// Errors: It is no CEC adapter, or not connected.
pub(crate) fn transmit_cec(adapter: &File, message: &mut CecMessage) -> io::Result<()> {
    // SAFETY: `CEC_TRANSMIT` reads and fills the 56 bytes of its structure, and keeps no pointer.
    unsafe { ioctl(adapter, Updater::<CEC_TRANSMIT, CecMessage>::new(message)) }?;
    Ok(())
}

/// The connector of the CEC `adapter`.
/// Errors: It is no CEC adapter, or the kernel is older than 5.5.
pub(crate) fn cec_connector(adapter: &File) -> io::Result<CecConnector> {
    // SAFETY: `CEC_ADAP_G_CONNECTOR_INFO` fills the 68 bytes of its structure, all of numbers, and keeps no pointer.
    Ok(unsafe { ioctl(adapter, Getter::<CEC_ADAP_G_CONNECTOR_INFO, CecConnector>::new()) }?)
}

/// The open descriptor `number`, inherited from the process that started this program.
pub(crate) fn take_inherited_fd(number: RawFd) -> OwnedFd {
    // SAFETY: a `FdStore` tells the number of a descriptor that nobody else here has, and `Device` asks once.
    unsafe { OwnedFd::from_raw_fd(number) }
}

fn gem_handle(object: &BufferObject<()>) -> u32 {
    // SAFETY: gbm fills the 32-bit field of this union, its handles are GEM handles.
    unsafe { object.handle().u32_ }
}

/// Begins or ends writing by the processor, for GPUs without coherent caches.
fn sync(dma_buf: &OwnedFd, flags: u64) -> io::Result<()> {
    // SAFETY: `DMA_BUF_IOCTL_SYNC` reads one u64 and keeps no pointer to it.
    rustix::io::retry_on_intr(|| unsafe { ioctl(dma_buf, Setter::<DMA_BUF_SYNC, u64>::new(flags)) })?;
    Ok(())
}
