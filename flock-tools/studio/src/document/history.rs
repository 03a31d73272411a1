//! What was done, and can be undone.
//!
//! Owns the steps, how far they are undone, and the text that they lead to. That text is the manifest's, but for the hashes
//! of clips, which a render writes at any time and which are nobody's edit. A text that somebody else wrote is a gap between
//! two steps: nothing is undone across it. Never touches a file: `journal.rs` does.
//!
//! Start at [`History::take`].

use std::collections::VecDeque;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::notes::{NoteChange, Notes};
use super::text_change::TextChange;

/// The most steps that can be undone.
pub(super) const MOST_STEPS: usize = 500;
/// The most bytes of all their changes.
pub(super) const MOST_BYTES: usize = 50 << 20;

/// What is done at once and undone at once.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Step {
    /// What it did, in words.
    pub(super) said: String,
    /// The gesture of the page that it belongs to: the next step of the same gesture becomes part of it.
    pub(super) gesture: Option<String>,
    /// What somebody else did to the text before it.
    pub(super) gap: Option<TextChange>,
    /// What it did to the manifest's text.
    pub(super) text: Option<TextChange>,
    /// What it did to the text of the credits.
    pub(super) credits: Option<TextChange>,
    /// What it did to the notes.
    pub(super) notes: Vec<NoteChange>,
}

/// An entry of the journal.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) enum Record {
    /// The state before all that follows; always the first, and only there.
    Base { text: String, notes: Notes },
    /// The last step is done again.
    Redo,
    /// A step is done; with `joined` it becomes part of the one before.
    Step { step: Step, joined: bool },
    /// The last step that is done is undone.
    Undo,
}

/// The steps, and the state that they lead to.
#[derive(Clone, Debug)]
pub(super) struct History {
    base: (Arc<str>, Arc<Notes>),
    steps: VecDeque<Arc<Step>>,
    /// How many steps are done; the others are undone.
    done: usize,
    text: Arc<str>,
    notes: Arc<Notes>,
}

impl Step {
    fn bytes(&self) -> usize {
        let texts = [&self.gap, &self.text, &self.credits].into_iter().flatten().map(TextChange::bytes).sum::<usize>();
        texts + self.said.len() + self.notes.len() * size_of::<NoteChange>()
    }

    fn is_empty(&self) -> bool {
        self.text.is_none() && self.credits.is_none() && self.notes.is_empty()
    }
}

impl History {
    /// Nothing is done yet.
    pub(super) fn new(text: &str, notes: Notes) -> Self {
        let (text, notes): (Arc<str>, _) = (text.into(), Arc::new(notes));
        Self { base: (Arc::clone(&text), Arc::clone(&notes)), steps: VecDeque::new(), done: 0, text, notes }
    }

    /// The manifest's text as the steps leave it.
    pub(super) fn text(&self) -> &Arc<str> {
        &self.text
    }

    /// The notes.
    pub(super) fn notes(&self) -> &Arc<Notes> {
        &self.notes
    }

    /// The step that an undo undoes; `None` if there is none, or if somebody else changed the text behind it.
    pub(super) fn undoes(&self) -> Option<&Arc<Step>> {
        if self.is_at_gap() { None } else { self.steps.get(self.done.checked_sub(1)?) }
    }

    /// The step that a redo does again.
    pub(super) fn redoes(&self) -> Option<&Arc<Step>> {
        self.steps.get(self.done)
    }

    /// Whether the next undo would have to cross what somebody else wrote.
    pub(super) fn is_at_gap(&self) -> bool {
        self.steps.get(self.done).is_some_and(|next| next.gap.is_some())
    }

    /// Whether a step of `gesture` becomes part of the last one.
    pub(super) fn joins(&self, gesture: Option<&str>) -> bool {
        let last = self.steps.back().filter(|_| self.done == self.steps.len());
        gesture.is_some() && last.is_some_and(|last| last.gesture.as_deref() == gesture)
    }

    /// The text before the last step, with what somebody else had written before it; `None` if a step is undone.
    pub(super) fn before_last(&self) -> Option<Arc<str>> {
        let last = self.steps.back().filter(|_| self.done == self.steps.len())?;
        back(last.text.as_ref(), &self.text)
    }

    /// Takes an entry of the journal; `None` if it does not fit what was taken before.
    pub(super) fn take(&mut self, record: Record) -> Option<()> {
        match record {
            Record::Base { .. } => None,
            Record::Redo => self.redo(),
            Record::Step { step, joined } => self.step(step, joined),
            Record::Undo => self.undo(),
        }
    }

    /// The journal that leads to this state: the shortest.
    pub(super) fn records(&self) -> Vec<Record> {
        let (text, notes) = &self.base;
        let base = Record::Base { text: text.to_string(), notes: (**notes).clone() };
        let steps = self.steps.iter().map(|step| Record::Step { step: (**step).clone(), joined: false });
        let undos = (self.done..self.steps.len()).map(|_| Record::Undo);
        std::iter::once(base).chain(steps).chain(undos).collect()
    }

    fn step(&mut self, step: Step, joined: bool) -> Option<()> {
        let foreign = forth(step.gap.as_ref(), &self.text)?;
        let text = forth(step.text.as_ref(), &foreign)?;
        let mut notes = (*self.notes).clone();
        step.notes.iter().for_each(|change| notes.apply(change));
        // What is undone cannot be done again any more; what somebody else wrote before it is still there.
        let lost = self.steps.drain(self.done..).next();
        let gap = match lost.as_deref().and_then(|lost| lost.gap.as_ref()) {
            Some(gap) => TextChange::between(&gap.revert(&self.text)?, &foreign),
            None => step.gap.clone(),
        };
        let step = if joined { self.join(step, &text, &notes)? } else { Step { gap, ..step } };
        if !step.is_empty() || step.gap.is_some() {
            self.steps.push_back(Arc::new(step));
        }
        (self.done, self.text, self.notes) = (self.steps.len(), text, Arc::new(notes));
        self.trim()
    }

    /// The last step and `step`, which led to `text` and `after`, as one; the last one is taken out.
    fn join(&mut self, step: Step, text: &str, after: &Notes) -> Option<Step> {
        let last = self.steps.pop_back()?;
        let first = back(last.text.as_ref(), &self.text)?;
        let credits = match (&last.credits, step.credits) {
            (None, credits) => credits,
            (credits, None) => credits.clone(),
            // Two edits of the credits in one gesture do not occur: only dropping and renaming change them.
            (Some(_), Some(_)) => return None,
        };
        let notes = [&last.notes[..], &step.notes].concat();
        let text = TextChange::between(&first, text);
        let is_undone = text.is_none() && credits.is_none() && take_nothing(&notes, after);
        let notes = if is_undone { Vec::new() } else { notes };
        Some(Step { said: step.said, gesture: step.gesture, gap: last.gap.clone(), text, credits, notes })
    }

    fn undo(&mut self) -> Option<()> {
        let step = Arc::clone(self.undoes()?);
        self.text = back(step.text.as_ref(), &self.text)?;
        let notes = Arc::make_mut(&mut self.notes);
        step.notes.iter().rev().for_each(|change| notes.revert(change));
        self.done -= 1;
        Some(())
    }

    fn redo(&mut self) -> Option<()> {
        let step = Arc::clone(self.redoes()?);
        self.text = forth(step.text.as_ref(), &self.text)?;
        let notes = Arc::make_mut(&mut self.notes);
        step.notes.iter().for_each(|change| notes.apply(change));
        self.done += 1;
        Some(())
    }

    /// Forgets the oldest steps, if there are too many.
    fn trim(&mut self) -> Option<()> {
        let mut bytes: usize = self.steps.iter().map(|step| step.bytes()).sum();
        // The last one stays, however large it is.
        while self.steps.len() > 1 && (self.steps.len() > MOST_STEPS || bytes > MOST_BYTES) && self.done > 0 {
            let oldest = self.steps.pop_front()?;
            bytes -= oldest.bytes();
            self.done -= 1;
            let (text, notes) = &mut self.base;
            *text = forth(oldest.text.as_ref(), &forth(oldest.gap.as_ref(), text)?)?;
            let notes = Arc::make_mut(notes);
            oldest.notes.iter().for_each(|change| notes.apply(change));
        }
        Some(())
    }
}

fn forth(change: Option<&TextChange>, text: &Arc<str>) -> Option<Arc<str>> {
    change.map_or_else(|| Some(Arc::clone(text)), |change| change.apply(text).map(Arc::from))
}

fn back(change: Option<&TextChange>, text: &Arc<str>) -> Option<Arc<str>> {
    change.map_or_else(|| Some(Arc::clone(text)), |change| change.revert(text).map(Arc::from))
}

/// Whether `changes`, which led to `notes`, cancel each other.
fn take_nothing(changes: &[NoteChange], notes: &Notes) -> bool {
    let mut before = notes.clone();
    changes.iter().rev().for_each(|change| before.revert(change));
    before == *notes
}
