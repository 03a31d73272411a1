//! From text to a genome.
//!
//! Owns what the forms mean and all that is refused about them, with its place. Never knows a function but by the table
//! (`functions.rs`); parentheses are read by `form.rs`.
//!
//! Start at [`Genome::parse`].

use crate::error::ExpressionError;
use crate::form::{Form, Kind, read};
use crate::functions::Function;
use crate::genome::{Drift, Genome, MOST_TURNS, Map, STRONGEST_ZOOM, Zoom};
use crate::math::LARGEST;
use crate::node::{FASTEST_WAVE, MOST_NODES, MOST_TIMES, Node};

/// The version of the language.
const VERSION: &str = "1";
/// The most characters of a text that an error repeats.
const MOST_QUOTED: usize = 40;
const SMALLEST_SCALE: f32 = 0.001;
const LARGEST_SCALE: f32 = 1000.0;

impl Genome {
    /// Reads a file: `(expression 1 (name "tide") (turns 1) (map (scale 1) (center 0 0)) (picture ...))`. All but the
    /// picture may be missing, and a `map` may have `(zoom n by p)` and `(drift n x y p)`, which go round as a `wave` does;
    /// forms that are not known are kept as they are.
    ///
    /// # Errors
    /// [`ExpressionError`] says what is refused, with line and column.
    pub fn parse(text: &str) -> Result<Genome, ExpressionError> {
        let form = read(text)?;
        let (head, forms) =
            form.call().filter(|(head, _)| head.text == "expression").ok_or(form.not("`(expression 1 ...)`"))?;
        match forms.first() {
            Some(version) if version.text == VERSION => {}
            Some(version) => return Err(version.number("version 1")),
            None => return Err(head.not("a version after `expression`")),
        }
        let (mut name, mut turns, mut map, mut picture, mut unknown) = (None, None, None, None, Vec::new());
        for form in &forms[1..] {
            match form.call().map(|(head, values)| (head.text, values)) {
                Some(("name", values)) => once(form, &mut name, form.string(values)?)?,
                Some(("turns", values)) => once(form, &mut turns, turns_of(form.one(values)?)?)?,
                Some(("map", values)) => once(form, &mut map, map_of(values)?)?,
                Some(("picture", values)) => {
                    once(form, &mut picture, Nodes { left: MOST_NODES }.node(form.one(values)?, 1)?)?;
                }
                _ => unknown.push(form.text.to_owned()),
            }
        }
        let picture = picture.ok_or(form.not("a `(picture ...)` inside"))?;
        Ok(Genome { name, turns: turns.unwrap_or(1), map: map.unwrap_or_default(), unknown, picture })
    }
}

impl Node {
    /// Reads an expression alone, as it stands in a `picture`.
    ///
    /// # Errors
    /// [`ExpressionError`] says what is refused, with line and column.
    pub fn parse(text: &str) -> Result<Node, ExpressionError> {
        Nodes { left: MOST_NODES }.node(&read(text)?, 1)
    }
}

/// How many nodes may still come.
struct Nodes {
    left: usize,
}

impl Nodes {
    /// The expression of a form that is evaluated `times` times for one sample.
    fn node(&mut self, form: &Form<'_>, times: u32) -> Result<Node, ExpressionError> {
        self.left = self.left.checked_sub(1).ok_or(ExpressionError::Many { place: form.place, most: MOST_NODES })?;
        match &form.kind {
            Kind::Atom => match form.text {
                "x" => Ok(Node::X),
                "y" => Ok(Node::Y),
                "z" => Ok(Node::Wave { n: 1, p: 0.0 }),
                text if text.starts_with(|c: char| c.is_ascii_digit() || "+-.".contains(c)) => {
                    Ok(Node::Number(constant(form)?))
                }
                _ => Err(form.unknown()),
            },
            Kind::List(_) => match form.call() {
                Some((head, values)) if head.text == "wave" => wave(head, values),
                Some((head, values)) => self.called(head, values, times),
                None => Err(form.not("a function after `(`")),
            },
            Kind::Text(_) => Err(form.not("an expression")),
            Kind::Vector(values) => match &values[..] {
                [a, b, c] => Ok(Node::Vector([constant(a)?, constant(b)?, constant(c)?])),
                _ => Err(ExpressionError::Arity { place: form.place, name: "#".into(), wants: 3, has: values.len() }),
            },
        }
    }

    fn called(&mut self, head: &Form<'_>, values: &[Form<'_>], times: u32) -> Result<Node, ExpressionError> {
        let function = Function::named(head.text).ok_or_else(|| head.unknown())?;
        has_arity(head, function.arguments.len(), values)?;
        let mut arguments = Vec::with_capacity(values.len());
        for (argument, value) in function.arguments.iter().zip(values) {
            let times = times * argument.times;
            if times > MOST_TIMES {
                let (place, name, most) = (head.place, head.quoted(), MOST_TIMES);
                return Err(ExpressionError::Neighbours { place, name, times, most });
            }
            arguments.push(self.node(value, times)?);
        }
        Ok(Node::Call(function, arguments))
    }
}

impl<'t> Form<'t> {
    /// The name and the values of a list that begins with a name.
    pub(crate) fn call(&self) -> Option<(&Form<'t>, &[Form<'t>])> {
        let Kind::List(forms) = &self.kind else { return None };
        let (head, values) = forms.split_first()?;
        matches!(head.kind, Kind::Atom).then_some((head, values))
    }

    fn one<'f>(&self, values: &'f [Form<'t>]) -> Result<&'f Form<'t>, ExpressionError> {
        if let [value] = values { Ok(value) } else { Err(self.not("one value")) }
    }

    fn string(&self, values: &[Form<'t>]) -> Result<String, ExpressionError> {
        match &self.one(values)?.kind {
            Kind::Text(string) => Ok(string.clone()),
            Kind::Atom | Kind::List(_) | Kind::Vector(_) => Err(values[0].not("a text in quotes")),
        }
    }

    fn quoted(&self) -> String {
        self.text.chars().take(MOST_QUOTED).collect()
    }

    fn not(&self, wants: &'static str) -> ExpressionError {
        ExpressionError::Syntax { place: self.place, wants }
    }

    fn number(&self, wants: &'static str) -> ExpressionError {
        ExpressionError::Number { place: self.place, text: self.quoted(), wants }
    }

    fn unknown(&self) -> ExpressionError {
        ExpressionError::Unknown { place: self.place, name: self.quoted() }
    }
}

fn once<T>(form: &Form<'_>, slot: &mut Option<T>, value: T) -> Result<(), ExpressionError> {
    if slot.replace(value).is_some() { Err(form.not("no second form of this name")) } else { Ok(()) }
}

fn has_arity(head: &Form<'_>, wants: usize, values: &[Form<'_>]) -> Result<(), ExpressionError> {
    let has = values.len();
    if has == wants {
        return Ok(());
    }
    Err(ExpressionError::Arity { place: head.place, name: head.quoted(), wants, has })
}

/// A number, without the sign of zero.
fn constant(form: &Form<'_>) -> Result<f32, ExpressionError> {
    let is_number = form.text.chars().all(|c| c.is_ascii_digit() || "+-.eE".contains(c));
    match form.text.parse::<f32>() {
        Ok(number) if is_number && number.abs() <= LARGEST => Ok(number + 0.0),
        _ => Err(form.number("a number from -1e6 to 1e6")),
    }
}

fn wave(head: &Form<'_>, values: &[Form<'_>]) -> Result<Node, ExpressionError> {
    has_arity(head, 2, values)?;
    Ok(Node::Wave { n: periods(&values[0])?, p: constant(&values[1])? })
}

/// Periods a turn.
fn periods(form: &Form<'_>) -> Result<u8, ExpressionError> {
    let n = form.text.parse().ok().filter(|n| (1..=FASTEST_WAVE).contains(n));
    n.ok_or_else(|| form.number("a whole number from 1 to 4"))
}

fn turns_of(form: &Form<'_>) -> Result<u32, ExpressionError> {
    let turns = form.text.parse().ok().filter(|turns| (1..=MOST_TURNS).contains(turns));
    turns.ok_or_else(|| form.number("a whole number from 1 to 16"))
}

fn map_of(forms: &[Form<'_>]) -> Result<Map, ExpressionError> {
    let (mut scale, mut center, mut zoom, mut drift) = (None, None, None, None);
    for form in forms {
        match form.call().map(|(head, values)| (head.text, values)) {
            Some(("scale", values)) => {
                let value = form.one(values)?;
                let number = constant(value)?;
                if !(SMALLEST_SCALE..=LARGEST_SCALE).contains(&number) {
                    return Err(value.number("a scale from 0.001 to 1000"));
                }
                once(form, &mut scale, number)?;
            }
            Some(("center", [x, y])) => once(form, &mut center, [constant(x)?, constant(y)?])?,
            Some(("zoom", [n, by, p])) => {
                let strength = constant(by)?;
                if strength.abs() > STRONGEST_ZOOM {
                    return Err(by.number("a zoom from -3 to 3"));
                }
                once(form, &mut zoom, Zoom { n: periods(n)?, by: strength, p: constant(p)? })?;
            }
            Some(("drift", [n, x, y, p])) => {
                once(form, &mut drift, Drift { n: periods(n)?, by: [constant(x)?, constant(y)?], p: constant(p)? })?;
            }
            _ => return Err(form.not("`(scale s)`, `(center x y)`, `(zoom n by p)` or `(drift n x y p)`")),
        }
    }
    let usual = Map::default();
    let (scale, center) = (scale.unwrap_or(usual.scale), center.unwrap_or(usual.center));
    Ok(Map { scale, center, zoom, drift })
}
