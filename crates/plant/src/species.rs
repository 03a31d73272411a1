//! Plants as a species.
//!
//! Owns what the contract asks of this species: its name, its files, its recipe. Never grows anything itself.
//!
//! Start at [`Plants`].

use species::{Genome, Lineage, Motion, Recipe, Refusal, Settings, Species};

use crate::genome::Plant;
use crate::motion::{Loop, Transition};
use crate::picture::moments;

/// The version of the pictures: another one where the same genome has other pixels.
pub const VERSION: u32 = 1;

/// The species of plants.
#[derive(Clone, Copy, Debug, Default)]
pub struct Plants;

impl Species for Plants {
    fn name(&self) -> &'static str {
        "a plant"
    }

    fn ending(&self) -> &'static str {
        "plant"
    }

    /// Whether the first table of the text is `[plant]`.
    fn begins(&self, text: &str) -> bool {
        let mut lines = text.trim_start_matches('\u{feff}').lines().map(str::trim_start);
        lines.find(|line| line.starts_with('[')).is_some_and(|line| {
            let head = line.split('#').next().unwrap_or_default().trim_end();
            head.trim_start_matches('[').trim_end_matches(']').trim() == "plant" && !head.starts_with("[[")
        })
    }

    fn parse(&self, text: &str) -> Result<Box<dyn Genome>, Refusal> {
        Ok(Box::new(Plant::parse(text)?))
    }
}

impl Genome for Plant {
    fn name(&self) -> Option<&str> {
        self.name.as_deref()
    }

    fn text(&self) -> String {
        self.to_toml()
    }

    fn lineage(&self) -> Lineage {
        self.origin()
    }

    fn with_lineage(&self, lineage: &Lineage) -> Box<dyn Genome> {
        Box::new(self.with_origin(lineage))
    }

    fn recipe(&self, settings: &Settings) -> Recipe {
        let genome = self.drawn_toml();
        Recipe::of_moments(format!("plant {VERSION}"), settings, moments(settings), genome)
    }

    fn turning(&self, _size: [u32; 2], frames: f64) -> Box<dyn Motion> {
        Box::new(Loop::new(self, frames))
    }

    fn transition(&self, to: &dyn Genome, _size: [u32; 2], turns: [f64; 2], frames: f64) -> Option<Box<dyn Motion>> {
        let to = to.as_any().downcast_ref::<Plant>()?;
        Some(Box::new(Transition::new(Loop::new(self, turns[0]), Loop::new(to, turns[1]), frames)))
    }
}
