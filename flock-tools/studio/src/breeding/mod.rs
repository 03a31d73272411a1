//! Broods and the snow globe.
//!
//! Owns how a child is made, and the folder `.studio/broods`. The operators are those of each species. `work` has the jobs.
//!
//! Start at [`broods::Broods`].

pub(super) mod broods;
pub(super) mod children;
pub(super) mod globe;
