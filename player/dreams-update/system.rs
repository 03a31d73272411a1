//! A new system for this unit, from a source into the store.
//!
//! Owns which units take systems at all: those whose own system is one of ours. What may come, the store decides; what
//! came lies there, staged, until `slot.rs` writes it.
//!
//! Start at [`take`].

use crate::answer::SystemOutcome;
use crate::fatal::Fatal;
use crate::fetch::Fetcher;
use crate::options::Order;
use crate::statements;
use bundle::{Store, System, SystemAdmission, UnverifiedSystem, Version};
use diagnostics::chain;
use player::now;
use std::fs;
use std::path::Path;
use tracing::{info, warn};

/// What a system of ours calls itself.
const OURS: &str = "dreams";

/// Fetches the system that the source has for this unit, if it is new.
/// Errors: [`Fatal`]. What has arrived stays.
pub(crate) fn take(order: &Order, store: &mut Store, fetcher: &mut Fetcher<'_>) -> Result<SystemOutcome, Fatal> {
    let Some(running) = running(&order.config.system) else { return Ok(SystemOutcome::None) };
    let found = UnverifiedSystem::open(fetcher.source, &order.unit).map_err(Fatal::Refused)?;
    let Some(unverified) = found else { return Ok(SystemOutcome::None) };
    let verify = |store: &Store| unverified.clone().verify(&store.system_trust());
    let system = statements::heeded(store, fetcher.source, verify, System::expected_statements)?;
    if store.admit_system(&system, &order.unit, &running, order.consent)? == SystemAdmission::Known {
        return Ok(SystemOutcome::NoNews);
    }
    let (version, signer) = (system.release().version.clone(), system.signer());
    info!(%version, %signer, "fetching a system");
    let mut plan = store.plan_system(&system)?;
    let reserve = order.config.reserve_mib << 20;
    if plan.shortfall(store.free_bytes()?, reserve).is_some() {
        if let Err(error) = store.collect(None) {
            warn!(error = chain(&error), "cannot remove unused objects from the store");
        }
        plan = store.plan_system(&system)?;
    }
    if let Some(shortfall) = plan.shortfall(store.free_bytes()?, reserve) {
        return Err(Fatal::Room(shortfall));
    }
    fetcher.progress.is_of_a_system();
    fetcher.progress.begins(plan.bytes, plan.bytes - plan.to_fetch(), now());
    plan.wanted.iter().try_for_each(|wanted| fetcher.fetch(store, wanted))?;
    store.stage(&system)?;
    info!(%version, "system fetched");
    Ok(SystemOutcome::Staged(version))
}

/// The version of the system that runs, as the file `path` says; `None` if it is none of ours.
pub(crate) fn running(path: &Path) -> Option<Version> {
    let text = fs::read_to_string(path).ok()?;
    let says = |key: &str| text.lines().find_map(|line| line.strip_prefix(key)).map(|value| value.trim_matches('"'));
    says("ID=").filter(|id| *id == OURS)?;
    Version::parse(says("VERSION_ID=")?).ok()
}

#[cfg(test)]
mod tests {
    use super::running;
    use std::fs;

    #[test]
    fn a_system_of_somebody_else_is_not_ours_to_look_after() {
        let folder = tempfile::tempdir().unwrap();
        let says = |text: &str| {
            let path = folder.path().join("os-release");
            fs::write(&path, text).unwrap();
            running(&path).map(|version| version.to_string())
        };
        assert_eq!(says("ID=dreams\nNAME=\"Dreams\"\nVERSION_ID=0.1.0\n").as_deref(), Some("0.1.0"));
        assert_eq!(says("ID=debian\nVERSION_ID=\"13\"\n"), None);
        assert_eq!(says("ID=dreams\n"), None);
        assert_eq!(running(&folder.path().join("missing")), None);
    }
}
