//! The status page of a running player, as a client reads it.
//!
//! Owns the requests, and the pixels of its picture.
//!
//! Start at [`ask`] and [`on_a_port`].

use crate::flocks::SMALL;
use crate::player_run::{PlayerRun, RunningPlayer};
use crate::programs::succeed;
use std::fs;
use std::io::{Read, Write};
use std::net::TcpListener;
use std::os::unix::net::UnixStream;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

/// An answer of the page: head and body.
pub struct Answer {
    pub head: String,
    pub body: Vec<u8>,
}

impl Answer {
    pub fn text(&self) -> String {
        String::from_utf8(self.body.clone()).unwrap()
    }
}

/// How long the page may take to answer.
pub const PATIENCE: Duration = Duration::from_mins(1);

/// Requests a page from `socket`, by HTTP 1.0, so that the body is not encoded.
pub fn ask(socket: &Path, request: &str) -> Answer {
    let mut stream = UnixStream::connect(socket).unwrap();
    stream.set_read_timeout(Some(PATIENCE)).unwrap();
    write!(stream, "{request} HTTP/1.0\r\nHost: unit\r\nConnection: close\r\n\r\n").unwrap();
    let mut all = Vec::new();
    stream.read_to_end(&mut all).expect("the page answers within a minute");
    let end = all.windows(4).position(|four| four == b"\r\n\r\n").expect("a head ends with an empty line");
    Answer { head: String::from_utf8(all[..end].to_vec()).unwrap().to_lowercase(), body: all[end + 4..].to_vec() }
}

/// A player that plays and serves its page at `address`.
pub fn serving(address: &str) -> (PlayerRun, RunningPlayer) {
    let flock = SMALL.flock();
    let playing = PlayerRun::of(&flock.folder).with(&["--screen", "virtual", "--seed", "1", "--status", address]);
    let mut running = playing.start();
    running.await_lines(40);
    (playing, running)
}

/// The same, on the socket returned.
pub fn on_a_socket() -> (PlayerRun, RunningPlayer, PathBuf) {
    let socket = tempfile::Builder::new().prefix("page").tempdir().unwrap().keep().join("socket");
    let (playing, running) = serving(&format!("unix:{}", socket.display()));
    (playing, running, socket)
}

/// The same, at the host and port returned.
pub fn on_a_port() -> (PlayerRun, RunningPlayer, String) {
    let port = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
    let address = format!("127.0.0.1:{port}");
    let (playing, running) = serving(&address);
    (playing, running, address)
}

/// The RGB bytes of a picture, as `ffmpeg` decodes it.
pub fn pixels(picture: &[u8], kind: &str) -> Vec<u8> {
    let file = tempfile::Builder::new().suffix(&format!(".{kind}")).tempfile().unwrap();
    fs::write(file.path(), picture).unwrap();
    let mut ffmpeg = Command::new("ffmpeg");
    ffmpeg.args(["-v", "error", "-nostdin", "-i"]).arg(file.path());
    ffmpeg.args(["-frames:v", "1", "-f", "rawvideo", "-pix_fmt", "rgb24", "-"]);
    succeed(&mut ffmpeg)
}
