//! From quantities to a skeleton.
//!
//! Owns how a plant branches. Whatever is counted grows from nothing: the last order, the last node, the last shoot and the
//! last leaf have the length of the fraction. Every branch has a budget of parts; it takes its own ones and shares the rest
//! among its shoots by their lengths, and one without a budget is not there. So the work is bounded before it is done, and a
//! small change of a gene is a small change of the plant. Never knows time.
//!
//! Start at [`grown`].

use std::f64::consts::TAU;

use crate::chance::{Chance, Draws};
use crate::genes::Habit;
use crate::skeleton::{Bone, GROUND, Leaf, Skeleton, Sway};
use crate::vector::{Vector, across, added, cross, scaled, smooth, unit};

/// Bones of a branch, by its order.
const BONES: [usize; 6] = [14, 6, 4, 3, 3, 3];
/// How willingly a branch of each order bends to the ground.
const WEIGHT: [f64; 6] = [0.2, 0.6, 0.9, 1.0, 1.0, 1.0];
/// How far wind bends a branch of each order, of a stem's.
const LIMBER: [f64; 6] = [1.0, 0.8, 0.8, 0.9, 1.0, 1.0];
/// How much more than its own parts a branch must have to be there as a whole.
const GATE: f64 = 0.4;
/// The radius of a stem, of its length.
const STEM: f64 = 0.0155;

/// What a stem starts with.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Seedling {
    /// Which place of chance it is.
    pub(crate) place: u64,
    pub(crate) length: f64,
    /// Radians to the right.
    pub(crate) lean: f64,
    /// Parts that it may have.
    pub(crate) budget: f64,
}

/// A branch that will grow.
struct Shoot {
    place: u64,
    order: usize,
    on: u32,
    at: f64,
    direction: Vector,
    up: Vector,
    length: f64,
    radius: f64,
    budget: f64,
    /// How much of it is there, `0.0..=1.0`: of leaves too.
    share: f64,
    lag: f64,
}

struct Growth<'a> {
    habit: &'a Habit,
    chance: Chance,
    /// How far all has grown, `0.0..=1.0`.
    vigour: f64,
    stem: u8,
    skeleton: Skeleton,
}

/// The stems of `seedlings`, `vigour` of the way from the seed to what they can be.
pub(crate) fn grown(habit: &Habit, chance: Chance, seedlings: &[Seedling], vigour: f64) -> Skeleton {
    let mut growth = Growth { habit, chance, vigour, stem: 0, skeleton: Skeleton::default() };
    for (stem, seedling) in seedlings.iter().enumerate() {
        growth.stem = stem as u8;
        let first = [growth.skeleton.bones.len(), growth.skeleton.leaves.len()];
        let mut draws = growth.chance.at(seedling.place);
        let lean = seedling.lean + 0.1 * habit.chance * draws.signed();
        let around = draws.signed() * TAU / 2.0;
        let direction = unit([lean, 1.0, 0.15 * draws.signed()], [0.0, 1.0, 0.0]);
        let outward = [libm::cos(around), 0.0, libm::sin(around)];
        growth.branch(&Shoot {
            place: seedling.place,
            order: 0,
            on: GROUND,
            at: 0.0,
            direction,
            up: across(outward, direction, [0.0, 0.0, 1.0]),
            length: seedling.length * (0.15 + 0.85 * vigour) * smooth(4.0 * vigour),
            radius: STEM * seedling.length * (0.3 + 0.7 * vigour),
            budget: seedling.budget,
            share: 1.0,
            lag: 2.1 * draws.signed(),
        });
        growth.measure(first);
    }
    growth.skeleton
}

impl Growth<'_> {
    /// How much of an order is there.
    fn order_share(&self, order: usize) -> f64 {
        // The outer orders come last.
        let come = smooth((self.vigour * (self.habit.depth + 1.5) - order as f64) / 1.5);
        (self.habit.depth - order as f64).clamp(0.0, 1.0) * come
    }

    /// How much of its leaves a branch has: all where no shoots follow, be it for its order or for want of budget.
    fn leafy(&self, shoot: &Shoot, rank: usize) -> f64 {
        let habit = self.habit;
        let outer = (shoot.order as f64 - (habit.depth - 2.0)).clamp(0.0, 1.0);
        let own = BONES[rank] as f64 + habit.leaf_density + 1.0;
        let of_shoot = BONES[(rank + 1).min(BONES.len() - 1)] as f64 + habit.leaf_density + 1.0;
        let each = (shoot.budget - own) / (habit.segments * habit.branching);
        outer.max(1.0 - smooth((each / of_shoot - 0.55) / 0.6))
    }

    fn branch(&mut self, shoot: &Shoot) {
        let habit = self.habit;
        let rank = shoot.order.min(BONES.len() - 1);
        let leaves = habit.leaf_density * self.leafy(shoot, rank);
        let own = BONES[rank] as f64 + leaves + 1.0;
        // Nothing below its own parts, all from somewhat more on.
        let gate = smooth((shoot.budget / own - 1.0) / GATE);
        let length = shoot.length * gate;
        if length <= 1e-5 {
            return;
        }
        let mut draws = self.chance.at(shoot.place);
        let shoot = Shoot { length, share: shoot.share * gate, radius: shoot.radius * gate.sqrt(), ..*shoot };
        let (first, ups) = self.bones(&shoot, rank, &mut draws);
        let line = Line { shoot: &shoot, first, ups: &ups };
        self.leaves(&line, leaves, &mut draws);
        self.shoots(&line, shoot.budget - own);
    }

    /// The bones of a branch: the number of the first one, and of each the direction that its bend looks to.
    fn bones(&mut self, shoot: &Shoot, rank: usize, draws: &mut Draws) -> (u32, Vec<Vector>) {
        let habit = self.habit;
        let many = BONES[rank];
        let step = 1.0 / many as f64;
        let first = self.skeleton.bones.len() as u32;
        let (mut direction, mut up) = (shoot.direction, shoot.up);
        let mut ups = Vec::with_capacity(many);
        let own = draws.signed();
        let taper = |part: f64| shoot.radius * (1.0 + (habit.taper - 1.0) * part);
        for bone in 0..many {
            let part = bone as f64 * step;
            let wander = [draws.signed(), draws.signed(), draws.signed()];
            let bend = (0.4 + 1.2 * part) * step;
            direction = added(direction, [0.0, -1.0, 0.0], habit.gravity * WEIGHT[rank] * bend);
            direction = added(direction, up, habit.curl * (0.35 + 0.65 * WEIGHT[rank]) * bend);
            direction = unit(added(direction, wander, 0.85 * habit.chance * step), shoot.direction);
            up = across(up, direction, shoot.up);
            ups.push(up);
            let (on, at) = if bone == 0 { (shoot.on, shoot.at) } else { (first + bone as u32 - 1, 1.0) };
            let start = if on == GROUND { [0.0; 3] } else { self.skeleton.place(on, at) };
            let sway = Sway {
                most: habit.sway * LIMBER[rank] * step * (0.3 + 1.4 * part),
                lag: shoot.lag + habit.sway_lag * 0.5 * part,
                own: 2.5 * own,
            };
            let youth = ((shoot.order as f64 + part) / habit.depth).min(1.0);
            self.skeleton.bones.push(Bone {
                on,
                at,
                direction,
                length: shoot.length * step,
                radii: [taper(part), taper(part + step)],
                youth,
                sway,
                start,
                stem: self.stem,
            });
        }
        (first, ups)
    }

    /// The leaves along a branch, and one at its end.
    fn leaves(&mut self, line: &Line, many: f64, draws: &mut Draws) {
        if many <= 0.0 {
            return;
        }
        let habit = self.habit;
        let come = smooth((self.vigour - 0.1) / 0.7);
        for leaf in 0..many.ceil() as usize {
            let part = (0.12 + 0.88 * (leaf as f64 + 0.7) / many).min(1.0);
            let whole = (many - leaf as f64).min(1.0);
            let [own, spread, lag] = [draws.signed(), draws.signed(), draws.signed()];
            let (on, at, direction, up) = line.frame(part, &self.skeleton);
            let around = leaf as f64 * habit.divergence + 0.6 * habit.chance * spread;
            let opening = 0.95 - 0.55 * part + 0.25 * habit.chance * own;
            let out = around_axis(direction, up, around);
            let mut pointing = added(scaled(direction, libm::cos(opening)), out, libm::sin(opening));
            pointing = unit(added(pointing, [0.0, -0.25, 0.0], habit.gravity.max(-0.3)), direction);
            // The upper side looks along the twig, and up.
            let normal = across(added(direction, [0.0, 0.7, 0.5], 1.0), pointing, out);
            let size = habit.leaf_size * (0.72 + 0.28 * own) * (1.0 - 0.35 * part * part);
            let length = size * whole.sqrt() * line.shoot.share.sqrt() * come;
            if length <= 1e-6 {
                continue;
            }
            self.skeleton.leaves.push(Leaf {
                on,
                at,
                direction: pointing,
                normal,
                length,
                width: 0.5 * habit.leaf_shape,
                age: part,
                own,
                lag: line.shoot.lag + 2.0 * lag,
                start: self.skeleton.place(on, at),
                stem: self.stem,
            });
        }
    }

    /// The shoots of a branch share what is left of its budget.
    fn shoots(&mut self, line: &Line, budget: f64) {
        let habit = self.habit;
        let share = self.order_share(line.shoot.order + 1);
        if share <= 0.0 || budget <= 0.0 {
            return;
        }
        let mut shoots = Vec::new();
        for node in 0..habit.segments.ceil() as usize {
            let part = (habit.bud_delay + (1.0 - habit.bud_delay) * (node as f64 + 0.5) / habit.segments).min(1.0);
            let whole = (habit.segments - node as f64).min(1.0);
            let near_start = libm::sqrt(1.0 - 0.97 * part) * (0.55 + 0.45 * smooth(part * 6.0));
            let near_end = 0.3 + 0.7 * smooth(part * 1.25);
            let profile = near_end + (near_start - near_end) * habit.tip_dominance;
            for side in 0..habit.branching.ceil() as usize {
                let there = whole * (habit.branching - side as f64).min(1.0) * share;
                let place = line.shoot.place.wrapping_mul(0x9e37_79b9).wrapping_add(64 * node as u64 + side as u64 + 7);
                let around = node as f64 * habit.divergence + side as f64 * TAU / habit.branching;
                shoots.push(self.bud(line, place, [part, around, there, profile]));
            }
        }
        let all: f64 = shoots.iter().map(|shoot| shoot.length).sum();
        for shoot in shoots {
            let budget = budget * shoot.length / all.max(1e-12);
            self.branch(&Shoot { budget, ..shoot });
        }
    }

    /// A shoot at a part of a branch, so far around it, so much of it there, and its length of the longest's. Its budget is not known yet.
    fn bud(&self, line: &Line, place: u64, [part, around, there, profile]: [f64; 4]) -> Shoot {
        let (habit, parent) = (self.habit, line.shoot);
        // Another stream than that of the branch itself.
        let mut draws = self.chance.at(place ^ (1 << 63));
        let (on, at, direction, up) = line.frame(part, &self.skeleton);
        let around = around + 0.5 * habit.chance * draws.signed();
        let angle = (habit.angle + habit.angle_spread * draws.signed()).max(0.12);
        let out = around_axis(direction, up, around);
        let pointing = unit(added(scaled(direction, libm::cos(angle)), out, libm::sin(angle)), direction);
        let chance = 1.0 + 0.45 * habit.chance * draws.signed();
        let weak = (1.25 - habit.chance * 0.9 * draws.signed().abs()).min(1.0);
        let there = there * weak.max(0.0);
        let vigour = there * profile;
        let here = parent.radius * (1.0 + (habit.taper - 1.0) * part);
        Shoot {
            place,
            order: parent.order + 1,
            on,
            at,
            direction: pointing,
            up: across(added(direction, [0.0, 0.5, 0.0], 1.0), pointing, out),
            length: parent.length * habit.length_ratio * vigour * chance,
            radius: here * habit.radius_ratio * vigour.min(1.0).sqrt(),
            budget: 0.0,
            share: parent.share * there.min(1.0),
            lag: parent.lag + habit.sway_lag * (0.35 + 0.3 * part) + 0.7 * draws.signed(),
        }
    }

    /// Keeps the box and the crown of the stem whose parts follow `first`.
    fn measure(&mut self, first: [usize; 2]) {
        let mut bounds = [0.0_f64, 0.0, 0.0, 1e-3];
        let (mut middle, mut weight) = ([0.0, 0.5, 0.0], 1e-6);
        let skeleton = &self.skeleton;
        let bones =
            (first[0]..skeleton.bones.len()).map(|bone| (skeleton.end(bone as u32), 0.2 * skeleton.bones[bone].length));
        let leaves = skeleton.leaves[first[1]..]
            .iter()
            .map(|leaf| (added(leaf.start, leaf.direction, leaf.length), leaf.length));
        for (place, weighs) in bones.chain(leaves) {
            bounds =
                [bounds[0].min(place[0]), bounds[1].min(place[1]), bounds[2].max(place[0]), bounds[3].max(place[1])];
            middle = added(middle, place, weighs);
            weight += weighs;
        }
        self.skeleton.boxes.push(bounds);
        self.skeleton.crowns.push(scaled(middle, 1.0 / (weight + 1e-6)));
    }
}

/// The branch on which something grows.
struct Line<'a> {
    shoot: &'a Shoot,
    first: u32,
    ups: &'a [Vector],
}

impl Line<'_> {
    /// At a part of the branch: the bone, where on it, and the directions of the branch and of its bend.
    fn frame(&self, part: f64, skeleton: &Skeleton) -> (u32, f64, Vector, Vector) {
        let along = part * self.ups.len() as f64;
        let bone = (along as usize).min(self.ups.len() - 1);
        let at = along - bone as f64;
        let on = self.first + bone as u32;
        // Between the middles of two bones the direction is between theirs, so that nothing jumps.
        let next = (bone + 1).min(self.ups.len() - 1);
        let other = skeleton.bones[(self.first as usize) + next].direction;
        let direction = skeleton.bones[on as usize].direction;
        let mixed = unit(added(scaled(direction, 1.0 - at), other, at), direction);
        let up = added(scaled(self.ups[bone], 1.0 - at), self.ups[next], at);
        (on, at, mixed, across(up, mixed, self.ups[bone]))
    }
}

/// The direction across `axis`, so many radians around it from `up`.
fn around_axis(axis: Vector, up: Vector, around: f64) -> Vector {
    let side = cross(axis, up);
    added(scaled(up, libm::cos(around)), side, libm::sin(around))
}
