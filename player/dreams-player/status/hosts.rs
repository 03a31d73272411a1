//! By which names the status page may be asked for.
//!
//! Owns whose page a request means. A web page from elsewhere can have its own name lead to this machine, and read with
//! the visitor's browser what no port shows it (DNS rebinding): it is told nothing. An address cannot be led elsewhere.

use std::fs;
use std::net::{IpAddr, UdpSocket};

/// Where a machine's name stands: `dreams-name` writes the first on a unit's own system.
const NAMES: [&str; 2] = ["/run/dreams-name/name", "/etc/hostname"];

/// Who may be asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Hosts {
    /// Anybody: no browser comes by a socket in a folder.
    Any,
    /// This machine, by an address or a name of its own.
    Own,
}

impl Hosts {
    /// Whether `host`, as a request has it, with or without a port, may be asked for.
    pub(crate) fn include(self, host: &str) -> bool {
        match self {
            Self::Any => true,
            Self::Own => is_own(host, is_here, || NAMES.iter().filter_map(|path| fs::read_to_string(path).ok())),
        }
    }
}

fn is_own<N: Iterator<Item = String>>(host: &str, is_here: impl Fn(IpAddr) -> bool, names: impl Fn() -> N) -> bool {
    let name = without_port(host);
    if let Ok(address) = name.parse::<IpAddr>() {
        return is_here(address);
    }
    let name = name.strip_suffix('.').unwrap_or(name).to_ascii_lowercase();
    let bare = name.strip_suffix(".local").unwrap_or(&name);
    bare == "localhost" || names().any(|own| !bare.is_empty() && own.trim().eq_ignore_ascii_case(bare))
}

/// The host without its port, and an IPv6 address without its brackets.
fn without_port(host: &str) -> &str {
    if let Some((address, _)) = host.strip_prefix('[').and_then(|rest| rest.split_once(']')) {
        return address;
    }
    match host.rsplit_once(':') {
        Some((name, port)) if !name.contains(':') && port.bytes().all(|byte| byte.is_ascii_digit()) => name,
        Some(_) | None => host,
    }
}

/// Whether this machine has the address: only to one of its own can a socket be bound.
fn is_here(address: IpAddr) -> bool {
    !address.is_unspecified() && !address.is_multicast() && UdpSocket::bind((address, 0)).is_ok()
}

#[cfg(test)]
mod tests {
    use super::{Hosts, is_here, is_own};

    #[test]
    fn a_page_is_told_to_whoever_asks_for_this_machine_and_to_nobody_else() {
        let names = || ["dreams-1a2b3c\n".to_owned(), String::new()].into_iter();
        let include = |host: &str| is_own(host, |address| address.to_string() == "192.0.2.7", names);
        for own in [
            "localhost",
            "LOCALHOST:7180",
            "dreams-1a2b3c",
            "Dreams-1A2B3C.local:7180",
            "dreams-1a2b3c.local.",
            "192.0.2.7",
        ] {
            assert!(include(own), "{own}");
        }
        for other in
            ["", ".local", "example.org", "dreams-1a2b3c.example.org", "192.0.2.8", "localhost.example.org:7180"]
        {
            assert!(!include(other), "{other}");
        }
        for address in ["127.0.0.1:7180", "[::1]:7180", "127.0.0.1"] {
            assert!(Hosts::Own.include(address), "{address}");
        }
        assert!(!Hosts::Own.include("0.0.0.0:7180") && Hosts::Any.include("unit"));
        assert!(!is_here("192.0.2.7".parse().unwrap()), "an address of nobody");
    }
}
