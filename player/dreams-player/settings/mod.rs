//! What the player is told: the config, the command line, and the settings that both have.
//!
//! Owns every key and option. Never acts on one.
//!
//! Start at [`options::Options`].

pub(crate) mod choices;
pub(crate) mod config;
pub(crate) mod options;
