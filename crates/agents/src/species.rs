//! Agents as a kind of sheep.
//!
//! Owns the species, and what a globe is to those who know no species. Never draws by itself.
//!
//! Start at [`Agents`].

use ::species::{
    Breed, Child, Genome, Lineage, Motion, Operator, Recipe, Refusal, Rng, Settings, Species, UNCHANGED, descended,
};

use crate::breed;
use crate::globe::{Globe, MOST_BYTES};
use crate::motion::{Transition, Turning};
use crate::picture::{Drawing, moments};

/// The version of the pictures: it rises when a globe looks otherwise than before.
pub const VERSION: u32 = 1;

/// L-system agents after Langdon's Pfeiffer.
#[derive(Clone, Copy, Debug, Default)]
pub struct Agents;

impl Species for Agents {
    fn name(&self) -> &'static str {
        "a globe of agents"
    }

    fn ending(&self) -> &'static str {
        "agents"
    }

    fn begins(&self, text: &str) -> bool {
        let is_said = |line: &&str| !line.is_empty() && !line.starts_with('#');
        let text = text.trim_start_matches('\u{feff}');
        let first = text.lines().map(str::trim).find(is_said).unwrap_or_default();
        let has_head = || toml::de::DeTable::parse(text).is_ok_and(|root| root.get_ref().contains_key("agents"));
        first.starts_with("[agents]") || (text.len() <= MOST_BYTES && !first.starts_with(['<', '(']) && has_head())
    }

    fn parse(&self, text: &str) -> Result<Box<dyn Genome>, Refusal> {
        Ok(Box::new(Globe::parse(text)?))
    }
}

impl Breed for Agents {
    fn operators(&self) -> &'static [Operator] {
        breed::OPERATORS
    }

    fn random(&self, rng: &mut Rng) -> Box<dyn Genome> {
        Box::new(breed::random(rng))
    }

    fn mutate(&self, parent: &dyn Genome, strength: f64, rng: &mut Rng) -> Option<Child> {
        let globe: &Globe = parent.as_any().downcast_ref()?;
        Some(match breed::mutated(globe, strength, rng) {
            Some((child, how)) => descended(&child, how, &[parent]),
            None => (Box::new(globe.clone()), UNCHANGED),
        })
    }

    fn cross(&self, parents: [&dyn Genome; 2], rng: &mut Rng) -> Option<Child> {
        let [a, b] = parents.map(|parent| parent.as_any().downcast_ref::<Globe>());
        Some(descended(&breed::crossed(a?, b?, rng), breed::CROSSED, &parents))
    }

    fn apply(&self, name: &str, parents: &[&dyn Genome], strength: f64, rng: &mut Rng) -> Option<Child> {
        let operator = self.operator(name)?;
        match parents {
            [a, b] if operator.parents == 2 => self.cross([*a, *b], rng),
            [parent] => {
                let child = breed::mutated_by(operator.name, parent.as_any().downcast_ref()?, strength, rng)?;
                Some(descended(&child, operator.name, parents))
            }
            _ => None,
        }
    }
}

impl Genome for Globe {
    fn name(&self) -> Option<&str> {
        self.name.as_deref()
    }

    fn text(&self) -> String {
        self.written()
    }

    fn lineage(&self) -> Lineage {
        self.origin()
    }

    fn with_lineage(&self, lineage: &Lineage) -> Box<dyn Genome> {
        Box::new(self.with_origin(lineage))
    }

    fn recipe(&self, settings: &Settings) -> Recipe {
        let genome = self.essence();
        Recipe::of_moments(format!("agents {VERSION}"), settings, moments(settings), genome)
    }

    fn turning(&self, _size: [u32; 2], frames: f64) -> Box<dyn Motion> {
        Box::new(Drawing(Turning::new(self, frames)))
    }

    fn transition(&self, to: &dyn Genome, _: [u32; 2], turns: [f64; 2], frames: f64) -> Option<Box<dyn Motion>> {
        let to: &Globe = to.as_any().downcast_ref()?;
        let sides = (Turning::new(self, turns[0]), Turning::new(to, turns[1]));
        Some(Box::new(Drawing(Transition::new(sides.0, sides.1, frames))))
    }
}
