//! Which program wrote a genome.
//!
//! Owns the marks by which a file shows it: the attribute `version`, or else attributes that only one program writes.
//! Never decides how such a genome is drawn.
//!
//! Start at [`Genome::program`].

use super::Genome;
use super::origin::attribute;

/// A program that writes genomes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Program {
    /// Apophysis, and Apophysis 7X.
    Apophysis,
    /// flam3, and what draws with it, as Electric Sheep.
    Flam3,
    /// FLAM3H for Houdini.
    Flam3h,
    /// Fractorium, whose renderer is called EMBER.
    Fractorium,
    /// JWildfire.
    JWildfire,
}

impl Program {
    /// Its name, as its authors write it.
    pub fn name(self) -> &'static str {
        match self {
            Program::Apophysis => "Apophysis",
            Program::Flam3 => "flam3",
            Program::Flam3h => "FLAM3H",
            Program::Fractorium => "Fractorium",
            Program::JWildfire => "JWildfire",
        }
    }

    /// The program that writes such a `version`.
    fn of_version(version: &str) -> Option<Program> {
        let version = version.to_ascii_lowercase();
        // One that is the beginning of another stands after it.
        let known = [
            ("apo", Program::Apophysis),
            ("ember", Program::Fractorium),
            ("flam3h", Program::Flam3h),
            ("flam3", Program::Flam3),
            ("jwildfire", Program::JWildfire),
        ];
        known.into_iter().find(|(start, _)| version.starts_with(start)).map(|(_, program)| program)
    }
}

impl Genome {
    /// The program that wrote the genome, as `version` says, or else attributes that no other program writes; `None`
    /// where neither is known.
    pub fn program(&self) -> Option<Program> {
        let has = |is_mark: fn(&str) -> bool| self.extra.iter().any(|(name, _)| is_mark(name));
        let of_xforms = || self.xforms.iter().chain(&self.finals).flat_map(|xform| &xform.extra);
        if has(|name| name.starts_with("flam3h_")) {
            return Some(Program::Flam3h);
        }
        attribute(&self.extra, "version").and_then(Program::of_version).or_else(|| {
            // JWildfire writes `new_linear`, too.
            if has(|name| name == "smooth_gradient")
                || of_xforms().any(|(name, _)| name.ends_with(variations::PRIORITY))
            {
                return Some(Program::JWildfire);
            }
            has(|name| name == "new_linear" || name == "plugins").then_some(Program::Apophysis)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_genome_says_which_program_wrote_it() {
        let program = |flame: &str, xform: &str| {
            let text = format!("<flame {flame}><xform weight=\"1\" linear=\"1\" {xform}/></flame>");
            Genome::parse(&text).unwrap().program()
        };
        for (version, expected) in [
            ("EMBER-WIN-1.0.0.19", Some(Program::Fractorium)),
            ("JWildfire V7.30 (27.11.2021)", Some(Program::JWildfire)),
            ("Apophysis 7X.15C", Some(Program::Apophysis)),
            ("FLAM3-LNX-3.1.1", Some(Program::Flam3)),
            ("FLAM3H-LNX-1.9", Some(Program::Flam3h)),
            ("1.0", None),
        ] {
            assert_eq!(program(&format!("version=\"{version}\""), ""), expected, "{version}");
        }
        assert_eq!(program("", ""), None);
        assert_eq!(program("new_linear=\"1\"", ""), Some(Program::Apophysis));
        assert_eq!(program("new_linear=\"1\"", "linear_fx_priority=\"0\""), Some(Program::JWildfire));
        assert_eq!(program("version=\"EMBER-WIN-1\" flam3h_hsv=\"1 1 1\"", ""), Some(Program::Flam3h));
        assert_eq!(program("version=\"EMBER-WIN-1\" new_linear=\"1\"", ""), Some(Program::Fractorium));
    }
}
