//! How bright a pixel looks.
//!
//! Owns the weights of red, green and blue, and the mean and the contrast of many values. Never looks at a whole picture.
//!
//! Start at [`luma`].

/// The luma of displayable light, `0.0..=1.0`: BT.709.
pub(crate) fn luma([red, green, blue]: &[f32; 3]) -> f64 {
    0.2126 * f64::from(*red) + 0.7152 * f64::from(*green) + 0.0722 * f64::from(*blue)
}

/// The mean and the standard deviation of values; zeros if there are none.
pub(crate) fn spread(values: impl ExactSizeIterator<Item = f64> + Clone) -> [f64; 2] {
    let count = values.len().max(1) as f64;
    let mean = values.clone().sum::<f64>() / count;
    let squares: f64 = values.map(|value| (value - mean) * (value - mean)).sum();
    [mean, (squares / count).sqrt()]
}
