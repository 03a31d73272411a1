//! Somebody else on the unit's network, who knocks at its ports.
//!
//! Owns the frames on the wire: who is asked where, and what comes back. Never judges, and has no addresses but its own.
//!
//! Start at [`Neighbour::knock`].

use etherparse::{
    ArpHardwareId, ArpOperation, ArpPacket, EtherType, IpHeaders, LinkSlice, NetSlice, PacketBuilder,
    PacketBuilderStep, SlicedPacket, TransportSlice,
};
use std::collections::BTreeSet;
use std::net::{IpAddr, Ipv4Addr, Ipv6Addr};
use std::os::unix::net::UnixDatagram;
use std::sync::mpsc::{Receiver, channel};
use std::thread;
use std::time::Duration;

type Mac = [u8; 6];

/// The neighbour's own addresses, in the networks that QEMU makes.
const MAC: Mac = [0x02, 0, 0, 0, 0, 0x77];
const IPV4: Ipv4Addr = Ipv4Addr::new(10, 0, 2, 77);
const IPV6: Ipv6Addr = Ipv6Addr::new(0xfe80, 0, 0, 0, 0, 0, 0, 0x77);
/// Where it knocks from.
const FROM: u16 = 40_000;
/// So many knocks are sent before the answers are looked at.
const BURST: usize = 256;
/// After so long nothing more comes.
const QUIET: Duration = Duration::from_millis(300);
/// So often it knocks at a door behind which nobody says anything.
const PATIENCE: u32 = 6;

/// What a port is asked by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Protocol {
    Tcp,
    Udp,
}

/// What was behind the doors that were not shut.
#[derive(Debug, Default, PartialEq, Eq)]
pub(crate) struct Doors {
    /// Somebody answered.
    pub(crate) open: BTreeSet<u16>,
    /// Nobody said that nobody is there.
    pub(crate) silent: BTreeSet<u16>,
}

/// What a frame of the unit's says of one of its ports.
enum Answer {
    Shut(u16),
    Open(u16),
}

/// Somebody on the network of one unit.
pub(crate) struct Neighbour {
    wire: UnixDatagram,
    unit: Mac,
    answers: Receiver<Answer>,
}

impl Neighbour {
    /// At the other end of `wire` there is a network, and on it a unit of this address.
    pub(crate) fn new(wire: UnixDatagram, unit: Mac) -> Self {
        let (sender, answers) = channel();
        let ear = wire.try_clone().unwrap();
        thread::spawn(move || {
            let mut frame = [0; 2048];
            while let Ok(length) = ear.recv(&mut frame) {
                let Ok(packet) = SlicedPacket::from_ethernet(&frame[..length]) else { continue };
                if let Some(here) = presence(&packet) {
                    // QEMU may be gone.
                    ear.send(&here).ok();
                } else if let Some(answer) = answer(&packet)
                    && sender.send(answer).is_err()
                {
                    return;
                }
            }
        });
        Self { wire, unit, answers }
    }

    /// Knocks at `ports` of the unit's `address`, again and again where nobody says anything.
    pub(crate) fn knock(&self, address: IpAddr, protocol: Protocol, ports: impl Iterator<Item = u16>) -> Doors {
        let mut doors = Doors { silent: ports.collect(), ..Doors::default() };
        for _ in 0..PATIENCE {
            let waiting: Vec<_> = doors.silent.iter().copied().collect();
            for burst in waiting.chunks(BURST) {
                for port in burst {
                    self.wire.send(&knock(self.unit, address, protocol, *port)).unwrap();
                }
                self.note(&mut doors, Duration::ZERO);
            }
            if doors.silent.is_empty() {
                break;
            }
            self.note(&mut doors, QUIET);
        }
        doors
    }

    /// Notes the answers, until none has come for so long.
    fn note(&self, doors: &mut Doors, quiet: Duration) {
        while let Ok(answer) = self.answers.recv_timeout(quiet) {
            let (Answer::Shut(port) | Answer::Open(port)) = answer;
            doors.silent.remove(&port);
            if let Answer::Open(port) = answer {
                doors.open.insert(port);
            }
        }
    }
}

/// A frame to `unit` that holds a packet to `address`.
fn to(unit: Mac, address: IpAddr) -> PacketBuilderStep<IpHeaders> {
    let frame = PacketBuilder::ethernet2(MAC, unit);
    match address {
        IpAddr::V4(address) => frame.ipv4(IPV4.octets(), address.octets(), 64),
        // What asks who has an address is heard only if no router has touched it.
        IpAddr::V6(address) => frame.ipv6(IPV6.octets(), address.octets(), 255),
    }
}

fn knock(unit: Mac, address: IpAddr, protocol: Protocol, port: u16) -> Vec<u8> {
    let mut frame = Vec::new();
    let packet = to(unit, address);
    match protocol {
        Protocol::Tcp => packet.tcp(FROM, port, 1, 1024).syn().write_to_vec(&mut frame, &[]),
        Protocol::Udp => packet.udp(FROM, port).write_to_vec(&mut frame, b"?"),
    }
    .expect("a frame is written to memory");
    frame
}

/// What `packet` says of a port of the unit.
fn answer(packet: &SlicedPacket) -> Option<Answer> {
    match packet.transport.as_ref()? {
        TransportSlice::Tcp(tcp) if tcp.destination_port() == FROM => {
            Some(if tcp.rst() { Answer::Shut(tcp.source_port()) } else { Answer::Open(tcp.source_port()) })
        }
        TransportSlice::Udp(udp) if udp.destination_port() == FROM => Some(Answer::Open(udp.source_port())),
        // Nobody is at that port; behind it lies the head of what was sent there.
        TransportSlice::Icmpv4(icmp) if (icmp.type_u8(), icmp.code_u8()) == (3, 3) => {
            port_after(icmp.payload(), 20).map(Answer::Shut)
        }
        TransportSlice::Icmpv6(icmp) if (icmp.type_u8(), icmp.code_u8()) == (1, 4) => {
            port_after(icmp.payload(), 40).map(Answer::Shut)
        }
        TransportSlice::Tcp(_)
        | TransportSlice::Udp(_)
        | TransportSlice::Icmpv4(_)
        | TransportSlice::Icmpv6(_)
        | TransportSlice::Igmp(_) => None,
    }
}

/// To which port a packet goes, whose head is so long.
fn port_after(packet: &[u8], head: usize) -> Option<u16> {
    packet.get(head + 2..head + 4).map(|port| u16::from_be_bytes([port[0], port[1]]))
}

/// The answer to `packet`, if it asks who has our address.
fn presence(packet: &SlicedPacket) -> Option<Vec<u8>> {
    let mut frame = Vec::new();
    match (&packet.net, &packet.transport) {
        (Some(NetSlice::Arp(asked)), _) if asked.operation() == ArpOperation::REQUEST => {
            if asked.target_protocol_addr() != IPV4.octets() {
                return None;
            }
            let unit: Mac = asked.sender_hw_addr().try_into().ok()?;
            let (ethernet, ip) = (ArpHardwareId::ETHERNET, EtherType::IPV4);
            let theirs = asked.sender_protocol_addr();
            let here = ArpPacket::new(ethernet, ip, ArpOperation::REPLY, &MAC, &IPV4.octets(), &unit, theirs).ok()?;
            PacketBuilder::ethernet2(MAC, unit).arp(here).write_to_vec(&mut frame).ok()?;
        }
        (Some(NetSlice::Ipv6(ip)), Some(TransportSlice::Icmpv6(asked))) if asked.type_u8() == 135 => {
            let target = asked.payload().get(..16)?;
            if target != IPV6.octets() {
                return None;
            }
            let Some(LinkSlice::Ethernet2(link)) = &packet.link else { return None };
            let here = [target, &[2, 1], &MAC].concat();
            let unit = IpAddr::V6(ip.header().source_addr());
            // Asked for, and it takes the place of what was known.
            to(link.source(), unit).icmpv6_raw(136, 0, [0x60, 0, 0, 0]).write_to_vec(&mut frame, &here).ok()?;
        }
        _ => return None,
    }
    Some(frame)
}
