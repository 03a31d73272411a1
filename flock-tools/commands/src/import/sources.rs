//! The files to import, found in the paths of the command line.
//!
//! Owns the search through folders, and the list of files that are skipped for their names. Never opens a file.
//!
//! Start at [`Sources::find`].

use std::collections::{HashMap, HashSet};
use std::fs;
use std::io::ErrorKind;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

use operations::program::{Fatal, print};
use operations::render::plan::ClipRole;

use super::SkippedFile;
use super::file_kind::{FileKind, Origin, file_kind, origin};

/// Names of folders for deleted files and thumbnails, in which artists keep nothing: of Windows, macOS and network drives.
const SYSTEMS: &[&str] =
    &["#recycle", "$RECYCLE.BIN", "@eaDir", "__MACOSX", "lost+found", "RECYCLER", "System Volume Information"];

/// The files to import, in the order in which they are taken in: loops, transitions, genomes, each by name.
#[derive(Debug, Default)]
pub(super) struct Sources {
    pub(super) clips: Vec<SourceClip>,
    pub(super) genomes: Vec<PathBuf>,
    pub(super) skipped: Vec<SkippedFile>,
    /// Clips that were voted down or deleted; only their names are left.
    pub(super) tombstones: usize,
    /// Files of other kinds.
    pub(super) others: usize,
    /// Links to folders that are searched anyway.
    pub(super) links: usize,
    /// Files and folders that are passed over for their names.
    pub(super) hidden: usize,
}

/// A loop or a transition, and the files that show it, by name.
#[derive(Debug)]
pub(super) struct SourceClip {
    pub(super) role: ClipRole,
    pub(super) files: Vec<SourceFile>,
}

/// A video.
#[derive(Clone, Debug)]
pub(super) struct SourceFile {
    pub(super) path: PathBuf,
    pub(super) origin: Origin,
}

/// What the search through folders has seen.
#[derive(Default)]
struct Search {
    /// The folders that were searched, by device and number.
    searched: HashSet<(u64, u64)>,
    /// The folders of the command line, without links.
    roots: Vec<PathBuf>,
    /// Links to folders, which are followed at the end.
    links: Vec<PathBuf>,
}

impl Sources {
    /// The files in `paths`: files, and folders with all that is in them, without the folder `flock`. `given` is the role
    /// of all videos of the command line, if it names one. What cannot be listed is skipped, with a reason.
    /// Errors: If a path is missing.
    pub(super) fn find(paths: &[PathBuf], given: Option<&ClipRole>, flock: &Path) -> Result<Self, Fatal> {
        let mut sources = Self::default();
        let flock = number(flock);
        let mut search = Search { searched: flock.into_iter().collect(), ..Search::default() };
        let (mut folders, mut videos) = (Vec::new(), Vec::new());
        for path in paths {
            let there = fs::symlink_metadata(path);
            match there.and_then(|there| fs::metadata(path).or(Ok(there))) {
                Ok(kind) if kind.is_dir() => folders.push(path),
                Ok(_) => sources.add(path, given, true, &mut videos),
                Err(error) if error.kind() == ErrorKind::PermissionDenied => {
                    sources.skip(path, format!("cannot be read: {error}"));
                }
                Err(error) => return Err(Fatal::read(path, error)),
            }
        }
        search.roots = folders.iter().filter_map(|folder| fs::canonicalize(folder).ok()).collect();
        for folder in folders {
            let number = number(folder);
            // The flock's own folder is searched where the command line names it.
            if number.is_none_or(|number| search.searched.insert(number)) || number == flock {
                sources.list(folder, &mut search, &mut videos);
            }
        }
        while let Some(link) = search.links.pop() {
            sources.follow(&link, &mut search, &mut videos);
        }
        videos.sort_by(|(a, a_role), (b, b_role)| {
            (is_transition(a_role), &a.path).cmp(&(is_transition(b_role), &b.path))
        });
        sources.group(videos);
        sources.genomes.sort();
        Ok(sources)
    }

    /// Adds the files in `top` and in the folders below it.
    fn list(&mut self, top: &Path, search: &mut Search, videos: &mut Vec<(SourceFile, ClipRole)>) {
        let mut waiting = vec![top.to_owned()];
        while let Some(folder) = waiting.pop() {
            let entries = match fs::read_dir(&folder) {
                Ok(entries) => entries,
                Err(error) => {
                    self.skip(&folder, format!("cannot be listed: {error}"));
                    continue;
                }
            };
            for entry in entries {
                match entry.and_then(|entry| Ok((entry.path(), entry.file_type()?))) {
                    Ok((path, _)) if is_hidden(&path) => self.hidden += 1,
                    Ok((path, kind)) if kind.is_dir() => {
                        if number(&path).is_none_or(|number| search.searched.insert(number)) {
                            waiting.push(path);
                        }
                    }
                    Ok((path, kind)) if kind.is_symlink() && path.is_dir() => search.links.push(path),
                    Ok((path, _)) => self.add(&path, None, false, videos),
                    Err(error) => {
                        self.skip(&folder, format!("cannot be listed to its end: {error}"));
                        break;
                    }
                }
            }
        }
    }

    /// Searches the folder that `link` leads to, if it lies in a folder of the command line and was not searched yet.
    fn follow(&mut self, link: &Path, search: &mut Search, videos: &mut Vec<(SourceFile, ClipRole)>) {
        let led = fs::canonicalize(link).and_then(|led| Ok((fs::metadata(&led)?, led)));
        match led {
            Ok((folder, _)) if search.searched.contains(&(folder.dev(), folder.ino())) => self.links += 1,
            Ok((_, led)) if search.roots.iter().any(|root| is_hidden_below(root, &led)) => self.hidden += 1,
            Ok((folder, led)) if search.roots.iter().any(|root| led.starts_with(root)) => {
                search.searched.insert((folder.dev(), folder.ino()));
                self.list(link, search, videos);
            }
            Ok((_, led)) => {
                self.skip(
                    link,
                    format!("it leads to another folder, `{}`, which is imported if named", print::path(&led)),
                );
            }
            Err(error) => self.skip(link, format!("cannot be followed: {error}")),
        }
    }

    fn add(&mut self, path: &Path, given: Option<&ClipRole>, is_given: bool, videos: &mut Vec<(SourceFile, ClipRole)>) {
        let video = |origin| SourceFile { path: path.to_owned(), origin };
        match (file_kind(path), given) {
            (FileKind::Genomes, _) => self.genomes.push(path.to_owned()),
            (_, Some(role)) => videos.push((video(origin(path)), role.clone())),
            (FileKind::Clip(role, origin), None) => videos.push((video(origin), role)),
            (FileKind::Unclear(reason), None) => self.skip(path, reason),
            (FileKind::Tombstone, None) => self.tombstones += 1,
            (FileKind::Other, None) if is_given => {
                self.skip(path, "its ending is not one that is imported (expected a video or a genome)".to_owned());
            }
            (FileKind::Other, None) => self.others += 1,
        }
    }

    fn skip(&mut self, path: &Path, reason: String) {
        self.skipped.push(SkippedFile::new(path, reason));
    }

    /// Puts together the videos of each role.
    fn group(&mut self, videos: Vec<(SourceFile, ClipRole)>) {
        let mut places: HashMap<ClipRole, usize> = HashMap::new();
        for (file, role) in videos {
            let place = *places.entry(role.clone()).or_insert(self.clips.len());
            match self.clips.get_mut(place) {
                // The command line may name a file and its folder.
                Some(clip) if clip.files.iter().any(|other| other.path == file.path) => (),
                Some(clip) => clip.files.push(file),
                None => self.clips.push(SourceClip { role, files: vec![file] }),
            }
        }
    }
}

/// Why `other` is skipped where a file shows `role` already.
pub(super) fn doubled(role: &ClipRole, first: &Path, other: &Path) -> SkippedFile {
    let shows = match role {
        ClipRole::Loop(id) => format!("the loop of `{id}`"),
        ClipRole::Transition(from, to) => format!("the transition from `{from}` to `{to}`"),
    };
    let reason = format!("it shows {shows}, as does `{}`", print::path(first));
    SkippedFile::new(other, reason)
}

/// Whether a file or a folder is hidden, or is where a system puts deleted files or files of its own.
fn is_hidden(path: &Path) -> bool {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    name.starts_with('.') || SYSTEMS.iter().any(|system| name.eq_ignore_ascii_case(system))
}

/// Whether `folder` is such a folder below `root`, or lies in one.
fn is_hidden_below(root: &Path, folder: &Path) -> bool {
    folder.strip_prefix(root).is_ok_and(|inside| inside.iter().any(|name| is_hidden(Path::new(name))))
}

/// The device and the number of a folder.
fn number(folder: &Path) -> Option<(u64, u64)> {
    fs::metadata(folder).map(|folder| (folder.dev(), folder.ino())).ok()
}

fn is_transition(role: &ClipRole) -> bool {
    matches!(role, ClipRole::Transition(..))
}
