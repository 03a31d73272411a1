//! How the camera stands in space.
//!
//! Owns the attributes `cam_*` for reading and writing, and what programs mean where a genome does not say so: how far the
//! centre turns, and which side of the camera's plane is blurred. What they do to a point is in `render/projection.rs`.
//!
//! Start at [`Pose`].

use std::f64::consts::TAU;

use super::attributes::NEW_BLUR;
use super::{Camera, Element, Genome, Program};

/// How the camera stands in space: by default straight in front of the plane z = 0, where it changes nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pose {
    /// `cam_pitch`: how far the flame is tilted, in radians.
    pub pitch: f64,
    /// `cam_yaw`: how far it is turned about its own axis before, in radians.
    pub yaw: f64,
    /// `cam_yaw_turns`: how often the yaw goes round in a loop. No other program has it.
    pub yaw_turns: i32,
    /// `cam_roll`: how far it is then turned about the axis that goes up, in radians.
    pub roll: f64,
    /// `cam_persp`, Apophysis' `cam_perspective`: how much larger near things are; 0 is a parallel projection.
    pub perspective: f64,
    /// `cam_dof`: how much things blur by their distance from the plane of the camera.
    pub depth_blur: f64,
    /// `dof_one_sided`: how much less is blurred what stands above that plane; 0 in Apophysis, 1, so not at all, in
    /// JWildfire.
    pub one_sided: f64,
    /// `cam_zpos`: the height about which everything is turned.
    pub height: f64,
    /// `cam_pos_x`, `cam_pos_y` and `cam_pos_z`: by how much points are moved after the turns; the last one moves them away.
    pub shift: [f64; 3],
}

impl Pose {
    /// Whether it changes nothing, at any moment of a loop.
    pub fn is_straight(&self) -> bool {
        *self == Pose::default()
    }

    /// By how much the yaw differs `part` of a loop after its start, in radians.
    pub(crate) fn turned(&self, part: f64) -> f64 {
        TAU * f64::from(self.yaw_turns) * part
    }

    /// The number that the attribute `name` says, if it is one of the pose.
    pub(super) fn number(&mut self, name: &str) -> Option<&mut f64> {
        Some(match name {
            "cam_pitch" => &mut self.pitch,
            "cam_yaw" => &mut self.yaw,
            "cam_roll" => &mut self.roll,
            "cam_persp" | "cam_perspective" => &mut self.perspective,
            "cam_dof" => &mut self.depth_blur,
            "cam_zpos" => &mut self.height,
            "cam_pos_x" => &mut self.shift[0],
            "cam_pos_y" => &mut self.shift[1],
            "cam_pos_z" => &mut self.shift[2],
            _ => return None,
        })
    }

    /// Adds the attributes that read back as this pose.
    pub(super) fn write(&self, element: &mut Element) {
        let [x, y, z] = self.shift;
        for (name, value) in [
            ("cam_pitch", self.pitch),
            ("cam_yaw", self.yaw),
            ("cam_yaw_turns", f64::from(self.yaw_turns)),
            ("cam_roll", self.roll),
            ("cam_persp", self.perspective),
            ("cam_dof", self.depth_blur),
            ("cam_zpos", self.height),
            ("cam_pos_x", x),
            ("cam_pos_y", y),
            ("cam_pos_z", z),
        ] {
            element.set_unless_0(name, value);
        }
    }
}

impl Genome {
    /// How far the centre of the picture turns with it, where the genome does not say so.
    pub(super) fn usual_center_turns(&self) -> f64 {
        let is_of_space = self.program() == Some(Program::JWildfire) && !self.camera.pose.is_straight();
        if is_of_space { 0.0 } else { 1.0 }
    }

    /// How much less is blurred above the plane of the camera, where the genome does not say so.
    pub(super) fn usual_one_sided(&self) -> f64 {
        let is_blurred = self.program() == Some(Program::JWildfire) && self.camera.pose.depth_blur != 0.0;
        let is_new = self.extra.iter().any(|(name, value)| name == NEW_BLUR && value.trim() != "0");
        if is_blurred && !is_new { 1.0 } else { 0.0 }
    }

    /// Writes what programs do in their own ways and the genome does not as its program does.
    pub(super) fn write_unusual_camera(&self, root: &mut Element) {
        let Camera { center_turns, pose, .. } = &self.camera;
        for (name, value, usual) in [
            ("center_turns", *center_turns, self.usual_center_turns()),
            ("dof_one_sided", pose.one_sided, self.usual_one_sided()),
        ] {
            if value != usual {
                root.set(name, value);
            }
        }
    }
}
