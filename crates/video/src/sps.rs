//! Sequence parameter sets.
//!
//! Owns their parser, so that a clip is checked by the values that its decoder uses, not by those of its container.
//!
//! Start at [`Sps::parse`].
//!
//! The crate `h264-reader` (0.9) does not replace it: it refuses a set whose picture is larger than its level allows, or whose
//! limits contradict each other, although ffmpeg plays such clips. It adds eight crates to a unit, and has no walk over units
//! with lengths, which is in `nal.rs`.
//!
//! # Source
//! ITU-T H.264 (08/2021), 7.3.2.1.1 (syntax) and E.1.1 (video usability information).

/// The fields of a sequence parameter set that the flock's form fixes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Sps {
    /// `profile_idc`: 66 Baseline, 77 Main, 100 High.
    pub(crate) profile: u32,
    /// `constraint_set1_flag`: with profile 66, a Main decoder plays it too.
    pub(crate) within_main: bool,
    /// `chroma_format_idc`: 1 is 4:2:0.
    pub(crate) chroma: u32,
    /// Bits of a luma and of a chroma sample.
    pub(crate) depth: (u32, u32),
    /// Visible width and height.
    pub(crate) size: (u32, u32),
    /// Whether every picture is a whole frame.
    pub(crate) progressive: bool,
    /// Width and height of a pixel; `None` if not stated.
    pub(crate) pixel: Option<(u32, u32)>,
    /// Whether samples use all 256 values.
    pub(crate) full_range: bool,
    /// Primaries, transfer and matrix by their code points: 1 is BT.709, 2 is untold.
    pub(crate) colour: [u32; 3],
    /// How many pictures the decoder must hold back to put them in order; `None` if not stated.
    pub(crate) reorder: Option<u32>,
}

impl Sps {
    /// Reads a unit of kind SPS, header byte first; `None` if it ends early or is invalid.
    pub(crate) fn parse(unit: &[u8]) -> Option<Self> {
        let mut bits = Bits::new(unit.get(1..)?);
        let (profile, constraints, _level) = (bits.u(8)?, bits.u(8)?, bits.u(8)?);
        bits.ue()?;
        let (chroma, depth) = if HIGH_PROFILES.contains(&profile) { chroma_format(&mut bits)? } else { (1, (8, 8)) };
        bits.ue()?;
        picture_order(&mut bits)?;
        bits.ue()?;
        bits.u(1)?;
        let (mbs_wide, map_units) = (bits.ue()?.checked_add(1)?, bits.ue()?.checked_add(1)?);
        let progressive = bits.flag()?;
        if !progressive {
            bits.u(1)?;
        }
        bits.u(1)?;
        let crop = if bits.flag()? { [bits.ue()?, bits.ue()?, bits.ue()?, bits.ue()?] } else { [0; 4] };
        let fields = if progressive { 1 } else { 2 };
        let (step_x, step_y) = match chroma {
            1 => (2, 2 * fields),
            2 => (2, fields),
            _ => (1, fields),
        };
        let cut = |whole: u32, a: u32, b: u32, step| whole.checked_sub(a.checked_add(b)?.checked_mul(step)?);
        let size = (
            cut(mbs_wide.checked_mul(16)?, crop[0], crop[1], step_x)?,
            cut(map_units.checked_mul(16 * fields)?, crop[2], crop[3], step_y)?,
        );
        let within_main = constraints & 0x40 != 0;
        let (pixel, full_range, colour, reorder) = (None, false, [2; 3], None);
        let mut sps =
            Self { profile, within_main, chroma, depth, size, progressive, pixel, full_range, colour, reorder };
        if bits.flag()? {
            sps.usability(&mut bits)?;
        }
        Some(sps)
    }

    fn usability(&mut self, bits: &mut Bits<'_>) -> Option<()> {
        if bits.flag()? {
            self.pixel = match bits.u(8)? {
                255 => Some((bits.u(16)?, bits.u(16)?)),
                1 => Some((1, 1)),
                0 => None,
                // Every other code point of table E-1 is a pixel that is not square.
                code => Some((code, 0)),
            };
        }
        if bits.flag()? {
            bits.u(1)?;
        }
        if bits.flag()? {
            bits.u(3)?;
            self.full_range = bits.flag()?;
            if bits.flag()? {
                self.colour = [bits.u(8)?, bits.u(8)?, bits.u(8)?];
            }
        }
        if bits.flag()? {
            bits.pass_ue(2)?;
        }
        if bits.flag()? {
            bits.u(32)?;
            bits.u(32)?;
            bits.u(1)?;
        }
        let (nal, vcl) = (reference_decoder(bits)?, reference_decoder(bits)?);
        bits.u(u32::from(nal || vcl))?;
        bits.u(1)?;
        if bits.flag()? {
            bits.u(1)?;
            bits.pass_ue(4)?;
            self.reorder = Some(bits.ue()?);
        }
        Some(())
    }
}

/// Profiles whose parameter sets carry chroma format, depths and scaling matrices.
const HIGH_PROFILES: [u32; 13] = [100, 110, 122, 244, 44, 83, 86, 118, 128, 138, 139, 134, 135];

/// Reads chroma format and depths, and passes over the scaling matrices.
fn chroma_format(bits: &mut Bits<'_>) -> Option<(u32, (u32, u32))> {
    let chroma = bits.ue()?;
    if chroma == 3 {
        bits.u(1)?;
    }
    let depth = (bits.ue()?.checked_add(8)?, bits.ue()?.checked_add(8)?);
    bits.u(1)?;
    if bits.flag()? {
        for list in 0..if chroma == 3 { 12 } else { 8 } {
            if bits.flag()? {
                scaling_list(bits, if list < 6 { 16 } else { 64 })?;
            }
        }
    }
    Some((chroma, depth))
}

fn scaling_list(bits: &mut Bits<'_>, entries: u32) -> Option<()> {
    let (mut last, mut next) = (8i64, 8i64);
    for _ in 0..entries {
        if next != 0 {
            next = (last + bits.se()?).rem_euclid(256);
        }
        last = if next == 0 { last } else { next };
    }
    Some(())
}

fn picture_order(bits: &mut Bits<'_>) -> Option<()> {
    match bits.ue()? {
        0 => {
            bits.ue()?;
        }
        1 => {
            bits.u(1)?;
            bits.pass_ue(2)?;
            let cycle = bits.ue()?.min(255);
            bits.pass_ue(cycle)?;
        }
        _ => (),
    }
    Some(())
}

/// Passes over the parameters of a hypothetical reference decoder; whether there were any.
fn reference_decoder(bits: &mut Bits<'_>) -> Option<bool> {
    let told = bits.flag()?;
    if told {
        let buffers = bits.ue()?.min(31);
        bits.u(8)?;
        for _ in 0..=buffers {
            bits.pass_ue(2)?;
            bits.u(1)?;
        }
        bits.u(20)?;
    }
    Some(told)
}

/// The bits of a unit, most significant first, without its emulation prevention bytes.
struct Bits<'a> {
    bytes: &'a [u8],
    /// Bits of `bytes[0]` that are already read.
    used: u32,
    /// How many zero bytes went before `bytes[0]`.
    zeros: u32,
}

impl<'a> Bits<'a> {
    fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, used: 0, zeros: 0 }
    }

    fn bit(&mut self) -> Option<u32> {
        if self.used == 0 && self.zeros >= 2 && *self.bytes.first()? == 3 {
            (self.bytes, self.zeros) = (&self.bytes[1..], 0);
        }
        let byte = *self.bytes.first()?;
        let bit = byte >> (7 - self.used) & 1;
        self.used = (self.used + 1) % 8;
        if self.used == 0 {
            self.zeros = if byte == 0 { self.zeros + 1 } else { 0 };
            self.bytes = &self.bytes[1..];
        }
        Some(bit.into())
    }

    /// `count` bits as a number, 32 at most.
    fn u(&mut self, count: u32) -> Option<u32> {
        (0..count).try_fold(0, |sum: u32, _| Some(sum << 1 | self.bit()?))
    }

    fn flag(&mut self) -> Option<bool> {
        Some(self.bit()? == 1)
    }

    /// An Exp-Golomb number, below 2^32 - 1.
    fn ue(&mut self) -> Option<u32> {
        let mut zeros = 0;
        while !self.flag()? {
            zeros += 1;
            if zeros > 31 {
                return None;
            }
        }
        Some((1 << zeros) - 1 + self.u(zeros)?)
    }

    /// Passes over Exp-Golomb numbers, signed or not.
    fn pass_ue(&mut self, count: u32) -> Option<()> {
        (0..count).try_for_each(|_| self.ue().map(drop))
    }

    /// A signed Exp-Golomb number.
    fn se(&mut self) -> Option<i64> {
        let code = i64::from(self.ue()?);
        Some(if code % 2 == 0 { -(code / 2) } else { code / 2 + 1 })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_varying_length_are_read() {
        // 1 | 010 | 011 | 00100 | 0001000
        let mut bits = Bits::new(&[0b1010_0110, 0b0100_0001, 0b0000_0000]);
        assert_eq!([bits.ue(), bits.ue(), bits.ue(), bits.ue(), bits.ue()], [0, 1, 2, 3, 7].map(Some));
        let mut bits = Bits::new(&[0b1010_0110, 0b0100_0010, 0b1000_0000]);
        assert_eq!([bits.se(), bits.se(), bits.se(), bits.se(), bits.se()], [0, 1, -1, 2, -2].map(Some));
    }

    #[test]
    fn emulation_prevention_bytes_are_passed_over() {
        let mut bits = Bits::new(&[0, 0, 3, 1, 0, 0, 3, 3]);
        assert_eq!([bits.u(24), bits.u(24), bits.u(1)], [Some(1), Some(3), None]);
    }

    #[test]
    fn a_set_that_ends_early_or_never_ends_is_refused() {
        assert_eq!(Sps::parse(&[]), None);
        assert_eq!(Sps::parse(&[0x67, 100, 0, 31]), None);
        for byte in 0..=255 {
            Sps::parse(&[byte; 64]);
        }
    }
}
