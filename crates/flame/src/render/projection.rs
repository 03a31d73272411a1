//! From a point in space to a point in the picture's plane.
//!
//! Owns the camera's turns, its perspective and the blur by depth. Where cells are is for `view.rs`.
//!
//! Start at [`Projection::new`].
//!
//! # Source
//! The camera of Apophysis 7X: turned by -yaw and then by the pitch, divided by 1 - perspective * z. JWildfire's has a roll
//! about the y axis between them and a shift after them, which adds its third number to what it divides by: three small discs in
//! 20 poses are within 0.008 of where JWildfire 9.00 draws them.

use std::f64::consts::TAU;

use crate::genome::Pose;
use variations::number::{Number, Random};

/// What `cam_dof` is multiplied by.
const BLUR: f64 = 0.1;

/// A camera ready to project points.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Projection {
    /// What is taken from z first.
    height: f64,
    /// What is added to a point in front of the camera.
    shift: [f64; 3],
    /// What the coordinates are multiplied by: a row for each of those in front of the camera.
    rows: [[f64; 3]; 3],
    perspective: f64,
    blur: f64,
    /// The same for points above the plane of the camera.
    blur_above: f64,
}

impl Projection {
    /// That of a camera in this pose; `None` if it changes nothing.
    pub(crate) fn new(pose: &Pose) -> Option<Projection> {
        if pose.is_straight() {
            return None;
        }
        let (yaw_sin, yaw_cos) = libm::sincos(-pose.yaw);
        let (roll_sin, roll_cos) = libm::sincos(pose.roll);
        let (pitch_sin, pitch_cos) = libm::sincos(pose.pitch);
        let across = [yaw_cos * roll_cos, -yaw_sin * roll_cos, roll_sin];
        let upright = [yaw_sin, yaw_cos, 0.0];
        let rolled = [-yaw_cos * roll_sin, yaw_sin * roll_sin, roll_cos];
        let tilted = |first: f64, second: f64| std::array::from_fn(|i| first * upright[i] + second * rolled[i]);
        let rows = [across, tilted(pitch_cos, -pitch_sin), tilted(pitch_sin, pitch_cos)];
        let Pose { height, shift, perspective, .. } = *pose;
        let blur = BLUR * pose.depth_blur;
        Some(Projection { height, shift, rows, perspective, blur, blur_above: blur * (1.0 - pose.one_sided) })
    }

    /// Where a point is seen.
    #[inline(always)]
    pub(crate) fn apply<N: Number, R: Random<N>>(&self, [x, y, z]: [N; 3], random: &mut R) -> (N, N) {
        let z = z - self.height;
        let [mut across, mut up, depth] = self.rows.map(|[a, b, c]| x * a + y * b + z * c);
        if self.blur != 0.0 {
            let (sin, cos) = (random.unit() * TAU).sin_cos();
            let is_above = depth.like(0.0).less(depth);
            let blur = N::select(is_above, depth.like(self.blur_above), depth.like(self.blur));
            let radius = random.unit() * depth * blur;
            (across, up) = (across + radius * cos, up + radius * sin);
        }
        let [right, above, away] = self.shift;
        let (across, up) = (across + right, up + above);
        if self.perspective == 0.0 && away == 0.0 {
            return (across, up);
        }
        let nearness = depth.like(1.0 + away) - (depth + away) * self.perspective;
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
        assert!(near(seen(Pose { roll: quarter, ..Pose::default() }, [1.0, 2.0, 5.0]), (5.0, 2.0)));
        assert!(near(seen(Pose { roll: quarter, pitch: quarter, ..Pose::default() }, [1.0, 2.0, 5.0]), (5.0, 1.0)));
        assert!(near(seen(Pose { perspective: 0.5, ..Pose::default() }, [1.0, 2.0, 1.0]), (2.0, 4.0)));
        let all = Pose { yaw: 0.5, roll: 0.3, pitch: 0.4, perspective: 0.3, ..Pose::default() };
        let (x, y) = seen(all, [1.0, 0.4, 0.8]);
        assert!(
            libm::hypot(x - 1.407, y + 0.323) < 0.01,
            "JWildfire 9.00 draws it at (1.407, -0.323), not at ({x}, {y})"
        );
        let (height, shift) = (1.0, [0.3, 0.2, 0.2]);
        assert!(near(seen(Pose { height, pitch: quarter, ..Pose::default() }, [1.0, 3.0, 9.0]), (1.0, -8.0)));
        assert!(near(seen(Pose { shift, ..Pose::default() }, [0.9, 1.0, 5.0]), (1.0, 1.0)));
        assert!(near(
            seen(Pose { shift, perspective: 0.5, ..Pose::default() }, [0.9, 1.0, 0.8]),
            (12.0 / 7.0, 12.0 / 7.0)
        ));
        let blurred = seen(Pose { depth_blur: 1.0, ..Pose::default() }, [0.0, 0.0, 2.0]);
        assert!(libm::hypot(blurred.0, blurred.1) < 0.2 && blurred != (0.0, 0.0));
        let one_sided = |one_sided: f64, z: f64| {
            let (x, y) = seen(Pose { depth_blur: 1.0, one_sided, ..Pose::default() }, [0.0, 0.0, z]);
            libm::hypot(x, y)
        };
        assert_eq!([one_sided(1.0, 2.0), one_sided(0.0, 2.0)], [0.0, libm::hypot(blurred.0, blurred.1)]);
        assert_eq!(one_sided(1.0, -2.0), one_sided(0.0, -2.0));
        assert!(one_sided(1.0, -2.0) > 0.0 && (one_sided(0.5, 2.0) / one_sided(0.0, 2.0) - 0.5).abs() < 1e-12);
    }
}
