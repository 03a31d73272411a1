//! Errors of the network, in our own words.
//!
//! Owns those words. The words of a server, a proxy or a certificate may be an attacker's, and reach neither people nor
//! the log: only the kind of error, and a number. Never decides what to do about it.

use std::io::{self, ErrorKind, Read};
use ureq::Error;

/// What may be wrong with a certificate, in the words of the library that verifies it.
const CERTIFICATES: [(&str, &str); 4] = [
    ("expired", "it has expired"),
    ("not valid yet", "it is not valid yet"),
    ("not valid for name", "it is for another name"),
    ("UnknownIssuer", "its issuer is not trusted"),
];
/// What is wrong with all others.
const CERTIFICATE: &str = "it is not valid";

/// How the standard library begins an error of name resolution, which has no number.
const LOOKUP: &str = "failed to lookup address information";
/// The same, in our words.
const UNRESOLVED: &str = "cannot resolve the name of the server";

/// A body whose errors are in our own words.
#[derive(Debug)]
pub(crate) struct PlainReader<R>(pub(crate) R);

impl<R: Read> Read for PlainReader<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        self.0.read(buffer).map_err(of_io)
    }
}

/// What a request met.
#[expect(clippy::wildcard_enum_match_arm, reason = "the list grows with every version of ureq")]
pub(crate) fn of_request(error: Error) -> io::Error {
    let other = |words: &str| io::Error::other(words.to_owned());
    match error {
        Error::Io(error) => of_io(error),
        Error::Timeout(_) => io::Error::new(ErrorKind::TimedOut, "the server does not answer in time"),
        Error::HostNotFound => other(UNRESOLVED),
        Error::ConnectionFailed => other("cannot connect to the server"),
        Error::Tls(_) | Error::Pem(_) | Error::TlsRequired => other("cannot set up TLS with the server"),
        Error::Rustls(error) => other(&of_tls(&error.to_string())),
        Error::ConnectProxyFailed(said) => other(&of_proxy(&said)),
        Error::BadUri(_) | Error::RedirectFailed | Error::TooManyRedirects | Error::RequireHttpsOnly(_) => {
            other("the server redirects to an address that is not allowed")
        }
        _ => other("the answer of the server is not valid HTTP"),
    }
}

/// What a connection met: the system's own words, or, of whatever else stands behind it, what kind it is.
fn of_io(error: io::Error) -> io::Error {
    if error.raw_os_error().is_some() {
        return error;
    }
    let kind = error.kind();
    match error.downcast::<Error>() {
        Ok(error) => of_request(error),
        Err(error) if kind == ErrorKind::InvalidData => io::Error::new(kind, of_tls(&error.to_string())),
        Err(error) if error.to_string().starts_with(LOOKUP) => io::Error::other(UNRESOLVED),
        Err(_) => kind.into(),
    }
}

fn of_tls(said: &str) -> String {
    if !said.contains("certificate") {
        return "cannot set up TLS with the server".to_owned();
    }
    let why = CERTIFICATES.iter().find(|(word, _)| said.contains(word)).map_or(CERTIFICATE, |(_, why)| why);
    format!("the server's certificate is refused: {why}")
}

/// A proxy's status is a number; whatever it says besides is its own.
fn of_proxy(said: &str) -> String {
    let is_status = |word: &&str| word.len() == 3 && word.bytes().all(|b| b.is_ascii_digit());
    let status = said.split(|c: char| !c.is_ascii_alphanumeric()).find(is_status);
    status.map_or("the proxy refuses to connect".to_owned(), |status| {
        format!("the proxy refuses to connect: it answers {status}")
    })
}

#[cfg(test)]
mod tests {
    use super::{PlainReader, of_request};
    use std::io::{self, ErrorKind, Read};
    use std::net::ToSocketAddrs;
    use ureq::Error;

    struct Broken;

    impl Read for Broken {
        fn read(&mut self, _: &mut [u8]) -> io::Result<usize> {
            Err(io::Error::other(Error::ConnectProxyFailed(THEIRS.to_owned())))
        }
    }

    const THEIRS: &str = "evil\n\u{1b}[2J 12345";

    #[test]
    fn what_strangers_say_is_told_by_nobody() {
        let foreign = || io::Error::new(ErrorKind::InvalidData, THEIRS);
        for error in [
            Error::BadUri(THEIRS.to_owned()),
            Error::ConnectProxyFailed(THEIRS.to_owned()),
            Error::RequireHttpsOnly(THEIRS.to_owned()),
            Error::Other(THEIRS.into()),
            Error::Io(foreign()),
            Error::Io(io::Error::new(ErrorKind::InvalidData, format!("invalid peer certificate: {THEIRS}"))),
            Error::Io(io::Error::new(ErrorKind::UnexpectedEof, THEIRS)),
            Error::Io(io::Error::other(Error::BadUri(THEIRS.to_owned()))),
        ] {
            let said = of_request(error).to_string();
            assert!(!said.contains("evil") && !said.contains(char::is_control) && !said.is_empty(), "{said}");
        }
        assert_eq!(PlainReader(Broken).read(&mut [0]).unwrap_err().to_string(), "the proxy refuses to connect");
    }

    #[test]
    fn what_helps_on_site_is_told() {
        let said = |error| of_request(error).to_string();
        assert!(said(Error::ConnectProxyFailed("HTTP 403 Forbidden".to_owned())).ends_with("answers 403"));
        let refused = io::Error::from_raw_os_error(111);
        assert_eq!(said(Error::Io(io::Error::from_raw_os_error(111))), refused.to_string());
        let expired = io::Error::new(ErrorKind::InvalidData, "invalid peer certificate: certificate expired: at 7");
        assert_eq!(said(Error::Io(expired)), "the server's certificate is refused: it has expired");
        assert_eq!(of_request(Error::Io(ErrorKind::UnexpectedEof.into())).kind(), ErrorKind::UnexpectedEof);
        // No server of names is asked for one that is too long.
        let unresolved = ("x".repeat(64), 80).to_socket_addrs().unwrap_err();
        assert_eq!(said(Error::Io(unresolved)), "cannot resolve the name of the server");
    }
}
