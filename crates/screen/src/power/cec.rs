//! HDMI-CEC: the messages to a television by an adapter of the kernel.
//!
//! Owns the messages for standby and for waking, and the logical address of a playback device, which the kernel claims. A
//! television that is in standby may hide where the cable is plugged in: the messages to it then come from an unregistered
//! device, as the standard allows.
//!
//! Start at [`switch`]. Source: HDMI 1.4, supplement 1, CEC 13; `linux/cec.h`.

use super::PowerError;
use crate::raw::{CecAddresses, CecMessage, cec_addresses, cec_physical_address, claim_cec_addresses, transmit_cec};
use std::fs::File;
use std::io;

/// Logical addresses: of the television, of an unregistered device, and of all.
const TELEVISION: u8 = 0;
const UNREGISTERED: u8 = 15;
const ALL: u8 = 15;
/// What the kernel says in the place of an address that was not claimed, or is not known.
const NO_LOGICAL: u8 = 0xff;
const NO_PHYSICAL: u16 = 0xffff;
/// The operations.
const IMAGE_VIEW_ON: u8 = 0x04;
const STANDBY: u8 = 0x36;
const ACTIVE_SOURCE: u8 = 0x82;
/// What a television shows as our name.
const NAME: &[u8] = b"Dreams";
/// Offsets in `struct cec_log_addrs`.
const VERSION: usize = 6;
const COUNT: usize = 7;
const VENDOR: std::ops::Range<usize> = 8..12;
const OSD_NAME: usize = 16;
const PRIMARY_TYPE: usize = 31;
const ADDRESS_TYPE: usize = 35;
const ALL_TYPES: usize = 39;
/// Their values: CEC 1.4, no vendor, a playback device.
const CEC_1_4: u8 = 5;
const NO_VENDOR: [u8; 4] = [0xff; 4];
const PLAYBACK_PRIMARY: u8 = 4;
const PLAYBACK_ADDRESS: u8 = 3;
const PLAYBACK_ALL: u8 = 0x10;
/// Offsets in `struct cec_msg`, and the bit of the status that says that the message has arrived.
const LENGTH: usize = 16;
const CONTENT: usize = 32;
const STATUS: usize = 50;
const ARRIVED: u8 = 1;

/// What a CEC adapter can do.
pub(super) trait Adapter {
    /// Its logical address, claimed if it has none; `None` if it cannot have one now.
    fn logical_address(&mut self) -> io::Result<Option<u8>>;

    /// Where it is plugged in; `None` while that is not known.
    fn physical_address(&mut self) -> io::Result<Option<u16>>;

    /// Sends a message, and waits until it has arrived.
    fn transmit(&mut self, message: &[u8]) -> io::Result<()>;
}

impl Adapter for File {
    fn logical_address(&mut self) -> io::Result<Option<u8>> {
        let mut addresses = cec_addresses(self)?;
        if addresses[COUNT] == 0 {
            addresses = playback();
            claim_cec_addresses(self, &mut addresses)?;
        }
        Ok(Some(addresses[0]).filter(|address| *address != NO_LOGICAL))
    }

    fn physical_address(&mut self) -> io::Result<Option<u16>> {
        cec_physical_address(self).map(|address| Some(address).filter(|address| *address != NO_PHYSICAL))
    }

    fn transmit(&mut self, message: &[u8]) -> io::Result<()> {
        let mut bytes: CecMessage = [0; 56];
        bytes[LENGTH..LENGTH + 4].copy_from_slice(&(message.len() as u32).to_ne_bytes());
        bytes[CONTENT..CONTENT + message.len()].copy_from_slice(message);
        transmit_cec(self, &mut bytes)?;
        if bytes[STATUS] & ARRIVED == 0 {
            return Err(io::Error::other(format!("no device acknowledges it, status {:#04x}", bytes[STATUS])));
        }
        Ok(())
    }
}

/// The wish for the logical address of a playback device.
fn playback() -> CecAddresses {
    let mut addresses: CecAddresses = [0; 92];
    addresses[VERSION] = CEC_1_4;
    addresses[COUNT] = 1;
    addresses[VENDOR].copy_from_slice(&NO_VENDOR);
    addresses[OSD_NAME..OSD_NAME + NAME.len()].copy_from_slice(NAME);
    addresses[PRIMARY_TYPE] = PLAYBACK_PRIMARY;
    addresses[ADDRESS_TYPE] = PLAYBACK_ADDRESS;
    addresses[ALL_TYPES] = PLAYBACK_ALL;
    addresses
}

/// Asks a television to go into standby; or to wake, and to show this connector.
/// Errors: [`PowerError`].
pub(super) fn switch(adapter: &mut impl Adapter, is_on: bool) -> Result<(), PowerError> {
    let failed = |message| move |source| PowerError::Send { message, source };
    let from = adapter.logical_address().map_err(failed("claim of an address"))?.unwrap_or(UNREGISTERED);
    let to_television = from << 4 | TELEVISION;
    if !is_on {
        return adapter.transmit(&[to_television, STANDBY]).map_err(failed("Standby"));
    }
    adapter.transmit(&[to_television, IMAGE_VIEW_ON]).map_err(failed("Image View On"))?;
    let physical = adapter.physical_address().map_err(failed("Active Source"))?.filter(|_| from != UNREGISTERED);
    let [high, low] = physical.ok_or(PowerError::Unanswered { message: "Image View On" })?.to_be_bytes();
    adapter.transmit(&[from << 4 | ALL, ACTIVE_SOURCE, high, low]).map_err(failed("Active Source"))
}

#[cfg(test)]
mod tests {
    use super::{Adapter, playback, switch};
    use crate::power::PowerError;
    use std::io::{self, ErrorKind};

    /// A television behind an adapter.
    #[derive(Debug, Default)]
    struct Television {
        /// The adapter's addresses; none while the cable says nothing.
        logical: Option<u8>,
        physical: Option<u16>,
        is_gone: bool,
        heard: Vec<Vec<u8>>,
    }

    impl Adapter for Television {
        fn logical_address(&mut self) -> io::Result<Option<u8>> {
            Ok(self.logical)
        }

        fn physical_address(&mut self) -> io::Result<Option<u16>> {
            Ok(self.physical)
        }

        fn transmit(&mut self, message: &[u8]) -> io::Result<()> {
            if self.is_gone {
                return Err(ErrorKind::NotConnected.into());
            }
            self.heard.push(message.to_vec());
            Ok(())
        }
    }

    #[test]
    fn a_television_gets_the_messages_of_the_standard() {
        let plugged = || Television { logical: Some(4), physical: Some(0x1200), ..Television::default() };
        let mut television = plugged();
        switch(&mut television, false).unwrap();
        assert_eq!(television.heard, [vec![0x40, 0x36]]);
        let mut television = plugged();
        switch(&mut television, true).unwrap();
        assert_eq!(television.heard, [vec![0x40, 0x04], vec![0x4f, 0x82, 0x12, 0x00]], "awake, and this input");
    }

    #[test]
    fn a_television_that_hides_in_standby_is_woken_first_and_gets_the_input_later() {
        let mut television = Television::default();
        let waking = switch(&mut television, true);
        assert!(matches!(waking, Err(PowerError::Unanswered { message: "Image View On" })), "to be tried again");
        assert_eq!(television.heard, [vec![0xf0, 0x04]], "from an unregistered device");
        (television.logical, television.physical) = (Some(8), Some(0x1000));
        switch(&mut television, true).unwrap();
        assert_eq!(television.heard[1..], [vec![0x80, 0x04], vec![0x8f, 0x82, 0x10, 0x00]]);
        let mut gone = Television { is_gone: true, ..Television::default() };
        assert!(matches!(switch(&mut gone, false), Err(PowerError::Send { message: "Standby", .. })));
    }

    #[test]
    fn the_wish_for_an_address_lies_where_the_kernel_reads_it() {
        let wish = playback();
        assert_eq!((wish[6], wish[7], &wish[8..12]), (5, 1, &[0xff; 4][..]));
        assert_eq!((&wish[16..22], wish[22], wish[31], wish[35], wish[39]), (&b"Dreams"[..], 0, 4, 3, 0x10));
        assert_eq!(wish.iter().filter(|byte| **byte != 0).count(), 15, "and nothing else");
    }
}
