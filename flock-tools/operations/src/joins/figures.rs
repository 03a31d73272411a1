//! Whether a join meets, in value and in velocity: the criterion.
//!
//! Owns what is measured between the frames around a join, and the limits. Never decodes: it is given views of frames
//! (`view.rs`).
//!
//! Every figure compares the join with what happens a few frames before and after it, in decibels of picture
//! distance, so that slow and fast flocks are judged alike:
//!
//! * [`Figures::step_db`], value: the distance between the last frame and the first, against the steps just before and
//!   after. Too long: frames are missing, or it is another picture. Too short: a frame is shown twice.
//! * [`Figures::course_db`], velocity's direction: distances over 2, 4 and 8 frames across the join, against as many
//!   frames before and after. Too short: motion turns back. Too long: it jumped, though too slowly for one step to tell.
//! * [`Figures::speed_db`], velocity's size: the steps after the join against those before, each followed to the join.
//!
//! Measured on cuts through unbroken takes (a still, noise, a flame turning at 0.02, 0.1, 0.4 and 2 degrees a frame,
//! three of the demo's loops, one of them at three times its pace), each half encoded separately with x264 at rate
//! factors 18, 26 and 34: cuts that meet measure at most 0.61 of what is allowed at 18 and 26, 0.81 at 34. From 0.4
//! degrees a frame on (a turn in 900 frames), at 1280x720, a frame missing measures 2.3 dB and more, a frame doubled
//! 2.8, double speed 2.2, motion turned back 2.4, another sheep 15, and 4 levels of brightness 5. Hence a limit of 2 dB
//! for all three. What is missed: the doubled frame at 0.4 degrees and rate factor 34 (0.86 of what is allowed); the
//! step of brightness on the fastest takes; and whatever is slower or fainter. There a break is hidden by the encoder's
//! noise, for viewers as well.
//!
//! A view has the same blocks at every size, and so have the distances. At 320x180, 640x360, 1280x720 and 720x1280 the
//! first demo's 35 joins measure 0.82 at most, at rate factors 20 and 34; of breaks that are planted in its loops (a frame missing,
//! a frame doubled, double speed, motion turned back, 5 levels of brightness, another sheep) all are found at all these
//! sizes at 20 and 26. But a block of a small picture has fewer pixels, and more of the encoder's noise. So the smallest
//! distance that counts rises with the noise that is expected from the quantisers of the two frames that meet: at 1280x720
//! from rate factor 40 on, at 320x180 from 20 on. There, at 34, a doubled frame and motion turned back are hidden.
//!
//! With very fast motion distances go up and down inside a clip: after a few frames of 12 degrees a flame is as far away
//! as it can be. A course is compared with the swing of those inside the clips; without that, good joins
//! of such loops measured 1.1. A transition that has half as many frames as its loops turns on average twice as fast or not
//! at all. If loops are that short (30 frames, transitions 15), the pace changes threefold within the four frames after a
//! join, and the criterion takes that for a break: render longer transitions.

use std::ops::Range;

use super::view::View;

/// The decibels that a figure may be off before the join jumps.
const LIMIT_DB: f64 = 2.0;
/// Frames on either side that are compared: the longest of [`SPANS`] and some more.
pub(super) const FRAMES: usize = 12;
/// Frames between the two ends of a course.
const SPANS: [usize; 3] = [2, 4, 8];
/// Steps on either side that a step is compared with, and whose mean is the speed.
const NEAR: usize = 2;
/// Steps on either side whose trend is the speed.
const TREND: usize = 3;
/// How much steps vary in smooth motion, in decibels.
const SMOOTH_DB: f64 = 0.5;

/// The smallest distance that counts at least, in levels of 255 (root mean square): well above the noise of x264 at rate
/// factor 34 between the end of one clip and the keyframe of the next, at 1280x720. In fine and in broad blocks.
const FLOOR: f64 = 2.5;
const BROAD_FLOOR: f64 = 1.5;
/// The same against the noise that is expected, as squares: a join that meets then measures 1.8 dB at most.
const OVER_NOISE: f64 = 2.0;
/// The squared noise in broad blocks, of that in fine ones.
const BROAD_NOISE: f64 = 1.0 / 7.0;
/// The same between two frames of one clip, which share their noise.
const INNER_FLOOR: f64 = 0.5;

/// How well the clips of a join meet.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Figures {
    /// PSNR of the luma of the last frame and the first, in decibels.
    pub value_db: f64,
    /// The mean of the same for neighbouring frames just before and after.
    pub inside_db: f64,
    /// How much longer the step across the join is than those around it.
    pub step_db: f64,
    /// How much longer the worst course across it is than those around it.
    pub course_db: f64,
    /// How much faster the motion is after it than before.
    pub speed_db: f64,
    /// The worst of the three against what is allowed: above 1 the join jumps.
    pub severity: f64,
}

impl Figures {
    /// Whether a viewer could see the join.
    pub fn jumps(&self) -> bool {
        self.severity > 1.0
    }

    /// The worst of the three figures, in words.
    pub fn worst_in_words(&self) -> String {
        let Self { value_db, inside_db, step_db, course_db, speed_db, .. } = *self;
        let (size, what) = [(step_db, "step"), (course_db, "course"), (speed_db, "speed")]
            .into_iter()
            .max_by(|a, b| a.0.abs().total_cmp(&b.0.abs()))
            .unwrap_or_default();
        let off = size.abs();
        let why = match (what, size > 0.0) {
            ("step", true) => format!("the step is {off:.1} dB longer than those around it"),
            ("step", false) => {
                format!("the step is {off:.1} dB shorter than those around it, as of a frame shown twice")
            }
            ("course", true) => format!("over a few frames the picture goes {off:.1} dB further than before and after"),
            ("course", false) => {
                format!("over a few frames the picture goes {off:.1} dB less far than before and after")
            }
            (_, true) => format!("motion is {off:.1} dB faster after it than before"),
            (_, false) => format!("motion is {off:.1} dB slower after it than before"),
        };
        format!("{why} ({value_db:.1} dB PSNR across it, {inside_db:.1} dB inside)")
    }
}

/// Mean squared differences of full frames around a join.
#[derive(Clone, Debug, Default)]
pub(super) struct SquaredDifferences {
    /// Between the last frame and the first.
    pub across: f64,
    /// Between neighbours on one side or the other.
    pub inside: Vec<f64>,
}

/// Judges the join between the frames `before` and the frames `after`, each in order and at least one.
pub(super) fn figures(before: &[View], after: &[View], squares: &SquaredDifferences) -> Figures {
    let inside = squares.inside.iter().sum::<f64>() / squares.inside.len().max(1) as f64;
    let sequence = FrameSequence { frames: before.iter().chain(after).collect(), cut: before.len() };
    let (fine, broad) = (sequence.step(fine, sequence.floor()), sequence.step(broad, sequence.broad_floor()));
    let step = if fine.over() >= broad.over() { fine } else { broad };
    let course = SPANS.iter().filter_map(|span| sequence.course(*span)).max_by(|a, b| a.over().total_cmp(&b.over()));
    let course = course.unwrap_or(Measurement { value: 0.0, variation: 0.0 });
    let speed = sequence.speed();
    let severity = [step.over(), course.over(), speed.over()].into_iter().fold(0.0, f64::max);
    Figures {
        value_db: psnr(squares.across),
        inside_db: psnr(inside),
        step_db: step.value,
        course_db: course.value,
        speed_db: speed.value,
        severity,
    }
}

/// Mean squared difference as PSNR; nothing at all is 99 dB.
fn psnr(squares: f64) -> f64 {
    (10.0 * (255.0_f64.powi(2) / squares.max(1e-9)).log10()).min(99.0)
}

fn fine(view: &View) -> &[f32] {
    &view.fine
}

fn broad(view: &View) -> &[f32] {
    &view.broad
}

/// A figure in decibels, and by how much it varies inside the clips.
#[derive(Clone, Copy)]
struct Measurement {
    value: f64,
    variation: f64,
}

impl Measurement {
    /// In parts of what is allowed.
    fn over(self) -> f64 {
        self.value.abs() / (LIMIT_DB + self.variation)
    }
}

/// Frames in a row, with the join before the frame `cut`.
struct FrameSequence<'a> {
    frames: Vec<&'a View>,
    cut: usize,
}

impl FrameSequence<'_> {
    /// The smallest distance that counts across the join in fine blocks, in levels.
    fn floor(&self) -> f64 {
        FLOOR.max((OVER_NOISE * self.noise()).sqrt())
    }

    /// The same in broad blocks.
    fn broad_floor(&self) -> f64 {
        BROAD_FLOOR.max((OVER_NOISE * BROAD_NOISE * self.noise()).sqrt())
    }

    /// The noise that is expected between the two frames that meet, as a squared distance in fine blocks.
    fn noise(&self) -> f64 {
        f64::midpoint(self.frames[self.cut - 1].noise.into(), self.frames[self.cut].noise.into())
    }

    /// The step across the join against the ones around it.
    fn step(&self, of: fn(&View) -> &[f32], floor: f64) -> Measurement {
        let steps = self.steps(of, floor);
        let cut = self.cut - 1;
        let (before, after) = (&steps[..cut], &steps[cut + 1..]);
        let near = before.iter().rev().take(NEAR).chain(after.iter().take(NEAR)).copied();
        let around = mean(near).unwrap_or(decibels(0.0, floor));
        Measurement { value: steps[cut] - around, variation: variation(before, after) }
    }

    /// The steps after the join against those before: by their means or by their trends, the smaller difference. A bend in a
    /// smooth course misleads one of the two, a change of speed neither.
    fn speed(&self) -> Measurement {
        let steps = self.steps(fine, INNER_FLOOR);
        let cut = self.cut - 1;
        let (before, mut after) = (steps[..cut].to_vec(), steps[cut + 1..].to_vec());
        after.reverse();
        let change = |before: Option<f64>, after: Option<f64>| after.zip(before).map(|(after, before)| after - before);
        let changes = [change(level(&before), level(&after)), change(lead(&before), lead(&after))];
        let value = changes.into_iter().flatten().min_by(|a, b| a.abs().total_cmp(&b.abs())).unwrap_or(0.0);
        Measurement { value, variation: variation(&before, &after) }
    }

    /// Distances over `span` frames across the join, against the nearest ones that do not cross it; `None` if there are
    /// none.
    fn course(&self, span: usize) -> Option<Measurement> {
        let (cut, floor) = (self.cut, self.floor());
        if cut <= span || self.frames.len() < cut + span + 1 {
            return None;
        }
        let across = (cut - span..cut).map(|first| self.square(first, first + span, fine)).sum::<f64>() / span as f64;
        let inside = |firsts: Range<usize>| -> Vec<f64> {
            firsts.map(|first| decibels(self.square(first, first + span, fine), floor)).collect()
        };
        let (before, after) = (inside(0..cut - span), inside(cut..self.frames.len() - span));
        let value = decibels(across, floor) - f64::midpoint(*before.last()?, *after.first()?);
        Some(Measurement { value, variation: (swing(&before).min(swing(&after)) - SMOOTH_DB).max(0.0) })
    }

    /// Every frame's distance to the next, in decibels.
    fn steps(&self, of: fn(&View) -> &[f32], floor: f64) -> Vec<f64> {
        (1..self.frames.len()).map(|next| decibels(self.square(next - 1, next, of), floor)).collect()
    }

    /// The mean squared difference of two frames.
    fn square(&self, one: usize, other: usize, of: fn(&View) -> &[f32]) -> f64 {
        let (one, other) = (of(self.frames[one]), of(self.frames[other]));
        let sum: f64 = one.iter().zip(other).map(|(a, b)| f64::from(a - b).powi(2)).sum();
        sum / one.len().max(1) as f64
    }
}

/// A squared distance in decibels, no lower than `floor` levels.
fn decibels(square: f64, floor: f64) -> f64 {
    10.0 * (square + floor * floor).log10()
}

fn mean(values: impl Iterator<Item = f64>) -> Option<f64> {
    let (count, sum) = values.fold((0u32, 0.0), |(count, sum), value| (count + 1, sum + value));
    (count > 0).then(|| sum / f64::from(count))
}

/// How much steps vary inside the clips, on the calmer side of a join: 0 where motion is smooth, more where it jerks.
fn variation(before: &[f64], after: &[f64]) -> f64 {
    (jitter(before).min(jitter(after)) - SMOOTH_DB).max(0.0)
}

/// The most that a step differs from those around it.
fn jitter(steps: &[f64]) -> f64 {
    let around = |window: &[f64]| {
        let others = window.iter().sum::<f64>() - window[NEAR];
        (window[NEAR] - others / (2 * NEAR) as f64).abs()
    };
    steps.windows(2 * NEAR + 1).map(around).fold(0.0, f64::max)
}

/// Half the range of `distances`.
fn swing(distances: &[f64]) -> f64 {
    let (least, most) = distances
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), one| (least.min(*one), most.max(*one)));
    (most - least).max(0.0) / 2.0
}

/// The mean of the last steps; `None` without any.
fn level(steps: &[f64]) -> Option<f64> {
    mean(steps.iter().rev().take(NEAR).copied())
}

/// The next step by the straight line that fits the last steps best; `None` without any.
fn lead(steps: &[f64]) -> Option<f64> {
    let steps = &steps[steps.len().saturating_sub(TREND)..];
    let level = mean(steps.iter().copied())?;
    let middle = (steps.len() as f64 - 1.0) / 2.0;
    let offsets = || steps.iter().enumerate().map(|(at, step)| (at as f64 - middle, step - level));
    let (up, across) = offsets().fold((0.0, 0.0), |(up, across), (x, y)| (up + x * y, across + x * x));
    let slope = if across > 0.0 { up / across } else { 0.0 };
    Some(level + slope * (steps.len() as f64 - middle))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Frame `at` of an endless take: waves of several lengths that run through the picture, `pace` of a turn a frame.
    fn frame(at: f64, pace: f64, brightness: f64) -> View {
        let block = |block: usize, blocks: usize| {
            let place = block as f64 / blocks as f64;
            let wave = |waves: f64, depth: f64| depth * (std::f64::consts::TAU * (waves * place + pace * at)).sin();
            (100.0 + brightness + wave(3.0, 30.0) + wave(7.0, 20.0) + wave(1.0, 10.0)) as f32
        };
        let means = |blocks: usize| (0..blocks).map(|at| block(at, blocks)).collect();
        View { fine: means(480), broad: means(30), noise: 0.0 }
    }

    /// Judges the join of two stretches of frames, each given by its places in the take.
    fn join(
        pace: f64,
        before: impl Iterator<Item = f64>,
        after: impl Iterator<Item = f64>,
        brightness: f64,
    ) -> Figures {
        let before: Vec<View> = before.map(|at| frame(at, pace, 0.0)).collect();
        let after: Vec<View> = after.map(|at| frame(at, pace, brightness)).collect();
        figures(&before, &after, &SquaredDifferences::default())
    }

    fn places(from: i32, frames: i32) -> impl Iterator<Item = f64> {
        (from..from + frames).map(f64::from)
    }

    #[test]
    fn what_breaks_a_join_is_told_from_a_cut() {
        let pace = 1.0 / 80.0;
        let meet = |after: Vec<f64>| join(pace, places(-12, 12), after.into_iter(), 0.0);
        let whole = meet(places(0, 12).collect());
        assert!(whole.severity < 0.1, "{whole:?}");
        let breaks: [(&str, Vec<f64>); 6] = [
            ("a frame is missing", places(1, 12).collect()),
            ("a frame is doubled", places(-1, 12).collect()),
            ("many frames are missing", places(40, 12).collect()),
            ("motion turns back", (0..12).map(|at| f64::from(-2 - at)).collect()),
            ("motion is twice as fast", (0..12).map(|at| f64::from(2 * at)).collect()),
            ("motion is half as fast", (0..12).map(|at| f64::from(at) / 2.0).collect()),
        ];
        for (what, after) in breaks {
            let found = meet(after);
            assert!(found.jumps(), "{what}: {found:?}");
        }
        let brighter = join(pace, places(-12, 12), places(0, 12), 5.0);
        assert!(brighter.jumps(), "{brighter:?}");
    }

    #[test]
    fn the_worst_figure_is_the_one_that_is_told() {
        let told = |after: Vec<f64>| join(1.0 / 80.0, places(-12, 12), after.into_iter(), 0.0).worst_in_words();
        assert!(told(places(9, 12).collect()).starts_with("the step is"));
        assert!(told((0..12).map(|at| f64::from(-2 - at)).collect()).contains("less far"));
        assert!(told((0..12).map(|at| f64::from(2 * at)).collect()).contains("faster"));
        assert!(told((0..12).map(|at| f64::from(at) / 2.0).collect()).contains("slower"));
    }

    #[test]
    fn a_still_meets_itself_and_no_other() {
        assert!(!join(0.0, places(-12, 12), places(0, 12), 0.0).jumps());
        assert!(join(0.0, places(-12, 12), places(0, 12), 6.0).jumps());
    }

    #[test]
    fn a_break_that_noise_would_hide_is_none() {
        let meet = |noise: f32| {
            let views = |brightness: f64| -> Vec<View> {
                places(0, 12).map(|at| View { noise, ..frame(at, 0.0, brightness) }).collect()
            };
            figures(&views(0.0), &views(3.0), &SquaredDifferences::default())
        };
        assert!(meet(0.0).jumps() && !meet(100.0).jumps());
    }

    #[test]
    fn clips_that_jerk_by_themselves_are_held_to_their_own_jerks() {
        let jerky = |from: i32| (from..from + 12).map(|at| f64::from(at / 2 * 2));
        let pace = 1.0 / 100.0;
        assert!(!join(pace, jerky(0), jerky(12), 0.0).jumps());
        assert!(join(pace, places(0, 12), jerky(12), 0.0).jumps(), "a smooth clip runs into a jerky one");
        assert!(join(pace, jerky(0), jerky(32), 0.0).jumps());
    }

    #[test]
    fn motion_that_sways_by_itself_is_held_to_its_own_sway() {
        let swaying = |at: f64| at + 0.5 * (0.9 * at).sin();
        let meet = |after: Vec<f64>| join(1.0 / 24.0, places(-8, 12).map(swaying), after.into_iter().map(swaying), 0.0);
        let whole = meet(places(4, 12).collect());
        assert!(!whole.jumps() && whole.course_db.abs() > LIMIT_DB, "{whole:?}");
        let back = meet((0..12).map(|at| f64::from(2 - at)).collect());
        assert!(back.jumps(), "{back:?}");
    }

    proptest! {
        #[test]
        fn a_cut_through_a_take_meets_at_any_pace(
            pace in 0.0..0.05f64,
            bend in -0.02..0.02f64,
            before in 1i32..=12,
            after in 1i32..=12,
        ) {
            // Motion that gains or loses speed all the time.
            let bent = |at: f64| at + bend * at * at;
            let found = join(pace, places(-before, before).map(bent), places(0, after).map(bent), 0.0);
            // With fewer than three frames there is little to compare with: only what is said of them is bounded.
            let most = if before.min(after) < 3 { f64::INFINITY } else { 1.0 };
            prop_assert!(found.severity <= most, "{:?}", found);
            prop_assert!(found.severity.is_finite());
        }
    }
}
