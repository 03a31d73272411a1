//! flock
