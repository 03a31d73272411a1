//! Hot-plug events from the kernel, without udevd.
//!
//! Owns the netlink socket and the filter. A survey finds out what has changed.

use rustix::net::{AddressFamily, RecvFlags, SocketFlags, SocketType, bind, netlink, recvfrom, socket_with};
use std::io;
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};

/// The kernel's own multicast group; udevd would re-broadcast on 2, where there is a udevd.
const KERNEL_GROUP: u32 = 1;

/// A subscription to the kernel's device events.
#[derive(Debug)]
pub(crate) struct Uevents(OwnedFd);

impl Uevents {
    /// Subscribes.
    /// Errors: The kernel or a sandbox denies netlink.
    pub(crate) fn subscribe() -> io::Result<Self> {
        let flags = SocketFlags::CLOEXEC | SocketFlags::NONBLOCK;
        let socket = socket_with(AddressFamily::NETLINK, SocketType::DGRAM, flags, Some(netlink::KOBJECT_UEVENT))?;
        bind(&socket, &netlink::SocketAddrNetlink::new(0, KERNEL_GROUP))?;
        Ok(Self(socket))
    }

    /// Reads all waiting events; whether any concerns a display.
    pub(crate) fn display_changed(&mut self) -> bool {
        let mut changed = false;
        let mut message = [0; 8192];
        loop {
            match recvfrom(&self.0, &mut message[..], RecvFlags::empty()) {
                Ok((_, length, sender)) => {
                    // Any process may send to us; the kernel's port is 0.
                    let sender = sender.and_then(|address| netlink::SocketAddrNetlink::try_from(address).ok());
                    let kernel = sender.is_some_and(|address| address.pid() == 0);
                    changed |= kernel && is_display_event(&message[..length.min(8192)]);
                }
                Err(rustix::io::Errno::INTR) => {}
                // Some were lost: one of them may have concerned a display.
                Err(rustix::io::Errno::NOBUFS) => changed = true,
                Err(_) => return changed,
            }
        }
    }
}

impl AsFd for Uevents {
    fn as_fd(&self) -> BorrowedFd<'_> {
        self.0.as_fd()
    }
}

/// A connector changed, or a card came or went. Leases and properties send `change` events too, without `HOTPLUG`.
fn is_display_event(message: &[u8]) -> bool {
    let has = |field: &[u8]| message.split(|&byte| byte == 0).any(|found| found == field);
    has(b"SUBSYSTEM=drm") && (has(b"HOTPLUG=1") || has(b"ACTION=add") || has(b"ACTION=remove"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_hotplug_of_displays_counts() {
        let event = |fields: &str| is_display_event(fields.replace(' ', "\0").as_bytes());
        assert!(event("change@/devices/x ACTION=change SUBSYSTEM=drm HOTPLUG=1 CONNECTOR=34"));
        assert!(event("add@/devices/x ACTION=add SUBSYSTEM=drm DEVNAME=dri/card1"));
        assert!(!event("change@/devices/x ACTION=change SUBSYSTEM=drm LEASE=1"));
        assert!(!event("change@/devices/x ACTION=change SUBSYSTEM=usb HOTPLUG=1"));
        assert!(!event(""));
    }
}
