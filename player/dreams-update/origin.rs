//! Where an update comes from: a stick or a web server, which look the same from then on.
//!
//! Owns the choice between the two. What both must have is `bundle::Source`.

use crate::astray::Astray;
use crate::fatal::Fatal;
use crate::http_source::HttpSource;
use crate::tls::Judgement;
use bundle::{Folder, FolderError, ObjectId, Source, UnitId};
use std::io::{self, ErrorKind, Read};
use std::path::Path;

/// A place that has bundles.
#[derive(Debug)]
pub(crate) enum Origin {
    /// A folder: on a stick, on any disk.
    Folder(Folder),
    /// A web server.
    Http(HttpSource),
}

impl Origin {
    /// The folder or the address `source`; an address is asked through `proxy`, if its server is accepted by
    /// `judgement`.
    /// Errors: [`Fatal::Source`] or [`Fatal::Address`].
    pub(crate) fn open(source: &str, proxy: Option<&str>, judgement: Judgement) -> Result<Self, Fatal> {
        if source.contains("://") {
            HttpSource::new(source, proxy, judgement).map(Self::Http)
        } else {
            Folder::open(Path::new(source)).map(Self::Folder).map_err(Fatal::Source)
        }
    }

    /// Which units it has bundles for, as far as that can be seen, in order.
    /// Errors: [`Fatal::Source`].
    pub(crate) fn units(&self) -> Result<Vec<UnitId>, Fatal> {
        match self {
            Self::Folder(folder) => match folder.seals() {
                Err(FolderError::Read { source, .. }) if source.kind() == ErrorKind::NotFound => Ok(Vec::new()),
                seals => Ok(seals.map_err(Fatal::Source)?.into_iter().flatten().collect()),
            },
            // A server shows no lists.
            Self::Http(_) => Ok(Vec::new()),
        }
    }

    /// What it has instead of a bundle. A server shows no lists.
    pub(crate) fn astray(&self) -> Option<Astray> {
        match self {
            Self::Folder(folder) => Astray::on(folder.path()),
            Self::Http(_) => None,
        }
    }

    /// Whether it has refused what it was asked for, and has given nothing.
    pub(crate) fn is_shut(&self) -> bool {
        matches!(self, Self::Http(server) if server.is_shut())
    }

    /// Whether another attempt, a moment later, may find what this one did not.
    pub(crate) fn is_far(&self) -> bool {
        matches!(self, Self::Http(_))
    }
}

impl Source for Origin {
    fn small(&mut self, path: &str, limit: u64) -> io::Result<Box<dyn Read + '_>> {
        match self {
            Self::Folder(folder) => folder.small(path, limit),
            Self::Http(server) => server.small(path, limit),
        }
    }

    fn object(&mut self, id: &ObjectId, size: u64, from: u64) -> io::Result<Box<dyn Read + '_>> {
        match self {
            Self::Folder(folder) => folder.object(id, size, from),
            Self::Http(server) => server.object(id, size, from),
        }
    }
}
