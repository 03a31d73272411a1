//! The hand-over from the prelude, which lights the first picture, to the player.
//!
//! Owns the socket between the two and the one message on it: the open DRM card, which shows the picture, and the place
//! in the path, so that the player begins with the same picture. The player never waits longer than [`PATIENCE`].
//!
//! `prelude.rs` gives; `run.rs` and `still.rs` take.

use rustix::net::{
    RecvAncillaryBuffer, RecvAncillaryMessage, RecvFlags, SendAncillaryBuffer, SendAncillaryMessage, SendFlags,
    recvmsg, sendmsg,
};
use std::io::{self, IoSlice, IoSliceMut, Read, Write};
use std::mem::MaybeUninit;
use std::os::fd::{BorrowedFd, OwnedFd};
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::Path;
use std::slice;
use std::time::Duration;

/// The socket on a unit.
pub(crate) const SOCKET: &str = "/run/dreams-prelude/card";

/// How long the prelude may take to send.
const PATIENCE: Duration = Duration::from_secs(2);

/// What is handed over.
#[derive(Debug)]
pub(crate) struct Handover {
    /// The open DRM card, which shows a picture. When it is closed the screen goes dark.
    pub(crate) card: OwnedFd,
    /// The place in the path that the picture is of, as `flock::Place` writes it.
    pub(crate) place: Vec<u8>,
}

/// Sends `card` and `place` through `socket` to the first process that connects, always both. `ready` is called when it
/// listens.
/// Errors: What the kernel says of the socket, or of sending.
pub(crate) fn give(socket: &Path, card: BorrowedFd<'_>, place: &[u8], ready: impl FnOnce()) -> io::Result<()> {
    let listener = UnixListener::bind(socket)?;
    ready();
    let (mut taker, _) = listener.accept()?;
    let mut space = [MaybeUninit::uninit(); rustix::cmsg_space!(ScmRights(1))];
    let mut rights = SendAncillaryBuffer::new(&mut space);
    rights.push(SendAncillaryMessage::ScmRights(slice::from_ref(&card)));
    let sent = sendmsg(&taker, &[IoSlice::new(place)], &mut rights, SendFlags::NOSIGNAL)?;
    taker.write_all(&place[sent..])
}

/// Receives what the prelude offers at `socket`; `None` without a prelude.
pub(crate) fn take(socket: &Path) -> Option<Handover> {
    let giver = UnixStream::connect(socket).ok()?;
    taken(giver).inspect_err(|error| tracing::warn!(%error, "cannot take over the first picture")).ok()
}

fn taken(mut giver: UnixStream) -> io::Result<Handover> {
    giver.set_read_timeout(Some(PATIENCE))?;
    let mut space = [MaybeUninit::uninit(); rustix::cmsg_space!(ScmRights(1))];
    let mut rights = RecvAncillaryBuffer::new(&mut space);
    let mut place = vec![0; 1 << 12];
    let got = recvmsg(&giver, &mut [IoSliceMut::new(&mut place)], &mut rights, RecvFlags::CMSG_CLOEXEC)?;
    let card = rights.drain().find_map(|message| {
        let RecvAncillaryMessage::ScmRights(mut cards) = message else { return None };
        cards.next()
    });
    let card = card.ok_or_else(|| io::Error::new(io::ErrorKind::InvalidData, "the message has no DRM card"))?;
    place.truncate(got.bytes);
    giver.read_to_end(&mut place)?;
    Ok(Handover { card, place })
}

#[cfg(test)]
mod tests {
    use super::{give, take};
    use std::fs::File;
    use std::io::{Read, Seek, Write};
    use std::os::fd::AsFd;
    use std::os::unix::net::UnixListener;
    use std::sync::mpsc::channel;
    use std::thread;

    #[test]
    fn what_is_handed_over_is_the_open_file_and_a_place_of_any_length() {
        for length in [1, 4_096, 4_097, 3_000_000] {
            let folder = tempfile::tempdir().unwrap();
            let socket = folder.path().join("card");
            assert!(take(&socket).is_none(), "nobody is there yet");
            let mut file = tempfile::tempfile().unwrap();
            file.write_all(b"glass").unwrap();
            let place: Vec<_> = (0..length).map(|at| (at % 251) as u8).collect();
            let (ready, is_ready) = channel();
            thread::scope(|scope| {
                let given = scope.spawn(|| give(&socket, file.as_fd(), &place, || ready.send(()).unwrap()));
                is_ready.recv().unwrap();
                let handed = take(&socket).expect("it is offered");
                given.join().unwrap().unwrap();
                assert!(handed.place == place, "{length} bytes went in, {} came out", handed.place.len());
                let mut card = File::from(handed.card);
                card.rewind().unwrap();
                let mut text = String::new();
                card.read_to_string(&mut text).unwrap();
                assert_eq!(text, "glass");
            });
            assert!(take(&socket).is_none(), "it is offered once");
        }
    }

    #[test]
    fn whoever_offers_and_gives_nothing_is_not_waited_for() {
        let folder = tempfile::tempdir().unwrap();
        let socket = folder.path().join("card");
        let silent = UnixListener::bind(&socket).unwrap();
        assert!(take(&socket).is_none());
        let (mut taker, _) = silent.accept().unwrap();
        thread::scope(|scope| {
            let taking = scope.spawn(|| take(&socket));
            // One who was given up on, and one who brings a place without a card.
            assert!(taker.write_all(b"late").is_err());
            silent.accept().unwrap().0.write_all(b"place").unwrap();
            assert!(taking.join().unwrap().is_none());
        });
    }
}
