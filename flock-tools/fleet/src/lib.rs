//! `dreams fleet FOLDER`: what all units report, on one page.
//!
//! Owns the server that receives status reports, the folder that keeps the newest of each unit, the rules by which
//! something is wrong with a unit, and what shows it: a table, a page, metrics, alarms. Reports are unsigned and come from
//! any network: each field of one is untrusted. Never changes a unit.
//!
//! A folder sees only folders above it in this table; `tests/it/house/folders.rs` holds that.
//!
//! | folder | what is there |
//! |---|---|
//! | `picture.rs` | whether bytes are a small JPEG |
//! | `facts.rs` | what is read of a report |
//! | `finding.rs` | what is wrong with a unit, and what to do |
//! | `record.rs` | the newest report of a unit with its times, and what is shown of it |
//! | `folder.rs` | the folder of reports |
//! | `alarm.rs` | which alarms are due |
//! | `desk.rs` | takes reports, and knows the newest of each unit |
//! | `webhook.rs` | sends alarms |
//! | `table.rs` | the units as lines of text |
//! | `page` | the page |
//! | `metrics.rs` | the units as `OpenMetrics` text |
//! | `doors.rs` | which requests are let in |
//! | `server.rs` | receives reports, and answers with page, metrics and JSON |
//! | `command.rs` | the options, and how the command ends |
//!
//! Start at [`run`].
#![forbid(unsafe_code)]

mod alarm;
mod command;
mod desk;
mod doors;
mod facts;
mod finding;
mod folder;
mod metrics;
mod page;
mod picture;
mod record;
mod server;
mod table;
mod webhook;

pub use command::{Args, run};
