//! From a text to a genome.
//!
//! Owns which keys there are and what they must be. What is not known is kept. Never draws.
//!
//! Start at [`Plant::parse`].

use std::ops::Range;

use species::Place;
use toml::Value;
use toml::de::{DeTable, DeValue};

use crate::error::PlantError;
use crate::genes::GENES;
use crate::genome::{MOST_BYTES, MOST_TURNS, Plant};

/// The version of the text that is read and written.
pub(crate) const VERSION: i64 = 1;

/// A value of a table, and where it is.
struct Found<'a> {
    text: &'a str,
    name: &'a str,
    span: Range<usize>,
    value: &'a DeValue<'a>,
}

impl Plant {
    /// Reads a text of at most [`MOST_BYTES`]. Genes that are not there take the defaults of [`GENES`].
    ///
    /// # Errors
    /// [`PlantError`] says what is not understood, and where.
    pub fn parse(text: &str) -> Result<Plant, PlantError> {
        let too_long = |bytes: usize| PlantError::Long { place: Place::of(text, MOST_BYTES), bytes, most: MOST_BYTES };
        if text.len() > MOST_BYTES {
            return Err(too_long(text.len()));
        }
        let file = DeTable::parse(text).map_err(|error| PlantError::Syntax {
            place: Place::of(text, error.span().map_or(0, |span| span.start)),
            reason: error.message().to_owned(),
        })?;
        let mut plant = Plant::default();
        let mut is_there = false;
        for (key, value) in file.get_ref() {
            let name = key.get_ref().as_ref();
            let found = Found { text, name, span: value.span(), value: value.get_ref() };
            if name == "plant" {
                let DeValue::Table(table) = found.value else { return Err(found.wants("a table")) };
                plant.read(text, table, value.span().start)?;
                is_there = true;
            } else {
                plant.unknown[1].push((name.to_owned(), found.kept()?));
            }
        }
        if !is_there {
            return Err(PlantError::Missing { place: Place::of(text, 0), name: "plant" });
        }
        let written = plant.to_toml().len();
        if written > MOST_BYTES { Err(too_long(written)) } else { Ok(plant) }
    }

    fn read(&mut self, text: &str, table: &DeTable<'_>, start: usize) -> Result<(), PlantError> {
        let mut has_version = false;
        for (key, value) in table {
            let name = key.get_ref().as_ref();
            let found = Found { text, name, span: value.span(), value: value.get_ref() };
            if let Some(place) = GENES.iter().position(|gene| gene.name == name) {
                self.genes[place] = found.part("a number from 0 to 1")?;
                continue;
            }
            match name {
                "version" => {
                    found.whole(VERSION..=VERSION, "1")?;
                    has_version = true;
                }
                "name" => {
                    let DeValue::String(said) = found.value else { return Err(found.wants("a text")) };
                    self.name = Some(said.clone().into_owned());
                }
                "seed" => self.seed = found.whole(0..=i64::MAX, "a whole number from 0 to 9223372036854775807")?,
                "turns" => {
                    self.turns = found.whole(1..=i64::from(MOST_TURNS), "a whole number from 1 to 16")? as u32;
                }
                "sky" => self.sky[0] = found.colour()?,
                "horizon" => self.sky[1] = found.colour()?,
                _ => self.unknown[0].push((name.to_owned(), found.kept()?)),
            }
        }
        if has_version { Ok(()) } else { Err(PlantError::Missing { place: Place::of(text, start), name: "version" }) }
    }
}

impl Found<'_> {
    fn wants(&self, wants: &'static str) -> PlantError {
        let written = self.text.get(self.span.clone()).unwrap_or_default();
        let short: String = written.chars().take(60).collect();
        PlantError::Value {
            place: Place::of(self.text, self.span.start),
            name: self.name.chars().take(60).collect(),
            value: if short.is_empty() { self.value.type_str().to_owned() } else { format!("`{short}`") },
            wants,
        }
    }

    /// A number from 0 to 1.
    fn part(&self, wants: &'static str) -> Result<f64, PlantError> {
        number(self.value).filter(|number| (0.0..=1.0).contains(number)).ok_or_else(|| self.wants(wants))
    }

    fn whole(&self, range: std::ops::RangeInclusive<i64>, wants: &'static str) -> Result<u64, PlantError> {
        let number = integer(self.value).filter(|number| range.contains(number)).ok_or_else(|| self.wants(wants))?;
        Ok(number.unsigned_abs())
    }

    fn colour(&self) -> Result<[f64; 3], PlantError> {
        const WANTS: &str = "three numbers from 0 to 1";
        let DeValue::Array(parts) = self.value else { return Err(self.wants(WANTS)) };
        let mut colour = [0.0; 3];
        if parts.len() != colour.len() {
            return Err(self.wants(WANTS));
        }
        for (light, part) in colour.iter_mut().zip(parts.iter()) {
            *light = Found { span: part.span(), value: part.get_ref(), ..*self }.part(WANTS)?;
        }
        Ok(colour)
    }

    /// A value that means nothing here, as it will be written.
    fn kept(&self) -> Result<String, PlantError> {
        Ok(kept(self.value).ok_or_else(|| self.wants("a value that TOML can write"))?.to_string())
    }
}

fn integer(value: &DeValue<'_>) -> Option<i64> {
    let DeValue::Integer(integer) = value else { return None };
    i64::from_str_radix(integer.as_str(), integer.radix()).ok()
}

fn number(value: &DeValue<'_>) -> Option<f64> {
    let number = if let DeValue::Float(float) = value { float.as_str().parse().ok()? } else { integer(value)? as f64 };
    // -0 is 0.
    Some(number + 0.0)
}

fn kept(value: &DeValue<'_>) -> Option<Value> {
    Some(match value {
        DeValue::String(text) => Value::String(text.clone().into_owned()),
        DeValue::Integer(_) => Value::Integer(integer(value)?),
        DeValue::Float(float) => Value::Float(float.as_str().parse().ok()?),
        DeValue::Boolean(boolean) => Value::Boolean(*boolean),
        DeValue::Datetime(moment) => Value::Datetime(*moment),
        DeValue::Array(parts) => {
            Value::Array(parts.iter().map(|part| kept(part.get_ref())).collect::<Option<Vec<Value>>>()?)
        }
        DeValue::Table(table) => Value::Table(
            table
                .iter()
                .map(|(key, value)| Some((key.get_ref().clone().into_owned(), kept(value.get_ref())?)))
                .collect::<Option<toml::Table>>()?,
        ),
    })
}
