//! Bad clips.
