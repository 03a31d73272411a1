//! HTTP/1.1, as much of it as a page needs that can only be looked at.
//!
//! Owns what is understood of a request and how an answer is spelled: one request, one answer, and the connection is
//! over. Pure functions over bytes; `httparse` knows the grammar. Never touches a socket: `server.rs` does.
//!
//! # Source
//! RFC 9110 and RFC 9112; the refusals of an oversized head are RFC 6585's.

use httparse::{EMPTY_HEADER, Error, Request, Status};

/// The longest head that is read, in bytes. Browsers send some 700.
pub(crate) const LONGEST_HEAD: usize = 8192;

/// The most header lines that are read. Browsers send some 15.
const MOST_HEADERS: usize = 64;

/// Headers of every answer: no cache, no guessed type, nothing fetched from elsewhere, no page around it.
const ALWAYS: &str = "\
    Connection: close\r\n\
    Cache-Control: no-store\r\n\
    Content-Security-Policy: default-src 'none'; connect-src 'self'; img-src 'self' data:; \
        script-src 'unsafe-inline'; style-src 'unsafe-inline'; \
        base-uri 'none'; form-action 'none'; frame-ancestors 'none'\r\n\
    Cross-Origin-Resource-Policy: same-origin\r\n\
    Referrer-Policy: no-referrer\r\n\
    X-Content-Type-Options: nosniff\r\n";

/// An answer to a client.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Answer {
    /// The code and its words, as in `404 Not Found`.
    pub(crate) status: &'static str,
    /// The content type.
    pub(crate) kind: &'static str,
    pub(crate) body: Vec<u8>,
}

impl Answer {
    /// All is well.
    pub(crate) fn of(kind: &'static str, body: Vec<u8>) -> Self {
        Self { status: "200 OK", kind, body }
    }

    /// It is not to be had; `why` in a few words.
    pub(crate) fn refusal(status: &'static str, why: &str) -> Self {
        Self { status, kind: "text/plain; charset=utf-8", body: format!("{why}\n").into_bytes() }
    }

    /// The answer as it is sent.
    fn bytes(&self, with_body: bool) -> Vec<u8> {
        let Self { status, kind, body } = self;
        let allow = if status.starts_with("405") { "Allow: GET, HEAD\r\n" } else { "" };
        let length = body.len();
        let head =
            format!("HTTP/1.1 {status}\r\nContent-Type: {kind}\r\nContent-Length: {length}\r\n{allow}{ALWAYS}\r\n");
        let mut bytes = head.into_bytes();
        if with_body {
            bytes.extend_from_slice(body);
        }
        bytes
    }
}

/// The reply to a request of which `head` has arrived, or `None` while more of it is to come. `answer` is asked for
/// the path, without a query, of a request that may be answered: one to a host that `is_ours`. A request without a host
/// comes from no browser.
pub(crate) fn reply(head: &[u8], is_ours: impl Fn(&str) -> bool, answer: impl Fn(&str) -> Answer) -> Option<Vec<u8>> {
    let mut headers = [EMPTY_HEADER; MOST_HEADERS];
    let mut request = Request::new(&mut headers);
    let oversized = || Answer::refusal("431 Request Header Fields Too Large", "the request is too long");
    match request.parse(head) {
        Ok(Status::Complete(_)) => {}
        Ok(Status::Partial) if head.len() < LONGEST_HEAD => return None,
        Ok(Status::Partial) | Err(Error::TooManyHeaders) => return Some(oversized().bytes(true)),
        Err(_) => return Some(Answer::refusal("400 Bad Request", "this is no HTTP request").bytes(true)),
    }
    let mut hosts = request.headers.iter().filter(|header| header.name.eq_ignore_ascii_case("host"));
    if !hosts.all(|host| std::str::from_utf8(host.value).is_ok_and(|host| is_ours(host.trim()))) {
        return Some(Answer::refusal("421 Misdirected Request", "this page is of another machine").bytes(true));
    }
    let path = request.path.unwrap_or_default().split('?').next().unwrap_or_default();
    Some(match request.method {
        Some("GET") => answer(path).bytes(true),
        Some("HEAD") => answer(path).bytes(false),
        Some(_) | None => Answer::refusal("405 Method Not Allowed", "this page can only be read").bytes(true),
    })
}

#[cfg(test)]
mod tests {
    use super::{Answer, LONGEST_HEAD, reply};
    use proptest::collection::vec;
    use proptest::prelude::{any, proptest};

    /// The reply to a whole request, from a page that says its path.
    fn said(request: &[u8]) -> String {
        let echo = |path: &str| Answer::of("text/plain", path.as_bytes().to_vec());
        String::from_utf8(reply(request, |host| host == "unit", echo).expect("the request is whole")).unwrap()
    }

    #[test]
    fn get_is_answered_with_the_page_and_head_with_its_length_only() {
        let get = said(b"GET /status.json?now HTTP/1.1\r\nHost: unit\r\n\r\n");
        assert!(get.starts_with("HTTP/1.1 200 OK\r\n") && get.ends_with("\r\n\r\n/status.json"), "{get}");
        let head = said(b"HEAD /status.json HTTP/1.0\r\n\r\n");
        assert_eq!(head, get.strip_suffix("/status.json").unwrap());
        assert!(head.contains("\r\nContent-Length: 12\r\n"), "{head}");
        for header in ["Connection: close", "Cache-Control: no-store", "X-Content-Type-Options: nosniff"] {
            assert!(head.contains(&format!("\r\n{header}\r\n")), "`{header}` is missing: {head}");
        }
    }

    #[test]
    fn a_request_is_waited_for_until_its_empty_line() {
        let request = b"GET / HTTP/1.1\r\nHost: unit\r\n\r\n";
        for end in 0..request.len() {
            assert_eq!(reply(&request[..end], |_| true, |_| unreachable!()), None, "{end} bytes");
        }
    }

    #[test]
    fn what_is_no_request_to_look_is_refused() {
        let many = format!("GET / HTTP/1.1\r\n{}\r\n", "a: b\r\n".repeat(65));
        let long = format!("GET / HTTP/1.1\r\na: {}", "b".repeat(LONGEST_HEAD - 19));
        assert_eq!(long.len(), LONGEST_HEAD);
        for (request, status) in [
            (b"\x16\x03\x01\x02\x00".as_slice(), "400 Bad Request"),
            (b"GET / HTTP/9.9\r\n\r\n", "400 Bad Request"),
            (b"POST / HTTP/1.1\r\n\r\n", "405 Method Not Allowed"),
            (b"GET / HTTP/1.1\r\nHost: example.org\r\n\r\n", "421 Misdirected Request"),
            (b"GET / HTTP/1.1\r\nHost: unit\r\nHOST: example.org\r\n\r\n", "421 Misdirected Request"),
            (b"GET / HTTP/1.1\r\nHost: \xff\r\n\r\n", "421 Misdirected Request"),
            (many.as_bytes(), "431 Request Header Fields Too Large"),
            (long.as_bytes(), "431 Request Header Fields Too Large"),
        ] {
            let said = said(request);
            assert!(said.starts_with(&format!("HTTP/1.1 {status}\r\n")), "{said}");
        }
    }

    proptest! {
        #[test]
        fn no_bytes_whatever_break_the_page(head in vec(any::<u8>(), 0..300)) {
            reply(&head, |_| true, |_| Answer::of("text/plain", Vec::new()));
        }
    }
}
