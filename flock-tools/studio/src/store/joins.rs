//! The joins that were judged, and how well their clips meet.
//!
//! Owns the record of them in `.studio/joins.json`, each with the sizes and times of its two clips: a figure of clips that
//! were rendered again since is not told. Never judges a join: `operations::joins` does.
//!
//! Start at [`JoinRecord::find`].

use std::collections::BTreeMap;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use flock::{Clip, Manifest, SheepId};
use operations::joins::{JudgedJoin, Judgement};

use super::clip_states::since_1970_ms;

/// The record's file in the studio's own folder.
const FILE: &str = "joins.json";

/// A clip's size, and when it was changed, in milliseconds since 1970.
type Stamp = (u64, u64);

/// The joins that were judged.
#[derive(Debug, Default)]
pub(crate) struct JoinRecord {
    path: PathBuf,
    known: BTreeMap<(String, String), KnownJoin>,
}

/// A join that was judged.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub(crate) struct KnownJoin {
    /// The clip that ends, and the one that begins.
    before: String,
    after: String,
    stamps: [Stamp; 2],
    /// Above 1 the join jumps.
    pub(crate) severity: f64,
    /// The largest of what is off, in decibels.
    pub(crate) db: f64,
    /// The same in words.
    pub(crate) why: String,
}

/// The loop or the transition that a clip is.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
#[serde(tag = "kind", rename_all = "lowercase")]
pub(crate) enum End {
    /// The loop of this sheep.
    Loop { sheep: SheepId, frames: u32, fragments: Option<String> },
    /// The transition between these.
    Transition { from: SheepId, to: SheepId, frames: u32, fragments: Option<String> },
}

/// A join as the page shows it.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub(crate) struct ToldJoin {
    pub(crate) from: End,
    pub(crate) to: End,
    pub(crate) severity: f64,
    pub(crate) db: f64,
    pub(crate) why: String,
    /// Whether the artist has marked the transition of this join.
    pub(crate) bad: bool,
}

impl JoinRecord {
    /// The record in the studio's own folder; empty if it cannot be read.
    pub(crate) fn open(own: &Path) -> Self {
        let path = own.join(FILE);
        let read = fs::read(&path).ok().and_then(|bytes| serde_json::from_slice::<Vec<KnownJoin>>(&bytes).ok());
        let known = read.unwrap_or_default().into_iter();
        let known = known.map(|join| ((join.before.clone(), join.after.clone()), join)).collect();
        Self { path, known }
    }

    /// Takes in what was judged in the flock's `folder`.
    /// Errors: If the record cannot be written.
    pub(crate) fn add(&mut self, folder: &Path, judgement: &Judgement) -> io::Result<()> {
        for JudgedJoin { join, figures } in &judgement.joins {
            let paths = [&join.before, &join.after].map(|clip| clip.path.as_str().to_owned());
            let Some(stamps) = stamps(folder, [&join.before, &join.after]) else { continue };
            let offs = [figures.step_db, figures.course_db, figures.speed_db];
            let db = offs.into_iter().max_by(|a, b| a.abs().total_cmp(&b.abs())).unwrap_or(0.0);
            let [before, after] = paths.clone();
            let why = figures.worst_in_words();
            let known = KnownJoin { before, after, stamps, severity: figures.severity, db, why };
            self.known.insert(paths.into(), known);
        }
        let all: Vec<&KnownJoin> = self.known.values().collect();
        durable::write(&self.path, &serde_json::to_vec(&all)?)
    }

    /// What is known of the join from `before` to `after`, as the clips are now in the flock's `folder`.
    pub(crate) fn find(&self, folder: &Path, before: &Clip, after: &Clip) -> Option<&KnownJoin> {
        let known = self.known.get(&(before.path.as_str().to_owned(), after.path.as_str().to_owned()))?;
        (stamps(folder, [before, after]) == Some(known.stamps)).then_some(known)
    }

    /// The joins of `manifest` that were judged, the worst first. `fragments` gives a clip's key; `is_bad` tells whether the
    /// artist has marked a transition.
    pub(crate) fn told(
        &self,
        folder: &Path,
        manifest: &Manifest,
        fragments: impl Fn(&Clip) -> Option<String>,
        is_bad: impl Fn(&SheepId, &SheepId) -> bool,
    ) -> Vec<ToldJoin> {
        let mut ends: BTreeMap<&str, (End, &Clip)> = BTreeMap::new();
        for sheep in &manifest.sheep {
            let Some(clip) = &sheep.clip else { continue };
            let (sheep, frames, fragments) = (sheep.id.clone(), clip.frames.0, fragments(clip));
            ends.insert(clip.path.as_str(), (End::Loop { sheep, frames, fragments }, clip));
        }
        for own in &manifest.transitions {
            let (from, to, clip) = (own.from.clone(), own.to.clone(), &own.clip);
            let (frames, fragments) = (clip.frames.0, fragments(clip));
            ends.insert(clip.path.as_str(), (End::Transition { from, to, frames, fragments }, clip));
        }
        let told = |known: &KnownJoin| {
            let (from, before) = ends.get(known.before.as_str())?;
            let (to, after) = ends.get(known.after.as_str())?;
            self.find(folder, before, after)?;
            let bad = [from, to].into_iter().any(|end| match end {
                End::Loop { .. } => false,
                End::Transition { from, to, .. } => is_bad(from, to),
            });
            let (severity, db, why) = (known.severity, known.db, known.why.clone());
            Some(ToldJoin { from: from.clone(), to: to.clone(), severity, db, why, bad })
        };
        let mut all: Vec<ToldJoin> = self.known.values().filter_map(told).collect();
        all.sort_by(|a, b| b.severity.total_cmp(&a.severity));
        all
    }
}

/// The part of `manifest` that has the joins of the transition from `from` to `to` with the loops at its ends.
pub(crate) fn around(manifest: &Manifest, from: &SheepId, to: &SheepId) -> Manifest {
    let sheep = manifest.sheep.iter().filter(|sheep| sheep.id == *from || sheep.id == *to).cloned().collect();
    let transitions = manifest.transitions.iter().filter(|own| own.from == *from && own.to == *to).cloned().collect();
    Manifest { name: manifest.name.clone(), size: manifest.size, fps: manifest.fps, sheep, transitions }
}

fn stamps(folder: &Path, clips: [&Clip; 2]) -> Option<[Stamp; 2]> {
    let stamp = |clip: &Clip| {
        let status = fs::metadata(clip.path.inside(folder)).ok()?;
        Some((status.len(), since_1970_ms(status.modified().ok()?)))
    };
    let [before, after] = clips.map(stamp);
    Some([before?, after?])
}

#[cfg(test)]
mod tests {
    use super::*;
    use operations::decoder::ffmpeg::Ffmpeg;
    use operations::joins::judge;

    #[test]
    fn joins_are_known_after_a_restart_until_a_clip_is_rendered_again() {
        let scratch = tempfile::tempdir().unwrap();
        let demo = Path::new(env!("CARGO_MANIFEST_DIR")).join("../demo/small");
        let manifest = Manifest::read(&demo).unwrap();
        let one = &manifest.transitions[0];
        let part = around(&manifest, &one.from, &one.to);
        for clip in part.clips() {
            let to = clip.path.inside(scratch.path());
            fs::create_dir_all(to.parent().unwrap()).unwrap();
            fs::copy(clip.path.inside(&demo), to).unwrap();
        }
        let mut record = JoinRecord::open(scratch.path());
        record.add(scratch.path(), &judge(scratch.path(), &part, &Ffmpeg, |_| ())).unwrap();
        let record = JoinRecord::open(scratch.path());
        let told = || record.told(scratch.path(), &part, |_| None, |from, _| *from == one.from);
        let all = told();
        assert!(all.iter().any(|join| matches!(join.from, End::Transition { .. }) && join.bad), "{all:?}");
        assert!(all.is_sorted_by(|a, b| a.severity >= b.severity));
        let from = part.sheep.iter().find(|sheep| sheep.id == one.from).unwrap().clip.clone().unwrap();
        let known = record.find(scratch.path(), &from, &one.clip).unwrap();
        assert!(known.severity < 1.0 && known.why.contains("dB"), "{known:?}");
        fs::write(one.clip.path.inside(scratch.path()), "rendered again").unwrap();
        assert_eq!(record.find(scratch.path(), &from, &one.clip), None);
        assert!(told().len() < all.len());
    }
}
