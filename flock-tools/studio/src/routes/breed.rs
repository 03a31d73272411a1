//! Broods, votes and the snow globe.
//!
//! Owns these handlers. Broods are made as jobs; the globe's next generation is made at once.
//!
//! Start at [`router`].

use std::collections::HashMap;
use std::ffi::OsString;
use std::fs;
use std::path::PathBuf;
use std::sync::Arc;

use axum::Router;
use axum::extract::{DefaultBodyLimit, State};
use axum::routing::{get, post};
use flock::SheepId;
use operations::program::{now, print};
use serde_json::{Value, json};

use crate::answer::{Answer, Asked, Body, Problem, conflict, malformed, of, refused};
use crate::breeding::broods::{BroodRecord, CellState, PARENT};
use crate::breeding::globe;
use crate::document::EditRequest;
use crate::fence::MOST_IMPORTED_BYTES;
use crate::lock::locked;
use crate::requests::{Accept, BreedRequest, Destination, GlobeQuery, GlobeRequest, VotesText};
use crate::work::births::{begin, queue_births};
use crate::work::own_command;
use crate::workshop::Workshop;

/// Agents of a globe if no number is asked for, and the most.
const AGENTS: usize = 25;

/// The routes.
pub(super) fn router() -> Router<Arc<Workshop>> {
    Router::new()
        .route("/api/breed", post(breed))
        .route("/api/broods", get(broods))
        .route("/api/broods/accept", post(accept))
        .route("/api/votes/import", post(import_votes).layer(DefaultBodyLimit::max(MOST_IMPORTED_BYTES)))
        .route("/api/globe", get(strings).post(next_strings))
}

async fn breed(State(workshop): State<Arc<Workshop>>, Body(request): Body<BreedRequest>) -> Answer<Value> {
    of(move || {
        let (job, brood) = begin(&workshop, &request).map_err(refused)?;
        Ok(json!({ "job": job, "brood": told(&workshop, &brood, &workshop.genomes_by_id()) }))
    })
    .await
}

async fn broods(State(workshop): State<Arc<Workshop>>) -> Answer<Value> {
    of(move || {
        let newest: Vec<BroodRecord> = locked(&workshop.stock.broods).newest().cloned().collect();
        let genomes = workshop.genomes_by_id();
        let all: Vec<Value> = newest.iter().map(|brood| told(&workshop, brood, &genomes)).collect();
        Ok(json!({ "broods": all }))
    })
    .await
}

/// A brood as the page reads it: the record, and the key of each cell's strip.
fn told(workshop: &Workshop, brood: &BroodRecord, genomes: &HashMap<String, PathBuf>) -> Value {
    let (_, flock) = workshop.flock();
    let keys = workshop.keys(flock.manifest());
    let cells: Vec<Value> = brood
        .cells
        .iter()
        .map(|cell| {
            let of_brood = || Some(locked(&workshop.stock.broods).genome(&brood.id, &cell.id, &cell.species));
            let genome = match (cell.state, &*cell.op) {
                (_, PARENT) => {
                    locked(&workshop.stock.broods).find_genome(&cell.id).or_else(|| genomes.get(&cell.id).cloned())
                }
                (CellState::There, _) => of_brood(),
                (CellState::Failed | CellState::Queued | CellState::Running, _) => None,
            };
            let mut told = serde_json::to_value(cell).unwrap_or_default();
            told["strip"] = json!(keys.strip(None, genome.as_deref()));
            told
        })
        .collect();
    let BroodRecord { id, parents, species, wish, at_ms, .. } = brood;
    json!({ "id": id, "parents": parents, "species": species, "strength": wish.strength, "locks": wish.locks,
            "seed": wish.seed, "at_ms": at_ms, "cells": cells })
}

async fn accept(State(workshop): State<Arc<Workshop>>, Body(request): Body<Accept>) -> Answer<Value> {
    of(move || {
        if request.cells.is_empty() {
            return Err(malformed("no cell is named"));
        }
        let count = print::count(request.cells.len(), "cell");
        match request.into {
            Destination::Pool => {
                let job = queue_births(&workshop, request.cells);
                Ok(json!({ "said": format!("{count} go into the pool"), "job": job }))
            }
            Destination::Flock => add(&workshop, &request.cells),
        }
    })
    .await
}

/// Adds cells to the flock, as an edit that can be taken back.
fn add(workshop: &Workshop, cells: &[String]) -> Result<Value, Problem> {
    let ids = cells.iter().map(|id| SheepId::new(id)).collect::<Result<Vec<_>, _>>();
    let edits = [EditRequest::Add { candidates: ids.map_err(|error| malformed(error.to_string()))? }];
    let mut document = locked(&workshop.document);
    let revision = document.revision().clone();
    let applied = document.apply(&edits, &revision, None, false).map_err(|error| refused(error.to_string()));
    drop(document);
    workshop.tell_changed();
    applied.map(|applied| json!({ "said": applied.said, "revision": applied.revision }))
}

/// Takes in what units report, by the command `dreams votes`.
async fn import_votes(State(workshop): State<Arc<Workshop>>, Body(sent): Body<VotesText>) -> Answer<Value> {
    of(move || {
        let pool = &workshop.stock.candidates.pool;
        if !pool.join(::breeding::SETTINGS).exists() {
            return Err(conflict("there is no pool yet: accept a sheep of a brood into it first"));
        }
        let file = workshop.own.join("votes-import.json");
        fs::write(&file, sent.text).map_err(|error| refused(format!("cannot keep the votes: {error}")))?;
        let mut words: Vec<OsString> = vec!["votes".into(), pool.into(), file.clone().into()];
        if let Some(unit) = sent.unit {
            words.extend(["--unit".into(), unit.into()]);
        }
        let answer = own_command::run(&words, &|_| (), &|| false);
        // It is read; what is left of it harms nobody.
        let _ = fs::remove_file(&file);
        let said = votes_said(&answer.map_err(refused)?.0).map_err(refused)?;
        workshop.tell_all();
        Ok(json!({ "said": said }))
    })
    .await
}

/// What became of the votes in a sentence, by the answer of the command.
/// Errors: The first refusal, if nothing is new.
fn votes_said(answer: &Value) -> Result<String, String> {
    let units = answer["units"].as_object().into_iter().flatten();
    let new: Vec<String> = units
        .filter(|(_, news)| news["sheep"].as_u64() > Some(0))
        .map(|(unit, news)| format!("{unit}: {} votes for and {} against", news["up"], news["down"]))
        .collect();
    let refused = answer["refused"].as_array().and_then(|all| all.first()).and_then(|first| first["why"].as_str());
    match (new.is_empty(), refused) {
        (true, Some(why)) => Err(format!("the votes were refused: {why}")),
        (true, None) => Ok("nothing is new in these votes".to_owned()),
        (false, None) => Ok(new.join("; ")),
        (false, Some(why)) => Ok(format!("{}; one document was refused: {why}", new.join("; "))),
    }
}

async fn strings(Asked(query): Asked<GlobeQuery>) -> Answer<Value> {
    let count = query.agents.unwrap_or(AGENTS).clamp(1, AGENTS);
    of(move || Ok(json!({ "strings": globe::strangers(count, rand::random()), "defaults": agents::DEFAULT }))).await
}

async fn next_strings(State(workshop): State<Arc<Workshop>>, Body(sent): Body<GlobeRequest>) -> Answer<Value> {
    of(move || {
        if sent.strings.len() > AGENTS {
            return Err(malformed(format!("a globe has at most {AGENTS} agents, found {}", sent.strings.len())));
        }
        if sent.keep {
            keep(&workshop, &sent.strings)
        } else {
            Ok(json!({ "strings": globe::next(&sent.strings, AGENTS, rand::random()) }))
        }
    })
    .await
}

/// Puts the strings into the pool, as one globe.
fn keep(workshop: &Arc<Workshop>, strings: &[String]) -> Result<Value, Problem> {
    let text = globe::genome(strings, rand::random()).map_err(malformed)?;
    let kept = locked(&workshop.stock.broods).keep_genome("agents", &text, now::since_1970_ms());
    let id = kept.map_err(|error| refused(format!("cannot keep the globe: {error}")))?;
    let job = queue_births(workshop, vec![id]);
    Ok(json!({ "said": "the globe goes into the pool", "job": job }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_became_of_votes_is_told_in_a_sentence() {
        let news = |sheep: u64| json!({"showings": 9, "up": 3, "down": 1, "sheep": sheep});
        let said = |units: Value, refused: Value| votes_said(&json!({ "units": units, "refused": refused }));
        assert_eq!(said(json!({"lobby": news(2)}), json!([])).unwrap(), "lobby: 3 votes for and 1 against");
        assert_eq!(said(json!({"lobby": news(0)}), json!([])).unwrap(), "nothing is new in these votes");
        let why = json!([{"file": "x", "why": "it names no unit"}]);
        assert_eq!(said(json!({}), why).unwrap_err(), "the votes were refused: it names no unit");
    }
}
