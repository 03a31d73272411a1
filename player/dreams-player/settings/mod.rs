//! The player's config, its command line, and the types of their values.
//!
//! Owns every key and option. Never acts on one.
//!
//! Start at [`Options`].

mod choices;
mod config;
mod options;

pub(crate) use choices::{Clock, ScreenChoice, StatusAddress};
pub(crate) use config::Config;
pub(crate) use options::Options;
