//! Claims on what strangers can do to the page.
//!
//! Owns clients of every kind, and time in the hand: a unix socket has what was written at once, so a round of the
//! server is all that a test needs. Never waits.

use super::{ANSWERING_NS, ASKING_NS, MOST_CLIENTS, Server};
use crate::status::hosts::Hosts;
use crate::status::http::{Answer, LONGEST_HEAD};
use player::now;
use std::fmt::Write as _;
use std::io::{ErrorKind, Read, Write};
use std::net::{Shutdown, TcpListener, TcpStream};
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::PathBuf;
use std::thread;
use tempfile::TempDir;
use timing::Nanos;

/// More than a socket takes before its reader reads.
const LARGE: usize = 4 << 20;

const ASK: &[u8] = b"GET /small HTTP/1.1\r\nHost: unit\r\n\r\n";
const ASK_LARGE: &[u8] = b"GET /large HTTP/1.1\r\nHost: unit\r\n\r\n";

fn page(path: &str) -> Answer {
    Answer::of("text/plain", vec![b'a'; if path == "/large" { LARGE } else { 5 }])
}

/// A server, and the folder with its socket.
struct Site<A> {
    server: Server<A>,
    folder: TempDir,
    now: Nanos,
}

fn site() -> Site<impl Fn(&str) -> Answer> {
    let folder = tempfile::tempdir().unwrap();
    let listener = UnixListener::bind(folder.path().join("socket")).unwrap();
    Site { server: Server::new(listener.into(), Hosts::Any, page).unwrap(), folder, now: Nanos(0) }
}

impl<A: Fn(&str) -> Answer> Site<A> {
    fn socket(&self) -> PathBuf {
        self.folder.path().join("socket")
    }

    /// A client that has said `said`, and whom the server has taken in.
    fn client(&mut self, said: &[u8]) -> UnixStream {
        let mut client = UnixStream::connect(self.socket()).unwrap();
        client.set_nonblocking(true).unwrap();
        client.write_all(said).unwrap();
        self.server.serve(self.now);
        client
    }

    /// All that `client` is told, or `None` if that takes more than `rounds`.
    fn told(&mut self, client: &mut UnixStream, rounds: usize) -> Option<Vec<u8>> {
        let mut told = Vec::new();
        for _ in 0..rounds {
            self.server.serve(self.now);
            match client.read_to_end(&mut told) {
                Ok(_) => return Some(told),
                Err(error) => assert_eq!(error.kind(), ErrorKind::WouldBlock),
            }
        }
        None
    }

    /// Whether a new client is answered at once.
    fn answers(&mut self) -> bool {
        let mut client = self.client(ASK);
        self.told(&mut client, 3).is_some_and(|told| told.starts_with(b"HTTP/1.1 200 OK") && told.ends_with(b"aaaaa"))
    }
}

/// Whether the server has hung up on `client`.
fn is_over(client: &mut UnixStream) -> bool {
    match client.read_to_end(&mut Vec::new()) {
        Ok(_) => true,
        Err(error) => error.kind() == ErrorKind::ConnectionReset,
    }
}

#[test]
fn a_client_that_says_nothing_delays_nobody_and_is_hung_up_on() {
    let mut site = site();
    let mut idle = site.client(b"");
    let mut slow = site.client(b"GET / HT");
    assert!(site.answers());
    site.now = Nanos(ASKING_NS - 1);
    slow.write_all(b"T").unwrap();
    site.server.serve(site.now);
    assert!(!is_over(&mut idle) && !is_over(&mut slow));
    site.now = Nanos(ASKING_NS);
    site.server.serve(site.now);
    assert!(is_over(&mut idle) && is_over(&mut slow), "also the one that says a byte now and then");
    assert!(site.server.clients.is_empty());
}

#[test]
fn six_hundred_idle_clients_take_few_descriptors_and_the_page_still_answers() {
    let mut site = site();
    let mut idle = Vec::new();
    for _ in 0..600 {
        idle.push(site.client(b""));
        assert!(site.server.clients.len() <= MOST_CLIENTS);
    }
    assert!(site.answers(), "while they are all there");
    let over = idle.iter_mut().map(is_over).filter(|&over| over).count();
    assert_eq!(over, 601 - MOST_CLIENTS, "those that came first had to go");
    drop(idle);
    assert!(site.answers(), "when they have gone");
    site.server.serve(site.now);
    assert!(site.server.clients.is_empty());
}

#[test]
fn clients_that_never_read_block_nobody_and_are_hung_up_on() {
    let mut site = site();
    let mut deaf: Vec<_> = (0..3).map(|_| site.client(&ASK_LARGE.repeat(300))).collect();
    assert!(site.answers());
    site.now = Nanos(ANSWERING_NS - 1);
    assert!(site.answers());
    site.server.serve(site.now);
    assert_eq!(site.server.clients.len(), 3, "only those are left");
    site.now = Nanos(ANSWERING_NS);
    site.server.serve(site.now);
    assert!(deaf.iter_mut().all(is_over));
}

#[test]
fn whoever_is_being_answered_outlasts_a_crowd_that_says_nothing() {
    let mut site = site();
    let mut reader = site.client(ASK_LARGE);
    let _crowd: Vec<_> = (0..100).map(|_| site.client(b"")).collect();
    let told = site.told(&mut reader, 10_000).expect("the answer is whole");
    assert_eq!(told.iter().rev().take_while(|&&byte| byte == b'a').count(), LARGE);
}

#[test]
fn a_page_full_of_clients_that_never_read_still_answers() {
    let mut site = site();
    let _deaf: Vec<_> = (0..MOST_CLIENTS).map(|_| site.client(ASK_LARGE)).collect();
    assert!(site.answers());
}

#[test]
fn a_client_that_asks_on_and_on_is_answered_once() {
    let mut site = site();
    let mut client = site.client(&ASK.repeat(300));
    let told = String::from_utf8(site.told(&mut client, 3).unwrap()).unwrap();
    assert_eq!(told.matches("HTTP/1.1 200 OK").count(), 1);
    client.shutdown(Shutdown::Both).unwrap();
    (0..3).for_each(|_| site.server.serve(site.now));
    assert!(site.server.clients.is_empty());
}

#[test]
fn garbage_is_refused_and_whoever_hangs_up_is_forgotten() {
    let mut site = site();
    let mut garbage = site.client(b"\x16\x03\x01\x02\x00\x01");
    assert!(site.told(&mut garbage, 3).unwrap().starts_with(b"HTTP/1.1 400 "));
    for said in [b"".as_slice(), b"GET /", ASK, ASK_LARGE] {
        drop(site.client(said));
    }
    drop(garbage);
    (0..4).for_each(|_| site.server.serve(site.now));
    assert!(site.server.clients.is_empty());
}

#[test]
fn a_refusal_arrives_although_the_request_was_not_read_to_its_end() {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap();
    let server = Server::new(listener.into(), Hosts::Any, page).unwrap();
    thread::spawn(move || server.run(now));
    let mut head = String::from("GET / HTTP/1.1\r\n");
    while head.len() < 4 * LONGEST_HEAD {
        write!(head, "x-{}: much\r\n", head.len()).unwrap();
    }
    let mut client = TcpStream::connect(address).unwrap();
    client.write_all(head.as_bytes()).unwrap();
    let mut told = String::new();
    client.read_to_string(&mut told).unwrap();
    assert!(told.starts_with("HTTP/1.1 431 ") && told.ends_with("the request is too long\n"), "{told}");
}
