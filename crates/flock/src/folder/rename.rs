//! A sheep's new id, with the names of its files.
//!
//! Owns which paths follow: those that are named after the sheep. Never touches the files themselves.
//!
//! Start at [`Edit::rename_with_files`].

use std::collections::BTreeMap;

use super::paths;
use crate::edit::{Edit, EditError};
use crate::manifest::{Clip, ClipPath, SheepId};

impl Edit {
    /// Gives the sheep `old` the id `new`, as [`Edit::rename`], and renames the paths of its files that are named after
    /// `old`. Returns them: each path that was, with the one that is.
    ///
    /// # Errors
    /// Those of [`Edit::rename`].
    pub fn rename_with_files(
        &mut self,
        old: &SheepId,
        new: &SheepId,
    ) -> Result<BTreeMap<ClipPath, ClipPath>, EditError> {
        self.rename(old, new)?;
        let mut moves = BTreeMap::new();
        let mut renamed = |path: &ClipPath| {
            let to = paths::renamed(path, old, new)?;
            moves.insert(path.clone(), to.clone());
            Some(to)
        };
        let mut moved = |clip: &Clip| Some(Clip { path: renamed(&clip.path)?, ..clip.clone() });
        let manifest = self.shared_manifest();
        for sheep in manifest.sheep.iter().filter(|sheep| sheep.id == *new) {
            if let Some(clip) = sheep.clip.as_ref().and_then(&mut moved) {
                self.set_loop(new, clip)?;
            }
        }
        for t in manifest.transitions.iter().filter(|t| t.from == *new || t.to == *new) {
            if let Some(clip) = moved(&t.clip) {
                self.set_transition_clip(&t.from, &t.to, clip)?;
            }
        }
        for genome in manifest.sheep.iter().filter(|sheep| sheep.id == *new).filter_map(|sheep| sheep.genome.as_ref()) {
            if let Some(genome) = renamed(genome) {
                self.set_genome(new, genome)?;
            }
        }
        Ok(moves)
    }
}
