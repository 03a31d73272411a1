//! The fault card: what is lit when nothing of the flock can be.
//!
//! Owns its drawing: dim rings around the middle of a dark ground, calm enough to hang on a wall for a night.
//! Never has text: what went wrong stands on the status page and in the log.

use screen::Picture;

/// What the trace and the status page call it.
pub(crate) const FAULT_CARD: &str = "fault-card";

/// A drawn picture, 8-bit 4:2:0, BT.709 limited range.
#[derive(Debug)]
pub(crate) struct FaultCard {
    width: u32,
    height: u32,
    /// Y, U and V, without padding.
    planes: [Vec<u8>; 3],
}

impl FaultCard {
    /// The fault card in the flock's size, which is even.
    pub(crate) fn draw((width, height): (u32, u32)) -> Self {
        let luma = plane(width, height, |distance| {
            let ring = (distance * 24.0).sin().max(0.0).powi(8);
            let fade = (1.0 - distance).max(0.0);
            22.0 + 60.0 * ring * fade
        });
        let tint =
            |depth: f32| plane(width / 2, height / 2, move |distance| 128.0 + depth * (1.0 - distance).clamp(0.0, 1.0));
        Self { width, height, planes: [luma, tint(10.0), tint(-6.0)] }
    }

    /// A picture of 16x16 that is `luma` everywhere.
    #[cfg(test)]
    pub(crate) fn plain(luma: u8) -> Self {
        Self { width: 16, height: 16, planes: [vec![luma; 256], vec![128; 64], vec![128; 64]] }
    }

    /// The picture, as a screen takes it.
    pub(crate) fn picture(&self) -> Picture<'_> {
        let width = self.width as usize;
        let [y, u, v] = &self.planes;
        Picture { width: self.width, height: self.height, planes: [y, u, v], strides: [width, width / 2, width / 2] }
    }
}

/// A plane whose samples depend on the distance from the middle, where 1 is half the height.
fn plane(width: u32, height: u32, sample: impl Fn(f32) -> f32) -> Vec<u8> {
    let unit = height as f32 / 2.0;
    let at = |x: u32, y: u32| {
        let (dx, dy) = (x as f32 + 0.5 - width as f32 / 2.0, y as f32 + 0.5 - unit);
        sample(dx.hypot(dy) / unit) as u8
    };
    (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| at(x, y)).collect()
}

#[cfg(test)]
mod tests {
    use super::FaultCard;

    #[test]
    fn the_fault_card_is_dim_but_not_black() {
        let card = FaultCard::draw((640, 360));
        let picture = card.picture();
        let luma: Vec<u8> = picture.rows(0).flatten().copied().collect();
        assert_eq!(luma.len(), 640 * 360);
        assert_eq!(picture.rows(1).flatten().count(), 320 * 180);
        assert!(luma.iter().all(|y| (20..=90).contains(y)));
        assert!(luma.iter().filter(|y| **y > 40).count() > 5_000);
    }
}
