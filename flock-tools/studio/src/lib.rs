//! `dreams studio DIR`: a page in the browser that does what the commands do, and shows pictures.
//!
//! Owns the server on this machine, its page, the document that is edited, and the jobs. Every change of the manifest goes
//! through `flock::Edit`, as with the commands.
//!
//! | where | what is there |
//! |---|---|
//! | `answer.rs` | errors as the page reads them, and bodies of requests |
//! | `page.rs` | the files of the page |
//! | `server.rs` | the sockets, and how long a request may take |
//! | `events` | the stream of events, and what a page has missed |
//! | `fence` | which requests are let in, and the headers of every answer |
//! | `jobs` | the queue: order, progress, pause, cancel, and what is left after a restart |
//! | `document` | the manifest with its revisions, undo, marks and notes |
//! | `workshop.rs`, `looking.rs`, `pictures.rs` | what all requests share, and what they read of it |
//! | `requests.rs`, `answers.rs`, `routes` | what pages ask, how they are answered, and which request by what |
//! | `views` | what the page is told: the state, figures, balances, the walk, the family tree, what may leave |
//! | `store` | what is read from the disk, and kept in `.studio` |
//! | `breeding` | broods and the snow globe |
//! | `work` | what the queue runs: clips, checks, commands |
//! | `media` | strips, fragments, packets, previews, and clips that are rendered |
//!
//! Start at [`run`].
#![forbid(unsafe_code)]

mod answer;
mod answers;
mod breeding;
mod command;
mod document;
mod events;
mod fence;
mod jobs;
mod looking;
mod media;
mod page;
mod pictures;
mod requests;
mod routes;
mod server;
mod store;
mod views;
mod work;
mod workshop;

pub use command::{Args, run};
