//! Three pictures from the middle of a transition, and how good they are.
//!
//! Owns the moments, a quarter, a half and three quarters of the way, and the figures: light and contrast, each against what
//! is expected between the two ends. Most transitions that fail do so there, so this tells before hours of rendering. It is
//! the transition that `dreams render` would render.
//!
//! Start at [`Media::make_middles`]; `moving.rs` has the preview that moves.

use std::fs;
use std::path::PathBuf;
use std::sync::Arc;

use ::species::{Light, RenderError, Settings, Threads, expected};
use flame::Backend;
use flock::ClipPath;
use operations::render::plan::{ClipPlan, Look, SheepMotion};
use operations::species;
use serde_json::{Value, json};
use video::Form;

use super::sources::{PairSource, Source};
use super::stopping::{go_on, with_flag};
use super::{Media, MediaError, cache, picture};
use crate::jobs::Progress;

/// A picture fits into this box.
const BOX: (u32, u32) = (480, 480);
/// Samples of each pixel.
const SAMPLES: f64 = 30.0;
const BYTES: usize = 90_000;
/// The moments, as parts of the way.
const PARTS: [f64; 3] = [0.25, 0.5, 0.75];
/// A transition with a lower score is flagged.
const LEAST: f64 = 0.6;
/// The file of the figures.
const FIGURES: &str = "-middles.json";

/// How a moment compares with what is expected of it.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Moment {
    part: f64,
    /// The mean light and the contrast, as parts of those expected.
    light: f64,
    contrast: f64,
}

impl Media {
    /// Picture `at` (1 to 3) of the middle of the transition of `key`, if it is made.
    pub(crate) fn find_middle(&self, key: &str, at: usize) -> Option<PathBuf> {
        let known = (1..=PARTS.len()).contains(&at);
        self.cache.find(key, &file(at)).filter(|_| known)
    }

    /// The figures of the middle of the transition of `key`, if they are made: `{score, flagged, moments: [{at, light,
    /// contrast}]}`, all of which are 1 of a perfect middle.
    pub(crate) fn find_figures(&self, key: &str) -> Option<Value> {
        serde_json::from_slice(&fs::read(self.cache.find(key, FIGURES)?).ok()?).ok()
    }

    /// Makes the three pictures and the figures of `key`; each picture is there as soon as it is drawn.
    /// Errors: [`MediaError`] if a genome cannot be read or drawn. Pictures that are drawn are kept.
    pub(crate) fn make_middles(&self, key: &str, progress: &Progress) -> Result<Value, MediaError> {
        let source = self.sources.find(key)?;
        let Source::Pair(pair) = &*source else { return Err(MediaError::Unknown { key: key.to_owned() }) };
        if let Some(told) = self.find_figures(key) {
            return Ok(told);
        }
        let size = picture::fit(pair.form.size, BOX);
        let plan = pair.plan(size, &Look::of_genomes(pair.form))?;
        let refused = |error: RenderError| pair.refused(&error, progress);
        with_flag(progress, |flag| {
            let threads = Threads::new(0).map_err(|error| MediaError::refused(pair.words(), error.to_string()))?;
            let threads = threads.with_stop_flag(Arc::clone(flag));
            let steps = PARTS.len() as u64 + 1;
            for (number, part) in PARTS.into_iter().enumerate() {
                go_on(progress)?;
                progress.set(number as u64, steps);
                self.cache.once(key, &file(number + 1), |path| {
                    let settings = few_samples(size, SAMPLES);
                    let drawn = plan.motion.frame(pair.frame(part), &settings, &threads).map_err(refused)?;
                    picture::save(path, &picture::of_image(&drawn.image), BYTES)
                })?;
            }
            progress.set(steps - 1, steps);
            let told = told(&moments(&plan, pair, &threads).map_err(refused)?);
            cache::write(&self.cache.path(key, FIGURES), told.to_string().as_bytes())?;
            progress.set(steps, steps);
            Ok(told)
        })
    }
}

impl PairSource {
    /// The transition in pictures of `size`, as `dreams render` would render it with `look`.
    /// Errors: [`MediaError::Refused`] if a genome cannot be read.
    pub(super) fn plan(&self, size: (u32, u32), look: &Look) -> Result<ClipPlan, MediaError> {
        let look = Look { form: Form { size, ..look.form }, ..*look };
        let end = |at: usize| {
            let genome = species::read(&self.genomes[at], &Backend::default());
            let genome =
                genome.map_err(|why| MediaError::refused(self.names[at].to_string(), why.source.to_string()))?;
            Ok(SheepMotion::new(genome, self.turns[at]))
        };
        let (from, to): (SheepMotion, SheepMotion) = (end(0)?, end(1)?);
        let path = ClipPath::new("preview.mp4").expect("it has no characters that a path cannot have");
        Ok(ClipPlan::of_transition(self.names.clone(), [&from, &to], path, self.frames, &look))
    }

    /// The frame at this part of the way.
    fn frame(&self, part: f64) -> f64 {
        (part * f64::from(self.frames.0)).floor()
    }

    /// The transition, for people.
    pub(super) fn words(&self) -> String {
        let [from, to] = &self.names;
        format!("{from} to {to}")
    }

    /// Why it was not drawn.
    pub(super) fn refused(&self, error: &RenderError, progress: &Progress) -> MediaError {
        if progress.is_cancelled() {
            MediaError::Cancelled
        } else {
            MediaError::refused(self.words(), error.to_string())
        }
    }
}

/// Settings of a picture with `spp` samples per pixel and without motion blur.
pub(super) fn few_samples(size: (u32, u32), spp: f64) -> Settings {
    Settings {
        size: [size.0, size.1],
        spp: Some(spp),
        psnr: None,
        supersample: Some(1),
        temporal_samples: Some(1),
        smooths: true,
        seed: 1,
    }
}

/// The name of picture `at`, from 1.
fn file(at: usize) -> String {
    format!("-middle{at}.jpg")
}

/// The light at the ends and at the moments, measured on pictures that are smaller still.
fn moments(plan: &ClipPlan, pair: &PairSource, threads: &Threads) -> Result<Vec<Moment>, RenderError> {
    let size = [pair.form.size.0, pair.form.size.1];
    let light = |frame: f64| Light::of_motion(&*plan.motion, frame, size, threads);
    let ends = [light(0.0)?, light(f64::from(pair.frames.0))?];
    let moment = |part: f64| {
        let found = light(pair.frame(part))?;
        let against = |of: fn(&Light) -> f64| of(&found) / expected(ends.each_ref().map(of), part).max(1e-6);
        Ok(Moment { part, light: against(|light| light.mean), contrast: against(|light| light.contrast) })
    };
    PARTS.into_iter().map(moment).collect()
}

/// The figures, for the page. Light that is too much counts as what is too little; contrast cannot be too much.
fn told(moments: &[Moment]) -> Value {
    let near = |ratio: f64| if ratio > 1.0 { 1.0 / ratio } else { ratio };
    let score = moments.iter().map(|own| near(own.light).min(own.contrast)).fold(1.0, f64::min);
    let short = |number: f64| (number * 1000.0).round() / 1000.0;
    let moment = |own: &Moment| json!({ "at": own.part, "light": short(own.light), "contrast": short(own.contrast) });
    json!({ "score": short(score), "flagged": score < LEAST, "moments": moments.iter().map(moment).collect::<Vec<_>>() })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_middle_is_as_good_as_its_worst_figure_and_flagged_below_six_tenths() {
        let of = |light: f64, contrast: f64| {
            let told = told(&[Moment { part: 0.25, light: 1.0, contrast: 1.2 }, Moment { part: 0.5, light, contrast }]);
            (told["score"].as_f64().unwrap(), told["flagged"].as_bool().unwrap())
        };
        assert_eq!(of(1.0, 1.0), (1.0, false));
        assert_eq!(of(0.5, 1.0), (0.5, true));
        assert_eq!(of(2.0, 1.0), (0.5, true), "a burst of light");
        assert_eq!(of(1.0, 0.7), (0.7, false));
        assert_eq!(of(1.0, 3.0), (1.0, false));
    }
}
