//! The strips of all sheep, which tell how much moves in each and its colour.
//!
//! Owns the job that makes those that are not there. It is as urgent as a clip: strips that a page shows have jobs of their
//! own, before it. A sheep that cannot be drawn is named in the log, and the others go on.
//!
//! Start at [`queue`].

use std::sync::Arc;

use flock::{Measure, SheepId};
use serde_json::{Value, json};

use super::previews::make_strip;
use crate::jobs::{Job, Kind, NewJob, Priority, Progress};
use crate::media::MediaError;
use crate::workshop::Workshop;

/// Queues the strips that are not there, of the flock and of what may come in.
pub(crate) fn queue(workshop: &Arc<Workshop>) -> Job {
    let what = "activity and colour of all sheep";
    let new = NewJob { key: Some("measure".to_owned()), ..NewJob::new(Priority::Clip, Kind::Measure, what) };
    workshop.add_job(new, |workshop, progress| run(workshop, progress))
}

fn run(workshop: &Workshop, progress: &Progress) -> Result<Value, String> {
    let strips = missing(workshop)?;
    let of = strips.len() as u64;
    let mut failed = 0;
    for ((id, key), done) in strips.iter().zip(0..) {
        progress.set(done, of);
        progress.wait_if_paused();
        match make_strip(workshop, key, &progress.for_part()) {
            Ok(()) => {}
            Err(MediaError::Cancelled) => return Err("cancelled".to_owned()),
            Err(error) => {
                failed += 1;
                progress.log(&format!("{id}: {error}"));
            }
        }
    }
    progress.set(of, of);
    Ok(json!({ "measured": of - failed, "failed": failed }))
}

/// The sheep of whose strips nothing is known, with the keys of those.
fn missing(workshop: &Workshop) -> Result<Vec<(SheepId, String)>, String> {
    let state = workshop.state(Measure::Visits).map_err(|_| "`credits.toml` cannot be read".to_owned())?;
    let all = state.part.sheep.into_iter().chain(state.part.candidates);
    let unknown = all.filter(|sheep| sheep.activity.is_none());
    Ok(unknown.filter_map(|sheep| Some((sheep.id, sheep.strip?))).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::events::EventKind;
    use std::fmt::Write;
    use std::fs;
    use std::path::Path;
    use std::time::Duration;

    #[test]
    fn sheep_that_nobody_has_looked_at_are_measured_once_and_the_pages_are_told_of_each() {
        let scratch = tempfile::tempdir().unwrap();
        let genomes = Path::new(env!("CARGO_MANIFEST_DIR")).join("../demo/genomes");
        let mut text = "format = 1\nname = \"small\"\nsize = [64, 36]\nfps = [30, 1]\n".to_owned();
        for id in ["lagoon", "vesper"] {
            fs::copy(genomes.join(format!("{id}.expr")), scratch.path().join(format!("{id}.expr"))).unwrap();
            write!(text, "[[sheep]]\nid = \"{id}\"\ngenome = \"{id}.expr\"\n").unwrap();
        }
        fs::write(scratch.path().join(flock::FILE_NAME), text).unwrap();
        let workshop = Workshop::of_folder(scratch.path());
        let mut told = workshop.hub.subscribe(None);
        assert_eq!(told.at_once().map(|event| event.kind), Some(EventKind::State));
        let measure = || {
            let id = queue(&workshop).id;
            assert!(
                workshop.queue.wait_until(Duration::from_mins(5), |jobs| jobs.iter().all(|job| job.state.is_over()))
            );
            workshop.queue.job(id).unwrap().result.unwrap()
        };
        assert_eq!(measure(), json!({ "measured": 2, "failed": 0 }));
        let events = std::iter::from_fn(|| told.at_once());
        let looks: Vec<Value> = events
            .filter(|event| event.kind == EventKind::Looks)
            .map(|event| serde_json::from_str::<Value>(&event.data).unwrap()["looks"][0].clone())
            .collect();
        let state = workshop.state(Measure::Visits).ok().unwrap();
        for sheep in &state.part.sheep {
            let look = looks.iter().find(|look| look["strip"] == json!(sheep.strip)).expect("it was told");
            let (told, known) = (look["activity"].as_f64().unwrap(), sheep.activity.unwrap());
            // Text keeps a number to its last digit but one.
            assert!(known > 0.0 && (told - known).abs() < 1e-12, "{told} {known}");
            assert_eq!(look["colour"], json!(sheep.colour));
        }
        assert_eq!(measure(), json!({ "measured": 0, "failed": 0 }));
    }
}
