//! Transitions from one sheep's loop to another's, continuous in value and velocity at both ends.
//!
//! Owns the easing and the interpolation of everything but affine parts and palettes. Never renders. The waves of both
//! loops go on through the transition, those of the one fading out and those of the other fading in.
//!
//! Start at [`Transition::new`]. Everything but the turning is eased by 3b² - 2b³, so its speed is 0 at both ends, as
//! it is in loops; the turning starts and ends at the loops' own speeds.

use std::f64::consts::TAU;

use super::affine::{AffinePath, Polar};
use super::align::{Padding, align};
use super::pairing::Pairing;
use super::palette::PaletteWay;
use super::waves::{added_to_affines, waved};
use super::{Loop, Motion};
use crate::genome::{Camera, Genome, Pose, Sampling, Space, Tilt, Tone, Xform};

/// The way from one loop to another.
///
/// Frame 0 is frame 0 of the loop it leaves, frame `frames` is frame 0 of the loop it leads to; so the clip
/// plays frames `0..frames` after the last frame of the one and before the first of the other.
#[derive(Clone, Debug)]
pub struct Transition {
    from: Genome,
    to: Genome,
    /// For each transform: the interpolation of its affine part.
    ways: Vec<AffinePath>,
    /// For each transform, final ones last: the interpolation of its post part.
    posts: Vec<AffinePath>,
    /// For each final transform: the interpolation of its affine part.
    final_ways: Vec<AffinePath>,
    /// The way of the colours.
    palettes: Option<PaletteWay>,
    /// In which order the transforms are drawn near either end.
    pairing: Pairing,
    frames: f64,
    /// Both loops.
    loops: [Loop; 2],
}

/// A moment of a transition.
#[derive(Clone, Copy, Debug)]
pub(super) struct Moment {
    /// Frames from the start.
    pub(super) frame: f64,
    /// How far everything that is eased has come, `0.0..=1.0`.
    pub(super) eased: f64,
}

impl Transition {
    /// The way from `from` to `to` in `frames` frames (> 0).
    ///
    /// Each transform becomes the one that it is most like; the shorter genome is padded with transforms of weight 0.
    /// The turning takes as many whole turns as bring its mean speed nearest to the mean of the loops'.
    pub fn new(from: &Loop, to: &Loop, frames: f64) -> Transition {
        let (pair, pairing) = Pairing::new([from, to].map(|end| end.genome().with_symmetry()));
        let space = match (pair[0].space, pair[1].space) {
            (Space::Log, Space::Log) => Space::Log,
            (Space::Old | Space::Older, _) | (_, Space::Old | Space::Older) => Space::Old,
            (Space::Linear, _) | (_, Space::Linear) => Space::Linear,
        };
        let polar = space == Space::Log;
        let [a, b] = align(pair, space, Padding::AsPartner);
        let way = |ends, speeds| {
            if polar {
                AffinePath::Polar(Polar::new(ends, speeds, frames))
            } else {
                AffinePath::Straight { ends, speeds, frames }
            }
        };
        let still = |a: &Xform, b: &Xform, part: fn(&Xform) -> crate::genome::Affine| way([part(a), part(b)], [0.0; 2]);
        let ways = a.xforms.iter().zip(&b.xforms).map(|(a, b)| way([a.affine, b.affine], [from.speed(a), to.speed(b)]));
        let finals = a.finals.iter().zip(&b.finals);
        let posts = a.xforms.iter().zip(&b.xforms).chain(finals.clone()).map(|(a, b)| still(a, b, |x| x.post));
        let palettes = a.palette.as_ref().zip(b.palette.as_ref());
        Transition {
            palettes: palettes.map(|(start, end)| PaletteWay::new(start, end, a.hue_path)),
            pairing,
            ways: ways.collect(),
            posts: posts.collect(),
            final_ways: finals.map(|(a, b)| still(a, b, |x| x.affine)).collect(),
            from: a,
            to: b,
            frames,
            loops: [from.clone(), to.clone()],
        }
    }

    /// How far each of the loops has come at `frame`, as if the one went on and the other began before its start.
    fn parts(&self, frame: f64) -> [f64; 2] {
        [self.loops[0].part(frame), self.loops[1].part(frame - self.frames)]
    }

    /// The camera at `moment`. One that goes round in its loop goes on, or has gone before the start.
    fn camera(&self, moment: Moment) -> Camera {
        let mut ends = [self.from.camera, self.to.camera];
        let parts = self.parts(moment.frame);
        for (camera, part) in ends.iter_mut().zip(parts) {
            camera.pose.yaw += camera.pose.turned(part);
        }
        // The shorter way between them.
        let apart = ends[1].pose.yaw - ends[0].pose.yaw;
        let at_start = self.to.camera.pose.yaw - self.from.camera.pose.yaw;
        ends[1].pose.yaw = ends[0].pose.yaw + apart - TAU * (at_start / TAU).round();
        camera(&ends[0], &ends[1], moment.eased)
    }

    /// A transform at `moment`: `a` and `b` at the ends, between which `way` and `post` lead its affine parts.
    /// `turns` is false for a final transform.
    fn xform(&self, [a, b]: [&Xform; 2], [way, post]: [&AffinePath; 2], moment: Moment, turns: bool) -> Xform {
        let parts = self.parts(moment.frame);
        let mut xform = mixed(&waved(a, parts[0]), &waved(b, parts[1]), moment.eased);
        (xform.affine, xform.post) = (way.at(moment), post.at(moment));
        let shares = [1.0 - moment.eased, moment.eased];
        for (end, frame) in [moment.frame, moment.frame - self.frames].into_iter().enumerate() {
            let of = [a, b][end];
            let [affine, post] = added_to_affines(of, parts[end]);
            let turn = if turns { self.loops[end].speed(of) * frame } else { 0.0 };
            xform.affine = xform.affine.plus(&affine.turned(turn), shares[end]);
            xform.post = xform.post.plus(&post, shares[end]);
        }
        xform
    }
}

impl Motion for Transition {
    fn at(&self, frame: f64) -> Genome {
        if frame <= 0.0 {
            return self.loops[0].at(frame);
        }
        if frame >= self.frames {
            return self.loops[1].at(frame - self.frames);
        }
        let b = frame / self.frames;
        let moment = Moment { frame, eased: b * b * (3.0 - 2.0 * b) };
        let part = moment.eased;
        let (from, to) = (&self.from, &self.to);
        let mut xforms = Vec::with_capacity(from.xforms.len());
        for (i, (a, b)) in from.xforms.iter().zip(&to.xforms).enumerate() {
            xforms.push(self.xform([a, b], [&self.ways[i], &self.posts[i]], moment, true));
        }
        let ways = self.final_ways.iter().zip(&self.posts[xforms.len()..]);
        let finals = from.finals.iter().zip(&to.finals).zip(ways);
        let finals = finals.map(|((a, b), (way, post))| self.xform([a, b], [way, post], moment, false)).collect();
        // A new order is another choice of points, so the noise is another one: half way between two frames, in the middle,
        // where most moves. At the ends it is that of the loops.
        let is_late = frame >= (self.frames / 2.0).floor() + 0.5;
        Genome {
            palette: self.palettes.as_ref().map(|way| way.at(part, mix(from.hue_path_rgb, to.hue_path_rgb, part))),
            xforms: self.pairing.ordered(xforms, is_late),
            finals,
            camera: self.camera(moment),
            ..between(from, to, part)
        }
    }
}

/// Everything of a genome but its transforms and its colours.
pub(super) fn between(from: &Genome, to: &Genome, part: f64) -> Genome {
    let nearer = if part < 0.5 { from } else { to };
    Genome {
        name: nearer.name.clone(),
        time: mix(from.time, to.time, part),
        camera: camera(&from.camera, &to.camera, part),
        sampling: sampling(&from.sampling, &to.sampling, part),
        tone: tone(&from.tone, &to.tone, part),
        finish: from.finish.mixed(&to.finish, part),
        palette_mode: nearer.palette_mode,
        hue_path: nearer.hue_path,
        hue_path_rgb: mix(from.hue_path_rgb, to.hue_path_rgb, part),
        interpolation: nearer.interpolation,
        space: nearer.space,
        // As in `mixed`.
        extra: of_both(&from.extra, &to.extra),
        children: from.children.iter().chain(&to.children).cloned().collect(),
        ..Genome::default()
    }
}

/// Linear interpolation from `a` to `b` by `part`.
pub(super) fn mix(a: f64, b: f64, part: f64) -> f64 {
    a + (b - a) * part
}

/// Everything of a transform but its affine parts.
pub(super) fn mixed(a: &Xform, b: &Xform, part: f64) -> Xform {
    let variations = a.variations.iter().zip(&b.variations).map(|(a, b)| {
        let mut variation = *a;
        variation.weight = mix(a.weight, b.weight, part);
        variation.presence = mix(a.presence, b.presence, part);
        variation.carry = mix(a.carry, b.carry, part);
        for (slot, (a, b)) in variation.params.iter_mut().zip(a.params.iter().zip(b.params)) {
            *slot = mix(*a, b, part);
        }
        variation
    });
    let nearer = if part < 0.5 { a } else { b };
    Xform {
        weight: mix(a.weight, b.weight, part),
        color: mix(a.color, b.color, part),
        color2: nearer.color2,
        color_speed: mix(a.color_speed, b.color_speed, part),
        animate: mix(a.animate, b.animate, part),
        opacity: mix(a.opacity, b.opacity, part),
        chaos: a.chaos.iter().zip(&b.chaos).map(|(a, b)| mix(*a, *b, part)).collect(),
        tilt: Tilt::between(&a.tilt, &b.tilt, part),
        post_tilt: Tilt::between(&a.post_tilt, &b.post_tilt, part),
        variations: variations.collect(),
        // What cannot be rendered at an end cannot be rendered in between.
        extra: of_both(&a.extra, &b.extra),
        children: a.children.iter().chain(&b.children).cloned().collect(),
        ..Xform::default()
    }
}

/// The attributes of both ends, each name once: an element has none twice.
fn of_both(a: &[(String, String)], b: &[(String, String)]) -> Vec<(String, String)> {
    let is_new = |(name, _): &&(String, String)| a.iter().all(|(known, _)| known != name);
    a.iter().chain(b.iter().filter(is_new)).cloned().collect()
}

fn camera(a: &Camera, b: &Camera, part: f64) -> Camera {
    Camera {
        size: if part < 0.5 { a.size } else { b.size },
        center: std::array::from_fn(|axis| mix(a.center[axis], b.center[axis], part)),
        scale: mix(a.scale, b.scale, part),
        zoom: mix(a.zoom, b.zoom, part),
        rotate: mix(a.rotate, b.rotate, part),
        center_turns: mix(a.center_turns, b.center_turns, part),
        pose: pose(&a.pose, &b.pose, part),
    }
}

fn pose(a: &Pose, b: &Pose, part: f64) -> Pose {
    Pose {
        pitch: mix(a.pitch, b.pitch, part),
        yaw: mix(a.yaw, b.yaw, part),
        yaw_turns: if part < 0.5 { a.yaw_turns } else { b.yaw_turns },
        roll: mix(a.roll, b.roll, part),
        perspective: mix(a.perspective, b.perspective, part),
        depth_blur: mix(a.depth_blur, b.depth_blur, part),
        one_sided: mix(a.one_sided, b.one_sided, part),
        height: mix(a.height, b.height, part),
        shift: std::array::from_fn(|axis| mix(a.shift[axis], b.shift[axis], part)),
    }
}

fn sampling(a: &Sampling, b: &Sampling, part: f64) -> Sampling {
    let nearer = if part < 0.5 { a } else { b };
    Sampling {
        quality: mix(a.quality, b.quality, part),
        filter_radius: mix(a.filter_radius, b.filter_radius, part),
        temporal_width: mix(a.temporal_width, b.temporal_width, part),
        temporal_exponent: mix(a.temporal_exponent, b.temporal_exponent, part),
        estimator_radius: mix(a.estimator_radius, b.estimator_radius, part),
        estimator_minimum: mix(a.estimator_minimum, b.estimator_minimum, part),
        estimator_curve: mix(a.estimator_curve, b.estimator_curve, part),
        ..*nearer
    }
}

fn tone(a: &Tone, b: &Tone, part: f64) -> Tone {
    Tone {
        background: std::array::from_fn(|c| mix(a.background[c], b.background[c], part)),
        brightness: mix(a.brightness, b.brightness, part),
        gamma: mix(a.gamma, b.gamma, part),
        gamma_threshold: mix(a.gamma_threshold, b.gamma_threshold, part),
        vibrancy: mix(a.vibrancy, b.vibrancy, part),
        highlight_power: mix(a.highlight_power, b.highlight_power, part),
    }
}
