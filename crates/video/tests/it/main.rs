//! Claims about the fence around ffmpeg, on clips made on the spot.
//!
//! Owns the claims that need whole clips; what one module promises by itself is tested beside it.
//!
//! Next: `joins.rs` (every frame, once, in order), `damage.rs` (bad clips), `encoding.rs` (the form).
#![expect(clippy::unwrap_used, clippy::panic, reason = "a test stops at the first surprise")]

mod clips;
mod damage;
mod encoding;
mod foreign;
mod fragments;
mod joins;
