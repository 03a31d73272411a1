//! Genomes bred at random from a seed.
//!
//! Owns the breeding for the property tests of this folder. Never a good-looking flame: only a legal one.
//!
//! Start at [`genome`].

use flame::Rng;
use flame::genome::{
    Affine, Element, FilterShape, Genome, HuePath, Interpolation, Palette, PaletteMode, Space, TemporalShape, Wave,
    WaveShape, Xform,
};
use flame::variations::{Kind, Variation};

/// A genome with one to five transforms, every field drawn from `seed`.
pub(crate) fn genome(seed: u64) -> Genome {
    let rng = &mut Rng::stream(seed, 0);
    let mut genome = Genome { name: Some(format!("bred \"{seed}\" <&>\n")), time: rng.signed(), ..Genome::default() };
    genome.camera.center = [rng.signed(), rng.signed()];
    genome.camera.scale = 10.0 + rng.unit();
    genome.camera.rotate = rng.signed() * 180.0;
    genome.camera.zoom = rng.signed();
    genome.sampling.quality = 1.0 + rng.unit();
    genome.sampling.supersample = 1 + below(rng, 3) as u32;
    genome.sampling.filter_shape = FilterShape::ALL[below(rng, FilterShape::ALL.len())];
    genome.sampling.temporal_shape = TemporalShape::ALL[below(rng, 3)];
    genome.tone.background = [rng.unit(), rng.unit(), rng.unit()];
    genome.tone.highlight_power = rng.signed();
    genome.tone.vibrancy = rng.unit();
    genome.palette_mode = PaletteMode::ALL[below(rng, 2)];
    genome.hue_path = HuePath::ALL[below(rng, 4)];
    genome.hue_path_rgb = rng.unit();
    genome.interpolation = Interpolation::ALL[below(rng, 2)];
    genome.space = Space::ALL[below(rng, 4)];
    genome.palette = Some(palette(rng));
    genome.xforms = (0..=below(rng, 5)).map(|_| xform(rng)).collect();
    genome.finals = (below(rng, 2) == 0).then(|| Xform { animate: 0.0, ..xform(rng) }).into_iter().collect();
    genome.symmetries.extend([None, Some(2), Some(-3)][below(rng, 3)]);
    genome.extra = vec![("nick".into(), "nobody & co".into())];
    genome.children = vec![Element {
        tag: "edit".into(),
        attributes: vec![("action".into(), "bred <at> \"random\"".into())],
        text: "x < y".into(),
        children: vec![Element { tag: "sheep".into(), ..Element::default() }],
    }];
    genome
}

fn palette(rng: &mut Rng) -> Palette {
    let whole = below(rng, 2) == 0;
    let alpha = below(rng, 2) == 0;
    Palette::from_fn(|_| {
        let mut entry = [0.0; 4].map(|_: f64| rng.unit() * 255.0);
        if whole {
            entry = entry.map(f64::round);
        }
        if !alpha {
            entry[3] = 255.0;
        }
        entry
    })
}

fn xform(rng: &mut Rng) -> Xform {
    let mut xform = Xform {
        weight: rng.unit() + 0.1,
        color: rng.unit(),
        color_speed: rng.unit(),
        animate: f64::from(u8::from(below(rng, 4) > 0)),
        opacity: rng.unit(),
        affine: affine(rng),
        post: if below(rng, 2) == 0 { Affine::IDENTITY } else { affine(rng) },
        ..Xform::default()
    };
    if below(rng, 3) == 0 {
        xform.chaos = vec![rng.unit(), 1.0, rng.unit()];
    }
    let mut kinds: Vec<Kind> = (0..=below(rng, 3)).map(|_| Kind::FLAM3[below(rng, Kind::FLAM3.len())]).collect();
    kinds.sort();
    kinds.dedup();
    for kind in kinds {
        // flam3's logarithm has one base.
        let own = kind.parameters().iter().filter(|_| kind != Kind::Log);
        let params: Vec<f64> = own.map(|_| 2.0 + rng.unit()).collect();
        xform.variations.push(Variation::new(kind, rng.signed()).with(&params));
    }
    xform.motions = (0..below(rng, 3)).map(|_| wave(rng, &xform.variations)).collect();
    xform
}

/// A wave that adds to what the transform has, and to its variations.
fn wave(rng: &mut Rng, variations: &[Variation]) -> Wave {
    let shape = WaveShape::ALL[below(rng, 3)];
    let mut wave = Wave { frequency: below(rng, 5) as i32 - 2, shape, ..Wave::default() };
    let added = &mut wave.added;
    if below(rng, 2) == 0 {
        (added.weight, added.color, added.color_speed, added.opacity) =
            (0.1 * rng.signed(), 0.1 * rng.signed(), 0.1 * rng.signed(), 0.1 * rng.signed());
    }
    if below(rng, 2) == 0 {
        (added.affine, added.post) = (affine(rng), affine(rng));
    }
    for variation in variations {
        let params: Vec<f64> = variation.kind.parameters().iter().map(|_| 0.1 * rng.signed()).collect();
        added.variations.push(Variation::new(variation.kind, 0.1 * rng.signed()).with(&params));
    }
    added.extra.extend((below(rng, 3) == 0).then(|| ("symmetry".to_owned(), "0.5".to_owned())));
    wave
}

fn affine(rng: &mut Rng) -> Affine {
    Affine { a: rng.signed(), b: rng.signed(), c: rng.signed(), d: rng.signed(), e: rng.signed(), f: rng.signed() }
}

fn below(rng: &mut Rng, count: usize) -> usize {
    (rng.unit() * count as f64) as usize
}
