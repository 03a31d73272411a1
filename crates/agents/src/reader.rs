//! From a text to a globe.
//!
//! Owns what is refused, with its place, and what is kept though it is not known. Never draws.
//!
//! Start at [`read`].

use std::ops::Range;

use species::Place;
use toml::de::{DeTable, DeValue};
use toml::{Spanned, Table, Value};

use crate::colour::Colour;
use crate::error::AgentsError;
use crate::globe::{Globe, Kept, MOST_AGENTS, MOST_BYTES, MOST_COLOURS, MOST_DUST, MOST_GLOW, MOST_IN_A_GLOBE};
use crate::pfeiffer::Pfeiffer;
use crate::shape::Shape;

/// The head.
const HEAD: &str = "agents";
/// What is known in it.
const KNOWN: [&str; 8] = ["version", "name", "background", "palette", "drift", "glow", "dust", "flock"];
/// Most characters of a name, and of an agent's string.
const LONGEST: [usize; 2] = [80, 4096];
/// Where the file says nothing.
const BACKGROUND: [Colour; 2] = [Colour([14, 22, 48]), Colour([34, 48, 84])];
const PALETTE: [Colour; 4] =
    [Colour([150, 205, 255]), Colour([235, 245, 255]), Colour([120, 150, 250]), Colour([190, 225, 250])];
/// How many motes there are where the file says nothing.
const DUST: u32 = 120;

type Entry<'t> = Spanned<DeValue<'t>>;

/// Reads a globe.
pub(crate) fn read(text: &str) -> Result<Globe, AgentsError> {
    if text.len() > MOST_BYTES {
        return Err(AgentsError::Long { place: Place::of(text, MOST_BYTES), most: MOST_BYTES });
    }
    let source = Source { text };
    let root = DeTable::parse(text).map_err(|error| source.syntax(&error))?;
    let missing = |at: usize, key| AgentsError::Missing { place: Place::of(text, at), key };
    let head = root.get_ref().get(HEAD).ok_or_else(|| missing(0, "[agents]"))?;
    let DeValue::Table(table) = head.get_ref() else { return Err(source.value("agents", head, "a table")) };
    if let Some(version) = table.get("version") {
        source.whole("version", version, 1..2, "1, the only version")?;
    }
    let name = table.get("name").map(|name| source.name(name)).transpose()?;
    let background = match table.get("background") {
        Some(entry) => match source.colours("background", entry)?[..] {
            [top, bottom] => [top, bottom],
            _ => return Err(source.value("background", entry, "two colours, of top and bottom")),
        },
        None => BACKGROUND,
    };
    let palette = match table.get("palette") {
        Some(entry) => source.colours("palette", entry)?,
        None => PALETTE.to_vec(),
    };
    let whole = |key: &'static str, most: u32, wants, default| match table.get(key) {
        Some(entry) => source.whole(key, entry, 0..i64::from(most) + 1, wants).map(|number| number as u32),
        None => Ok(default),
    };
    let drift = whole("drift", u32::MAX, "a whole number from 0 to 4294967295", 0)?;
    let dust = whole("dust", MOST_DUST, "a whole number from 0 to 400", DUST)?;
    let glow = table.get("glow").map_or(Ok(1.0), |entry| source.glow(entry))?;
    let flock = table.get("flock").ok_or_else(|| missing(head.span().start, "flock"))?;
    let (flock, shapes) = source.flock(flock)?;
    let kept = kept(text).map_err(|error| source.syntax(&error))?;
    Ok(Globe { name, background, palette, drift, glow, dust, flock, shapes, kept })
}

/// Everything that is not known, as it will be written.
fn kept(text: &str) -> Result<Kept, toml::de::Error> {
    let mut root: Table = toml::from_str(text)?;
    let head = root.remove(HEAD);
    let mut head = head.and_then(|head| head.try_into::<Table>().ok()).unwrap_or_default();
    head.retain(|key, _| !KNOWN.contains(&key));
    let is_table = |value: &Value| match value {
        Value::Table(_) => true,
        Value::Array(values) => !values.is_empty() && values.iter().all(Value::is_table),
        Value::String(_) | Value::Integer(_) | Value::Float(_) | Value::Boolean(_) | Value::Datetime(_) => false,
    };
    let (after, before): (Table, Table) = root.into_iter().partition(|(_, value)| is_table(value));
    let written =
        |table: &Table| if table.is_empty() { String::new() } else { toml::to_string(table).unwrap_or_default() };
    let (before, after) = (written(&before), written(&after));
    let head = if head.is_empty() { head } else { Table::from_iter([(HEAD.to_owned(), Value::Table(head))]) };
    let head = written(&head);
    let head = head.strip_prefix("[agents]\n").map(ToOwned::to_owned).unwrap_or(head);
    Ok(Kept { before, head, after })
}

/// The text that everything came from.
struct Source<'t> {
    text: &'t str,
}

impl Source<'_> {
    fn place(&self, span: Range<usize>) -> Place {
        Place::of(self.text, span.start)
    }

    fn syntax(&self, error: &toml::de::Error) -> AgentsError {
        let place = self.place(error.span().unwrap_or(0..0));
        AgentsError::Syntax { place, message: excerpt(&error.message().replace('\n', ", "), 200) }
    }

    fn value(&self, key: &'static str, entry: &Entry, wants: &'static str) -> AgentsError {
        let found = excerpt(self.text.get(entry.span()).unwrap_or_default().trim(), 40);
        AgentsError::Value { place: self.place(entry.span()), key, found: format!("`{found}`"), wants }
    }

    fn whole(
        &self,
        key: &'static str,
        entry: &Entry,
        range: Range<i64>,
        wants: &'static str,
    ) -> Result<i64, AgentsError> {
        let number = entry.get_ref().as_integer();
        let number = number.and_then(|number| i64::from_str_radix(number.as_str(), number.radix()).ok());
        number.filter(|number| range.contains(number)).ok_or_else(|| self.value(key, entry, wants))
    }

    fn glow(&self, entry: &Entry) -> Result<f64, AgentsError> {
        let number = match entry.get_ref() {
            DeValue::Float(number) => number.as_str().parse().ok(),
            DeValue::Integer(number) => i32::from_str_radix(number.as_str(), number.radix()).ok().map(f64::from),
            DeValue::String(_) | DeValue::Boolean(_) | DeValue::Datetime(_) | DeValue::Array(_) | DeValue::Table(_) => {
                None
            }
        };
        let number = number.filter(|number| (0.0..=MOST_GLOW).contains(number));
        // Minus nothing is nothing.
        number.map(f64::abs).ok_or_else(|| self.value("glow", entry, "a number from 0 to 4"))
    }

    fn name(&self, entry: &Entry) -> Result<String, AgentsError> {
        let is_name = |name: &&str| name.chars().count() <= LONGEST[0] && !name.chars().any(char::is_control);
        let name = entry.get_ref().as_str().filter(is_name);
        name.map(ToOwned::to_owned).ok_or_else(|| self.value("name", entry, "a text of up to 80 characters"))
    }

    fn colours(&self, key: &'static str, entry: &Entry) -> Result<Vec<Colour>, AgentsError> {
        let wants = "a list of 1 to 16 colours";
        let list = entry.get_ref().as_array().ok_or_else(|| self.value(key, entry, wants))?;
        if !(1..=MOST_COLOURS).contains(&list.len()) {
            return Err(self.value(key, entry, wants));
        }
        let colour = |entry: &Entry| {
            let colour = entry.get_ref().as_str().and_then(Colour::parse);
            colour.ok_or_else(|| self.value(key, entry, "a colour as `#80c0ff`"))
        };
        list.iter().map(colour).collect()
    }

    /// The strings, and what they are.
    fn flock(&self, entry: &Entry) -> Result<(Vec<String>, Vec<Shape>), AgentsError> {
        let wants = "a list of 1 to 25 texts, an agent each";
        let list = entry.get_ref().as_array().filter(|list| (1..=MOST_AGENTS).contains(&list.len()));
        let list = list.ok_or_else(|| self.value("flock", entry, wants))?;
        let (mut flock, mut shapes, mut segments) = (Vec::new(), Vec::<Shape>::new(), 0);
        for (agent, entry) in (1..).zip(list.iter()) {
            let place = self.place(entry.span());
            let is_short = |text: &&str| text.chars().count() <= LONGEST[1];
            let text = entry.get_ref().as_str().filter(is_short);
            let text = text.ok_or_else(|| self.value("flock", entry, "a text of up to 4096 characters"))?;
            let text: String = text.chars().filter(|letter| !letter.is_whitespace()).collect();
            let shape = Shape::of(Pfeiffer::read(&text)).map_err(|why| AgentsError::Invisible { place, agent, why })?;
            if let Some(twin) = shapes.iter().position(|other| other.hash == shape.hash) {
                return Err(AgentsError::Twin { place, agent, twin: twin + 1 });
            }
            segments += shape.strokes;
            if segments > MOST_IN_A_GLOBE {
                return Err(AgentsError::Heavy { place, agent, segments, most: MOST_IN_A_GLOBE });
            }
            flock.push(text);
            shapes.push(shape);
        }
        Ok((flock, shapes))
    }
}

/// So many characters of a text.
fn excerpt(text: &str, most: usize) -> String {
    let mut excerpt: String = text.chars().take(most).collect();
    if excerpt.len() < text.len() {
        excerpt.push_str("...");
    }
    excerpt
}
