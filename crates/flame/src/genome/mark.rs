//! The mark of a genome that is drawn without the variations that are not known in full.
//!
//! Owns the attribute that names what is unknown, variations and parameters of known variations, and what it takes out of
//! the genome. Never decides that something is left out: the artist does.
//!
//! Start at [`Genome::as_far_as_possible`].

use super::names::{Names, Parameter};
use super::{Genome, Xform};
use variations::{Slot, Spelling};

/// The attribute of `<flame>` that names the unknown variations without which it is drawn, and the unknown parameters
/// without whose variations it is.
pub const MARK: &str = "drawn_without";

impl Genome {
    /// The same genome, to be drawn without its unknown variations and without those that have unknown parameters: an
    /// attribute of its own names both.
    #[must_use]
    pub fn as_far_as_possible(&self) -> Genome {
        let names = self.unsupported().mark();
        let mut genome = self.clone().unmarked();
        genome.extra.extend(names.map(|names| (MARK.to_owned(), names)));
        genome.leave_out();
        genome
    }

    /// Leaves out the variations whose parameters the mark names.
    pub(super) fn leave_out(&mut self) {
        let marked: Vec<String> = self.marked().into_iter().map(str::to_owned).collect();
        if !marked.is_empty() {
            self.xforms.iter_mut().chain(&mut self.finals).for_each(|xform| xform.leave_out(&marked));
        }
    }

    /// The genome without its mark, with all its variations.
    #[must_use]
    pub(super) fn unmarked(mut self) -> Genome {
        self.extra.retain(|(name, _)| name != MARK);
        for xform in self.xforms.iter_mut().chain(&mut self.finals) {
            xform.variations.append(&mut xform.left_out);
            xform.motions.iter_mut().for_each(|it| it.added.variations.append(&mut it.added.left_out));
        }
        self
    }

    /// A marked genome without its mark and what it names, with the parameters: its picture is the same.
    pub(crate) fn without_left_out(mut self) -> Genome {
        let marked: Vec<String> = self.marked().into_iter().map(str::to_owned).collect();
        let is_of = |name: &str, unknown: &String| {
            name.strip_prefix(&**unknown).is_some_and(|rest| rest.is_empty() || rest.starts_with('_'))
        };
        let is_drawn = |(name, _): &(String, String)| !marked.iter().any(|unknown| is_of(name, unknown));
        if !marked.is_empty() {
            for xform in self.xforms.iter_mut().chain(&mut self.finals) {
                xform.extra.retain(is_drawn);
                xform.left_out.clear();
                for motion in &mut xform.motions {
                    motion.added.extra.retain(is_drawn);
                    motion.added.left_out.clear();
                }
            }
        }
        self.unmarked()
    }

    /// What the mark names.
    pub(super) fn marked(&self) -> Vec<&str> {
        self.extra.iter().filter(|(name, _)| name == MARK).flat_map(|(_, names)| names.split_whitespace()).collect()
    }
}

impl Xform {
    /// Leaves out the variations that have one of the `marked` parameters, here or in a motion.
    fn leave_out(&mut self, marked: &[String]) {
        let (mut slots, mut of_motions): (Vec<Slot>, Vec<Slot>) = (Vec::new(), Vec::new());
        for extra in std::iter::once(&self.extra).chain(self.motions.iter().map(|motion| &motion.added.extra)) {
            let is_marked = |name: &&String| marked.contains(name);
            let mut unknown = extra.iter().map(|(name, _)| name).filter(is_marked).peekable();
            if unknown.peek().is_some() {
                let names = Names::of(extra, self);
                for Parameter { variation, of } in unknown.filter_map(|name| names.parameter(name)) {
                    slots.push(variation.slot());
                    // No priority moves what a motion adds.
                    of_motions.extend(Spelling::of(of).map(|spelling| spelling.slot));
                }
            }
        }
        self.part(&slots);
        of_motions.extend(slots);
        self.motions.iter_mut().for_each(|motion| motion.added.part(&of_motions));
    }

    fn part(&mut self, slots: &[Slot]) {
        self.left_out.extend(self.variations.extract_if(.., |variation| slots.contains(&variation.slot())));
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Reasons, Why};
    use super::*;

    fn genome(attributes: &str, inside: &str) -> Genome {
        let xform = format!("<xform weight='1' linear='1' {attributes}>{inside}</xform>");
        Genome::parse(&format!("<flame>{xform}<xform weight='1' fdisc='0.4'/></flame>")).unwrap()
    }

    fn names(reasons: &Reasons) -> Vec<(&str, &str, Why)> {
        let own = reasons.0.iter();
        own.map(|reason| (&*reason.name, reason.variation.as_deref().unwrap_or_default(), reason.why)).collect()
    }

    #[test]
    fn an_unknown_parameter_refuses_a_genome_or_leaves_out_its_variation_alone() {
        let plain = genome("fdisc='0.5' fdisc_ashift='0.3' fdisc.2='0.2' pre_fdisc='0.1' fdisc_zero='0'", "");
        assert_eq!(names(&plain.unsupported().refused), [("fdisc_ashift", "fdisc", Why::Parameter)]);
        let marked = plain.as_far_as_possible();
        assert_eq!(marked.extra, [(MARK.to_owned(), "fdisc_ashift".to_owned())]);
        let drawn: Vec<f64> = marked.xforms[0].variations.iter().map(|variation| variation.weight).collect();
        assert_eq!((drawn, marked.xforms[1].variations.len()), (vec![1.0, 0.2, 0.1], 1));
        let found = marked.unsupported();
        assert!(found.refused.is_empty(), "{found:?}");
        assert_eq!(names(&found.without), [("fdisc_ashift", "fdisc", Why::LeftOut)]);
        assert_eq!(found, plain.unsupported().as_far_as_possible());
        let read = Genome::parse(&marked.to_xml()).unwrap();
        assert_eq!((&read, read.as_far_as_possible()), (&marked, marked.clone()));
        let bred = marked.without_left_out();
        assert_eq!((bred.unsupported(), bred.xforms[0].variations.len()), (genome("", "").unsupported(), 3));
    }

    #[test]
    fn a_variation_that_a_priority_moves_is_left_out_too() {
        let plain = genome("fdisc='0.5' fdisc_fx_priority='1' fdisc_ashift='0.3' fdisc.2='0.2'", "");
        let marked = plain.as_far_as_possible();
        let left: Vec<f64> = marked.xforms[0].left_out.iter().map(|variation| variation.weight).collect();
        assert_eq!(left, [0.5]);
        assert_eq!(Genome::parse(&marked.to_xml()).unwrap(), marked);
    }

    #[test]
    fn a_variation_of_weight_0_has_no_say_unless_a_motion_adds_to_it() {
        let motion = "<motion motion_frequency='1' motion_function='sin' fdisc='1'/>";
        assert!(genome("fdisc='0' fdisc_ashift='0.3'", "").unsupported().refused.is_empty());
        let moved = genome("fdisc='0' fdisc_ashift='0.3'", motion);
        assert_eq!(names(&moved.unsupported().refused), [("fdisc_ashift", "fdisc", Why::Parameter)]);
        let marked = moved.as_far_as_possible();
        assert!(marked.unsupported().refused.is_empty());
        assert_eq!(marked.xforms[0].motions[0].added.variations, []);
        assert_eq!(Genome::parse(&marked.to_xml()).unwrap(), marked);
        let of_motion = genome("fdisc='1'", &motion.replace("fdisc=", "fdisc_ashift="));
        let found = of_motion.unsupported().refused;
        assert_eq!(
            (names(&found), &*found.0[0].place),
            (vec![("fdisc_ashift", "fdisc", Why::Parameter)], "a motion of transform 0")
        );
        assert_eq!(of_motion.as_far_as_possible().xforms[0].left_out.len(), 1);
    }
}
