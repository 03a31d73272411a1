//! What leaves the studio: its state, checks, packing and publishing.
//!
//! Owns these handlers and their jobs. Packing and publishing are the commands of these names. The page names a key and a
//! target of those that it was told; the passphrase is asked on the terminal.
//!
//! Start at [`router`].

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use axum::Router;
use axum::extract::State;
use axum::routing::{get, post};
use bundle::UnitId;
use serde_json::{Value, json};

use crate::answer::{Answer, Body, Problem, conflict, of, refused};
use crate::jobs::{Job, Kind, NewJob, Priority, Progress};
use crate::lock::locked;
use crate::requests::{CheckRequest, PackRequest, PublishRequest};
use crate::store::clip_states::ClipState;
use crate::store::shipping::Shipping;
use crate::views::ship::{JoinCount, ShipState, licences, size, why_not};
use crate::work::checking;
use crate::work::own_command;
use crate::workshop::Workshop;

/// The routes.
pub(super) fn router() -> Router<Arc<Workshop>> {
    Router::new()
        .route("/api/ship", get(state))
        .route("/api/ship/check", post(check))
        .route("/api/ship/pack", post(pack))
        .route("/api/ship/publish", post(publish))
}

async fn state(State(workshop): State<Arc<Workshop>>) -> Answer<ShipState> {
    of(move || {
        let (revision, flock) = workshop.flock();
        let manifest = flock.manifest();
        let credits = workshop.credits(manifest)?;
        let faults = locked(&workshop.checked).faults(&flock, &revision);
        let judged = locked(&workshop.joins).told(&workshop.folder, manifest, |_| None, |_, _| false);
        let joins = (!judged.is_empty()).then(|| JoinCount {
            judged: judged.len(),
            jumps: judged.iter().filter(|join| join.severity > 1.0).count(),
            worst: judged.first().map_or(0.0, |join| join.severity),
        });
        let clips = workshop.clip_states();
        let is_there = |clip| clips.of(&workshop.folder, Some(clip)).state == ClipState::There;
        let missing = manifest.clips().filter(|clip| !is_there(*clip)).count();
        let why_not = why_not(missing, &faults, joins.as_ref(), workshop.shipping.keys.len());
        let (bytes, files) = size(&workshop.folder, manifest);
        Ok(ShipState {
            packed: workshop.shipping.has_bundle(),
            faults,
            joins,
            credits: licences(&credits),
            bytes,
            files,
            difference: locked(&workshop.difference).clone().filter(|(of, _)| *of == revision).map(|(_, told)| told),
            ready: why_not.is_empty(),
            why_not,
            keys: workshop.shipping.keys.keys().cloned().collect(),
            targets: workshop.shipping.targets().iter().map(|path| path.display().to_string()).collect(),
            outbox: workshop.shipping.outbox.display().to_string(),
        })
    })
    .await
}

async fn check(State(workshop): State<Arc<Workshop>>, Body(request): Body<CheckRequest>) -> Answer<Value> {
    of(move || {
        let job = checking::queue(&workshop, request.joins);
        compare(&workshop);
        Ok(json!({ "job": job }))
    })
    .await
}

async fn pack(State(workshop): State<Arc<Workshop>>, Body(request): Body<PackRequest>) -> Answer<Value> {
    of(move || {
        let shipping = &workshop.shipping;
        let key = shipping.keys.get(&request.key).cloned();
        let key = key.ok_or_else(|| refused(format!("there is no key `{}`", request.key)))?;
        let words = pack_words(&workshop.folder, shipping, &key, &request)?;
        let asks = shipping.passphrase_file.is_none();
        let waits = asks.then(|| format!("the passphrase of {}, on the terminal where the studio runs", key.display()));
        let whom = if request.units.is_empty() { String::new() } else { format!(" for {}", request.units.join(", ")) };
        let what = format!("a bundle{whom}, signed by {}", request.key);
        Ok(json!({ "job": command_job(&workshop, Kind::Pack, what, words, waits) }))
    })
    .await
}

/// The command that packs the flock in `folder`, signed by `key`.
/// Errors: If a unit has no name of a unit.
fn pack_words(folder: &Path, shipping: &Shipping, key: &Path, request: &PackRequest) -> Result<Vec<OsString>, Problem> {
    let mut words: Vec<OsString> = vec!["pack".into(), folder.into(), (&shipping.outbox).into()];
    words.extend(["--key".into(), key.into()]);
    for unit in &request.units {
        let unit = UnitId::new(unit).map_err(|error| refused(error.to_string()))?;
        words.extend(["--unit".into(), unit.as_str().into()]);
    }
    words.extend(request.allow_jumps.then(|| "--allow-jumps".into()));
    if let Some(file) = &shipping.passphrase_file {
        words.extend(["--passphrase-file".into(), file.into()]);
    }
    Ok(words)
}

async fn publish(State(workshop): State<Arc<Workshop>>, Body(request): Body<PublishRequest>) -> Answer<Value> {
    of(move || {
        let shipping = &workshop.shipping;
        if !shipping.has_bundle() {
            return Err(conflict("nothing is packed yet"));
        }
        let target = shipping.targets().into_iter().find(|path| path.display().to_string() == request.to);
        let target: PathBuf = target.ok_or_else(|| {
            refused(format!(
                "`{}` is no mounted stick and was not named by --to when the studio was started",
                request.to
            ))
        })?;
        let trust = shipping.trust(&workshop.own);
        let trust = trust.map_err(|error| refused(format!("cannot keep the public keys: {error}")))?;
        let trust = trust.ok_or_else(|| conflict("no public key lies beside the secret one"))?;
        let mut words: Vec<OsString> = vec!["publish".into(), (&shipping.outbox).into(), (&target).into()];
        words.extend(["--trust".into(), trust.into()]);
        let what = format!("the bundles to {}", target.display());
        Ok(json!({ "job": command_job(&workshop, Kind::Publish, what, words, None) }))
    })
    .await
}

/// Queues a command of ours, which `waits` for something first.
fn command_job(workshop: &Arc<Workshop>, kind: Kind, what: String, words: Vec<OsString>, waits: Option<String>) -> Job {
    let shared = Arc::downgrade(workshop);
    let work = move |progress: &Progress| {
        if let Some(what) = &waits {
            progress.waiting_for(what);
        }
        let (answer, is_yes) = own_command::run(&words, &|line| progress.log(line), &|| progress.is_cancelled())?;
        if let Some(workshop) = shared.upgrade() {
            // It was that to the bundle before.
            *locked(&workshop.difference) = None;
            compare(&workshop);
            workshop.tell_all();
        }
        if is_yes { Ok(answer) } else { Err(why_refused(&answer)) }
    };
    workshop.queue.add_job(NewJob::new(Priority::Clip, kind, what), Box::new(work))
}

/// Why a command said no: its first faults.
fn why_refused(answer: &Value) -> String {
    let faults = answer["faults"].as_array().into_iter().flatten();
    let told: Vec<&str> = faults.filter_map(|fault| fault["message"].as_str()).take(3).collect();
    if told.is_empty() { "it was refused; the log says why".to_owned() } else { told.join("; ") }
}

/// Queues the comparison with the last bundle, if there is one.
fn compare(workshop: &Arc<Workshop>) {
    let shipping = &workshop.shipping;
    // Without the keys it stays unknown, which the page says.
    let trust = shipping.trust(&workshop.own).ok().flatten();
    let Some(trust) = trust.filter(|_| shipping.has_bundle()) else { return };
    let mut words: Vec<OsString> = vec!["diff".into(), (&shipping.outbox).into(), (&workshop.folder).into()];
    words.extend(["--trust".into(), trust.into()]);
    if let Some(unit) = shipping.last_addressee() {
        words.extend(["--unit".into(), unit.as_str().into()]);
    }
    let of = shipping.outbox.display().to_string();
    let new = NewJob {
        key: Some("diff".into()),
        ..NewJob::new(Priority::Clip, Kind::Check, "what differs from the last bundle")
    };
    workshop.add_job(new, move |workshop, progress| {
        let (revision, _) = workshop.flock();
        let (mut told, _) = own_command::run(&words, &|line| progress.log(line), &|| progress.is_cancelled())?;
        told["of"] = json!(of);
        *locked(&workshop.difference) = Some((revision, told.clone()));
        workshop.tell_all();
        Ok(told)
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bundle_is_packed_for_the_units_that_are_named_and_for_nothing_else() {
        let scratch = tempfile::tempdir().unwrap();
        let shipping = Shipping::new(scratch.path(), &[], Some("out".into()), Vec::new(), Some("secret".into()));
        let words = |units: &[&str]| {
            let units = units.iter().map(|unit| (*unit).to_owned()).collect();
            let request = PackRequest { key: "artist".to_owned(), units, allow_jumps: false };
            let words = pack_words(Path::new("flock"), &shipping, Path::new("artist.key"), &request).ok()?;
            Some(words.join(" ".as_ref()).into_string().unwrap())
        };
        let common = "pack flock out --key artist.key";
        assert_eq!(words(&[]).unwrap(), format!("{common} --passphrase-file secret"));
        let both = format!("{common} --unit lobby --unit stairs --passphrase-file secret");
        assert_eq!(words(&["lobby", "stairs"]).unwrap(), both);
        assert_eq!(words(&["--system"]), None);
    }
}
