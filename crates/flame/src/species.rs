//! Flames as a species.
//!
//! Owns what the contract of `species` means for flames: what of a genome changes a picture, its loop, its transitions with
//! their exposure, and which settings a flame heeds. Never draws: `render` does.
//!
//! Start at [`Flames`].

use std::sync::{Mutex, PoisonError};

use species::{Demand, Drawn, Lineage, Recipe, Refusal, Threads};

use crate::animate::{Loop, Motion, Transition};
use crate::exposure::{Exposed, Exposure};
use crate::genome::Genome;
use crate::render::{Arithmetic, Backend, Filter, FrameCost, Measured, RenderError, Settings, VERSION, draw_frame};

/// The species.
#[derive(Clone, Debug)]
pub struct Flames {
    /// What draws the samples of frames.
    pub backend: Backend,
    /// What gives a genome the colours that it only names.
    pub coloured: fn(Genome) -> Result<Genome, Refusal>,
}

/// A flame with what draws it.
#[derive(Clone, Debug)]
pub struct Flame {
    genome: Genome,
    backend: Backend,
}

/// The loop of a flame.
#[derive(Debug)]
struct FlameLoop {
    motion: Loop,
    backend: Backend,
}

/// The transition between two flames. Its exposure is measured when the first frame between its ends is drawn.
#[derive(Debug)]
struct FlameTransition {
    loops: [Loop; 2],
    motion: Transition,
    frames: f64,
    exposure: Mutex<Option<Exposure>>,
    backend: Backend,
}

impl Flame {
    /// A genome that has its colours.
    pub fn new(genome: Genome, backend: Backend) -> Flame {
        Flame { genome, backend }
    }

    /// Its genome.
    pub fn genome(&self) -> &Genome {
        &self.genome
    }

    /// Its loop. All of a flock have cameras of one size, so that a transition between genomes of two sizes has no jump half
    /// way.
    fn motion(&self, size: [u32; 2], frames: f64) -> Loop {
        Loop::new(&drawn_of(&self.genome, size), frames)
    }
}

/// `genome` in pictures of `size`, without what changes none.
fn drawn_of(genome: &Genome, size: [u32; 2]) -> Genome {
    let camera = genome.camera.resized(size);
    let (extra, children) = genome.drawn_parts();
    Genome { camera, name: None, extra, children, ..genome.clone() }
}

impl species::Species for Flames {
    fn name(&self) -> &'static str {
        "a flame"
    }

    fn ending(&self) -> &'static str {
        "flam3"
    }

    fn begins(&self, text: &str) -> bool {
        text.trim_start_matches(['\u{feff}', ' ', '\t', '\r', '\n']).starts_with('<')
    }

    fn parse(&self, text: &str) -> Result<Box<dyn species::Genome>, Refusal> {
        let genome = (self.coloured)(Genome::parse(text)?)?;
        Ok(Box::new(Flame::new(genome, self.backend.clone())))
    }
}

impl species::Genome for Flame {
    fn name(&self) -> Option<&str> {
        self.genome.name.as_deref()
    }

    fn made_for(&self) -> Option<[u32; 2]> {
        Some(self.genome.camera.size)
    }

    fn text(&self) -> String {
        self.genome.to_xml()
    }

    fn lineage(&self) -> Lineage {
        self.genome.lineage()
    }

    fn with_lineage(&self, lineage: &Lineage) -> Box<dyn species::Genome> {
        Box::new(Flame::new(self.genome.with_lineage(lineage), self.backend.clone()))
    }

    fn recipe(&self, settings: &species::Settings) -> Recipe {
        Recipe {
            version: format!("light {VERSION}"),
            settings: format!("{:?}", Settings::from(settings)),
            genome: drawn_of(&self.genome, settings.size).to_xml(),
        }
    }

    fn turning(&self, size: [u32; 2], frames: f64) -> Box<dyn species::Motion> {
        Box::new(FlameLoop { motion: self.motion(size, frames), backend: self.backend.clone() })
    }

    fn transition(
        &self,
        to: &dyn species::Genome,
        size: [u32; 2],
        turns: [f64; 2],
        frames: f64,
    ) -> Option<Box<dyn species::Motion>> {
        let to = to.as_any().downcast_ref::<Flame>()?;
        let loops = [self.motion(size, turns[0]), to.motion(size, turns[1])];
        let motion = Transition::new(&loops[0], &loops[1], frames);
        let (exposure, backend) = (Mutex::new(None), self.backend.clone());
        Some(Box::new(FlameTransition { loops, motion, frames, exposure, backend }))
    }
}

impl FlameTransition {
    /// Its exposure. The first call measures it, in half a second; others wait for it.
    fn exposure(&self, threads: &Threads) -> Result<Exposure, RenderError> {
        let mut exposure = self.exposure.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(measured) = &*exposure {
            return Ok(measured.clone());
        }
        let measured = Exposure::measure(&self.motion, self.frames, threads)?;
        Ok(exposure.insert(measured).clone())
    }
}

impl species::Motion for FlameLoop {
    fn demand(&self, frame: f64, settings: &species::Settings) -> Result<Demand, species::RenderError> {
        drawable(&self.motion)?;
        demand(&self.motion, frame, settings)
    }

    fn frame(
        &self,
        frame: f64,
        settings: &species::Settings,
        threads: &Threads,
    ) -> Result<Drawn, species::RenderError> {
        drawn(&self.motion, frame, settings, &self.backend, threads)
    }

    fn is_noisy(&self) -> bool {
        true
    }
}

impl species::Motion for FlameTransition {
    fn demand(&self, frame: f64, settings: &species::Settings) -> Result<Demand, species::RenderError> {
        self.loops.iter().try_for_each(drawable)?;
        demand(&self.motion, frame, settings)
    }

    fn frame(
        &self,
        frame: f64,
        settings: &species::Settings,
        threads: &Threads,
    ) -> Result<Drawn, species::RenderError> {
        // At an end the loop's own picture, though the shutter is open beyond it.
        if frame <= 0.0 {
            return drawn(&self.loops[0], frame, settings, &self.backend, threads);
        }
        if frame >= self.frames {
            return drawn(&self.loops[1], frame - self.frames, settings, &self.backend, threads);
        }
        let exposure = self.exposure(threads)?;
        drawn(&Exposed { motion: &self.motion, exposure: &exposure }, frame, settings, &self.backend, threads)
    }

    fn is_noisy(&self) -> bool {
        true
    }
}

/// Refuses a loop whose genome asks for what is not drawn.
fn drawable(motion: &Loop) -> Result<(), RenderError> {
    let reasons = motion.genome().unsupported().refused;
    if reasons.is_empty() { Ok(()) } else { Err(RenderError::Unsupported { reasons }) }
}

fn demand(motion: &dyn Motion, frame: f64, settings: &species::Settings) -> Result<Demand, species::RenderError> {
    let FrameCost { samples, bytes, bytes_per_thread, .. } = FrameCost::of(motion, frame, &settings.into())?;
    Ok(Demand { samples, bytes, bytes_per_thread })
}

fn drawn(
    motion: &dyn Motion,
    frame: f64,
    settings: &species::Settings,
    backend: &Backend,
    threads: &Threads,
) -> Result<Drawn, species::RenderError> {
    let Measured { image, samples, psnr } = draw_frame(motion, frame, &settings.into(), backend, threads)?;
    Ok(Drawn { image, samples, psnr })
}

impl From<&species::Settings> for Settings {
    fn from(settings: &species::Settings) -> Settings {
        let species::Settings { size, spp, psnr, supersample, temporal_samples, smooths, seed } = *settings;
        let filter = if smooths { Filter::Variance } else { Filter::None };
        let arithmetic = Arithmetic::Fastest;
        Settings { size: Some(size), spp, psnr, supersample, temporal_samples, filter, seed, arithmetic }
    }
}

impl From<RenderError> for species::RenderError {
    fn from(error: RenderError) -> species::RenderError {
        if error == RenderError::Stopped {
            return species::RenderError::Stopped;
        }
        species::RenderError::Refused(error.into())
    }
}
