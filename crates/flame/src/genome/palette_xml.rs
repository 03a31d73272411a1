//! The forms in which flam3 XML gives colours.
//!
//! Owns the reading of `<color>`, `<colors>` and `<palette>`; `write.rs` writes them.
//!
//! Start at [`read`].

use roxmltree::Node;

use super::parse::{list, place, shown};
use super::value::integer;
use super::{Genome, GenomeError, Palette};

/// A place that no colour has been given for.
const MISSING: [f64; 4] = [f64::NAN; 4];

/// Whether `node` has colours itself, rather than the number of a palette in flam3's library.
pub(super) fn has_colours(node: Node) -> bool {
    match node.tag_name().name() {
        "color" => true,
        "colors" => node.has_attribute("data"),
        _ => node.has_attribute("format") || node.text().is_some_and(|text| !text.trim().is_empty()),
    }
}

/// Puts the colours of `node` into the genome's palette.
pub(super) fn read(node: Node, genome: &mut Genome) -> Result<(), GenomeError> {
    let palette = genome.palette.get_or_insert_with(|| Palette::from_fn(|_| MISSING));
    match node.tag_name().name() {
        "color" => {
            let (index, colour) = single(node)?;
            palette.entries[index] = colour;
        }
        "colors" => {
            let data = node.attribute("data").unwrap_or_default();
            *palette = Palette::resampled(&hex(node, data, 8, 2)?);
        }
        _ => {
            let format = node.attribute("format").unwrap_or("RGB");
            let digits = match format {
                "RGB" => 6,
                "RGBA" => 8,
                _ => return Err(refuse(node, &format!("format `{format}`"), "format `RGB` or `RGBA`")),
            };
            *palette = Palette::resampled(&hex(node, node.text().unwrap_or_default(), digits, 0)?);
        }
    }
    Ok(())
}

/// Fills places without a colour from their neighbours, around the end.
pub(super) fn fill(genome: &mut Genome) {
    let Some(Palette { entries }) = &mut genome.palette else { return };
    let given: Vec<usize> = (0..Palette::LEN).filter(|i| !entries[*i][0].is_nan()).collect();
    let known = entries.clone();
    for (place, &low) in given.iter().enumerate() {
        let high = given[(place + 1) % given.len()];
        let gap = (high + Palette::LEN - low - 1) % Palette::LEN + 1;
        for step in 1..gap {
            let part = step as f64 / gap as f64;
            entries[(low + step) % Palette::LEN] =
                std::array::from_fn(|c| known[low][c] * (1.0 - part) + known[high][c] * part);
        }
    }
}

/// `<color index rgb/>` or `<color index rgba/>`: alpha of the latter in `0.0..=255.0`.
fn single(node: Node) -> Result<(usize, [f64; 4]), GenomeError> {
    let index = node.attribute("index").unwrap_or_default();
    let index = match integer::<usize>(index) {
        Some(index) if index < Palette::LEN => index,
        _ => return Err(refuse(node, &format!("index `{index}`"), "an index of 0 to 255")),
    };
    let value = node.attribute("rgba").or(node.attribute("rgb")).unwrap_or_default();
    match list(value).as_deref() {
        Some(&[red, green, blue]) => Ok((index, [red, green, blue, 255.0])),
        Some(&[red, green, blue, alpha]) => Ok((index, [red, green, blue, alpha])),
        _ => Err(refuse(node, &format!("colour `{value}`"), "three numbers or four")),
    }
}

/// The note on the colours of `node` if they are not 256: the 256 that are drawn are blended from them.
pub(super) fn note(node: Node) -> Option<String> {
    let is_palette = matches!(node.tag_name().name(), "palette" | "colors") && has_colours(node);
    let count = is_palette.then(|| count(node)).flatten().filter(|count| *count != Palette::LEN)?;
    Some(format!("its palette has {count} colours, drawn as {}", Palette::LEN))
}

/// How many colours `node` says that it has: 256 unless it says otherwise.
fn count(node: Node) -> Option<usize> {
    node.attribute("count").map_or(Some(Palette::LEN), |count| integer(count).filter(|count| *count > 0))
}

/// The colours of `digits` hexadecimal digits each, of which the first `skip` mean nothing: as many as `node` says.
pub(super) fn hex(node: Node, text: &str, digits: usize, skip: usize) -> Result<Vec<[f64; 4]>, GenomeError> {
    let symbols: Vec<u8> = text.bytes().filter(|byte| !byte.is_ascii_whitespace()).collect();
    if count(node).is_none_or(|count| count.checked_mul(digits) != Some(symbols.len())) {
        let found = format!("{} digits", symbols.len());
        return Err(refuse(node, &found, "256 colours, or as many as its `count`, of 6 or 8 digits"));
    }
    let mut entries = Vec::with_capacity(symbols.len() / digits);
    for colour in symbols.chunks(digits) {
        let mut entry = [255.0; 4];
        for (slot, pair) in entry.iter_mut().zip(colour[skip..].chunks(2)) {
            let pair = String::from_utf8_lossy(pair);
            let Ok(byte) = u8::from_str_radix(&pair, 16) else {
                return Err(refuse(node, &format!("digits `{pair}`"), "hexadecimal digits"));
            };
            *slot = f64::from(byte);
        }
        entries.push(entry);
    }
    Ok(entries)
}

/// The number of a palette in the attribute `name`.
pub(super) fn index(node: Node, name: &str) -> Result<i32, GenomeError> {
    let value = node.attribute(name).unwrap_or_default();
    integer(value).ok_or_else(|| refuse(node, &format!("{name} `{value}`"), "a whole number"))
}

fn refuse(node: Node, found: &str, expected: &'static str) -> GenomeError {
    GenomeError::Palette { place: place(node), element: shown(node.tag_name().name()), found: shown(found), expected }
}
