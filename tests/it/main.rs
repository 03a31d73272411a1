//! Claims about the whole system, tried on the real programs.
#![forbid(unsafe_code)]
#![allow(clippy::unwrap_used, clippy::panic, reason = "a claim fails by panicking")]

mod bad_clips;
mod balancing;
mod beside;
mod broken_updates;
mod bundles;
mod cadence;
mod changing;
mod clips;
mod command_line;
mod crashes;
mod curating;
mod far_away;
mod fetching;
mod flocks;
mod forms;
mod glass;
mod guest;
mod hot_plug;
mod house;
mod importing;
mod joins;
mod last_resort;
mod manual;
mod night;
mod owning;
mod playing;
mod prelude;
mod programs;
mod publishing;
mod pulling;
mod rendering;
mod reporting;
mod resume;
mod sending;
mod shortage;
mod status_page;
mod stills;
mod systems;
mod telling;
mod trace;
mod tutorial;
mod unit;
mod updating;
mod watching_over;
