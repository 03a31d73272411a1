//! Named qualities.
//!
//! Owns what each sets. Size, rate and frames are the flock's; a preset that is made for others says so. Never renders.
//!
//! Start at [`Preset::look`].

use flock::Manifest;
use video::{Form, Quality};

use super::plan::{CRF, Look};

/// A named quality.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Preset {
    /// To judge the motion.
    Draft,
    /// For a display on a desk.
    Screen,
    /// For a wall, as the Dreams.
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

    /// The look of clips of `form`.
    pub fn look(self, form: Form) -> Look {
        let PresetValues { spp, supersample, temporal_samples, crf, .. } = self.values();
        let look = Look::of_genomes(form);
        let quality = Quality { crf, ..look.quality };
        Look { spp: Some(spp), supersample: Some(supersample), temporal_samples, quality, ..look }
    }

    /// What to tell an artist whose flock, `manifest`, is not of the form that this preset is made for.
    pub fn other_form(self, manifest: &Manifest) -> Option<String> {
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

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

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
