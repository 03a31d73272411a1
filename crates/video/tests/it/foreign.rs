//! Other people's videos come in frame by frame, as ffmpeg shows them.
//!
//! Owns the claims on what is read and what is refused. Never encodes: `encoding.rs` does.

use crate::clips::{framemd5, hex, made};
use md5::{Digest, Md5};
use std::path::Path;
use std::process::Command;
use timing::FrameCount;
use video::{ForeignError, ForeignVideo};

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
            picture.as_yuv420p().expect("it is a flock's").planes().iter().for_each(|plane| md5.update(plane));
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
    ]
    .into_iter()
    .enumerate()
    {
        let name = format!("{at}.nut");
        let smooth = format!("{},boxblur=4", source(size));
        let path = made(folder.path(), &name, &smooth, 3, &format!("-strict -2 -c:v {codec} -pix_fmt {format}"));
        let pictures = match read(&path) {
            Err((0, ForeignError::Pixels { found })) => {
                assert_eq!(found, format, "refused by its name");
                continue;
            }
            read => read.unwrap_or_else(|error| panic!("{format}: {error:?}")),
        };
        let found: Vec<f32> = pictures.iter().flat_map(video::ForeignPicture::to_rgb).collect();
        let due = rgb_of(&path, matrix);
        assert_eq!(found.len(), due.len(), "{format}");
        let off = |(found, due): (&f32, &u8)| f64::from(found.clamp(0.0, 1.0) * 255.0 - f32::from(*due)).powi(2);
        let mean = found.iter().zip(&due).map(off).sum::<f64>() / due.len() as f64;
        let psnr = 10.0 * (255.0 * 255.0 / mean.max(1e-9)).log10();
        assert!(psnr > 40.0, "{codec} {format} {size}: {psnr:.1} dB");
    }
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
    assert!(matches!(ForeignVideo::open(&at("text.avi")), Err(ForeignError::NotAVideo { .. })));
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
