//! Unknown attributes of a transform: which are variations, and which parameters, of what.
//!
//! Owns the rule. Where a transform says priorities, as JWildfire's all do, what has one is a variation; elsewhere, what
//! has parameters of its own. What else begins with the name of another variation of the transform is its parameter.
//! Never decides what becomes of either.
//!
//! Start at [`Names::parameter`].

use std::collections::{BTreeMap, HashMap};

use super::Xform;
use variations::{PRIORITY, Part, Slot, Spelling, Variation};

/// Most bytes of a variation's name, with its stage and its number.
const LONGEST: usize = 64;

/// The unknown attributes of a transform, or of its motion, and the variations that they may belong to.
pub(super) struct Names<'a> {
    /// Those whose values are numbers, each with whether one is not 0.
    numbers: BTreeMap<&'a str, bool>,
    /// The variations of the transform, by what files call them.
    variations: HashMap<Slot, Variation>,
    /// The attributes of the transform that are kept.
    kept: &'a [(String, String)],
    says_priorities: bool,
}

/// An unknown parameter of a known variation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Parameter<'n> {
    /// Of which variation of the transform.
    pub(super) variation: Variation,
    /// What the attribute calls that.
    pub(super) of: &'n str,
}

impl<'a> Names<'a> {
    /// The attributes in `extra`, which are those of `xform` or of one of its motions.
    pub(super) fn of(extra: &'a [(String, String)], xform: &'a Xform) -> Names<'a> {
        let mut numbers = BTreeMap::new();
        for (name, value) in extra {
            if let Ok(number) = value.trim().parse::<f64>() {
                *numbers.entry(&**name).or_default() |= number != 0.0;
            }
        }
        let all: Vec<Variation> = xform.variations.iter().chain(&xform.left_out).copied().collect();
        let slot = |it: &Variation| Spelling::of(&it.attribute()).map(|spelling| spelling.slot);
        let slots = Variation::spelled(&all).into_iter().map(|spelled| slot(&spelled));
        let variations = slots.zip(&all).filter_map(|(slot, variation)| Some((slot?, *variation))).collect();
        let kept = &xform.extra;
        let says_priorities = kept.iter().any(|(name, _)| name.ends_with(PRIORITY));
        Names { numbers, variations, kept, says_priorities }
    }

    /// The known variation of which the unknown attribute `name` is a parameter, if it is one.
    pub(super) fn parameter<'n>(&self, name: &'n str) -> Option<Parameter<'n>> {
        let of = |(end, _): (usize, &str)| {
            let of = &name[..end];
            let Spelling { slot, part: Part::Weight } = Spelling::of(of)? else { return None };
            Some(Parameter { variation: *self.variations.get(&slot)?, of })
        };
        let head = &name[..name.floor_char_boundary(LONGEST)];
        head.rmatch_indices('_').find_map(of).filter(|_| !self.is_variation(name))
    }

    /// Whether `name` is of a parameter of another unknown variation: that one is named instead, or has a weight of 0.
    pub(super) fn is_of_unknown(&self, name: &str) -> bool {
        let is_drawn = |(end, _): (usize, &str)| {
            let of = &name[..end];
            self.numbers.get(of).copied().filter(|_| self.parameter(of).is_none())
        };
        let mut variations = name.match_indices('_').filter_map(is_drawn).peekable();
        variations.peek().is_some() && (variations.any(|is_drawn| is_drawn) || !self.has_parameters(name))
    }

    fn is_variation(&self, name: &str) -> bool {
        if !self.says_priorities {
            return self.has_parameters(name);
        }
        let is_its = |kept: &str| kept.strip_suffix(PRIORITY) == Some(name);
        self.kept.iter().any(|(kept, _)| is_its(kept))
    }

    fn has_parameters(&self, name: &str) -> bool {
        let start = format!("{name}_");
        self.numbers.range(&*start..).next().is_some_and(|(next, _)| next.starts_with(&start))
    }
}

#[cfg(test)]
mod tests {
    use super::super::Genome;
    use super::*;

    /// Of which variation each of the unknown attributes of a transform is a parameter; the others are not listed.
    fn parameters(attributes: &str) -> Vec<(String, String)> {
        let text = format!("<flame><xform weight=\"1\" {attributes}/></flame>");
        let xform = &Genome::parse(&text).unwrap().xforms[0];
        let names = Names::of(&xform.extra, xform);
        let own = |(name, _): &(String, String)| Some((name.clone(), names.parameter(name)?.of.to_owned()));
        let is_unknown = |(name, _): &&(String, String)| !name.ends_with(PRIORITY) && !names.is_of_unknown(name);
        xform.extra.iter().filter(is_unknown).filter_map(own).collect()
    }

    #[test]
    fn a_parameter_belongs_to_the_longest_name_of_a_variation_of_its_transform() {
        for (attributes, wanted) in [
            ("fdisc='0.5' fdisc_ashift='0.3'", &[("fdisc_ashift", "fdisc")][..]),
            ("fdisc='0.5' fdisc_mode='fast'", &[("fdisc_mode", "fdisc")]),
            ("pre_fdisc='1' fdisc='1' pre_fdisc_a_b='1'", &[("pre_fdisc_a_b", "pre_fdisc")]),
            ("fdisc='1' fdisc#1#='1' fdisc#1#_a='1'", &[("fdisc.2_a", "fdisc.2")]),
            ("fdisc='1' fdisc.2='1' fdisc.2_fx_priority='1' fdisc.2_a='1'", &[("fdisc.2_a", "fdisc.2")]),
            ("fdisc='1' fdisc_fx_priority='1' fdisc_a='1'", &[("fdisc_a", "fdisc")]),
            ("linear='1' fdisc_ashift='0.3'", &[]),
            ("linear='1' pre_fdisc='1' fdisc_ashift='0.3'", &[]),
        ] {
            let found = parameters(attributes);
            let found: Vec<_> = found.iter().map(|(name, of)| (&**name, &**of)).collect();
            assert_eq!(found, wanted, "{attributes}");
        }
    }

    #[test]
    fn what_has_a_priority_or_parameters_of_its_own_is_a_variation() {
        let plain = "linear='1' linear_t='0.5' linear_t_powX='1.2'";
        let said = "linear='1' linear_fx_priority='0' linear_t='0.5' linear_t_fx_priority='0' linear_t_powX='1.2'";
        for variation in [plain, said] {
            assert_eq!(parameters(variation), [], "{variation}");
        }
        let parameter = "linear='1' linear_fx_priority='0' linear_t='0' linear_t_powX='1.2'";
        assert_eq!(parameters(parameter)[1], ("linear_t_powX".to_owned(), "linear".to_owned()));
    }
}
