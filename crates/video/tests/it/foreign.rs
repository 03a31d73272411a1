//! Other people's videos come in frame by frame, as ffmpeg shows them.
//!
//! Owns the claims on what is read and what is refused. Never encodes: `encoding.rs` does.

use crate::clips::{framemd5, hex, made};
use md5::{Digest, Md5};
use std::ffi::OsStr;
use std::os::unix::ffi::OsStrExt;
use std::path::Path;
use std::process::Command;
use timing::FrameCount;
use video::{ForeignError, ForeignVideo, Matrix, MatrixRule};

const FRAMES: u32 = 24;

/// Every picture of the video, or why it is refused, and how many came before.
fn read(path: &Path) -> Result<Vec<video::ForeignPicture>, (usize, ForeignError)> {
    let mut foreign = ForeignVideo::open(path).map_err(|error| (0, error))?;
    let mut pictures = Vec::new();
    loop {
        match foreign.picture() {
            Ok(Some(picture)) => pictures.push(picture),
            Ok(None) => return Ok(pictures),
            Err(error) => return Err((pictures.len(), error)),
        }
    }
}

fn source(size: &str) -> String {
    format!("testsrc2=size={size}:rate=24000/1001")
}

/// The video as ffmpeg's own scaler turns it into RGB: `[frame][height][width][3]` of 8 bits.
fn rgb_of(path: &Path, matrix: &str) -> Vec<u8> {
    let filter = format!("scale=in_color_matrix={matrix}:flags=bilinear+accurate_rnd+full_chroma_int,format=rgb24");
    let mut ffmpeg = Command::new("ffmpeg");
    ffmpeg.args(["-v", "error", "-i"]).arg(path).args([
        "-vf",
        &filter,
        "-fps_mode",
        "passthrough",
        "-f",
        "rawvideo",
        "-",
    ]);
    ffmpeg.output().expect("the tests need the `ffmpeg` command").stdout
}

/// How near a picture comes to ffmpeg's of the same size, in dB.
fn psnr(found: &[f32], due: &[u8]) -> f64 {
    assert_eq!(found.len(), due.len());
    let off = |(found, due): (&f32, &u8)| f64::from(found.clamp(0.0, 1.0) * 255.0 - f32::from(*due)).powi(2);
    let mean = found.iter().zip(due).map(off).sum::<f64>() / due.len() as f64;
    10.0 * (255.0 * 255.0 / mean.max(1e-9)).log10()
}

#[test]
fn samples_that_a_flock_has_already_are_taken_bit_by_bit() {
    let folder = tempfile::tempdir().unwrap();
    let tags = "-pix_fmt yuv420p -colorspace bt709 -color_primaries bt709 -color_trc bt709 -color_range tv";
    for (name, codec) in [("a.mkv", "-c:v ffv1"), ("b.avi", "-c:v mpeg4 -bf 2 -q:v 4"), ("c.mp4", "-c:v libx264 -bf 3")]
    {
        // What an AVI cannot tell is told by size.
        let size = if name == "b.avi" { "1280x96" } else { "96x64" };
        let path = made(folder.path(), name, &source(size), FRAMES, &format!("{codec} {tags}"));
        let digest = |picture: &video::ForeignPicture| {
            let mut md5 = Md5::new();
            picture.to_yuv420p().expect("it is a flock's").planes().iter().for_each(|plane| md5.update(plane));
            hex(md5)
        };
        let found: Vec<String> = read(&path).unwrap().iter().map(digest).collect();
        assert_eq!(found, framemd5(&path), "{name}");
        assert_eq!(found.len(), FRAMES as usize);
    }
}

#[test]
fn other_pixels_and_colours_come_out_as_ffmpeg_shows_them() {
    let folder = tempfile::tempdir().unwrap();
    for (at, (codec, format, size, matrix)) in [
        ("ffv1", "yuv420p", "100x62", "bt601"),
        ("ffv1", "yuv422p", "101x63", "bt601"),
        ("ffv1", "yuv444p10le", "98x62", "bt601"),
        ("ffv1", "yuv420p", "1280x32", "bt709"),
        ("mjpeg", "yuvj420p", "96x64", "bt601"),
        ("ffv1", "gray", "96x64", "bt601"),
        ("ffv1", "bgr0", "96x64", "bt601"),
        ("utvideo", "gbrp", "96x64", "bt601"),
        ("rawvideo", "nv12", "96x64", "bt601"),
        ("rawvideo", "uyvy422", "96x64", "bt601"),
        ("rawvideo", "rgb48le", "96x64", "bt601"),
        ("rawvideo", "yuv422p16be", "96x64", "bt601"),
        ("rawvideo", "p010le", "96x64", "bt601"),
        ("rawvideo", "rgb565le", "96x64", "bt601"),
    ]
    .into_iter()
    .enumerate()
    {
        let name = format!("{at}.nut");
        let smooth = format!("{},boxblur=4", source(size));
        let path = made(folder.path(), &name, &smooth, 3, &format!("-strict -2 -c:v {codec} -pix_fmt {format}"));
        let pictures = read(&path).unwrap_or_else(|error| panic!("{format}: {error:?}"));
        let found: Vec<f32> = pictures.iter().flat_map(video::ForeignPicture::to_rgb).collect();
        let due = rgb_of(&path, matrix);
        let psnr = psnr(&found, &due);
        let least = if format == "rgb565le" { 30.0 } else { 40.0 };
        assert!(psnr > least, "{codec} {format} {size}: {psnr:.1} dB");
    }
}

/// Writes `matrix` over the display matrix of the first track of an MP4, in units of its own scale.
fn turn(path: &Path, matrix: [i32; 4]) {
    let mut bytes = std::fs::read(path).unwrap();
    // ISO/IEC 14496-12, 8.3.2: `tkhd` of version 0 has its matrix 44 bytes after its name.
    let start = bytes.windows(4).position(|name| name == b"tkhd").expect("it is an MP4") + 44;
    let [a, b, c, d] = matrix;
    for (at, number) in [a, b, 0, c, d].into_iter().enumerate() {
        bytes[start + 4 * at..][..4].copy_from_slice(&(number << 16).to_be_bytes());
    }
    std::fs::write(path, bytes).unwrap();
}

#[test]
fn pictures_that_a_container_turns_or_mirrors_come_in_as_seen() {
    let folder = tempfile::tempdir().unwrap();
    let smooth = format!("{},boxblur=4,setsar=4/3", source("96x64"));
    let path = made(folder.path(), "a.mp4", &smooth, 2, "-c:v mpeg4 -q:v 2 -pix_fmt yuv420p");
    for (matrix, size, pixel) in [
        ([1, 0, 0, 1], (96, 64), (4, 3)),
        ([0, 1, -1, 0], (64, 96), (3, 4)),
        ([-1, 0, 0, -1], (96, 64), (4, 3)),
        ([0, -1, 1, 0], (64, 96), (3, 4)),
        ([-1, 0, 0, 1], (96, 64), (4, 3)),
        ([1, 0, 0, -1], (96, 64), (4, 3)),
        ([0, 1, 1, 0], (64, 96), (3, 4)),
        ([0, -1, -1, 0], (64, 96), (3, 4)),
    ] {
        turn(&path, matrix);
        let foreign = ForeignVideo::open(&path).unwrap();
        assert_eq!((foreign.info().size, foreign.info().pixel), (size, pixel), "{matrix:?}");
        assert_eq!(foreign.info().stored_size(), (96, 64), "{matrix:?}");
        let pictures = read(&path).unwrap();
        assert_eq!(pictures[0].size(), size, "{matrix:?}");
        assert!(pictures[0].to_yuv420p().is_none_or(|picture| picture.size() == size), "{matrix:?}");
        let found: Vec<f32> = pictures.iter().flat_map(video::ForeignPicture::to_rgb).collect();
        let decibels = psnr(&found, &rgb_of(&path, "bt601"));
        // ffmpeg turns the samples and takes their chroma for sited as before.
        assert!(decibels > 34.0, "{matrix:?}: {decibels:.1} dB");
    }
    turn(&path, [1, 1, -1, 1]);
    let refused = ForeignVideo::open(&path).map(drop).unwrap_err();
    assert!(matches!(refused, ForeignError::Orientation { .. }) && refused.to_string().contains("45.0"), "{refused}");
}

#[test]
fn a_picture_stored_from_the_bottom_up_comes_in_upright() {
    let folder = tempfile::tempdir().unwrap();
    let path = made(folder.path(), "a.avi", &source("96x64"), 2, "-c:v rawvideo -pix_fmt bgr24");
    let found = read(&path).unwrap()[0].to_rgb();
    let due = rgb_of(&path, "bt601");
    let off = found.iter().zip(&due).map(|(found, due)| (found * 255.0 - f32::from(*due)).abs()).fold(0.0, f32::max);
    assert!(off < 0.5, "{off}");
}

#[test]
fn colours_are_read_by_the_file_by_the_rule_for_untagged_ones_or_by_the_one_for_all() {
    let folder = tempfile::tempdir().unwrap();
    let green = "color=c=0x20C040:size=96x64:rate=25,format=rgb24,scale=out_color_matrix=bt601,format=yuv420p";
    let untagged = made(folder.path(), "a.avi", green, 2, "-c:v ffv1");
    let tagged = made(folder.path(), "b.mkv", green, 2, "-c:v ffv1 -colorspace smpte170m");
    let rules = [MatrixRule::Untagged(Matrix::Bt601), MatrixRule::Untagged(Matrix::Bt709)];
    let rules = rules.into_iter().chain([Matrix::Bt601, Matrix::Bt709].map(MatrixRule::Always));
    for (rule, right) in rules.zip([[true, true], [false, true], [true, true], [false, false]]) {
        for (path, right) in [&untagged, &tagged].into_iter().zip(right) {
            let mut foreign = ForeignVideo::open(path).unwrap().with_matrix(rule);
            let picture = foreign.picture().unwrap().unwrap();
            let rgb = picture.to_yuv420p().unwrap().to_rgb8();
            let off = rgb[..3].iter().zip([32u8, 192, 64]).map(|(found, due)| found.abs_diff(due)).max().unwrap();
            assert_eq!(off <= 2, right, "{rule:?} of `{}`: {:?}", path.display(), &rgb[..3]);
        }
    }
    assert_eq!(ForeignVideo::open(&untagged).unwrap().info().matrix, None);
    assert_eq!(ForeignVideo::open(&tagged).unwrap().info().matrix, Some("smpte170m"));
}

#[test]
fn edit_lists_and_open_groups_come_in_as_ffmpeg_plays_them() {
    let folder = tempfile::tempdir().unwrap();
    let groups = "-g 8 -bf 3 -b_strategy 0 -colorspace bt709 -color_range tv";
    let x264 = "-x264-params open-gop=1:keyint=8:min-keyint=8:scenecut=0:b-adapt=0";
    let mut differ = 0;
    for (codec, endings) in [
        (format!("-c:v libx264 {groups} {x264}"), &["mp4", "mkv"][..]),
        (format!("-c:v libx264 {groups} {x264}:b-adapt=1"), &["mp4", "mkv"]),
        (format!("-c:v mpeg2video -q:v 3 {groups}"), &["mp4", "mkv", "m2v", "mpg", "ts"]),
        (format!("-c:v mpeg4 -q:v 3 {groups}"), &["mp4", "mkv"]),
    ] {
        let whole = made(folder.path(), "whole.mp4", &source("96x64"), 30, &codec);
        for (start, more) in [("0.5", &[][..]), ("0.5", &["-avoid_negative_ts", "make_zero"]), ("0.7", &[])] {
            for ending in endings {
                let path = folder.path().join(format!("cut.{ending}"));
                let mut cut = Command::new("ffmpeg");
                cut.args(["-v", "error", "-y", "-ss", start, "-i"]).arg(&whole).args(["-c", "copy"]).args(more);
                assert!(cut.arg(&path).status().unwrap().success(), "{codec} to {ending}");
                let due = played(&path);
                differ += usize::from(due.len() < 30);
                let rule = MatrixRule::Always(Matrix::Bt709);
                let mut foreign = ForeignVideo::open(&path).unwrap().with_matrix(rule);
                let mut found = Vec::new();
                while let Some(picture) = foreign.picture().unwrap_or_else(|error| panic!("{codec} {ending}: {error}"))
                {
                    let mut md5 = Md5::new();
                    picture.to_yuv420p().unwrap().planes().iter().for_each(|plane| md5.update(plane));
                    found.push(hex(md5));
                }
                assert!(
                    !due.is_empty() && found == due,
                    "{codec} from {start} to {ending}: {} {}",
                    found.len(),
                    due.len()
                );
            }
        }
    }
    assert!(differ > 10, "the cuts hide frames");
}

/// The MD5 of every frame that ffmpeg plays.
fn played(path: &Path) -> Vec<String> {
    let mut ffmpeg = Command::new("ffmpeg");
    ffmpeg.args(["-v", "quiet", "-threads", "1", "-i"]).arg(path);
    let said = ffmpeg.args(["-an", "-fps_mode", "passthrough", "-f", "framemd5", "-"]).output().unwrap();
    let text = String::from_utf8(said.stdout).unwrap();
    let hashes = text.lines().filter(|line| !line.starts_with('#'));
    hashes.map(|line| line.rsplit(',').next().unwrap().trim().to_owned()).collect()
}

#[test]
fn a_name_of_any_bytes_is_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = made(folder.path(), "a.m2v", &source("96x64"), 5, "-c:v mpeg2video");
    let other = folder.path().join(OsStr::from_bytes(b"caf\xe9\n \xff.m2v"));
    std::fs::rename(path, &other).unwrap();
    assert_eq!(read(&other).unwrap().len(), 5);
}

#[test]
fn what_is_damaged_is_refused_and_told_where() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    for (name, settings) in [
        ("a.avi", "-c:v mpeg4 -q:v 3"),
        ("b.mp4", "-c:v libx264 -movflags +faststart"),
        ("c.mkv", "-c:v libx264"),
        ("d.mpg", "-c:v mpeg2video -q:v 3"),
        ("e.ts", "-c:v mpeg2video -q:v 3"),
        ("f.ogv", "-c:v libtheora -q:v 9"),
        ("g.wmv", "-c:v wmv2 -q:v 3"),
    ] {
        let path = made(folder.path(), name, "testsrc2=size=192x128:rate=25,noise=alls=30:allf=t", FRAMES, settings);
        assert_eq!(read(&path).unwrap().len(), FRAMES as usize, "{name} is fine");
        let whole = std::fs::read(&path).unwrap();
        std::fs::write(at("cut"), &whole[..whole.len() * 2 / 3]).unwrap();
        let (frames, error) = read(&at("cut")).err().unwrap_or_else(|| panic!("{name} cut short is read"));
        assert!(frames < FRAMES as usize, "{name}: {error}");
        let mut scratched = whole.clone();
        for scratch in 1..10 {
            scratched[whole.len() * scratch / 10..][..500].fill(0x55);
        }
        std::fs::write(at("scratched"), scratched).unwrap();
        assert!(read(&at("scratched")).is_err(), "{name} with a scratch is read");
    }
    std::fs::write(at("empty.avi"), "").unwrap();
    assert!(matches!(ForeignVideo::open(&at("empty.avi")), Err(ForeignError::Empty)));
    std::fs::write(at("text.avi"), "not a video at all, but long enough to be looked at twice").unwrap();
    assert!(
        matches!(ForeignVideo::open(&at("text.avi")), Err(ForeignError::NotAVideo { reason }) if !reason.is_empty())
    );
    assert!(matches!(ForeignVideo::open(folder.path()), Err(ForeignError::NotAFile)));
    assert!(matches!(ForeignVideo::open(&at("none.avi")), Err(ForeignError::Open { .. })));
}

#[test]
fn a_list_of_other_files_is_no_video() {
    let folder = tempfile::tempdir().unwrap();
    made(folder.path(), "a.mp4", &source("96x64"), 3, "-c:v libx264");
    for (name, text) in [("l.avi", "ffconcat version 1.0\nfile a.mp4\n"), ("m.avi", "#EXTM3U\n#EXTINF:1,\na.mp4\n")] {
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        assert!(matches!(ForeignVideo::open(&path), Err(ForeignError::NotAVideo { .. })), "{name}");
    }
}

#[test]
fn a_video_tells_of_itself_what_its_header_has() {
    let folder = tempfile::tempdir().unwrap();
    let tags = "-metadata title=Aurora -metadata copyright=CC-BY-4.0 -metadata artist=Scott";
    for name in ["a.avi", "b.mp4", "c.mkv"] {
        let settings = format!("-c:v mpeg4 {tags}");
        let path = made(folder.path(), name, &source("96x64"), FRAMES, &settings);
        let foreign = ForeignVideo::open(&path).unwrap();
        let info = foreign.info();
        assert_eq!((info.codec.as_str(), info.size, info.pixel), ("mpeg4", (96, 64), (1, 1)), "{name}");
        let fps = info.fps.unwrap();
        assert!((f64::from(fps.num()) / f64::from(fps.den()) - 23.976).abs() < 0.01, "{name}: {fps}");
        assert!(info.frames.is_none_or(|frames| frames == FrameCount(FRAMES)), "{name}");
        let told = |key: &str| {
            info.tags.iter().find(|(found, _)| found.eq_ignore_ascii_case(key)).map(|(_, value)| &value[..])
        };
        assert_eq!(
            [told("title"), told("copyright"), told("artist")],
            [Some("Aurora"), Some("CC-BY-4.0"), Some("Scott")]
        );
        assert_eq!(info.tags.len(), 3, "{name}: {:?}", info.tags);
    }
}
