//! How clips are to look: presets, and the options that override them.
//!
//! Owns the table of presets and the order of precedence: an option, then the preset, then the genome. Size, rate and frames
//! are the flock's; a preset that is made for others says so. Never renders.
//!
//! Start at [`LookArgs::look`].

use flock::Manifest;
use video::{Form, Quality, Tuning};

use super::options;
use super::plan::{CRF, Look, PRESET, SEED};

/// A named quality.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum Preset {
    /// To judge the motion: 20 samples per pixel
    Draft,
    /// For a display on a desk: 400 samples per pixel
    Screen,
    /// For a wall, as the Dreams: 2604 samples per pixel; made for flocks of 1280x720 and loops of 768 frames
    Dreams,
}

/// What a preset sets.
#[derive(Clone, Copy, Debug, PartialEq)]
struct PresetValues {
    spp: f64,
    supersample: u32,
    /// The genome's own where `None`.
    temporal_samples: Option<u32>,
    crf: f32,
    /// The size of the pictures and the frames of a loop that it is made for, if it is made for some.
    form: Option<((u32, u32), u32)>,
}

impl Preset {
    fn values(self) -> PresetValues {
        let finest = PresetValues { spp: 2604.0, supersample: 2, temporal_samples: None, crf: CRF, form: None };
        match self {
            Self::Draft => PresetValues { spp: 20.0, supersample: 1, temporal_samples: Some(16), crf: 30.0, ..finest },
            Self::Screen => PresetValues { spp: 400.0, ..finest },
            Self::Dreams => PresetValues { form: Some(((1280, 720), 768)), ..finest },
        }
    }

    /// What to tell an artist whose flock, `manifest`, is not of the form that this preset is made for.
    pub(crate) fn other_form(self, manifest: &Manifest) -> Option<String> {
        let ((width, height), frames) = self.values().form?;
        let loops = || manifest.sheep.iter().filter_map(|sheep| Some(sheep.clip.as_ref()?.frames.0));
        let (least, most) = (loops().min()?, loops().max()?);
        if manifest.size == (width, height) && (least, most) == (frames, frames) {
            return None;
        }
        let (own_width, own_height) = manifest.size;
        let own = if least == most { least.to_string() } else { format!("{least} to {most}") };
        Some(format!(
            "note: this preset is made for {width}x{height} and loops of {frames} frames; the flock has \
             {own_width}x{own_height} and {own}, and keeps them"
        ))
    }
}

/// The options of how clips look.
#[derive(Clone, Debug, Default, clap::Args)]
pub(crate) struct LookArgs {
    /// A quality by name; each option below overrides its part. Without one everything is as the genomes say
    #[arg(long, value_name = "NAME")]
    pub(crate) preset: Option<Preset>,
    /// Samples per pixel
    #[arg(long, value_name = "N", value_parser = options::samples)]
    spp: Option<f64>,
    /// As many samples as it takes until the noise is this small, a peak signal-to-noise ratio in decibels, such as 45;
    /// overrides the preset's samples per pixel
    #[arg(long, value_name = "DB", value_parser = options::decibels, conflicts_with = "spp")]
    psnr: Option<f64>,
    /// Histogram cells per pixel in each direction
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=16))]
    supersample: Option<u32>,
    /// Moments in a frame; 1 switches motion blur off
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=10_000))]
    temporal_samples: Option<u32>,
    /// x264's constant rate factor, to 51: smaller is finer and larger [default: 22, of a draft 30]
    #[arg(long, value_name = "N", value_parser = options::rate_factor)]
    crf: Option<f32>,
    /// The seed of the random numbers: the same gives the same clips, with any number of threads
    #[arg(long, value_name = "S", default_value_t = SEED)]
    seed: u64,
}

impl LookArgs {
    /// Those of a command line that has only this preset, or none.
    pub(crate) fn of_preset(preset: Option<Preset>) -> Self {
        Self { preset, seed: SEED, ..Self::default() }
    }

    /// The look of clips of `form`.
    pub(crate) fn look(&self, form: Form) -> Look {
        let values = self.preset.map(Preset::values);
        Look {
            form,
            spp: self.spp.or(values.map(|values| values.spp)).filter(|_| self.psnr.is_none()),
            psnr: self.psnr,
            supersample: self.supersample.or(values.map(|values| values.supersample)),
            temporal_samples: self.temporal_samples.or(values.and_then(|values| values.temporal_samples)),
            seed: self.seed,
            gpu: None,
            quality: Quality {
                crf: self.crf.or(values.map(|values| values.crf)).unwrap_or(CRF),
                preset: PRESET,
                tuning: Tuning::Gradients,
                max_bits_per_second: None,
            },
        }
    }

    /// The words of a command line that give the same pictures. What is only of the encoding is left out.
    pub(crate) fn words(&self) -> Vec<String> {
        let preset = self.preset.and_then(|preset| clap::ValueEnum::to_possible_value(&preset));
        let words = [
            ("--preset", preset.map(|value| value.get_name().to_owned())),
            ("--spp", self.spp.map(|number| number.to_string())),
            ("--psnr", self.psnr.map(|number| number.to_string())),
            ("--supersample", self.supersample.map(|number| number.to_string())),
            ("--temporal-samples", self.temporal_samples.map(|number| number.to_string())),
            ("--seed", Some(self.seed.to_string())),
        ];
        words.into_iter().filter_map(|(name, value)| Some([name.to_owned(), value?])).flatten().collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::{CommandFactory, Parser, ValueEnum};
    use std::path::Path;
    use timing::Rate;

    #[derive(Debug, Parser)]
    struct Line {
        #[command(flatten)]
        look: LookArgs,
    }

    fn look(words: &[&str]) -> Look {
        let form = Form { size: (64, 36), fps: Rate::new(30, 1).unwrap() };
        Line::parse_from([&["dreams"], words].concat()).look.look(form)
    }

    #[test]
    fn an_option_overrides_the_preset_and_the_preset_the_genome() {
        assert_eq!(look(&[]).spp, None);
        let dreams = look(&["--preset", "dreams"]);
        assert_eq!((dreams.spp, dreams.supersample, dreams.temporal_samples), (Some(2604.0), Some(2), None));
        assert_eq!(dreams.form.size, (64, 36), "the size is the flock's");
        let mixed = look(&["--preset", "draft", "--spp", "7", "--crf", "30"]);
        assert_eq!((mixed.spp, mixed.supersample, mixed.quality.crf), (Some(7.0), Some(1), 30.0));
        assert_eq!(look(&["--preset", "screen"]).quality, look(&[]).quality);
    }

    #[test]
    fn a_preset_alone_is_the_command_line_with_nothing_else() {
        let form = Form { size: (64, 36), fps: Rate::new(30, 1).unwrap() };
        assert_eq!(LookArgs::of_preset(None).look(form), look(&[]));
        assert_eq!(LookArgs::of_preset(Some(Preset::Draft)).look(form), look(&["--preset", "draft"]));
    }

    #[test]
    fn the_help_and_the_guide_tell_what_a_preset_sets() {
        for preset in Preset::value_variants() {
            let help = preset.to_possible_value().unwrap().get_help().unwrap().to_string();
            assert!(help.contains(&format!(": {} samples per pixel", preset.values().spp)), "{help}");
        }
        let guide = include_str!("../../../docs/farm.md");
        for preset in Preset::value_variants() {
            let name = preset.to_possible_value().unwrap().get_name().to_owned();
            let row = format!("| `{name}` | {} | ", preset.values().spp);
            assert!(guide.contains(&row), "docs/farm.md lacks {row}");
        }
        let help = Line::command().render_long_help().to_string();
        let draft = Preset::Draft.values().crf;
        assert!(help.contains(&format!("[default: {CRF}, of a draft {draft}]")), "{help}");
    }

    #[test]
    fn the_words_of_a_look_give_the_same_pictures() {
        let line =
            ["--preset", "draft", "--spp", "2.5", "--supersample", "3", "--temporal-samples", "9", "--seed", "4"];
        let words = Line::parse_from([&["dreams"][..], &line].concat()).look.words();
        assert_eq!(words, line);
        assert_eq!(look(&words.iter().map(String::as_str).collect::<Vec<_>>()), look(&line));
        let line = ["--preset", "dreams", "--psnr", "42.5", "--seed", "1"];
        let look = Line::parse_from([&["dreams"][..], &line].concat()).look;
        assert_eq!(look.words(), line);
        let look = look.look(Form { size: (64, 36), fps: Rate::new(30, 1).unwrap() });
        assert_eq!((look.spp, look.psnr), (None, Some(42.5)), "a target is instead of the preset's samples");
        assert!(Line::try_parse_from(["dreams", "--psnr", "40", "--spp", "9"]).is_err());
    }

    #[test]
    fn a_flock_of_another_form_is_told_and_keeps_it() {
        let manifest = |size: &str, frames: u32| {
            let text = format!(
                "format = 1\nname = \"a\"\nsize = {size}\nfps = [30, 1]\n\
                 [[sheep]]\nid = \"a\"\nframes = {frames}\nclip = \"a.mp4\"\n"
            );
            Manifest::parse(&text, Path::new("flock.toml")).unwrap()
        };
        assert_eq!(Preset::Dreams.other_form(&manifest("[1280, 720]", 768)), None);
        assert_eq!(Preset::Draft.other_form(&manifest("[64, 36]", 12)), None);
        let told = Preset::Dreams.other_form(&manifest("[64, 36]", 12)).unwrap();
        for part in ["1280x720", "768", "64x36", "12"] {
            assert!(told.contains(part), "{told}");
        }
        assert!(Preset::Dreams.other_form(&manifest("[1280, 720]", 240)).is_some());
    }
}
