//! Do the clips of a flock meet? Every join, judged by the frames on either side.
//!
//! Owns the order of the work: which joins there are (`places.rs`), decoding their ends on all cores (`ends.rs`), the
//! criterion (`figures.rs`), and the sheet on which the worst are looked at (`sheet.rs`). Never changes a clip.
//!
//! Start at [`judge`].

mod ends;
mod figures;
mod places;
mod sheet;
mod view;

use std::collections::HashMap;
use std::io;
use std::path::{Path, PathBuf};

use flock::{Clip, Manifest};
use rayon::iter::{IntoParallelRefIterator, ParallelIterator};
use video::{Form, Yuv420p};

use crate::decoder::Decoder;
use crate::progress;
use sheet::Sheet;

pub(crate) use figures::Figures;
pub(crate) use places::Place;

/// How many joins a contact sheet shows.
const ON_A_SHEET: usize = 20;

/// One join and how it meets.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Join {
    /// Where.
    pub(crate) place: Place,
    /// How.
    pub(crate) figures: Figures,
}

/// Every join of a flock.
#[derive(Clone, Debug, Default)]
pub(crate) struct Judged {
    /// Those that could be seen, the worst first.
    pub(crate) joins: Vec<Join>,
    /// Those that could not, and why: a clip is missing, damaged or of another form.
    pub(crate) unseen: Vec<(Place, String)>,
}

impl Judged {
    /// The joins that jump, the worst first.
    pub(crate) fn jumps(&self) -> impl Iterator<Item = &Join> {
        self.joins.iter().take_while(|join| join.figures.jumps())
    }
}

impl Join {
    /// The frames that meet: the last two of the one clip and the first two of the other, in order; fewer where a clip
    /// has a single frame.
    ///
    /// # Errors
    /// Why a clip cannot be decoded.
    pub(crate) fn pictures(&self, folder: &Path, manifest: &Manifest) -> Result<Vec<Yuv420p>, String> {
        ends::pictures(folder, &form(manifest), &self.place.before, &self.place.after)
    }
}

/// Judges every join of the flock in `folder`, on all cores, decoding no more than the ends of its clips. `done` is told
/// after every clip how many joins were judged at its end; [`count`] tells how many there are.
pub(crate) fn judge(folder: &Path, manifest: &Manifest, done: impl Fn(usize) + Sync) -> Judged {
    let mut by_clip: HashMap<Clip, usize> = HashMap::new();
    let mut groups: Vec<Vec<Place>> = Vec::new();
    for place in places::places(manifest) {
        let group = *by_clip.entry(place.before.clone()).or_insert_with(|| {
            groups.push(Vec::new());
            groups.len() - 1
        });
        groups[group].push(place);
    }
    let form = form(manifest);
    let look = |group: &Vec<Place>| {
        let afters: Vec<&Clip> = group.iter().map(|place| &place.after).collect();
        let found = ends::meetings(folder, &form, &group[0].before, &afters);
        done(group.len());
        found
    };
    let found: Vec<_> = groups.par_iter().map(look).collect();
    let mut judged = Judged::default();
    for (place, found) in groups.into_iter().flatten().zip(found.into_iter().flatten()) {
        match found {
            Ok(figures) => judged.joins.push(Join { place, figures }),
            Err(why) => judged.unseen.push((place, why)),
        }
    }
    judged.joins.sort_by(|a, b| b.figures.severity.total_cmp(&a.figures.severity));
    judged
}

/// As [`judge`], with its progress shown on a terminal.
pub(crate) fn judge_with_bar(folder: &Path, manifest: &Manifest) -> Judged {
    let bar = progress::bar("judging joins", count(manifest));
    let judged = judge(folder, manifest, |done| bar.inc(done as u64));
    bar.finish_and_clear();
    judged
}

/// A contact sheet that could not be written.
#[derive(Debug, thiserror::Error)]
#[error("cannot write the contact sheet `{path}`")]
pub(crate) struct Undrawn {
    path: PathBuf,
    source: io::Error,
}

/// Draws the worst joins of the flock in `folder` on a contact sheet, the worst on top, into the PNG file `path`. A join
/// whose clips can no longer be decoded is left out.
///
/// # Errors
/// [`Undrawn`].
pub(crate) fn draw(
    folder: &Path,
    manifest: &Manifest,
    judged: &Judged,
    path: &Path,
    decoder: &dyn Decoder,
) -> Result<(), Undrawn> {
    let mut sheet = Sheet::new();
    for join in judged.joins.iter().take(ON_A_SHEET) {
        if let Ok(frames) = decoder.meeting(join, folder, manifest) {
            sheet.add(join, &frames);
        }
    }
    sheet.save(path).map_err(|source| Undrawn { path: path.to_owned(), source })
}

/// How many joins `manifest` has.
pub(crate) fn count(manifest: &Manifest) -> usize {
    places::places(manifest).len()
}

fn form(manifest: &Manifest) -> Form {
    Form { size: manifest.size, fps: manifest.fps }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::decoder::Ffmpeg;
    use std::sync::atomic::{AtomicUsize, Ordering};

    fn demo() -> (PathBuf, Manifest) {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("demo/small");
        let manifest = Manifest::read(&folder).unwrap();
        (folder, manifest)
    }

    #[test]
    fn every_join_of_the_demo_meets_and_a_wrong_clip_is_the_worst() {
        let (folder, mut manifest) = demo();
        let counted = AtomicUsize::new(0);
        let judged = judge(&folder, &manifest, |joins| {
            counted.fetch_add(joins, Ordering::Relaxed);
        });
        let worst = &judged.joins[0];
        assert!(!worst.figures.jumps(), "{worst:?}");
        assert_eq!((judged.joins.len(), judged.unseen.len()), (35, 0));
        assert_eq!((counted.load(Ordering::Relaxed), count(&manifest)), (35, 35));

        // The loop of another sheep, and one that is not there.
        let orchid = manifest.sheep[4].clip.clone();
        manifest.sheep.truncate(2);
        manifest.sheep[0].clip = orchid;
        manifest.transitions.retain(|transition| transition.from.as_str() == "nautilus");
        let gone = manifest.transitions[1].clip.clone();
        manifest.sheep[1].clip = Some(Clip { path: flock::ClipPath::new("gone.mp4").unwrap(), ..gone });
        let judged = judge(&folder, &manifest, |_| ());
        assert_eq!((judged.joins.len(), judged.unseen.len()), (2, 2));
        let jumping = judged.jumps().next().unwrap();
        assert_eq!(jumping.place.before.path.as_str(), "transitions/nautilus=blossom.mp4");
        assert!(jumping.figures.step_db > 6.0, "{jumping:?}");
        assert!(judged.unseen[0].1.contains("gone.mp4"), "{:?}", judged.unseen);

        let sheet = tempfile::NamedTempFile::new().unwrap();
        draw(&folder, &manifest, &judged, sheet.path(), &Ffmpeg).unwrap();
        let drawn = png::Decoder::new(io::BufReader::new(std::fs::File::open(sheet.path()).unwrap()));
        let size = drawn.read_info().unwrap().info().size();
        assert_eq!(size, (1344, 8 + 2 * (2 * 24 + 180 + 16)));
    }
}
