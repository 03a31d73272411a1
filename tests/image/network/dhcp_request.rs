//! The DHCP request of a unit.
//!
//! Owns the parsing of the request, and the claims on the name and the client id in it. Where the name comes from is
//! tried in `it/unit/hostname.rs`.
//!
//! Start at [`dhcp_request`].

use crate::machine::Machine;
use crate::machine::clock::now;
use crate::owner::settings_error::{OPEN, TAKE_IN};
use crate::starts::first_start::playing_unit;
use etherparse::{SlicedPacket, TransportSlice};
use std::time::Duration;

/// The longest wait for the request.
const PATIENCE: Duration = Duration::from_mins(2);
/// The server's UDP port, and the number of bytes before the options.
const SERVER: u16 = 67;
const HEAD: usize = 240;
/// The options with the name and with the client id.
const NAME: u8 = 12;
const CLIENT: u8 = 61;
/// QEMU's address for a first card, after the type byte for Ethernet.
const CARD: [u8; 7] = [1, 0x52, 0x54, 0x00, 0x12, 0x34, 0x56];

/// What a unit sends of itself.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct DhcpRequest {
    pub(crate) client: Vec<u8>,
    pub(crate) name: String,
}

/// Makes the unit send a request, and receives it.
pub(crate) fn dhcp_request(machine: &mut Machine) -> DhcpRequest {
    let wire = machine.wire();
    wire.set_read_timeout(Some(Duration::from_secs(5))).unwrap();
    machine.run("systemctl restart systemd-networkd");
    let end = now() + PATIENCE;
    let mut frame = [0; 2048];
    while now() < end {
        let Ok(length) = wire.recv(&mut frame) else { continue };
        if let Some(dhcp_request) = question(&frame[..length]) {
            return dhcp_request;
        }
    }
    panic!("nobody asks for an address in two minutes; {}", machine.serial.lately());
}

/// The request in the frame, if it has one.
fn question(frame: &[u8]) -> Option<DhcpRequest> {
    let packet = SlicedPacket::from_ethernet(frame).ok()?;
    let Some(TransportSlice::Udp(udp)) = &packet.transport else { return None };
    let options = udp.payload().get(HEAD..).filter(|_| udp.destination_port() == SERVER)?;
    let said = |wanted| option(options, wanted).map(<[u8]>::to_vec).unwrap_or_default();
    Some(DhcpRequest { client: said(CLIENT), name: String::from_utf8(said(NAME)).unwrap() })
}

/// The value of the option with this number.
fn option(mut options: &[u8], wanted: u8) -> Option<&[u8]> {
    loop {
        let (number, length) = (*options.first()?, usize::from(*options.get(1)?));
        let value = options.get(2..2 + length)?;
        if number == wanted {
            return Some(value);
        }
        options = &options[2 + length..];
    }
}

#[test]
fn a_unit_asks_for_an_address_by_its_card_and_by_its_name() {
    let (_unit, mut machine) = playing_unit().snapshot.wake();
    assert_eq!(machine.run("cat /proc/sys/kernel/hostname"), "lobby", "as its owner calls it");
    assert_eq!(dhcp_request(&mut machine), DhcpRequest { client: CARD.to_vec(), name: "lobby".to_owned() });
    machine.run("[ ! -e /etc/hostname ]");
    machine.run("rm /var/lib/dreams/owner/name && systemctl restart dreams-name");
    assert_eq!(machine.run("cat /proc/sys/kernel/hostname"), "dreams-123456", "by its card");

    // An address of the owner's replaces the one from the network.
    let file = "/run/owner/dreams.toml";
    machine.run(&format!("{OPEN} && echo 'address = \"192.0.2.7/24\"' >> {file} && {TAKE_IN}"));
    machine.run("until grep -q '|-- 192.0.2.7$' /proc/net/fib_trie; do sleep 1; done");
    assert_eq!(machine.run("grep -c '|-- 10.0.2.15$' /proc/net/fib_trie; true"), "0", "that is given up");
    machine.is_well();
}
