//! Which requests are let in.
//!
//! Owns the names that this server has, and the path of reports. A request must name the server by an address, as
//! `localhost` or by a name that was given, which stops names that lead here (DNS rebinding); a report must be JSON and must
//! not come from a page in a browser. Never looks into a body.
//!
//! Start at [`Doors::check`].

use std::net::{IpAddr, Ipv6Addr};

use axum::http::header::{CONTENT_TYPE, HOST, ORIGIN};
use axum::http::request::Parts;
use axum::http::{Method, StatusCode};

/// The names of this server, and where reports may be sent.
#[derive(Clone, Debug, Default)]
pub(crate) struct Doors {
    /// In lower case, without a port.
    pub(crate) names: Vec<String>,
    /// The only path of reports; `None` for any.
    pub(crate) path: Option<String>,
}

/// What is answered instead, in words.
pub(crate) type Refusal = (StatusCode, String);

impl Doors {
    /// Lets a request in, or not.
    /// Errors: What is answered instead.
    pub(crate) fn check(&self, request: &Parts) -> Result<(), Refusal> {
        let mut hosts = request.headers.get_all(HOST).iter();
        let host = hosts.next().and_then(|host| host.to_str().ok());
        if hosts.next().is_some() || !host.is_some_and(|host| self.is_ours(host)) {
            let how = "this server has another name: start it with --host NAME for the name by which it is asked\n";
            return Err((StatusCode::MISDIRECTED_REQUEST, how.to_owned()));
        }
        if request.method != Method::POST {
            return Ok(());
        }
        if request.headers.contains_key(ORIGIN) {
            return Err((StatusCode::FORBIDDEN, "a report must not come from a page in a browser\n".to_owned()));
        }
        if self.path.as_ref().is_some_and(|path| path != request.uri.path()) {
            return Err((StatusCode::NOT_FOUND, "this server takes reports at another path\n".to_owned()));
        }
        let kind = request.headers.get(CONTENT_TYPE).and_then(|kind| kind.to_str().ok()).unwrap_or_default();
        let kind = kind.split(';').next().unwrap_or_default().trim();
        if kind.eq_ignore_ascii_case("application/json") {
            return Ok(());
        }
        Err((StatusCode::UNSUPPORTED_MEDIA_TYPE, "a report must be `application/json`\n".to_owned()))
    }

    /// Whether `host`, as a request has it, is a name of this server. No name leads here that is an address.
    fn is_ours(&self, host: &str) -> bool {
        let name = match host.strip_prefix('[') {
            Some(rest) => {
                return rest.split_once(']').is_some_and(|(six, _)| six.parse::<Ipv6Addr>().is_ok());
            }
            None => host.split_once(':').map_or(host, |(name, _)| name).to_ascii_lowercase(),
        };
        name == "localhost" || name.parse::<IpAddr>().is_ok() || self.names.contains(&name)
    }
}

/// `example.org`: a name of this server, in lower case.
pub(crate) fn name(text: &str) -> Result<String, String> {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '.';
    let is_fine = !text.is_empty() && text.len() <= 253 && text.chars().all(is_plain);
    is_fine.then(|| text.to_ascii_lowercase()).ok_or_else(|| "wanted a name without a port, such as example.org".into())
}

/// `/units-3f9c`: the path of reports.
pub(crate) fn path(text: &str) -> Result<String, String> {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "/-._~".contains(c);
    let is_fine = text.starts_with('/') && text.len() <= 200 && text.chars().all(is_plain);
    is_fine
        .then(|| text.to_owned())
        .ok_or_else(|| "wanted a path of letters, digits and `/-._~` that begins with `/`, such as /units".into())
}

#[cfg(test)]
mod tests {
    use super::*;
    use axum::http::Request;

    fn status_of(doors: &Doors, method: &str, path: &str, headers: &[(&str, &str)]) -> u16 {
        let request = Request::builder().method(method).uri(path);
        let request = headers.iter().fold(request, |request, (name, value)| request.header(*name, *value));
        doors.check(&request.body(()).unwrap().into_parts().0).map_or_else(|(status, _)| status.as_u16(), |()| 200)
    }

    #[test]
    fn only_addresses_and_given_names_lead_here() {
        let doors = Doors { names: vec!["fleet.example.org".to_owned()], path: None };
        let host = |host: &str| status_of(&doors, "GET", "/", &[("host", host)]);
        for ours in ["127.0.0.1:7181", "localhost", "LOCALHOST:1", "[::1]:7181", "192.168.1.5:80", "Fleet.Example.Org"]
        {
            assert_eq!(host(ours), 200, "{ours}");
        }
        for other in ["evil.example", "localhost.evil.example", "", "127.0.0.1.evil.example", "[evil]", "127.1.evil:80"]
        {
            assert_eq!(host(other), 421, "{other}");
        }
        assert_eq!(status_of(&doors, "GET", "/", &[]), 421);
        assert_eq!(status_of(&doors, "GET", "/", &[("host", "localhost"), ("host", "evil.example")]), 421);
    }

    #[test]
    fn a_report_is_json_at_its_path_and_from_no_browser() {
        let doors = Doors { names: Vec::new(), path: Some("/units".to_owned()) };
        let (here, json) = (("host", "localhost"), ("content-type", "application/json; charset=utf-8"));
        assert_eq!(status_of(&doors, "POST", "/units", &[here, json]), 200);
        assert_eq!(status_of(&doors, "POST", "/", &[here, json]), 404);
        assert_eq!(status_of(&Doors::default(), "POST", "/", &[here, json]), 200);
        assert_eq!(status_of(&doors, "POST", "/units", &[here]), 415);
        assert_eq!(status_of(&doors, "POST", "/units", &[here, ("content-type", "text/plain")]), 415);
        assert_eq!(status_of(&doors, "POST", "/units", &[here, json, ("origin", "http://localhost")]), 403);
    }

    #[test]
    fn names_and_paths_are_plain() {
        assert_eq!((name("Fleet.org"), path("/a-b")), (Ok("fleet.org".to_owned()), Ok("/a-b".to_owned())));
        for bad in ["", "a:80", "a/b", "a b", "*"] {
            assert!(name(bad).is_err() && path(bad).is_err(), "{bad}");
        }
    }
}
