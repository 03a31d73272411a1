//! Which events of a key are presses.
//!
//! Owns the state of the keys of a device: repeats that the kernel makes are no presses, and a key that is held longer than
//! [`STUCK_NS`] is stuck, so that its press does not count. Never reads a device or a clock.
//!
//! Start at [`Buttons::on`].

use crate::showing::Vote;

/// How long a person holds a key, at most.
pub const STUCK_NS: u64 = 5_000_000_000;
/// The shortest time between two presses of a hand: what comes sooner is a contact that bounces.
const BOUNCE_NS: u64 = 40_000_000;
/// Keys that are held at once, at most.
const MOST_HELD: usize = 16;

/// A press.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Press {
    /// The code of the key.
    pub key: u16,
    /// What it means.
    pub vote: Vote,
}

/// The keys of a device.
#[derive(Clone, Debug)]
pub struct Buttons {
    /// `None` for every key that is not `down`.
    up: Option<u16>,
    down: Option<u16>,
    /// The keys that are held, and since when; `None` for one that is known to be stuck.
    held: Vec<(u16, Option<u64>)>,
    /// When the last press was.
    last_ns: Option<u64>,
}

impl Buttons {
    /// Keys by their codes; without `up` every key is one that is not `down`.
    pub fn new(up: Option<u16>, down: Option<u16>) -> Self {
        Self { up, down, held: Vec::new(), last_ns: None }
    }

    /// An event of key `key` with the kernel's `value` (0 released, 1 pressed, 2 repeated) at `now_ns`. Returns a press
    /// of a key that means something.
    pub fn on(&mut self, key: u16, value: i32, now_ns: u64) -> Option<Press> {
        let vote = match self {
            Self { down: Some(down), .. } if *down == key => Vote::Down,
            Self { up: Some(up), .. } if *up != key => return None,
            Self { .. } => Vote::Up,
        };
        if value == 0 {
            self.held.retain(|(held, _)| *held != key);
        }
        let is_held = self.held.len() >= MOST_HELD || self.held.iter().any(|(held, _)| *held == key);
        if value != 1 || is_held {
            return None;
        }
        self.held.push((key, Some(now_ns)));
        let is_bounce = self.last_ns.is_some_and(|last_ns| now_ns.saturating_sub(last_ns) < BOUNCE_NS);
        self.last_ns = self.last_ns.filter(|_| is_bounce).or(Some(now_ns));
        (!is_bounce).then_some(Press { key, vote })
    }

    /// The keys that turn out to be stuck at `now_ns`, each told once.
    pub fn stuck(&mut self, now_ns: u64) -> Vec<u16> {
        let is_over = |since: &mut u64| now_ns.saturating_sub(*since) > STUCK_NS;
        self.held.iter_mut().filter_map(|(key, since)| since.take_if(is_over).map(|_| *key)).collect()
    }

    /// Forgets what is held: the device is gone, or events were lost.
    pub fn forget(&mut self) {
        self.held.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::{BOUNCE_NS, Buttons, Press, STUCK_NS};
    use crate::showing::Vote;

    #[test]
    fn a_press_counts_once_however_long_the_key_is_held() {
        let mut buttons = Buttons::new(Some(103), Some(108));
        let up = Some(Press { key: 103, vote: Vote::Up });
        assert_eq!(buttons.on(103, 1, 0), up);
        assert_eq!([2, 2, 1].map(|value| buttons.on(103, value, BOUNCE_NS)), [None; 3], "the kernel repeats");
        assert_eq!(buttons.on(108, 1, BOUNCE_NS), Some(Press { key: 108, vote: Vote::Down }));
        assert_eq!(buttons.on(28, 1, 2 * BOUNCE_NS), None, "a key without a meaning");
        assert_eq!([buttons.on(103, 0, 2 * BOUNCE_NS), buttons.on(103, 1, 2 * BOUNCE_NS)], [None, up]);
        let bounces = [0, 1, 0, 1].map(|value| buttons.on(103, value, 3 * BOUNCE_NS - 1));
        assert_eq!(bounces, [None; 4], "a contact that bounces");
        assert_eq!([buttons.on(103, 0, 3 * BOUNCE_NS), buttons.on(103, 1, 3 * BOUNCE_NS)], [None, up]);
    }

    #[test]
    fn a_key_that_is_held_over_five_seconds_is_stuck_until_it_is_released() {
        let mut buttons = Buttons::new(None, None);
        assert!(buttons.on(30, 1, 100).is_some() && buttons.on(31, 1, 100 + BOUNCE_NS).is_some(), "any key");
        assert_eq!(buttons.stuck(100 + STUCK_NS), [0; 0]);
        assert_eq!(buttons.stuck(101 + STUCK_NS), [30]);
        assert_eq!(buttons.stuck(101 + STUCK_NS), [0; 0], "told once");
        assert_eq!(buttons.on(30, 1, 102 + STUCK_NS), None);
        assert_eq!(buttons.on(30, 0, 103 + STUCK_NS), None);
        assert!(buttons.on(30, 1, 104 + STUCK_NS).is_some());
        buttons.forget();
        assert_eq!(buttons.stuck(u64::MAX), [0; 0]);
        let many = (0..99).filter_map(|key| buttons.on(key, 1, (1_000 + u64::from(key)) * BOUNCE_NS)).count();
        assert_eq!(many, 16, "no hand holds more");
    }
}
