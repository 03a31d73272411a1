//! How candidates are made and looked at.
//!
//! Owns the step from a planned birth to a genome by the operators of its species, and from a genome to its figures. Never
//! chooses parents and never judges: the package `breeding` does.
//!
//! Start at [`Candidates`].

use std::collections::BTreeMap;

use ::breeding::{Birth, Born, Id, Made, Nursery, Operation, Stamp, Traits};
use flame::Backend;
use species::{Breed, FigureFault, Figures, Genome, Lineage, Motion, RenderError, Rng, Threads, UNCHANGED};

use crate::credits::OURS;
use crate::species::all;

/// The loop by which candidates are judged: its frames.
pub const FRAMES: f64 = 384.0;
/// The size that its pictures have the shape of.
pub const SIZE: [u32; 2] = [1280, 720];

/// How a stranger is made.
const RANDOM: &str = "random";
/// How a sheep came whose genome was brought in.
pub const IMPORT: &str = "import";

/// What is wrong with a genome that is not drawn.
pub const REFUSED: &str = "refused";

/// What makes the candidates of a brood.
pub struct Candidates {
    /// The genomes of all sheep that may be parents.
    parents: BTreeMap<Id, Box<dyn Genome>>,
    /// The genomes that wait to be born.
    waiting: BTreeMap<Stamp, Box<dyn Genome>>,
    /// The operator that makes all of them; by chance where `None`.
    operator: Option<String>,
    /// The species.
    species: Vec<Box<dyn Breed>>,
}

impl Candidates {
    /// With these parents, and genomes that wait.
    pub fn new(
        parents: BTreeMap<Id, Box<dyn Genome>>,
        waiting: BTreeMap<Stamp, Box<dyn Genome>>,
        operator: Option<String>,
    ) -> Self {
        Self { parents, waiting, operator, species: all(&Backend::default()).into() }
    }

    fn child(&self, birth: &Birth, rng: &mut Rng) -> Option<(Box<dyn Genome>, &'static str)> {
        if let Some(since) = &birth.waited {
            let genome = self.waiting.get(since)?;
            return Some((genome.with_lineage(&genome.lineage()), IMPORT));
        }
        let species = self.species.iter().find(|species| species.ending() == birth.species)?;
        let parents: Option<Vec<&dyn Genome>> =
            birth.parents.iter().map(|id| self.parents.get(id).map(|genome| &**genome)).collect();
        let parents = parents?;
        match (birth.operation, &self.operator, &parents[..]) {
            (Operation::Stranger, ..) => {
                let genome = species.random(rng);
                let licence = Some(OURS.to_owned());
                Some((genome.with_lineage(&Lineage { licence, ..genome.lineage() }), RANDOM))
            }
            (_, Some(name), parents) => species.apply(name, parents, birth.amount, rng),
            (Operation::Mutation, None, [parent]) => species.mutate(*parent, birth.amount, rng),
            (Operation::Cross, None, [first, second]) => species.cross([*first, *second], rng),
            _ => None,
        }
    }
}

impl Nursery for Candidates {
    type Candidate = Box<dyn Genome>;

    fn candidate(&self, birth: &Birth, rng: &mut Rng) -> Option<Made<Self::Candidate>> {
        let (candidate, operator) = self.child(birth, rng).filter(|(_, operator)| *operator != UNCHANGED)?;
        let licence = candidate.lineage().licence.unwrap_or_default();
        Some(Made { candidate, operator: operator.to_owned(), licence })
    }

    fn sketch(&self, candidate: &Self::Candidate) -> Result<Traits, Vec<String>> {
        judged(&**candidate, Figures::sketched)
    }

    fn figures(&self, candidate: &Self::Candidate) -> Result<Traits, Vec<String>> {
        // Most of what is wrong shows in a sketch, which takes a fifth.
        self.sketch(candidate)?;
        judged(&**candidate, Figures::of)
    }
}

/// How figures of a loop are found: in so many frames, for pictures of a size.
type Measure = fn(&dyn Motion, f64, [u32; 2], &Threads) -> Result<Figures, RenderError>;

/// The figures of a genome by `measure`, or what is wrong with it.
pub fn judged(genome: &dyn Genome, measure: Measure) -> Result<Traits, Vec<String>> {
    let figures = measured(genome, measure).map_err(|_| vec![REFUSED.to_owned()])?;
    match figures.faults()[..] {
        [] => Ok(traits(&figures)),
        ref faults => Err(faults.iter().map(|fault| FigureFault::name(*fault).to_owned()).collect()),
    }
}

/// The figures of a genome's loop.
/// Errors: [`RenderError`] if it is not drawn.
pub fn figures(genome: &dyn Genome) -> Result<Figures, RenderError> {
    measured(genome, Figures::of)
}

fn measured(genome: &dyn Genome, measure: Measure) -> Result<Figures, RenderError> {
    let threads = Threads::new(1).map_err(|error| RenderError::Refused(error.into()))?;
    measure(&*genome.turning(SIZE, FRAMES), FRAMES, SIZE, &threads)
}

/// Figures as a pool keeps them.
pub fn traits(figures: &Figures) -> Traits {
    Traits::new(&figures.compared())
}

/// The text of the file of a sheep that is born, which says where it comes from.
pub fn text(born: &Born, genome: &dyn Genome) -> String {
    let lineage = Lineage {
        id: Some(born.id.to_string()),
        parents: born.parents.iter().map(ToString::to_string).collect(),
        operator: Some(born.operator.clone()),
        ..genome.lineage()
    };
    genome.with_lineage(&lineage).text()
}
