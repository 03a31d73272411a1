//! Genomes: the parameters of a flame, as flam3 XML holds them.
//!
//! Owns the data model and its defaults; `render` and `animate` read it. Unknown attributes and elements are kept in
//! `extra` fields, so that reading and writing loses nothing.
//!
//! Start at [`Genome::parse_all`] and [`Genome::to_xml`].

mod attributes;
mod carry;
mod choices;
mod curve;
mod error;
mod finish;
mod finish_xml;
mod jwildfire;
mod layers;
mod library;
mod limits;
mod lineage;
mod mark;
mod mend;
mod motion_curve;
mod names;
mod origin;
pub(crate) mod palette;
mod palette_xml;
mod parse;
mod pose;
mod program;
mod size;
mod split;
mod symmetry;
mod tilt;
mod unsupported;
mod value;
mod wave;
mod write;

pub use choices::{FilterShape, HuePath, Interpolation, PaletteMode, Space, TemporalShape, WaveShape};
pub use curve::Curves;
pub use error::{GenomeError, Place};
pub use finish::Finish;
pub use library::{Library, PaletteBlend};
pub use mark::MARK;
pub(crate) use motion_curve::catmull_rom;
pub use origin::{Origin, name_of};
pub use palette::Palette;
pub use pose::Pose;
pub use program::Program;
pub use split::Part;
pub use tilt::Tilt;
pub use unsupported::{Reason, Reasons, Unsupported, Why};
pub use wave::Wave;

pub use variations::Affine;
use variations::Variation;

/// A flame: its transforms, camera and colours.
#[derive(Clone, Debug, PartialEq)]
pub struct Genome {
    /// `name`: what people call it.
    pub name: Option<String>,
    /// `time`: its place on the time line of its file, in frames.
    pub time: f64,
    /// Where the camera stands and what it sees.
    pub camera: Camera,
    /// How many samples are drawn and how they are filtered.
    pub sampling: Sampling,
    /// From log-density to displayable light.
    pub tone: Tone,
    /// What another program than flam3 makes of that light.
    pub finish: Finish,
    /// The 256 colours, or `None` where the file names a palette of a library instead.
    pub palette: Option<Palette>,
    /// `palette`: the number of a palette in a library; below 0 it names none.
    pub palette_number: Option<i32>,
    /// `hue`: how far the hue of the library's palette is turned, in whole turns.
    pub hue: f64,
    /// `<palette index0 index1>`: a blend of two palettes of a library, where there is no `palette_number`.
    pub palette_blend: Option<PaletteBlend>,
    /// `palette_mode`: how a colour coordinate becomes a palette entry.
    pub palette_mode: PaletteMode,
    /// `palette_interpolation`: interpolation between two palettes.
    pub hue_path: HuePath,
    /// `hsv_rgb_palette_blend`: 0 interpolates in HSV, 1 linearly in RGB.
    pub hue_path_rgb: f64,
    /// `interpolation`: linear or smooth between the key frames of one file.
    pub interpolation: Interpolation,
    /// `interpolation_type`: the space in which affine parts are interpolated.
    pub space: Space,
    /// The transforms that the chaos game chooses among.
    pub xforms: Vec<Xform>,
    /// The transforms that are applied to every point before it is plotted, one after the other; their result is not fed
    /// back. flam3 has at most one.
    pub finals: Vec<Xform>,
    /// `<symmetry kind>` elements: each adds rotations, and a reflection where it is negative.
    pub symmetries: Vec<i32>,
    /// Attributes of `<flame>` that are kept as they are, in file order; [`Genome::unsupported`] names those that change the
    /// picture.
    pub extra: Vec<(String, String)>,
    /// Child elements that are kept as they are, in file order: `edit`, `sheep` and others.
    pub children: Vec<Element>,
}

/// Where the camera stands and what it sees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// `size`: width and height of the picture in pixels.
    pub size: [u32; 2],
    /// `center`: the point in the middle of the picture, also the centre of its rotation if [`Camera::center_turns`].
    pub center: [f64; 2],
    /// `scale`: pixels per unit at zoom 0.
    pub scale: f64,
    /// `zoom`: multiplies the scale by 2^zoom and the samples by 4^zoom.
    pub zoom: f64,
    /// `rotate`: degrees.
    pub rotate: f64,
    /// `center_turns`: 1 where the picture rotates about `center`; 0 where it rotates about the origin, and its middle is
    /// `center` after that, as a JWildfire's in space; between them in a transition.
    pub center_turns: f64,
    /// How it stands in space.
    pub pose: Pose,
}

/// How many samples are drawn and how they are filtered.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sampling {
    /// `quality`: samples per pixel at zoom 0.
    pub quality: f64,
    /// `supersample`: histogram cells per pixel, in each direction.
    pub supersample: u32,
    /// `filter`: radius of the spatial filter in pixels.
    pub filter_radius: f64,
    /// `filter_shape`.
    pub filter_shape: FilterShape,
    /// `temporal_samples`: moments in a frame.
    pub temporal_samples: u32,
    /// `temporal_filter_type`.
    pub temporal_shape: TemporalShape,
    /// `temporal_filter_width`: how long the shutter is open, in frames.
    pub temporal_width: f64,
    /// `temporal_filter_exp`: exponent of the exponential shutter.
    pub temporal_exponent: f64,
    /// `passes`: kept; one pass is always rendered.
    pub passes: u32,
    /// `estimator_radius`: widest density-estimation kernel in pixels, 0 for none.
    pub estimator_radius: f64,
    /// `estimator_minimum`: narrowest kernel in pixels.
    pub estimator_minimum: f64,
    /// `estimator_curve`: how fast the kernel narrows with density.
    pub estimator_curve: f64,
}

/// From log-density to displayable light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tone {
    /// `background`: red, green, blue in `0.0..=1.0`.
    pub background: [f64; 3],
    /// `brightness`: gain of the log-density.
    pub brightness: f64,
    /// `gamma`: display exponent, > 0.
    pub gamma: f64,
    /// `gamma_threshold`: density below which the gamma curve is replaced by a line.
    pub gamma_threshold: f64,
    /// `vibrancy`: 1 applies gamma to the density only, 0 to every channel.
    pub vibrancy: f64,
    /// `highlight_power`: below 0 highlights clip; from 0 on they keep their hue and fade to white.
    pub highlight_power: f64,
}

/// A transform: affine part, weighted sum of variations, post affine part.
#[derive(Clone, Debug, PartialEq)]
pub struct Xform {
    /// `weight`: how often the chaos game chooses it, relative to the others; unused in a final transform.
    pub weight: f64,
    /// `color`: the colour coordinate it pulls towards, `0.0..=1.0`.
    pub color: f64,
    /// The second colour coordinate that old files carry; kept.
    pub color2: Option<f64>,
    /// `color_speed`: how far it pulls, `0.0..=1.0`.
    pub color_speed: f64,
    /// `animate`: not 0 where it turns in loops.
    pub animate: f64,
    /// `opacity`: how visible its points are, `0.0..=1.0`.
    pub opacity: f64,
    /// `chaos` (xaos): what this transform multiplies the weight of each next one by; missing ones are 1.
    pub chaos: Vec<f64>,
    /// `coefs`: the affine part before the variations.
    pub affine: Affine,
    /// `post`: the affine part after the variations.
    pub post: Affine,
    /// `yzCoefs` and `zxCoefs`: what follows `coefs` in space.
    pub tilt: Tilt,
    /// `yzPost` and `zxPost`: what follows `post` in space.
    pub post_tilt: Tilt,
    /// The variations, no two of one [`Slot`](variations::Slot).
    pub variations: Vec<Variation>,
    /// Variations that are kept and not drawn: each has an unknown parameter that the genome's [`MARK`] names.
    pub left_out: Vec<Variation>,
    /// Attributes that are kept as they are. If one changes the picture, the flame is not rendered: it is a variation or
    /// a feature that this crate lacks, and [`Genome::unsupported`] names it.
    pub extra: Vec<(String, String)>,
    /// `<motion>` elements: what waves add to it in the course of a loop.
    pub motions: Vec<Wave>,
    /// Child elements that are kept as they are.
    pub children: Vec<Element>,
}

/// An XML element that is kept without being understood.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Element {
    /// Its tag.
    pub tag: String,
    /// Its attributes in file order.
    pub attributes: Vec<(String, String)>,
    /// Its text, trimmed.
    pub text: String,
    /// The elements in it.
    pub children: Vec<Element>,
}

impl Default for Genome {
    fn default() -> Genome {
        Genome {
            name: None,
            time: 0.0,
            camera: Camera {
                size: [100, 100],
                center: [0.0; 2],
                scale: 50.0,
                zoom: 0.0,
                rotate: 0.0,
                center_turns: 1.0,
                pose: Pose::default(),
            },
            sampling: Sampling {
                quality: 1.0,
                supersample: 1,
                filter_radius: 0.5,
                filter_shape: FilterShape::Gaussian,
                temporal_samples: 1000,
                temporal_shape: TemporalShape::Box,
                temporal_width: 1.0,
                temporal_exponent: 0.0,
                passes: 1,
                estimator_radius: 9.0,
                estimator_minimum: 0.0,
                estimator_curve: 0.4,
            },
            tone: Tone {
                background: [0.0; 3],
                brightness: 4.0,
                gamma: 4.0,
                gamma_threshold: 0.01,
                vibrancy: 1.0,
                highlight_power: -1.0,
            },
            finish: Finish::default(),
            palette: None,
            palette_number: None,
            hue: 0.0,
            palette_blend: None,
            palette_mode: PaletteMode::Step,
            hue_path: HuePath::HsvCircular,
            hue_path_rgb: 0.0,
            interpolation: Interpolation::Linear,
            space: Space::Log,
            xforms: Vec::new(),
            finals: Vec::new(),
            symmetries: Vec::new(),
            extra: Vec::new(),
            children: Vec::new(),
        }
    }
}

impl Default for Xform {
    fn default() -> Xform {
        Xform {
            weight: 0.0,
            color: 0.0,
            color2: None,
            color_speed: 0.5,
            animate: 1.0,
            opacity: 1.0,
            chaos: Vec::new(),
            affine: Affine::IDENTITY,
            post: Affine::IDENTITY,
            tilt: Tilt::NONE,
            post_tilt: Tilt::NONE,
            variations: Vec::new(),
            left_out: Vec::new(),
            extra: Vec::new(),
            motions: Vec::new(),
            children: Vec::new(),
        }
    }
}

impl Camera {
    /// The same camera for a picture of `size` pixels: the scale follows, so that what was in view stays in view.
    #[must_use]
    pub fn resized(&self, size: [u32; 2]) -> Camera {
        let ratio = |axis: usize| f64::from(size[axis]) / f64::from(self.size[axis]);
        Camera { size, scale: self.scale * ratio(0).min(ratio(1)), ..*self }
    }
}
