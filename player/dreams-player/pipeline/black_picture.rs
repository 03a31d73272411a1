//! A night in black: the display stays on and shows nothing.
//!
//! Owns the black picture, and lights it again when the display comes back. For the flip thread it is as if the screen
//! were gone meanwhile. Never decides when the night is.
//!
//! Start at [`Blackout::begin`].

use screen::{Event, Light, Picture, Screen, ScreenError};

/// Luma and chroma of black in limited range.
const LUMA: u8 = 16;
const CHROMA: u8 = 128;
/// Flips after which the picture is black for certain: the first may be that of a picture that was under way.
const FLIPS: u32 = 2;

/// A display that shows black.
#[derive(Debug)]
pub(crate) struct Blackout {
    size: (u32, u32),
    luma: Vec<u8>,
    chroma: Vec<u8>,
    /// How many flips came since black was committed first.
    flips: u32,
}

impl Blackout {
    /// Makes `screen`, which takes pictures of `size`, black.
    /// Errors: [`ScreenError`] if such pictures do not fit it.
    pub(crate) fn begin(screen: &mut dyn Screen, size: (u32, u32)) -> Result<Self, ScreenError> {
        let pixels = (size.0 * size.1) as usize;
        let mut black = Self { size, luma: vec![LUMA; pixels], chroma: vec![CHROMA; pixels / 4], flips: 0 };
        // The backlight goes as far down as it can.
        screen.set_light(Light::On { thousandths: 0 });
        black.show(screen)?;
        Ok(black)
    }

    /// Handles an event of the screen.
    /// Errors: [`ScreenError`] if black does not fit what the screen has become.
    pub(crate) fn on(&mut self, screen: &mut dyn Screen, event: &Event) -> Result<(), ScreenError> {
        match event {
            Event::Flip { .. } => {
                self.flips += 1;
                if self.flips < FLIPS {
                    screen.commit();
                }
            }
            Event::Back | Event::Recovered { .. } => self.show(screen)?,
            Event::Lost { .. } => self.flips = FLIPS,
            Event::Vblank { .. } | Event::Asleep | Event::Changed | Event::Idle => {}
        }
        Ok(())
    }

    /// Whether all its flips have come.
    pub(crate) fn is_complete(&self, screen: &dyn Screen) -> bool {
        self.flips >= FLIPS || screen.info().is_none()
    }

    fn show(&mut self, screen: &mut dyn Screen) -> Result<(), ScreenError> {
        self.flips = 0;
        let (width, height) = self.size;
        let half = width as usize / 2;
        let planes: [&[u8]; 3] = [&self.luma, &self.chroma, &self.chroma];
        screen.stage(&Picture { width, height, planes, strides: [width as usize, half, half] })?;
        screen.commit();
        Ok(())
    }
}
