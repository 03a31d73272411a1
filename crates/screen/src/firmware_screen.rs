//! The firmware's framebuffer, for a display without a driver.
//!
//! Writes pictures to it through fbdev (`/dev/fb0`): scaled, rotated, dimmed and converted in software, at most 60 a
//! second, since it has no vblank. It cannot be switched off: at night it is black. It is written to and not mapped:
//! once the display's DRM driver is loaded the kernel refuses writes, but mapped memory would be the driver's.
//!
//! Start at [`FirmwareScreen::open`]. `display.rs` replaces it by a card; `virtual_screen.rs` holds pictures until they
//! are due.

use crate::kms::{Console, Switch, fit};
use crate::paint::{Format, Layout, blacken, paint};
use crate::raw::{Framebuffer, framebuffer};
use crate::transform::{Transform, Transformer};
use crate::virtual_screen::{Pace, VirtualScreen};
use crate::{DimmedBy, Event, Light, OutputSettings, Picture, Screen, ScreenError, ScreenInfo};
use std::fs::{self, File};
use std::os::fd::OwnedFd;
use std::os::unix::fs::FileExt;
use std::time::Duration;
use timing::{Nanos, Rate, Vblank};

/// The framebuffer that the kernel takes over from the firmware.
const DEVICE: &str = "/dev/fb0";
/// The name of its driver.
const NAME: &str = "/sys/class/graphics/fb0/name";
/// Suffix of the names of framebuffers that a DRM driver emulates.
const EMULATED: &str = "drmfb";
/// Pictures a second, at most.
const REFRESH_HZ: u64 = 60;
/// All of the light, in thousandths.
const FULL: u16 = 1000;

/// How a pixel lies in memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Packing {
    /// Blue, green, red, unused: the output of `convert.rs`.
    Bgrx,
    /// Red, green, blue, nothing.
    Rgbx,
    /// Blue, green, red.
    Bgr,
    /// Five, six and five bits, red first, as a little-endian number.
    Rgb565,
}

/// The framebuffer, as a screen.
pub(crate) struct FirmwareScreen {
    file: File,
    name: String,
    framebuffer: Framebuffer,
    packing: Packing,
    /// Holds pictures until their vblank, which is computed.
    queue: VirtualScreen,
    output: OutputSettings,
    thousandths: u16,
    transformer: Transformer,
    /// The picture as XRGB8888, and in the framebuffer's format.
    converted: Vec<u8>,
    packed: Vec<u8>,
    /// The kernel has refused to write.
    is_gone: bool,
    /// The console that the player was started on, and whether another one is active.
    console: Option<Console>,
    is_elsewhere: bool,
}

impl FirmwareScreen {
    /// The firmware's framebuffer, for pictures of `size`; `None` if there is none, or its pixel format is not supported.
    pub(crate) fn open(size: (u32, u32), now: fn() -> Nanos, output: &OutputSettings) -> Option<Self> {
        let name = fs::read_to_string(NAME).ok()?.trim().to_owned();
        if name.ends_with(EMULATED) {
            return None;
        }
        let opened =
            File::options().write(true).read(true).open(DEVICE).and_then(|file| Ok((framebuffer(&file)?, file)));
        let (framebuffer, file) =
            opened.inspect_err(|error| tracing::warn!(%error, "cannot open the firmware framebuffer")).ok()?;
        let packing = packing(&framebuffer).or_else(|| {
            tracing::warn!(?framebuffer, "the firmware framebuffer has an unsupported pixel format");
            None
        })?;
        let refresh = Rate::new(REFRESH_HZ, 1).expect("60 Hz is a rate");
        Some(Self {
            file,
            name,
            packing,
            queue: VirtualScreen::new(size, refresh, Pace::Timer, now).to_measure(),
            output: output.clone(),
            thousandths: FULL,
            transformer: Transformer::default(),
            converted: Vec::new(),
            packed: vec![0; framebuffer.pitch as usize * framebuffer.size.1 as usize],
            framebuffer,
            is_gone: false,
            console: Console::take().ok().flatten(),
            is_elsewhere: false,
        })
    }

    /// Whether the display's DRM driver has taken it over.
    pub(crate) fn is_gone(&self) -> bool {
        self.is_gone
    }

    /// Leaves the console in graphics mode for the card that takes over.
    pub(crate) fn leave_console_to_the_card(&mut self) {
        std::mem::forget(self.console.take());
    }

    /// The open framebuffer, to hand over to another process.
    pub(crate) fn into_fd(self) -> OwnedFd {
        self.file.into()
    }

    /// Puts the picture on the screen.
    fn draw(&mut self) {
        let size = (self.framebuffer.size.0 & !1, self.framebuffer.size.1 & !1);
        let layout = Layout::new(Format::Xr24, size, size.0 * 4);
        if self.converted.len() != layout.bytes() {
            self.converted = vec![0; layout.bytes()];
        }
        blacken(&mut self.converted, &layout);
        if let Some(picture) = self.queue.picture() {
            let rotation = self.output.rotation;
            let area = fit(rotation.of_size((picture.width, picture.height)), size, self.output.margin);
            let transform = Transform { rotation, size: (area.width, area.height), thousandths: self.thousandths };
            let picture = self.transformer.apply(&picture, transform);
            paint(&mut self.converted, &layout, (area.left, area.top), &picture);
        }
        self.write(size);
    }

    fn draw_black(&mut self) {
        self.converted.fill(0);
        self.write((self.framebuffer.size.0 & !1, self.framebuffer.size.1 & !1));
    }

    fn write(&mut self, size: (u32, u32)) {
        let rows = self.converted.chunks_exact(size.0 as usize * 4);
        for (out, row) in self.packed.chunks_exact_mut(self.framebuffer.pitch as usize).zip(rows) {
            pack(self.packing, row, out);
        }
        if let Err(error) = self.file.write_all_at(&self.packed, 0)
            && !std::mem::replace(&mut self.is_gone, true)
        {
            tracing::info!(%error, "cannot write to the firmware framebuffer: it is gone");
        }
    }
}

/// The pixel format of `framebuffer`; `None` if it is not supported.
fn packing(framebuffer: &Framebuffer) -> Option<Packing> {
    match (framebuffer.bits, framebuffer.red, framebuffer.green, framebuffer.blue) {
        (32, (16, 8), (8, 8), (0, 8)) => Some(Packing::Bgrx),
        (32, (0, 8), (8, 8), (16, 8)) => Some(Packing::Rgbx),
        (24, (16, 8), (8, 8), (0, 8)) => Some(Packing::Bgr),
        (16, (11, 5), (5, 6), (0, 5)) => Some(Packing::Rgb565),
        _ => None,
    }
}

/// Packs a row of XRGB8888.
fn pack(packing: Packing, row: &[u8], out: &mut [u8]) {
    let pixels = row.chunks_exact(4);
    match packing {
        Packing::Bgrx => out[..row.len()].copy_from_slice(row),
        Packing::Rgbx => {
            out.chunks_exact_mut(4)
                .zip(pixels)
                .for_each(|(out, bgrx)| out.copy_from_slice(&[bgrx[2], bgrx[1], bgrx[0], 0]));
        }
        Packing::Bgr => out.chunks_exact_mut(3).zip(pixels).for_each(|(out, bgrx)| out.copy_from_slice(&bgrx[..3])),
        Packing::Rgb565 => {
            for (out, bgrx) in out.chunks_exact_mut(2).zip(pixels) {
                let [blue, green, red] = [bgrx[0], bgrx[1], bgrx[2]].map(u16::from);
                out.copy_from_slice(&((red >> 3) << 11 | (green >> 2) << 5 | blue >> 3).to_le_bytes());
            }
        }
    }
}

impl Screen for FirmwareScreen {
    fn info(&self) -> Option<ScreenInfo> {
        let lit = self.queue.info()?;
        let (width, height) = self.framebuffer.size;
        Some(ScreenInfo {
            screen: format!("firmware:{DEVICE} {} (no driver drives this display)", self.name),
            mode: format!("{width}x{height}@{}", lit.refresh),
            size: self.framebuffer.size,
            format: format!("{:?}", self.packing),
            dimmed_by: DimmedBy::Samples,
            ..lit
        })
    }

    fn stage(&mut self, picture: &Picture<'_>) -> Result<(), ScreenError> {
        self.queue.stage(picture)
    }

    fn commit(&mut self) {
        self.queue.commit();
    }

    fn set_format(&mut self, size: (u32, u32), fps: Rate) {
        self.queue.set_format(size, fps);
    }

    fn set_light(&mut self, light: Light) {
        match light {
            Light::On { thousandths } => self.thousandths = thousandths.min(FULL),
            Light::Off => self.draw_black(),
        }
        self.queue.set_light(light);
    }

    fn set_output(&mut self, output: &OutputSettings) {
        self.output = output.clone();
    }

    fn notify_at(&mut self, vblank: Vblank) {
        self.queue.notify_at(vblank);
    }

    fn next_event(&mut self, timeout: Duration) -> Event {
        while let Some(switch) = self.console.as_ref().and_then(Console::switch) {
            self.is_elsewhere = switch == Switch::Away;
            if let (Switch::Away, Some(console)) = (switch, &self.console) {
                console.release();
            }
        }
        let event = self.queue.next_event(timeout);
        if matches!(event, Event::Flip { .. }) && !self.is_elsewhere {
            self.draw();
        }
        event
    }
}

#[cfg(test)]
mod tests {
    use super::{Framebuffer, Packing, pack, packing};

    #[test]
    fn pixels_are_packed_as_the_framebuffer_has_them() {
        // Blue 1, green 2, red 255; and blue 255, green 128, red 8.
        let row = [1, 2, 255, 99, 255, 128, 8, 99];
        let packed = |packing, bytes: usize| {
            let mut out = vec![7; bytes];
            pack(packing, &row, &mut out);
            out
        };
        assert_eq!(packed(Packing::Bgrx, 10), [1, 2, 255, 99, 255, 128, 8, 99, 7, 7], "what lies behind a row stays");
        assert_eq!(packed(Packing::Rgbx, 8), [255, 2, 1, 0, 8, 128, 255, 0]);
        assert_eq!(packed(Packing::Bgr, 6), [1, 2, 255, 255, 128, 8]);
        assert_eq!(packed(Packing::Rgb565, 4), [0x00, 0xf8, 0x1f, 0x0c]);
    }

    #[test]
    fn a_form_that_we_do_not_write_is_none() {
        let usual = Framebuffer { size: (8, 8), pitch: 32, bits: 32, red: (16, 8), green: (8, 8), blue: (0, 8) };
        assert_eq!(packing(&usual), Some(Packing::Bgrx));
        assert_eq!(packing(&Framebuffer { red: (0, 8), blue: (16, 8), ..usual }), Some(Packing::Rgbx));
        assert_eq!(packing(&Framebuffer { bits: 8, ..usual }), None);
        assert_eq!(packing(&Framebuffer { red: (20, 10), ..usual }), None, "ten bits a channel");
    }
}
