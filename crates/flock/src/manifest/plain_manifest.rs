//! A manifest in the plain form, one sheep or transition after another.
//!
//! Owns the order: the head, which is TOML of any form, then tables. `plain.rs` finds them; `mod.rs` defines their keys.
//!
//! Start at [`plain`].

use toml::de::DeTable;

use super::names::KnownIds;
use super::plain::{Block, Blocks};
use super::table::{ManifestError, Source, Table};
use super::{MANIFEST, Manifest, SHEEP, Sheep, TRANSITION, Transition, UNIT_DOCUMENT_BYTES, head, sheep, transition};

/// Why a manifest was not read in place.
pub(crate) enum NotPlain {
    /// It is plain, and wrong.
    Fault(ManifestError),
    /// It is not plain at this byte: this many bytes would have to be parsed as a TOML document.
    NotPlain { at: usize, bytes: u64 },
}

impl NotPlain {
    /// The error of a reader that builds no document of `source`.
    pub(crate) fn refused(self, source: Source<'_>) -> ManifestError {
        match self {
            Self::Fault(error) => error,
            Self::NotPlain { at, bytes } => source.not_plain(at, bytes, UNIT_DOCUMENT_BYTES),
        }
    }
}

impl From<ManifestError> for NotPlain {
    fn from(error: ManifestError) -> Self {
        Self::Fault(error)
    }
}

/// The manifest in `source`, if it is plain and valid, and its head has at most `most` bytes.
pub(crate) fn plain(source: Source<'_>, most: u64) -> Result<Manifest, NotPlain> {
    let mut plain = PlainManifest::open(source, most)?;
    let (mut sheep, mut transitions) = (Vec::new(), Vec::new());
    while let Some(item) = plain.next()? {
        match item {
            Item::Sheep(one) => sheep.push(one),
            Item::Transition(one) => transitions.push(one),
        }
    }
    Ok(Manifest { sheep, transitions, ..plain.head })
}

/// A manifest that is being read.
pub(crate) struct PlainManifest<'t> {
    source: Source<'t>,
    /// Its head: sheep and transitions are empty.
    head: Manifest,
    blocks: Blocks<'t>,
    /// The table that was read last.
    block: Block<'t>,
    known: KnownIds,
}

/// What stands below a header.
enum Item {
    Sheep(Sheep),
    Transition(Transition),
}

impl<'t> PlainManifest<'t> {
    /// Reads the head of the manifest in `source`, which has at most `most` bytes.
    pub(crate) fn open(source: Source<'t>, most: u64) -> Result<Self, NotPlain> {
        let bytes = source.text.len() as u64;
        let (text, blocks) = Blocks::split(source.text).map_err(|at| NotPlain::NotPlain { at, bytes })?;
        let bytes = text.len() as u64;
        if bytes > most {
            return Err(NotPlain::NotPlain { at: 0, bytes });
        }
        let document = DeTable::parse(text).map_err(|error| source.syntax(&error))?;
        let mut table = Table::new(source, MANIFEST, &document);
        let head = head(&mut table)?;
        table.finish()?;
        Ok(Self { source, head, blocks, block: Block::new(), known: KnownIds::default() })
    }

    /// Whether it is `manifest`, whose head, sheep and transitions are compared as they are read.
    pub(crate) fn is(mut self, manifest: &Manifest) -> Result<bool, NotPlain> {
        let (mut sheep, mut transitions) = (manifest.sheep.iter(), manifest.transitions.iter());
        let Manifest { name, size, fps, .. } = &self.head;
        let mut is_same = (name, *size, *fps) == (&manifest.name, manifest.size, manifest.fps);
        while let Some(item) = self.next()? {
            is_same &= match item {
                Item::Sheep(one) => sheep.next() == Some(&one),
                Item::Transition(one) => transitions.next() == Some(&one),
            };
        }
        Ok(is_same && sheep.next().is_none() && transitions.next().is_none())
    }

    /// The next sheep or transition; `None` at the end.
    fn next(&mut self) -> Result<Option<Item>, NotPlain> {
        let Self { source, blocks, block, known, .. } = self;
        let not_plain = |at| NotPlain::NotPlain { at, bytes: source.text.len() as u64 };
        match (blocks.next(block), block.name) {
            (None, _) => Err(not_plain(blocks.at())),
            (Some(false), _) => Ok(None),
            (Some(true), "sheep") => Ok(Some(Item::Sheep(sheep(Table::plain(*source, SHEEP, block), known)?))),
            (Some(true), "transition") => {
                Ok(Some(Item::Transition(transition(Table::plain(*source, TRANSITION, block), known)?)))
            }
            (Some(true), _) => Err(not_plain(block.at)),
        }
    }
}
