//! The keys that edits change in entries of the text.
//!
//! Owns their list, which is short of bytes: a balance may change a million weights. What becomes of their values stands in
//! the contents; `place.rs` writes them.
//!
//! Start at [`Changes::of`].

use super::Kind;

/// The changes of every entry of the text: a bit for each key, by its place in the order of writing.
#[derive(Debug)]
pub(super) struct Changes {
    sheep: Vec<u8>,
    transitions: Vec<u8>,
}

impl Changes {
    /// None yet, in a text with so many entries.
    pub(super) fn none(sheep: usize, transitions: usize) -> Self {
        Self { sheep: vec![0; sheep], transitions: vec![0; transitions] }
    }

    /// Adds a change of the key at place `key`, in the entry of `kind` at `entry`.
    pub(super) fn put(&mut self, kind: Kind, entry: u32, key: usize) {
        let entries = match kind {
            Kind::Sheep => &mut self.sheep,
            Kind::Transition => &mut self.transitions,
        };
        entries[entry as usize] |= 1 << key;
    }

    /// The keys that are changed in the entry of `kind` at `entry`, in the order of writing.
    pub(super) fn of(&self, kind: Kind, entry: u32) -> impl Iterator<Item = usize> + use<> {
        let keys = self.entries(kind)[entry as usize];
        (0..kind.keys().len()).filter(move |key| keys & 1 << key != 0)
    }

    /// How many keys are changed in entries of `kind`.
    pub(super) fn count(&self, kind: Kind) -> usize {
        self.entries(kind).iter().map(|keys| keys.count_ones() as usize).sum()
    }

    /// How many entries of `kind` the text has.
    pub(super) fn entry_count(&self, kind: Kind) -> usize {
        self.entries(kind).len()
    }

    fn entries(&self, kind: Kind) -> &[u8] {
        match kind {
            Kind::Sheep => &self.sheep,
            Kind::Transition => &self.transitions,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_are_listed_once_and_in_the_order_of_writing() {
        let mut changes = Changes::none(8, 8);
        for (entry, key) in [(7, 6), (3, 2), (7, 6), (7, 0)] {
            changes.put(Kind::Sheep, entry, key);
        }
        changes.put(Kind::Transition, 7, 1);
        let listed = |kind, entry| changes.of(kind, entry).collect::<Vec<_>>();
        assert_eq!([3, 4, 7].map(|entry| listed(Kind::Sheep, entry)), [vec![2], vec![], vec![0, 6]]);
        assert_eq!((listed(Kind::Transition, 7), changes.count(Kind::Sheep)), (vec![1], 3));
    }
}
