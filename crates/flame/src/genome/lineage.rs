//! Lineage in a flame's file: an `<edit>` element, one generation deep, and the attribute `licence`.
//!
//! Owns how it is written: the parents are `<sheep>` elements in the `<edit>`, and each author is an `<edit>` in it, as if
//! that had been an earlier one. Reading is `origin.rs`'s, which knows the genealogies of Electric Sheep too.
//!
//! Start at [`Genome::with_lineage`].

use species::Lineage;

use super::origin::{Number, attribute, is_of_origin, number, number_in_name};
use super::{Element, Genome};

impl Genome {
    /// What the file says of the genome's origin, as all species say it.
    pub fn lineage(&self) -> Lineage {
        let origin = self.origin();
        let edit = self.children.iter().find(|child| child.tag == "edit");
        let said = |name: &str| edit.and_then(|edit| attribute(&edit.attributes, name)).map(ToOwned::to_owned);
        let id = edit.and_then(number).or_else(|| number_in_name(self.name.as_deref()?));
        Lineage {
            id: id.map(Number::name),
            parents: origin.parents,
            operator: said("action"),
            date: said("date"),
            authors: origin.authors,
            licence: origin.licence,
        }
    }

    /// The same genome, whose file says this of its origin and nothing else. Authors of what was made of others are not its
    /// designers.
    #[must_use]
    pub fn with_lineage(&self, lineage: &Lineage) -> Genome {
        let mut genome = self.clone();
        genome.children.retain(|child| child.tag != "edit" && child.tag != "sheep");
        genome.extra.retain(|(name, _)| !is_of_origin(name));
        genome.extra.extend(lineage.licence.iter().map(|licence| ("licence".to_owned(), clean(licence))));
        let mut edit = Element { tag: "edit".into(), ..Element::default() };
        let own = [("date", &lineage.date), ("id", &lineage.id), ("action", &lineage.operator)];
        for (name, value) in own.into_iter().filter_map(|(name, value)| Some((name, value.as_ref()?))) {
            edit.set(name, clean(value));
        }
        for parent in &lineage.parents {
            let mut sheep = Element { tag: "sheep".into(), ..Element::default() };
            sheep.set("id", clean(parent));
            edit.children.push(sheep);
        }
        let mut authors = lineage.authors.iter();
        if lineage.parents.is_empty() && lineage.operator.is_none() {
            authors.by_ref().take(1).for_each(|designer| set_author(&mut edit, designer));
        }
        for author in authors {
            let mut earlier = Element { tag: "edit".into(), ..Element::default() };
            set_author(&mut earlier, author);
            edit.children.push(earlier);
        }
        if !edit.attributes.is_empty() || !edit.children.is_empty() {
            genome.children.push(edit);
        }
        genome
    }
}

/// Names the author `name` or `name <address>` of an edit.
fn set_author(edit: &mut Element, author: &str) {
    match author.strip_suffix('>').and_then(|author| author.split_once(" <")) {
        Some((nick, url)) => {
            edit.set("nick", clean(nick));
            edit.set("url", clean(url));
        }
        None => edit.set("nick", clean(author)),
    }
}

/// A text without what XML cannot hold.
fn clean(text: &str) -> String {
    text.chars().filter(|letter| !letter.is_control() && !('\u{fffe}'..='\u{ffff}').contains(letter)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lineage_reads_back_from_a_file_and_replaces_another_one() {
        let text = |texts: &[&str]| texts.iter().map(ToString::to_string).collect::<Vec<String>>();
        let bred = Lineage {
            id: Some("7.00412".into()),
            parents: text(&["7.00400", "electric & <sheep>"]),
            operator: Some("alternation".into()),
            date: Some("2026-11-25".into()),
            authors: text(&["ann <a.example>", "bob \"b\"", "cy"]),
            licence: Some("CC-BY-NC-3.0".into()),
        };
        let designed = Lineage { authors: text(&["ann", "bob"]), ..Lineage::default() };
        let old = "<flame nick=\"zed\" licence=\"x\" made=\"here\"><edit id=\"1\"><edit nick=\"zed\"/></edit></flame>";
        let old = Genome::parse(old).unwrap();
        for lineage in [&bred, &designed, &Lineage::default()] {
            let written = old.with_lineage(lineage).to_xml();
            let read = Genome::parse(&written).unwrap();
            assert_eq!(read.lineage(), *lineage, "{written}");
            assert_eq!(read.extra[0], ("made".to_owned(), "here".to_owned()), "what is not of its origin stays");
            assert!(!written.contains("zed"), "{written}");
        }
        assert!(!old.with_lineage(&bred).origin().designed && old.with_lineage(&designed).origin().designed);
        let odd = Lineage { licence: Some("a\u{1}b".into()), ..Lineage::default() };
        assert_eq!(Genome::parse(&old.with_lineage(&odd).to_xml()).unwrap().lineage().licence.as_deref(), Some("ab"));
    }
}
