//! The variations of flames: their names, parameters, stages and formulas.
//!
//! Owns the table that the XML reader, the writer, the animation and the renderer share: V0 to V98 of flam3, and after
//! them those of other programs. `spelling.rs` has the spelling in files, `stage.rs` the order inside a transform, `carry.rs` what
//! becomes of z in the plane,
//! `formulas.rs` says what a formula is, `limits.rs` which parameters are not drawn; `number` has the numbers that formulas
//! calculate with; the other files have the mathematics. Never knows a transform, an orbit or a picture: `flame` does.
//!
//! Start at [`Kind`].
//!
//! # Source
//! Draves & Reckase, *The Fractal Flame Algorithm* (2008), appendix: catalogue of variations, V0 to V48. Names,
//! numbers and parameters of the others are those of flam3 3.1.1; where a genome does not give a parameter, its pictures say
//! what it is.
#![forbid(unsafe_code)]
#![allow(clippy::inline_always, reason = "a call that is not inlined would use other instructions than its caller")]
#![allow(clippy::return_self_not_must_use, reason = "nobody calculates but for the result")]
#![allow(clippy::float_cmp, reason = "0 and 1 mean `off` and `whole` exactly, as files say them")]

mod affine;
mod blurs;
mod carry;
mod cells;
mod chance;
mod colours;
mod complex;
#[cfg(test)]
mod documented;
mod escape;
#[cfg(test)]
mod expected;
#[cfg(test)]
mod expected_chance;
#[cfg(test)]
mod expected_escape;
#[cfg(test)]
mod expected_later;
#[cfg(test)]
mod expected_more;
#[cfg(test)]
mod expected_probed;
#[cfg(test)]
mod expected_synth;
mod figures;
mod formulas;
mod later;
mod limits;
pub mod number;
mod plain;
mod precomputed;
mod roots;
mod solid;
mod space;
mod spelling;
mod stage;
mod synth;
mod tiles;
mod waves;

use std::f64::consts::{E, FRAC_PI_2, FRAC_PI_4, PI};

pub use affine::Affine;
pub use formulas::{Coloured, Compiled, Depth, Formula, TINY, Visitor};
pub use limits::{Limit, Undrawn};
pub use spelling::{PRIORITY, Part, Spelling};
pub use stage::{Slot, Stage};

/// How many parameters a variation has at most.
pub const MAX_PARAMETERS: usize = 36;

/// One variation of a transform, with its weight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Variation {
    /// Which formula.
    pub kind: Kind,
    /// How strongly it is mixed in; 0 leaves it out but keeps its parameters.
    pub weight: f64,
    /// Its parameters in the order of [`Kind::parameters`]; the rest is 0.
    pub params: [f64; MAX_PARAMETERS],
    /// When it is applied.
    pub stage: Stage,
    /// Which of several of its kind and stage it is, from 0.
    pub number: u8,
    /// How far it has come, `0.0..=1.0`, where its weight does not say that: in a transition, what replaces the point grows
    /// by it from 0. 1 elsewhere.
    pub presence: f64,
    /// How much of a point's z a formula of the plane carries, times the weight: 0 or 1, and between them in a transition.
    pub carry: f64,
}

impl Variation {
    /// A variation of the given weight with its default parameters.
    pub fn new(kind: Kind, weight: f64) -> Variation {
        let mut params = [0.0; MAX_PARAMETERS];
        for (slot, parameter) in params.iter_mut().zip(kind.parameters()) {
            *slot = parameter.default;
        }
        Variation { kind, weight, params, stage: Stage::Sum, number: 0, presence: 1.0, carry: 0.0 }
    }

    /// Whether it changes nothing, whatever its parameters are.
    pub fn is_absent(&self) -> bool {
        self.weight == 0.0 || self.presence == 0.0
    }

    /// Its place among the variations of a transform: no two of a transform have the same.
    pub fn slot(&self) -> Slot {
        Slot { stage: self.stage, kind: self.kind, number: self.number }
    }

    /// How much of z it adds to the sum in space, times z; 0 of a formula that has a z of its own.
    pub fn carried(&self) -> f64 {
        if self.kind.depth() == Depth::None { self.weight * self.presence * self.carry } else { 0.0 }
    }

    /// What z is multiplied with where it replaces a point in space; `None` for a formula that has a z of its own.
    pub fn depth_factor(&self) -> Option<f64> {
        let whole = 1.0 + self.carry * (self.weight - 1.0);
        (self.kind.depth() == Depth::None).then_some(1.0 + self.presence * (whole - 1.0))
    }

    /// The same variation with other parameters, in the order of [`Kind::parameters`].
    #[must_use]
    pub fn with(mut self, params: &[f64]) -> Variation {
        self.params[..params.len()].copy_from_slice(params);
        self
    }
}

/// A parameter of a variation.
#[derive(Debug, PartialEq)]
pub struct Parameter {
    /// Its name after the variation's and an underscore: `power` of `julian_power`.
    pub name: &'static str,
    /// Its value where a genome does not say.
    pub default: f64,
}

macro_rules! kinds {
    ($($module:ident::$kind:ident $name:literal [$($parameter:ident $default:expr),*];)*) => {
        /// A variation; the discriminant of the first 99 is its number in flam3, up to 48 that in the paper.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        #[expect(missing_docs, reason = "each name is the published one, its formula stands in the module that the table names")]
        pub enum Kind { $($kind),* }

        /// How many there are.
        const COUNT: usize = [$(Kind::$kind),*].len();

        impl Kind {
            /// All variations, by number.
            pub const ALL: [Kind; COUNT] = [$(Kind::$kind),*];

            /// The name in XML.
            pub fn name(self) -> &'static str {
                match self { $(Kind::$kind => $name),* }
            }

            /// The parameters, in the order of [`Variation::params`].
            pub fn parameters(self) -> &'static [Parameter] {
                match self {
                    $(Kind::$kind => &[$(Parameter { name: stringify!($parameter), default: $default }),*]),*
                }
            }

            /// Does what `visitor` does with the formula.
            #[inline(always)]
            pub fn visit<V: Visitor>(self, visitor: V) -> V::Out {
                match self { $(Kind::$kind => visitor.visit::<$module::$kind>()),* }
            }
        }
    };
}

kinds! {
    plain::Linear "linear" [];
    plain::Sinusoidal "sinusoidal" [];
    plain::Spherical "spherical" [];
    plain::Swirl "swirl" [];
    plain::Horseshoe "horseshoe" [];
    plain::Polar "polar" [];
    plain::Handkerchief "handkerchief" [];
    plain::Heart "heart" [];
    plain::Disc "disc" [];
    plain::Spiral "spiral" [];
    plain::Hyperbolic "hyperbolic" [];
    plain::Diamond "diamond" [];
    plain::Ex "ex" [];
    chance::Julia "julia" [];
    plain::Bent "bent" [];
    plain::Waves "waves" [];
    plain::Fisheye "fisheye" [];
    plain::Popcorn "popcorn" [];
    plain::Exponential "exponential" [];
    plain::Power "power" [];
    plain::Cosine "cosine" [];
    plain::Rings "rings" [];
    plain::Fan "fan" [];
    plain::Blob "blob" [low 0.0, high 1.0, waves 1.0];
    plain::Pdj "pdj" [a 0.0, b 0.0, c 0.0, d 0.0];
    plain::Fan2 "fan2" [x 0.0, y 0.0];
    plain::Rings2 "rings2" [val 0.0];
    plain::Eyefish "eyefish" [];
    solid::Bubble "bubble" [];
    solid::Cylinder "cylinder" [];
    plain::Perspective "perspective" [angle 0.0, dist 0.0];
    chance::Noise "noise" [];
    chance::Julian "julian" [power 1.0, dist 1.0];
    chance::Juliascope "juliascope" [power 1.0, dist 1.0];
    chance::Blur "blur" [];
    chance::GaussianBlur "gaussian_blur" [];
    chance::RadialBlur "radial_blur" [angle 0.0];
    chance::Pie "pie" [slices 6.0, rotation 0.0, thickness 0.5];
    plain::Ngon "ngon" [power 3.0, sides 5.0, corners 2.0, circle 1.0];
    plain::Curl "curl" [c1 1.0, c2 0.0];
    plain::Rectangles "rectangles" [x 1.0, y 1.0];
    chance::Arch "arch" [];
    plain::Tangent "tangent" [];
    chance::Square "square" [];
    chance::Rays "rays" [];
    chance::Blade "blade" [];
    plain::Secant2 "secant2" [];
    chance::Twintrian "twintrian" [];
    plain::Cross "cross" [];
    later::Disc2 "disc2" [rot 0.0, twist 0.0];
    chance::SuperShape "super_shape" [rnd 0.0, m 0.0, n1 1.0, n2 1.0, n3 1.0, holes 0.0];
    chance::Flower "flower" [holes 0.0, petals 0.0];
    chance::Conic "conic" [holes 0.0, eccentricity 1.0];
    chance::Parabola "parabola" [height 0.0, width 0.0];
    later::Bent2 "bent2" [x 1.0, y 1.0];
    complex::Bipolar "bipolar" [shift 0.0];
    chance::Boarders "boarders" [];
    later::Butterfly "butterfly" [];
    later::Cell "cell" [size 1.0];
    chance::Cpow "cpow" [r 1.0, i 0.0, power 1.0];
    later::Curve "curve" [xamp 0.0, yamp 0.0, xlength 1.0, ylength 1.0];
    complex::Edisc "edisc" [];
    complex::Elliptic "elliptic" [];
    complex::Escher "escher" [beta 0.0];
    complex::Foci "foci" [];
    later::Lazysusan "lazysusan" [spin 0.0, space 0.0, twist 0.0, x 0.0, y 0.0];
    later::Loonie "loonie" [];
    chance::PreBlur "pre_blur" [];
    later::Modulus "modulus" [x 0.0, y 0.0];
    later::Oscilloscope "oscilloscope" [separation 1.0, frequency PI, amplitude 1.0, damping 0.0];
    later::Polar2 "polar2" [];
    later::Popcorn2 "popcorn2" [x 0.0, y 0.0, c 0.0];
    later::Scry "scry" [];
    later::Separation "separation" [x 0.0, xinside 0.0, y 0.0, yinside 0.0];
    later::Split "split" [xsize 0.0, ysize 0.0];
    later::Splits "splits" [x 0.0, y 0.0];
    later::Stripes "stripes" [space 0.0, warp 0.0];
    later::Wedge "wedge" [angle 0.0, hole 0.0, count 1.0, swirl 0.0];
    chance::WedgeJulia "wedge_julia" [angle 0.0, count 1.0, power 1.0, dist 0.0];
    later::WedgeSph "wedge_sph" [angle 0.0, hole 0.0, count 1.0, swirl 0.0];
    later::Whorl "whorl" [inside 0.0, outside 0.0];
    later::Waves2 "waves2" [scalex 0.0, scaley 0.0, freqx 0.0, freqy 0.0];
    complex::Exp "exp" [];
    complex::Log "log" [base E];
    complex::Sin "sin" [];
    complex::Cos "cos" [];
    complex::Tan "tan" [];
    complex::Sec "sec" [];
    complex::Csc "csc" [];
    complex::Cot "cot" [];
    complex::Sinh "sinh" [];
    complex::Cosh "cosh" [];
    complex::Tanh "tanh" [];
    complex::Sech "sech" [];
    complex::Csch "csch" [];
    complex::Coth "coth" [];
    later::Auger "auger" [freq 1.0, weight 0.5, sym 0.0, scale 1.0];
    later::Flux "flux" [spread 0.0];
    complex::Mobius "mobius" [re_a 0.0, im_a 0.0, re_b 0.0, im_b 0.0, re_c 0.0, im_c 0.0, re_d 0.0, im_d 0.0];
    solid::Linear3D "linear3D" [];
    solid::Flatten "flatten" [];
    solid::Zscale "zscale" [];
    solid::Ztranslate "ztranslate" [];
    solid::Zcone "zcone" [];
    solid::Zblur "zblur" [];
    space::Spherical3D "spherical3D" [];
    space::Spherical3DWf "spherical3D_wf" [invert 0.0, exponent 2.0];
    space::Hemisphere "hemisphere" [];
    space::Julia3D "julia3D" [power 2.0];
    space::Julia3Dz "julia3Dz" [power 2.0];
    space::Julian3Dx "julian3Dx" [dist 1.0, power 2.0, a 1.0, b 0.0, c 0.0, d 1.0, e 0.0, f 0.0];
    space::Blur3D "blur3D" [];
    space::Curl3D "curl3D" [cx 0.0, cy 0.0, cz 0.0];
    space::Blob3D "blob3D" [low 0.0, high 1.0, waves 1.0];
    space::LinearT3D "linearT3D" [powX 1.0, powY 1.0, powZ 1.0];
    space::Poincare3D "poincare3D" [r 0.0, a 0.0, b 0.0];
    space::Bubble2 "bubble2" [x 1.0, y 1.0, z 0.0];
    space::RotateY "rotate_y" [];
    space::RotateX "rotate_x" [];
    space::RotateZ "rotate_z" [];
    space::Waves2In3D "waves2_3D" [freq 2.0, scale 1.0];
    space::Affine3D "affine3D" [
        translateX 0.0, translateY 0.0, translateZ 0.0, scaleX 1.0, scaleY 1.0, scaleZ 1.0, rotateX 0.0, rotateY 0.0,
        rotateZ 0.0, shearXY 0.0, shearXZ 0.0, shearYX 0.0, shearYZ 0.0, shearZX 0.0, shearZY 0.0
    ];
    space::Butterfly3D "butterfly3D" [];
    colours::AxisSymmetryWf "axis_symmetry_wf" [
        axis 0.0, centre_x 0.0, centre_y 0.0, centre_z 0.0, rotation 0.0, x1colorshift 0.0, y1colorshift 0.0,
        z1colorshift 0.0, x2colorshift 0.0, y2colorshift 0.0, z2colorshift 0.0
    ];
    colours::Falloff2 "falloff2" [
        scatter 1.0, mindist 0.5, mul_x 1.0, mul_y 1.0, mul_z 0.0, mul_c 0.0, x0 0.0, y0 0.0, z0 0.0, invert 0.0, type 0.0,
        above 0.0
    ];
    complex::EllipticMirrored "elliptic_mirrored" [];
    roots::Juliac "juliac" [re 0.0, im 0.0, dist 1.0];
    roots::Juliaq "juliaq" [power 3.0, divisor 2.0];
    roots::EJulia "eJulia" [power 2.0];
    roots::BTransform "bTransform" [rotate 0.0, power 1.0, move 0.0, split 0.0];
    roots::Acosech "acosech" [];
    roots::Hypertile "hypertile" [p 3.0, q 7.0, n 0.0];
    roots::Hypertile1 "hypertile1" [p 3.0, q 7.0];
    roots::Hypertile2 "hypertile2" [p 3.0, q 7.0];
    blurs::Sineblur "sineblur" [power 1.0];
    blurs::BlurCircle "blur_circle" [];
    blurs::BlurLinear "blur_linear" [length 0.0, angle 0.0];
    blurs::BlurZoom "blur_zoom" [length 0.0, x 0.0, y 0.0];
    blurs::Spirograph "spirograph" [
        a 3.0, b 2.0, d 0.0, tmin -1.0, tmax 1.0, ymin -1.0, ymax 1.0, c1 0.0, c2 0.0
    ];
    blurs::Crop "crop" [left -1.0, top -1.0, right 1.0, bottom 1.0, scatter_area 0.0, zero 0.0];
    blurs::Smartcrop "smartcrop" [
        power 4.0, radius 1.0, roundstr 0.0, roundwidth 1.0, distortion 1.0, edge 0.0, scatter 0.0, offset 0.0, rotation 0.0,
        cropmode 1.0, static 1.0
    ];
    blurs::Circlecrop "circlecrop" [radius 1.0, x 0.0, y 0.0, scatter_area 0.0, zero 1.0];
    waves::Waves2b "waves2b" [
        freqx 2.0, freqy 2.0, pwx 1.0, pwy 1.0, scalex 1.0, scaleinfx 1.0, scaley 1.0, scaleinfy 1.0, unity 1.0, jacok 0.25
    ];
    waves::Waves2Wf "waves2_wf" [
        scalex 0.25, scaley 0.5, freqx FRAC_PI_2, freqy FRAC_PI_4, use_cos_x 1.0, use_cos_y 0.0, dampx 0.0, dampy 0.0
    ];
    waves::Waves3Wf "waves3_wf" [
        scalex 0.25, scaley 0.5, freqx FRAC_PI_2, freqy FRAC_PI_4, use_cos_x 1.0, use_cos_y 0.0, dampx 0.0, dampy 0.0
    ];
    waves::Waves4Wf "waves4_wf" [
        scalex 0.25, scaley 0.5, freqx FRAC_PI_2, freqy FRAC_PI_4, use_cos_x 1.0, use_cos_y 0.0, dampx 0.0, dampy 0.0
    ];
    tiles::Bwraps "bwraps" [cellsize 1.0, space 0.0, gain 1.0, inner_twist 0.0, outer_twist 0.0];
    tiles::Boarders2 "boarders2" [c 0.5, left 0.5, right 0.5];
    tiles::TileLog "tile_log" [spread 1.0];
    tiles::Shredlin "shredlin" [xdistance 1.0, xwidth 0.5, ydistance 1.0, ywidth 0.5];
    colours::PointSymmetryWf "point_symmetry_wf" [centre_x 0.25, centre_y 0.5, order 3.0, colorshift 0.0];
    figures::YinYang "yin_yang" [radius 0.5, ang1 0.0, ang2 0.0, dual_t 1.0, outside 0.0];
    figures::Glynnia "glynnia" [];
    figures::CloverleafWf "cloverleaf_wf" [filled 0.85];
    figures::CannabiscurveWf "cannabiscurve_wf" [filled 0.85];
    figures::Target "target" [even 0.0, odd 0.0, size 1.0];
    tiles::Kaleidoscope "kaleidoscope" [pull 0.0, rotate 1.0, line_up 1.0, x 0.0, y 0.0];
    tiles::TileHlp "tile_hlp" [width 1.0];
    figures::EpispiralWf "epispiral_wf" [waves 4.0];
    figures::Epispiral "epispiral" [n 6.0, thickness 0.0, holes 1.0];
    figures::Fdisc "fdisc" [];
    figures::Unpolar "unpolar" [];
    figures::Twoface "twoface" [];
    figures::Xheart "xheart" [angle 0.0, ratio 0.0];
    roots::Acosh "acosh" [];
    complex::Acoth "acoth" [];
    space::Cone "cone" [
        radius1 0.5, radius2 1.0, size1 0.5, size2 2.0, ywave 1.0, xwave 1.0, height 1.0, warp 1.0, weight 2.0
    ];
    figures::Idisc "idisc" [];
    figures::Cardioid "cardioid" [a 1.0];
    figures::Asteria "asteria" [alpha 0.0];
    figures::Circlize "circlize" [hole 0.4];
    figures::Eclipse "eclipse" [shift 0.1];
    space::Ennepers2 "ennepers2" [a 1.0, b 0.3333, c 0.075];
    complex::Joukowski "joukowski" [P1 2.5, P2 0.0, inverse 0.0];
    figures::Petal "petal" [];
    roots::Julian2 "julian2" [power 2.0, dist 1.0, a 1.0, b 0.0, c 0.0, d 1.0, e 0.0, f 0.0];
    figures::HeartWf "heart_wf" [scale_x 1.0, shift_t 0.0, scale_r_left 1.0, scale_r_right 1.0];
    waves::Waves3 "waves3" [scalex 0.05, scaley 0.05, freqx 7.0, freqy 13.0, sx_freq 0.0, sy_freq 2.0];
    waves::Waves22 "waves22" [
        scalex 0.05, scaley 0.05, freqx 7.0, freqy 13.0, modex 0.0, modey 0.0, powerx 2.0, powery 2.0
    ];
    figures::RoseWf "rose_wf" [amp 0.5, waves 4.0, filled 0.85];
    space::Sph3D "sph3D" [x 0.75, y 1.0, z 0.5];
    figures::Tancos "tancos" [];
    space::Tanhq "tanhq" [];
    space::Taurus "taurus" [r 3.0, n 5.0, inv 1.5, sor 1.0];
    figures::TargetSp "target_sp" [twist 0.0, n_of_sp 1.0, size 0.5, tightness 0.5];
    figures::GlynnSim2 "glynnSim2" [radius 1.0, thickness 0.1, contrast 0.5, pow 1.5, phi1 110.0, phi2 150.0];
    tiles::Waffle "waffle" [slices 6.0, xthickness 0.5, ythickness 0.5, rotation 0.0];
    space::WhitneyUmbrella "whitney_umbrella" [];
    complex::Sec2Bs "sec2_bs" [x1 1.25, x2 0.75, y1 1.5, y2 0.5];
    waves::Stwin "stwin" [distort 1.0, offset_xy 0.0, offset_x2 0.0, offset_y2 0.0];
    space::Seashell3D "seashell3D" [final_radius 0.25, height 3.5, inner_radius 0.4, nSpirals 3.0];
    space::Hypertile3D "hypertile3D" [p 3.0, q 7.0, n 0.0];
    tiles::Gnarly "gnarly" [cellsize 1.0, twist 1.0];
    blurs::Gaussian "gaussian" [];
    roots::PowBlock "pow_block" [numerator 3.0, denominator 2.0, root 1.0, correctn 1.0, correctd 1.0];
    blurs::Rblur "rblur" [strength 1.0, offset 1.0, center_x 0.0, center_y 0.0];
    synth::Synth "synth" [
        a 0.0,
        b 0.0, b_type 0.0, b_skew 0.0, b_frq 1.0, b_phs 0.0, b_layer 0.0,
        c 0.0, c_type 0.0, c_skew 0.0, c_frq 1.0, c_phs 0.0, c_layer 0.0,
        d 0.0, d_type 0.0, d_skew 0.0, d_frq 1.0, d_phs 0.0, d_layer 0.0,
        e 0.0, e_type 0.0, e_skew 0.0, e_frq 1.0, e_phs 0.0, e_layer 0.0,
        f 0.0, f_type 0.0, f_skew 0.0, f_frq 1.0, f_phs 0.0, f_layer 0.0,
        mode 3.0, power -2.0, mix 0.0, smooth 0.0
    ];
    cells::Crackle "crackle" [cellsize 1.0, power 0.2, distort 0.0, scale 1.0, z 0.0];
    colours::DcLinear "dc_linear" [offset 0.0, angle 0.0, scale 1.0];
    tiles::Xtrb "xtrb" [power 2.0, radius 1.0, width 0.5, dist 1.0, a 1.0, b 1.0];
    colours::Falloff3 "falloff3" [
        blur_type 0.0, blur_shape 0.0, blur_strength 1.0, min_distance 0.5, invert_distance 0.0, mul_x 1.0, mul_y 1.0,
        mul_z 0.0, mul_c 0.0, center_x 0.0, center_y 0.0, center_z 0.0, alpha 0.0
    ];
    tiles::Truchet "truchet" [extended 0.0, exponent 2.0, arc_width 0.5, rotation 0.0, size 1.0, seed 50.0, direct_color 0.0];
    waves::Waves4 "waves4" [scalex 0.05, scaley 0.05, freqx 7.0, freqy 13.0, cont 0.0, yfact 0.1];
    waves::Vibration2 "vibration2" [
        dir 0.0, angle FRAC_PI_2, freq 1.0, amp 0.25, phase 0.0, dir2 FRAC_PI_2, angle2 FRAC_PI_2, freq2 1.0, amp2 0.25, phase2 0.0,
        dm 0.0, dmfreq 0.1, tm 0.0, tmfreq 0.1, fm 0.0, fmfreq 0.1, am 0.0, amfreq 0.1,
        d2m 0.0, d2mfreq 0.1, t2m 0.0, t2mfreq 0.1, f2m 0.0, f2mfreq 0.1, a2m 0.0, a2mfreq 0.1
    ];
    escape::FractJuliaWf "fract_julia_wf" [
        max_iter 100.0, xmin -1.0, xmax 1.0, ymin -1.2, ymax 1.2, buddhabrot_mode 0.0, power 2.0, xseed 0.35, yseed 0.09,
        direct_color 1.0, scalez 1.0, clip_iter_min 4.0, clip_iter_max -5.0, max_clip_iter 3.0, buddhabrot_min_iter 7.0,
        scale 3.8, offsetx 0.0, offsety 0.0, offsetz 0.0, z_fill 0.0, z_logscale 0.0, color_only 0.0
    ];
    escape::Mandelbrot "mandelbrot" [
        iter 100.0, xmin -1.6, xmax 1.6, ymin -1.2, ymax 1.2, invert 0.0, skin 0.012, cx 0.0, cy 0.0, max_points -1.0, seed 1234.0,
        rnd_z_range 0.0
    ];
}

impl Kind {
    /// The variations of flam3 3.1.1, by number: those that are bred.
    pub const FLAM3: [Kind; 99] = {
        let mut first = [Kind::Linear; 99];
        let mut number = 0;
        while number < first.len() {
            first[number] = Kind::ALL[number];
            number += 1;
        }
        first
    };

    /// The variation whose XML attribute is `name`.
    pub fn named(name: &str) -> Option<Kind> {
        Kind::ALL.into_iter().find(|kind| kind.name() == name)
    }

    /// What the formula does with z.
    pub fn depth(self) -> Depth {
        struct DepthOf;
        impl Visitor for DepthOf {
            type Out = Depth;
            fn visit<F: Formula>(self) -> Depth {
                F::DEPTH
            }
        }
        self.visit(DepthOf)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_variation_has_the_number_of_the_paper_and_of_flam3() {
        assert_eq!(Kind::Linear as usize, 0);
        assert_eq!(Kind::Blob as usize, 23);
        assert_eq!(Kind::Julian as usize, 32);
        assert_eq!(Kind::Cross as usize, 48);
        assert_eq!(Kind::PreBlur as usize, 67);
        assert_eq!(Kind::Mobius as usize, 98);
        assert_eq!(Kind::FLAM3.last(), Some(&Kind::Mobius));
        assert!(Kind::ALL.iter().enumerate().all(|(number, kind)| *kind as usize == number));
    }

    #[test]
    fn every_name_finds_its_variation() {
        for kind in Kind::ALL {
            assert_eq!(Kind::named(kind.name()), Some(kind));
            assert!(kind.parameters().len() <= MAX_PARAMETERS);
        }
        assert_eq!(Kind::named("waltz"), None);
    }
}
