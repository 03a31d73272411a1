//! Claims about bundles and stores, tried through what the crate shows to others.
#![forbid(unsafe_code)]
#![allow(clippy::unwrap_used, clippy::panic, reason = "a claim fails by panicking")]

mod astray;
mod careless;
mod corpus;
mod folders;
mod forgery;
mod installing;
mod model;
mod power;
mod press;
