//! How `dreams-votes` has the player show that a press was counted.
//!
//! Owns the socket between the two and its one message, and where it is. Whoever may send can have a small mark shown, and
//! nothing else: so everybody on this machine may. Never waits, never draws.
//!
//! `dreams-player` listens, `dreams-votes` tells.

use serde::Deserialize;
use std::convert::Infallible;
use std::fs::{self, Permissions};
use std::io::{self, ErrorKind};
use std::os::unix::fs::{FileTypeExt, PermissionsExt};
use std::os::unix::net::UnixDatagram;
use std::path::{Path, PathBuf};
use std::str::FromStr;

/// The message.
pub const MESSAGE: &[u8] = b"acknowledge";

/// Where the socket is; `None` for nowhere.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(from = "String")]
pub struct MarkSocket(pub Option<PathBuf>);

impl Default for MarkSocket {
    fn default() -> Self {
        Self(Some("/run/dreams/acknowledge".into()))
    }
}

impl From<String> for MarkSocket {
    fn from(text: String) -> Self {
        Self((text != "off").then(|| text.into()))
    }
}

impl FromStr for MarkSocket {
    type Err = Infallible;

    fn from_str(text: &str) -> Result<Self, Infallible> {
        Ok(text.to_owned().into())
    }
}

/// Listens at `path`, in place of a socket that a killed player left, but never of one that is listened to.
/// Errors: What the file system says; also if somebody else listens there.
pub fn listen(path: &Path) -> io::Result<UnixDatagram> {
    let bound = UnixDatagram::bind(path);
    let is_taken = bound.as_ref().is_err_and(|error| error.kind() == ErrorKind::AddrInUse);
    let is_left = || UnixDatagram::unbound()?.connect(path).map_or_else(refused, |()| Ok(false));
    let socket = if is_taken && fs::symlink_metadata(path)?.file_type().is_socket() && is_left()? {
        fs::remove_file(path)?;
        UnixDatagram::bind(path)?
    } else {
        bound?
    };
    fs::set_permissions(path, Permissions::from_mode(0o666))?;
    Ok(socket)
}

fn refused(error: io::Error) -> io::Result<bool> {
    if error.kind() == ErrorKind::ConnectionRefused { Ok(true) } else { Err(error) }
}

/// Asks the player that listens at `path` for the mark, without waiting.
/// Errors: If nobody listens, or does not keep up.
pub fn tell(path: &Path) -> io::Result<()> {
    let socket = UnixDatagram::unbound()?;
    socket.set_nonblocking(true)?;
    socket.send_to(MESSAGE, path).map(drop)
}

#[cfg(test)]
mod tests {
    use super::{MESSAGE, listen, tell};
    use std::fs;
    use std::io::ErrorKind;

    #[test]
    fn a_message_arrives_and_a_flood_of_them_waits_for_nobody() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("socket");
        assert!(tell(&path).is_err(), "there is no player");
        let socket = listen(&path).unwrap();
        assert_eq!(listen(&path).unwrap_err().kind(), ErrorKind::AddrInUse, "it is listened to");
        tell(&path).unwrap();
        let mut buffer = [0; 64];
        let length = socket.recv(&mut buffer).unwrap();
        assert_eq!(&buffer[..length], MESSAGE);
        let arrived = (0..10_000).take_while(|_| tell(&path).is_ok()).count();
        assert!(arrived < 10_000, "the rest is lost");
        drop(socket);
        listen(&path).expect("the socket that a killed player left is replaced");
        fs::remove_file(&path).unwrap();
        fs::write(&path, "a file of the user").unwrap();
        assert!(listen(&path).is_err());
    }
}
