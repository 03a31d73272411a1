//! A bundle on a web server: any server of static files will do.
//!
//! Owns the requests, one for each file, and the checks of the answers: a login page of a hotel is no bundle, a part must
//! be the part that was asked for, or the file is asked for whole, and a server that does not answer, or too slowly, is
//! given up. Object stores answer 403 for what they do not have: that is no file, unless they give none at all. The
//! signature of the content is checked by the reader; so TLS, in `tls.rs`, is for privacy alone.
//!
//! Start at [`HttpSource::new`].

use crate::fatal::Fatal;
use crate::meter::{Meter, MeteredReader};
use crate::network_error::{PlainReader, of_request};
use crate::tls::{Judgement, Tls};
use bundle::{ObjectId, Source};
use std::cell::Cell;
use std::io::{self, Cursor, ErrorKind, Read};
use std::time::Duration;
use ureq::http::{Response, header};
use ureq::unversioned::resolver::DefaultResolver;
use ureq::unversioned::transport::{ConnectProxyConnector, Connector, TcpConnector};
use ureq::{Agent, Body, Proxy};

/// How long until a name is found, and a server answers.
const CONNECT: Duration = Duration::from_secs(15);
/// How long a server may say nothing.
const SILENCE: Duration = Duration::from_secs(30);
/// How long anything small may take as a whole.
pub(crate) const SMALL: Duration = Duration::from_mins(5);
/// The media types of web pages.
const PAGES: [&str; 2] = ["text/html", "application/xhtml+xml"];
/// The first bytes of a small file by which a web page is known that says nothing of itself.
const HEAD: u64 = 64;
const PORTAL: &str = "the server sent a web page instead of a bundle: is there a login portal on this network?";
const COMPRESSED: &str =
    "the server sent a compressed answer, which was not asked for: is there a login portal on this network?";
/// Redirects in a row.
const REDIRECTS: u32 = 5;

/// A web server.
#[derive(Debug)]
pub(crate) struct HttpSource {
    agent: Agent,
    /// Ends in no `/`.
    url: String,
    meter: Meter,
    /// Whether it has given a file, and whether it has answered 403.
    has_given: Cell<bool>,
    has_refused: Cell<bool>,
}

impl HttpSource {
    /// The bundles beneath `url`, asked for through `proxy`, from a server that is accepted by `judgement`.
    /// Errors: [`Fatal::Address`] if one of them is no address.
    pub(crate) fn new(url: &str, proxy: Option<&str>, judgement: Judgement) -> Result<Self, Fatal> {
        let agent = agent(url, proxy, judgement)?;
        let url = url.trim_end_matches('/').to_owned();
        Ok(Self { agent, url, meter: Meter::default(), has_given: Cell::default(), has_refused: Cell::default() })
    }

    /// Whether it has answered 403 to something, and has given nothing.
    pub(crate) fn is_shut(&self) -> bool {
        self.has_refused.get() && !self.has_given.get()
    }

    /// Asks for the file at `path`, from byte `from` on, in at most `within` if that is set.
    fn get(&self, path: &str, from: u64, within: Option<Duration>) -> io::Result<Response<Body>> {
        self.meter.check()?;
        let mut request = self.agent.get(format!("{}/{path}", self.url)).config().timeout_global(within).build();
        if from > 0 {
            request = request.header(header::RANGE, format!("bytes={from}-"));
        }
        let response = request.call().map_err(of_request)?;
        match response.status().as_u16() {
            200 | 206 => {}
            404 | 410 => return Err(io::Error::new(ErrorKind::NotFound, "the server has no such file")),
            403 => {
                self.has_refused.set(true);
                let error = "the server has no such file, or gives it to nobody: it answers 403";
                return Err(io::Error::new(ErrorKind::NotFound, error));
            }
            status => return Err(io::Error::other(format!("the server answers {status}"))),
        }
        let said = |name| response.headers().get(name).and_then(|value| value.to_str().ok());
        let kind = said(header::CONTENT_TYPE).map(|kind| kind.split(';').next().unwrap_or_default().trim());
        if kind.is_some_and(|kind| PAGES.iter().any(|page| kind.eq_ignore_ascii_case(page))) {
            return Err(io::Error::other(PORTAL));
        }
        if said(header::CONTENT_ENCODING).is_some_and(|coding| !coding.trim().eq_ignore_ascii_case("identity")) {
            return Err(io::Error::other(COMPRESSED));
        }
        self.has_given.set(true);
        Ok(response)
    }
}

impl Source for HttpSource {
    fn small(&mut self, path: &str, _limit: u64) -> io::Result<Box<dyn Read + '_>> {
        let response = self.get(path, 0, Some(SMALL))?;
        let reader = MeteredReader { reader: PlainReader(response.into_body().into_reader()), meter: &mut self.meter };
        Ok(Box::new(no_page(reader)?))
    }

    fn object(&mut self, id: &ObjectId, size: u64, from: u64) -> io::Result<Box<dyn Read + '_>> {
        let mut response = self.get(&id.path(), from, None)?;
        let begins = match first_byte(&response, size) {
            Some(begins) if begins <= from => begins,
            // It is another part than was asked for, or of another file: the whole leaves nothing to mistake.
            Some(_) | None => {
                response = self.get(&id.path(), 0, None)?;
                first_byte(&response, size)
                    .filter(|begins| *begins == 0)
                    .ok_or_else(|| io::Error::other("the server sends a part of what was asked for whole"))?
            }
        };
        let mut reader =
            MeteredReader { reader: PlainReader(response.into_body().into_reader()), meter: &mut self.meter };
        // A server that knows no parts sends everything: what is here already is read over.
        io::copy(&mut reader.by_ref().take(from - begins), &mut io::sink())?;
        Ok(Box::new(reader))
    }
}

/// Who asks at `url`, through `proxy`, a server that is accepted by `judgement`.
/// Errors: [`Fatal::Address`] if one of them is no address.
pub(crate) fn agent(url: &str, proxy: Option<&str>, judgement: Judgement) -> Result<Agent, Fatal> {
    let refused = |address: &str| Fatal::Address { address: address.to_owned() };
    let rest = url.strip_prefix("https://").or_else(|| url.strip_prefix("http://"));
    if rest.is_none_or(|rest| rest.is_empty() || rest.starts_with('/') || url.contains(['?', '#', ' '])) {
        return Err(refused(url));
    }
    let proxy = proxy.map(|proxy| Proxy::new(proxy).map_err(|_| refused(proxy))).transpose()?;
    let config = Agent::config_builder()
        .proxy(proxy)
        .https_only(url.starts_with("https://"))
        .http_status_as_error(false)
        .max_redirects(REDIRECTS)
        .accept_encoding("identity")
        .user_agent(concat!("dreams-update/", env!("CARGO_PKG_VERSION")))
        .timeout_resolve(Some(CONNECT))
        .timeout_connect(Some(CONNECT))
        .timeout_recv_response(Some(SILENCE))
        .timeout_per_read(Some(SILENCE));
    let connector =
        ().chain(ConnectProxyConnector::default()).chain(TcpConnector::default()).chain(Tls::new(judgement));
    Ok(Agent::with_parts(config.build(), connector, DefaultResolver::default()))
}

/// The place in a file of `size` bytes of the first byte of this answer; `None` if it does not say, or is of another file.
fn first_byte(response: &Response<Body>, size: u64) -> Option<u64> {
    if response.status().as_u16() != 206 {
        return Some(0);
    }
    let (first, total) = part_of(response.headers().get(header::CONTENT_RANGE)?.to_str().ok()?)?;
    total.is_none_or(|total| total == size).then_some(first)
}

/// The first byte, and the size of the whole, of a `Content-Range: bytes 5-9/10`; a size of `*` is not known.
fn part_of(range: &str) -> Option<(u64, Option<u64>)> {
    let (first, rest) = range.strip_prefix("bytes ")?.split_once('-')?;
    let (_, total) = rest.split_once('/')?;
    Some((first.parse().ok()?, if total == "*" { None } else { Some(total.parse().ok()?) }))
}

/// The small file in `reader`, whatever its type was said to be.
/// Errors: Those of `reader`; that it is a web page, or compressed, which no small file of ours is.
fn no_page(mut reader: impl Read) -> io::Result<impl Read> {
    let mut head = Vec::new();
    reader.by_ref().take(HEAD).read_to_end(&mut head)?;
    let text = head.strip_prefix(b"\xef\xbb\xbf").unwrap_or(&head).trim_ascii_start();
    if text.first() == Some(&b'<') {
        return Err(io::Error::other(PORTAL));
    }
    if head.starts_with(&[0x1f, 0x8b]) {
        return Err(io::Error::other(COMPRESSED));
    }
    Ok(Cursor::new(head).chain(reader))
}

#[cfg(test)]
mod tests {
    use super::{HttpSource, no_page, part_of};
    use crate::tls::Judgement;
    use player::clock::ClockReader;
    use settings::authorities::Authorities;
    use std::io::Read;

    #[test]
    fn only_addresses_are_taken_for_addresses() {
        let clock = ClockReader::of_machine().read();
        let judgement = Judgement { system: "/nowhere".into(), owners: Authorities::default(), clock };
        let source = |url, proxy| HttpSource::new(url, proxy, judgement.clone());
        for fine in ["http://127.0.0.1:80/a", "https://example.org", "https://example.org/flocks/"] {
            assert!(source(fine, Some("http://proxy:8080")).is_ok(), "{fine}");
        }
        for wrong in ["", "example.org", "ftp://example.org", "http://", "https:///a", "https://a/?b", "http://a b"] {
            assert!(source(wrong, None).is_err(), "{wrong}");
        }
        assert!(source("https://example.org", Some("gopher://x")).is_err());
    }

    #[test]
    fn a_part_tells_where_it_begins() {
        assert_eq!(part_of("bytes 5-9/10"), Some((5, Some(10))));
        assert_eq!(part_of("bytes 5-9/*"), Some((5, None)));
        for wrong in ["", "bytes", "bytes */10", "items 5-9/10", "bytes -9/10", "bytes 5-9", "bytes 5-9/all"] {
            assert_eq!(part_of(wrong), None, "{wrong}");
        }
    }

    #[test]
    fn a_page_is_known_by_its_first_bytes_and_all_else_comes_whole() {
        for page in ["<!DOCTYPE html>", "\n <HTML>", "\u{feff}<?xml version='1.0'?>", "<html>"] {
            assert!(no_page(page.as_bytes()).is_err(), "{page}");
        }
        assert!(no_page(&[0x1f, 0x8b, 8][..]).is_err());
        for file in ["", "untrusted comment: signature", &"a < b\n".repeat(100)] {
            let mut text = String::new();
            no_page(file.as_bytes()).unwrap().read_to_string(&mut text).unwrap();
            assert_eq!(text, file);
        }
    }
}
