//! Edits by chance, as the studio's page asks for them and as commands.
//!
//! Owns their choice. Never makes one.
//!
//! Start at [`EditsByChance::of`].

use crate::programs::{self, succeed};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng as _, SeedableRng};
use serde_json::{Value, json};
use std::collections::BTreeSet;
use std::fs;
use std::path::Path;
use std::process::Command;

/// How many edits are made: `EDITS` for `make soak`.
pub fn edits() -> usize {
    std::env::var("EDITS").map_or(120, |edits| edits.parse().expect("EDITS is a number"))
}

/// An edit as the studio's page asks for it, and as a command.
pub struct Edit {
    pub request: Value,
    pub words: Vec<String>,
}

/// Edits by chance, each of which fits the flock after all those before it.
pub struct EditsByChance {
    chance: ChaCha8Rng,
    pub sheep: Vec<String>,
    transitions: BTreeSet<(String, String)>,
    names: u32,
}

impl EditsByChance {
    /// For the flock in `folder`.
    pub fn of(folder: &Path, seed: u64) -> Self {
        let listed = succeed(Command::new(programs::dreams()).args(["list", "--json"]).arg(folder));
        let listed: Value = serde_json::from_slice(&listed).unwrap();
        let text = |value: &Value| value.as_str().expect("an id is a text").to_owned();
        let sheep = listed["sheep"].as_array().unwrap().iter().map(|sheep| text(&sheep["id"])).collect();
        let manifest: toml::Table = fs::read_to_string(folder.join("flock.toml")).unwrap().parse().unwrap();
        let end = |transition: &toml::Value, key: &str| transition[key].as_str().unwrap().to_owned();
        let transitions = manifest["transition"].as_array().unwrap().iter();
        let transitions = transitions.map(|one| (end(one, "from"), end(one, "to"))).collect();
        Self { chance: ChaCha8Rng::seed_from_u64(seed), sheep, transitions, names: 0 }
    }

    pub fn below(&mut self, limit: usize) -> usize {
        self.chance.next_u32() as usize % limit
    }

    fn one_sheep(&mut self) -> String {
        let at = self.below(self.sheep.len());
        self.sheep[at].clone()
    }

    fn one_transition(&mut self) -> (String, String) {
        let at = self.below(self.transitions.len());
        self.transitions.iter().nth(at).expect("it is below their number").clone()
    }

    /// Chooses the next edit. The flock stays large enough for all kinds.
    pub fn choose(&mut self) -> Edit {
        let edit =
            |request: Value, words: &[&str]| Edit { request, words: words.iter().map(ToString::to_string).collect() };
        let quarters = 1 + self.below(31);
        let value = quarters as f64 / 4.0;
        let (one, (from, to)) = (self.one_sheep(), self.one_transition());
        match self.below(12) {
            0..3 => edit(json!({ "do": "want", "sheep": one, "value": value }), &["want", &one, &value.to_string()]),
            3..6 => {
                let words = ["weight", &*from, &to, &value.to_string()];
                edit(json!({ "do": "weight", "from": from, "to": to, "value": value }), &words)
            }
            6 => edit(
                json!({ "do": "repeat", "sheep": one, "value": quarters }),
                &["repeat", &one, &quarters.to_string()],
            ),
            7 | 8 => {
                let other = self.one_sheep();
                if !self.transitions.insert((one.clone(), other.clone())) {
                    return self.choose();
                }
                let words = ["link", &*one, &other, "--frames", &quarters.to_string()];
                edit(json!({ "do": "link", "from": one, "to": other, "frames": quarters }), &words)
            }
            9 if self.transitions.len() > 30 => {
                self.transitions.remove(&(from.clone(), to.clone()));
                edit(json!({ "do": "unlink", "from": from, "to": to }), &["unlink", &from, &to, "--force"])
            }
            10 if self.sheep.len() > 20 => {
                self.sheep.retain(|sheep| *sheep != one);
                self.transitions.retain(|(from, to)| *from != one && *to != one);
                edit(json!({ "do": "drop", "sheep": one }), &["drop", &one, "--force"])
            }
            _ => {
                self.names += 1;
                let new = format!("ram{}", self.names);
                let renamed = |id: &String| if *id == one { new.clone() } else { id.clone() };
                self.sheep = self.sheep.iter().map(renamed).collect();
                self.transitions = self.transitions.iter().map(|(from, to)| (renamed(from), renamed(to))).collect();
                edit(json!({ "do": "rename", "sheep": one, "to": new }), &["rename", &one, &new])
            }
        }
    }
}
