//! Broods and the snow globe: children that are made, shown and accepted.
//!
//! Owns their making and their folder `.studio/broods`. The operators are those of each species, the rules of a pool those of the
//! package `breeding`.
//!
//! Start at [`births::begin`].

pub(super) mod broods;
pub(super) mod children;
pub(super) mod globe;
