//! What the queue runs: clips, strips and previews, broods, checks, measuring, and commands of this program.
//!
//! Owns which job does what. `jobs` has the queue, `media` makes the files.
//!
//! Start at [`clips`].

pub(super) mod births;
pub(super) mod checking;
pub(super) mod clips;
pub(super) mod measuring;
pub(super) mod own_command;
pub(super) mod previews;

use std::sync::Arc;

use crate::lock::locked;
use crate::workshop::Workshop;

/// Goes on with the jobs that an earlier run left.
pub(super) fn go_on(workshop: &Arc<Workshop>) {
    for brood in locked(&workshop.stock.broods).unfinished() {
        births::queue(workshop, &brood);
    }
    for kept in workshop.queue.left() {
        match clips::work_of(workshop, &kept) {
            Some(work) => drop(workshop.queue.go_on(&kept, work)),
            None => workshop.queue.forget(&kept),
        }
    }
}
