//! What an import is going to do with each clip, before it does it.
//!
//! Owns the look at a clip that is cheap: its header, its shape, whether the flock has it. Never decodes a picture and
//! never writes: `take.rs` does.
//!
//! Start at [`Plan::of`].

use std::path::{Path, PathBuf};

use flock::{ClipPath, Manifest};
use timing::Rate;
use video::{ForeignVideo, Form, VideoInfo};

use super::fit::{Fit, Fitting};
use crate::places;
use crate::render::plan::Shows;
use crate::report::chain;

/// How the artist wants clips to come in.
#[derive(Clone, Copy, Debug)]
pub(super) struct Wishes {
    pub(super) form: Form,
    pub(super) fit: Option<Fit>,
    /// What a second of a clip is, in its frames; `None`: whatever it is, the frames count.
    pub(super) fps: Option<Rate>,
}

/// A clip to take in.
#[derive(Clone, Debug)]
pub(super) struct Plan {
    pub(super) source: PathBuf,
    pub(super) shows: Shows,
    /// Where it goes.
    pub(super) path: ClipPath,
    pub(super) about: VideoInfo,
    /// `None` where it is in the flock's form and its bytes are taken as they are.
    pub(super) encode: Option<Fitting>,
}

/// What a look at a clip found.
pub(super) enum Looked {
    /// It is to be taken in.
    Due(Box<Plan>),
    /// It is not; why.
    LeftOut(String),
    /// The flock has it.
    Stands(ClipPath),
}

impl Plan {
    /// What becomes of the clip at `source`, which shows `shows`, in the flock of `manifest` in `folder`.
    pub(super) fn of(source: &Path, shows: &Shows, folder: &Path, manifest: &Manifest, wishes: &Wishes) -> Looked {
        if let Some(path) = stands(manifest, shows).filter(|path| path.inside(folder).exists()) {
            return Looked::Stands(path.clone());
        }
        let foreign = match ForeignVideo::open(source) {
            Ok(foreign) => foreign,
            Err(error) => return Looked::LeftOut(chain(&error)),
        };
        let about = foreign.info().clone();
        let fits = wishes.fps.is_none_or(|fps| fps == wishes.form.fps) && in_form(source, &wishes.form);
        let encode = if fits { Ok(None) } else { Fitting::new(&about, wishes.form.size, wishes.fit).map(Some) };
        match encode {
            Ok(encode) => {
                let (source, shows, path) = (source.to_owned(), shows.clone(), place(shows));
                Looked::Due(Box::new(Self { source, shows, path, about, encode }))
            }
            Err(reason) => Looked::LeftOut(reason),
        }
    }
}

/// Where the flock's own clip of this lies, by its manifest.
pub(super) fn stands<'a>(manifest: &'a Manifest, shows: &Shows) -> Option<&'a ClipPath> {
    let clip = match shows {
        Shows::Loop(id) => manifest.sheep.iter().find(|sheep| sheep.id == *id)?.clip.as_ref(),
        Shows::Transition(from, to) => {
            manifest.transitions.iter().find(|t| t.from == *from && t.to == *to).map(|transition| &transition.clip)
        }
    };
    clip.map(|clip| &clip.path)
}

/// Whether a clip is in the form, by its packets.
fn in_form(source: &Path, form: &Form) -> bool {
    video::probe(source).is_ok_and(|probe| probe.differences(form, probe.frames).is_empty())
}

fn place(shows: &Shows) -> ClipPath {
    match shows {
        Shows::Loop(id) => places::of_loop(id, places::CLIP),
        Shows::Transition(from, to) => places::of_transition(from, to, places::CLIP),
    }
}
