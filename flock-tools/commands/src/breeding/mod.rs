//! The commands on pools, in which sheep are bred.
//!
//! Owns the commands. How a pool is opened, and how its candidates are made and looked at, is in `operations`.
//!
//! | file | what is there |
//! |---|---|
//! | `pool.rs`, `add.rs`, `check.rs` | `dreams pool`: new pools, their sheep, the artist's marks, merging; genomes from elsewhere; faults |
//! | `breed.rs` | `dreams breed`: a brood |
//! | `votes.rs` | `dreams votes`: what units report |
//! | `family.rs` | `dreams family`: ancestors and children of a sheep |
//! | `elect.rs`, `edition.rs` | `dreams elect`: a flock from a pool, and its transitions |
//! | `sheet.rs` | a contact sheet of sheep |

mod add;
pub mod breed;
mod check;
mod edition;
pub mod elect;
pub mod family;
pub mod pool;
mod sheet;
pub mod votes;
