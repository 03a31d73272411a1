//! The open ports of a machine.
//!
//! Owns the list of sockets that take what other machines send, as the kernel shows them in `/proc/net`. A port without
//! a socket is closed.

use crate::machine::Machine;

/// The tables of sockets, and the state in each of a socket that takes what comes: a listening TCP socket, and a UDP
/// socket without a peer.
const TABLES: [(&str, &str); 6] =
    [("tcp", "0A"), ("tcp6", "0A"), ("udp", "07"), ("udp6", "07"), ("udplite", "07"), ("udplite6", "07")];
/// The port of the DHCP client, 68, in those tables.
const DHCP: &str = ":0044";

/// The sockets that other machines can reach: the table, a space, and the address with the port, both in hexadecimal.
pub(crate) fn open_ports(machine: &mut Machine) -> Vec<String> {
    let mut open = Vec::new();
    for (table, state) in TABLES {
        // A kernel without IPv6 or UDP-Lite has no such table.
        for socket in machine.run(&format!("tail -n +2 /proc/net/{table} 2> /dev/null; true")).lines() {
            let words: Vec<_> = socket.split_whitespace().collect();
            let is_dhcp = table == "udp" && words[1].ends_with(DHCP);
            if words[3] == state && !is_loopback(words[1]) && !is_dhcp {
                open.push(format!("{table} {}", words[1]));
            }
        }
    }
    open
}

/// Whether an address in such a table is a loopback address.
fn is_loopback(address: &str) -> bool {
    let host = address.split(':').next().unwrap();
    host.ends_with("7F") || host == "00000000000000000000000001000000" || host == "0000000000000000FFFF00000100007F"
}
