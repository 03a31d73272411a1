//! Whether a server is too slow.
//!
//! Owns the limit: a server that sends fewer than so many bytes in a minute of waiting is given up, however steadily they
//! come. Only waiting counts: what a unit takes its own time for (`bandwidth_kib`, a slow disk) is not the server's
//! fault.
//!
//! Start at [`Meter`].

use player::now;
use std::io::{self, ErrorKind, Read};

/// After so much waiting, in nanoseconds, it is counted what came.
const WINDOW_NS: u64 = 60_000_000_000;
/// The least that must have come in it, in bytes: a modem sends more.
const LEAST: u64 = 60 << 10;

/// What a server sends, over all that it is asked for.
#[derive(Debug, Default)]
pub(crate) struct Meter {
    waited_ns: u64,
    bytes: u64,
    is_left: bool,
}

/// A reader that fails when its server is too slow.
#[derive(Debug)]
pub(crate) struct MeteredReader<'m, R> {
    pub(crate) reader: R,
    pub(crate) meter: &'m mut Meter,
}

impl Meter {
    /// Fails once the server was too slow.
    /// Errors: [`ErrorKind::TimedOut`], from the first time on that it was too slow.
    pub(crate) fn check(&self) -> io::Result<()> {
        let slow = || io::Error::new(ErrorKind::TimedOut, "the server sends less than 1 KiB a second");
        if self.is_left { Err(slow()) } else { Ok(()) }
    }

    /// So many bytes came after so long a wait.
    fn count(&mut self, waited_ns: u64, bytes: u64) {
        self.waited_ns += waited_ns;
        self.bytes += bytes;
        if self.waited_ns >= WINDOW_NS {
            self.is_left |= self.bytes < LEAST;
            (self.waited_ns, self.bytes) = (0, 0);
        }
    }
}

impl<R: Read> Read for MeteredReader<'_, R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let begun = now();
        let count = self.reader.read(buffer);
        self.meter.count(now().since(begun), *count.as_ref().unwrap_or(&0) as u64);
        self.meter.check()?;
        count
    }
}

#[cfg(test)]
mod tests {
    use super::{LEAST, Meter, WINDOW_NS};

    const SECOND_NS: u64 = 1_000_000_000;

    #[test]
    fn a_server_is_left_for_its_slowness_and_for_nothing_else() {
        let after = |reads: &[(u64, u64)]| {
            let mut meter = Meter::default();
            for (waited_ns, bytes) in reads {
                meter.count(*waited_ns, *bytes);
            }
            meter.check().is_ok()
        };
        assert!(after(&[(WINDOW_NS - 1, 0)]), "a minute is not over");
        assert!(!after(&[(WINDOW_NS, LEAST - 1)]) && after(&[(WINDOW_NS, LEAST)]));
        assert!(!after(&vec![(SECOND_NS, 1_000); 60]), "it drips");
        assert!(after(&vec![(SECOND_NS, 1_025); 600]), "it is slow");
        assert!(after(&vec![(SECOND_NS / 1_000, 100); 600]), "there is little to be had, and it comes at once");
        assert!(!after(&[(WINDOW_NS, 0), (0, 1 << 30)]), "who was left stays left");
    }
}
