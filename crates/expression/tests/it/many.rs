//! How much chance is tried: a little every day, more where the environment says so.

/// The number in the variable `name`, or `usual`.
pub(crate) fn many(name: &str, usual: u64) -> u64 {
    std::env::var(name).ok().and_then(|number| number.parse().ok()).unwrap_or(usual)
}
