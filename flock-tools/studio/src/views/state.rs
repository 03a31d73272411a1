//! The state of the flock as the page gets it, in one document.
//!
//! Owns its form, and how it is put together from the manifest, the shares, the credits, the clips, the joins and the artist's
//! notes. What is read from the disk comes in with [`Sources`].
//!
//! Start at [`flock_part`].

use std::collections::HashMap;
use std::path::Path;

use flame::genome::Unsupported;
use flock::{Fault, Flock, FlockShares, Measure, Sheep, SheepId, SheepShare, Transition};
use operations::credits::{Credit, FlockCredits};
use operations::species::reasons;

use super::figures::{Figures, shown};
use crate::document::{Mark, MarkKind, Notes, Revision};
use crate::jobs::Job;
use crate::media::Keys;
use crate::store::candidates::{Candidate, PoolMarks, VoteCounts};
use crate::store::clip_states::{ClipFile, ClipState, ClipStates};
use crate::store::genomes::{GenomeFacts, Genomes};
use crate::store::joins::JoinRecord;
use crate::store::places::Places;

/// All that the state is made of.
pub(crate) struct Sources<'a> {
    pub(crate) folder: &'a Path,
    pub(crate) flock: &'a Flock,
    pub(crate) by: Measure,
    pub(crate) genomes: &'a Genomes,
    pub(crate) credits: &'a FlockCredits,
    pub(crate) clips: &'a ClipStates,
    pub(crate) joins: &'a JoinRecord,
    pub(crate) places: &'a Places,
    pub(crate) votes: &'a VoteCounts,
    pub(crate) marks: &'a PoolMarks,
    pub(crate) notes: &'a Notes,
    pub(crate) keys: Keys<'a>,
}

/// The state.
#[derive(Debug, serde::Serialize)]
pub(crate) struct State {
    #[serde(flatten)]
    pub(crate) head: Head,
    #[serde(flatten)]
    pub(crate) part: FlockPart,
}

/// The part of the state that is short.
#[derive(Debug, serde::Serialize)]
pub(crate) struct Head {
    pub(crate) revision: Revision,
    pub(crate) name: String,
    /// Numerator and denominator.
    pub(crate) fps: [u32; 2],
    pub(crate) size: [u32; 2],
    /// What wants are compared with.
    pub(crate) by: Measure,
    /// The server's time, in milliseconds since 1970.
    pub(crate) now_ms: u64,
    /// What would be taken back, and done again, in words.
    pub(crate) undo: Option<String>,
    pub(crate) redo: Option<String>,
    pub(crate) jobs: Vec<Job>,
    pub(crate) paused: bool,
    /// `null` until a sheep was accepted.
    pub(crate) pool: Option<PoolState>,
    pub(crate) capabilities: Capabilities,
}

/// The pool.
#[derive(Debug, serde::Serialize)]
pub(crate) struct PoolState {
    pub(crate) name: String,
}

/// What this program can do besides.
#[derive(Debug, serde::Serialize)]
pub(crate) struct Capabilities {
    pub(crate) gpu: bool,
}

/// The part of the state that is about sheep and transitions.
#[derive(Debug, serde::Serialize)]
pub(crate) struct FlockPart {
    pub(crate) figures: Figures,
    pub(crate) faults: Vec<Fault>,
    pub(crate) sheep: Vec<SheepState>,
    pub(crate) candidates: Vec<SheepState>,
    pub(crate) transitions: Vec<TransitionState>,
}

/// A sheep on the page.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
#[expect(clippy::struct_excessive_bools, reason = "independent facts, each a key of the interface")]
pub(crate) struct SheepState {
    pub(crate) id: SheepId,
    /// The ending of its genome's file.
    pub(crate) species: Option<String>,
    pub(crate) in_flock: bool,
    /// Of a candidate: `pool` or `archive`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) source: Option<&'static str>,
    /// As written in the manifest, and as a part of all.
    pub(crate) want: f64,
    pub(crate) wanted: f64,
    pub(crate) share: f64,
    pub(crate) ratio: Option<f64>,
    pub(crate) repeat: u32,
    pub(crate) frames: u32,
    pub(crate) ins: usize,
    pub(crate) outs: usize,
    pub(crate) shown: bool,
    pub(crate) state: ClipState,
    pub(crate) percent: Option<f64>,
    pub(crate) strip: Option<String>,
    pub(crate) fragments: Option<String>,
    pub(crate) genome: bool,
    /// Why its genome cannot be drawn.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) refused: Option<String>,
    /// What its genome is drawn without.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) without: Option<String>,
    pub(crate) licence: Option<String>,
    pub(crate) authors: Vec<String>,
    pub(crate) parents: Vec<String>,
    pub(crate) mark: MarkKind,
    pub(crate) rating: u8,
    pub(crate) votes: Option<VoteCount>,
    pub(crate) activity: Option<f64>,
    pub(crate) colour: Option<String>,
    pub(crate) bytes: Option<u64>,
    pub(crate) made_ms: Option<u64>,
    pub(crate) x: f64,
    pub(crate) y: f64,
    pub(crate) pinned: bool,
}

/// Votes of the people before the picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
pub(crate) struct VoteCount {
    #[serde(rename = "for")]
    pub(crate) up: u64,
    pub(crate) against: u64,
}

/// A transition on the page.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub(crate) struct TransitionState {
    pub(crate) from: SheepId,
    pub(crate) to: SheepId,
    pub(crate) weight: f64,
    pub(crate) visits: f64,
    pub(crate) frames: u32,
    pub(crate) state: ClipState,
    pub(crate) percent: Option<f64>,
    /// Whether both genomes are there and of one species, so that it goes through genomes.
    pub(crate) genetic: bool,
    pub(crate) join: Option<Joins>,
    /// Whether the artist has marked it.
    pub(crate) bad: bool,
    pub(crate) fragments: Option<String>,
    pub(crate) bytes: Option<u64>,
}

/// How well a transition meets the loops at its ends, in decibels off.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub(crate) struct Joins {
    pub(crate) from: Option<Decibels>,
    pub(crate) to: Option<Decibels>,
    /// The larger severity: above 1 it jumps.
    pub(crate) worst: f64,
}

#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub(crate) struct Decibels {
    pub(crate) db: f64,
}

/// The figures of sheep by their ids, and how often transitions are taken.
struct Shares<'f> {
    sheep: HashMap<&'f SheepId, &'f SheepShare<'f>>,
    transitions: HashMap<(&'f SheepId, &'f SheepId), f64>,
}

/// The part of the state that is about sheep and transitions; `candidates` that are in the flock are left out.
pub(crate) fn flock_part(sources: &Sources<'_>, candidates: &[Candidate], faults: Vec<Fault>) -> FlockPart {
    let manifest = sources.flock.manifest();
    let computed = FlockShares::of(sources.flock);
    let shares = Shares::of(computed.as_ref());
    let is_shown = shown(sources.flock);
    let mut degrees: HashMap<&SheepId, [usize; 2]> = HashMap::new();
    for own in &manifest.transitions {
        degrees.entry(&own.to).or_default()[0] += 1;
        degrees.entry(&own.from).or_default()[1] += 1;
    }
    let sheep = manifest.sheep.iter().zip(&sources.credits.sheep).map(|(sheep, credit)| {
        let share = shares.sheep.get(&sheep.id).copied();
        let [ins, outs] = degrees.get(&sheep.id).copied().unwrap_or_default();
        let shown = is_shown.contains(&sheep.id);
        SheepState { ins, outs, shown, ..sources.sheep(sheep, credit, share) }
    });
    let own: HashMap<&SheepId, &Sheep> = manifest.sheep.iter().map(|sheep| (&sheep.id, sheep)).collect();
    let transitions = manifest.transitions.iter().map(|transition| {
        let visits = shares.transitions.get(&(&transition.from, &transition.to)).copied().unwrap_or(0.0);
        sources.transition(transition, visits, [&transition.from, &transition.to].map(|id| own.get(id).copied()))
    });
    FlockPart {
        figures: Figures::of(sources.flock, computed.as_ref(), sources.by),
        faults,
        sheep: sheep.collect(),
        transitions: transitions.collect(),
        candidates: candidates
            .iter()
            .filter(|candidate| !own.contains_key(&candidate.id))
            .map(|candidate| sources.candidate(candidate))
            .collect(),
    }
}

impl SheepState {
    /// With what of its genome is not drawn.
    fn of_genome(self, facts: Option<&GenomeFacts>) -> Self {
        let Some(GenomeFacts { undrawn: Unsupported { refused, without }, unusable, .. }) = facts else { return self };
        let refused = unusable.clone().or_else(|| (!refused.is_empty()).then(|| reasons::refusal(refused)));
        Self { refused, without: (!without.is_empty()).then(|| without.to_string()), ..self }
    }
}

impl<'f> Shares<'f> {
    fn of(shares: Option<&'f FlockShares<'f>>) -> Self {
        let sheep = shares.iter().flat_map(|shares| &shares.sheep);
        let transitions = shares.iter().flat_map(|shares| &shares.transitions);
        Self {
            sheep: sheep.map(|sheep| (sheep.id, sheep)).collect(),
            transitions: transitions.map(|own| ((own.from, own.to), own.visits)).collect(),
        }
    }
}

impl Sources<'_> {
    fn sheep(&self, sheep: &Sheep, credit: &Credit, share: Option<&SheepShare<'_>>) -> SheepState {
        let (share, wanted) = share.map_or((0.0, 0.0), |own| own.share_and_want(self.by));
        let genome = sheep.genome.as_ref().map(|genome| genome.inside(self.folder));
        let species = genome.as_deref().and_then(|genome| self.genomes.facts(genome).species);
        let ClipFile { state, percent, bytes, made_ms } = self.clips.of(self.folder, sheep.clip.as_ref());
        let is_there = state == ClipState::There;
        let clip = sheep.clip.as_ref().filter(|_| is_there);
        let base = SheepState {
            in_flock: true,
            source: None,
            want: sheep.want,
            wanted,
            share,
            ratio: (wanted > 0.0).then(|| share / wanted),
            repeat: sheep.repeat,
            frames: sheep.clip.as_ref().map_or(0, |clip| clip.frames.0),
            state,
            percent,
            bytes,
            made_ms,
            strip: self.keys.strip(sheep.clip.as_ref(), genome.as_deref().filter(|_| species.is_some())),
            fragments: clip.and_then(|clip| self.keys.fragments(clip)),
            genome: species.is_some(),
            species: species.map(str::to_owned),
            licence: credit.licence.as_ref().map(|licence| licence.as_str().to_owned()),
            authors: credit.authors.clone(),
            parents: credit.parents.clone(),
            ..self.blank(&sheep.id)
        };
        self.looked_at(base.of_genome(genome.as_deref().map(|genome| self.genomes.facts(genome)).as_deref()))
    }

    fn candidate(&self, candidate: &Candidate) -> SheepState {
        let base = SheepState {
            source: Some(candidate.source),
            strip: self.keys.strip(None, Some(&candidate.path)),
            genome: true,
            species: candidate.species.clone(),
            licence: candidate.licence.clone(),
            authors: candidate.authors.clone(),
            parents: candidate.parents.clone(),
            made_ms: candidate.made_ms,
            ..self.blank(&candidate.id)
        };
        self.looked_at(base.of_genome(Some(&self.genomes.facts(&candidate.path))))
    }

    /// A sheep of which nothing is known but the artist's notes and the votes.
    fn blank(&self, id: &SheepId) -> SheepState {
        let Mark { kind, rating } = self.notes.marks.get(id).copied().unwrap_or_default();
        let mark = self.marks.get(id).copied().unwrap_or(kind);
        let pin = self.notes.pins.get(id).copied();
        let [x, y] = pin.unwrap_or_else(|| self.places.of(id.as_str()));
        SheepState {
            id: id.clone(),
            species: None,
            in_flock: false,
            source: None,
            want: 1.0,
            wanted: 0.0,
            share: 0.0,
            ratio: None,
            repeat: 1,
            frames: 0,
            ins: 0,
            outs: 0,
            shown: false,
            state: ClipState::None,
            percent: None,
            strip: None,
            fragments: None,
            genome: false,
            refused: None,
            without: None,
            licence: None,
            authors: Vec::new(),
            parents: Vec::new(),
            mark,
            rating,
            votes: self.votes.get(id.as_str()).map(|[up, against]| VoteCount { up: *up, against: *against }),
            activity: None,
            colour: None,
            bytes: None,
            made_ms: None,
            x,
            y,
            pinned: pin.is_some(),
        }
    }

    /// With what is known of its pictures.
    fn looked_at(&self, sheep: SheepState) -> SheepState {
        match sheep.strip.as_deref().and_then(|strip| self.keys.look(strip)) {
            Some((activity, colour)) => SheepState { activity: Some(activity), colour: Some(colour), ..sheep },
            None => sheep,
        }
    }

    fn transition(&self, own: &Transition, visits: f64, ends: [Option<&Sheep>; 2]) -> TransitionState {
        let ClipFile { state, percent, bytes, .. } = self.clips.of(self.folder, Some(&own.clip));
        let is_there = state == ClipState::There;
        let species = ends.map(|sheep| {
            let genome = sheep?.genome.as_ref()?;
            self.genomes.facts(&genome.inside(self.folder)).species
        });
        TransitionState {
            from: own.from.clone(),
            to: own.to.clone(),
            weight: own.weight,
            visits,
            frames: own.clip.frames.0,
            state,
            percent,
            genetic: species[0].is_some() && species[0] == species[1],
            join: is_there.then(|| self.joins_of(own, ends)).flatten(),
            bad: self.notes.bad_joins.contains(&(own.from.clone(), own.to.clone())),
            fragments: is_there.then(|| self.keys.fragments(&own.clip)).flatten(),
            bytes,
        }
    }

    fn joins_of(&self, own: &Transition, ends: [Option<&Sheep>; 2]) -> Option<Joins> {
        let [before, after] = ends.map(|sheep| sheep.and_then(|sheep| sheep.clip.as_ref()));
        let from = before.and_then(|before| self.joins.find(self.folder, before, &own.clip));
        let to = after.and_then(|after| self.joins.find(self.folder, &own.clip, after));
        let worst = from.iter().chain(&to).map(|known| known.severity).reduce(f64::max)?;
        let [from, to] = [from, to].map(|known| known.map(|known| Decibels { db: known.db }));
        Some(Joins { from, to, worst })
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::media::Media;
    use flock::{Clip, ClipPath, Manifest};
    use std::path::PathBuf;
    use timing::FrameCount;

    fn demo() -> (PathBuf, Flock) {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../demo/small");
        let mut manifest = Manifest::read(&folder).unwrap();
        let mut open = manifest.sheep[0].clone();
        open.id = SheepId::new("open").unwrap();
        open.clip = Some(Clip { path: ClipPath::new("loops/open.mp4").unwrap(), frames: FrameCount(9), hash: None });
        manifest.sheep.push(open);
        (folder, Flock::new(manifest))
    }

    /// The demo flock with a sheep that is not rendered.
    pub(crate) fn part(notes: &Notes, candidates: &[Candidate]) -> FlockPart {
        let own = tempfile::tempdir().unwrap();
        let (folder, flock) = demo();
        let (genomes, manifest) = (Genomes::default(), flock.manifest());
        let credits = FlockCredits::of(&folder, manifest).unwrap();
        let media = Media::open(&folder, own.path());
        let sources = Sources {
            folder: &folder,
            flock: &flock,
            by: Measure::Visits,
            genomes: &genomes,
            credits: &credits,
            clips: &ClipStates::default(),
            joins: &JoinRecord::open(own.path()),
            places: &Places::open(own.path()),
            votes: &VoteCounts::from([("bower".to_owned(), [3, 1])]),
            marks: &PoolMarks::new(),
            notes,
            keys: Keys::new(&media, manifest),
        };
        flock_part(&sources, candidates, Vec::new())
    }

    #[test]
    fn the_page_gets_of_each_sheep_its_share_its_clip_its_origin_and_the_artists_notes() {
        let (id, kept) = (SheepId::new("bower").unwrap(), Mark { kind: MarkKind::Kept, rating: 4 });
        let (_, flock) = demo();
        let way = &flock.manifest().transitions[0];
        let notes = Notes {
            marks: [(id.clone(), kept)].into(),
            pins: [(id.clone(), [0.25, -0.5])].into(),
            bad_joins: [(way.from.clone(), way.to.clone())].into(),
        };
        let told = part(&notes, &[]);
        let bower = told.sheep.iter().find(|sheep| sheep.id == id).unwrap();
        assert_eq!(
            (bower.mark, bower.rating, bower.pinned, [bower.x, bower.y]),
            (MarkKind::Kept, 4, true, [0.25, -0.5])
        );
        assert_eq!((bower.state, bower.shown, bower.genome), (ClipState::There, true, true));
        assert_eq!(bower.votes, Some(VoteCount { up: 3, against: 1 }));
        assert!(bower.strip.is_some() && bower.fragments.is_some() && bower.bytes > Some(1000), "{bower:?}");
        assert_eq!((bower.species.as_deref(), bower.ins.min(bower.outs) > 0), (Some("flam3"), true));
        assert!((told.sheep.iter().map(|sheep| sheep.share).sum::<f64>() - 1.0).abs() < 1e-9);
        assert!((told.sheep.iter().map(|sheep| sheep.wanted).sum::<f64>() - 1.0).abs() < 1e-9);
        let open = told.sheep.iter().find(|sheep| sheep.id.as_str() == "open").unwrap();
        assert_eq!((open.state, open.shown, open.fragments.is_some()), (ClipState::Missing, false, false));
        assert!(open.strip.is_some(), "its genome is drawn");
        assert!(told.transitions[0].bad && told.transitions[1..].iter().all(|own| !own.bad));
    }

    #[test]
    fn a_candidate_that_is_in_the_flock_is_told_once() {
        let candidate = |id: &str| Candidate {
            id: SheepId::new(id).unwrap(),
            path: Path::new(env!("CARGO_MANIFEST_DIR")).join("../demo/genomes/orchid.flam3"),
            source: "archive",
            species: Some("flam3".to_owned()),
            licence: None,
            authors: Vec::new(),
            parents: Vec::new(),
            made_ms: None,
        };
        let told = part(&Notes::default(), &[candidate("bower"), candidate("new")]);
        let ids: Vec<&str> = told.candidates.iter().map(|own| own.id.as_str()).collect();
        assert_eq!((ids, told.candidates[0].in_flock, told.candidates[0].strip.is_some()), (vec!["new"], false, true));
    }
}
