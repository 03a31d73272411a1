//! Test clips in the flock's form, made by the `ffmpeg` program, and the frames that it decodes from them.
//!
//! Owns the encoder settings and the hashes of frames. Never uses the project's own decoder or encoder, so that
//! `ffmpeg` is an independent reference.
//!
//! Start at [`Encode::make`] and [`framemd5`].

use crate::programs::succeed;
use std::path::Path;
use std::process::Command;

/// The pictures of a test clip, and how it is encoded.
#[derive(Clone, Copy, Debug, Hash)]
pub struct Encode {
    /// Width and height in pixels.
    pub size: (u32, u32),
    /// Frames per second, numerator and denominator.
    pub fps: (u32, u32),
    /// The number of frames.
    pub frames: u32,
    /// Chooses the pictures and one of [`SETTINGS`]; two numbers have no frame in common.
    pub number: usize,
}

/// Encoder settings, taken in turn: all are H.264 High with a closed GOP, and each differs from the next.
pub const SETTINGS: [(&str, &str); 6] = [
    ("veryfast", "bframes=3:ref=2:cabac=1:crf=23"),
    ("ultrafast", "bframes=0:ref=1:cabac=0:8x8dct=1:crf=30"),
    ("medium", "bframes=2:ref=5:b-pyramid=strict:weightp=2:crf=20"),
    ("fast", "bframes=1:ref=3:slices=4:crf=28:keyint=5"),
    ("superfast", "bframes=4:b-adapt=0:ref=4:8x8dct=1:threads=2:sliced-threads=1:crf=34"),
    ("faster", "bframes=0:ref=2:cabac=1:intra-refresh=0:qp=26"),
];

/// Options of ffmpeg's output that tag it as BT.709 limited range.
pub const TAGS: [&str; 8] =
    ["-colorspace", "bt709", "-color_primaries", "bt709", "-color_trc", "bt709", "-color_range", "tv"];
/// The filter that tags pictures so: ffmpeg 7 takes primaries and transfer from the pictures, not from those options.
pub const SETPARAMS: &str = "setparams=range=tv:color_primaries=bt709:color_trc=bt709:colorspace=bt709";

impl Encode {
    /// Makes the clip at `path`.
    pub fn make(self, path: &Path) {
        let (preset, x264) = SETTINGS[self.number % SETTINGS.len()];
        let mut ffmpeg = self.source();
        ffmpeg.args(["-c:v", "libx264", "-profile:v", "high", "-preset", preset, "-bsf:v", "dump_extra=freq=keyframe"]);
        ffmpeg.args(["-x264-params", &format!("open-gop=0:scenecut=0:{x264}")]);
        succeed(ffmpeg.arg(path));
    }

    /// The same pictures in another codec, which a flock does not accept.
    pub fn make_as(self, codec: &str, path: &Path) {
        succeed(self.source().args(["-c:v", codec]).arg(path));
    }

    /// `ffmpeg` with the raw pictures of this clip as its input, tagged as BT.709 limited range.
    fn source(self) -> Command {
        let ((width, height), (num, den), turn) = (self.size, self.fps, self.number * 47);
        let picture = format!("testsrc2=size={width}x{height}:rate={num}/{den},hue=h={turn},format=yuv420p");
        let mut ffmpeg = Command::new("ffmpeg");
        ffmpeg.args(["-v", "error", "-nostdin", "-y", "-f", "lavfi", "-i", &picture]);
        ffmpeg.args(["-frames:v", &self.frames.to_string(), "-movflags", "+faststart"]);
        ffmpeg.args(["-vf", SETPARAMS]).args(TAGS);
        ffmpeg
    }
}

/// The MD5 of every frame of `clip`, in order, as `ffmpeg -f framemd5` lists them.
pub fn framemd5(clip: &Path) -> Vec<String> {
    let mut ffmpeg = Command::new("ffmpeg");
    ffmpeg.args(["-v", "error", "-nostdin", "-i"]).arg(clip);
    ffmpeg.args(["-an", "-pix_fmt", "yuv420p", "-fps_mode", "passthrough", "-f", "framemd5", "-"]);
    let list = String::from_utf8(succeed(&mut ffmpeg)).unwrap();
    let digest = |line: &str| line.rsplit(',').next().map(|md5| md5.trim().to_owned());
    list.lines().filter(|line| !line.starts_with('#')).filter_map(digest).collect()
}
