//! Claims about the whole system, tried on the real programs.

mod bad_clips;
mod cadence;
mod clips;
mod command_line;
mod flocks;
mod guest;
mod hot_plug;
mod joins;
mod playing;
mod programs;
mod resume;
mod status_page;
mod trace;
