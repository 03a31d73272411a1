//! What the artist's commands and the studio both do, as plain functions.
//!
//! Owns how a flock's folder, its genomes, clips, joins and credits are read and changed, how clips are rendered, and how a
//! program of the artist's prints and ends. Knows no command line and no page.
//!
//! A folder sees only folders above it in this table; `tests/it/house/folders.rs` holds that.
//!
//! | folder | what is there |
//! |---|---|
//! | `program` | what every command needs: exit codes, printing, progress bars, contact sheets, the clock |
//! | `flock_folder` | a flock's folder: its manifest, read and edited; the paths and contents of its files |
//! | `species` | the one list of the species, and genomes read from files |
//! | `credits` | who made what, and under which licences |
//! | `decoder` | what is asked of ffmpeg, and which program has it |
//! | `joins` | which clips meet, and how well |
//! | `check` | the faults of graph, clips and joins |
//! | `render` | clips from genomes: which are missing, their plans, the work, their cost |
//! | `breeding` | pools, opened, and how the candidates of a brood are made and looked at |
//! | `portrait` | how sheep are drawn: their places in a graph, their pictures and colours |
//!
//! Start at [`program::Fatal`] and at [`flock_folder::open`].
#![forbid(unsafe_code)]
#![allow(clippy::missing_errors_doc, reason = "a `Fatal` ends a program; what else fails is said in a line")]
#![allow(clippy::missing_panics_doc, reason = "a panic is our bug, never a reaction to what is given")]

pub mod breeding;
pub mod check;
pub mod credits;
pub mod decoder;
pub mod flock_folder;
pub mod joins;
pub mod portrait;
pub mod program;
pub mod render;
pub mod species;
