//! How clips are to look: the name of a preset, and the options that override it.
//!
//! Owns the order of precedence: an option, then the preset, then the genome. Never renders.
//!
//! Start at [`LookArgs::look`].

use operations::render::plan::{Look, SEED};
use operations::render::presets::Preset;
use video::{Form, Quality};

use crate::arguments;

/// A named quality.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum PresetName {
    /// To judge the motion: 20 samples per pixel
    Draft,
    /// For a display on a desk: 400 samples per pixel
    Screen,
    /// For a wall, as the Dreams: 2604 samples per pixel; made for flocks of 1280x720 and loops of 768 frames
    Dreams,
}

impl From<PresetName> for Preset {
    fn from(name: PresetName) -> Self {
        match name {
            PresetName::Draft => Self::Draft,
            PresetName::Screen => Self::Screen,
            PresetName::Dreams => Self::Dreams,
        }
    }
}

/// The options of how clips look.
#[derive(Clone, Debug, Default, clap::Args)]
pub(crate) struct LookArgs {
    /// A quality by name; each option below overrides its part. Without one everything is as the genomes say
    #[arg(long, value_name = "NAME")]
    pub(crate) preset: Option<PresetName>,
    /// Samples per pixel
    #[arg(long, value_name = "N", value_parser = arguments::samples)]
    spp: Option<f64>,
    /// As many samples as it takes until the noise is this small, a peak signal-to-noise ratio in decibels, such as 45;
    /// overrides the preset's samples per pixel
    #[arg(long, value_name = "DB", value_parser = arguments::decibels, conflicts_with = "spp")]
    psnr: Option<f64>,
    /// Histogram cells per pixel in each direction
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=16))]
    supersample: Option<u32>,
    /// Moments in a frame; 1 switches motion blur off
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=10_000))]
    temporal_samples: Option<u32>,
    /// x264's constant rate factor, to 51: smaller is finer and larger [default: 22, of a draft 30]
    #[arg(long, value_name = "N", value_parser = arguments::rate_factor)]
    crf: Option<f32>,
    /// The seed of the random numbers: the same gives the same clips, with any number of threads
    #[arg(long, value_name = "S", default_value_t = SEED)]
    seed: u64,
}

impl LookArgs {
    /// The look of clips of `form`.
    pub(crate) fn look(&self, form: Form) -> Look {
        let look = self.preset.map_or_else(|| Look::of_genomes(form), |name| Preset::from(name).look(form));
        Look {
            spp: self.spp.or(look.spp).filter(|_| self.psnr.is_none()),
            psnr: self.psnr,
            supersample: self.supersample.or(look.supersample),
            temporal_samples: self.temporal_samples.or(look.temporal_samples),
            seed: self.seed,
            quality: Quality { crf: self.crf.unwrap_or(look.quality.crf), ..look.quality },
            ..look
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
        assert_eq!(Look::of_genomes(form), look(&[]));
        assert_eq!(Preset::Draft.look(form), look(&["--preset", "draft"]));
    }

    #[test]
    fn the_help_and_the_guide_tell_what_a_preset_sets() {
        let spp = |name: &PresetName| look(&["--preset", name.to_possible_value().unwrap().get_name()]).spp.unwrap();
        for preset in PresetName::value_variants() {
            let help = preset.to_possible_value().unwrap().get_help().unwrap().to_string();
            assert!(help.contains(&format!(": {} samples per pixel", spp(preset))), "{help}");
        }
        let guide = include_str!("../../../../docs/farm.md");
        for preset in PresetName::value_variants() {
            let name = preset.to_possible_value().unwrap().get_name().to_owned();
            let row = format!("| `{name}` | {} | ", spp(preset));
            assert!(guide.contains(&row), "docs/farm.md lacks {row}");
        }
        let help = Line::command().render_long_help().to_string();
        let draft = look(&["--preset", "draft"]).quality.crf;
        assert!(help.contains(&format!("[default: {}, of a draft {draft}]", look(&[]).quality.crf)), "{help}");
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
}
