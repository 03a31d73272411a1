//! The settings of a pool.
//!
//! Owns the form of `pool.toml`, its defaults and its limits. Never applies a setting.
//!
//! Start at [`Settings`].

use std::ops::RangeInclusive;

use serde::{Deserialize, Serialize};
use species::Figures;

use crate::error::BreedingError;
use crate::id::Origin;

/// The name of the file.
pub const SETTINGS: &str = "pool.toml";

/// The most niches in either direction.
const MOST_BINS: u64 = 64;

/// What a pool is bred by.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// What people call the pool.
    pub name: String,
    /// What no other pool is called.
    pub origin: Origin,
    /// Whence all that is drawn by chance follows.
    pub seed: u64,
    /// The species of strangers, by the endings of their files.
    pub species: Vec<String>,
    /// Whose children are bred.
    #[serde(default)]
    pub licence: LicencePolicy,
    /// How many sheep live, but for those that may not die.
    #[serde(default = "Settings::limit")]
    pub limit: usize,
    /// Births of a brood.
    #[serde(default = "Settings::births")]
    pub births: usize,
    /// The part of births by crossing.
    #[serde(default = "Settings::crossings")]
    pub crossings: f64,
    /// The part of births by mutation; the others are strangers.
    #[serde(default = "Settings::mutations")]
    pub mutations: f64,
    /// The part of births that are rebirths instead.
    #[serde(default = "Settings::rebirths")]
    pub rebirths: f64,
    /// The figures that niches are told by.
    #[serde(default = "Settings::niches")]
    pub niches: [String; 2],
    /// Niches in either direction; 1 for none.
    #[serde(default = "Settings::bins")]
    pub bins: usize,
    /// Candidates of a screened birth; 1 for no screening.
    #[serde(default = "Settings::screening")]
    pub screening: usize,
    /// The part of births that are screened.
    #[serde(default = "Settings::screened")]
    pub screened: f64,
    /// How much the artist's marks count in screening, beside the audience's votes: 0 to 1. By default all before the first
    /// vote, then nothing.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub artist: Option<f64>,
    /// After how many days a vote counts half.
    #[serde(default = "Settings::half_life_days")]
    pub half_life_days: f64,
    /// Showings after which a brood is due.
    #[serde(default = "Settings::due_showings")]
    pub due_showings: u64,
    /// Votes after which a brood is due.
    #[serde(default = "Settings::due_votes")]
    pub due_votes: u64,
}

/// Whose children are bred.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum LicencePolicy {
    /// Those of every sheep.
    #[default]
    Any,
    /// Not those of sheep without a licence, or under one that forbids commercial use.
    Ours,
}

impl LicencePolicy {
    /// Whether a sheep under `licence` may be a parent.
    pub fn allows(self, licence: &str) -> bool {
        let is_part = |part: &str| part.eq_ignore_ascii_case("nc");
        match self {
            LicencePolicy::Any => true,
            LicencePolicy::Ours => {
                !licence.is_empty() && !licence.split(|c: char| !c.is_ascii_alphanumeric()).any(is_part)
            }
        }
    }
}

impl Settings {
    /// How many births a brood may have: more would take days.
    pub const BIRTHS: RangeInclusive<u64> = 1..=1000;
    /// How many sheep may live: more would take all memory.
    pub const LIMITS: RangeInclusive<u64> = 2..=100_000;
    /// How many candidates a screened birth may have.
    pub const SCREENINGS: RangeInclusive<u64> = 1..=64;
    /// The seeds that TOML has.
    pub const SEEDS: RangeInclusive<u64> = 0..=i64::MAX as u64;

    /// The defaults of a new pool.
    pub fn new(name: &str, origin: Origin, seed: u64, species: &[&str]) -> Settings {
        Settings {
            name: name.to_owned(),
            origin,
            seed,
            species: species.iter().map(|species| (*species).to_owned()).collect(),
            licence: LicencePolicy::default(),
            limit: Settings::limit(),
            births: Settings::births(),
            crossings: Settings::crossings(),
            mutations: Settings::mutations(),
            rebirths: Settings::rebirths(),
            niches: Settings::niches(),
            bins: Settings::bins(),
            screening: Settings::screening(),
            screened: Settings::screened(),
            artist: None,
            half_life_days: Settings::half_life_days(),
            due_showings: Settings::due_showings(),
            due_votes: Settings::due_votes(),
        }
    }

    /// Reads the text of the file called `file`.
    ///
    /// # Errors
    /// [`BreedingError::Settings`] with line and column; [`BreedingError::Setting`] for a value out of its limits.
    pub fn parse(text: &str, file: &str) -> Result<Settings, BreedingError> {
        let settings: Settings = toml::from_str(text)
            .map_err(|source| BreedingError::Settings { file: file.to_owned(), source: Box::new(source) })?;
        settings.check()?;
        Ok(settings)
    }

    /// The text of the file.
    ///
    /// # Errors
    /// As [`Settings::check`].
    pub fn text(&self) -> Result<String, BreedingError> {
        self.check()?;
        Ok(self.table())
    }

    fn table(&self) -> String {
        toml::to_string(self).expect("settings within their limits are a table of values that TOML has")
    }

    /// The places of the two figures that niches are told by.
    pub fn axes(&self) -> [usize; 2] {
        let place = |name: &String| Figures::NAMES.iter().position(|known| known == name).unwrap_or(0);
        [place(&self.niches[0]), place(&self.niches[1])]
    }

    /// Whether the values are within their limits.
    ///
    /// # Errors
    /// [`BreedingError::Setting`] names the value and the limit.
    pub fn check(&self) -> Result<(), BreedingError> {
        let refused = |what, value: String, limit: String| Err(BreedingError::Setting { what, value, limit });
        let counts = [
            ("limit", self.limit as u64, Settings::LIMITS),
            ("births", self.births as u64, Settings::BIRTHS),
            ("bins", self.bins as u64, 1..=MOST_BINS),
            ("screening", self.screening as u64, Settings::SCREENINGS),
            ("seed", self.seed, Settings::SEEDS),
        ];
        for (what, value, range) in counts {
            if !range.contains(&value) {
                return refused(what, value.to_string(), format!("not {} to {}", range.start(), range.end()));
            }
        }
        let parts = [
            ("crossings", self.crossings),
            ("mutations", self.mutations),
            ("rebirths", self.rebirths),
            ("screened", self.screened),
            ("artist", self.artist.unwrap_or(0.0)),
        ];
        for (what, value) in parts {
            if !(0.0..=1.0).contains(&value) {
                return refused(what, value.to_string(), "not 0 to 1".to_owned());
            }
        }
        // Parts that are written in decimals may add up to a little more.
        if self.crossings + self.mutations > 1.0 + 1e-9 {
            let limit = format!("and mutations is {}: together over 1", self.mutations);
            return refused("crossings", self.crossings.to_string(), limit);
        }
        if !(self.half_life_days >= 1.0 && self.half_life_days.is_finite()) {
            return refused("half_life_days", self.half_life_days.to_string(), "not 1 or more".to_owned());
        }
        if self.species.is_empty() {
            return refused("species", "empty".to_owned(), "not one or more".to_owned());
        }
        if let Some(unknown) = self.niches.iter().find(|name| !Figures::NAMES.contains(&name.as_str())) {
            return refused("niches", format!("`{unknown}`"), format!("not two of {}", Figures::NAMES.join(", ")));
        }
        if self.niches[0] == self.niches[1] {
            let value = format!("`{}`", self.niches[0]);
            return refused("niches", value, format!("and again `{}`: not two figures", self.niches[1]));
        }
        Ok(())
    }

    /// How many sheep live in a new pool.
    pub fn limit() -> usize {
        200
    }

    fn births() -> usize {
        20
    }

    fn crossings() -> f64 {
        0.5
    }

    fn mutations() -> f64 {
        0.4
    }

    fn rebirths() -> f64 {
        0.05
    }

    fn niches() -> [String; 2] {
        ["activity".to_owned(), "colourfulness".to_owned()]
    }

    fn bins() -> usize {
        8
    }

    fn screening() -> usize {
        8
    }

    fn screened() -> f64 {
        0.5
    }

    fn half_life_days() -> f64 {
        180.0
    }

    fn due_showings() -> u64 {
        1000
    }

    fn due_votes() -> u64 {
        40
    }
}
