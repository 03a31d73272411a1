//! The answers that only look: the state, the walk, balances, suggestions, pruning, joins, the family tree.
//!
//! Owns these handlers. Nothing here changes anything.
//!
//! Start at [`router`].

use std::sync::Arc;

use axum::Router;
use axum::extract::State;
use axum::routing::get;
use flock::{Clip, Flock, FlockShares, SheepId};
use operations::breeding::today;
use serde_json::{Value, json};

use crate::answer::{Answer, Asked, conflict, fatal, malformed, measure, missing, of, refused};
use crate::document::EditRequest;
use crate::lock::locked;
use crate::requests::{LineageQuery, PruneQuery, StateQuery, Terms, WalkQuery};
use crate::views::balance::{Advice, Proposal};
use crate::views::figures::sheep_figures;
use crate::views::lineage::Tree;
use crate::views::prune::Pruning;
use crate::views::state_delta::StateAnswer;
use crate::views::walk::Walked;
use crate::workshop::Workshop;

/// Steps of a walk if none are asked for, and the most.
const STEPS: usize = 12;
const MOST_STEPS: usize = 5000;

/// The routes.
pub(super) fn router() -> Router<Arc<Workshop>> {
    Router::new()
        .route("/api/state", get(state))
        .route("/api/walk", get(walk))
        .route("/api/balance", get(balance))
        .route("/api/suggestions", get(suggestions))
        .route("/api/prune", get(prune))
        .route("/api/joins", get(joins))
        .route("/api/lineage", get(lineage))
}

async fn state(State(workshop): State<Arc<Workshop>>, Asked(query): Asked<StateQuery>) -> Answer<StateAnswer> {
    let by = measure(query.by.as_deref())?;
    of(move || workshop.told(by, query.since.as_deref())).await
}

async fn walk(State(workshop): State<Arc<Workshop>>, Asked(query): Asked<WalkQuery>) -> Answer<Walked> {
    of(move || {
        let (_, flock) = workshop.flock();
        let start = query.from.map(|id| SheepId::new(&id)).transpose();
        let start = start.map_err(|error| malformed(error.to_string()))?;
        let seed = query.seed.unwrap_or_else(|| rand::random::<u32>().into());
        let steps = query.steps.unwrap_or(STEPS).min(MOST_STEPS);
        let walked = Walked::of(&flock, seed, steps, start.as_ref());
        let mut walked = walked.ok_or_else(|| match start {
            Some(start) => conflict(format!("the walk never comes to `{start}`")),
            None => conflict("the flock has nothing to show yet: it needs a cycle of transitions, or a loop"),
        })?;
        workshop.find_media(&mut walked);
        Ok(walked)
    })
    .await
}

/// The terms of a balance that a query asks for.
fn terms(query: &Terms) -> Result<flock::Terms, crate::answer::Problem> {
    let usual = flock::Terms::default();
    let number = |text: &String| text.parse::<f64>().ok().filter(|number| *number > 0.0);
    let fairness = query.fairness.as_ref().map(|text| {
        number(text).ok_or_else(|| malformed(format!("fairness is a number above 0 or `inf`, found `{text}`")))
    });
    let floor = query.floor.unwrap_or(usual.floor);
    if !(floor.is_finite() && floor >= 0.0) {
        return Err(malformed(format!("the floor is 0 or more, found `{floor}`")));
    }
    let fairness = fairness.transpose()?.unwrap_or(usual.fairness);
    Ok(flock::Terms { fairness, floor, afresh: query.afresh, by: measure(query.by.as_deref())? })
}

async fn balance(State(workshop): State<Arc<Workshop>>, Asked(query): Asked<Terms>) -> Answer<Proposal> {
    let terms = terms(&query)?;
    of(move || {
        let (_, flock) = workshop.flock();
        let shares = FlockShares::of(&flock);
        let now = shares.as_ref().map_or_else(Vec::new, |shares| sheep_figures(shares, terms.by));
        let worst = shares.as_ref().and_then(|shares| shares.worst(terms.by));
        Proposal::of(&flock, terms, &now, worst).ok_or_else(no_cycle)
    })
    .await
}

async fn suggestions(State(workshop): State<Arc<Workshop>>, Asked(query): Asked<Terms>) -> Answer<Advice> {
    let terms = terms(&query)?;
    of(move || {
        let (_, flock) = workshop.flock();
        let mut advice = Advice::of(&workshop.folder, &flock, terms).ok_or_else(no_cycle)?;
        let keys = workshop.keys(flock.manifest());
        for own in &mut advice.add {
            own.cost_s = keys.cost_s(&own.from, &own.to, own.frames);
        }
        Ok(advice)
    })
    .await
}

async fn prune(State(workshop): State<Arc<Workshop>>, Asked(query): Asked<PruneQuery>) -> Answer<Pruning> {
    let by = measure(query.by.as_deref())?;
    of(move || {
        let (_, flock) = workshop.flock();
        let keep = query.keep.as_deref().map(SheepId::new).transpose();
        let keep = keep.map_err(|error| malformed(error.to_string()))?;
        if let Some(unknown) = keep.as_ref().filter(|id| flock.whole().find(id).is_none()) {
            return Err(missing(format!("nobody is called `{unknown}`")));
        }
        let after = |drop: &[SheepId]| {
            let edits = [EditRequest::Prune { drop: drop.to_vec() }];
            let manifest = locked(&workshop.document).what_if(&edits);
            manifest.map(Flock::new).map_err(|error| refused(error.to_string()))
        };
        Pruning::of(&flock, keep.as_ref(), by, after)?.ok_or_else(no_cycle)
    })
    .await
}

fn no_cycle() -> crate::answer::Problem {
    conflict("the flock cannot be walked yet: none of its transitions lies on a cycle")
}

async fn joins(State(workshop): State<Arc<Workshop>>) -> Answer<Value> {
    of(move || {
        let (_, flock) = workshop.flock();
        let notes = workshop.snapshot().notes;
        let keys = workshop.keys(flock.manifest());
        let fragments = |clip: &Clip| keys.fragments(clip);
        let is_bad = |from: &SheepId, to: &SheepId| notes.bad_joins.contains(&(from.clone(), to.clone()));
        let told = locked(&workshop.joins).told(&workshop.folder, flock.manifest(), fragments, is_bad);
        Ok(json!({ "joins": told }))
    })
    .await
}

async fn lineage(State(workshop): State<Arc<Workshop>>, Asked(query): Asked<LineageQuery>) -> Answer<Tree> {
    of(move || {
        let (_, flock) = workshop.flock();
        let credits = workshop.credits(flock.manifest())?;
        let folder = workshop.stock.candidates.folder().map_err(fatal)?;
        let pool = folder.as_ref().map(|folder| (folder.pool(), today()));
        let genomes = workshop.genomes_by_id();
        let species = |id: &str| workshop.stock.genomes.facts(genomes.get(id)?).species.map(str::to_owned);
        let keys = workshop.keys(flock.manifest());
        let strip = |id: &str| keys.strip(None, Some(genomes.get(id)?));
        let tree = Tree::of(flock.manifest(), &credits, pool, query.at.as_deref(), species, strip);
        if let Some(at) = query.at.filter(|_| tree.nodes.is_empty()) {
            return Err(missing(format!("nobody is called `{at}`")));
        }
        Ok(tree)
    })
    .await
}
