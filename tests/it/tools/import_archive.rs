//! A whole archive comes into a flock: all that is sound, and a reason for all that is not.
//!
//! Owns the maker of a folder as years of fetching leave it: names in any bytes, codecs, sizes, rates, damages, permissions,
//! links. `dreams import` runs on it as a user without privileges. ffmpeg makes the clips and counts their frames.
//!
//! Start at [`Archive::make`].

use claims::clips::framemd5;
use claims::programs::{self, json, output, succeed};
use rustix::fs::{Mode, mkfifoat};
use rustix::process::geteuid;
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::ffi::OsStr;
use std::fs::{self, Permissions};
use std::os::unix::ffi::OsStrExt;
use std::os::unix::fs::{PermissionsExt, lchown, symlink};
use std::path::{Path, PathBuf};
use std::process::Command;

/// Sheep whose loops are in the archive; as many transitions lead around them.
const SHEEP: usize = 352;
/// The user without privileges, `nobody`.
const NOBODY: u32 = 65_534;
/// What a fault of the graph is called.
const OF_GRAPH: [&str; 4] = ["dead-end", "unreachable", "split", "no-cycle"];

/// Videos that ffmpeg makes: the ending, and the settings.
const VIDEOS: [(&str, &str); 30] = [
    ("avi", "-c:v mpeg4 -q:v 3"),
    ("avi", "-c:v mpeg4 -q:v 3 -bf 2"),
    ("avi", "-c:v libxvid -q:v 3"),
    ("avi", "-c:v msmpeg4 -q:v 3"),
    ("avi", "-c:v msmpeg4v2 -q:v 3"),
    ("avi", "-c:v mjpeg -q:v 3"),
    ("avi", "-c:v ffv1"),
    ("avi", "-c:v huffyuv"),
    ("avi", "-c:v utvideo"),
    ("avi", "-c:v rawvideo -pix_fmt bgr24"),
    ("avi", "-c:v libx264"),
    ("mpg", "-c:v mpeg1video -q:v 3"),
    ("mpeg", "-c:v mpeg2video -q:v 3 -f mpeg"),
    ("m2v", "-c:v mpeg2video -q:v 3"),
    ("m1v", "-c:v mpeg1video -q:v 3"),
    ("vob", "-c:v mpeg2video -q:v 3"),
    ("ts", "-c:v mpeg2video -q:v 3"),
    ("mp4", "-c:v libx264 -bf 3"),
    ("mp4", "-c:v mpeg4 -q:v 3"),
    ("m4v", "-c:v libx264"),
    ("mkv", "-c:v libx264 -bf 2"),
    ("mkv", "-c:v ffv1 -pix_fmt yuv444p"),
    ("h264", "-c:v libx264"),
    ("mov", "-c:v prores_ks"),
    ("mov", "-c:v png"),
    ("webm", "-c:v libvpx"),
    ("ogv", "-c:v libtheora -q:v 8"),
    ("wmv", "-c:v wmv2 -q:v 3"),
    ("flv", "-c:v flv -q:v 3"),
    ("gif", "-c:v gif"),
];
/// Sizes and rates, in turn.
const SIZES: [&str; 4] = ["64x64", "48x36", "96x54", "50x50"];
const RATES: [&str; 5] = ["23", "25", "30", "24000/1001", "15"];

/// A folder of videos, and what is in it.
struct Archive {
    scratch: tempfile::TempDir,
    /// The paths in the flock of all clips that must come in, with their frames and their source.
    sound: BTreeMap<String, (usize, PathBuf)>,
    /// The ends of the names of all that must be named, and the beginnings of the reasons.
    odd: Vec<(&'static str, &'static str)>,
}

impl Archive {
    /// An archive with everything in it.
    fn make() -> Self {
        let scratch = tempfile::tempdir().unwrap();
        let mut archive = Self { scratch, sound: BTreeMap::new(), odd: Vec::new() };
        for folder in [archive.bin(), archive.home(), archive.inbox(), archive.models(), archive.elsewhere()] {
            fs::create_dir(folder).unwrap();
        }
        let models = archive.make_models();
        archive.add_sheep(&models);
        archive.add_cut_clips();
        archive.add_copies(&models);
        archive.add_damages(&models);
        archive.add_names(&models);
        archive.add_links(&models);
        archive.lock_up(&models);
        archive
    }

    fn inbox(&self) -> PathBuf {
        self.scratch.path().join("content")
    }

    fn models(&self) -> PathBuf {
        self.scratch.path().join("models")
    }

    fn elsewhere(&self) -> PathBuf {
        self.scratch.path().join("elsewhere")
    }

    fn bin(&self) -> PathBuf {
        self.scratch.path().join("bin")
    }

    fn flock(&self) -> PathBuf {
        self.home().join("flock")
    }

    /// Where the user may write.
    fn home(&self) -> PathBuf {
        self.scratch.path().join("home")
    }

    /// The videos that the archive has under many names, and the number of their frames.
    fn make_models(&self) -> Vec<(PathBuf, usize)> {
        let make = |(at, (ending, settings)): (usize, &(&str, &str))| {
            let path = self.models().join(format!("{at}.{ending}"));
            let frames = 2 + at % 5;
            // MPEG-1 and MPEG-2 know a few rates.
            let rate = if settings.contains("-c:v mpeg1") || settings.contains("-c:v mpeg2") {
                "25"
            } else {
                RATES[at % RATES.len()]
            };
            film(&path, SIZES[at % SIZES.len()], rate, frames, settings);
            assert_eq!(count(&path), frames, "{settings}");
            (path, frames)
        };
        VIDEOS.iter().enumerate().map(make).collect()
    }

    /// A ring of sheep with a loop each, in folders of all kinds. Every tenth has a way to one without a loop.
    fn add_sheep(&mut self, models: &[(PathBuf, usize)]) {
        let deep = "d/".repeat(70);
        let folders: [&[u8]; 8] = [
            b"mpeg",
            b"mpeg/00247",
            b"caf\xe9",
            b"two words",
            b"new\nline",
            b"\x1b[31mred",
            deep.as_bytes(),
            b"a=b.avi",
        ];
        for at in 0..SHEEP {
            let folder = self.inbox().join(OsStr::from_bytes(folders[at % folders.len()]));
            let next = (at + 1) % SHEEP;
            self.add(&folder, &format!("00247={at:05}={at:05}={at:05}"), &models[at % models.len()]);
            self.add(&folder, &format!("247={}={at:05}={next}", SHEEP + at), &models[(at * 7 + 3) % models.len()]);
        }
        for (at, model) in models.iter().enumerate().take(6) {
            let name = format!("247={}={at}={}", 3000 + at, 4000 + at);
            self.add(&self.inbox().join("mpeg"), &name, model);
        }
    }

    /// Copies `model` into `folder`, under the name `stem` with its ending.
    fn add(&mut self, folder: &Path, stem: &str, (model, frames): &(PathBuf, usize)) {
        let path = folder.join(stem).with_extension(model.extension().unwrap());
        fs::create_dir_all(folder).unwrap();
        fs::copy(model, &path).unwrap();
        self.expect(stem, *frames, path);
    }

    /// The clip of the file `path`, called `stem`, must come in.
    fn expect(&mut self, stem: &str, frames: usize, path: PathBuf) {
        let number = |text: &str| text.parse::<u32>().unwrap();
        let [generation, _, first, last] = stem.split('=').map(number).collect::<Vec<_>>()[..] else { unreachable!() };
        let clip = if first == last {
            format!("loops/{generation}.{first}.mp4")
        } else {
            format!("transitions/{generation}.{first}={generation}.{last}.mp4")
        };
        assert!(self.sound.insert(clip, (frames, path)).is_none(), "{stem} is there once");
    }

    /// What was cut out of longer videos without encoding it again: MP4 with edit lists, and groups that begin open.
    fn add_cut_clips(&mut self) {
        let whole = self.models().join("whole.mp4");
        let x264 = "-c:v libx264 -x264-params open-gop=1:keyint=8:min-keyint=8:scenecut=0:bframes=3:b-adapt=0";
        film(&whole, "64x64", "25", 24, x264);
        for (at, (start, ending, more)) in
            [("0.5", "mp4", ""), ("0.5", "mp4", "-avoid_negative_ts make_zero"), ("0.7", "mkv", "")].iter().enumerate()
        {
            let stem = format!("00248={at}={at}={at}");
            let path = self.inbox().join("mpeg").join(format!("{stem}.{ending}"));
            let mut cut = Command::new("ffmpeg");
            cut.args(["-v", "error", "-nostdin", "-y", "-ss", start, "-i"]).arg(&whole).args(["-c", "copy"]);
            succeed(cut.args(more.split_whitespace()).arg(&path));
            let frames = count(&path);
            assert!((1..24).contains(&frames), "{stem} is cut: {frames} frames");
            self.expect(&stem, frames, path);
        }
    }

    /// Several files for one loop: the first that is sound comes in, damaged ones before it do not stop it.
    fn add_copies(&mut self, models: &[(PathBuf, usize)]) {
        let folder = self.inbox().join("copies");
        self.add(&folder.join("b"), "00249=1=1=1", &models[0]);
        let whole = fs::read(&models[0].0).unwrap();
        fs::create_dir_all(folder.join("a")).unwrap();
        fs::create_dir_all(folder.join("c")).unwrap();
        fs::write(folder.join("a/249=1=1=1.avi"), &whole[..whole.len() / 2]).unwrap();
        fs::write(folder.join("a/0249=1=1=1.avi"), scratched(&models[1].0)).unwrap();
        fs::copy(&models[2].0, folder.join("c/249=1=1=1.avi")).unwrap();
        self.odd.extend([
            ("copies/a/249=1=1=1.avi", "is cut short: "),
            ("copies/a/0249=1=1=1.avi", "does not decode cleanly at frame "),
            ("copies/c/249=1=1=1.avi", "it shows the loop of `249.1`, as does `"),
        ]);
    }

    fn add_damages(&mut self, models: &[(PathBuf, usize)]) {
        let folder = self.inbox().join("damaged");
        fs::create_dir(&folder).unwrap();
        let half = |at: usize| {
            let whole = fs::read(&models[at].0).unwrap();
            // A few bytes more: in the middle of a packet.
            whole[..whole.len() / 2 + 7].to_vec()
        };
        for (name, bytes, why) in [
            ("00250=1=1=1.avi", half(0), "is cut short: "),
            ("00250=2=2=2.avi", Vec::new(), "is empty"),
            ("00250=3=3=3.avi", b"<html>404 Not Found</html>".to_vec(), "is not a readable video: Invalid data"),
            ("00250=4=4=4.mp4", half(17), "is not a readable video: Invalid data"),
            ("00250=5=5=5.mkv", half(21), "is cut short: "),
            ("00250=12=12=12.ts", half(16), "is cut short: "),
            ("00250=13=13=13.ogv", half(26), "is cut short: "),
            ("00250=6=6=6.avi", scratched(&models[1].0), "does not decode cleanly at frame "),
            ("00250=7=7=7.avi.tmp", half(0), "it was not fetched to its end"),
            ("00250=8=8=8.avi.part", half(0), "it was not fetched to its end"),
        ] {
            fs::write(folder.join(name), bytes).unwrap();
            self.odd.push((name, why));
        }
        film(&folder.join("00250=9=9=9.avi"), "64x64", "25", 4, "-c:v mpeg2video -flags +ildct+ilme");
        film(&folder.join("00250=10=10=10.avi"), "64x64", "25", 4, "-c:v rawvideo -pix_fmt pal8");
        fs::write(folder.join("00250=11=11=11.xxx"), "").unwrap();
        self.odd.extend([
            ("00250=9=9=9.avi", "is interlaced at frame 0"),
            ("00250=10=10=10.avi", "has an unsupported pixel format: `pal8`"),
        ]);
    }

    /// Names that no program of ours gave.
    fn add_names(&mut self, models: &[(PathBuf, usize)]) {
        let folder = self.inbox().join("names");
        fs::create_dir(&folder).unwrap();
        let wanted = "its name is `";
        let names: [(&[u8], &str, &str); 9] = [
            (b"00251=1=1=1 (copy).avi", "00251=1=1=1 (copy).avi", wanted),
            (b"00251=1=1=\xff\xfe.avi", "00251=1=1=\\xff\\xfe.avi", wanted),
            (b"00251=1=1=\x1b[2J.avi", "00251=1=1=\\u{1b}[2J.avi", wanted),
            (b"00251=1=1=1\n.avi", "00251=1=1=1\\u{a}.avi", wanted),
            ("00251=1=1=\u{202e}iva".as_bytes(), "", ""),
            ("00251=1=1=\u{9b}31m.avi".as_bytes(), "00251=1=1=\\u{9b}31m.avi", wanted),
            (b"00251=2=2=2.backup", "00251=2=2=2.backup", "its ending is `backup`"),
            (b"00251=3=3=3", "00251=3=3=3", "its ending is ``"),
            // A file that macOS puts beside one of this name: it is hidden.
            (b"._00251=4=4=4.avi", "", ""),
        ];
        for (name, told, why) in names {
            fs::copy(&models[0].0, folder.join(OsStr::from_bytes(name))).unwrap();
            if !told.is_empty() {
                self.odd.push((told, why));
            }
        }
        for other in ["list.xml", "frost.jpg", "00251=5=5=5.jpg", "play_counts.247"] {
            fs::write(folder.join(other), "x").unwrap();
        }
        mkfifoat(rustix::fs::CWD, folder.join("00251=6=6=6.avi"), Mode::RUSR).unwrap();
        self.odd.push(("00251=6=6=6.avi", "is not a file"));
    }

    fn add_links(&mut self, models: &[(PathBuf, usize)]) {
        let folder = self.inbox().join("links");
        fs::create_dir(&folder).unwrap();
        // Files are followed wherever they are.
        fs::copy(&models[3].0, self.elsewhere().join("x.avi")).unwrap();
        symlink(self.elsewhere().join("x.avi"), folder.join("00252=1=1=1.avi")).unwrap();
        self.expect("00252=1=1=1", models[3].1, folder.join("00252=1=1=1.avi"));
        for (name, to) in [("up", ".."), ("here", "."), ("mpeg", "../mpeg"), ("again", "mpeg")] {
            symlink(to, folder.join(name)).unwrap();
        }
        symlink(self.elsewhere(), folder.join("outside")).unwrap();
        symlink("nothing.avi", folder.join("00252=2=2=2.avi")).unwrap();
        symlink("00252=3=3=3.avi", folder.join("00252=3=3=3.avi")).unwrap();
        self.odd.extend([
            ("links/outside", "it leads to another folder, `"),
            ("00252=2=2=2.avi", "cannot be read: No such file"),
            ("00252=3=3=3.avi", "cannot be read: Too many levels"),
        ]);
    }

    /// What the user may not read or list, or only read.
    fn lock_up(&mut self, models: &[(PathBuf, usize)]) {
        let folder = self.inbox().join("locked");
        let locks: Vec<(PathBuf, u32)> = vec![
            (folder.join("read-only"), 0o555),
            (folder.join("shut"), 0o000),
            (folder.join("unlisted"), 0o111),
            (folder.join("00253=4=4=4.avi"), 0o000),
            (folder.join("read-only/00253=1=1=1.avi"), 0o444),
        ];
        self.add(&folder.join("read-only"), "00253=1=1=1", &models[0]);
        self.add(&folder.join("unlisted/inside"), "00253=2=2=2", &models[0]);
        fs::create_dir(folder.join("shut")).unwrap();
        fs::copy(&models[0].0, folder.join("shut/00253=3=3=3.avi")).unwrap();
        fs::copy(&models[0].0, folder.join("00253=4=4=4.avi")).unwrap();
        // The way into a folder that cannot be listed.
        symlink("unlisted/inside", folder.join("inside")).unwrap();
        self.odd.extend([
            ("locked/shut", "cannot be listed: Permission denied"),
            ("locked/unlisted", "cannot be listed: Permission denied"),
            ("00253=4=4=4.avi", "cannot be read: Permission denied"),
        ]);
        fs::set_permissions(self.scratch.path(), Permissions::from_mode(0o755)).unwrap();
        if geteuid().is_root() {
            let owned = succeed(Command::new("find").arg(self.inbox()).args(["-print0"]));
            let owned = owned.split(|byte| *byte == 0).filter(|name| !name.is_empty());
            for path in owned.map(|name| self.inbox().join(OsStr::from_bytes(name))).chain([self.home()]) {
                lchown(&path, Some(NOBODY), Some(NOBODY)).unwrap();
            }
        }
        // Files before their folders.
        for (path, mode) in locks.into_iter().rev() {
            fs::set_permissions(path, Permissions::from_mode(mode)).unwrap();
        }
    }

    /// `dreams WORDS...` as a user without privileges.
    fn dreams(&self, words: &[&str]) -> Command {
        let ours = programs::dreams();
        for name in ["dreams", "dreams-video"] {
            let copy = self.bin().join(name);
            if !copy.exists() {
                programs::copy_program(&ours.with_file_name(name), &copy);
            }
        }
        let program = self.bin().join("dreams");
        let mut command = if geteuid().is_root() {
            let id = NOBODY.to_string();
            let mut setpriv = Command::new("setpriv");
            setpriv.args(["--reuid", &id, "--regid", &id, "--clear-groups"]).arg(program);
            setpriv
        } else {
            Command::new(program)
        };
        command.args(words).current_dir(self.scratch.path());
        command
    }
}

impl Drop for Archive {
    fn drop(&mut self) {
        // So that the folder can be removed.
        for folder in ["shut", "unlisted", "read-only"] {
            let _ = fs::set_permissions(self.inbox().join("locked").join(folder), Permissions::from_mode(0o755));
        }
    }
}

/// Makes a moving picture.
fn film(path: &Path, size: &str, rate: &str, frames: usize, settings: &str) {
    let source = format!("testsrc2=size={size}:rate={rate},boxblur=1");
    let mut ffmpeg = Command::new("ffmpeg");
    ffmpeg.args(["-v", "error", "-nostdin", "-y", "-f", "lavfi", "-i", &source, "-frames:v", &frames.to_string()]);
    succeed(ffmpeg.args(settings.split_whitespace()).arg(path));
}

/// The number of frames that ffmpeg plays.
fn count(path: &Path) -> usize {
    framemd5(path).len()
}

/// The bytes of the AVI at `path`, its first frame damaged.
fn scratched(path: &Path) -> Vec<u8> {
    let mut bytes = fs::read(path).unwrap();
    let frames = bytes.windows(4).position(|four| four == b"movi").unwrap();
    bytes[frames + 150..][..300].fill(0x55);
    bytes
}

/// The sources and reasons of what was left out.
fn left_out(answer: &Value) -> Vec<(String, String)> {
    let text = |value: &Value| value.as_str().unwrap().to_owned();
    answer["left_out"].as_array().unwrap().iter().map(|one| (text(&one["source"]), text(&one["reason"]))).collect()
}

/// Every odd file is named once, with its reason, and nothing else.
fn assert_named(archive: &Archive, named: &[(String, String)]) {
    let mut unexpected: Vec<_> = named.iter().collect();
    for (name, why) in &archive.odd {
        let found: Vec<_> = named.iter().filter(|(source, _)| source.ends_with(&format!("/{name}"))).collect();
        assert!(found.len() == 1 && found[0].1.starts_with(why), "{name}: {why}: {found:?} of {named:#?}");
        unexpected.retain(|other| *other != found[0]);
    }
    assert!(unexpected.is_empty(), "{unexpected:?}");
    assert!(named.iter().all(|(_, reason)| !reason.trim().is_empty() && !reason.trim().ends_with(':')), "{named:?}");
}

#[test]
fn of_an_archive_of_many_years_all_that_is_sound_comes_in_and_all_else_is_named() {
    let archive = Archive::make();
    assert!(archive.sound.len() >= 700, "{} sound clips", archive.sound.len());
    succeed(&mut archive.dreams(&["new", "home/flock", "--size", "64x64", "--fps", "30"]));
    let said = output(&mut archive.dreams(&["import", "home/flock", "content", "--fit", "pad", "--json"]));
    let error = String::from_utf8(said.stderr.clone()).expect("what is told is text");
    assert_eq!(said.status.code(), Some(1), "{error}");
    let answer = json(&said);
    assert_named(&archive, &left_out(&answer));
    let clips: BTreeMap<&str, &Value> =
        answer["clips"].as_array().unwrap().iter().map(|clip| (clip["clip"].as_str().unwrap(), clip)).collect();
    let missing: Vec<_> = archive.sound.keys().filter(|clip| !clips.contains_key(clip.as_str())).collect();
    assert!(missing.is_empty() && clips.len() == archive.sound.len(), "{missing:?}");
    for (at, (clip, (frames, source))) in archive.sound.iter().enumerate() {
        assert_eq!(clips[clip.as_str()]["frames"], *frames, "{clip} from `{}`", source.display());
        // ffmpeg counts some of them: `check` decodes all.
        let counted = at % 40 > 0 || count(&archive.flock().join(clip)) == *frames;
        assert!(counted, "{clip} from `{}`", source.display());
    }
    assert_eq!((&answer["tombstones"], &answer["links"]), (&1.into(), &4.into()));
    let faults = json(&output(&mut archive.dreams(&["check", "home/flock", "--json"])));
    let kinds: BTreeSet<_> = faults["faults"].as_array().unwrap().iter().map(|f| f["kind"].as_str().unwrap()).collect();
    assert!(!kinds.is_empty() && kinds.iter().all(|kind| OF_GRAPH.contains(kind)), "{kinds:?}");
    let flock = fs::read(archive.flock().join("flock.toml")).unwrap();
    succeed(&mut archive.dreams(&["prune", "home/flock", "--write"]));
    succeed(&mut archive.dreams(&["check", "home/flock"]));
    fs::write(archive.flock().join("flock.toml"), flock).unwrap();

    // The second time all is there; for people, no name reaches the terminal as it is.
    let again = output(&mut archive.dreams(&["import", "home/flock", "content", "--fit", "pad"]));
    let told = String::from_utf8([again.stdout, again.stderr].concat()).expect("what is told is text");
    assert!(!told.chars().any(|c| c.is_control() && c != '\n' || c == '\u{202e}'), "{told:?}");
    let lines = |start: &str| told.lines().filter(|line| line.starts_with(start)).count();
    assert!(lines("left out `") >= archive.odd.len() - 2, "{told}");
    assert!(told.contains(&format!("{} files passed over, in the flock already", archive.sound.len())), "{told}");
    assert!(!told.contains("encoded from"), "{told}");
}
