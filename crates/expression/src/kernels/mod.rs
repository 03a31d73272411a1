//! What the machine does with batches of samples.
//!
//! Owns the list of kernels, what each costs, and how each is run. A kernel reads whole arrays and writes another one, in a
//! plain loop, so that it becomes vector instructions, those of [`vectorized`]. Every result is settled: finite, at most 1e6, no negative zero.
//! Never knows an expression: `lower.rs` makes kernels of it.
//!
//! Start at [`Kernel::run`]; `plain.rs`, `noise.rs` and `fractal.rs` have the loops.

mod fractal;
mod noise;
mod plain;
mod vectors;

pub(crate) use noise::Slice;
pub(crate) use vectors::vectorized;

/// Samples that are calculated at once.
pub(crate) const BATCH: usize = 512;
/// The most arguments of a kernel.
pub(crate) const MOST_ARGUMENTS: usize = 18;

/// A function of arrays of samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Kernel {
    Abs,
    Add,
    And,
    Atan,
    /// The distance to the nearest of points that turn; of u, v, size and seed.
    Cell(Slice),
    /// A number from -1 to 1 that a seed and an index choose.
    Chance(u8),
    Cos,
    Dissolve,
    Divide,
    Escape,
    /// Red, green or blue of hue, saturation and value.
    Hue(u8),
    If,
    Ifs,
    Invert,
    Log,
    Max,
    Min,
    Modulo,
    Multiply,
    /// Noise of one of three channels; of u, v, size and seed.
    Noise(u8, Slice),
    Or,
    Power,
    Round,
    Sin,
    Sqrt,
    Subtract,
    Xor,
}

impl Kernel {
    /// Nanoseconds a sample on one core of a server of 2024, with the vector instructions that every x86-64 has; measured one
    /// by one. Those of [`vectorized`] take less. For estimates only: no pixel depends on them. `examples/expression-speed.rs` compares an
    /// estimate with a measurement.
    pub(crate) fn ns(self) -> f32 {
        match self {
            Kernel::Abs | Kernel::Add | Kernel::Invert | Kernel::Max | Kernel::Min => 0.2,
            Kernel::Subtract | Kernel::Multiply | Kernel::Sqrt | Kernel::Divide => 0.3,
            Kernel::Dissolve | Kernel::If | Kernel::Round | Kernel::Modulo => 0.6,
            Kernel::And | Kernel::Or | Kernel::Xor | Kernel::Sin | Kernel::Cos => 0.8,
            Kernel::Chance(_) | Kernel::Hue(_) => 1.0,
            Kernel::Atan => 1.4,
            Kernel::Log | Kernel::Power => 2.5,
            Kernel::Noise(..) => 9.0,
            Kernel::Cell(_) => 13.0,
            Kernel::Escape => 40.0,
            Kernel::Ifs => 50.0,
        }
    }

    /// Whether its two arguments may change places.
    pub(crate) fn commutes(self) -> bool {
        let both = [Kernel::Add, Kernel::And, Kernel::Max, Kernel::Min, Kernel::Multiply, Kernel::Or, Kernel::Xor];
        both.contains(&self)
    }

    /// Calculates `out.len()` samples; every argument has as many.
    #[inline(always)]
    pub(crate) fn run(self, arguments: &[&[f32]], out: &mut [f32]) {
        match (self, arguments) {
            (Kernel::Abs, [a]) => plain::each(a, out, f32::abs),
            (Kernel::Add, [a, b]) => plain::each_two(a, b, out, plain::add),
            (Kernel::And, [a, b]) => plain::each_two(a, b, out, plain::and),
            (Kernel::Atan, [a, b]) => plain::each_two(a, b, out, plain::atan),
            (Kernel::Cell(slice), [u, v, size, seed]) => noise::cell(slice, [u, v, size, seed], out),
            (Kernel::Chance(index), [seed]) => noise::chance(index, seed, out),
            (Kernel::Cos, [a]) => plain::each(a, out, plain::cos),
            (Kernel::Dissolve, [a, b, c]) => plain::each_three(a, b, c, out, plain::dissolve),
            (Kernel::Divide, [a, b]) => plain::each_two(a, b, out, plain::divide),
            (Kernel::Escape, [u, v, re, im]) => fractal::escape([u, v, re, im], out),
            (Kernel::Hue(channel), [h, s, v]) => {
                let sixth = plain::SIXTHS[usize::from(channel)];
                plain::each_three(h, s, v, out, |h, s, v| plain::hue(sixth, h, s, v));
            }
            (Kernel::If, [a, b, c]) => plain::each_three(a, b, c, out, plain::choose),
            (Kernel::Ifs, arguments) if arguments.len() == MOST_ARGUMENTS => fractal::ifs(arguments, out),
            (Kernel::Invert, [a]) => plain::each(a, out, plain::invert),
            (Kernel::Log, [a, b]) => plain::each_two(a, b, out, plain::log),
            (Kernel::Max, [a, b]) => plain::each_two(a, b, out, plain::max),
            (Kernel::Min, [a, b]) => plain::each_two(a, b, out, plain::min),
            (Kernel::Modulo, [a, b]) => plain::each_two(a, b, out, plain::modulo),
            (Kernel::Multiply, [a, b]) => plain::each_two(a, b, out, plain::multiply),
            (Kernel::Noise(channel, slice), [u, v, size, seed]) => {
                noise::noise(channel, slice, [u, v, size, seed], out);
            }
            (Kernel::Or, [a, b]) => plain::each_two(a, b, out, plain::or),
            (Kernel::Power, [a, b]) => plain::each_two(a, b, out, plain::power),
            (Kernel::Round, [a, b]) => plain::each_two(a, b, out, plain::round),
            (Kernel::Sin, [a]) => plain::each(a, out, plain::sin),
            (Kernel::Sqrt, [a]) => plain::each(a, out, plain::sqrt),
            (Kernel::Subtract, [a, b]) => plain::each_two(a, b, out, plain::subtract),
            (Kernel::Xor, [a, b]) => plain::each_two(a, b, out, plain::xor),
            (kernel, arguments) => unreachable!("{kernel:?} does not take {} arguments", arguments.len()),
        }
    }
}
