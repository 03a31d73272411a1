//! The artist's commands: their arguments, their answers, and how they end.
//!
//! Owns what each subcommand of `dreams` takes and prints. What commands and studio both do is in `operations`; the list of
//! subcommands is in `dreams`.
//!
//! A folder sees only folders above it in this table; `tests/it/house/folders.rs` holds that.
//!
//! | folder | what is there |
//! |---|---|
//! | `arguments.rs` | arguments that are sizes, rates and numbers, and those that several commands take |
//! | `ids.rs` | ids of sheep, completed by the shell |
//! | `credits.rs` | `dreams credits` |
//! | `check.rs` | `dreams check`: the faults of graph, clips and joins |
//! | `render` | `dreams render`, `dreams still`: clips and pictures from genomes |
//! | `demo` | `dreams demo` |
//! | `curate` | the commands that edit a flock by hand, and the list of its sheep: `add`, `link`, `want`, `list`, `prune`, ... |
//! | `import` | `dreams import`: clips and genomes from elsewhere |
//! | `walks` | `dreams walk`, `dreams simulate`, `dreams share` |
//! | `balance` | `dreams balance`: weights, and transitions to add or remove |
//! | `breeding` | `dreams pool`, `breed`, `votes`, `family`, `elect`: pools in which sheep are bred, and flocks from them |
//! | `report` | `dreams report`: a flock as one page |
//! | `bundles` | `dreams keygen`, `pack`, `publish`, `settings`, `verify`, `diff`: a flock, a system or settings on their way to units |
//!
//! Start at the module of a command.
#![forbid(unsafe_code)]
#![allow(clippy::missing_errors_doc, reason = "the help of each command says how it ends")]
#![allow(clippy::missing_panics_doc, reason = "a panic is our bug, never a reaction to what is given")]

mod arguments;
pub mod balance;
pub mod breeding;
pub mod bundles;
pub mod check;
pub mod credits;
pub mod curate;
pub mod demo;
mod ids;
pub mod import;
pub mod render;
pub mod report;
pub mod walks;
