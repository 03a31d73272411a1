//! A globe: what a file of agents says.
//!
//! Owns the genome and its limits. Text is `reader.rs` and `writer.rs`, motion `motion.rs`.
//!
//! Start at [`Globe`].

use crate::colour::Colour;
use crate::error::AgentsError;
use crate::reader;
use crate::shape::Shape;
use crate::writer;

/// Most bytes of a text.
pub const MOST_BYTES: usize = 64 * 1024;
/// Most agents of a globe.
pub const MOST_AGENTS: usize = 25;
/// Most segments of all agents of a globe.
pub const MOST_IN_A_GLOBE: usize = 60_000;
/// Most colours of a palette.
pub const MOST_COLOURS: usize = 16;
/// Most motes of dust.
pub const MOST_DUST: u32 = 400;
/// The brightest glow; 1 is usual.
pub const MOST_GLOW: f64 = 4.0;

/// A snow globe of agents.
#[derive(Clone, Debug, PartialEq)]
pub struct Globe {
    pub(crate) name: Option<String>,
    /// Top and bottom.
    pub(crate) background: [Colour; 2],
    /// 1 to 16 colours.
    pub(crate) palette: Vec<Colour>,
    /// Which paths the agents take.
    pub(crate) drift: u32,
    /// How bright the glow is.
    pub(crate) glow: f64,
    /// How many motes fall with the agents.
    pub(crate) dust: u32,
    /// The strings, without white space, as they were read.
    pub(crate) flock: Vec<String>,
    /// What each of them is.
    pub(crate) shapes: Vec<Shape>,
    pub(crate) kept: Kept,
}

/// What was read and is not known: TOML that is written again, and means nothing to pictures.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Kept {
    /// Keys before the head.
    pub(crate) before: String,
    /// Keys and tables in the head.
    pub(crate) head: String,
    /// Tables after it.
    pub(crate) after: String,
}

impl Globe {
    /// Reads a text.
    ///
    /// # Errors
    /// [`AgentsError`] says what is refused, and where.
    pub fn parse(text: &str) -> Result<Globe, AgentsError> {
        reader::read(text)
    }

    /// The agents' strings.
    pub fn flock(&self) -> &[String] {
        &self.flock
    }

    /// The same globe under another name.
    #[must_use]
    pub fn named(self, name: &str) -> Globe {
        Globe { name: Some(name.to_owned()), ..self }
    }

    /// Its file.
    pub(crate) fn written(&self) -> String {
        writer::written(self)
    }

    /// All that its pictures depend on, as text.
    pub(crate) fn essence(&self) -> String {
        writer::written(&Globe { name: None, kept: Kept::default(), ..self.clone() })
    }

    /// The colour of agent `number` and the colour of its tips, as linear light.
    pub(crate) fn colours(&self, number: usize) -> [[f32; 3]; 2] {
        let chosen = self.shapes[number].agent.c.map_or(number, |c| c as usize);
        [chosen, chosen + 1].map(|chosen| self.palette[chosen % self.palette.len()].light())
    }
}
