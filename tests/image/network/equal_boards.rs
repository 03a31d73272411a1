//! Two units whose boards have the same serial number.
//!
//! Owns the claim that a network can tell them apart.

use crate::network::dhcp_request::dhcp_request;
use crate::starts::first_start::UP;
use crate::unit::Unit;

/// The UUID that such boards report.
const UUID: &str = "03000200-0400-0500-0006-000700080009";

#[test]
fn two_units_with_the_same_number_on_their_boards_are_two_to_their_network() {
    let twin = |card: &str| {
        let unit = Unit::new();
        let words = ["-uuid", UUID, "-global", &format!("virtio-net-pci.mac={card}")].map(str::to_owned);
        let mut machine = unit.start_with(&words);
        machine.await_shell();
        machine.run(UP);
        (machine.run("cat /etc/machine-id"), dhcp_request(&mut machine))
    };
    let (one_id, one) = twin("52:54:00:aa:00:01");
    let (other_id, other) = twin("52:54:00:aa:00:02");
    assert_eq!(one_id, UUID.replace('-', ""));
    assert_eq!(one_id, other_id, "to themselves they are one");
    assert_eq!((one.name.as_str(), other.name.as_str()), ("dreams-aa0001", "dreams-aa0002"));
    assert_ne!(one.client, other.client);
}
