//! A shot as a GPU reads it: a shader, and the numbers of each moment.
//!
//! Owns both. The text depends on the forms of transforms alone, and not on their numbers: one shader serves all frames of
//! a clip, whose numbers change. Transforms of one form share their code. Never talks to a GPU.
//!
//! Start at [`Program::new`].

use std::collections::HashMap;
use std::fmt::Write;

use super::frame::ORBITS_OF_WORKGROUP;
use super::tape::{Recorded, Steps, Tape, float};
use crate::genome::Affine;
use crate::render::RenderError;
use crate::render::plan::{CompiledXform, Passed, Plan, Summand};
use crate::render::shot::Shot;
use variations::number::series;
use variations::{Compiled, MAX_PARAMETERS};

/// Most variations in all forms of transforms of a frame: a driver takes seconds to compile so many.
const MOST_CALLS: usize = 2000;

/// What of a plan stands where.
const MOVES: u32 = 0;
const THRESHOLDS: u32 = 1;
const THRESHOLDS_ON: u32 = 2;
const LENS: u32 = 3;
const TO_CELLS: u32 = 4;
const FIRST_MOVE: u32 = 10;

/// What of a transform stands where; from `NUMBERS` on are those that its form reads.
const PROGRAM: u32 = 0;
const KEEP: u32 = 1;
const PULL: u32 = 2;
const PART: u32 = 3;
const FIRST_ENTRY: u32 = 4;
const IS_SEEN: u32 = 5;
const OPACITY: u32 = 6;
const NUMBERS: u32 = 7;

/// Numbers of an affine map.
const AFFINE: u32 = 6;

/// A shot for a GPU.
#[derive(Debug)]
pub(super) struct Program {
    /// The shader, in WGSL.
    pub(super) text: String,
    /// The step at which each moment begins, and where its plan is, by turns; then the plans.
    pub(super) words: Vec<u32>,
}

/// The forms that were met so far.
#[derive(Default)]
struct Forms {
    /// The functions of all formulas.
    functions: String,
    /// By what they do, and the constants that are a part of their text.
    formulas: HashMap<(Steps, Vec<Option<u64>>), Formula>,
    moved: HashMap<Form, u32>,
    seen_through: HashMap<Form, u32>,
    /// Calls of formulas in all forms.
    calls: usize,
}

/// A formula that has become a function.
#[derive(Clone)]
struct Formula {
    number: usize,
    /// How many numbers it reads.
    reads: u32,
}

/// What a transform does, whatever its numbers are.
#[derive(Clone, PartialEq, Eq, Hash)]
struct Form {
    /// Numbers of functions, and how many numbers each reads.
    before: Vec<(usize, u32)>,
    variations: Vec<(usize, u32)>,
    has_post: bool,
}

impl Program {
    /// Writes the program of `shot`.
    /// Errors: [`RenderError::Range`] where transforms have too many forms.
    pub(super) fn new(shot: &Shot) -> Result<Program, RenderError> {
        let mut forms = Forms::default();
        let mut words = vec![0; 2 * shot.plans.len()];
        if let Some(what) = shot.plans.iter().find_map(beyond) {
            return Err(RenderError::NotOnGpu { what });
        }
        for (moment, (plan, begins)) in shot.plans.iter().zip(&shot.begins).enumerate() {
            words[2 * moment] = *begins as u32;
            words[2 * moment + 1] = words.len() as u32;
            forms.write_plan(plan, &mut words);
        }
        if forms.calls > MOST_CALLS {
            let expected = "at most 2000 variations in different transforms of a frame, for a GPU";
            return Err(RenderError::Range { name: "xform", value: forms.calls as f64, expected });
        }
        Ok(Program { text: forms.text(shot.plans[0].entries), words })
    }
}

impl Forms {
    fn write_plan(&mut self, plan: &Plan, words: &mut Vec<u32>) {
        let start = words.len();
        words.resize(start + FIRST_MOVE as usize + plan.moves.len(), 0);
        words[start + MOVES as usize] = plan.moves.len() as u32;
        for (at, number) in numbers(&plan.to_cells).into_iter().enumerate() {
            words[start + TO_CELLS as usize + at] = number;
        }
        for (number, chosen) in plan.moves.iter().enumerate() {
            words[start + FIRST_MOVE as usize + number] = words.len() as u32;
            self.write_transform(chosen, plan.first_entry(number), false, words);
        }
        if let Some(lens) = plan.lenses.first() {
            words[start + LENS as usize] = words.len() as u32;
            self.write_transform(lens, 0, true, words);
        }
        words[start + THRESHOLDS as usize] = words.len() as u32;
        words[start + THRESHOLDS_ON as usize] = if plan.choices.len() > 1 { plan.moves.len() as u32 - 1 } else { 0 };
        words.extend(plan.choices.iter().flatten());
    }

    fn write_transform(&mut self, xform: &CompiledXform, first_entry: u32, is_lens: bool, words: &mut Vec<u32>) {
        let start = words.len();
        words.resize(start + NUMBERS as usize, 0);
        let number = |value: f64| (value as f32).to_bits();
        words[start + KEEP as usize] = number(xform.keep);
        words[start + PULL as usize] = number(xform.pull);
        words[start + PART as usize] = number(xform.part);
        words[start + FIRST_ENTRY as usize] = first_entry;
        words[start + IS_SEEN as usize] = u32::from(xform.brightness != 0.0);
        words[start + OPACITY as usize] = number(xform.opacity);
        words.extend(numbers(&xform.affine));
        let before = xform.before.iter().map(|passed| self.write_formula(&passed.variation, words)).collect();
        let variation = |summand: &Summand| match summand {
            Summand::Plain(variation)
            | Summand::Part { variation, .. }
            | Summand::Running(Passed { variation, .. }) => Some(*variation),
            Summand::Carried(_) => None,
        };
        let summands = xform.variations.iter().filter_map(variation);
        let variations = summands.map(|variation| self.write_formula(&variation, words)).collect();
        words.extend(xform.post.iter().flat_map(numbers));
        let form = Form { before, variations, has_post: xform.post.is_some() };
        words[start + PROGRAM as usize] = self.number_of(form, is_lens);
    }

    /// Writes the numbers that the formula of `variation` reads. Returns the number of its function, and of these.
    fn write_formula(&mut self, variation: &Compiled, words: &mut Vec<u32>) -> (usize, u32) {
        let recorded = Tape::of(variation);
        let literal = literals(variation, &recorded);
        let constants = || recorded.constants.iter().zip(&literal);
        words.extend(constants().filter(|(_, literal)| !**literal).map(|(value, _)| (*value as f32).to_bits()));
        let key = constants().map(|(value, literal)| literal.then(|| value.to_bits())).collect();
        let count = self.formulas.len();
        let functions = &mut self.functions;
        let formula = self.formulas.entry((recorded.steps.clone(), key)).or_insert_with(|| {
            functions.push_str(&recorded.function(&format!("formula_{count}"), &literal));
            Formula { number: count, reads: literal.iter().filter(|literal| !**literal).count() as u32 }
        });
        (formula.number, formula.reads)
    }

    fn number_of(&mut self, form: Form, is_lens: bool) -> u32 {
        let forms = if is_lens { &mut self.seen_through } else { &mut self.moved };
        let count = forms.len() as u32;
        let calls = form.before.len() + form.variations.len();
        *forms.entry(form).or_insert_with(|| {
            self.calls += calls;
            count
        })
    }

    fn text(&self, entries: u32) -> String {
        let mut text = constants(entries);
        text.push_str(include_str!("orbits.wgsl"));
        text.push_str(&self.functions);
        for (name, forms) in [("moved", &self.moved), ("seen_through", &self.seen_through)] {
            let mut sorted: Vec<_> = forms.iter().collect();
            sorted.sort_by_key(|(_, number)| **number);
            let mut cases = String::new();
            for (form, number) in sorted {
                text.push_str(&form.function(&format!("{name}_{number}")));
                writeln!(cases, "        case {number}u: {{ return {name}_{number}(x, y, at); }}")
                    .expect("a text grows");
            }
            write!(
                text,
                "fn {name}(form: u32, x: f32, y: f32, at: u32) -> vec2f {{\n    switch form {{\n{cases}        \
                 default: {{ return vec2f(x, y); }}\n    }}\n}}\n"
            )
            .expect("a text grows");
        }
        text
    }
}

impl Form {
    /// The function `name` in WGSL: the image of a point.
    fn function(&self, name: &str) -> String {
        let mut text = format!(
            "fn {name}(x: f32, y: f32, at: u32) -> vec2f {{\n    var point = affine(at, x, y);\n    var sum = vec2f();\n"
        );
        let mut at = AFFINE;
        let mut sum = |formulas: &[(usize, u32)], text: &mut String| {
            for (number, reads) in formulas {
                writeln!(text, "    sum += formula_{number}(point.x, point.y, at + {at}u);").expect("a text grows");
                at += reads;
            }
        };
        sum(&self.before, &mut text);
        if !self.before.is_empty() {
            text.push_str("    point += sum;\n    sum = vec2f();\n");
        }
        sum(&self.variations, &mut text);
        if self.has_post {
            writeln!(text, "    sum = affine(at + {at}u, sum.x, sum.y);").expect("a text grows");
        }
        text + "    return sum;\n}\n"
    }
}

/// What `plan` asks for that only the processor draws.
fn beyond(plan: &Plan) -> Option<&'static str> {
    let xforms = || plan.moves.iter().chain(&plan.lenses);
    let is_added_twice = |xform: &CompiledXform| xform.before.len() > 1;
    let replaces = |xform: &CompiledXform| {
        let runs = xform.variations.iter().any(|summand| !matches!(summand, Summand::Plain(_)));
        runs || !xform.after.is_empty() || xform.before.iter().any(|passed| passed.presence.is_some())
    };
    let counts = |summand: &Summand| matches!(summand, Summand::Plain(it) if Tape::of(it).depends);
    if plan.has_z {
        Some("flames in three dimensions")
    } else if plan.begins_again < 1.0 {
        Some("flames whose orbits escape for good, as JWildfire's do")
    } else if plan.lenses.len() > 1 {
        Some("several final transforms")
    } else if xforms().any(|xform| replaces(xform) || is_added_twice(xform)) {
        Some("variations before or after the sum")
    } else if xforms().any(|xform| xform.is_in_colour) {
        Some("variations that change colours")
    } else if xforms().any(|xform| xform.variations.iter().any(counts)) {
        Some("variations that count steps")
    } else {
        None
    }
}

/// Which constants of a formula are the same whatever its weight and parameters are.
fn literals(variation: &Compiled, recorded: &Recorded) -> Vec<bool> {
    let probe = |first: f64, step: f64| {
        let p: [f64; MAX_PARAMETERS] = std::array::from_fn(|i| first + step * i as f64);
        Tape::of(&Compiled { w: first - step, p, ..*variation })
    };
    let probes = [probe(1.37, 0.31), probe(2.61, 0.173)];
    let is_alike = probes.iter().all(|probe| probe.steps == recorded.steps);
    let is_literal = |(at, value): (usize, &f64)| {
        is_alike
            && (*value as f32).is_finite()
            && probes.iter().all(|probe| probe.constants[at].to_bits() == value.to_bits())
    };
    recorded.constants.iter().enumerate().map(is_literal).collect()
}

fn numbers(affine: &Affine) -> [u32; 6] {
    let Affine { a, b, c, d, e, f } = *affine;
    [a, b, c, d, e, f].map(|number| (number as f32).to_bits())
}

/// What the fixed part of the shader needs to know.
fn constants(entries: u32) -> String {
    let mut text = String::new();
    let words = [
        ("MOVES", MOVES),
        ("THRESHOLDS", THRESHOLDS),
        ("THRESHOLDS_ON", THRESHOLDS_ON),
        ("LENS", LENS),
        ("TO_CELLS", TO_CELLS),
        ("FIRST_MOVE", FIRST_MOVE),
        ("PROGRAM", PROGRAM),
        ("KEEP", KEEP),
        ("PULL", PULL),
        ("PART", PART),
        ("FIRST_ENTRY", FIRST_ENTRY),
        ("IS_SEEN", IS_SEEN),
        ("OPACITY", OPACITY),
        ("NUMBERS", NUMBERS),
        ("ENTRIES", entries),
        ("WORKGROUP", ORBITS_OF_WORKGROUP),
    ];
    for (name, value) in words {
        writeln!(text, "const {name} = {value}u;").expect("a text grows");
    }
    writeln!(text, "const LACKING = {};", float(series::LACKING)).expect("a text grows");
    writeln!(text, "const HALF_ROOT = {}i;", series::HALF_ROOT).expect("a text grows");
    let polynomials: [(&str, &[f32]); 5] = [
        ("sin", &series::SIN),
        ("cos", &series::COS),
        ("atan", &series::ATAN),
        ("log", &series::LOG),
        ("exp2", &series::EXP2),
    ];
    for (name, coefficients) in polynomials {
        let sum = coefficients[1..]
            .iter()
            .fold(float(coefficients[0]), |sum, coefficient| format!("fma({sum}, x, {})", float(*coefficient)));
        writeln!(text, "fn series_{name}(x: f32) -> f32 {{ return {sum}; }}").expect("a text grows");
    }
    text
}
