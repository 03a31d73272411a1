//! An expression as a graph of kernels in which nothing stands twice.
//!
//! Owns sharing (equal parts are found by hash) and folding (what depends on no position is calculated here, by the same
//! kernels). Never knows the language: `lower.rs` builds the graph, `tape.rs` runs it.
//!
//! Start at [`Graph::call`].

use std::collections::HashMap;

use crate::kernels::Kernel;

/// The most entries of a graph; what needs more is far too slow to be drawn.
const MOST_ENTRIES: usize = 1 << 16;

/// An entry of a graph, by its number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(crate) struct Id(pub(crate) u32);

/// What is known about an entry.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Entry {
    Call(Kernel, Vec<Id>),
    /// By its bits.
    Constant(u32),
    /// The position: 0 is x, 1 is y.
    Position(u8),
}

/// Entries, each after those that it needs.
#[derive(Debug)]
pub(crate) struct Graph {
    entries: Vec<Entry>,
    numbers: HashMap<Entry, Id>,
}

impl Graph {
    /// Both positions, x and y, and nothing else.
    pub(crate) fn new() -> (Graph, [Id; 2]) {
        let mut graph = Graph { entries: Vec::new(), numbers: HashMap::new() };
        let position = [0, 1].map(|axis| graph.add(Entry::Position(axis)));
        (graph, position)
    }

    pub(crate) fn entries(&self) -> &[Entry] {
        &self.entries
    }

    /// Whether something was left out because there was too much.
    pub(crate) fn is_full(&self) -> bool {
        self.entries.len() >= MOST_ENTRIES
    }

    /// Most bytes that it took, with those of the tape's making.
    pub(crate) fn bytes(&self) -> u64 {
        let is_call = |entry: &Entry| if let Entry::Call(_, arguments) = entry { arguments.len() } else { 0 };
        let arguments: usize = self.entries.iter().map(is_call).sum();
        // Tables grow by doubling, while the old half is still there; a hash table is at least twice as large as needed.
        let room = self.entries.len().next_power_of_two().max(8) * 3 / 2;
        let entry = size_of::<Entry>() + 2 * (size_of::<(Entry, Id)>() + 1) + 4 * size_of::<usize>();
        (room * entry + 2 * arguments * size_of::<Id>()) as u64
    }

    pub(crate) fn constant(&mut self, value: f32) -> Id {
        self.add(Entry::Constant((value + 0.0).to_bits()))
    }

    /// A kernel of other entries; a constant where all of them are.
    pub(crate) fn call(&mut self, kernel: Kernel, arguments: &[Id]) -> Id {
        let constants: Option<Vec<[f32; 1]>> = arguments.iter().map(|id| Some([self.value(*id)?])).collect();
        if let Some(constants) = constants {
            let arrays: Vec<&[f32]> = constants.iter().map(|constant| &constant[..]).collect();
            let mut result = [0.0];
            kernel.run(&arrays, &mut result);
            return self.constant(result[0]);
        }
        let mut arguments = arguments.to_vec();
        if kernel.commutes() {
            arguments.sort_unstable();
        }
        self.add(Entry::Call(kernel, arguments))
    }

    fn value(&self, id: Id) -> Option<f32> {
        match &self.entries[id.0 as usize] {
            Entry::Constant(bits) => Some(f32::from_bits(*bits)),
            Entry::Call(..) | Entry::Position(_) => None,
        }
    }

    fn add(&mut self, entry: Entry) -> Id {
        if let Some(id) = self.numbers.get(&entry) {
            return *id;
        }
        if self.is_full() {
            return Id(0);
        }
        let id = Id(self.entries.len() as u32);
        self.entries.push(entry.clone());
        self.numbers.insert(entry, id);
        id
    }
}
