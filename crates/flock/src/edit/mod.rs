//! Edits of a manifest that keep its formatting.
//!
//! Owns the edits for the tools' commands. Everything that an edit does not concern keeps its bytes: comments, order,
//! layout, line ends. The tools open and save the file, atomically.
//!
//! Bytes are replaced at the positions that `layout.rs` finds. `toml_edit` (0.25), which writes it anew, was tried:
//!
//! - It writes every header of a kind like the first one: below `[[sheep]]`, `[[ "sheep" ]]` changes.
//! - It drops a byte order mark and every `\r`. To convert line ends and back does not help a file that has both kinds.
//! - A million weights take 4.6 GiB and 18 s of processor time.
//!
//! Start at [`Edit::parse`].
#![allow(
    clippy::missing_errors_doc,
    reason = "a function that does not say otherwise fails with `EditError::UnknownSheep`"
)]

mod changes;
mod layout;
mod place;
mod render;
mod splice;
#[cfg(test)]
mod tests;

use std::collections::{BTreeSet, HashMap, HashSet};
use std::path::Path;
use std::sync::Arc;

use timing::Rate;

use crate::manifest::{Clip, ClipPath, MAX_REPEATS, Manifest, ManifestError, Sheep, SheepId, Transition};
use changes::Changes;
use render::Pair;

/// A manifest being edited: its text, and its new contents.
///
/// It may have no sheep yet. Of duplicate sheep or transitions the first one is edited, because it counts; dropping and
/// renaming affect all.
#[derive(Debug)]
pub struct Edit {
    text: String,
    manifest: Arc<Manifest>,
    /// For each sheep and transition of `manifest`, its index among the entries of the text; `None` if it is new.
    sheep: Vec<Option<u32>>,
    transitions: Vec<Option<u32>>,
    changes: Changes,
    lookup: Option<Lookup>,
}

/// Why an edit was not made. The manifest is unchanged.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum EditError {
    /// A sheep of this id is in the flock.
    #[error("sheep `{id}` already exists in the flock")]
    DuplicateSheep {
        /// Which.
        id: SheepId,
    },
    /// A transition between these two is in the flock.
    #[error("a transition from `{from}` to `{to}` already exists in the flock")]
    DuplicateTransition {
        /// Where it starts.
        from: SheepId,
        /// Where it ends.
        to: SheepId,
    },
    /// An invalid want or weight.
    #[error("a {what} must be a finite number above 0, found `{found}`")]
    Number {
        /// `want` or `weight`.
        what: &'static str,
        /// As given.
        found: f64,
    },
    /// An invalid number of loops per visit.
    #[error("a sheep is repeated 1 to {MAX_REPEATS} times, found `{found}`")]
    Repeat {
        /// As given.
        found: u32,
    },
    /// No such sheep.
    #[error("sheep `{id}` is not in the flock")]
    UnknownSheep {
        /// Which.
        id: SheepId,
    },
    /// No such transition.
    #[error("there is no transition from `{from}` to `{to}`")]
    UnknownTransition {
        /// Where it would start.
        from: SheepId,
        /// Where it would end.
        to: SheepId,
    },
}

/// The two kinds of entries.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Sheep,
    Transition,
}

/// The index of each sheep and transition in the manifest, so that many edits need one pass.
#[derive(Debug)]
struct Lookup {
    names: HashMap<SheepId, u32>,
    sheep: HashMap<u32, u32>,
    transitions: HashMap<(u32, u32), u32>,
}

impl Edit {
    /// Takes the manifest `text` for editing; `path` is only named in errors.
    ///
    /// # Errors
    /// [`ManifestError`], as [`Manifest::parse`], except that sheep may be missing.
    pub fn parse(text: String, path: &Path) -> Result<Self, ManifestError> {
        let manifest = Manifest::parse_unfinished(&text, path)?;
        Ok(Self::of(text, manifest))
    }

    /// The manifest of a flock without sheep, of clips of `size` (width and height in pixels) and `fps` frames per second.
    pub fn blank(name: &str, size: (u32, u32), fps: Rate) -> Self {
        let text = render::head(name, size, fps);
        let manifest = Manifest { name: name.to_owned(), size, fps, sheep: Vec::new(), transitions: Vec::new() };
        Self::of(text, manifest)
    }

    /// `text`, whose contents are `manifest`, not edited yet.
    fn of(text: String, manifest: Manifest) -> Self {
        let changes = Changes::none(manifest.sheep.len(), manifest.transitions.len());
        let origins = |kind| (0..changes.entry_count(kind) as u32).map(Some).collect();
        let (sheep, transitions) = (origins(Kind::Sheep), origins(Kind::Transition));
        Self { text, manifest: Arc::new(manifest), sheep, transitions, changes, lookup: None }
    }

    /// The contents of the edited text.
    pub fn manifest(&self) -> &Manifest {
        &self.manifest
    }

    /// The same, to be kept: the next edit changes another one.
    pub fn shared_manifest(&self) -> Arc<Manifest> {
        Arc::clone(&self.manifest)
    }

    /// The text with all edits. Other bytes are unchanged.
    ///
    /// # Panics
    /// If the parsers of manifest and layout find different entries, which is a bug.
    pub fn text(&self) -> String {
        place::text(self, self.text.clone())
    }

    /// The same, in the memory of the text before. `None` if it does not read back as the contents of the edited text, which
    /// is a bug.
    pub fn into_text(mut self) -> Option<String> {
        self.lookup = None;
        let text = std::mem::take(&mut self.text);
        let text = place::text(&self, text);
        let Self { manifest, .. } = self;
        manifest.is_written_in(&text).then_some(text)
    }

    /// Sets the weight of the transition from `from` to `to`.
    ///
    /// # Errors
    /// [`EditError::UnknownTransition`]; [`EditError::Number`] unless `weight` is finite and above 0.
    pub fn set_weight(&mut self, from: &SheepId, to: &SheepId, weight: f64) -> Result<(), EditError> {
        let at = self.transition(from, to)?;
        self.set_weight_at(at, weight).map(|_| ())
    }

    /// Sets the weight of the transition at place `at` of the manifest; returns whether it is another than before. Many
    /// weights are set so without an index of the names, which takes 40 bytes a transition.
    ///
    /// # Errors
    /// [`EditError::Number`] unless `weight` is finite and above 0.
    pub fn set_weight_at(&mut self, at: usize, weight: f64) -> Result<bool, EditError> {
        positive("weight", weight)?;
        let is_new = self.manifest.transitions[at].weight.to_bits() != weight.to_bits();
        if is_new {
            self.changed().transitions[at].weight = weight;
            self.change(Kind::Transition, at, ["weight"]);
        }
        Ok(is_new)
    }

    /// Sets the want of the sheep `id`, relative to the others.
    ///
    /// # Errors
    /// [`EditError::UnknownSheep`]; [`EditError::Number`] unless `want` is finite and above 0.
    pub fn set_want(&mut self, id: &SheepId, want: f64) -> Result<(), EditError> {
        positive("want", want)?;
        let at = self.sheep(id)?;
        if self.manifest.sheep[at].want.to_bits() != want.to_bits() {
            self.changed().sheep[at].want = want;
            self.change(Kind::Sheep, at, ["want"]);
        }
        Ok(())
    }

    /// Sets how often the loop of the sheep `id` is shown at each visit.
    ///
    /// # Errors
    /// [`EditError::UnknownSheep`]; [`EditError::Repeat`] unless `repeat` is from 1 to [`MAX_REPEATS`].
    pub fn set_repeat(&mut self, id: &SheepId, repeat: u32) -> Result<(), EditError> {
        if !(1..=MAX_REPEATS).contains(&repeat) {
            return Err(EditError::Repeat { found: repeat });
        }
        let at = self.sheep(id)?;
        if self.manifest.sheep[at].repeat != repeat {
            self.changed().sheep[at].repeat = repeat;
            self.change(Kind::Sheep, at, ["repeat"]);
        }
        Ok(())
    }

    /// Gives the sheep `id` the loop `clip`: its frames, its path, and its hash if it has one.
    pub fn set_loop(&mut self, id: &SheepId, clip: Clip) -> Result<(), EditError> {
        let at = self.sheep(id)?;
        let changes = clip_changes(self.manifest.sheep[at].clip.as_ref(), &clip);
        self.changed().sheep[at].clip = Some(clip);
        self.change(Kind::Sheep, at, changes);
        Ok(())
    }

    /// Gives the sheep `id` the genome at `genome`.
    pub fn set_genome(&mut self, id: &SheepId, genome: ClipPath) -> Result<(), EditError> {
        let at = self.sheep(id)?;
        if self.manifest.sheep[at].genome.as_ref() != Some(&genome) {
            self.changed().sheep[at].genome = Some(genome);
            self.change(Kind::Sheep, at, ["genome"]);
        }
        Ok(())
    }

    /// Gives the transition from `from` to `to` another clip: its frames, its path, and its hash if it has one.
    ///
    /// # Errors
    /// [`EditError::UnknownTransition`].
    pub fn set_transition_clip(&mut self, from: &SheepId, to: &SheepId, clip: Clip) -> Result<(), EditError> {
        let at = self.transition(from, to)?;
        let changes = clip_changes(Some(&self.manifest.transitions[at].clip), &clip);
        self.changed().transitions[at].clip = clip;
        self.change(Kind::Transition, at, changes);
        Ok(())
    }

    /// Adds `sheep` below the others.
    ///
    /// # Errors
    /// [`EditError::DuplicateSheep`]; [`EditError::Number`] unless its want is finite and above 0.
    pub fn add_sheep(&mut self, sheep: Sheep) -> Result<(), EditError> {
        positive("want", sheep.want)?;
        if self.sheep(&sheep.id).is_ok() {
            return Err(EditError::DuplicateSheep { id: sheep.id });
        }
        let at = self.manifest.sheep.len() as u32;
        let lookup = self.lookup();
        let name = lookup.name(&sheep.id);
        lookup.sheep.insert(name, at);
        self.changed().sheep.push(sheep);
        self.sheep.push(None);
        Ok(())
    }

    /// Adds `transition` below the others.
    ///
    /// # Errors
    /// [`EditError::DuplicateTransition`]; [`EditError::UnknownSheep`] if it names a sheep that is not in the flock;
    /// [`EditError::Number`] unless its weight is finite and above 0.
    pub fn add_transition(&mut self, transition: Transition) -> Result<(), EditError> {
        positive("weight", transition.weight)?;
        self.sheep(&transition.from)?;
        self.sheep(&transition.to)?;
        if self.transition(&transition.from, &transition.to).is_ok() {
            return Err(EditError::DuplicateTransition { from: transition.from, to: transition.to });
        }
        let at = self.manifest.transitions.len() as u32;
        let lookup = self.lookup();
        let pair = (lookup.name(&transition.from), lookup.name(&transition.to));
        lookup.transitions.insert(pair, at);
        self.changed().transitions.push(transition);
        self.transitions.push(None);
        Ok(())
    }

    /// Drops the sheep `id` and every transition from or to it.
    ///
    /// An entry is removed with its lines, from its header to its last key; comments above and below it stay.
    pub fn drop_sheep(&mut self, id: &SheepId) -> Result<(), EditError> {
        self.drop_all(&BTreeSet::from([id.clone()]))
    }

    /// Drops all the sheep `ids`, as [`Edit::drop_sheep`] each of them, or none if one is not in the flock.
    pub fn drop_all(&mut self, ids: &BTreeSet<SheepId>) -> Result<(), EditError> {
        ids.iter().try_for_each(|id| self.sheep(id).map(drop))?;
        keep(&mut Arc::make_mut(&mut self.manifest).sheep, &mut self.sheep, |sheep| !ids.contains(&sheep.id));
        self.keep_transitions(|t| !ids.contains(&t.from) && !ids.contains(&t.to));
        Ok(())
    }

    /// Keeps the sheep `ids`, the transitions among them, and nothing else: of duplicates the first.
    pub fn keep_only(&mut self, ids: &BTreeSet<SheepId>) {
        let (mut seen, mut seen_pairs) = (HashSet::new(), HashSet::new());
        keep(&mut Arc::make_mut(&mut self.manifest).sheep, &mut self.sheep, |sheep| {
            ids.contains(&sheep.id) && seen.insert(sheep.id.clone())
        });
        self.keep_transitions(|t| {
            ids.contains(&t.from) && ids.contains(&t.to) && seen_pairs.insert((t.from.clone(), t.to.clone()))
        });
    }

    /// Drops the transition from `from` to `to`.
    ///
    /// # Errors
    /// [`EditError::UnknownTransition`].
    pub fn drop_transition(&mut self, from: &SheepId, to: &SheepId) -> Result<(), EditError> {
        self.transition(from, to)?;
        self.keep_transitions(|t| t.from != *from || t.to != *to);
        Ok(())
    }

    /// Drops all the transitions between `pairs`, or none if one is not in the flock.
    ///
    /// # Errors
    /// [`EditError::UnknownTransition`].
    pub fn drop_transitions(&mut self, pairs: &BTreeSet<(SheepId, SheepId)>) -> Result<(), EditError> {
        pairs.iter().try_for_each(|(from, to)| self.transition(from, to).map(drop))?;
        self.keep_transitions(|t| !pairs.contains(&(t.from.clone(), t.to.clone())));
        Ok(())
    }

    /// Gives the sheep `old` the id `new`, in every transition too. Paths of files are left as they are.
    ///
    /// # Errors
    /// [`EditError::UnknownSheep`] if there is no `old`, [`EditError::DuplicateSheep`] if there is a `new`.
    pub fn rename(&mut self, old: &SheepId, new: &SheepId) -> Result<(), EditError> {
        self.sheep(old)?;
        if self.sheep(new).is_ok() {
            return Err(EditError::DuplicateSheep { id: new.clone() });
        }
        for at in 0..self.manifest.sheep.len() {
            if self.manifest.sheep[at].id == *old {
                self.changed().sheep[at].id = new.clone();
                self.change(Kind::Sheep, at, ["id"]);
            }
        }
        for at in 0..self.manifest.transitions.len() {
            let Transition { from, to, .. } = &mut self.changed().transitions[at];
            let (starts, ends) = (from == old, to == old);
            if starts {
                *from = new.clone();
            }
            if ends {
                *to = new.clone();
            }
            let changes = [starts.then_some("from"), ends.then_some("to")];
            self.change(Kind::Transition, at, changes.into_iter().flatten());
        }
        self.lookup = None;
        Ok(())
    }

    /// The contents, to be edited.
    fn changed(&mut self) -> &mut Manifest {
        Arc::make_mut(&mut self.manifest)
    }

    fn keep_transitions(&mut self, stays: impl FnMut(&Transition) -> bool) {
        keep(&mut Arc::make_mut(&mut self.manifest).transitions, &mut self.transitions, stays);
        self.lookup = None;
    }

    /// Records changes of keys of the entry of `kind` at `at`, if it is in the text.
    fn change(&mut self, kind: Kind, at: usize, changes: impl IntoIterator<Item = &'static str>) {
        let Some(entry) = self.origins(kind)[at] else { return };
        for key in changes {
            let place = kind.keys().iter().position(|known| *known == key).expect("a key of its kind");
            self.changes.put(kind, entry, place);
        }
    }

    /// The value of `key` in the sheep or transition at `at`, as it is written; `None` if it has none.
    fn value(&self, kind: Kind, at: usize, key: &str) -> Option<String> {
        match kind {
            Kind::Sheep => render::sheep_value(&self.manifest.sheep[at], key),
            Kind::Transition => render::transition_value(&self.manifest.transitions[at], key),
        }
    }

    fn origins(&self, kind: Kind) -> &[Option<u32>] {
        match kind {
            Kind::Sheep => &self.sheep,
            Kind::Transition => &self.transitions,
        }
    }

    /// The keys of the entries of `kind` that are new, in the order in which they were added.
    fn added(&self, kind: Kind) -> Vec<Vec<Pair>> {
        let new = |(at, origin): (usize, &Option<u32>)| origin.is_none().then_some(at);
        let new = self.origins(kind).iter().enumerate().filter_map(new);
        match kind {
            Kind::Sheep => new.map(|at| render::sheep(&self.manifest.sheep[at])).collect(),
            Kind::Transition => new.map(|at| render::transition(&self.manifest.transitions[at])).collect(),
        }
    }

    fn sheep(&mut self, id: &SheepId) -> Result<usize, EditError> {
        let lookup = self.lookup();
        let at = lookup.names.get(id).and_then(|name| lookup.sheep.get(name));
        at.map(|at| *at as usize).ok_or_else(|| EditError::UnknownSheep { id: id.clone() })
    }

    fn transition(&mut self, from: &SheepId, to: &SheepId) -> Result<usize, EditError> {
        let lookup = self.lookup();
        let pair = lookup.names.get(from).zip(lookup.names.get(to));
        let at = pair.and_then(|(from, to)| lookup.transitions.get(&(*from, *to)));
        let unknown = || EditError::UnknownTransition { from: from.clone(), to: to.clone() };
        at.map(|at| *at as usize).ok_or_else(unknown)
    }

    fn lookup(&mut self) -> &mut Lookup {
        self.lookup.get_or_insert_with(|| Lookup::of(&self.manifest))
    }
}

impl Kind {
    /// The kind whose entries stand under `key`.
    fn named(key: &str) -> Option<Self> {
        match key {
            "sheep" => Some(Self::Sheep),
            "transition" => Some(Self::Transition),
            _ => None,
        }
    }

    fn name(self) -> &'static str {
        match self {
            Self::Sheep => "sheep",
            Self::Transition => "transition",
        }
    }

    fn keys(self) -> &'static [&'static str] {
        match self {
            Self::Sheep => render::SHEEP_KEYS,
            Self::Transition => render::TRANSITION_KEYS,
        }
    }
}

impl Lookup {
    fn of(manifest: &Manifest) -> Self {
        let mut lookup = Self { names: HashMap::new(), sheep: HashMap::new(), transitions: HashMap::new() };
        for (at, sheep) in (0..).zip(&manifest.sheep) {
            let name = lookup.name(&sheep.id);
            lookup.sheep.entry(name).or_insert(at);
        }
        for (at, transition) in (0..).zip(&manifest.transitions) {
            let pair = (lookup.name(&transition.from), lookup.name(&transition.to));
            lookup.transitions.entry(pair).or_insert(at);
        }
        lookup
    }

    /// The number of the name `id`, whether a sheep has it or not.
    fn name(&mut self, id: &SheepId) -> u32 {
        if let Some(name) = self.names.get(id) {
            return *name;
        }
        let name = self.names.len() as u32;
        self.names.insert(id.clone(), name);
        name
    }
}

/// The keys that a clip has with another value, or not any more, where `new` is in place of `old`.
fn clip_changes(old: Option<&Clip>, new: &Clip) -> Vec<&'static str> {
    let is_changed = |key: &str| old.and_then(|old| render::clip_value(old, key)) != render::clip_value(new, key);
    render::CLIP_KEYS.iter().copied().filter(|key| is_changed(key)).collect()
}

fn keep<T>(items: &mut Vec<T>, origins: &mut Vec<Option<u32>>, mut stays: impl FnMut(&T) -> bool) {
    let mut kept = Vec::with_capacity(items.len());
    items.retain(|item| {
        kept.push(stays(item));
        kept.last() == Some(&true)
    });
    let mut kept = kept.into_iter();
    origins.retain(|_| kept.next().unwrap_or_default());
}

fn positive(what: &'static str, found: f64) -> Result<(), EditError> {
    if found.is_normal() && found > 0.0 { Ok(()) } else { Err(EditError::Number { what, found }) }
}
