//! What the player shows.
//!
//! Owns the question, one small request to the player's page on this machine, and how long the player may take to answer.
//! Whoever answers is our own player; what cannot be understood counts as no answer. Never decides what a press counts for.
//!
//! Start at [`ask`].

use serde::Deserialize;
use std::io::{self, Read, Write};
use std::net::{TcpStream, ToSocketAddrs};
use std::os::unix::net::UnixStream;
use std::time::Duration;
use votes::{Lit, Shows, Visit};

/// How long the player may take to accept, and for each part of its answer.
const PATIENCE: Duration = Duration::from_secs(1);
/// Bytes of an answer that are read, at most.
const LONGEST: u64 = 64 << 10;
/// The request, in a version of HTTP whose answers end with the connection.
const REQUEST: &[u8] = b"GET /glass.json HTTP/1.0\r\n\r\n";

/// The document of the player, as far as it is read.
#[derive(Debug, Deserialize)]
struct Document {
    glass: Option<Shown>,
    before: Option<Clip>,
}

#[derive(Debug, Deserialize)]
struct Shown {
    is_lit: bool,
    #[serde(flatten)]
    clip: Option<Clip>,
}

#[derive(Debug, Deserialize)]
struct Clip {
    sheep: Vec<String>,
    seed: u64,
    step: u64,
    since_ms: u64,
    lasts_ms: u64,
}

/// Asks the player at `address`, the `status` of its config. Returns the clips that are lit and were, the newest first;
/// none if it shows no sheep.
/// Errors: If it does not answer, or says what makes no sense.
pub(crate) fn ask(address: &str) -> io::Result<Vec<Lit>> {
    let answer = if let Some(path) = address.strip_prefix("unix:") {
        let stream = UnixStream::connect(path)?;
        stream.set_read_timeout(Some(PATIENCE))?;
        stream.set_write_timeout(Some(PATIENCE))?;
        asked(stream)
    } else {
        let place = address.to_socket_addrs()?.next().ok_or(io::ErrorKind::NotFound)?;
        let stream = TcpStream::connect_timeout(&place, PATIENCE)?;
        stream.set_read_timeout(Some(PATIENCE))?;
        stream.set_write_timeout(Some(PATIENCE))?;
        asked(stream)
    }?;
    let body = answer.windows(4).position(|four| four == b"\r\n\r\n").map(|end| &answer[end + 4..]);
    Ok(clips(serde_json::from_slice(body.unwrap_or_default())?))
}

/// The clips of `document`.
fn clips(document: Document) -> Vec<Lit> {
    let newest = document.glass.filter(|shown| shown.is_lit).and_then(|shown| lit(shown.clip?));
    let before = document.before.filter(|_| newest.is_some()).and_then(lit);
    newest.into_iter().chain(before).collect()
}

fn asked(mut stream: impl Read + Write) -> io::Result<Vec<u8>> {
    stream.write_all(REQUEST)?;
    let mut answer = Vec::new();
    stream.take(LONGEST).read_to_end(&mut answer)?;
    Ok(answer)
}

/// A clip with its visits: a transition is made before the step that it leads to.
fn lit(clip: Clip) -> Option<Lit> {
    let Clip { sheep, seed, step, since_ms, lasts_ms } = clip;
    let visit = |sheep, step| Visit { seed, step, sheep };
    let mut sheep = sheep.into_iter();
    let shows = match (sheep.next()?, sheep.next()) {
        (sheep, None) => Shows::Loop(visit(sheep, step)),
        (from, Some(to)) => Shows::Transition { from: visit(from, step), to: visit(to, step.checked_add(1)?) },
    };
    Some(Lit { shows, since_ms, lasts_ms })
}

#[cfg(test)]
mod tests {
    use super::{Document, clips};
    use votes::Lit;

    fn read(text: &str) -> Vec<Lit> {
        clips(serde_json::from_str::<Document>(text).unwrap())
    }

    #[test]
    fn what_the_player_says_becomes_the_clips_that_were_lit() {
        let clip = r#""sheep":["a","b"],"seed":7,"step":41,"since_ms":900,"lasts_ms":4000"#;
        let before = r#"{"sheep":["a"],"seed":7,"step":41,"since_ms":8900,"lasts_ms":8000}"#;
        let told = |is_lit: bool, clip: &str| {
            let shown = format!(r#"{{"clip":"a=b.mp4","frame":27,"frames":120,"is_lit":{is_lit},{clip}}}"#);
            read(&format!(r#"{{"glass":{shown},"before":{before}}}"#))
        };
        let lit = told(true, clip);
        let seen = |ago_ms| votes::seen(&lit, ago_ms).map(|visit| (visit.sheep.as_str(), visit.step));
        assert_eq!([seen(0), seen(900), seen(901)], [Some(("a", 41)); 3]);
        let later = told(true, &clip.replace("900", "2100"));
        assert_eq!(votes::seen(&later, 0).map(|visit| (visit.sheep.as_str(), visit.step)), Some(("b", 42)));
        assert_eq!(told(false, clip), [], "a dark screen shows nothing");
        assert_eq!(told(true, r#""more":1"#), [], "a fault card");
        assert_eq!(read(r#"{"glass":null,"before":null,"later":1}"#), []);
    }
}
