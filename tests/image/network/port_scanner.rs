//! A port scanner on the unit's network.
//!
//! Owns the frames on the wire: TCP and UDP probes and their answers, and the scanner's own answers to ARP and neighbour
//! discovery. Never judges. A packaged scanner needs a network interface, and so root or a network namespace with
//! `/dev/net/tun`; QEMU's user network forwards single ports, and answers in the unit's place. QEMU's datagram socket
//! needs neither.
//!
//! Start at [`PortScanner::scan`].

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

/// The scanner's own addresses, in the networks that QEMU makes.
const MAC: Mac = [0x02, 0, 0, 0, 0, 0x77];
const IPV4: Ipv4Addr = Ipv4Addr::new(10, 0, 2, 77);
const IPV6: Ipv6Addr = Ipv6Addr::new(0xfe80, 0, 0, 0, 0, 0, 0, 0x77);
/// The port that probes are sent from.
const FROM: u16 = 40_000;
/// So many probes are sent before the answers are read.
const BURST: usize = 256;
/// Without an answer for so long, a round is over.
const QUIET: Duration = Duration::from_millis(300);
/// The most rounds: ports that have not answered are probed again.
const ROUNDS: u32 = 6;

/// The protocol of a probe.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Protocol {
    Tcp,
    Udp,
}

/// The ports that are not closed.
#[derive(Debug, Default, PartialEq, Eq)]
pub(crate) struct Ports {
    /// They accept a connection, or answer a datagram.
    pub(crate) open: BTreeSet<u16>,
    /// No answer came from them.
    pub(crate) silent: BTreeSet<u16>,
}

/// The state of a port by the unit's answer.
enum Answer {
    Closed(u16),
    Open(u16),
}

/// A scanner on the network of one unit.
pub(crate) struct PortScanner {
    wire: UnixDatagram,
    unit: Mac,
    answers: Receiver<Answer>,
}

impl PortScanner {
    /// `wire` leads to the network of the unit with this address.
    pub(crate) fn new(wire: UnixDatagram, unit: Mac) -> Self {
        let (sender, answers) = channel();
        let receiver = wire.try_clone().unwrap();
        thread::spawn(move || {
            let mut frame = [0; 2048];
            while let Ok(length) = receiver.recv(&mut frame) {
                let Ok(packet) = SlicedPacket::from_ethernet(&frame[..length]) else { continue };
                if let Some(here) = resolution(&packet) {
                    // QEMU may have ended.
                    receiver.send(&here).ok();
                } else if let Some(answer) = answer(&packet)
                    && sender.send(answer).is_err()
                {
                    return;
                }
            }
        });
        Self { wire, unit, answers }
    }

    /// Probes `ports` of the unit's `address`; those that do not answer several times.
    pub(crate) fn scan(&self, address: IpAddr, protocol: Protocol, ports: impl Iterator<Item = u16>) -> Ports {
        let mut found = Ports { silent: ports.collect(), ..Ports::default() };
        for _ in 0..ROUNDS {
            let waiting: Vec<_> = found.silent.iter().copied().collect();
            for burst in waiting.chunks(BURST) {
                for port in burst {
                    self.wire.send(&probe(self.unit, address, protocol, *port)).unwrap();
                }
                self.note(&mut found, Duration::ZERO);
            }
            if found.silent.is_empty() {
                break;
            }
            self.note(&mut found, QUIET);
        }
        found
    }

    /// Notes the answers, until none has come for so long.
    fn note(&self, found: &mut Ports, quiet: Duration) {
        while let Ok(answer) = self.answers.recv_timeout(quiet) {
            let (Answer::Closed(port) | Answer::Open(port)) = answer;
            found.silent.remove(&port);
            if let Answer::Open(port) = answer {
                found.open.insert(port);
            }
        }
    }
}

/// A frame to `unit` that holds a packet to `address`.
fn to(unit: Mac, address: IpAddr) -> PacketBuilderStep<IpHeaders> {
    let frame = PacketBuilder::ethernet2(MAC, unit);
    match address {
        IpAddr::V4(address) => frame.ipv4(IPV4.octets(), address.octets(), 64),
        // Neighbour discovery is accepted only with the full hop limit.
        IpAddr::V6(address) => frame.ipv6(IPV6.octets(), address.octets(), 255),
    }
}

fn probe(unit: Mac, address: IpAddr, protocol: Protocol, port: u16) -> Vec<u8> {
    let mut frame = Vec::new();
    let packet = to(unit, address);
    match protocol {
        Protocol::Tcp => packet.tcp(FROM, port, 1, 1024).syn().write_to_vec(&mut frame, &[]),
        Protocol::Udp => packet.udp(FROM, port).write_to_vec(&mut frame, b"?"),
    }
    .expect("a frame is written to memory");
    frame
}

/// The state of the port that `packet` answers for.
fn answer(packet: &SlicedPacket) -> Option<Answer> {
    match packet.transport.as_ref()? {
        TransportSlice::Tcp(tcp) if tcp.destination_port() == FROM => {
            Some(if tcp.rst() { Answer::Closed(tcp.source_port()) } else { Answer::Open(tcp.source_port()) })
        }
        TransportSlice::Udp(udp) if udp.destination_port() == FROM => Some(Answer::Open(udp.source_port())),
        // Port unreachable; the payload begins with the header of the probe.
        TransportSlice::Icmpv4(icmp) if (icmp.type_u8(), icmp.code_u8()) == (3, 3) => {
            port_after(icmp.payload(), 20).map(Answer::Closed)
        }
        TransportSlice::Icmpv6(icmp) if (icmp.type_u8(), icmp.code_u8()) == (1, 4) => {
            port_after(icmp.payload(), 40).map(Answer::Closed)
        }
        TransportSlice::Tcp(_)
        | TransportSlice::Udp(_)
        | TransportSlice::Icmpv4(_)
        | TransportSlice::Icmpv6(_)
        | TransportSlice::Igmp(_) => None,
    }
}

/// The destination port of a packet whose IP header has `head` bytes.
fn port_after(packet: &[u8], head: usize) -> Option<u16> {
    packet.get(head + 2..head + 4).map(|port| u16::from_be_bytes([port[0], port[1]]))
}

/// The answer to `packet`, if it is an ARP request or a neighbour solicitation for our address.
fn resolution(packet: &SlicedPacket) -> Option<Vec<u8>> {
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
            // Flags: solicited, override.
            to(link.source(), unit).icmpv6_raw(136, 0, [0x60, 0, 0, 0]).write_to_vec(&mut frame, &here).ok()?;
        }
        _ => return None,
    }
    Some(frame)
}
