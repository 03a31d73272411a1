//! The ports of a unit as its network sees them: all closed.
//!
//! Owns the claim on the ports of known services, scanned from the network. `all_ports.rs` scans all of them, and
//! `starts/first_start.rs` lists the sockets from inside.

use crate::machine::Machine;
use crate::network::port_scanner::{PortScanner, Ports, Protocol};
use crate::starts::first_start::playing_unit;
use std::collections::BTreeSet;
use std::net::{IpAddr, Ipv6Addr};
use std::ops::RangeInclusive;

/// The port of the DHCP client.
const DHCP: u16 = 68;
/// The ports of well-known services, of mDNS and LLMNR, and of the status page.
const KNOWN: [RangeInclusive<u16>; 3] = [1..=1023, 5353..=5355, 7180..=7180];

/// The unit's addresses that everybody on its network knows: one from the network, one of its own.
fn addresses(machine: &mut Machine) -> [IpAddr; 2] {
    let lease = "cat /run/systemd/netif/leases/* 2> /dev/null | sed -n 's/^ADDRESS=//p'";
    machine.run(&format!("until [ -n \"$({lease})\" ]; do sleep 1; done"));
    let given = machine.run(lease).trim().parse().unwrap();
    let own = machine.run("sed -n '/^fe80/s/ .*//p' /proc/net/if_inet6");
    [given, IpAddr::V6(Ipv6Addr::from_bits(u128::from_str_radix(own.trim(), 16).unwrap()))]
}

/// Scans `ports` from the network; every one is closed.
pub(crate) fn are_closed(ports: &[RangeInclusive<u16>]) {
    let (_unit, mut machine) = playing_unit().snapshot.wake();
    let addresses = addresses(&mut machine);
    // The kernel limits how often it answers `port unreachable`; the scan needs every answer.
    machine.run("cd /proc/sys/net && echo 0 | tee ipv4/icmp_ratemask ipv6/icmp/ratelimit");
    machine.run("cd /proc/sys/net/ipv4 && echo 1000000 | tee icmp_msgs_per_sec icmp_msgs_burst");
    let mac = machine.run("cat /sys/class/net/e*/address");
    let mac: Vec<u8> = mac.trim().split(':').map(|byte| u8::from_str_radix(byte, 16).unwrap()).collect();
    let scanner = PortScanner::new(machine.wire(), mac.try_into().unwrap());
    for address in addresses {
        for protocol in [Protocol::Tcp, Protocol::Udp] {
            let found = scanner.scan(address, protocol, ports.iter().cloned().flatten());
            let is_dhcp = address.is_ipv4() && protocol == Protocol::Udp;
            let silent = if is_dhcp { BTreeSet::from([DHCP]) } else { BTreeSet::new() };
            assert_eq!(found, Ports { open: BTreeSet::new(), silent }, "{protocol:?} at {address}");
        }
    }
    // The scan finds a port that is open.
    machine.run("systemd-socket-activate --listen=[::]:1023 cat > /dev/null 2>&1 &");
    machine.run("until grep -q ':03FF ' /proc/net/tcp6; do sleep 1; done");
    for address in addresses {
        assert_eq!(scanner.scan(address, Protocol::Tcp, 1023..=1023).open, BTreeSet::from([1023]), "{address}");
    }
}

#[test]
fn nobody_on_its_network_finds_an_open_door() {
    are_closed(&KNOWN);
}
