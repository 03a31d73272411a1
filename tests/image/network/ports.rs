//! The ports of a unit: none is open to its network.
//!
//! Owns this claim, and that an open port is found.

use crate::machine::open_ports::open_ports;
use crate::starts::first_start::playing_unit;

#[test]
fn no_port_of_a_unit_is_open_to_its_network() {
    let (_unit, mut machine) = playing_unit().snapshot.wake();
    assert_eq!(open_ports(&mut machine), [""; 0]);
    // A port that is open is found, on IPv4 alone and on both.
    for (address, port, table) in [("0.0.0.0", 1022, "tcp"), ("[::]", 1023, "tcp6")] {
        machine.run(&format!("systemd-socket-activate --listen={address}:{port} cat > /dev/null 2>&1 &"));
        machine.run(&format!("until grep -q ':{port:04X} ' /proc/net/{table}; do sleep 1; done"));
    }
    assert_eq!(
        open_ports(&mut machine),
        ["tcp 00000000:03FE", "tcp6 00000000000000000000000000000000:03FF"],
        "the ports that were opened"
    );
}
