//! What the queue runs, besides broods: clips, strips and previews, checks, measuring, and commands of this program.
//!
//! Owns which job does what. `jobs` has the queue, `media` makes the files.
//!
//! Start at [`rendering`].

pub(super) mod checking;
pub(super) mod measuring;
pub(super) mod own_command;
pub(super) mod rendering;
