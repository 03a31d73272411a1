//! Where a genome comes from, as its file says.
//!
//! Owns the reading of the names of authors (`nick`, `url`), of a licence, and of the genealogy in `<edit>` elements, as
//! flam3 and Electric Sheep write them: the outermost `<edit>` made this genome, those in it made its parents, which may be
//! `<sheep>` in it, too. Never
//! guesses: what no file says is left out.
//!
//! Start at [`Genome::origin`].

use super::{Element, Genome};

/// The `nick` of genomes that Electric Sheep's program has bred.
const BROOD: &str = "brood";

/// The attributes of a flame that tell who made it when.
const OF_ORIGIN: [&str; 7] = ["comment", "licence", "license", "nick", "notes", "url", "version"];

/// What a genome's file says of its origin.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Origin {
    /// The authors of the genome and of its ancestors, each once, its own first: `nick` or `nick <url>`.
    pub authors: Vec<String>,
    /// The value of the attribute `licence` or `license`, as written.
    pub licence: Option<String>,
    /// The genomes that it was made from: `GENERATION.NUMBER`, or the number alone where the file has no generation.
    pub parents: Vec<String>,
    /// Whether a person is named as its designer.
    pub designed: bool,
    /// Whether a program has bred it, or one of its ancestors.
    pub bred: bool,
}

impl Genome {
    /// What the file says of the genome's origin.
    pub fn origin(&self) -> Origin {
        let of_flame = |name: &str| attribute(&self.extra, name);
        let edits = || self.children.iter().filter(|child| child.tag == "edit");
        let mut origin = Origin {
            licence: of_flame("licence").or_else(|| of_flame("license")).map(str::to_owned),
            ..Origin::default()
        };
        origin.add_author(&self.extra);
        edits().for_each(|edit| origin.add_author(&edit.attributes));
        origin.designed = !origin.authors.is_empty();
        let named = self.name.as_deref().and_then(number_in_name);
        for edit in edits() {
            let own = named.or_else(|| number(edit)).unwrap_or_default();
            origin.walk(edit);
            parents(edit, own, &mut origin.parents);
        }
        origin
    }

    /// The genome without what differs between two copies of it in files of Electric Sheep: the time in the file, and who
    /// made it when; and without the mark of one that is drawn as far as possible.
    #[must_use]
    pub fn anonymous(&self) -> Genome {
        let mut genome = Genome { name: None, time: 0.0, ..self.clone() };
        genome.children.retain(|child| child.tag != "edit" && child.tag != "sheep");
        genome.extra.retain(|(name, _)| !is_of_origin(name));
        genome.unmarked()
    }
}

impl Origin {
    /// Adds the author that `attributes` name.
    fn add_author(&mut self, attributes: &[(String, String)]) {
        let Some(nick) = attribute(attributes, "nick").filter(|nick| !nick.eq_ignore_ascii_case(BROOD)) else { return };
        if self.authors.iter().all(|author| name_of(author) != nick) {
            let url = attribute(attributes, "url");
            self.authors.push(url.map_or(nick.to_owned(), |url| format!("{nick} <{url}>")));
        }
    }

    /// Adds the authors of `edit` and of those in it, and looks whether a program has bred them.
    fn walk(&mut self, edit: &Element) {
        self.add_author(&edit.attributes);
        let breeds = |value: &str| value.to_ascii_lowercase().contains(BROOD);
        self.bred |= edit.attributes.iter().any(|(_, value)| breeds(value));
        edit.children.iter().filter(|child| child.tag == "edit").for_each(|child| self.walk(child));
    }
}

/// Whether an attribute of a flame tells who made it when.
pub(super) fn is_of_origin(name: &str) -> bool {
    OF_ORIGIN.contains(&name)
}

/// The name of an author without the address.
pub fn name_of(author: &str) -> &str {
    author.split_once(" <").map_or(author, |(name, _)| name)
}

/// Adds the nearest ancestors below `edit` that are not the genome `own` itself, which may be in there several times.
fn parents(edit: &Element, own: Number<'_>, found: &mut Vec<String>) {
    for child in edit.children.iter().filter(|child| child.tag == "edit" || child.tag == "sheep") {
        match number(child).filter(|number| !number.may_be(own)) {
            Some(number) => {
                let parent = number.name();
                if !found.contains(&parent) {
                    found.push(parent);
                }
            }
            None => parents(child, own, found),
        }
    }
}

/// What Electric Sheep calls a genome: a number, and the generation if the file has it.
#[derive(Clone, Copy, Default)]
pub(super) struct Number<'a> {
    generation: Option<&'a str>,
    id: &'a str,
}

impl Number<'_> {
    /// `GENERATION.NUMBER`, or the number alone.
    pub(super) fn name(self) -> String {
        self.generation.map_or(self.id.to_owned(), |generation| format!("{generation}.{}", self.id))
    }

    fn may_be(self, other: Number<'_>) -> bool {
        let differ = self.generation.zip(other.generation).is_some_and(|(a, b)| a != b);
        self.id == other.id && !differ
    }
}

/// The number of the genome that `edit` made.
pub(super) fn number(edit: &Element) -> Option<Number<'_>> {
    let id = attribute(&edit.attributes, "id")?;
    Some(Number { generation: attribute(&edit.attributes, "gen"), id })
}

/// The number in a name such as `electricsheep.247.00505`.
pub(super) fn number_in_name(name: &str) -> Option<Number<'_>> {
    let (generation, id) = name.strip_prefix("electricsheep.")?.split_once('.')?;
    Some(Number { generation: Some(generation), id: id.trim_start_matches('0') })
}

/// The value of an attribute, trimmed, if it is not empty.
pub(super) fn attribute<'a>(attributes: &'a [(String, String)], name: &str) -> Option<&'a str> {
    let found = attributes.iter().find(|(other, _)| other == name).map(|(_, value)| value.trim());
    found.filter(|value| !value.is_empty())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn origin(flame: &str) -> Origin {
        Genome::parse(flame).unwrap().origin()
    }

    #[test]
    fn a_genome_tells_its_authors_its_parents_and_who_bred_it() {
        // As Electric Sheep's server writes it: the outermost edit is of the sheep itself, and so is the one in it.
        let bred = origin(
            r#"<flame name="electricsheep.247.00505" time="0">
            <edit date="2013" action="clone"><edit id="505" gen="247" action="clone brood">
              <edit id="387" gen="247" action="cross alternate 0: 1 0"><edit id="27045" gen="244" action="clone brood">
                <edit nick="cqfd93" url="sylvie.example" id="21854" action="clone upload"/></edit></edit>
              <edit id="22031" action="clone"/>
            </edit></edit></flame>"#,
        );
        assert_eq!(bred.authors, ["cqfd93 <sylvie.example>"]);
        assert_eq!(bred.parents, ["247.387", "22031"]);
        assert!(bred.bred && !bred.designed, "a designer among the ancestors is not the designer");
        let designed = origin(
            r#"<flame nick="Ursitti" url="jam.example" licence=" CC BY 4.0 " time="180">
            <edit nick="Ursitti" id="76" action="clone upload"><edit filename="upload" index="0"/></edit></flame>"#,
        );
        assert_eq!((designed.authors.as_slice(), designed.designed), (&["Ursitti <jam.example>".to_owned()][..], true));
        assert_eq!((designed.licence.as_deref(), designed.bred), (Some("CC BY 4.0"), false));
        assert_eq!(designed.parents, [] as [&str; 0]);
        let crossed = "<flame><edit action=\"cross\"><edit id=\"1\" gen=\"9\"/><edit id=\"2\"/></edit></flame>";
        assert_eq!(origin(crossed).parents, ["9.1", "2"]);
        assert_eq!(origin(&crossed.replace("<edit id=\"2\"", "<sheep id=\"2\"")).parents, ["9.1", "2"]);
        assert_eq!(origin("<flame nick=\"brood\"/>"), Origin::default());
        assert_eq!(origin("<flame nick=\" \"/>"), Origin::default());
    }

    #[test]
    fn copies_of_a_genome_differ_in_nothing_but_time_and_origin() {
        let genome = |attributes: &str, edit: &str| {
            let xform = r#"<xform weight="1" color="0" linear="1" coefs="1 0 0 1 0 0"/>"#;
            Genome::parse(&format!("<flame scale=\"9\" {attributes}>{xform}{edit}</flame>")).unwrap().anonymous()
        };
        let alone = genome("time=\"0\" name=\"electricsheep.242.00076\"", "<edit nick=\"Ursitti\"/>");
        assert_eq!(alone, genome("time=\"180\" nick=\"Ursitti\"", ""));
        assert_ne!(alone, genome("time=\"0\" hue=\"0.5\"", ""));
    }
}
