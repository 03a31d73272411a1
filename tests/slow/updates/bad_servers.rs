//! Servers that stop answering, and a unit with a wrong clock.
//!
//! Owns the claims that take time: how long a silent server is waited for, and TLS on a unit whose clock says 1970.
//! They run in a guest with virtual time.

use crate::guest::{script, succeed_in_virtual_time, word};
use claims::bundle_maker::{BundleMaker, rubbish};
use claims::programs::{claims_folder, updater};
use std::fmt::Write as _;
use std::path::Path;

/// A server of static files, for one request: `GET /PATH`.
const SERVER: &str = r#"
read -r _ path _
while read -r header && [ "$header" != $'\r' ]; do :; done
if [ -f "$1$path" ]; then
    printf 'HTTP/1.1 200 OK\r\nContent-Length: %d\r\nConnection: close\r\n\r\n' "$(stat -c %s "$1$path")"
    cat "$1$path"
else
    printf 'HTTP/1.1 404 Not Found\r\nContent-Length: 0\r\nConnection: close\r\n\r\n'
fi
"#;

/// One that stops in the middle of its answer, and one that sends a byte every ten seconds.
const HALF: &str = r"printf 'HTTP/1.1 200 OK\r\n'; sleep 100000";
const DRIP: &str = r"printf 'HTTP/1.1 200 OK\r\n\r\n'; while sleep 10; do printf x; done";

/// The most seconds for a silent server.
const SILENCE: u64 = 30;
/// The same for one that sends single bytes.
const DRIPPING: u64 = 60;

/// The result of an updater in the guest: its exit status, and the seconds that it took.
fn ended(console: &str, case: &str) -> (u64, u64) {
    let line = console.lines().find_map(|line| line.strip_prefix(&format!("{case}: ")));
    let line = line.unwrap_or_else(|| panic!("nothing is told of `{case}`: {console}"));
    let (status, seconds) = line.split_once(" after ").unwrap();
    (status.parse().unwrap(), seconds.trim().parse().unwrap())
}

#[test]
fn a_server_that_says_nothing_is_left_in_time_and_tls_does_without_a_clock() {
    let folder = tempfile::tempdir_in(claims_folder()).unwrap();
    let at = |name: &str| folder.path().join(name);
    let maker = BundleMaker::with_new_keys();
    for number in [1, 2] {
        maker.bundle(&at(&number.to_string()), &rubbish(3, 5_000, number), &[], number as u64);
    }
    std::fs::rename(maker.keys(), at("keys")).unwrap();
    for (name, script) in [("server", SERVER), ("half", HALF), ("drip", DRIP)] {
        std::fs::write(at(name), script).unwrap();
    }
    let fixture = |name: &str| {
        std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/certificates").join(name)).unwrap()
    };
    for name in ["good.pem", "for-another-name.pem"] {
        std::fs::write(at(name), fixture(name) + &fixture("server.key")).unwrap();
    }
    std::fs::write(at("authority.pem"), fixture("authority.pem")).unwrap();
    std::fs::write(at("update.toml"), "authorities = \"authority.pem\"\n").unwrap();
    let socat = |address: &str, does: &str| format!("socat {address},fork,reuseaddr {does} 2> /dev/null &\n");
    let tls = |port: u16, number: u16, certificate: &str| {
        let address = format!("OPENSSL-LISTEN:{port},cert={certificate},verify=0");
        socat(&address, &format!("EXEC:'bash server {number}'"))
    };
    let mut text = format!(
        "cd {}\n\
         look() {{ begun=$SECONDS status=0; {} --unit lobby --config update.toml --store /tmp/store --keys keys \
         --notice /tmp/notice \"$2\" 2>&1 || status=$?; echo \"$1: $status after $((SECONDS - begun))\"; }}\n",
        word(folder.path()),
        word(&updater()),
    );
    text += &tls(8441, 1, "good.pem");
    text += &tls(8442, 2, "for-another-name.pem");
    text += &socat("TCP-LISTEN:8001", "EXEC:'sleep 100000'");
    text += &socat("TCP-LISTEN:8002", "EXEC:'bash half'");
    text += &socat("TCP-LISTEN:8003", "EXEC:'bash drip'");
    text += "sleep 1\n";
    for (case, clock, url) in [
        ("in 1970", "1970-01-01 00:05", "https://127.0.0.1:8441"),
        ("with a clock", "2030-01-01 12:00", "https://127.0.0.1:8442"),
        ("silent", "2030-01-01 12:00", "http://127.0.0.1:8001"),
        ("silent in the middle", "2030-01-01 12:00", "http://127.0.0.1:8002"),
        ("dripping", "2030-01-01 12:00", "http://127.0.0.1:8003"),
    ] {
        writeln!(text, "date --utc --set='{clock}' > /dev/null; look '{case}' {url}; cat /tmp/notice; echo").unwrap();
    }
    let console = succeed_in_virtual_time(120, &script(&text));

    assert_eq!(ended(&console, "in 1970").0, 0, "certificates are not judged by such a clock: {console}");
    assert!(console.contains("installed `aurora` 1") && !console.contains("installed `aurora` 2"), "{console}");
    assert_eq!(ended(&console, "with a clock").0, 3, "a certificate of somebody else: {console}");
    assert!(console.contains("certificate"), "{console}");
    for (case, at_most) in [("silent", SILENCE), ("silent in the middle", SILENCE), ("dripping", DRIPPING)] {
        let (status, seconds) = ended(&console, case);
        assert!(
            status == 3 && (at_most - 1..=at_most + 1).contains(&seconds),
            "{case}: {status}, {seconds} s: {console}"
        );
    }
}
