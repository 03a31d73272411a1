//! What of a flock's genomes is not drawn.
//!
//! Owns the look at all genomes of a flock, and when one that is refused is a fault: while a clip is missing that only it
//! could give. A file that is missing or torn is named, too; the missing clip is the fault then.
//!
//! Start at [`undrawn`].

use std::collections::HashSet;
use std::path::Path;

use flame::genome::{Reasons, Unsupported};
use flock::{ClipPath, Fault, FaultKind, Manifest, Sheep, SheepId};
use rayon::iter::{IntoParallelRefIterator, ParallelIterator};
use serde::Serialize;

use crate::program::chain;
use crate::program::reasons::serialize;
use crate::species::{self, reasons};

/// A genome of which something is not drawn.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct UndrawnGenome {
    /// Its sheep.
    pub sheep: SheepId,
    /// Its file.
    pub genome: ClipPath,
    /// For this it is refused.
    #[serde(skip_serializing_if = "Reasons::is_empty", serialize_with = "serialize")]
    pub refused: Reasons,
    /// It is drawn without this.
    #[serde(skip_serializing_if = "Reasons::is_empty", serialize_with = "serialize")]
    pub without: Reasons,
    /// Why its file is no genome, or cannot be read.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unusable: Option<String>,
}

/// The genomes of the flock in `folder` of which something is not drawn, in the order of the manifest.
pub fn undrawn(folder: &Path, manifest: &Manifest) -> Vec<UndrawnGenome> {
    undrawn_by(folder, manifest, |path| {
        let text = species::text(path).map_err(|why| chain(&*why.source))?;
        reasons::of_text(path, &text)
    })
}

/// The same, where `of_file` knows what of the genome in a file is not drawn, or why there is none.
pub fn undrawn_by(
    folder: &Path,
    manifest: &Manifest,
    of_file: impl Fn(&Path) -> Result<Unsupported, String> + Sync,
) -> Vec<UndrawnGenome> {
    let of_sheep = |sheep: &Sheep| {
        let genome = sheep.genome.clone()?;
        let (found, unusable) = match of_file(&genome.inside(folder)) {
            Ok(found) => (found, None),
            Err(why) => (Unsupported::default(), Some(why)),
        };
        let Unsupported { refused, without } = found;
        let is_drawn = refused.is_empty() && without.is_empty() && unusable.is_none();
        (!is_drawn).then(|| UndrawnGenome { sheep: sheep.id.clone(), genome, refused, without, unusable })
    };
    manifest.sheep.par_iter().filter_map(of_sheep).collect()
}

/// The faults among `genomes` of the flock in `folder`.
pub fn faults(folder: &Path, manifest: &Manifest, genomes: &[UndrawnGenome]) -> Vec<Fault> {
    if genomes.iter().all(|genome| genome.refused.is_empty()) {
        return Vec::new();
    }
    let mut wanted: HashSet<&SheepId> = HashSet::new();
    let is_missing = |path: &ClipPath| !path.inside(folder).exists();
    let loops = manifest.sheep.iter().filter(|sheep| sheep.clip.as_ref().is_some_and(|clip| is_missing(&clip.path)));
    wanted.extend(loops.map(|sheep| &sheep.id));
    for transition in manifest.transitions.iter().filter(|transition| is_missing(&transition.clip.path)) {
        wanted.extend([&transition.from, &transition.to]);
    }
    let is_fault = |own: &&UndrawnGenome| !own.refused.is_empty() && wanted.contains(&own.sheep);
    genomes.iter().filter(is_fault).map(UndrawnGenome::fault).collect()
}

impl UndrawnGenome {
    /// What is not drawn, in sentences.
    pub fn sentences(&self) -> impl Iterator<Item = String> {
        let Self { sheep, genome, refused, without, unusable } = self;
        let unusable = unusable.as_ref().map(|why| format!("genome `{genome}` of sheep `{sheep}` is unusable: {why}"));
        let refusal = || format!("genome `{genome}` of sheep `{sheep}` cannot be drawn: {}", reasons::refusal(refused));
        let omission = || format!("genome `{genome}` of sheep `{sheep}` is drawn without {without}");
        let refusal = (!refused.is_empty()).then(refusal);
        unusable.into_iter().chain(refusal).chain((!without.is_empty()).then(omission))
    }

    fn fault(&self) -> Fault {
        let message = self.sentences().next().unwrap_or_default();
        let sheep = Some(self.sheep.clone());
        Fault { kind: FaultKind::UndrawnGenome, sheep, from: None, to: None, clip: None, message }
    }
}
