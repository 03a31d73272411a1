//! What a unit remembers of a newer system that it has left.
//!
//! Owns when the file changes, and that people get one notice of each system that was left, not one of each start. The
//! file goes when that system, or a newer one, runs. Never decides whether a system was left: `plan.rs` does.
//!
//! Start at [`remember`].

use bundle::Version;
use diagnostics::chain;
use player::{Notice, Rollback};
use std::fs;
use std::path::Path;
use tracing::warn;

/// Remembers in the file `path` that the `running` system runs because another one was `left`, and says so once on the
/// picture, through the file `notice`. That it cannot be remembered stops nothing.
pub(crate) fn remember(left: Option<&Rollback>, running: &Version, path: &Path, notice: Option<&Path>) {
    let known = Rollback::read(path);
    let changed = match left {
        Some(left) if known.as_ref().is_none_or(|known| known.from != left.from) => left.write(path).inspect(|()| {
            warn!(from = left.from, running = %running, why = left.why, "a newer system was left");
            show(left, running, notice);
        }),
        None if known.is_some_and(|known| Version::parse(&known.from).is_ok_and(|from| from <= *running)) => {
            fs::remove_file(path)
        }
        Some(_) | None => Ok(()),
    };
    if let Err(error) = changed {
        warn!(path = %path.display(), error = chain(&error), "cannot remember which system was left");
    }
}

fn show(left: &Rollback, running: &Version, notice: Option<&Path>) {
    let Some(path) = notice else { return };
    if let Err(error) = said(left, running).tell(path) {
        warn!(error = chain(&error), "cannot write the notice");
    }
}

fn said(left: &Rollback, running: &Version) -> Notice {
    Notice { text: format!("{} {running} runs again.", left.why), thousandths: None }
}

#[cfg(test)]
mod tests {
    use super::said;
    use crate::plan::{Why, why};
    use bundle::Version;
    use player::{Notice, Rollback};

    #[test]
    fn each_reason_has_room_in_large_letters() {
        let [new, old] = ["2026.12.1", "2026.11.9"].map(|text| Version::parse(text).unwrap());
        for reason in [Why::Damaged, Why::GaveWay, Why::Starts(3)] {
            let notice = said(&Rollback { from: new.to_string(), why: why(&new, reason) }, &old);
            assert_eq!(notice.lines(Notice::LARGE_LINE).join(" "), notice.text);
        }
    }
}
