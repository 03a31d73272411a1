//! Expressions as a species: what those see who know no expression.
//!
//! Owns what the settings of all species mean for expressions, and what pictures depend on. Never draws: `picture.rs` does.
//!
//! Start at [`Expressions`].

use ::species::{Demand, Drawn, Light, Lineage, Motion, Recipe, Refusal, RenderError, Species, Threads, expected};

use crate::dissolve::{LEAST_SHARED, Transition};
use crate::error::ExpressionError;
use crate::genome::Genome;
use crate::motion::{Loop, Moving};
use crate::picture::{Settings, cost, render};
use crate::tile::Samples;

/// The version of the renderer: it rises whenever the picture of an expression changes, even by a bit.
pub const VERSION: u32 = 1;

/// How such a file begins, whatever its name is.
const BEGINS: &str = "(expression";

/// From so many samples per pixel on, there are more where they are needed.
const ADAPTIVE: f64 = 16.0;

/// Less contrast than this part of what is expected between two loops is dull.
const LEAST_CONTRAST: f64 = 0.65;

/// The species of expressions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Expressions;

impl Species for Expressions {
    fn name(&self) -> &'static str {
        "an expression"
    }

    fn ending(&self) -> &'static str {
        "expr"
    }

    fn begins(&self, text: &str) -> bool {
        // A comment may stand before it.
        let is_code = |line: &&str| !line.is_empty() && !line.starts_with(';');
        text.lines().map(str::trim_start).find(is_code).is_some_and(|line| line.starts_with(BEGINS))
    }

    fn parse(&self, text: &str) -> Result<Box<dyn ::species::Genome>, Refusal> {
        Ok(Box::new(Genome::parse(text)?))
    }
}

impl ::species::Genome for Genome {
    fn name(&self) -> Option<&str> {
        self.name.as_deref()
    }

    fn text(&self) -> String {
        self.to_string()
    }

    fn lineage(&self) -> Lineage {
        self.origin()
    }

    fn with_lineage(&self, lineage: &Lineage) -> Box<dyn ::species::Genome> {
        Box::new(self.with_origin(lineage))
    }

    fn recipe(&self, settings: &::species::Settings) -> Recipe {
        let Settings { size: [width, height], samples, is_blurred } = settings.into();
        let blur = if is_blurred && samples != Samples::One { "blurred" } else { "sharp" };
        Recipe {
            version: format!("expression {VERSION}"),
            settings: format!("{width}x{height} {} {blur}", samples.name()),
            genome: Genome { name: None, unknown: Vec::new(), ..self.clone() }.to_string(),
        }
    }

    fn turning(&self, _size: [u32; 2], frames: f64) -> Box<dyn Motion> {
        Box::new(Loop::new(self, frames))
    }

    fn transition(
        &self,
        to: &dyn ::species::Genome,
        _size: [u32; 2],
        turns: [f64; 2],
        frames: f64,
    ) -> Option<Box<dyn Motion>> {
        let to: &Genome = to.as_any().downcast_ref()?;
        let way = Transition::new(&Loop::new(self, turns[0]), &Loop::new(to, turns[1]), frames);
        let is_good = way.shared() >= LEAST_SHARED && keeps_contrast(&way, frames).unwrap_or(false);
        if is_good { Some(Box::new(way)) } else { None }
    }
}

/// Whether the pictures of `way` have contrast enough between its loops. Where they have not, a dissolve of pictures is
/// better, which restores it. Few small pictures tell: a flock has thousands of transitions.
fn keeps_contrast(way: &Transition, frames: f64) -> Result<bool, RenderError> {
    let threads = Threads::new(1).map_err(|error| RenderError::Refused(error.into()))?;
    let contrast = |moving: &dyn Moving, frame: f64| {
        let settings = Settings { size: [64, 36], samples: Samples::One, is_blurred: false };
        Ok::<f64, RenderError>(Light::of(&render(moving, frame, &settings, &threads)?.0).contrast)
    };
    let [from, to] = way.loops();
    for part in [0.2, 0.35, 0.5, 0.65, 0.8] {
        let frame = part * frames;
        let ends = [contrast(from, frame)?, contrast(to, frame - frames)?];
        if contrast(way, frame)? < LEAST_CONTRAST * expected(ends, part) {
            return Ok(false);
        }
    }
    Ok(true)
}

impl From<&::species::Settings> for Settings {
    /// Pictures have no noise, so nothing else is heeded.
    fn from(settings: &::species::Settings) -> Settings {
        let samples = match (settings.psnr, settings.spp) {
            (None, Some(spp)) if spp < ADAPTIVE => {
                if spp > 1.0 {
                    Samples::Sixteen
                } else {
                    Samples::One
                }
            }
            _ => Samples::Adaptive,
        };
        Settings { size: settings.size, samples, is_blurred: settings.temporal_samples != Some(1) }
    }
}

impl Motion for Loop {
    fn demand(&self, frame: f64, settings: &::species::Settings) -> Result<Demand, RenderError> {
        demand(self, frame, settings)
    }

    fn frame(&self, frame: f64, settings: &::species::Settings, threads: &Threads) -> Result<Drawn, RenderError> {
        drawn(self, frame, settings, threads)
    }
}

impl Motion for Transition {
    fn demand(&self, frame: f64, settings: &::species::Settings) -> Result<Demand, RenderError> {
        demand(self, frame, settings)
    }

    fn frame(&self, frame: f64, settings: &::species::Settings, threads: &Threads) -> Result<Drawn, RenderError> {
        drawn(self, frame, settings, threads)
    }
}

fn demand(moving: &dyn Moving, frame: f64, settings: &::species::Settings) -> Result<Demand, RenderError> {
    let refused = |error: ExpressionError| RenderError::Refused(error.into());
    Ok(cost(moving, frame, &settings.into()).map_err(refused)?.into())
}

fn drawn(
    moving: &dyn Moving,
    frame: f64,
    settings: &::species::Settings,
    threads: &Threads,
) -> Result<Drawn, RenderError> {
    let (image, samples) = render(moving, frame, &settings.into(), threads)?;
    Ok(Drawn { image, samples, psnr: None })
}
