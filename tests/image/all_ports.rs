//! All of a unit's ports, seen by somebody else on its network.
//!
//! Owns that claim, which takes longer than that on the ports that are known: see `ports.rs`.

use crate::ports::is_shut;

#[test]
fn nobody_on_its_network_finds_an_open_door_among_all_that_there_are() {
    is_shut(&[1..=u16::MAX]);
}
