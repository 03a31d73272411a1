//! What of the studio knows neither a pixel nor a command.
//!
//! Owns the fence around a server on this machine, the page's files, the stream of events, the document that is edited with
//! its undo and its notes, and the queue of jobs. Never renders, decodes or opens a clip: the tools do, as jobs. Never reads
//! a clock of its own, except for the limits of the network.
//!
//! A folder sees only folders above it in this table; `tests/it/house/folders.rs` holds that.
//!
//! | folder | what is there |
//! |---|---|
//! | `answer.rs` | errors as the page reads them, and bodies of requests |
//! | `page.rs` | the files of the page |
//! | `server.rs` | the sockets, and how long a request may take |
//! | `events` | the stream of events, and what a page has missed |
//! | `fence` | which requests are let in, and the headers of every answer |
//! | `jobs` | the queue: order, progress, pause, cancel, and what is left after a restart |
//! | `document` | the manifest with its revisions, undo, marks and notes |
//!
//! Start at [`server::Server`] for the network, at [`document::Document`] for the flock.
#![forbid(unsafe_code)]

pub mod answer;
pub mod document;
pub mod events;
pub mod fence;
pub mod jobs;
pub mod page;
pub mod server;
