//! The notices of the updater: one plain sentence, or two.
//!
//! Owns those sentences. They name no digest and no key: these are in the log. A file
//! system is named only where the stick has to be formatted anew.

use crate::answer::{Outcome, SystemOutcome};
use crate::astray::Astray;
use crate::fatal::Fatal;
use bundle::{Refusal, StoreError, few};

/// While a flock is coming in.
pub(crate) const COMING: &str = "A new flock is coming in.";
/// While a system is coming in.
pub(crate) const SYSTEM_COMING: &str = "A new system is coming in.";

/// What to say of an update that ended so; `None` if there is nothing to say.
pub(crate) fn of_answer(outcome: Outcome, system: &SystemOutcome) -> Option<&'static str> {
    match (outcome, system) {
        (_, SystemOutcome::Written(_)) => None,
        (Outcome::Installed, SystemOutcome::Staged(_)) => {
            Some("The new flock is here, and a new system for the next start. You may remove the stick.")
        }
        (_, SystemOutcome::Staged(_)) => Some("A new system is here for the next start. You may remove the stick."),
        (Outcome::Installed, _) => Some("The new flock is here. You may remove the stick."),
        (Outcome::NoNews, _) => Some("This flock is here already. You may remove the stick."),
        (Outcome::NoBundle, SystemOutcome::NoNews) => {
            Some("This frame has had this system already. You may remove the stick.")
        }
        // Whatever it holds, it is not for us.
        (Outcome::NoBundle | Outcome::NotNow, _) => None,
    }
}

/// What is on a stick that has no bundle, and what to do.
pub(crate) fn of_astray(astray: &Astray) -> String {
    match astray {
        Astray::Below(Some(folder)) => {
            format!("The flock is in the folder {folder}. Copy its contents to the top of the stick.")
        }
        Astray::Below(None) => {
            "The flock is in a folder of this stick. Copy its contents to the top of the stick.".to_owned()
        }
        Astray::Unsigned => {
            "This stick has a flock that is not signed. Run dreams pack, then dreams publish.".to_owned()
        }
    }
}

/// What was wrong.
pub(crate) fn of_fatal(fatal: &Fatal) -> String {
    match fatal {
        Fatal::Busy { .. } => "Another update is at work. Please wait.".to_owned(),
        Fatal::ForOthers { units, unit, .. } => {
            format!("This stick is for {}. This frame is {unit}.", few(units))
        }
        Fatal::Format { format } => format!("This stick is formatted as {format}. This frame reads FAT32 and exFAT."),
        Fatal::Read { .. } | Fatal::Source(_) | Fatal::Stopped => AGAIN.to_owned(),
        Fatal::Refused(refused) => of_refused(refused),
        Fatal::Room(shortfall) => {
            let megabytes = shortfall.needed.saturating_sub(shortfall.room).div_ceil(1_000_000);
            format!("There is no room for this flock: {megabytes} MB more are needed.")
        }
        Fatal::Store(StoreError::Damaged { name, .. } | StoreError::TooLong { name, .. }) => {
            format!("This stick is damaged: {name} is not what it should be.")
        }
        Fatal::Store(StoreError::Incomplete { name, .. }) => format!("This stick is damaged: {name} is not whole."),
        Fatal::Slot { .. } => "The new system cannot be written. The picture goes on.".to_owned(),
        Fatal::Store(StoreError::Failing { .. }) => {
            "The memory of this frame cannot be read well. The picture goes on.".to_owned()
        }
        Fatal::Store(_) => "The memory of this frame does not take the flock. The picture goes on.".to_owned(),
        Fatal::Address { .. }
        | Fatal::Config(_)
        | Fatal::Host { .. }
        | Fatal::Keys(_)
        | Fatal::Nameless(_)
        | Fatal::Nowhere
        | Fatal::Signals(_)
        | Fatal::Unwritten(_) => "This frame is not set up to take flocks. The picture goes on.".to_owned(),
    }
}

/// How an update run ended, for the status page.
pub(crate) fn of_look(ended: Result<Outcome, &Fatal>) -> &'static str {
    match ended {
        Ok(Outcome::Installed) => "a new flock came",
        Ok(Outcome::NoNews) => "no news",
        Ok(Outcome::NoBundle) => "nothing for this unit",
        Ok(Outcome::NotNow) => "nothing was looked for",
        Err(Fatal::ForOthers { .. } | Fatal::Refused(Refusal::ForOthers { .. })) => "for other units",
        Err(Fatal::Read { .. } | Fatal::Source(_) | Fatal::Stopped | Fatal::Refused(Refusal::Read { .. })) => {
            "could not be read to its end"
        }
        Err(Fatal::Refused(Refusal::ForEverybody { .. })) => "refused: for every unit, and this one has its own",
        Err(Fatal::Refused(Refusal::Older { .. })) => "refused: older than what was played",
        Err(Fatal::Refused(Refusal::MarkedBad { .. })) => "refused: it was tried before, and did not play",
        Err(Fatal::Refused(_)) => "refused",
        Err(Fatal::Room(_)) => "there is no room for it",
        Err(Fatal::Store(_)) => "damaged, or the disk does not take it",
        Err(_) => "this unit is not set up for it",
    }
}

const AGAIN: &str = "The stick could not be read to its end. Put it in again, and the rest follows.";

fn of_refused(refused: &Refusal) -> String {
    match refused {
        Refusal::ForEverybody { unit } => {
            format!("This stick is for every frame. This frame is {unit}, and takes what is for it by name.")
        }
        Refusal::ForOthers { addressees, unit } => {
            format!("This stick is for {}. This frame is {unit}.", addressees.summary())
        }
        Refusal::MarkedBad { .. } => "This flock was tried here before, and did not play.".to_owned(),
        Refusal::Older { sequence, floor, .. } => {
            format!("This flock is number {sequence}. This frame has already played number {floor}.")
        }
        Refusal::Read { .. } => AGAIN.to_owned(),
        Refusal::Withheld { .. } => {
            "This stick lacks what its artist sent along about keys. Please ask for it again.".to_owned()
        }
        Refusal::Forged { .. }
        | Refusal::NotSigned { .. }
        | Refusal::RevokedKey { .. }
        | Refusal::UnknownKey { .. } => "This flock is not signed by anybody whom this frame trusts.".to_owned(),
        Refusal::Damaged { .. }
        | Refusal::Length { .. }
        | Refusal::Line { .. }
        | Refusal::MissingFile { .. }
        | Refusal::Name { .. }
        | Refusal::NotAFlock { .. }
        | Refusal::Order { .. }
        | Refusal::Quota { .. }
        | Refusal::TooLarge { .. }
        | Refusal::TooMany { .. } => "This flock is damaged, or was made wrongly.".to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::{of_answer, of_astray, of_fatal};
    use crate::answer::{Outcome, SystemOutcome};
    use crate::astray::Astray;
    use crate::fatal::Fatal;
    use crate::stick_format::StickFormat;
    use bundle::{Shortfall, UnitId, Version};
    use clap::ValueEnum;
    use player::Notice;

    #[test]
    fn what_is_said_of_a_stick_made_wrongly_fits_into_large_letters() {
        let below = [None, Some("M".repeat(20))].map(Astray::Below);
        let astray = below.iter().chain([&Astray::Unsigned]).map(of_astray);
        let formats = StickFormat::value_variants().iter().map(|&format| of_fatal(&Fatal::Format { format }));
        for text in astray.chain(formats) {
            let lines = Notice { text: text.clone(), thousandths: None }.lines(Notice::LARGE_LINE);
            assert_eq!(lines.join(" "), text);
        }
    }

    #[test]
    fn people_are_told_in_plain_words() {
        let unit = UnitId::new("lobby").unwrap();
        let others = |units: &[&str]| {
            let units = units.iter().map(|name| UnitId::new(name).unwrap()).collect();
            of_fatal(&Fatal::ForOthers { place: "/media".to_owned(), units, unit: unit.clone() })
        };
        assert_eq!(others(&["attic", "stairs"]), "This stick is for attic, stairs. This frame is lobby.");
        let told = "This stick is for a, b, c and 2 more. This frame is lobby.";
        assert_eq!(others(&["a", "b", "c", "d", "e"]), told);
        let room = Fatal::Room(Shortfall { needed: 5_000_000_001, room: 1_000_000_000 });
        assert_eq!(of_fatal(&room), "There is no room for this flock: 4001 MB more are needed.");
        let nothing = of_answer(Outcome::NoBundle, &SystemOutcome::None);
        assert_eq!(nothing, None, "a stick with holiday photographs is nobody's business");
        let version = Version::parse("0.2.0").unwrap();
        assert!(
            of_answer(Outcome::NoNews, &SystemOutcome::Staged(version)).unwrap().starts_with("A new system is here")
        );
    }
}
