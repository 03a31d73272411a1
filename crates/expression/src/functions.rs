//! The functions of the language, in one table.
//!
//! Owns each function's name, arguments, result, and how readily chance chooses it. The reader, the writer, the types, the
//! limit on neighbours and the breeding all ask this table. Never calculates: [`Lowering`] names the rule, `lower.rs` has
//! the rules, and `kernels` what they cost.
//!
//! Start at [`FUNCTIONS`].

use crate::kernels::Kernel;

/// What an argument must be. Whatever is given is converted: a scalar is spread, a vector is averaged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wants {
    /// A scalar or a vector. The function works on each component, and is a vector where one of these arguments is.
    Any,
    /// A scalar.
    Scalar,
    /// A scalar that chooses a pattern. Its neighbouring values have nothing in common, so it is never interpolated.
    Seed,
    /// A scalar that is the size of a pattern's features; chance takes 0.05 to 4.
    Size,
    /// A vector.
    Vector,
}

/// An argument.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Argument {
    /// Its type.
    pub wants: Wants,
    /// How often it is evaluated for one sample: more than once where the function looks at neighbours.
    pub times: u32,
}

/// How a function is calculated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Lowering {
    BandPass,
    Blur,
    Bump,
    Cell,
    ColourGradient,
    /// A kernel, on each component.
    Each(Kernel),
    Escape,
    GradientDirection,
    GradientMagnitude,
    HsvToRgb,
    Ifs {
        warped: bool,
    },
    Noise {
        warped: bool,
        coloured: bool,
    },
    RotateVector,
    TransformVector,
    Vector,
    WarpAbsolute,
    WarpByGradient,
    WarpRelative,
}

/// A function of the language.
#[derive(Debug)]
pub struct Function {
    /// Its name, as it is written.
    pub name: &'static str,
    /// Another name that is read.
    pub also: Option<&'static str>,
    /// Its arguments, in order.
    pub arguments: &'static [Argument],
    /// Whether two arguments may change places.
    pub commutes: bool,
    /// How readily chance chooses it, beside the others.
    pub weight: u32,
    pub(crate) lowering: Lowering,
}

impl PartialEq for Function {
    fn eq(&self, other: &Function) -> bool {
        self.name == other.name
    }
}

impl Function {
    /// The function that is called `name`.
    pub fn named(name: &str) -> Option<&'static Function> {
        FUNCTIONS.iter().find(|function| function.name == name || function.also == Some(name))
    }

    const fn commuting(self) -> Function {
        Function { commutes: true, ..self }
    }

    const fn also(self, name: &'static str) -> Function {
        Function { also: Some(name), ..self }
    }
}

const fn argument(wants: Wants) -> Argument {
    Argument { wants, times: 1 }
}

const fn seen(wants: Wants, times: u32) -> Argument {
    Argument { wants, times }
}

const fn function(name: &'static str, weight: u32, lowering: Lowering, arguments: &'static [Argument]) -> Function {
    Function { name, also: None, arguments, commutes: false, weight, lowering }
}

const fn each(name: &'static str, weight: u32, kernel: Kernel, arguments: &'static [Argument]) -> Function {
    function(name, weight, Lowering::Each(kernel), arguments)
}

const A: Argument = argument(Wants::Any);
const S: Argument = argument(Wants::Scalar);
const V: Argument = argument(Wants::Vector);
const SIZE: Argument = argument(Wants::Size);
const SEED: Argument = argument(Wants::Seed);

/// Every function, by group. Colours are red, green and blue; turns are whole circles; positions are those of `x` and `y`.
///
/// # Source
/// Sims, *Artificial Evolution for Computer Graphics* (1991), section 4.1; what it leaves open is defined here.
pub static FUNCTIONS: &[Function] = &[
    each("+", 10, Kernel::Add, &[A, A]).commuting(),
    each("-", 10, Kernel::Subtract, &[A, A]),
    each("*", 10, Kernel::Multiply, &[A, A]).commuting(),
    each("/", 5, Kernel::Divide, &[A, A]),
    each("max", 4, Kernel::Max, &[A, A]).commuting(),
    each("min", 4, Kernel::Min, &[A, A]).commuting(),
    each("abs", 5, Kernel::Abs, &[A]),
    each("invert", 3, Kernel::Invert, &[A]),
    each("mod", 5, Kernel::Modulo, &[A, A]),
    each("round", 2, Kernel::Round, &[A, A]),
    each("expt", 3, Kernel::Power, &[A, A]),
    each("log", 2, Kernel::Log, &[A, A]),
    each("sin", 6, Kernel::Sin, &[A]),
    each("cos", 4, Kernel::Cos, &[A]),
    each("atan", 3, Kernel::Atan, &[A, A]),
    each("and", 2, Kernel::And, &[A, A]).commuting(),
    each("or", 2, Kernel::Or, &[A, A]).commuting(),
    each("xor", 2, Kernel::Xor, &[A, A]).commuting(),
    // The second where the first is above 0, else the third.
    each("if", 3, Kernel::If, &[S, A, A]),
    // From the first to the second as the third goes from 0 to 1.
    each("dissolve", 4, Kernel::Dissolve, &[A, A, S]),
    function("vector", 6, Lowering::Vector, &[S, S, S]),
    function("hsv-to-rgb", 5, Lowering::HsvToRgb, &[V]),
    // The first by so many turns about the third.
    function("rotate-vector", 3, Lowering::RotateVector, &[V, S, V]),
    function("transform-vector", 2, Lowering::TransformVector, &[V, SEED]),
    // An image, waves per unit of it, their phase in turns, the colours of trough and crest.
    function("color-grad", 3, Lowering::ColourGradient, &[S, S, S, V, V]),
    function("bw-noise", 4, Lowering::Noise { warped: false, coloured: false }, &[SIZE, SEED]),
    function("color-noise", 4, Lowering::Noise { warped: false, coloured: true }, &[SIZE, SEED]),
    // Where to look, u and v, in place of x and y; then as without `warped`.
    function("warped-bw-noise", 6, Lowering::Noise { warped: true, coloured: false }, &[S, S, SIZE, SEED]),
    function("warped-color-noise", 6, Lowering::Noise { warped: true, coloured: true }, &[S, S, SIZE, SEED]),
    function("cell", 4, Lowering::Cell, &[S, S, SIZE, SEED]),
    function("grad-mag", 2, Lowering::GradientMagnitude, &[seen(Wants::Scalar, 4)]),
    // An image, the direction of the light in turns, what is added.
    function("grad-direction", 2, Lowering::GradientDirection, &[seen(Wants::Scalar, 4), S, S]).also("grad-dir"),
    // A height, the surface's colour, how high the height is, the colours of light and shade, where the light is.
    function("bump", 2, Lowering::Bump, &[seen(Wants::Scalar, 4), V, S, V, V, S, S, S]),
    // An image, the height down whose slope it flows, how far.
    function("warp-by-grad", 2, Lowering::WarpByGradient, &[A, seen(Wants::Scalar, 4), S]),
    // An image and the radius.
    function("blur", 1, Lowering::Blur, &[seen(Wants::Any, 9), S]),
    function("band-pass", 1, Lowering::BandPass, &[seen(Wants::Any, 18), S]),
    // Two maps a b c d e f each (u' = a u + b v + e, v' = c u + d v + f), a centre, a size, how fast it darkens.
    function("ifs", 1, Lowering::Ifs { warped: false }, &[S; 16]),
    function("warped-ifs", 1, Lowering::Ifs { warped: true }, &[S; 18]),
    // A place, and the constant of the Julia set.
    function("escape", 2, Lowering::Escape, &[S, S, S, S]),
    function("warp-abs", 3, Lowering::WarpAbsolute, &[A, S, S]),
    function("warp-rel", 4, Lowering::WarpRelative, &[A, S, S]),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_means_one_function_and_what_commutes_has_two_like_arguments() {
        for function in FUNCTIONS {
            let of_name =
                FUNCTIONS.iter().filter(|other| other.name == function.name || other.also == Some(function.name));
            assert_eq!(of_name.count(), 1, "{}", function.name);
            assert!(!function.commutes || function.arguments == [A, A], "{}", function.name);
        }
    }
}
