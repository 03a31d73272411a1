//! From a point in space to a point in the picture's plane.
//!
//! Owns the camera's turns, its perspective and the blur by depth. Where cells are is for `view.rs`.
//!
//! Start at [`Projection::new`].
//!
//! # Source
//! The camera of Apophysis 7X and JWildfire: turned by -yaw and then by the pitch, divided by 1 - perspective * z. The roll
//! turns the picture.

use std::f64::consts::TAU;

use crate::genome::Pose;
use variations::number::{Number, Random};

/// What `cam_dof` is multiplied by.
const BLUR: f64 = 0.1;

/// A camera ready to project points.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Projection {
    /// What is taken from a point first.
    position: [f64; 3],
    /// What the coordinates are multiplied by: a row for each of those in front of the camera.
    rows: [[f64; 3]; 3],
    perspective: f64,
    blur: f64,
}

impl Projection {
    /// That of a camera in this pose; `None` if it changes nothing.
    pub(crate) fn new(pose: &Pose) -> Option<Projection> {
        if pose.is_straight() {
            return None;
        }
        let (yaw_sin, yaw_cos) = libm::sincos(-pose.yaw);
        let (pitch_sin, pitch_cos) = libm::sincos(pose.pitch);
        let across = [yaw_cos, -yaw_sin, 0.0];
        let up = [yaw_sin * pitch_cos, yaw_cos * pitch_cos, -pitch_sin];
        let depth = [yaw_sin * pitch_sin, yaw_cos * pitch_sin, pitch_cos];
        let (roll_sin, roll_cos) = libm::sincos(pose.roll);
        let turned = |first: f64, second: f64| std::array::from_fn(|i| first * across[i] + second * up[i]);
        let rows = [turned(roll_cos, -roll_sin), turned(roll_sin, roll_cos), depth];
        Some(Projection { position: pose.position, rows, perspective: pose.perspective, blur: BLUR * pose.depth_blur })
    }

    /// Where a point is seen.
    #[inline(always)]
    pub(crate) fn apply<N: Number, R: Random<N>>(&self, [x, y, z]: [N; 3], random: &mut R) -> (N, N) {
        let [left, below, behind] = self.position;
        let (x, y, z) = (x - left, y - below, z - behind);
        let [across, up, depth] = self.rows.map(|[a, b, c]| x * a + y * b + z * c);
        let (mut across, mut up) = (across, up);
        if self.blur != 0.0 {
            let (sin, cos) = (random.unit() * TAU).sin_cos();
            let radius = random.unit() * depth * self.blur;
            (across, up) = (across + radius * cos, up + radius * sin);
        }
        if self.perspective == 0.0 {
            return (across, up);
        }
        let nearness = depth.like(1.0) - depth * self.perspective;
        (across / nearness, up / nearness)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use species::Rng;

    fn seen(pose: Pose, point: [f64; 3]) -> (f64, f64) {
        Projection::new(&pose).unwrap().apply(point, &mut Rng::stream(1, 0))
    }

    #[test]
    fn a_straight_camera_projects_nothing() {
        assert!(Projection::new(&Pose::default()).is_none());
    }

    #[test]
    fn points_are_turned_tilted_and_brought_nearer() {
        let near =
            |(x, y): (f64, f64), (other_x, other_y): (f64, f64)| (x - other_x).abs() + (y - other_y).abs() < 1e-12;
        let quarter = TAU / 4.0;
        assert!(near(seen(Pose { yaw: quarter, ..Pose::default() }, [1.0, 0.0, 5.0]), (0.0, -1.0)));
        assert!(near(seen(Pose { pitch: quarter, ..Pose::default() }, [1.0, 2.0, 5.0]), (1.0, -5.0)));
        assert!(near(seen(Pose { roll: quarter, ..Pose::default() }, [1.0, 0.0, 5.0]), (0.0, 1.0)));
        assert!(near(seen(Pose { perspective: 0.5, ..Pose::default() }, [1.0, 2.0, 1.0]), (2.0, 4.0)));
        assert!(near(seen(Pose { position: [1.0, 1.0, 1.0], ..Pose::default() }, [1.0, 3.0, 9.0]), (0.0, 2.0)));
        let blurred = seen(Pose { depth_blur: 1.0, ..Pose::default() }, [0.0, 0.0, 2.0]);
        assert!(libm::hypot(blurred.0, blurred.1) < 0.2 && blurred != (0.0, 0.0));
    }
}
