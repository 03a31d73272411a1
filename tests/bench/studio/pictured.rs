//! A flock of any size with pictures.
//!
//! Owns how it is made of the few small clips that the claims on the studio have. Never encodes one.
//!
//! Start at [`pictured`].

use claims::programs::claims_folder;
use claims::studio::sheep::{RATE, manifest, small_pictures};
use std::fs;
use std::path::PathBuf;
use tempfile::TempDir;

/// A flock of `sheep` in a ring with two exits each, whose loops are there: copies of those of [`small_pictures`].
pub(crate) fn pictured(sheep: usize) -> TempDir {
    let from = small_pictures();
    let mut clips: Vec<PathBuf> =
        fs::read_dir(from.join("loops")).unwrap().map(|entry| entry.unwrap().path()).collect();
    clips.sort();
    let folder = tempfile::tempdir_in(claims_folder()).unwrap();
    fs::create_dir(folder.path().join("loops")).unwrap();
    let listed = fs::read_to_string(from.join("flock.toml")).unwrap();
    let text = manifest("meadow", sheep, 1).replace("size = [1280, 720]", "size = [320, 180]");
    let mut text = text.replace("fps = [30, 1]", &format!("fps = [{RATE}, 1]"));
    for at in 0..sheep {
        let clip = &clips[at % clips.len()];
        fs::hard_link(clip, folder.path().join(format!("loops/s{at}.mp4"))).unwrap();
        let name = clip.file_name().and_then(|name| name.to_str()).expect("our file names are UTF-8");
        let before = listed.split(&format!("clip = \"loops/{name}\"")).next().unwrap_or_default();
        let frames = before.rsplit("frames = ").next().and_then(|rest| rest.lines().next()).expect("a clip has frames");
        let line = format!("frames = 768\nclip = \"loops/s{at}.mp4\"\n");
        text = text.replacen(&line, &line.replace("768", frames), 1);
    }
    fs::write(folder.path().join("flock.toml"), text).unwrap();
    folder
}
