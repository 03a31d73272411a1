//! A bundle on a web server: any server of static files will do.
//!
//! Owns the requests, one for each file, and the checks of the answers: a login page of a hotel is no bundle, a part must
//! be the part that was asked for, and a server that does not answer, or too slowly, is given up. The signature of the
//! content is checked by the reader; so TLS is for privacy alone, and a unit whose clock cannot be right does not judge
//! how old a certificate is.
//!
//! Start at [`HttpSource::new`].

use crate::fatal::Fatal;
use crate::meter::{Meter, MeteredReader};
use crate::network_error::{PlainReader, of_request};
use bundle::{ObjectId, Source};
use std::io::{self, ErrorKind, Read};
use std::time::Duration;
use ureq::http::{Response, header};
use ureq::tls::TlsConfig;
use ureq::{Agent, Body, Proxy};

/// How long until a name is found, and a server answers.
const CONNECT: Duration = Duration::from_secs(15);
/// How long a server may say nothing.
const SILENCE: Duration = Duration::from_secs(30);
/// How long anything small may take as a whole.
pub(crate) const SMALL: Duration = Duration::from_mins(5);
/// Redirects in a row.
const REDIRECTS: u32 = 5;

/// A web server.
#[derive(Debug)]
pub(crate) struct HttpSource {
    agent: Agent,
    /// Ends in no `/`.
    url: String,
    meter: Meter,
}

impl HttpSource {
    /// The bundles beneath `url`, asked for through `proxy`. With `is_clock_wrong`, certificates are not judged.
    /// Errors: [`Fatal::Address`] if one of them is no address.
    pub(crate) fn new(url: &str, proxy: Option<&str>, is_clock_wrong: bool) -> Result<Self, Fatal> {
        let agent = agent(url, proxy, is_clock_wrong)?;
        Ok(Self { agent, url: url.trim_end_matches('/').to_owned(), meter: Meter::default() })
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
            status => return Err(io::Error::other(format!("the server answers {status}"))),
        }
        let kind = response.headers().get(header::CONTENT_TYPE).and_then(|kind| kind.to_str().ok());
        if kind.is_some_and(|kind| kind.starts_with("text/html")) {
            return Err(io::Error::other(
                "the server sent a web page instead of a bundle: is there a login portal on this network?",
            ));
        }
        Ok(response)
    }
}

impl Source for HttpSource {
    fn small(&mut self, path: &str, _limit: u64) -> io::Result<Box<dyn Read + '_>> {
        let response = self.get(path, 0, Some(SMALL))?;
        Ok(Box::new(MeteredReader { reader: PlainReader(response.into_body().into_reader()), meter: &mut self.meter }))
    }

    fn object(&mut self, id: &ObjectId, _size: u64, from: u64) -> io::Result<Box<dyn Read + '_>> {
        let response = self.get(&id.path(), from, None)?;
        let range = response.headers().get(header::CONTENT_RANGE).and_then(|range| range.to_str().ok());
        let begins = match (response.status().as_u16(), range) {
            (206, range) => range
                .and_then(first_byte)
                .ok_or_else(|| io::Error::other("the server sent a part without `Content-Range`"))?,
            _ => 0,
        };
        if begins > from {
            return Err(io::Error::other(format!("asked for bytes from {from} on, got those from {begins} on")));
        }
        let mut reader =
            MeteredReader { reader: PlainReader(response.into_body().into_reader()), meter: &mut self.meter };
        // A server that knows no parts sends everything: what is here already is read over.
        io::copy(&mut reader.by_ref().take(from - begins), &mut io::sink())?;
        Ok(Box::new(reader))
    }
}

/// Who asks at `url`, through `proxy`. With `is_clock_wrong`, certificates are not judged.
/// Errors: [`Fatal::Address`] if one of them is no address.
pub(crate) fn agent(url: &str, proxy: Option<&str>, is_clock_wrong: bool) -> Result<Agent, Fatal> {
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
        .timeout_per_read(Some(SILENCE))
        .tls_config(TlsConfig::builder().disable_verification(is_clock_wrong).build());
    Ok(config.build().new_agent())
}

/// The first byte of a `Content-Range: bytes 5-9/10`.
fn first_byte(range: &str) -> Option<u64> {
    range.strip_prefix("bytes ")?.split('-').next()?.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::{HttpSource, first_byte};

    #[test]
    fn only_addresses_are_taken_for_addresses() {
        for fine in ["http://127.0.0.1:80/a", "https://example.org", "https://example.org/flocks/"] {
            assert!(HttpSource::new(fine, Some("http://proxy:8080"), false).is_ok(), "{fine}");
        }
        for wrong in ["", "example.org", "ftp://example.org", "http://", "https:///a", "https://a/?b", "http://a b"] {
            assert!(HttpSource::new(wrong, None, false).is_err(), "{wrong}");
        }
        assert!(HttpSource::new("https://example.org", Some("gopher://x"), false).is_err());
    }

    #[test]
    fn a_part_tells_where_it_begins() {
        assert_eq!(first_byte("bytes 5-9/10"), Some(5));
        for wrong in ["", "bytes", "bytes */10", "items 5-9/10", "bytes -9/10"] {
            assert_eq!(first_byte(wrong), None, "{wrong}");
        }
    }
}
