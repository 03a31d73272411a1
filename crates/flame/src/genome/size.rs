//! The memory that a genome takes.
//!
//! Owns the count of its bytes: a frame has a genome for each of its moments.

use super::{Element, Genome, Xform};

impl Genome {
    /// Its size in memory, with what it owns.
    pub(crate) fn bytes(&self) -> u64 {
        let palette = self.palette.iter().map(|palette| size_of_val(&palette.entries[..])).sum::<usize>();
        let xforms = self.xforms.iter().chain(&self.finals).map(of_xform).sum::<usize>();
        let own = size_of::<Genome>() + self.name.as_ref().map_or(0, String::len) + size_of_val(&self.symmetries[..]);
        (own + self.finish.bytes() + palette + xforms + of_pairs(&self.extra) + of_elements(&self.children)) as u64
    }
}

fn of_xform(xform: &Xform) -> usize {
    let waves = xform.motions.iter().map(|wave| size_of_val(wave) + of_xform(&wave.added)).sum::<usize>();
    let variations = size_of_val(&xform.variations[..]) + size_of_val(&xform.left_out[..]);
    let numbers = size_of_val(&xform.chaos[..]) + variations;
    size_of::<Xform>() + numbers + waves + of_pairs(&xform.extra) + of_elements(&xform.children)
}

fn of_pairs(pairs: &[(String, String)]) -> usize {
    size_of_val(pairs) + pairs.iter().map(|(key, value)| key.len() + value.len()).sum::<usize>()
}

fn of_elements(elements: &[Element]) -> usize {
    let of = |element: &Element| {
        let own = size_of::<Element>() + element.tag.len() + element.text.len();
        own + of_pairs(&element.attributes) + of_elements(&element.children)
    };
    elements.iter().map(of).sum()
}
