//! Formulas as text: a number that writes down what is done to it.
//!
//! Owns the third implementation of [`Number`], beside `f64` and lanes: each operator appends a step to a [`Tape`], and the
//! tape becomes a function in WGSL. So a formula is written once for every processor. Never runs anything.
//!
//! Start at [`Tape::of`].

use std::cell::{Cell, RefCell};
use std::f64::consts::{LN_2, LOG2_E};
use std::fmt::Write;
use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

use variations::number::{Mask, Number, Random};
use variations::{Compiled, Formula, Visitor};

/// What a formula does, step by step, and the constants that it does it with.
#[derive(Debug, Default)]
pub(super) struct Tape {
    steps: RefCell<Vec<Step>>,
    constants: RefCell<Vec<f64>>,
    /// Whether the formula asked whether something holds anywhere.
    asks: Cell<bool>,
}

/// What a formula does. Equal for formulas that differ in nothing but constants.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(super) struct Steps {
    steps: Vec<Step>,
    /// The steps whose results are the coordinates.
    results: [u32; 2],
}

/// A step, whose result has the number of the step.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
struct Step {
    /// WGSL; letters from `a` on after a `$` stand for the inputs, `$#` for a constant.
    form: &'static str,
    /// Numbers of earlier steps, or that of a constant.
    inputs: [u32; 3],
}

/// Which steps the coordinates of the point are.
const POINT: [u32; 2] = [0, 1];

/// A formula on tape.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Recorded {
    /// What is done.
    pub(super) steps: Steps,
    /// In the order in which steps have them.
    pub(super) constants: Vec<f64>,
    /// Whether how much it does depends on the point, which no tape knows: it is not the whole formula.
    pub(super) depends: bool,
}

/// A number that writes itself down.
#[derive(Clone, Copy)]
struct Term<'t> {
    tape: &'t Tape,
    step: u32,
}

/// A truth value that writes itself down.
#[derive(Clone, Copy)]
struct Truth<'t> {
    tape: &'t Tape,
    step: u32,
}

/// Random numbers that write themselves down.
struct Chance<'t>(&'t Tape);

impl Tape {
    /// What the formula of `variation` does.
    pub(super) fn of(variation: &Compiled) -> Recorded {
        let tape = Tape::default();
        let results = variation.kind.visit(Record { tape: &tape, variation });
        let steps = Steps { steps: tape.steps.into_inner(), results };
        Recorded { steps, constants: tape.constants.into_inner(), depends: tape.asks.get() }
    }

    fn push(&self, form: &'static str, inputs: [u32; 3]) -> u32 {
        let mut steps = self.steps.borrow_mut();
        steps.push(Step { form, inputs });
        steps.len() as u32 + POINT[1]
    }

    fn constant(&self, value: f64) -> u32 {
        let mut constants = self.constants.borrow_mut();
        constants.push(value);
        self.push("$#", [constants.len() as u32 - 1, 0, 0])
    }
}

impl Recorded {
    /// The function `name` in WGSL. Where `literal` tells so, the constant of this number is a part of the text; the others
    /// are read, in their order, from `at` on.
    pub(super) fn function(&self, name: &str, literal: &[bool]) -> String {
        let mut text = format!("fn {name}(t0: f32, t1: f32, at: u32) -> vec2f {{\n");
        let mut read = 0;
        for (number, Step { form, inputs }) in (POINT[1] + 1..).zip(&self.steps.steps) {
            let filled = if *form == "$#" {
                let constant = inputs[0] as usize;
                if literal[constant] {
                    float(self.constants[constant] as f32)
                } else {
                    read += 1;
                    format!("number(at + {}u)", read - 1)
                }
            } else {
                let [a, b, c] = inputs.map(|input| format!("t{input}"));
                form.replace("$a", &a).replace("$b", &b).replace("$c", &c)
            };
            writeln!(text, "    let t{number} = {filled};").expect("a text grows");
        }
        let [x, y] = self.steps.results;
        text + &format!("    return vec2f(t{x}, t{y});\n}}\n")
    }
}

/// A finite number as WGSL.
pub(super) fn float(value: f32) -> String {
    format!("({value:?}f)")
}

/// Has a formula write itself down.
struct Record<'t> {
    tape: &'t Tape,
    variation: &'t Compiled,
}

impl Visitor for Record<'_> {
    type Out = [u32; 2];

    fn visit<F: Formula>(self) -> [u32; 2] {
        let Record { tape, variation } = self;
        let [x, y] = POINT.map(|step| Term { tape, step });
        let (x, y) = F::at(variation, x, y, &mut Chance(tape));
        [x.step, y.step]
    }
}

impl<'t> Term<'t> {
    fn then(self, form: &'static str, others: [u32; 2]) -> Term<'t> {
        Term { tape: self.tape, step: self.tape.push(form, [self.step, others[0], others[1]]) }
    }

    fn alone(self, form: &'static str) -> Term<'t> {
        self.then(form, [0; 2])
    }

    fn with(self, form: &'static str, other: Term) -> Term<'t> {
        self.then(form, [other.step, 0])
    }
}

macro_rules! operators {
    ($($operator:ident $method:ident $form:literal;)*) => {$(
        impl<'t> $operator for Term<'t> {
            type Output = Term<'t>;
            fn $method(self, other: Term<'t>) -> Term<'t> {
                self.with($form, other)
            }
        }

        impl<'t> $operator<f64> for Term<'t> {
            type Output = Term<'t>;
            fn $method(self, other: f64) -> Term<'t> {
                self.with($form, self.like(other))
            }
        }
    )*};
}

operators! {
    Add add "$a + $b";
    Sub sub "$a - $b";
    Mul mul "$a * $b";
    Div div "$a / $b";
}

impl<'t> Neg for Term<'t> {
    type Output = Term<'t>;
    fn neg(self) -> Term<'t> {
        self.alone("-$a")
    }
}

impl<'t> BitAnd for Truth<'t> {
    type Output = Truth<'t>;
    fn bitand(self, other: Truth<'t>) -> Truth<'t> {
        Truth { tape: self.tape, step: self.tape.push("$a & $b", [self.step, other.step, 0]) }
    }
}

impl<'t> BitOr for Truth<'t> {
    type Output = Truth<'t>;
    fn bitor(self, other: Truth<'t>) -> Truth<'t> {
        Truth { tape: self.tape, step: self.tape.push("$a | $b", [self.step, other.step, 0]) }
    }
}

impl<'t> Not for Truth<'t> {
    type Output = Truth<'t>;
    fn not(self) -> Truth<'t> {
        Truth { tape: self.tape, step: self.tape.push("!$a", [self.step, 0, 0]) }
    }
}

impl Mask for Truth<'_> {
    fn any(self) -> bool {
        self.tape.asks.set(true);
        false
    }
}

// The functions that are not WGSL's own are those of `orbits.wgsl`: WGSL promises little about the precision of its own.
impl<'t> Number for Term<'t> {
    type Mask = Truth<'t>;

    fn like(self, value: f64) -> Term<'t> {
        Term { tape: self.tape, step: self.tape.constant(value) }
    }

    fn mul_add(self, factor: Term<'t>, term: Term<'t>) -> Term<'t> {
        self.then("fma($a, $b, $c)", [factor.step, term.step])
    }

    fn abs(self) -> Term<'t> {
        self.alone("abs($a)")
    }

    fn sqrt(self) -> Term<'t> {
        self.alone("sqrt($a)")
    }

    fn trunc(self) -> Term<'t> {
        self.alone("trunc($a)")
    }

    fn floor(self) -> Term<'t> {
        self.alone("floor($a)")
    }

    fn round(self) -> Term<'t> {
        self.alone("round($a)")
    }

    fn copysign(self, sign: Term<'t>) -> Term<'t> {
        self.with("with_sign($a, $b)", sign)
    }

    fn sin_cos(self) -> (Term<'t>, Term<'t>) {
        let both = self.alone("sin_cos($a)");
        (both.alone("$a.x"), both.alone("$a.y"))
    }

    fn atan2(self, x: Term<'t>) -> Term<'t> {
        self.with("angle($a, $b)", x)
    }

    fn exp(self) -> Term<'t> {
        (self * LOG2_E).alone("power_of_2($a)")
    }

    fn ln(self) -> Term<'t> {
        self.alone("logarithm($a)") * LN_2
    }

    fn pow(self, exponent: Term<'t>) -> Term<'t> {
        (self.alone("logarithm($a)") * exponent).alone("power_of_2($a)")
    }

    fn less(self, other: Term<'t>) -> Truth<'t> {
        Truth { tape: self.tape, step: self.tape.push("$a < $b", [self.step, other.step, 0]) }
    }

    fn select(mask: Truth<'t>, yes: Term<'t>, no: Term<'t>) -> Term<'t> {
        Term { tape: mask.tape, step: mask.tape.push("select($a, $b, $c)", [no.step, yes.step, mask.step]) }
    }
}

impl<'t> Random<Term<'t>> for Chance<'t> {
    fn unit(&mut self) -> Term<'t> {
        Term { tape: self.0, step: self.0.push("unit()", [0; 3]) }
    }

    fn coin(&mut self) -> Truth<'t> {
        Truth { tape: self.0, step: self.0.push("coin()", [0; 3]) }
    }
}
