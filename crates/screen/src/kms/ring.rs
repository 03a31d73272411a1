//! Who holds which scan-out buffer.
//!
//! Owns the life of a buffer: free, staged, pending, on the screen, free. Pure. Its rule: a buffer is free only when the
//! flip that *follows* its own has arrived.

/// The buffers of one output. Three suffice: one on the screen, one pending, one being filled.
#[derive(Debug)]
pub(crate) struct Ring<B> {
    buffers: Vec<B>,
    staged: Option<usize>,
    pending: Option<usize>,
    /// The buffers that may be on the screen, the newest last. More than one only after a flip event was lost.
    on_screen: Vec<usize>,
}

impl<B> Ring<B> {
    pub(crate) fn new(buffers: Vec<B>) -> Self {
        Self { buffers, staged: None, pending: None, on_screen: Vec::new() }
    }

    /// The buffer to fill: the staged one again, or a free one; `None` while none is free.
    pub(crate) fn stage(&mut self) -> Option<&mut B> {
        let free = |index: &usize| Some(*index) != self.pending && !self.on_screen.contains(index);
        let index = self.staged.or_else(|| (0..self.buffers.len()).find(free))?;
        self.staged = Some(index);
        self.buffers.get_mut(index)
    }

    /// Whether a buffer is staged.
    pub(crate) fn is_staged(&self) -> bool {
        self.staged.is_some()
    }

    /// Moves the staged buffer into the commit; without one, the buffer on the screen is committed again.
    pub(crate) fn commit(&mut self) -> Option<&B> {
        self.pending = self.pending.or_else(|| self.staged.take()).or_else(|| self.on_screen.last().copied());
        self.pending()
    }

    /// The buffer in the commit.
    pub(crate) fn pending(&self) -> Option<&B> {
        self.pending.map(|index| &self.buffers[index])
    }

    /// The flip has arrived: only the pending buffer is on the screen. Returns whether it is a new picture.
    pub(crate) fn flipped(&mut self) -> bool {
        let Some(index) = self.pending.take() else { return false };
        let before = std::mem::replace(&mut self.on_screen, vec![index]);
        before.last() != Some(&index)
    }

    /// The flip's event was lost: the pending buffer is on the screen, and perhaps the one before it, too.
    pub(crate) fn presume_flipped(&mut self) {
        if let Some(index) = self.pending.take() {
            self.on_screen.retain(|&lit| lit != index);
            self.on_screen.push(index);
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
                        let lit: BTreeSet<_> = ring.on_screen.iter().copied().chain(ring.pending).collect();
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
