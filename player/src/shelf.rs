//! The shelf between the decoder and the glass.
//!
//! Owns the frames that lie ready, and when the decoder works: it fills the shelf, rests until half of it is taken,
//! and fills it again. Decoding a few frames at a stretch finds the processor's caches as the frame before left them,
//! and wakes the processor less often, which counts on a machine that has nothing else to do.
//! Never looks at a frame.

use std::collections::VecDeque;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// A shelf with room for `room` things, at least one: the end where they are put, and the end where they are taken.
pub(crate) fn shelf<T>(room: usize) -> (Filler<T>, Taker<T>) {
    let inside = Mutex::new(Inside { things: VecDeque::with_capacity(room), filler_gone: false, taker_gone: false });
    let shelf = Arc::new(Shelf { inside, room: room.max(1), came: Condvar::new(), is_wanted: Condvar::new() });
    (Filler(Arc::clone(&shelf)), Taker(shelf))
}

/// Where things are put. Dropped, the taker takes what is left and then hears of the end.
#[derive(Debug)]
pub(crate) struct Filler<T>(Arc<Shelf<T>>);

/// Where things are taken. Dropped, the filler hears of it at once.
#[derive(Debug)]
pub(crate) struct Taker<T>(Arc<Shelf<T>>);

/// The taker is gone: there is nobody to work for.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Unwanted;

/// What a taker finds.
#[derive(Debug, PartialEq, Eq)]
pub(crate) enum Found<T> {
    /// The oldest thing.
    Thing(T),
    /// Nothing yet.
    Nothing,
    /// Nothing ever: the filler is gone.
    End,
}

#[derive(Debug)]
struct Shelf<T> {
    inside: Mutex<Inside<T>>,
    room: usize,
    /// Something was put, or the filler is gone.
    came: Condvar,
    /// So much was taken that it is time to work, or the taker is gone.
    is_wanted: Condvar,
}

#[derive(Debug)]
struct Inside<T> {
    things: VecDeque<T>,
    filler_gone: bool,
    taker_gone: bool,
}

impl<T> Shelf<T> {
    fn hold(&self) -> MutexGuard<'_, Inside<T>> {
        self.inside.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl<T> Filler<T> {
    /// Puts `thing` down; if that fills the shelf, rests until half of it is taken.
    ///
    /// # Errors
    /// [`Unwanted`].
    pub(crate) fn put(&self, thing: T) -> Result<(), Unwanted> {
        let shelf = &*self.0;
        let mut inside = shelf.hold();
        inside.things.push_back(thing);
        shelf.came.notify_one();
        if inside.things.len() >= shelf.room {
            let rest = |inside: &mut Inside<T>| !inside.taker_gone && inside.things.len() > shelf.room / 2;
            inside = shelf.is_wanted.wait_while(inside, rest).unwrap_or_else(PoisonError::into_inner);
        }
        if inside.taker_gone { Err(Unwanted) } else { Ok(()) }
    }
}

impl<T> Drop for Filler<T> {
    fn drop(&mut self) {
        self.0.hold().filler_gone = true;
        self.0.came.notify_one();
    }
}

impl<T> Taker<T> {
    /// Takes the oldest thing, waiting for one at most `patience`.
    pub(crate) fn take(&self, patience: Duration) -> Found<T> {
        let shelf = &*self.0;
        let mut inside = shelf.hold();
        if !patience.is_zero() {
            let wait = |inside: &mut Inside<T>| inside.things.is_empty() && !inside.filler_gone;
            let waited = shelf.came.wait_timeout_while(inside, patience, wait);
            inside = waited.unwrap_or_else(PoisonError::into_inner).0;
        }
        match inside.things.pop_front() {
            Some(thing) => {
                if inside.things.len() == shelf.room / 2 {
                    shelf.is_wanted.notify_one();
                }
                Found::Thing(thing)
            }
            None if inside.filler_gone => Found::End,
            None => Found::Nothing,
        }
    }
}

impl<T> Drop for Taker<T> {
    fn drop(&mut self) {
        let mut inside = self.0.hold();
        inside.taker_gone = true;
        inside.things.clear();
        self.0.is_wanted.notify_one();
    }
}

#[cfg(test)]
mod tests {
    use super::{Found, Unwanted, shelf};
    use std::sync::mpsc::channel;
    use std::thread;
    use std::time::Duration;

    const LONG: Duration = Duration::from_secs(20);

    #[test]
    fn a_full_shelf_is_filled_again_when_half_of_it_is_taken() {
        let (filler, taker) = shelf(4);
        let (told, tells) = channel();
        let filling = thread::spawn(move || {
            for thing in 1..=6 {
                filler.put(thing).unwrap();
                told.send(thing).unwrap();
            }
        });
        // The fourth fills it: that one is not told of before two are left.
        assert_eq!([tells.recv(), tells.recv(), tells.recv()], [Ok(1), Ok(2), Ok(3)]);
        assert_eq!(taker.take(LONG), Found::Thing(1));
        assert!(tells.recv_timeout(Duration::from_millis(20)).is_err(), "three or four are left");
        assert_eq!(taker.take(LONG), Found::Thing(2));
        assert_eq!([tells.recv(), tells.recv()], [Ok(4), Ok(5)]);
        let rest: Vec<_> = std::iter::from_fn(|| match taker.take(LONG) {
            Found::Thing(thing) => Some(thing),
            Found::Nothing | Found::End => None,
        })
        .collect();
        assert_eq!(rest, [3, 4, 5, 6]);
        filling.join().unwrap();
        assert_eq!(taker.take(Duration::ZERO), Found::End);
    }

    #[test]
    fn an_empty_shelf_is_no_end() {
        let (filler, taker) = shelf::<u8>(1);
        assert_eq!(taker.take(Duration::ZERO), Found::Nothing);
        assert_eq!(taker.take(Duration::from_millis(1)), Found::Nothing);
        drop(filler);
        assert_eq!(taker.take(LONG), Found::End);
    }

    #[test]
    fn who_works_for_nobody_hears_of_it() {
        let (filler, taker) = shelf(1);
        let resting = thread::spawn(move || filler.put(1));
        thread::sleep(Duration::from_millis(5));
        drop(taker);
        assert_eq!(resting.join().unwrap(), Err(Unwanted));
    }
}
