//! A genome compiled for iteration.
//!
//! Owns what the inner loop reads: transforms without their zero parts, tables to choose the next one, a palette in
//! histogram units. Unsupported genomes are refused here. `chaos.rs` iterates.
//!
//! Start at [`Plan::new`].

use super::RenderError;
use super::histogram::UNIT;
use super::view::{View, in_range};
use crate::genome::{Affine, Genome, Palette, PaletteMode, Xform};
use crate::rng::Rng;
use crate::variations::{Compiled, Needs, Point, is_out_of_range, needs};

/// Table entries per palette entry where colours are blend: an eighth of a step is below what a byte shows.
const BLEND_STEPS: usize = 8;

/// A genome ready to be iterated.
#[derive(Clone, Debug)]
pub(crate) struct Plan {
    /// The transforms with a weight.
    pub(crate) moves: Vec<CompiledXform>,
    /// The final transform.
    pub(crate) lens: Option<CompiledXform>,
    /// How the next transform is chosen: one table, or one for each transform where there is xaos.
    choices: Vec<AliasTable>,
    /// Colours in histogram units.
    pub(crate) colours: Vec<[u32; 4]>,
    /// Where points land.
    pub(crate) view: View,
}

/// A transform ready to be applied.
#[derive(Clone, Debug)]
pub(crate) struct CompiledXform {
    affine: Affine,
    post: Option<Affine>,
    variations: Vec<Compiled>,
    needs: Needs,
    /// `c' = keep * c + pull`.
    keep: f64,
    pull: f64,
    /// The part of a sample that is seen, `0.0..=1.0`.
    pub(crate) visibility: f64,
    /// The part of points that a final transform takes.
    pub(crate) opacity: f64,
}

/// Walker's alias table: one random number chooses among any number of transforms.
#[derive(Clone, Debug)]
struct AliasTable {
    /// For each slot: the probability of its own index, and the alias for the rest.
    slots: Vec<(f64, u32)>,
}

impl Plan {
    /// Compiles `genome`, seen through `view`, its colours dimmed to `light` (`0.0..=1.0`).
    /// Errors: [`RenderError`] names what the genome lacks or what is unknown.
    pub(crate) fn new(genome: &Genome, view: View, light: f64) -> Result<Plan, RenderError> {
        check(genome)?;
        let genome = genome.with_symmetry();
        let count = genome.xforms.len();
        in_range("xform", count as f64, count <= Genome::MAX_XFORMS, "at most 256 transforms, symmetries included")?;
        let palette = genome.palette.as_ref().ok_or(RenderError::NoPalette)?;
        let used: Vec<usize> = (0..genome.xforms.len()).filter(|i| genome.xforms[*i].weight > 0.0).collect();
        if used.is_empty() {
            return Err(RenderError::NothingToChoose { xforms: genome.xforms.len() });
        }
        let weights = |from: Option<usize>| -> Vec<f64> {
            let chaos = from.map_or(&[][..], |from| &genome.xforms[from].chaos);
            used.iter().map(|i| genome.xforms[*i].weight * chaos.get(*i).copied().unwrap_or(1.0).max(0.0)).collect()
        };
        let xaos = used.iter().any(|i| genome.xforms[*i].chaos.iter().any(|weight| *weight != 1.0));
        let choices = if xaos {
            used.iter().map(|i| AliasTable::new(&weights(Some(*i)))).collect()
        } else {
            vec![AliasTable::new(&weights(None))]
        };
        Ok(Plan {
            moves: used.iter().map(|i| CompiledXform::new(&genome.xforms[*i])).collect(),
            lens: genome.final_xform.as_ref().map(CompiledXform::new),
            choices,
            colours: colours(palette, genome.palette_mode, light),
            view,
        })
    }

    /// Its size in memory, roughly: the palette, and the tables of xaos.
    pub(crate) fn bytes(&self) -> u64 {
        let tables: usize = self.choices.iter().map(|table| size_of_val(&table.slots[..])).sum();
        let variations: usize = self.moves.iter().map(|chosen| size_of_val(&chosen.variations[..])).sum();
        let lists = size_of_val(&self.colours[..]) + size_of_val(&self.moves[..]);
        (size_of::<Plan>() + lists + tables + variations) as u64
    }

    /// Draws the transform after number `last`.
    #[inline]
    pub(crate) fn next(&self, last: usize, rng: &mut Rng) -> usize {
        let choice = if self.choices.len() == 1 { &self.choices[0] } else { &self.choices[last] };
        choice.draw(rng)
    }
}

impl CompiledXform {
    fn new(xform: &Xform) -> CompiledXform {
        let used = || xform.variations.iter().filter(|variation| variation.weight != 0.0);
        let needs = used()
            .map(|variation| needs(variation.kind))
            .fold(Needs::default(), |all, one| Needs { theta: all.theta || one.theta, phi: all.phi || one.phi });
        let opacity = xform.opacity.clamp(0.0, 1.0);
        CompiledXform {
            affine: xform.affine,
            post: (xform.post != Affine::IDENTITY).then_some(xform.post),
            variations: used().map(|variation| Compiled::new(variation, &xform.affine)).collect(),
            needs,
            keep: 1.0 - xform.color_speed,
            pull: xform.color_speed * xform.color,
            visibility: if opacity == 0.0 { 0.0 } else { 10.0_f64.powf(opacity.log2()) },
            opacity,
        }
    }

    /// The image of a point; it may be anything, see [`has_escaped`].
    #[inline]
    pub(crate) fn point(&self, x: f64, y: f64, rng: &mut Rng) -> (f64, f64) {
        let (x, y) = self.affine.apply(x, y);
        let at = Point::new(x, y, self.needs);
        let mut sum = (0.0, 0.0);
        for variation in &self.variations {
            let (x, y) = variation.apply(&at, rng);
            sum = (sum.0 + x, sum.1 + y);
        }
        self.post.map_or(sum, |post| post.apply(sum.0, sum.1))
    }

    /// The image of a colour coordinate.
    #[inline]
    pub(crate) fn colour(&self, colour: f64) -> f64 {
        self.keep * colour + self.pull
    }
}

impl AliasTable {
    /// A table that draws each index by its weight; all weights 0 draws the first.
    fn new(weights: &[f64]) -> AliasTable {
        let sum: f64 = weights.iter().sum();
        let count = weights.len();
        if sum <= 0.0 {
            return AliasTable { slots: vec![(0.0, 0); count] };
        }
        let mut share: Vec<f64> = weights.iter().map(|weight| weight / sum * count as f64).collect();
        let mut slots: Vec<(f64, u32)> = (0..count).map(|i| (1.0, i as u32)).collect();
        let (mut small, mut large): (Vec<usize>, Vec<usize>) = (0..count).partition(|i| share[*i] < 1.0);
        while let (Some(poor), Some(rich)) = (small.pop(), large.last().copied()) {
            slots[poor] = (share[poor], rich as u32);
            share[rich] -= 1.0 - share[poor];
            if share[rich] < 1.0 {
                large.pop();
                small.push(rich);
            }
        }
        AliasTable { slots }
    }

    #[inline]
    fn draw(&self, rng: &mut Rng) -> usize {
        let place = rng.unit() * self.slots.len() as f64;
        let slot = place as usize;
        let (own, other) = self.slots[slot];
        if place - (slot as f64) < own { slot } else { other as usize }
    }
}

/// Whether a point has left the plane.
#[inline]
pub(crate) fn has_escaped(x: f64, y: f64) -> bool {
    is_out_of_range(x) || is_out_of_range(y)
}

/// Refuses what cannot be drawn.
fn check(genome: &Genome) -> Result<(), RenderError> {
    let (sampling, tone) = (&genome.sampling, &genome.tone);
    in_range("quality", sampling.quality, sampling.quality > 0.0, "a number above 0")?;
    in_range("gamma", tone.gamma, tone.gamma > 0.0, "a number above 0")?;
    let finals = genome.final_xform.iter().map(|xform| ("the final transform".to_owned(), xform));
    let numbered = genome.xforms.iter().enumerate().map(|(i, xform)| (format!("transform {i}"), xform));
    for (place, xform) in numbered.chain(finals) {
        if let Some((name, value)) = xform.extra.iter().find(|(name, value)| affects_picture(name, value)) {
            return Err(RenderError::Unknown { place, name: name.clone(), value: value.clone() });
        }
        if let Some(child) = xform.children.first() {
            return Err(RenderError::Unknown { place, name: child.tag.clone(), value: child.text.clone() });
        }
    }
    Ok(())
}

/// Whether an unknown attribute of a transform changes the picture.
fn affects_picture(name: &str, value: &str) -> bool {
    name != "name" && !value.trim().parse::<f64>().is_ok_and(|number| number == 0.0)
}

/// The palette as a table over the colour coordinate.
fn colours(palette: &Palette, mode: PaletteMode, light: f64) -> Vec<[u32; 4]> {
    let steps = match mode {
        PaletteMode::Step => 1,
        PaletteMode::Linear => BLEND_STEPS,
    };
    let count = Palette::LEN * steps;
    let unit = f64::from(UNIT) * light;
    let entry = |i: usize| {
        let coordinate = (i as f64 + 0.5) / count as f64;
        let colour = match mode {
            PaletteMode::Step => palette.step(coordinate),
            PaletteMode::Linear => palette.linear(coordinate),
        };
        colour.map(|channel| (channel.clamp(0.0, 255.0) / 255.0 * unit).round() as u32)
    };
    (0..count).map(entry).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn transforms_are_chosen_by_their_weights() {
        let weights = [0.5, 0.0, 2.0, 1.5];
        let choice = AliasTable::new(&weights);
        let mut rng = Rng::stream(1, 1);
        let mut counts = [0_u32; 4];
        for _ in 0..400_000 {
            counts[choice.draw(&mut rng)] += 1;
        }
        for (count, weight) in counts.iter().zip(weights) {
            assert!((f64::from(*count) / 100_000.0 - weight).abs() < 0.01, "{counts:?}");
        }
    }

    #[test]
    fn an_unknown_variation_is_refused_by_name() {
        let text = r#"<flame><xform weight="1" coefs="1 0 0 1 0 0" bipolar="0.5"/></flame>"#;
        let mut genome = Genome::parse(text).unwrap();
        genome.palette = Some(Palette::from_fn(|_| [255.0; 4]));
        let refused = Plan::new(&genome, View::new(&genome).unwrap(), 1.0).unwrap_err();
        assert_eq!(refused.to_string(), "transform 0 uses `bipolar` (`0.5`), which this renderer does not support");
    }
}
