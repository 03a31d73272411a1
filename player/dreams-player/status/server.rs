//! The server of the status page: strangers on one side, art on the other.
//!
//! Owns the listening socket, the few connections and their deadlines. Nothing that a client does or leaves undone
//! costs the picture anything: one thread, a fixed number of descriptors, a bounded head, and an end to every
//! connection. Never knows the contents: `http.rs` spells answers, `mod.rs` makes them.
//!
//! A server of our own, because the small ones take a thread and two descriptors for each connection and wait for ever:
//! 500 idle connections to `tiny_http` left the player none to open clips with. A round never waits and is told the
//! time, so the tests drive it by hand: start at [`Server::serve`].

use super::hosts::Hosts;
use super::http::{Answer, LONGEST_HEAD, reply};
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::io::{Errno, ioctl_fionbio};
use rustix::net::{Shutdown, SocketFlags, accept_with, shutdown};
use std::fs::File;
use std::io::{self, ErrorKind, Read, Write};
use std::os::fd::OwnedFd;
use std::thread;
use std::time::Duration;
use timing::Nanos;
use tracing::debug;

/// How many connections there are at most. A browser opens up to six.
const MOST_CLIENTS: usize = 16;

/// How long a client may take to ask, in nanoseconds.
const ASKING_NS: u64 = 2_000_000_000;

/// How long a client may take to read the whole answer, in nanoseconds.
const ANSWERING_NS: u64 = 5_000_000_000;

/// How long a client may take to hang up after the answer, in nanoseconds.
const LEAVING_NS: u64 = 1_000_000_000;

/// How long nothing is served after the system has refused, as it does when descriptors run out.
const PAUSE: Duration = Duration::from_secs(1);

/// Answers all who connect, one request each.
pub(crate) struct Server<A> {
    listener: OwnedFd,
    /// In the order in which they came.
    clients: Vec<Client>,
    /// Who may be asked for.
    hosts: Hosts,
    /// The answer for a path.
    answer: A,
}

struct Client {
    socket: File,
    stage: Stage,
    /// When it is hung up on, however far it is.
    until: Nanos,
}

enum Stage {
    /// So much of its request has arrived.
    Asking(Vec<u8>),
    /// So much of its answer is still to be sent: what is left from the offset on.
    Answering(Vec<u8>, usize),
    /// It has all; what it still sends is read and dropped. Hanging up on unread bytes would take the answer back.
    Leaving,
}

impl<A: Fn(&str) -> Answer> Server<A> {
    /// Serves what `answer` says at `listener`, a listening socket, to those who ask for one of `hosts`.
    /// Errors: If the socket cannot be made to not wait.
    pub(crate) fn new(listener: OwnedFd, hosts: Hosts, answer: A) -> io::Result<Self> {
        ioctl_fionbio(&listener, true)?;
        Ok(Self { listener, clients: Vec::with_capacity(MOST_CLIENTS + 1), hosts, answer })
    }

    /// Serves for ever.
    pub(crate) fn run(mut self, now: fn() -> Nanos) {
        loop {
            self.wait(now());
            self.serve(now());
        }
    }

    /// Waits until there is something to do, or a deadline has passed.
    fn wait(&self, now: Nanos) {
        let mut watched = vec![PollFd::new(&self.listener, PollFlags::IN)];
        watched.extend(self.clients.iter().map(|client| PollFd::new(&client.socket, client.stage.awaited())));
        let soonest_ns = self.clients.iter().map(|client| client.until.since(now)).min();
        let timeout = soonest_ns
            .map(|ns| Timespec::try_from(Duration::from_nanos(ns)).expect("a deadline is seconds away, not centuries"));
        if let Err(error) = poll(&mut watched, timeout.as_ref()) {
            rest(error);
        }
    }

    /// One round: takes in one client, and lets everyone go on as far as they can without waiting.
    fn serve(&mut self, now: Nanos) {
        match accept_with(&self.listener, SocketFlags::NONBLOCK | SocketFlags::CLOEXEC) {
            Ok(socket) => self.admit(socket, now),
            Err(Errno::AGAIN | Errno::CONNABORTED) => {}
            Err(error) => rest(error),
        }
        let (hosts, answer) = (self.hosts, &self.answer);
        self.clients.retain_mut(|client| client.until > now && client.go_on(hosts, answer, now));
    }

    /// Takes a client in. If all places are taken, one that is not being answered has to go, the longest here first.
    fn admit(&mut self, socket: OwnedFd, now: Nanos) {
        if self.clients.len() == MOST_CLIENTS {
            let idle = self.clients.iter().position(|client| !matches!(client.stage, Stage::Answering(..)));
            self.clients.remove(idle.unwrap_or(0));
        }
        let (socket, stage) = (File::from(socket), Stage::Asking(Vec::new()));
        self.clients.push(Client { socket, stage, until: now.after(ASKING_NS) });
    }
}

impl Client {
    /// Goes one step on, and says whether there is more to come.
    fn go_on(&mut self, hosts: Hosts, answer: impl Fn(&str) -> Answer, now: Nanos) -> bool {
        self.step(hosts, answer, now)
            .unwrap_or_else(|error| matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::Interrupted))
    }

    fn step(&mut self, hosts: Hosts, answer: impl Fn(&str) -> Answer, now: Nanos) -> io::Result<bool> {
        let mut buffer = [0; LONGEST_HEAD];
        match &mut self.stage {
            Stage::Asking(head) => {
                let space = LONGEST_HEAD - head.len();
                let count = self.socket.read(&mut buffer[..space])?;
                head.extend_from_slice(&buffer[..count]);
                if let Some(bytes) = reply(head, |host| hosts.include(host), answer) {
                    (self.stage, self.until) = (Stage::Answering(bytes, 0), now.after(ANSWERING_NS));
                }
                Ok(count > 0)
            }
            Stage::Answering(bytes, sent) => {
                *sent += self.socket.write(&bytes[*sent..])?;
                if *sent == bytes.len() {
                    shutdown(&self.socket, Shutdown::Write)?;
                    (self.stage, self.until) = (Stage::Leaving, now.after(LEAVING_NS));
                }
                Ok(true)
            }
            Stage::Leaving => Ok(self.socket.read(&mut buffer)? > 0),
        }
    }
}

impl Stage {
    fn awaited(&self) -> PollFlags {
        match self {
            Self::Asking(_) | Self::Leaving => PollFlags::IN,
            Self::Answering(..) => PollFlags::OUT,
        }
    }
}

/// Gives a system that refuses time to recover.
fn rest(error: Errno) {
    debug!(%error, "the status page pauses after an error of the system");
    thread::park_timeout(PAUSE);
}

#[cfg(test)]
mod tests;
