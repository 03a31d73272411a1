//! Whole-system claims live in `it/`: this package only gives them a home.
#![forbid(unsafe_code)]
