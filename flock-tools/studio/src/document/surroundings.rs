//! What lies beside the manifest, as the document asks for it.
//!
//! Owns the questions; the tools answer them, since they know genomes, clips and credits.

use flock::{Clip, Manifest, Sheep, SheepId};

use super::notes::MarkKind;
use super::requests::EditRequest;

/// Answers what lies beside the manifest. Every error is a sentence for the artist.
pub(crate) trait Surroundings: Send + Sync {
    /// The candidate `id` as the sheep that it would be in the flock of `manifest`. Writes nothing.
    /// Errors: If there is no such candidate, or its genome cannot be read.
    fn candidate(&self, id: &SheepId, manifest: &Manifest) -> Result<Sheep, String>;

    /// Has the files of `sheep`, which was a candidate, lie in the flock's folder. Called before the manifest is saved.
    /// Errors: If another file is in their place, or the disk refuses.
    fn place(&self, sheep: &Sheep) -> Result<(), String>;

    /// The clip of a new transition in the flock of `manifest`: `clip`, or, if its file is there already, that file's frames
    /// and hash. Writes nothing.
    /// Errors: If the file that is there has another form.
    fn clip(&self, clip: Clip, manifest: &Manifest) -> Result<Clip, String>;

    /// The text of the credits after `edits`, which led from the manifest `before` to `after`; `text` is the one before.
    /// Called if the flock has credits, and something was dropped, unlinked or renamed.
    /// Errors: If the credits are malformed.
    fn credits(&self, text: &str, edits: &[EditRequest], before: &Manifest, after: &Manifest)
    -> Result<String, String>;

    /// How the pool has marked its sheep `id`; `None` of a sheep that is in no pool.
    fn mark(&self, id: &SheepId) -> Option<MarkKind>;

    /// Has the pool mark sheep of its own, all or none.
    /// Errors: If the pool cannot be changed: another program has it open, or the disk refuses.
    fn set_marks(&self, marks: &[(SheepId, MarkKind)]) -> Result<(), String>;
}
