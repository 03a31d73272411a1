//! A still of a flame.
//!
//! Owns what only flames have of `dreams still`: key frames, flam3's filter, and settings of the genome's own. Never writes a
//! file.
//!
//! Start at [`draw`].

use std::slice;

use ::species::Drawn;
use flame::genome::{Program, Reasons};
use flame::{
    Arithmetic, Filter, FrameCost, Genome, GenomeError, KeyFrames, Loop, Motion, RenderError, Renderer, Settings,
};
use operations::program::{Exit, Fatal, now::Stopwatch};
use operations::species::palettes::coloured;

use super::still::{Args, FlameFacts, Smoothing, Timed};

/// The picture of the flame in `text` that `args` ask for.
/// Errors: [`Fatal`] if it is not one, or cannot be rendered.
pub(super) fn draw(args: &Args, text: &str) -> Result<Timed, Fatal> {
    let (motion, frame, facts) = motion(args, text)?;
    let settings = settings(args);
    let genome_fatal = |source| args.genome_fatal(Exit::Malformed, source);
    let demand = FrameCost::of(&*motion, frame, &settings).map_err(|error| genome_fatal(error.into()))?;
    let threads = args.threads_for(demand.bytes, demand.bytes_per_thread)?;
    let watch = Stopwatch::start();
    let renderer = Renderer::new(threads.get()).map_err(|error| Fatal::new(Exit::Unreadable, error))?;
    let measured = renderer.render_measured(&*motion, frame, &settings).map_err(|error| genome_fatal(error.into()))?;
    let (cpu_s, seconds) = (watch.cpu().as_secs_f64(), watch.wall().as_secs_f64());
    let samples = if args.psnr.is_some() { measured.samples } else { demand.samples };
    let drawn = Drawn { image: measured.image, samples, psnr: measured.psnr };
    Ok(Timed { drawn, cpu_s, seconds, facts: Some(facts) })
}

/// What the file shows, at which frame or time, and what its flame, or the first of them, says of how it is drawn.
fn motion(args: &Args, text: &str) -> Result<(Box<dyn Motion>, f64, FlameFacts), Fatal> {
    let malformed = |error: GenomeError| args.genome_fatal(Exit::Malformed, error.into());
    let with_colours =
        |genome: Genome| coloured(genome).map_err(|error| args.genome_fatal(Exit::Unreadable, error.into()));
    if let Some(time) = args.time {
        let keys = Genome::parse_all(text).map_err(malformed)?;
        let keys = keys.into_iter().map(with_colours).collect::<Result<Vec<_>, _>>()?;
        let told = facts(args, &keys)?;
        return Ok((Box::new(KeyFrames::new(keys).map_err(malformed)?), time, told));
    }
    let genome = with_colours(Genome::parse(text).map_err(malformed)?)?;
    let told = facts(args, slice::from_ref(&genome))?;
    Ok(match args.frame.zip(args.frames) {
        Some((frame, frames)) => (Box::new(Loop::new(&genome, f64::from(frames))), f64::from(frame), told),
        None => (Box::new(genome), 0.0, told),
    })
}

/// What `genomes` say of how they are drawn: the first of its program and tone, all of what is not drawn.
/// Errors: [`Fatal`] with all reasons, if they ask for what is not drawn.
fn facts(args: &Args, genomes: &[Genome]) -> Result<FlameFacts, Fatal> {
    let (mut reasons, mut without) = (Reasons::default(), Reasons::default());
    for found in genomes.iter().map(Genome::unsupported) {
        reasons.0.extend(found.refused.0);
        without.0.extend(found.without.0);
    }
    if !reasons.is_empty() {
        return Err(args.genome_fatal(Exit::Malformed, RenderError::Unsupported { reasons }.into()));
    }
    let first = genomes.first();
    let program = first.and_then(Genome::program).map(Program::name);
    Ok(FlameFacts { program, tone: first.map_or(Vec::new(), |genome| genome.finish.names()), without })
}

fn settings(args: &Args) -> Settings {
    Settings {
        size: args.size,
        spp: args.spp,
        psnr: args.psnr,
        supersample: args.supersample,
        // A genome that does not move has no motion blur.
        temporal_samples: if args.frame.is_some() || args.time.is_some() { args.temporal_samples } else { Some(1) },
        filter: match args.filter {
            Smoothing::None => Filter::None,
            Smoothing::Variance => Filter::Variance,
            Smoothing::Flam3 => Filter::Flam3,
        },
        seed: args.seed,
        arithmetic: Arithmetic::Fastest,
    }
}
