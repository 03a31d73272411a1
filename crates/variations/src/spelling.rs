//! How files spell variations.
//!
//! Owns the names of weights and parameters, in every stage: `julian`, `julian_power`, `pre_julian_power`, `julian.2` for
//! the second of two, `julian_fx_priority`; and the names that other programs give to a variation of flam3. Never reads a
//! value.
//!
//! Start at [`Spelling::of`].

use std::collections::{HashMap, HashSet};
use std::sync::LazyLock;

use super::{Kind, Slot, Stage, Variation};

/// What an attribute of a transform says of a variation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Spelling {
    /// Of which one.
    pub slot: Slot,
    /// And what.
    pub part: Part,
}

/// What an attribute says of a variation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// The weight.
    Weight,
    /// The parameter of this index.
    Parameter(usize),
    /// `_fx_priority`: when JWildfire applies it.
    Priority,
    /// `.presence`: [`Variation::presence`].
    Presence,
    /// `.z`: [`Variation::carry`].
    Carry,
}

/// What JWildfire writes after the name of a variation to say when it is applied.
pub const PRIORITY: &str = "_fx_priority";
const PRESENCE: &str = ".presence";
const CARRY: &str = ".z";

/// Names of other programs: theirs, and flam3's.
const ALIASES: [(&str, &str); 7] = [
    ("bwraps2", "bwraps"),
    ("bwraps7", "bwraps"),
    ("cylinder_apo", "cylinder"),
    ("oscope", "oscilloscope"),
    ("pre_gaussian_blur", "pre_blur"),
    ("supershape", "super_shape"),
    ("wedgejulia", "wedge_julia"),
];

/// Variations that ignore their point: Fractorium's `pre_X` and `post_X` of them add.
const IGNORING: [Kind; 12] = [
    Kind::Arch,
    Kind::Blur,
    Kind::Blur3D,
    Kind::BlurCircle,
    Kind::GaussianBlur,
    Kind::Pie,
    Kind::Sineblur,
    Kind::Spirograph,
    Kind::Square,
    Kind::Waffle,
    Kind::Zblur,
    Kind::Ztranslate,
];

/// What a name stands for in a transform's sum: by the name, and by the name in small letters where no other has that.
static NAMES: LazyLock<HashMap<String, (Kind, Part)>> = LazyLock::new(|| {
    let mut exact = HashMap::new();
    for kind in Kind::ALL {
        let aliases = ALIASES.iter().filter(|(_, known)| *known == kind.name()).map(|(alias, _)| *alias);
        for name in std::iter::once(kind.name()).chain(aliases) {
            exact.insert(name.to_owned(), (kind, Part::Weight));
            for (index, parameter) in kind.parameters().iter().enumerate() {
                exact.entry(format!("{name}_{}", parameter.name)).or_insert((kind, Part::Parameter(index)));
            }
        }
    }
    let mut all = exact.clone();
    for (name, found) in exact {
        all.entry(name.to_lowercase()).or_insert(found);
    }
    all
});

impl Spelling {
    /// What the attribute `name` says, if it is of a variation.
    pub fn of(name: &str) -> Option<Spelling> {
        let (name, number) = without_number(name);
        for (suffix, part) in [(PRESENCE, Part::Presence), (CARRY, Part::Carry), (PRIORITY, Part::Priority)] {
            if let Some(name) = name.strip_suffix(suffix) {
                return Spelling::of_part(name, number, Some(part));
            }
        }
        Spelling::of_part(&name, number, None)
    }

    fn of_part(name: &str, number: u8, part: Option<Part>) -> Option<Spelling> {
        let (stage, (kind, found)) = match known(name) {
            Some(found) => (Stage::Sum, found),
            None => match name.split_once('_')? {
                ("pre", rest) => (Stage::Before, known(rest)?),
                ("post", rest) => (Stage::After, known(rest)?),
                _ => return None,
            },
        };
        if part.is_some() && found != Part::Weight {
            return None;
        }
        let slot = Slot { stage: own_stage(kind, stage), kind, number };
        Some(Spelling { slot, part: part.unwrap_or(found) })
    }

    /// The stages of a variation in `slot` whose JWildfire priority is `value`: two where it is applied twice.
    ///
    /// Below 0 it works on the point, above 0 on the sum, and with 2 or -2 on both; what its name puts before the sum does
    /// nothing after it.
    pub fn stages_of_priority(slot: Slot, value: f64) -> Option<(Stage, Option<Stage>)> {
        if value.fract() != 0.0 {
            return None;
        }
        let stage = slot.stage;
        let is_twice = value.abs() == 2.0;
        if matches!(stage, Stage::Before | Stage::AddedBefore) || slot.kind == Kind::PreBlur {
            return Some((if value < 0.0 || is_twice { stage } else { Stage::Never }, None));
        }
        let (before, between, after) = match stage {
            Stage::After => (Stage::Before, Stage::Running, stage),
            Stage::AddedAfter => (Stage::AddedBefore, Stage::Running, stage),
            Stage::Before | Stage::AddedBefore | Stage::Sum | Stage::Running | Stage::Never => {
                (Stage::AddedBefore, stage, Stage::AddedAfter)
            }
        };
        Some(match value {
            _ if is_twice => (before, Some(after)),
            _ if value < 0.0 => (before, None),
            _ if value > 0.0 => (after, None),
            _ => (between, None),
        })
    }
}

impl Variation {
    /// The attribute of its weight.
    pub fn attribute(&self) -> String {
        self.base(&self.number_suffix())
    }

    /// The attribute of its parameter `name`.
    pub fn parameter_attribute(&self, name: &str) -> String {
        format!("{}_{name}", self.attribute())
    }

    /// The attribute of [`Variation::carry`].
    pub fn carry_attribute(&self) -> String {
        self.attribute() + CARRY
    }

    /// The variations of a transform with the numbers that spell them. Numbers count within a stage, and some stages share
    /// names: one that a priority moves gets a number that no other of its name has.
    pub fn spelled(variations: &[Variation]) -> Vec<Variation> {
        let of_name = variations.iter().filter(|variation| variation.is_spelled_by_name());
        let mut taken: HashSet<String> = of_name.map(Variation::attribute).collect();
        let mut spell = |variation: &Variation| {
            if variation.is_spelled_by_name() {
                return *variation;
            }
            let numbers = std::iter::once(variation.number).chain(0..u8::MAX);
            let mut all = numbers.map(|number| Variation { number, ..*variation });
            all.find(|other| taken.insert(other.attribute())).unwrap_or(*variation)
        };
        variations.iter().map(&mut spell).collect()
    }

    /// Whether the name alone says when it is applied.
    fn is_spelled_by_name(&self) -> bool {
        Spelling::of(&self.attribute()).is_some_and(|spelling| spelling.slot.stage == self.stage)
    }

    /// The attributes that are needed besides to say when it is applied, with their values.
    pub fn stage_attributes(&self) -> Vec<(String, f64)> {
        let name = self.attribute();
        let mut found = Vec::new();
        if !self.is_spelled_by_name() {
            let priority = match self.stage {
                Stage::Before | Stage::AddedBefore => -1.0,
                Stage::Sum | Stage::Running | Stage::Never => 0.0,
                Stage::After | Stage::AddedAfter => 1.0,
            };
            found.push((format!("{name}{PRIORITY}"), priority));
        }
        if self.presence != 1.0 {
            found.push((format!("{name}{PRESENCE}"), self.presence));
        }
        found
    }

    fn number_suffix(&self) -> String {
        if self.number == 0 { String::new() } else { format!(".{}", u32::from(self.number) + 1) }
    }

    fn base(&self, suffix: &str) -> String {
        let name = self.kind.name();
        let with = |prefix: &str| format!("{prefix}{name}{suffix}");
        match self.stage {
            // Its name has the prefix.
            _ if self.kind == Kind::PreBlur => with(""),
            Stage::Before | Stage::Never => with("pre_"),
            Stage::After | Stage::Running if own_stage(self.kind, Stage::Sum) == Stage::Sum => with("post_"),
            Stage::AddedBefore | Stage::Sum | Stage::Running | Stage::After | Stage::AddedAfter => with(""),
        }
    }
}

/// The stage of `kind` that is spelled in `stage`.
fn own_stage(kind: Kind, stage: Stage) -> Stage {
    match stage {
        Stage::Sum if kind == Kind::Flatten => Stage::After,
        Stage::Before if IGNORING.contains(&kind) => Stage::AddedBefore,
        Stage::After if IGNORING.contains(&kind) => Stage::AddedAfter,
        Stage::Before
        | Stage::AddedBefore
        | Stage::Sum
        | Stage::Running
        | Stage::After
        | Stage::AddedAfter
        | Stage::Never => stage,
    }
}

fn known(name: &str) -> Option<(Kind, Part)> {
    NAMES.get(name).or_else(|| NAMES.get(&name.to_lowercase())).copied()
}

/// `name` without the number of an occurrence, which is from 2 on in files: `bubble.2_x` is `bubble_x` of number 1.
fn without_number(name: &str) -> (String, u8) {
    let plain = || (name.to_owned(), 0);
    let Some((base, rest)) = name.split_once('.') else { return plain() };
    let end = rest.find(|c: char| !c.is_ascii_digit()).unwrap_or(rest.len());
    match rest[..end].parse::<u8>() {
        Ok(number) if number >= 2 => (format!("{base}{}", &rest[end..]), number - 1),
        Ok(_) | Err(_) => plain(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn spelled(name: &str) -> Option<(Kind, Stage, u8, Part)> {
        Spelling::of(name).map(|Spelling { slot, part }| (slot.kind, slot.stage, slot.number, part))
    }

    #[test]
    fn names_of_all_programs_are_understood() {
        let sum = |kind, part| Some((kind, Stage::Sum, 0, part));
        assert_eq!(spelled("julian_power"), sum(Kind::Julian, Part::Parameter(0)));
        assert_eq!(spelled("oscope_damping"), sum(Kind::Oscilloscope, Part::Parameter(3)));
        assert_eq!(spelled("Mobius_Re_A"), sum(Kind::Mobius, Part::Parameter(0)));
        assert_eq!(spelled("TwinTrian"), sum(Kind::Twintrian, Part::Weight));
        assert_eq!(spelled("pre_gaussian_blur"), sum(Kind::PreBlur, Part::Weight));
        assert_eq!(spelled("pre_blur"), sum(Kind::PreBlur, Part::Weight));
        assert_eq!(spelled("post_curl_c1"), Some((Kind::Curl, Stage::After, 0, Part::Parameter(0))));
        assert_eq!(spelled("pre_pie_slices"), Some((Kind::Pie, Stage::AddedBefore, 0, Part::Parameter(0))));
        assert_eq!(spelled("bubble.3"), Some((Kind::Bubble, Stage::Sum, 2, Part::Weight)));
        assert_eq!(spelled("julian.2_power"), Some((Kind::Julian, Stage::Sum, 1, Part::Parameter(0))));
        assert_eq!(spelled("bubble.2_fx_priority"), Some((Kind::Bubble, Stage::Sum, 1, Part::Priority)));
        assert_eq!(spelled("pre_curl.presence"), Some((Kind::Curl, Stage::Before, 0, Part::Presence)));
        assert_eq!(spelled("bubble.2.z"), Some((Kind::Bubble, Stage::Sum, 1, Part::Carry)));
        assert_eq!(spelled("flatten"), Some((Kind::Flatten, Stage::After, 0, Part::Weight)));
        for unknown in ["waltz", "julian_waltz", "pre_", "julian.1", "julian_power_fx_priority", "pre_post_curl", ""] {
            assert_eq!(spelled(unknown), None, "{unknown}");
        }
    }

    #[test]
    fn a_priority_applies_a_variation_where_jwildfire_does() {
        use Stage::{AddedAfter, AddedBefore, After, Before, Never, Running, Sum};
        let of = |name: &str, value: f64| {
            let stages = Spelling::stages_of_priority(Spelling::of(name).unwrap().slot, value);
            stages.map(|(first, second)| std::iter::once(first).chain(second).collect::<Vec<_>>())
        };
        let all = |name: &str| [-3.0, -2.0, -1.0, 0.0, 1.0, 2.0, 3.0].map(|value| of(name, value).unwrap());
        let (before, after) = (vec![AddedBefore], vec![AddedAfter]);
        let both = vec![AddedBefore, AddedAfter];
        let plain = [before.clone(), both.clone(), before, vec![Sum], after.clone(), both, after];
        assert_eq!(all("spherical"), plain);
        let both = vec![Before, After];
        let later = [vec![Before], both.clone(), vec![Before], vec![Running], vec![After], both, vec![After]];
        assert_eq!(all("post_spherical"), later);
        assert_eq!(all("flatten"), later);
        let earlier = [Before, Before, Before, Never, Never, Before, Never].map(|stage| vec![stage]);
        assert_eq!(all("pre_spherical"), earlier);
        assert_eq!(of("pre_blur", 1.0), Some(vec![Never]));
        assert_eq!(of("spherical", 0.5), None);
        assert_eq!(of("spherical", f64::NAN), None);
    }

    #[test]
    fn every_variation_is_found_by_what_is_written_of_it() {
        let stages = [
            Stage::Before,
            Stage::AddedBefore,
            Stage::Sum,
            Stage::Running,
            Stage::After,
            Stage::AddedAfter,
            Stage::Never,
        ];
        // A blur is always added; what has a stage of its own has few others.
        let exists = |kind: Kind, stage: Stage| {
            if kind == Kind::PreBlur {
                matches!(stage, Stage::Sum | Stage::Never)
            } else if kind == Kind::Flatten {
                matches!(stage, Stage::After | Stage::Running)
            } else if IGNORING.contains(&kind) {
                let is_other = matches!(stage, Stage::Before | Stage::After | Stage::Running);
                !is_other && (stage != Stage::Never || !matches!(kind, Kind::Blur | Kind::GaussianBlur))
            } else {
                true
            }
        };
        for (kind, stage, number) in Kind::ALL
            .into_iter()
            .flat_map(|kind| stages.map(|stage| [(kind, stage, 0), (kind, stage, 4)]))
            .flatten()
            .filter(|(kind, stage, _)| exists(*kind, *stage))
        {
            let variation = Variation { stage, number, ..Variation::new(kind, 1.0) };
            let weight = Spelling::of(&variation.attribute()).unwrap();
            assert_eq!((weight.slot.kind, weight.slot.number, weight.part), (kind, number, Part::Weight));
            let priority = variation.stage_attributes().first().map(|(_, value)| *value);
            let found = priority
                .map_or(Some((weight.slot.stage, None)), |value| Spelling::stages_of_priority(weight.slot, value));
            assert!(found == Some((stage, None)), "{kind:?} {stage:?} became {found:?}");
            for (index, parameter) in kind.parameters().iter().enumerate() {
                let found = Spelling::of(&variation.parameter_attribute(parameter.name)).unwrap();
                assert_eq!((found.slot.kind, found.part), (kind, Part::Parameter(index)));
            }
        }
    }
}
