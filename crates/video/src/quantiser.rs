//! How coarsely a picture is encoded, from what ffmpeg's decoder exports.
//!
//! Owns the reading of `AVVideoEncParams`, which is not in the bindings: a head, and an entry for every macroblock. Never
//! trusts its offsets.

/// Bytes of `size_t`.
const WORD: usize = size_of::<usize>();
/// Offset of a block's own part of the quantiser, after its place and its size.
const DELTA: usize = 16;

/// The mean quantiser of all blocks; `None` without `params`.
pub(crate) fn mean(params: &[u8]) -> Option<f32> {
    let number = |at: usize| Some(i32::from_ne_bytes(*params.get(at..)?.first_chunk()?));
    let word = |at: usize| Some(usize::from_ne_bytes(*params.get(at..)?.first_chunk()?));
    let (count, offset, size) = (usize::try_from(number(0)?).ok()?, word(WORD)?, word(2 * WORD)?);
    let of_all = number(3 * WORD + 4)?;
    let delta = |block: usize| number(block.checked_mul(size)?.checked_add(offset)?.checked_add(DELTA)?);
    let sum = (0..count).map(delta).sum::<Option<i32>>()?;
    Some(of_all as f32 + sum as f32 / count.max(1) as f32)
}

#[cfg(test)]
mod tests {
    use super::{WORD, mean};

    #[test]
    fn a_quantiser_is_the_mean_of_the_blocks_and_what_is_cut_has_none() {
        let mut params = vec![0; 3 * WORD + 8];
        params[0] = 2;
        params[WORD] = 3 * WORD as u8 + 8;
        params[2 * WORD] = 20;
        params[3 * WORD + 4] = 26;
        for delta in [-3i32, 8] {
            params.extend([0; 16]);
            params.extend(delta.to_ne_bytes());
        }
        assert_eq!(mean(&params), Some(28.5));
        assert!((0..params.len()).all(|length| mean(&params[..length]).is_none()));
        params[2 * WORD..3 * WORD].fill(255);
        assert_eq!(mean(&params), None);
    }
}
