//! All ports of a unit as its network sees them: all closed.
//!
//! Owns this claim, which takes longer than that on the ports of known services in `ports.rs`.

use crate::network::ports::are_closed;

#[test]
fn nobody_on_its_network_finds_an_open_door_among_all_that_there_are() {
    are_closed(&[1..=u16::MAX]);
}
