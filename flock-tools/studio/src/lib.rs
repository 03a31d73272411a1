//! `dreams studio DIR`: a page in the browser that does what the commands do, and shows pictures.
//!
//! Owns the server on this machine, its page, the document that is edited, and the jobs. Every change of the manifest goes
//! through `flock::Edit`, as with the commands.
//!
//! A folder sees only folders above it in this table; `tests/it/house/folders.rs` holds that.
//!
//! | folder | what is there |
//! |---|---|
//! | `lock.rs` | the value behind a mutex |
//! | `answer.rs` | how a request is read, and answered with JSON or a sentence |
//! | `page.rs` | the files of the page |
//! | `connections.rs` | which connections are held, and which one makes room |
//! | `server.rs` | the sockets, and how long a request may take |
//! | `fence` | which requests are let in, and the headers of every answer |
//! | `events` | the stream of events, and what a page has missed |
//! | `jobs` | the queue: order, progress, pause, cancel, and what is left after a restart |
//! | `document` | the manifest with its revisions, undo, marks and notes |
//! | `breeding` | the children of a brood, the record of all broods, the snow globe |
//! | `media` | strips, fragments, packets, previews, and clips that are rendered |
//! | `store` | what is read from the disk, and kept in `.studio` |
//! | `views` | what the page is told: the state, figures, balances, the walk, the family tree, what may leave |
//! | `workshop` | what all requests share, and what they read of it |
//! | `requests.rs` | what pages ask |
//! | `work` | what the queue runs: clips, previews, broods, checks, commands |
//! | `routes` | which request is answered by what |
//! | `command.rs` | the options, and what starts and ends with the studio |
//!
//! Start at [`run`].
#![forbid(unsafe_code)]

mod answer;
mod breeding;
mod command;
mod connections;
mod document;
mod events;
mod fence;
mod jobs;
mod lock;
mod media;
mod page;
mod requests;
mod routes;
mod server;
mod store;
mod views;
mod work;
mod workshop;

pub use command::{Args, run};
