//! Text from strangers appears on no screen, and in no log.
//!
//! Owns the claim on the names of files on a stick and on the answers of a web server: only valid unit names, and
//! sentences of our own, reach the notice, the log and the status page.

use claims::programs::output;
use claims::unit::Unit;
use std::ffi::OsStr;
use std::fs;
use std::io::{Read as _, Write as _};
use std::net::TcpListener;
use std::os::unix::ffi::OsStrExt;
use std::path::Path;
use std::process::Output;
use std::thread;

/// Characters that none of our texts has.
const STRANGE: &str = "evil";

/// The exit code, and the updater's complete output; checks that it has no text of a stranger.
fn told(unit: &Unit, said: &Output) -> (Option<i32>, String) {
    let read = |path: &Path| fs::read_to_string(path).unwrap_or_default();
    let files = [read(&unit.path("notice")), read(&unit.path("store/contact.json"))].concat();
    let streams = [&said.stdout[..], &said.stderr].map(|text| String::from_utf8(text.to_vec()).unwrap()).concat();
    let all = streams + &files;
    assert!(!all.contains(STRANGE) && !all.contains('\u{1b}') && !all.contains("\\u001b"), "{all:?}");
    (said.status.code(), all)
}

#[test]
fn the_names_of_seals_that_nobody_has_verified_are_told_only_if_a_unit_may_be_called_so_and_three_at_most() {
    let unit = Unit::new();
    let seals = unit.stick().join("seals");
    fs::create_dir(&seals).unwrap();
    let strange = |name: &[u8]| fs::write(seals.join(OsStr::from_bytes(name)), "rubbish").unwrap();
    for at in 0..300 {
        strange(format!("{at}\n\u{1b}[2Jevil\u{7}.seal").as_bytes());
    }
    for name in
        [&b"evil\xff.seal"[..], "\u{202e}evil.seal".as_bytes(), b"Evil evil.seal", b".evil.seal", b"evil\r.seal"]
    {
        strange(name);
    }
    let (code, all) = told(&unit, &unit.update(&["--scrub"]));
    assert_eq!((code, unit.notice()), (Some(0), None), "no unit's seal is there: {all}");

    for name in ["attic", "cellar", "hall", "kitchen", "stairs"] {
        fs::write(seals.join(format!("{name}.seal")), "rubbish").unwrap();
    }
    let (code, all) = told(&unit, &unit.update(&[]));
    assert_eq!(code, Some(1), "{all}");
    assert!(all.contains("has bundles for `attic, cellar, hall and 2 more`, none for `lobby`"), "{all}");
    let notice = "This stick is for attic, cellar, hall and 2 more. This frame is lobby.";
    assert_eq!(unit.notice().as_deref(), Some(notice));
}

#[test]
fn what_a_server_says_is_told_in_our_own_words() {
    for answer in [
        "HTTP/1.1 302 Found\r\nLocation: http://evil\u{7f}host/\r\n\r\n",
        "HTTP/1.1 302 Found\r\nLocation: evil://evil\r\n\r\n",
        "HTTP/1.1 418 evil\r\nEvil: evil\r\n\r\nevil",
        "HTTP/1.1 200 evil\r\nContent-Type: text/html; evil\r\n\r\nevil",
        "HTTP/1.1 200 OK\r\nTransfer-Encoding: chunked\r\n\r\nevil\r\nevil",
        "HTTP/1.1 200 OK\r\nContent-Length: 4\r\n\r\nevil",
        "evil \u{1b}[2J\r\n\r\n",
    ] {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let address = format!("http://{}/flocks", listener.local_addr().unwrap());
        // It runs until the claims have ended.
        thread::spawn(move || {
            for stream in listener.incoming() {
                let mut stream = stream.unwrap();
                let _asked = stream.read(&mut [0; 4_096]);
                stream.write_all(answer.as_bytes()).ok();
            }
        });
        let unit = Unit::new();
        let (code, all) = told(&unit, &output(&mut unit.update_from(Some(Path::new(&address)))));
        assert!(matches!(code, Some(1 | 3)) && all.contains("error: "), "{answer:?}: {code:?} {all}");
    }
}
