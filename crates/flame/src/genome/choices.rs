//! The attributes of a genome that choose among named alternatives.
//!
//! Owns the enums and their spelling in XML. What a choice does is in `render/filter.rs` and `animate`.
//!
//! Start at any of the enums: [`named`](FilterShape::named) reads what [`name`](FilterShape::name) writes.

macro_rules! choices {
    ($($(#[$doc:meta])* $choice:ident { $($(#[$variant_doc:meta])* $variant:ident $name:literal,)* })*) => {$(
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum $choice { $($(#[$variant_doc])* $variant,)* }

        impl $choice {
            /// All alternatives.
            pub const ALL: &[$choice] = &[$($choice::$variant),*];

            /// The spelling in XML.
            pub fn name(self) -> &'static str {
                match self { $($choice::$variant => $name),* }
            }

            /// The alternative spelled `name`, in letters of any case.
            pub fn named(name: &str) -> Option<$choice> {
                $choice::ALL.iter().copied().find(|choice| choice.name().eq_ignore_ascii_case(name.trim()))
            }
        }
    )*};
}

choices! {
    /// The kernel of the spatial filter.
    FilterShape {
        /// exp(-2x²).
        Gaussian "gaussian",
        /// Cubic Hermite.
        Hermite "hermite",
        /// Flat.
        Box "box",
        /// Linear.
        Triangle "triangle",
        /// Quadratic B-spline.
        Bell "bell",
        /// Cubic B-spline.
        BSpline "bspline",
        /// Mitchell-Netravali, B = C = 1/3.
        Mitchell "mitchell",
        /// Blackman window.
        Blackman "blackman",
        /// Catmull-Rom.
        Catrom "catrom",
        /// Hann window.
        Hanning "hanning",
        /// Hamming window.
        Hamming "hamming",
        /// Sinc windowed by a wider sinc, three lobes.
        Lanczos3 "lanczos3",
        /// The same with two lobes.
        Lanczos2 "lanczos2",
        /// Quadratic.
        Quadratic "quadratic",
    }

    /// The shutter of motion blur.
    TemporalShape {
        /// Open, then shut.
        Box "box",
        /// Opens and shuts softly.
        Gaussian "gaussian",
        /// Opens or shuts by a power.
        Exp "exp",
    }

    /// How a colour coordinate becomes a palette entry.
    PaletteMode {
        /// The entry it falls in.
        Step "step",
        /// Blended from the two entries it falls between.
        Linear "linear",
    }

    /// Interpolation between two palettes.
    HuePath {
        /// Straight, channel by channel.
        Rgb "rgb",
        /// By hue, saturation and value.
        Hsv "hsv",
        /// The same, hue taking the shorter way round; in transitions, where flam3's default is no choice, as the eye sees it.
        HsvCircular "hsv_circular",
        /// The new palette wipes over the old one.
        Sweep "sweep",
    }

    /// Interpolation between the key frames of one file.
    Interpolation {
        /// Straight.
        Linear "linear",
        /// Catmull-Rom.
        Smooth "smooth",
    }

    /// The shape of a wave that moves a transform.
    WaveShape {
        /// A sine.
        Sin "sin",
        /// Straight up to 1, down to -1 and back.
        Triangle "triangle",
        /// From 0 to 1 and back, as (1 - cos) / 2.
        Hill "hill",
    }

    /// The space in which affine parts are interpolated.
    Space {
        /// Each column by log length and angle.
        Log "log",
        /// Entry by entry.
        Linear "linear",
        /// Entry by entry, and what one end lacks is plainly linear.
        Old "old",
        /// The same: `flam3-genome` prints no difference.
        Older "older",
    }
}

impl HuePath {
    /// The alternative that a program means by `name`: its spelling, or `hsv2`, as Fractorium calls the circular one.
    pub(super) fn read(name: &str) -> Option<HuePath> {
        if name.trim().eq_ignore_ascii_case("hsv2") { Some(HuePath::HsvCircular) } else { HuePath::named(name) }
    }
}
