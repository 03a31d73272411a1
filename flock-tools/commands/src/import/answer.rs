//! The answer of an import.
//!
//! Owns the JSON document and the lines for people, and what the credits are told of each clip. Never decides anything.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use flock::{ClipHash, ClipPath, SheepId};
use operations::credits::{Licence, Said, Subject};
use operations::program::{Fatal, print};
use operations::render::plan::ClipRole;
use serde::Serialize;
use timing::Rate;

use super::SkippedFile;
use super::genomes::{GenomeAnswer, GenomesAnswer, TransitionAnswer};
use super::plan::{ClipPlan, FilePlan, MatrixBy};
use super::summary::Summary;
use crate::import::electric::{ATTRIBUTION, ElectricName};

/// The answer with `--json`.
#[derive(Default, Serialize)]
pub(super) struct Answer {
    pub(super) clips: Vec<ClipAnswer>,
    pub(super) genomes: Vec<GenomeAnswer>,
    /// Transitions that are yet to be rendered, from genomes with two flames.
    pub(super) transitions: Vec<TransitionAnswer>,
    /// Sheep that imported transitions start or end with, and that had to be added, without loops.
    pub(super) added: Vec<SheepId>,
    pub(super) left_out: Vec<SkippedFile>,
    pub(super) plan: Summary,
    pub(super) tombstones: usize,
    /// Links to folders that are searched anyway.
    pub(super) links: usize,
    /// Files and folders that are hidden, or hold deleted files or a system's own.
    pub(super) hidden: usize,
    /// Files with the key frames of one animation, of which sheep were made.
    pub(super) key_frames: usize,
    pub(super) interrupted: bool,
    /// What the genomes' names and flames tell the credits.
    #[serde(skip)]
    pub(super) notes: Vec<(Subject, Said)>,
}

/// A clip in the answer.
#[derive(Serialize)]
pub(super) struct ClipAnswer {
    #[serde(serialize_with = "print::serialize_path")]
    source: PathBuf,
    /// Of a loop.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) sheep: Option<SheepId>,
    /// Of a transition.
    #[serde(skip_serializing_if = "Option::is_none")]
    from: Option<SheepId>,
    #[serde(skip_serializing_if = "Option::is_none")]
    to: Option<SheepId>,
    clip: ClipPath,
    /// `copied` or `encoded`, with a dry run `copy` or `encode`; `stood`: the flock has it.
    state: &'static str,
    /// Whether the flock had another clip, which this one replaces.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    replaces: bool,
    /// In the flock; with a dry run, by the file's header.
    #[serde(skip_serializing_if = "Option::is_none")]
    frames: Option<u64>,
    /// Frames per second by the file.
    #[serde(skip_serializing_if = "Option::is_none")]
    fps: Option<String>,
    /// How many times as fast it looks as its file tells.
    #[serde(skip_serializing_if = "Option::is_none")]
    speed: Option<f64>,
    /// By which its colours are read, if it is encoded, and why.
    #[serde(skip_serializing_if = "Option::is_none")]
    matrix: Option<&'static str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    matrix_by: Option<MatrixBy>,
    #[serde(skip_serializing_if = "Option::is_none")]
    hash: Option<String>,
    /// The tags of the file, which are kept in the clip.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    tags: BTreeMap<String, String>,
}

impl ClipAnswer {
    /// The clip from `source`, which is `role` and has the path `clip` in the flock.
    pub(super) fn new(source: &Path, role: &ClipRole, clip: ClipPath, state: &'static str) -> Self {
        let (sheep, from, to) = match role.clone() {
            ClipRole::Loop(id) => (Some(id), None, None),
            ClipRole::Transition(from, to) => (None, Some(from), Some(to)),
        };
        let (source, tags) = (source.to_owned(), BTreeMap::new());
        let (frames, fps, speed, matrix, matrix_by, hash) = (None, None, None, None, None, None);
        Self {
            source,
            sheep,
            from,
            to,
            clip,
            state,
            replaces: false,
            frames,
            fps,
            speed,
            matrix,
            matrix_by,
            hash,
            tags,
        }
    }

    /// The clip of `plan` from its `file`, for a flock of `fps` frames a second.
    pub(super) fn of(plan: &ClipPlan, file: &FilePlan, fps: Rate, state: &'static str) -> Self {
        let colours = file.encode.as_ref().map(|_| file.colours);
        Self {
            replaces: plan.replaces,
            fps: file.about.fps.map(|fps| fps.to_string()),
            speed: file.speed(fps),
            matrix: colours.map(|(matrix, _)| matrix),
            matrix_by: colours.map(|(_, by)| by),
            tags: file.about.tags.iter().cloned().collect(),
            ..Self::new(&file.source, &plan.role, plan.path.clone(), state)
        }
    }

    /// The same, with its frames and its hash.
    pub(super) fn with(self, frames: Option<u64>, hash: Option<ClipHash>) -> Self {
        Self { frames, hash: hash.map(|hash| hash.to_string()), ..self }
    }

    /// What its file tells the credits, by its name and its tags. Of a clip that was there only Electric Sheep's name tells.
    fn note(&self) -> Option<(Subject, Said)> {
        let subject = match (&self.sheep, &self.from, &self.to) {
            (Some(id), _, _) => Subject::Sheep(id.clone()),
            (None, Some(from), Some(to)) => Subject::Transition(from.clone(), to.clone()),
            (None, _, _) => return None,
        };
        let electric = self.source.file_stem().and_then(|stem| ElectricName::of_file(stem.to_str()?));
        let authors: Vec<String> = self.tags_named(["artist", "author"]).map(str::to_owned).collect();
        let licence = self.tags_named(["license", "licence", "copyright"]).find_map(Licence::read);
        let said = Said {
            authors: Some(authors).filter(|authors| !authors.is_empty()),
            licence: licence.or_else(|| electric.as_ref()?.licence(None)),
            ..Said::default()
        };
        match electric {
            Some(name) => {
                // A loop has its sheep's number; some have a number of their own besides.
                let sheep = name.end_names().filter(|[first, last]| first == last);
                let source = sheep.map_or(name.source(), |[sheep, _]| sheep.source());
                Some((subject, Said { source: Some(source), attribution: Some(ATTRIBUTION.to_owned()), ..said }))
            }
            None if self.state == "stood" => None,
            None => {
                let source = self.source.file_name().map(|name| print::path(Path::new(name)));
                Some((subject, Said { source, ..said }))
            }
        }
    }

    /// The values of the tags with these names, in the order of the names.
    fn tags_named<const N: usize>(&self, names: [&'static str; N]) -> impl Iterator<Item = &str> {
        let of_name = |name: &'static str| self.tags.iter().find(move |(key, _)| key.eq_ignore_ascii_case(name));
        names.into_iter().filter_map(of_name).map(|(_, value)| value.trim()).filter(|value| !value.is_empty())
    }

    /// The same as a line.
    pub(super) fn line(&self) -> String {
        let frames = self.frames.map_or(String::new(), |frames| format!(" {frames} frames,"));
        format!("{}{frames} {} from `{}`", self.clip, self.state, print::path(&self.source))
    }
}

impl Answer {
    /// Adds what became of the genomes.
    pub(super) fn take(&mut self, told: GenomesAnswer) {
        let GenomesAnswer { genomes, transitions, left_out, key_frames, notes } = told;
        self.key_frames += key_frames;
        self.genomes.extend(genomes);
        self.transitions.extend(transitions);
        self.left_out.extend(left_out);
        self.notes.extend(notes);
    }

    /// What is known of everything that was imported: a genome tells more than the name of a clip, and comes first.
    pub(super) fn notes(&self) -> Vec<(Subject, Said)> {
        self.notes.iter().cloned().chain(self.clips.iter().filter_map(ClipAnswer::note)).collect()
    }

    /// Prints the answer. Without `json` the imported clips were printed already. `others` files were of other kinds.
    pub(super) fn print(&self, others: usize, json: bool) -> Result<(), Fatal> {
        if json {
            return print::json(self);
        }
        let planned = self.clips.iter().filter(|clip| ["copy", "encode"].contains(&clip.state)).map(ClipAnswer::line);
        let flame = |genome: &GenomeAnswer| {
            let source = print::path(&genome.source);
            format!("{} {} as sheep `{}` from `{source}`", genome.genome, genome.state, genome.sheep)
        };
        let flames = self.genomes.iter().filter(|genome| genome.state != "stood").map(flame);
        let transition = |transition: &TransitionAnswer| {
            format!("{} {} from `{}`", transition.clip, transition.state, print::path(&transition.source))
        };
        let transitions = self.transitions.iter().filter(|it| it.state != "stood").map(transition);
        print::lines(planned.chain(flames).chain(transitions).chain(self.plan.cost_line()))?;
        for id in &self.added {
            print::note(&format!("note: sheep `{id}` is added without a loop: it is only passed through"));
        }
        for GenomeAnswer { sheep, notes, without, .. } in &self.genomes {
            for what in notes {
                print::note(&format!("note: of genome `{sheep}` {what}"));
            }
            if !without.is_empty() {
                print::note(&format!("note: genome `{sheep}` is drawn without {without}"));
            }
        }
        for SkippedFile { source, reason, .. } in &self.left_out {
            print::note(&format!("left out `{}`: {reason}", print::path(source)));
        }
        let already_there = self.clips.iter().filter(|clip| clip.state == "stood").count()
            + self.genomes.iter().filter(|genome| genome.state == "stood").count()
            + self.transitions.iter().filter(|transition| transition.state == "stood").count();
        for (count, what) in [
            (already_there, "in the flock already"),
            (self.tombstones, "only a name: voted down or deleted"),
            (others, "of kinds that are not imported"),
        ] {
            if count > 0 {
                print::note(&format!("note: {} passed over, {what}", print::count(count, "file")));
            }
        }
        for (count, what, why) in [
            (self.links, "link", "passed over, to folders that are searched anyway"),
            (self.hidden, "item", "passed over: hidden, deleted or of a system; name one to import it"),
            (
                self.key_frames,
                "file",
                "with the key frames of one animation: the motion from one to the next is not imported",
            ),
        ] {
            if count > 0 {
                print::note(&format!("note: {} {why}", print::count(count, what)));
            }
        }
        if self.interrupted {
            print::note("interrupted; the same command continues where this one stopped");
        }
        Ok(())
    }
}
