//! Loops close, and transitions meet them in value and in velocity.
//!
//! Owns claims about genomes over time; none of these tests draws a picture.

use crate::bred;
use flame::{Genome, Loop, Motion, Transition};
use proptest::prelude::{any, prop_assert, proptest};

/// Frames over which a velocity is measured.
const STEP: f64 = 1e-4;

/// All numbers of a genome that a picture depends on, for its first `xforms` transforms.
fn numbers(genome: &Genome, xforms: usize) -> Vec<f64> {
    let mut out = vec![genome.camera.scale, genome.camera.zoom, genome.camera.rotate, genome.tone.gamma];
    out.extend(genome.camera.center);
    out.extend(genome.tone.background);
    out.extend([genome.tone.brightness, genome.tone.vibrancy, genome.tone.highlight_power]);
    out.extend(genome.palette.iter().flat_map(|palette| palette.entries.as_flattened()));
    for xform in genome.xforms.iter().take(xforms).chain(&genome.finals) {
        out.extend([xform.weight, xform.color, xform.color_speed, xform.opacity]);
        for affine in [xform.affine, xform.post] {
            out.extend([affine.a, affine.b, affine.c, affine.d, affine.e, affine.f]);
        }
        for variation in xform.variations.iter().filter(|variation| variation.weight.abs() > 1e-6) {
            out.push(variation.weight);
            out.extend(variation.params);
        }
    }
    out
}

/// Why the motions part at `a` frames of the one and `b` of the other, if they do.
fn parted(one: &dyn Motion, a: f64, other: &dyn Motion, b: f64, own: &Genome) -> Option<String> {
    let own = own.with_symmetry();
    let count = own.xforms.len();
    let mut at = [one.at(a), other.at(b), one.at(a + STEP), other.at(b + STEP), one.at(a - STEP), other.at(b - STEP)];
    for genome in &mut at {
        if genome.xforms.iter().skip(count).any(|xform| xform.weight.abs() > 1e-6) {
            return Some("a transform that the sheep lacks is chosen at the join".into());
        }
        if own.finals.is_empty() {
            // What stands in for a missing final transform moves no point and no colour.
            genome.finals.clear();
        }
        *genome = genome.with_symmetry();
    }
    let [one_now, other_now, one_next, other_next, one_before, other_before] = at.map(|genome| numbers(&genome, count));
    for i in 0..one_now.len() {
        if (one_now[i] - other_now[i]).abs() > 1e-6 {
            return Some(format!("number {i} jumps from {} to {}", one_now[i], other_now[i]));
        }
        let leaving = (one_now[i] - one_before[i]) / STEP;
        let arriving = (other_next[i] - other_now[i]) / STEP;
        let inner = (other_now[i] - other_before[i]) / STEP;
        let outer = (one_next[i] - one_now[i]) / STEP;
        let speeds = [leaving, arriving, inner, outer];
        let spread = speeds.iter().fold(f64::MIN, |a, b| a.max(*b)) - speeds.iter().fold(f64::MAX, |a, b| a.min(*b));
        // Eased numbers of size 255 pick up a speed of about 255 * 3 * STEP / frames² within a step.
        if spread > 2e-3 {
            return Some(format!("number {i} changes speed at the join: {speeds:?}"));
        }
    }
    None
}

proptest! {
    #![proptest_config(proptest::test_runner::Config::with_cases(256))]

    #[test]
    fn a_loop_meets_its_own_start(seed in any::<u64>(), frames in 20_u32..2000) {
        let genome = bred::genome(seed);
        let turning = Loop::new(&genome, frames.into());
        let gap = parted(&turning, frames.into(), &turning, 0.0, &genome);
        prop_assert!(gap.is_none(), "{}", gap.unwrap_or_default());
    }

    #[test]
    fn a_transition_meets_both_loops_whatever_their_lengths(
        seeds in any::<[u64; 2]>(), from in 40_u32..2000, to in 40_u32..2000, frames in 40_u32..1500,
    ) {
        let [a, b] = seeds.map(bred::genome);
        let (leaving, arriving) = (Loop::new(&a, from.into()), Loop::new(&b, to.into()));
        let way = Transition::new(&leaving, &arriving, frames.into());
        let gap = parted(&leaving, from.into(), &way, 0.0, &a);
        prop_assert!(gap.is_none(), "at the start: {}", gap.unwrap_or_default());
        let gap = parted(&arriving, 0.0, &way, frames.into(), &b);
        prop_assert!(gap.is_none(), "at the end: {}", gap.unwrap_or_default());
    }
}

#[test]
fn a_transition_between_equal_loops_turns_on_at_their_speed() {
    let genome = Genome::parse(r#"<flame><xform weight="1" coefs="0.5 0.3 -0.2 0.7 0.1 0.2" julia="1"/></flame>"#);
    let turning = Loop::new(&genome.unwrap(), 100.0);
    let way = Transition::new(&turning, &turning, 200.0);
    for frame in [0.0, 13.0, 77.5, 150.0, 200.0] {
        let (there, here) = (turning.at(frame).xforms[0].affine, way.at(frame).xforms[0].affine);
        assert!((there.a - here.a).abs() + (there.e - here.e).abs() < 1e-9, "frame {frame}: {there:?}, {here:?}");
    }
}
