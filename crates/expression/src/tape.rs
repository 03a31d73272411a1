//! A graph as a list of instructions over registers.
//!
//! Owns the order, the registers, which are used again as soon as nobody needs them, and the cost. Each register holds one
//! number for every sample of a batch. Never knows the language.
//!
//! Start at [`Tape::of`] and [`Tape::run`].

use crate::graph::{Entry, Graph, Id};
use crate::kernels::{BATCH, Kernel, MOST_ARGUMENTS};

/// What a sample takes beside kernels, in nanoseconds: its position, its light, its part of the pixel.
const SAMPLE_NS: f32 = 8.0;
/// Registers of the position.
pub(crate) const POSITION: [usize; 2] = [0, 1];

/// A kernel, the registers it reads, and the one it writes, which is none of them.
#[derive(Clone, Debug)]
struct Instruction {
    kernel: Kernel,
    from: Vec<usize>,
    to: usize,
}

/// What is done for each batch of samples.
#[derive(Clone, Debug)]
pub(crate) struct Tape {
    constants: Vec<(usize, f32)>,
    instructions: Vec<Instruction>,
    registers: usize,
    outputs: [usize; 3],
}

/// The registers of a tape.
pub(crate) struct Registers(Vec<Vec<f32>>);

impl Tape {
    /// The tape that calculates red, green and blue.
    pub(crate) fn of(graph: &Graph, colours: [Id; 3]) -> Tape {
        let entries = graph.entries();
        let last_use = last_uses(entries, colours);
        let mut places = vec![0; entries.len()];
        places[..2].copy_from_slice(&POSITION);
        let (mut constants, mut instructions, mut free, mut registers) = (Vec::new(), Vec::new(), Vec::new(), 2);
        let mut take = |free: &mut Vec<usize>| {
            free.pop().unwrap_or_else(|| {
                registers += 1;
                registers - 1
            })
        };
        for (number, entry) in entries.iter().enumerate().filter(|(number, _)| last_use[*number].is_some()) {
            match entry {
                Entry::Call(kernel, arguments) => {
                    let from: Vec<usize> = arguments.iter().map(|id| places[id.0 as usize]).collect();
                    places[number] = take(&mut free);
                    instructions.push(Instruction { kernel: *kernel, from, to: places[number] });
                    let mut ended: Vec<usize> = arguments.iter().map(|id| id.0 as usize).collect();
                    ended.sort_unstable();
                    ended.dedup();
                    let is_free = |id: &usize| last_use[*id] == Some(number) && matches!(entries[*id], Entry::Call(..));
                    free.extend(ended.into_iter().filter(is_free).map(|id| places[id]));
                }
                // Constants keep their registers, which are filled once.
                Entry::Constant(bits) => {
                    places[number] = take(&mut Vec::new());
                    constants.push((places[number], f32::from_bits(*bits)));
                }
                Entry::Position(_) => {}
            }
        }
        let outputs = colours.map(|id| places[id.0 as usize]);
        Tape { constants, instructions, registers, outputs }
    }

    /// Nanoseconds a sample, by the table of the kernels, with what every sample takes.
    pub(crate) fn ns(&self) -> f32 {
        self.instructions.iter().fold(SAMPLE_NS, |sum, instruction| sum + instruction.kernel.ns())
    }

    /// Bytes of its registers.
    pub(crate) fn bytes(&self) -> usize {
        self.registers * (BATCH * size_of::<f32>() + size_of::<Vec<f32>>())
    }

    /// Most bytes of itself while it is made; its tables grow by doubling.
    pub(crate) fn own_bytes(&self) -> u64 {
        let room = |count: usize| count.next_power_of_two().max(4) * 3 / 2;
        let registers: usize = self.instructions.iter().map(|instruction| instruction.from.len()).sum();
        let instructions = room(self.instructions.len()) * size_of::<Instruction>();
        (instructions + (registers + 2 * room(self.constants.len())) * size_of::<usize>()) as u64
    }

    /// Registers with the constants in them.
    pub(crate) fn registers(&self) -> Registers {
        let mut registers = vec![vec![0.0; BATCH]; self.registers];
        for (register, value) in &self.constants {
            registers[*register].fill(*value);
        }
        Registers(registers)
    }

    /// Calculates red, green and blue of the first `count` positions in the registers, at most a batch.
    #[inline(always)]
    pub(crate) fn run<'r>(&self, registers: &'r mut Registers, count: usize) -> [&'r [f32]; 3] {
        for Instruction { kernel, from, to } in &self.instructions {
            let mut out = std::mem::take(&mut registers.0[*to]);
            let mut arguments: [&[f32]; MOST_ARGUMENTS] = [&[]; MOST_ARGUMENTS];
            for (argument, register) in arguments.iter_mut().zip(from) {
                *argument = &registers.0[*register][..count];
            }
            kernel.run(&arguments[..from.len()], &mut out[..count]);
            registers.0[*to] = out;
        }
        self.outputs.map(|register| &registers.0[register][..count])
    }
}

impl Registers {
    /// The registers of x and y.
    pub(crate) fn positions(&mut self) -> [&mut [f32]; 2] {
        let (x, rest) = self.0.split_at_mut(1);
        [&mut x[POSITION[0]], &mut rest[POSITION[1] - 1]]
    }
}

/// For each entry, the last one that needs it, or the end; none where nobody does.
fn last_uses(entries: &[Entry], colours: [Id; 3]) -> Vec<Option<usize>> {
    let mut last = vec![None; entries.len()];
    for id in colours {
        last[id.0 as usize] = Some(entries.len());
    }
    for (number, entry) in entries.iter().enumerate().rev() {
        let Entry::Call(_, arguments) = entry else { continue };
        if last[number].is_some() {
            for id in arguments {
                let use_ = &mut last[id.0 as usize];
                *use_ = Some(use_.unwrap_or(number));
            }
        }
    }
    last
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lower::lowered;
    use crate::node::Node;
    use crate::still::Still;

    fn tape(text: &str) -> Tape {
        let (mut graph, at) = Graph::new();
        let colours = lowered(&Still::of(&Node::parse(text).unwrap(), 0.25), 1.0, &mut graph, at);
        Tape::of(&graph, colours)
    }

    #[test]
    fn equal_parts_are_calculated_once_and_constant_ones_not_at_all() {
        assert_eq!(tape("(+ (sin (* x y)) (sin (* y x)))").instructions.len(), 3);
        assert_eq!(tape("(* (+ 1 z) (sin (/ 3 (wave 2 .1))))").instructions.len(), 0);
        assert_eq!(tape("(vector (sin x) (sin x) (sin x))").instructions.len(), 1);
    }

    #[test]
    fn registers_are_used_again() {
        let chain = (0..40).fold("x".to_owned(), |inner, _| format!("(sin {inner})"));
        let tape = tape(&chain);
        assert_eq!((tape.instructions.len(), tape.registers), (40, 4));
    }
}
