//! The colours of genomes that only name them.
//!
//! Owns where flam3's palettes lie and what is told if they are missing. `flame` reads them; none of them is ours to ship.
//!
//! Start at [`coloured`].

use std::path::{Path, PathBuf};
use std::{env, fs, io};

use flame::genome::{Genome, GenomeError, Library};

/// Names another file of palettes, as it does for flam3's own programs.
const VARIABLE: &str = "flam3_palettes";

/// Where Debian's `flam3-palette` puts them.
const FILE: &str = "/usr/share/flam3/flam3-palettes.xml";

/// A genome whose palette is not at hand.
#[derive(Debug, thiserror::Error)]
pub enum PaletteError {
    /// The library cannot be read.
    #[error(
        "cannot read the palettes that the genome names by number, `{path}`: install flam3's (Debian: `flam3-palette`) or \
         name another file in `{VARIABLE}`"
    )]
    Library {
        /// Its file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// The library is none, or lacks the palette.
    #[error("cannot take the genome's colours from `{path}`")]
    Palette {
        /// Its file.
        path: PathBuf,
        /// Why.
        source: GenomeError,
    },
}

/// `genome` with the colours that it names, from the library that is installed.
/// Errors: [`PaletteError`] if it needs one that is missing.
pub fn coloured(genome: Genome) -> Result<Genome, PaletteError> {
    let place = env::var_os(VARIABLE).map_or_else(|| PathBuf::from(FILE), PathBuf::from);
    coloured_from(genome, &place)
}

fn coloured_from(genome: Genome, place: &Path) -> Result<Genome, PaletteError> {
    if !genome.needs_library() {
        return Ok(genome);
    }
    let path = || place.to_owned();
    let text = fs::read_to_string(place).map_err(|source| PaletteError::Library { path: path(), source })?;
    let coloured = Library::parse(&text).and_then(|library| genome.with_library(&library));
    coloured.map_err(|source| PaletteError::Palette { path: path(), source })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::program::chain;

    #[test]
    fn a_genome_that_names_a_palette_gets_its_colours_or_says_what_to_install() {
        let folder = tempfile::tempdir().unwrap();
        let place = folder.path().join("palettes.xml");
        let genome = |attributes: &str| Genome::parse(&format!("<flame {attributes}/>")).unwrap();
        assert_eq!(coloured_from(genome("hue=\"0.5\""), &place).unwrap(), genome("hue=\"0.5\""));
        let named = || genome("palette=\"7\"");
        let missing = chain(&coloured_from(named(), &place).unwrap_err());
        for part in ["palettes.xml", "flam3-palette", "flam3_palettes", "No such file"] {
            assert!(missing.contains(part), "{missing}");
        }
        let of = |number: i32| {
            format!("<palettes><palette number=\"{number}\" data=\"{}\"/></palettes>", "00102030".repeat(256))
        };
        fs::write(&place, of(8)).unwrap();
        let lacking = chain(&coloured_from(named(), &place).unwrap_err());
        assert!(lacking.contains("palettes.xml") && lacking.contains("palette 7 is not among the 1"), "{lacking}");
        fs::write(&place, of(7)).unwrap();
        let palette = coloured_from(named(), &place).unwrap().palette.unwrap();
        assert_eq!(palette.entries[255].map(|channel| channel as u8), [16, 32, 48, 255]);
    }
}
