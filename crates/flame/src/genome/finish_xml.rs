//! The attributes of `<flame>` by which other programs say their tone.
//!
//! Owns their names, for reading and for writing, and which program's genomes they count in. Never applies them.
//!
//! Start at [`settle`].

use roxmltree::Node;

use super::curve::Curves;
use super::finish::{FRACTORIUM_GAIN, Finish, JWILDFIRE_GAIN, PALETTE_SPAN};
use super::parse::{attributes, list, wrong};
use super::{Element, Genome, GenomeError, Program};

/// JWildfire's attributes; the one that all its genomes and no others have comes first.
const LIGHT: [&str; 7] = [
    "white_level",
    "contrast",
    "low_density_brightness",
    "balancing_red",
    "balancing_green",
    "balancing_blue",
    "saturation",
];

/// The splines of all channels together, of red, of green and of blue.
const SPLINES: [&str; 4] = ["overall_curve", "red_curve", "green_curve", "blue_curve"];

/// The colours of a JWildfire's background: of its corners and of its middle.
const BACKGROUND: [&str; 5] = ["background_ul", "background_ur", "background_ll", "background_lr", "background_cc"];

/// The gain of a light that says none.
fn usual_gain(program: Option<Program>, is_jwildfires: bool) -> f64 {
    match program {
        _ if is_jwildfires => JWILDFIRE_GAIN,
        Some(Program::Fractorium) => FRACTORIUM_GAIN,
        _ => 1.0,
    }
}

/// Takes what it knows of other programs' tone out of the attributes of `genome` that are kept, which come from `parts`.
/// Errors: [`GenomeError::Attribute`] where a value is wrong.
pub(super) fn settle(genome: &mut Genome, parts: &[Node]) -> Result<(), GenomeError> {
    let program = genome.program();
    let mut kept = Kept { genome, parts };
    if let Some(zoom) = kept.number("cam_zoom", |zoom| zoom > 0.0, "a number above 0")? {
        let scale = kept.genome.camera.scale * zoom;
        if !scale.is_finite() || (scale == 0.0) != (kept.genome.camera.scale == 0.0) {
            return Err(kept.refused("cam_zoom", "a zoom by which `scale` stays a finite number above 0"));
        }
        kept.genome.camera.scale = scale;
    }
    let turns = kept.part("center_turns")?;
    kept.genome.camera.center_turns = turns.unwrap_or_else(|| kept.genome.usual_center_turns());
    let one_sided = kept.part("dof_one_sided")?;
    kept.genome.camera.pose.one_sided = one_sided.unwrap_or_else(|| kept.genome.usual_one_sided());
    let is_jwildfires = program == Some(Program::JWildfire) || kept.has(LIGHT[0]);
    if is_jwildfires {
        kept.light()?;
        kept.background();
    }
    let gain = kept.number("log_gain", |gain| gain > 0.0, "a number above 0")?;
    kept.genome.finish.log_gain = gain.unwrap_or_else(|| usual_gain(program, is_jwildfires));
    if let Some(lost) = kept.part("lost_samples")? {
        kept.genome.finish.lost_samples = lost;
    }
    if let Some(start) = kept.part("palette_start")? {
        kept.genome.finish.palette_start = start;
    }
    if program == Some(Program::Fractorium) && !is_jwildfires {
        kept.genome.finish.palette_span = PALETTE_SPAN;
    }
    if let Some(span) = kept.part("palette_span")? {
        kept.genome.finish.palette_span = span;
    }
    kept.curves()
}

/// The attributes of a genome that are kept, and the elements that they come from.
struct Kept<'g, 'a, 'i> {
    genome: &'g mut Genome,
    parts: &'g [Node<'a, 'i>],
}

impl<'a, 'i> Kept<'_, 'a, 'i> {
    fn has(&self, name: &str) -> bool {
        self.genome.extra.iter().any(|(kept, _)| kept == name)
    }

    /// Takes the value of attribute `name` out.
    fn take(&mut self, name: &str) -> Option<String> {
        let at = self.genome.extra.iter().position(|(kept, _)| kept == name)?;
        Some(self.genome.extra.remove(at).1)
    }

    /// Takes a finite number out that `fits`.
    fn number(
        &mut self,
        name: &str,
        fits: impl Fn(f64) -> bool,
        expected: &'static str,
    ) -> Result<Option<f64>, GenomeError> {
        let Some(value) = self.take(name) else { return Ok(None) };
        match list::<f64>(&value).as_deref() {
            Some(&[number]) if fits(number) => Ok(Some(number)),
            _ => Err(self.refused(name, expected)),
        }
    }

    /// Takes a number from 0 to 1 out.
    fn part(&mut self, name: &str) -> Result<Option<f64>, GenomeError> {
        self.number(name, |part| (0.0..=1.0).contains(&part), "a number from 0 to 1")
    }

    fn refused(&self, name: &str, expected: &'static str) -> GenomeError {
        let of = |part: &Node<'a, 'i>| Some((*part, attributes(*part).find(|attribute| attribute.name() == name)?));
        // The last one counts.
        let found = self.parts.iter().rev().find_map(of);
        let (part, attribute) = found.expect("all that is kept comes from the elements' attributes");
        wrong(part, attribute, expected)
    }

    /// Takes JWildfire's light out.
    fn light(&mut self) -> Result<(), GenomeError> {
        let mut finish = Finish::jwildfire();
        let [red, green, blue] = &mut finish.balancing;
        let slots = [
            (&mut finish.white_level, true),
            (&mut finish.contrast, true),
            (&mut finish.low_density, false),
            (red, false),
            (green, false),
            (blue, false),
            (&mut finish.saturation, false),
        ];
        for (name, (slot, is_above_0)) in LIGHT.into_iter().zip(slots) {
            let found = match name {
                "low_density_brightness" => self.number(name, |_| true, "a finite number")?,
                _ if is_above_0 => self.number(name, |value| value > 0.0, "a number above 0")?,
                _ => self.number(name, |value| value >= 0.0, "a number from 0 on")?,
            };
            *slot = found.unwrap_or(*slot);
        }
        self.genome.finish = finish;
        Ok(())
    }

    /// Takes the background out where it is one colour; others are kept, and not drawn.
    fn background(&mut self) {
        let value = |name: &&str| {
            let found = self.genome.extra.iter().find(|(kept, _)| kept == name)?;
            list::<f64>(&found.1).and_then(|colour| <[f64; 3]>::try_from(colour).ok())
        };
        let colours: Vec<[f64; 3]> = BACKGROUND.iter().filter_map(value).collect();
        let given = BACKGROUND.iter().filter(|name| self.has(name)).count();
        let Some(first) = colours.first().filter(|first| colours.iter().all(|colour| colour == *first)) else { return };
        if colours.len() == given && first.iter().all(|channel| (0.0..=1.0).contains(channel)) {
            self.genome.tone.background = *first;
            self.genome.extra.retain(|(name, _)| !BACKGROUND.contains(&name.as_str()));
        }
    }

    /// Takes the curves out: splines, or else Bezier curves, which are a copy for older programs where there are both.
    fn curves(&mut self) -> Result<(), GenomeError> {
        let has_splines = SPLINES.iter().any(|name| self.has(name));
        let mut splines = Curves::straight();
        for (name, spline) in SPLINES.into_iter().zip(&mut splines) {
            if let Some(value) = self.take(name) {
                *spline = points(&value).ok_or_else(|| self.refused(name, "2 to 1000 points `x y` of different x"))?;
            }
        }
        let bezier = match self.take("curves") {
            Some(value) => {
                let curves =
                    list::<f64>(&value).filter(|numbers| numbers.len() == 48).and_then(|numbers| curves(&numbers));
                Some(curves.ok_or_else(|| {
                    self.refused("curves", "four curves of four points `x y weight`, weights above 0")
                })?)
            }
            None => None,
        };
        let curves = if has_splines { Some(Curves::Splines(splines)) } else { bezier };
        self.genome.finish.curves = curves.filter(|curves| !curves.is_straight()).map(Box::new);
        Ok(())
    }
}

/// The points of a spline, in the order of their x.
fn points(value: &str) -> Option<Vec<[f64; 2]>> {
    let numbers = list::<f64>(value).filter(|numbers| numbers.len().is_multiple_of(2))?;
    let mut points: Vec<[f64; 2]> = numbers.chunks_exact(2).map(|point| [point[0], point[1]]).collect();
    points.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let rises = points.windows(2).all(|pair| pair[0][0] < pair[1][0]);
    (rises && (2..=Curves::MOST_POINTS).contains(&points.len())).then_some(points)
}

/// Four Bezier curves of 48 numbers.
fn curves(numbers: &[f64]) -> Option<Curves> {
    let curve =
        |number: usize| std::array::from_fn(|point| std::array::from_fn(|i| numbers[12 * number + 3 * point + i]));
    let curves: [[[f64; 3]; 4]; 4] = std::array::from_fn(curve);
    curves.as_flattened().iter().all(|point| point[2] > 0.0).then(|| Curves::Bezier(Box::new(curves)))
}

impl Genome {
    /// Writes other programs' tone into the attributes of `<flame>`: nothing of flam3's, unless `version` stands for another.
    pub(super) fn write_finish(&self, root: &mut Element) {
        let (finish, program) = (&self.finish, self.program());
        let is_jwildfires = finish.has_jwildfires_light() || program == Some(Program::JWildfire);
        // A genome with such a light has such a palette, if it says no other.
        if finish.palette_span != 1.0 || program == Some(Program::Fractorium) || is_jwildfires {
            root.set("palette_span", finish.palette_span);
        }
        let usual = if is_jwildfires { Finish::jwildfire() } else { Finish::default() };
        for (name, part, usual) in [
            ("lost_samples", finish.lost_samples, usual.lost_samples),
            ("palette_start", finish.palette_start, usual.palette_start),
        ] {
            if part != usual {
                root.set(name, part);
            }
        }
        if finish.log_gain != usual_gain(program, is_jwildfires) {
            root.set("log_gain", finish.log_gain);
        }
        if is_jwildfires {
            let [red, green, blue] = finish.balancing;
            let values = [finish.white_level, finish.contrast, finish.low_density, red, green, blue, finish.saturation];
            for (name, value) in LIGHT.into_iter().zip(values) {
                root.set(name, value);
            }
        }
        match finish.curves.as_deref() {
            Some(Curves::Bezier(curves)) => root.set_all("curves", curves.as_flattened().as_flattened()),
            Some(Curves::Splines(curves)) => {
                for (name, points) in SPLINES.into_iter().zip(curves) {
                    root.set_all(name, points.as_flattened());
                }
            }
            None => {}
        }
    }
}
