//! Who holds which scan-out buffer.
//!
//! Owns the life of a buffer: free, staged, pending, on the glass, free. Pure: never touches memory.
//! The rule that it keeps: a buffer is free only when the flip that *follows* its own has arrived.

/// The buffers of one output. Three suffice: one on the glass, one pending, one being filled.
#[derive(Debug)]
pub(crate) struct Ring<B> {
    buffers: Vec<B>,
    staged: Option<usize>,
    pending: Option<usize>,
    /// What may be on the glass, the newest last. More than one only after a flip event was lost.
    glass: Vec<usize>,
}

impl<B> Ring<B> {
    pub(crate) fn new(buffers: Vec<B>) -> Self {
        Self { buffers, staged: None, pending: None, glass: Vec::new() }
    }

    /// The buffer to fill: the staged one again, or a free one; `None` while none is free.
    pub(crate) fn stage(&mut self) -> Option<&mut B> {
        let free = |slot: &usize| Some(*slot) != self.pending && !self.glass.contains(slot);
        let slot = self.staged.or_else(|| (0..self.buffers.len()).find(free))?;
        self.staged = Some(slot);
        self.buffers.get_mut(slot)
    }

    /// Whether a buffer is staged.
    pub(crate) fn is_staged(&self) -> bool {
        self.staged.is_some()
    }

    /// Moves the staged buffer into the commit; without one, what is on the glass is committed again.
    pub(crate) fn commit(&mut self) -> Option<&B> {
        self.pending = self.pending.or_else(|| self.staged.take()).or_else(|| self.glass.last().copied());
        self.pending()
    }

    /// The buffer in the commit.
    pub(crate) fn pending(&self) -> Option<&B> {
        self.pending.map(|slot| &self.buffers[slot])
    }

    /// The flip has arrived: the pending buffer is on the glass, and it alone. Returns whether that is news, and not
    /// what was there before.
    pub(crate) fn flipped(&mut self) -> bool {
        let Some(slot) = self.pending.take() else { return false };
        let before = std::mem::replace(&mut self.glass, vec![slot]);
        before.last() != Some(&slot)
    }

    /// The flip's event was lost: the pending buffer is on the glass, but perhaps not yet alone.
    pub(crate) fn presume_flipped(&mut self) {
        if let Some(slot) = self.pending.take() {
            self.glass.retain(|&lit| lit != slot);
            self.glass.push(slot);
        }
    }

    pub(crate) fn into_buffers(self) -> Vec<B> {
        self.buffers
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::collections::BTreeSet;

    proptest! {
        #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

        #[test]
        fn what_may_be_on_the_glass_is_never_filled(steps in prop::collection::vec(0..4u8, 0..200)) {
            let mut ring = Ring::new(vec![0, 1, 2]);
            for step in steps {
                match step {
                    0 => {
                        let lit: BTreeSet<_> = ring.glass.iter().copied().chain(ring.pending).collect();
                        if let Some(&mut filled) = ring.stage() {
                            prop_assert!(!lit.contains(&filled));
                        } else {
                            prop_assert_eq!(lit.len(), 3);
                        }
                    }
                    1 => drop(ring.commit()),
                    2 => drop(ring.flipped()),
                    _ => ring.presume_flipped(),
                }
            }
        }
    }

    #[test]
    fn there_is_always_a_buffer_to_fill_while_no_event_is_lost() {
        let mut ring = Ring::new(vec!['a', 'b', 'c']);
        for _ in 0..10 {
            assert!(ring.stage().is_some());
            ring.commit();
            assert!(ring.stage().is_some());
            ring.flipped();
        }
    }

    #[test]
    fn a_commit_with_nothing_staged_lights_the_same_picture_again() {
        let mut ring = Ring::new(vec!['a', 'b', 'c']);
        assert_eq!(ring.commit(), None);
        ring.stage();
        assert_eq!(ring.commit(), Some(&'a'));
        assert!(ring.flipped());
        assert_eq!(ring.commit(), Some(&'a'));
        assert!(!ring.flipped());
        assert_eq!(ring.stage(), Some(&mut 'b'));
    }
}
