//! From an expression at a moment to a graph of kernels.
//!
//! Owns the types (a scalar is spread, a vector is averaged) and every function that is more than one kernel: colours,
//! noise, neighbours and warps. A function that looks elsewhere evaluates its argument at another position. Never
//! calculates: `kernels` do.
//!
//! Start at [`lowered`].

use std::f32::consts::TAU;

use crate::functions::{Function, Lowering, Wants};
use crate::graph::{Graph, Id};
use crate::kernels::{Kernel, Slice};
use crate::still::Still;

/// Neighbours are this far away, in heights of the picture.
const STEP: f32 = 1.0 / 540.0;
/// Slopes far below this, squared, have no direction.
const FLAT: f32 = 0.01;

/// A scalar or a vector.
#[derive(Clone, Copy)]
enum Value {
    Scalar(Id),
    Vector([Id; 3]),
}

impl Value {
    /// A scalar is every component.
    fn spread(self) -> [Id; 3] {
        match self {
            Value::Scalar(id) => [id; 3],
            Value::Vector(ids) => ids,
        }
    }
}

/// A graph that grows.
struct Builder<'g> {
    graph: &'g mut Graph,
    /// From the middle to a neighbour.
    step: f32,
}

/// A function with its arguments, at a position.
struct Call<'s> {
    function: &'static Function,
    turns: f64,
    arguments: &'s [Still],
    at: [Id; 2],
}

/// Red, green and blue of an expression in a picture whose half height is `scale`.
pub(crate) fn lowered(still: &Still, scale: f32, graph: &mut Graph, at: [Id; 2]) -> [Id; 3] {
    let mut builder = Builder { graph, step: 2.0 * scale * STEP };
    builder.value(still, at).spread()
}

impl Builder<'_> {
    fn value(&mut self, still: &Still, at: [Id; 2]) -> Value {
        match still {
            Still::Call { .. } if self.graph.is_full() => Value::Scalar(at[0]),
            Still::Call { function, turns, arguments } => self.lower(&Call { function, turns: *turns, arguments, at }),
            Still::Number(number) => Value::Scalar(self.graph.constant(*number)),
            Still::Vector(vector) => Value::Vector(vector.map(|number| self.graph.constant(number))),
            Still::X => Value::Scalar(at[0]),
            Still::Y => Value::Scalar(at[1]),
        }
    }

    fn wanted(&mut self, wants: Wants, still: &Still, at: [Id; 2]) -> Value {
        let value = self.value(still, at);
        match wants {
            Wants::Any => value,
            Wants::Scalar | Wants::Seed | Wants::Size => Value::Scalar(self.average(value)),
            Wants::Vector => Value::Vector(value.spread()),
        }
    }

    fn lower(&mut self, call: &Call<'_>) -> Value {
        match call.function.lowering {
            Lowering::BandPass => self.band_pass(call),
            Lowering::Blur => {
                let radius = self.scalar(call, 1);
                self.blur(call, radius)
            }
            Lowering::Bump => self.bump(call),
            Lowering::Cell => {
                let arguments = [0, 1, 2, 3].map(|number| self.scalar(call, number));
                Value::Scalar(self.graph.call(Kernel::Cell(Slice::at(call.turns)), &arguments))
            }
            Lowering::ColourGradient => self.colour_gradient(call),
            Lowering::Each(kernel) => {
                let each = call.function.arguments.iter().zip(call.arguments);
                let values: Vec<Value> = each.map(|(wants, still)| self.wanted(wants.wants, still, call.at)).collect();
                self.each(kernel, &values)
            }
            Lowering::Escape => {
                let arguments = [0, 1, 2, 3].map(|number| self.scalar(call, number));
                Value::Scalar(self.graph.call(Kernel::Escape, &arguments))
            }
            Lowering::GradientDirection => self.gradient_direction(call),
            Lowering::GradientMagnitude => {
                let [x, y] = self.slope(&call.arguments[0], call.at);
                let length = self.length(&[x, y]);
                Value::Scalar(length)
            }
            Lowering::HsvToRgb => {
                let colour = self.vector(call, 0);
                Value::Vector([0, 1, 2].map(|channel| self.graph.call(Kernel::Hue(channel), &colour)))
            }
            Lowering::Ifs { warped } => {
                let place = self.place(warped, call);
                let rest = (if warped { 2 } else { 0 })..call.arguments.len();
                let mut arguments = place.to_vec();
                arguments.extend(rest.map(|number| self.scalar(call, number)));
                Value::Scalar(self.graph.call(Kernel::Ifs, &arguments))
            }
            Lowering::Noise { warped, coloured } => self.noise(warped, coloured, call),
            Lowering::RotateVector => self.rotate(call),
            Lowering::TransformVector => self.transform(call),
            Lowering::Vector => Value::Vector([0, 1, 2].map(|number| self.scalar(call, number))),
            Lowering::WarpAbsolute => {
                let at = [1, 2].map(|number| self.scalar(call, number));
                self.value(&call.arguments[0], at)
            }
            Lowering::WarpByGradient => self.warp_by_gradient(call),
            Lowering::WarpRelative => {
                let at = [0, 1].map(|axis| {
                    let by = self.scalar(call, axis + 1);
                    self.add(call.at[axis], by)
                });
                self.value(&call.arguments[0], at)
            }
        }
    }

    /// A kernel on each component of its arguments, a vector where one of them is.
    fn each(&mut self, kernel: Kernel, values: &[Value]) -> Value {
        let scalars: Option<Vec<Id>> =
            values.iter().map(|value| if let Value::Scalar(id) = value { Some(*id) } else { None }).collect();
        if let Some(scalars) = scalars {
            return Value::Scalar(self.graph.call(kernel, &scalars));
        }
        let vectors: Vec<[Id; 3]> = values.iter().map(|value| value.spread()).collect();
        Value::Vector([0, 1, 2].map(|component| {
            let arguments: Vec<Id> = vectors.iter().map(|vector| vector[component]).collect();
            self.graph.call(kernel, &arguments)
        }))
    }

    fn average(&mut self, value: Value) -> Id {
        match value {
            Value::Scalar(id) => id,
            Value::Vector([a, b, c]) => {
                let sum = self.add(a, b);
                let sum = self.add(sum, c);
                self.times(sum, 1.0 / 3.0)
            }
        }
    }

    fn scalar(&mut self, call: &Call<'_>, number: usize) -> Id {
        let value = self.value(&call.arguments[number], call.at);
        self.average(value)
    }

    fn vector(&mut self, call: &Call<'_>, number: usize) -> [Id; 3] {
        let value = self.value(&call.arguments[number], call.at);
        value.spread()
    }

    fn add(&mut self, a: Id, b: Id) -> Id {
        self.graph.call(Kernel::Add, &[a, b])
    }

    fn multiply(&mut self, a: Id, b: Id) -> Id {
        self.graph.call(Kernel::Multiply, &[a, b])
    }

    fn times(&mut self, a: Id, factor: f32) -> Id {
        let factor = self.graph.constant(factor);
        self.multiply(a, factor)
    }

    fn dot(&mut self, a: &[Id], b: &[Id]) -> Id {
        let products: Vec<Id> = a.iter().zip(b).map(|(a, b)| self.multiply(*a, *b)).collect();
        products.into_iter().reduce(|sum, product| self.add(sum, product)).expect("there are two components or three")
    }

    fn length(&mut self, of: &[Id]) -> Id {
        let square = self.dot(of, of);
        self.graph.call(Kernel::Sqrt, &[square])
    }

    /// A vector of length 1, or 0 where it has no direction.
    fn direction(&mut self, of: [Id; 3]) -> [Id; 3] {
        let length = self.length(&of);
        of.map(|component| self.graph.call(Kernel::Divide, &[component, length]))
    }

    /// Cosine and sine of an angle in turns.
    fn circle(&mut self, turns: Id) -> [Id; 2] {
        let angle = self.times(turns, TAU);
        [Kernel::Cos, Kernel::Sin].map(|kernel| self.graph.call(kernel, &[angle]))
    }

    /// Where a function looks: at its first two arguments if it is warped, else where it is.
    fn place(&mut self, warped: bool, call: &Call<'_>) -> [Id; 2] {
        if warped { [0, 1].map(|number| self.scalar(call, number)) } else { call.at }
    }

    fn noise(&mut self, warped: bool, coloured: bool, call: &Call<'_>) -> Value {
        let [u, v] = self.place(warped, call);
        let first = if warped { 2 } else { 0 };
        let [size, seed] = [first, first + 1].map(|number| self.scalar(call, number));
        let slice = Slice::at(call.turns);
        let mut channel = |channel| self.graph.call(Kernel::Noise(channel, slice), &[u, v, size, seed]);
        if coloured { Value::Vector([0, 1, 2].map(channel)) } else { Value::Scalar(channel(0)) }
    }

    /// A palette: from the fourth argument to the fifth and back, once for each unit of the first times the second.
    fn colour_gradient(&mut self, call: &Call<'_>) -> Value {
        let [image, waves, phase] = [0, 1, 2].map(|number| self.scalar(call, number));
        let turns = self.multiply(image, waves);
        let turns = self.add(turns, phase);
        let [cosine, _] = self.circle(turns);
        let half = self.times(cosine, -0.5);
        let middle = self.graph.constant(0.5);
        let blend = self.add(middle, half);
        let (trough, crest) = (self.vector(call, 3), self.vector(call, 4));
        self.each(Kernel::Dissolve, &[Value::Vector(trough), Value::Vector(crest), Value::Scalar(blend)])
    }

    /// Rodrigues' rotation of the first argument about the third.
    fn rotate(&mut self, call: &Call<'_>) -> Value {
        let (vector, axis) = (self.vector(call, 0), self.vector(call, 2));
        let axis = self.direction(axis);
        let turns = self.scalar(call, 1);
        let [cosine, sine] = self.circle(turns);
        let along = self.dot(&vector, &axis);
        let rest = self.graph.call(Kernel::Invert, &[cosine]);
        let along = self.multiply(along, rest);
        Value::Vector([0, 1, 2].map(|component| {
            let (next, last) = ((component + 1) % 3, (component + 2) % 3);
            let forward = self.multiply(axis[next], vector[last]);
            let back = self.multiply(axis[last], vector[next]);
            let cross = self.graph.call(Kernel::Subtract, &[forward, back]);
            self.dot(&[vector[component], cross, axis[component]], &[cosine, sine, along])
        }))
    }

    /// The first argument times a matrix that the second chooses.
    fn transform(&mut self, call: &Call<'_>) -> Value {
        let vector = self.vector(call, 0);
        let seed = self.scalar(call, 1);
        Value::Vector([0, 1, 2].map(|row| {
            let factors = [0, 1, 2].map(|column| self.graph.call(Kernel::Chance(3 * row + column), &[seed]));
            self.dot(&vector, &factors)
        }))
    }

    fn beside(&mut self, at: [Id; 2], axis: usize, by: f32) -> [Id; 2] {
        let by = self.graph.constant(by);
        let mut beside = at;
        beside[axis] = self.add(at[axis], by);
        beside
    }

    /// How steep an image is along both axes, by central differences.
    fn slope(&mut self, image: &Still, at: [Id; 2]) -> [Id; 2] {
        [0, 1].map(|axis| {
            let [low, high] = [-self.step, self.step].map(|by| {
                let beside = self.beside(at, axis, by);
                let value = self.value(image, beside);
                self.average(value)
            });
            let difference = self.graph.call(Kernel::Subtract, &[high, low]);
            self.times(difference, 0.5 / self.step)
        })
    }

    fn gradient_direction(&mut self, call: &Call<'_>) -> Value {
        let slope = self.slope(&call.arguments[0], call.at);
        let light = self.scalar(call, 1);
        let light = self.circle(light);
        let (along, square, flat) = (self.dot(&slope, &light), self.dot(&slope, &slope), self.graph.constant(FLAT));
        let square = self.add(square, flat);
        let length = self.graph.call(Kernel::Sqrt, &[square]);
        let cosine = self.graph.call(Kernel::Divide, &[along, length]);
        let half = self.times(cosine, 0.5);
        let (more, middle) = (self.scalar(call, 2), self.graph.constant(0.5));
        let added = self.add(middle, more);
        Value::Scalar(self.add(half, added))
    }

    /// A surface of the second argument's colour, as high as the first times the third, lit from the last three.
    fn bump(&mut self, call: &Call<'_>) -> Value {
        let slope = self.slope(&call.arguments[0], call.at);
        let height = self.scalar(call, 2);
        let down = self.times(height, -1.0);
        let [x, y] = slope.map(|slope| self.multiply(slope, down));
        let up = self.graph.constant(1.0);
        let normal = self.direction([x, y, up]);
        let light = [5, 6, 7].map(|number| self.scalar(call, number));
        let light = self.direction(light);
        let (facing, none) = (self.dot(&normal, &light), self.graph.constant(0.0));
        let lit = self.graph.call(Kernel::Max, &[facing, none]);
        let [colour, bright, shade] = [1, 3, 4].map(|number| self.vector(call, number));
        Value::Vector([0, 1, 2].map(|channel| {
            let light = self.multiply(bright[channel], lit);
            let light = self.add(light, shade[channel]);
            self.multiply(colour[channel], light)
        }))
    }

    /// The first argument at a position that is moved along the slope of the second, which counts as at most 1.
    fn warp_by_gradient(&mut self, call: &Call<'_>) -> Value {
        let slope = self.slope(&call.arguments[1], call.at);
        let (square, one) = (self.dot(&slope, &slope), self.graph.constant(1.0));
        let square = self.add(square, one);
        let length = self.graph.call(Kernel::Sqrt, &[square]);
        let far = self.scalar(call, 2);
        let far = self.graph.call(Kernel::Divide, &[far, length]);
        let at = [0, 1].map(|axis| {
            let by = self.multiply(slope[axis], far);
            self.add(call.at[axis], by)
        });
        self.value(&call.arguments[0], at)
    }

    /// Nine samples of the first argument, `radius` apart, weighted 1, 2, 1 across and up.
    fn blur(&mut self, call: &Call<'_>, radius: Id) -> Value {
        let none = self.graph.constant(0.0);
        let back = self.times(radius, -1.0);
        let taps = [(back, 0.25), (none, 0.5), (radius, 0.25)];
        let mut sum = Value::Scalar(none);
        for ((up, high), (across, wide)) in taps.iter().flat_map(|up| taps.map(|across| (*up, across))) {
            let at = [self.add(call.at[0], across), self.add(call.at[1], up)];
            let tap = self.value(&call.arguments[0], at);
            let weight = Value::Scalar(self.graph.constant(high * wide));
            let tap = self.each(Kernel::Multiply, &[tap, weight]);
            sum = self.each(Kernel::Add, &[sum, tap]);
        }
        sum
    }

    fn band_pass(&mut self, call: &Call<'_>) -> Value {
        let radius = self.scalar(call, 1);
        let twice = self.times(radius, 2.0);
        let (fine, coarse) = (self.blur(call, radius), self.blur(call, twice));
        self.each(Kernel::Subtract, &[fine, coarse])
    }
}
