//! Whether the clips of a flock meet: every join, judged by the frames on either side.
//!
//! Owns the order of the work: list the joins (`list.rs`), decode the ends of clips on all cores (`ends.rs`), judge them
//! (`figures.rs`), draw the worst on a contact sheet (`sheet.rs`). Never changes a clip.
//!
//! Start at [`judge_with_bar`].

mod ends;
mod figures;
mod list;
mod sheet;
mod view;

use std::collections::HashMap;
use std::io;
use std::path::{Path, PathBuf};

use flock::{Clip, Manifest};
use rayon::iter::{IntoParallelRefIterator, ParallelIterator};
use video::{Form, Yuv420p};

use crate::decoder::Decoder;
use crate::program::progress;
use sheet::Sheet;

pub use figures::Figures;
pub use list::Join;

/// How many joins a contact sheet shows.
const ON_A_SHEET: usize = 20;

/// A join and how well its clips meet.
#[derive(Clone, Debug, PartialEq)]
pub struct JudgedJoin {
    /// Which.
    pub join: Join,
    /// How well.
    pub figures: Figures,
}

/// Every join of a flock, judged.
#[derive(Clone, Debug, Default)]
pub struct Judgement {
    /// Those that could be judged, the worst first.
    pub joins: Vec<JudgedJoin>,
    /// Those that could not, and why: a clip is missing, damaged or of another form.
    pub unjudged: Vec<(Join, String)>,
}

impl Judgement {
    /// The joins that jump, the worst first.
    pub fn jumps(&self) -> impl Iterator<Item = &JudgedJoin> {
        self.joins.iter().take_while(|join| join.figures.jumps())
    }
}

impl Join {
    /// The frames that meet: the last two of the one clip and the first two of the other, in order; fewer where a clip
    /// has a single frame.
    /// Errors: Why a clip cannot be decoded.
    pub fn pictures(&self, folder: &Path, manifest: &Manifest, decoder: &dyn Decoder) -> Result<Vec<Yuv420p>, String> {
        ends::pictures(folder, &form(manifest), &self.before, &self.after, decoder)
    }
}

/// Judges every join of the flock in `folder`, on all cores. Only the ends of its clips are decoded. After each clip
/// `progress` is given the number of joins that were judged at its end; [`count`] is the number of all.
pub fn judge(folder: &Path, manifest: &Manifest, decoder: &dyn Decoder, progress: impl Fn(usize) + Sync) -> Judgement {
    let mut by_clip: HashMap<Clip, usize> = HashMap::new();
    let mut groups: Vec<Vec<Join>> = Vec::new();
    for join in list::all(manifest) {
        let group = *by_clip.entry(join.before.clone()).or_insert_with(|| {
            groups.push(Vec::new());
            groups.len() - 1
        });
        groups[group].push(join);
    }
    let form = form(manifest);
    let judge_group = |group: &Vec<Join>| {
        let afters: Vec<&Clip> = group.iter().map(|join| &join.after).collect();
        let figures = ends::judge(folder, &form, &group[0].before, &afters, decoder);
        progress(group.len());
        figures
    };
    let results: Vec<_> = groups.par_iter().map(judge_group).collect();
    let mut judgement = Judgement::default();
    for (join, result) in groups.into_iter().flatten().zip(results.into_iter().flatten()) {
        match result {
            Ok(figures) => judgement.joins.push(JudgedJoin { join, figures }),
            Err(why) => judgement.unjudged.push((join, why)),
        }
    }
    judgement.joins.sort_by(|a, b| b.figures.severity.total_cmp(&a.figures.severity));
    judgement
}

/// As [`judge`], with its progress shown on a terminal.
pub fn judge_with_bar(folder: &Path, manifest: &Manifest, decoder: &dyn Decoder) -> Judgement {
    let bar = progress::bar("judging joins", count(manifest));
    let judgement = judge(folder, manifest, decoder, |joins| bar.inc(joins as u64));
    bar.finish_and_clear();
    judgement
}

/// A contact sheet that could not be written.
#[derive(Debug, thiserror::Error)]
#[error("cannot write the contact sheet `{path}`")]
pub struct SheetError {
    path: PathBuf,
    source: io::Error,
}

/// Draws the worst joins of the flock in `folder` on a contact sheet, the worst on top, into the PNG file `path`. A join
/// whose clips can no longer be decoded is left out.
/// Errors: [`SheetError`].
pub fn draw(
    folder: &Path,
    manifest: &Manifest,
    judgement: &Judgement,
    path: &Path,
    decoder: &dyn Decoder,
) -> Result<(), SheetError> {
    let mut sheet = Sheet::new();
    for judged in judgement.joins.iter().take(ON_A_SHEET) {
        if let Ok(frames) = judged.join.pictures(folder, manifest, decoder) {
            sheet.add(judged, &frames);
        }
    }
    sheet.save(path).map_err(|source| SheetError { path: path.to_owned(), source })
}

/// The number of joins that `manifest` has.
pub fn count(manifest: &Manifest) -> usize {
    list::all(manifest).len()
}

fn form(manifest: &Manifest) -> Form {
    Form { size: manifest.size, fps: manifest.fps }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::decoder::ffmpeg::Ffmpeg;
    use std::sync::atomic::{AtomicUsize, Ordering};

    fn demo() -> (PathBuf, Manifest) {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../demo/small");
        let manifest = Manifest::read(&folder).unwrap();
        (folder, manifest)
    }

    #[test]
    fn every_join_of_the_demo_meets_and_a_wrong_clip_is_the_worst() {
        let (folder, mut manifest) = demo();
        let counted = AtomicUsize::new(0);
        let judgement = judge(&folder, &manifest, &Ffmpeg, |joins| {
            counted.fetch_add(joins, Ordering::Relaxed);
        });
        let worst = &judgement.joins[0];
        assert!(!worst.figures.jumps(), "{worst:?}");
        assert_eq!((judgement.joins.len(), judgement.unjudged.len()), (80, 0));
        assert_eq!((counted.load(Ordering::Relaxed), count(&manifest)), (80, 80));

        // The loop of another sheep, and one that is not there.
        let medusa = manifest.sheep.iter().find(|sheep| sheep.id.as_str() == "medusa").unwrap().clip.clone();
        manifest.sheep.retain(|sheep| ["bower", "clematis"].contains(&sheep.id.as_str()));
        manifest.sheep[0].clip = medusa;
        manifest.transitions.retain(|transition| transition.from.as_str() == "oracle");
        let gone = manifest.transitions[1].clip.clone();
        manifest.sheep[1].clip = Some(Clip { path: flock::ClipPath::new("gone.mp4").unwrap(), ..gone });
        let judgement = judge(&folder, &manifest, &Ffmpeg, |_| ());
        assert_eq!((judgement.joins.len(), judgement.unjudged.len()), (2, 2));
        let jumping = judgement.jumps().next().unwrap();
        assert_eq!(jumping.join.before.path.as_str(), "transitions/oracle=bower.mp4");
        assert!(jumping.figures.step_db > 6.0, "{jumping:?}");
        assert!(judgement.unjudged[0].1.contains("gone.mp4"), "{:?}", judgement.unjudged);

        let sheet = tempfile::NamedTempFile::new().unwrap();
        draw(&folder, &manifest, &judgement, sheet.path(), &Ffmpeg).unwrap();
        let drawn = png::Decoder::new(io::BufReader::new(std::fs::File::open(sheet.path()).unwrap()));
        let size = drawn.read_info().unwrap().info().size();
        assert_eq!(size, (1344, 8 + 2 * (2 * 24 + 180 + 16)));
    }
}
