//! Many strangers at once do not shut the artist out.

use std::io::{ErrorKind, Read, Write};
use std::net::TcpStream;

use super::{CLOSE, SOON, Studio};
use crate::connections::MOST_OF_STRANGERS;

/// Sends each of `texts` on a connection of its own, and keeps all of them open.
fn crowd(studio: &Studio, texts: impl IntoIterator<Item = String>) -> Vec<TcpStream> {
    let connect = |text: String| {
        let mut stream = TcpStream::connect(("127.0.0.1", studio.port)).unwrap();
        // The server may have closed it already, which is its right.
        let _ = stream.write_all(text.as_bytes());
        stream
    };
    texts.into_iter().map(connect).collect()
}

/// A post whose body does not come.
fn slow_post(studio: &Studio, path: &str) -> String {
    let host = studio.host();
    format!(
        "POST {path} HTTP/1.1\r\nHost: {host}\r\nOrigin: http://{host}\r\nContent-Type: application/json\r\n\
         Content-Length: 900\r\n\r\n{{"
    )
}

/// The whole way of a page that is opened and used, each question on a connection of its own.
fn assert_a_page_is_answered_soon(studio: &Studio) {
    let token = &studio.fence.secrets.token;
    let begin = studio.request("POST", "/session", &format!("{{\"token\":\"{token}\"}}"));
    let way = [
        studio.request("GET", "/", "").with("Cookie", None).with("X-Studio-Secret", None),
        studio.request("GET", "/app/app.js", "").with("Cookie", None).with("X-Studio-Secret", None),
        begin.with("Cookie", None).with("X-Studio-Secret", None),
        studio.request("GET", "/api/state", ""),
        studio.request("POST", "/api/edits", "{}"),
    ];
    for request in way {
        let answer = studio.ask(&request);
        assert_eq!(answer.status, 200, "{}: {}", request.path, answer.head);
    }
}

#[test]
fn three_hundred_half_sent_heads_do_not_shut_the_artist_out() {
    let studio = Studio::start();
    let mut page = crowd(&studio, [String::new()]).remove(0);
    let headers = studio.request("GET", "/api/state", "").headers;
    let head: String = headers.iter().flat_map(|(name, value)| [name, ": ", value, "\r\n"]).collect();
    let text = format!("GET /api/state HTTP/1.1\r\n{head}\r\n");
    let mut part = [0; 4096];
    page.set_read_timeout(Some(SOON)).unwrap();
    page.write_all(text.as_bytes()).unwrap();
    assert!(page.read(&mut part).unwrap() > 0);
    let heads = (0..300).map(|_| format!("GET / HTTP/1.1\r\nHost: {}\r\n", studio.host()));
    let mut held = crowd(&studio, heads);
    assert_a_page_is_answered_soon(&studio);
    // Those that were silent for the longest have made room.
    for silent in &mut held[..300 - MOST_OF_STRANGERS] {
        silent.set_read_timeout(Some(SOON)).unwrap();
        let read = silent.read(&mut part);
        assert!(!read.as_ref().is_err_and(|error| error.kind() == ErrorKind::WouldBlock), "{read:?}");
    }
    // The page that was open before has kept its connection.
    page.write_all(text.as_bytes()).unwrap();
    assert!(page.read(&mut part).is_ok_and(|bytes| part[..bytes].starts_with(b"HTTP/1.1 200")));
}

#[test]
fn seventy_slow_posts_without_a_secret_do_not_shut_the_artist_out() {
    let studio = Studio::start();
    let posts: Vec<String> = (0..70).map(|_| slow_post(&studio, "/session")).collect();
    let _held = crowd(&studio, posts.clone());
    let _refused = crowd(&studio, (0..70).map(|_| slow_post(&studio, "/api/edits")));
    assert_a_page_is_answered_soon(&studio);
    // Nor do more of them than there are places.
    let _more = crowd(&studio, posts.iter().cycle().take(280).cloned());
    assert_a_page_is_answered_soon(&studio);
}

#[test]
fn a_token_that_is_longer_than_any_is_refused() {
    let studio = Studio::start();
    let body = format!("{{\"token\":\"{}\"}}", "0".repeat(2000));
    let post = slow_post(&studio, "/session").replace("Content-Length: 900\r\n\r\n{", "");
    let answer = studio.send(&format!("{post}{CLOSE}Content-Length: {}\r\n\r\n{body}", body.len()));
    assert_eq!(answer.status, 413, "{answer:?}");
}
