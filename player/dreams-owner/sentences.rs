//! The notices about the owner's file and about settings on a stick: what is wrong in them, and how it is put right.
//!
//! Owns those sentences. A notice has little room: each says what is expected, and repeats no value, which may be long or a
//! secret. `config/dreams.toml` explains the keys.

use crate::from_stick::Fatal;
use bundle::{Refusal, few};
use diagnostics::did_you_mean;
use settings::ConfigError;
use settings::config_file::Mistake;
use settings::owner::FILE_NAME;
use settings::owners_text::NoText;
use std::io::ErrorKind;

/// How each key is set.
const FORMS: [(&str, &str); 35] = [
    ("acknowledge", "true or false"),
    ("address", "as \"192.0.2.7/24\""),
    ("authorities", "certificates in PEM, in \"\"\""),
    ("brightness", "1 to 100, or as \"07:00 100, 20:00 40\""),
    ("button", "\"any\", or a path below \"/dev/input\""),
    ("button_down", "one key, as \"KEY_DOWN\""),
    ("button_up", "\"any\", or one key, as \"KEY_UP\""),
    ("closed", "days, as [\"Mon\", \"2026-12-24\"]"),
    ("connector", "as \"HDMI-A-1\""),
    ("dns", "addresses, as [\"192.0.2.53\"]"),
    ("gateway", "an address, as \"192.0.2.1\""),
    ("hours", "as \"Tue-Sun 08:00-23:00\""),
    ("keys", "lines of NAME.pub, as [\"RWQy...\"]"),
    ("margin", "0 to 20"),
    ("mode", "as \"1920x1080@60\""),
    ("night", "\"off\", \"black\", \"ddc\" or \"cec\""),
    ("ntp", "names or addresses of servers, in []"),
    ("presence", "a path below \"/dev/input\""),
    ("proxy", "as \"http://proxy.example.org:3128\""),
    ("range", "\"auto\", \"full\" or \"limited\""),
    ("report_every", "5 to 10080 minutes"),
    ("report_picture", "true or false"),
    ("report_to", "as \"https://example.org/units\""),
    ("report_votes", "true or false"),
    ("rotate", "0, 90, 180 or 270"),
    ("timezone", "as \"Europe/Zurich\""),
    ("unit", "1 to 64 of a-z 0-9 . _ -, in \"\""),
    ("url", "as \"https://example.org/flocks\""),
    ("vote_noise", "true or false"),
    ("wifi", "its name in \"\", 32 bytes at most"),
    ("wifi_authorities", "PEM, in \"\"\""),
    ("wifi_country", "two capitals, as \"CH\""),
    ("wifi_identity", "the name of the user, in \"\""),
    ("wifi_password", "8 to 63 English letters or signs in \"\""),
    ("wifi_server", "as \"radius.example.org\""),
];
/// Letters of a key that is not known.
const KEY: usize = 24;
/// What follows each of them.
const STAYS: &str = "The settings before it stay.";

/// What is said of settings on a stick when the owner's partition has them.
pub(crate) const IN_USE: &str = "New settings are in use. You may remove the stick.";
/// What is said of those that the unit has had.
pub(crate) const KNOWN: &str = "This frame has had these settings already. You may remove the stick.";
/// What is said if the data disk does not take settings.
pub(crate) const NO_MEMORY: &str = "The memory of this frame does not take the settings. The picture goes on.";
/// What is said if the owner's partition does not take them.
pub(crate) const NO_PARTITION: &str =
    "The owner's partition does not take the new settings. The settings before it stay.";
const AGAIN: &str = "The stick could not be read to its end. Put it in again.";

/// Why settings on a stick are not taken.
pub(crate) fn of_stick(fatal: &Fatal) -> String {
    match fatal {
        Fatal::Config(_) | Fatal::Host(_) | Fatal::Keys(_) | Fatal::Nameless(_) => {
            "This frame is not set up to take settings from a stick.".to_owned()
        }
        Fatal::ForOthers { units, unit } => format!("These settings are for {}. This frame is {unit}.", few(units)),
        Fatal::Inbox { .. } | Fatal::Store(_) => NO_MEMORY.to_owned(),
        Fatal::Malformed(error) => of_settings(error),
        Fatal::NoText(found) => of_no_text(*found),
        Fatal::Older { sequence, last, .. } => {
            format!("These settings are number {sequence}. This frame has already had number {last}.")
        }
        Fatal::Refused(refused) => of_refused(refused),
        Fatal::Stick(_) => AGAIN.to_owned(),
    }
}

fn of_refused(refused: &Refusal) -> String {
    match refused {
        Refusal::ForOthers { addressees, unit } => {
            format!("These settings are for {}. This frame is {unit}.", addressees.summary())
        }
        Refusal::Read { .. } => AGAIN.to_owned(),
        Refusal::Forged { .. }
        | Refusal::NotSigned { .. }
        | Refusal::RevokedKey { .. }
        | Refusal::UnknownKey { .. } => "These settings are not signed by a key of this frame.".to_owned(),
        Refusal::Damaged { .. }
        | Refusal::ForEverybody { .. }
        | Refusal::Length { .. }
        | Refusal::Line { .. }
        | Refusal::MarkedBad { .. }
        | Refusal::MissingFile { .. }
        | Refusal::Name { .. }
        | Refusal::NotAFlock { .. }
        | Refusal::Older { .. }
        | Refusal::Order { .. }
        | Refusal::Quota { .. }
        | Refusal::TooLarge { .. }
        | Refusal::TooMany { .. }
        | Refusal::Withheld { .. } => "These settings are damaged, or were made wrongly.".to_owned(),
    }
}

/// What is wrong with the settings in the file.
pub(crate) fn of_settings(error: &ConfigError) -> String {
    match error {
        ConfigError::Malformed { line, key, mistake, .. } => {
            format!("{FILE_NAME} line {line}: {} {STAYS}", of_line(key, *mistake))
        }
        ConfigError::Read { source, .. } if source.kind() == ErrorKind::FileTooLarge => {
            format!("{FILE_NAME} has more than 64 KiB. {STAYS}")
        }
        ConfigError::Read { .. } => format!("{FILE_NAME} cannot be read. {STAYS}"),
    }
}

/// What the file has instead of text.
pub(crate) fn of_no_text(found: NoText) -> String {
    match found {
        NoText::Empty => format!("{FILE_NAME} is empty. {STAYS}"),
        NoText::NotUtf8 { line } => {
            format!("{FILE_NAME} line {line} has characters that are not UTF-8. Save it as UTF-8. {STAYS}")
        }
        NoText::Utf16 => format!("{FILE_NAME} is saved as UTF-16. Save it as UTF-8. {STAYS}"),
    }
}

/// A file of another name, instead of ours or beside it.
pub(crate) fn of_misnamed(name: &str, is_beside: bool) -> String {
    if is_beside {
        format!("{FILE_NAME} is read, {name} beside it is not. Keep one, as {FILE_NAME}.")
    } else {
        format!("{name} is not read. Rename it to {FILE_NAME}. {STAYS}")
    }
}

fn of_line(key: &str, mistake: Mistake) -> String {
    let form = FORMS.iter().find(|(known, _)| *known == key).map(|(_, form)| form);
    match (mistake, form) {
        (Mistake::Alone { needs }, _) => format!("{key} is set without {needs}."),
        (Mistake::Twice, _) => format!("{key} is set twice."),
        (Mistake::Value, Some(form)) => format!("{key} is {form}."),
        (Mistake::Value, None) if key.is_empty() => "it is not of the form key = value.".to_owned(),
        (Mistake::Value, None) | (Mistake::Unknown, _) => {
            let short: String = key.chars().take(KEY).collect();
            let similar = did_you_mean(key, FORMS.iter().map(|(known, _)| *known));
            let question =
                similar.map(|question| format!(" {}", capital(&question.replace('`', "")))).unwrap_or_default();
            format!("unknown key {short}.{question}")
        }
    }
}

/// A question that begins a sentence.
fn capital(question: &str) -> String {
    let mut letters = question.chars();
    letters.next().map(|first| first.to_uppercase().chain(letters).collect()).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::{
        AGAIN, FORMS, IN_USE, KNOWN, NO_MEMORY, NO_PARTITION, of_line, of_misnamed, of_no_text, of_refused,
        of_settings, of_stick,
    };
    use crate::from_stick::Fatal;
    use bundle::{KeyId, Refusal, Sequence};
    use player::Notice;
    use settings::Owner;
    use settings::config_file::{ConfigError, Mistake};
    use settings::owner::FILE_NAME;
    use settings::owners_text::NoText;
    use std::path::Path;

    const SAMPLE: &str = include_str!("../../config/dreams.toml");

    /// What is said of this text.
    fn told(text: &str) -> String {
        of_settings(&Owner::parse(Path::new(FILE_NAME), text).unwrap_err())
    }

    #[test]
    fn what_is_wrong_is_told_with_what_would_be_right() {
        for (text, said) in [
            ("\nbrightness = 400", "dreams.toml line 2: brightness is 1 to 100, or as \"07:00 100, 20:00 40\"."),
            ("hours = 8:00-23:00", "dreams.toml line 1: hours is as \"Tue-Sun 08:00-23:00\"."),
            ("rotate = 45", "rotate is 0, 90, 180 or 270."),
            ("hour = 1", "line 1: unknown key hour. Did you mean hours?"),
            ("unit = \"lobby\"\nglow = 1", "line 2: unknown key glow. The"),
            ("[picture]\nrotate = 90", "line 1: unknown key picture. The"),
            ("unit = \"a\"\nunit = \"b\"", "line 2: unit is set twice."),
            ("gateway = \"192.0.2.1\"", "line 1: gateway is set without address."),
            ("vote_noise = true", "line 1: vote_noise is set without button or presence."),
            ("unit = \"a\"\nplease be brighter", "line 2: it is not of the form key = value."),
        ] {
            let told = told(text);
            assert!(told.contains(said) && told.ends_with(" The settings before it stay."), "{told}");
        }
        let secret = told("wifi = \"Home\"\nwifi_password = \"velvet\"");
        assert!(secret.contains("wifi_password is 8 to 63 English letters") && !secret.contains("velvet"), "{secret}");
    }

    #[test]
    fn every_key_has_its_form_and_every_sentence_room_on_the_picture() {
        let keys: Vec<_> = FORMS.iter().map(|(key, _)| *key).collect();
        let mut explained: Vec<_> =
            SAMPLE.lines().filter_map(|line| line.strip_prefix("# ")?.split_once(" = ")).collect();
        explained.retain(|(key, _)| key.bytes().all(|byte| byte.is_ascii_lowercase() || byte == b'_'));
        let mut wanted: Vec<_> = explained.iter().map(|(key, _)| *key).collect();
        wanted.sort_unstable();
        assert_eq!(keys, wanted);
        let of = |key: &str, mistake| {
            let (path, key) = (FILE_NAME.into(), key.to_owned());
            of_settings(&ConfigError::Malformed { path, line: 9_999, key, message: String::new(), mistake })
        };
        let values = keys.iter().map(|key| of(key, Mistake::Value));
        let unknown = ["a".repeat(90), "wifi_passwords".to_owned(), "button_dow".to_owned(), "report_".to_owned()];
        let others = unknown.iter().map(|key| of(key, Mistake::Unknown));
        let signer = KeyId::parse("7F6F7B501F4A54A9").unwrap();
        let alone = Mistake::Alone { needs: "button or presence" };
        let rest = [
            of("vote_noise", alone),
            of("report_votes", Mistake::Twice),
            of("", Mistake::Value),
            of_no_text(NoText::Empty),
            of_no_text(NoText::NotUtf8 { line: 9_999 }),
            of_no_text(NoText::Utf16),
            of_misnamed("Dreams.toml.TXT", true),
            of_misnamed("Dreams.toml.TXT", false),
            IN_USE.to_owned(),
            KNOWN.to_owned(),
            NO_MEMORY.to_owned(),
            NO_PARTITION.to_owned(),
            AGAIN.to_owned(),
        ];
        let refused = Refusal::MarkedBad { sequence: Sequence(9_999) };
        let older = Fatal::Older { sequence: Sequence(9_998), last: Sequence(9_999), signer };
        let rest = rest.into_iter().chain([of_refused(&refused), of_stick(&older)]);
        // A suggestion for a long key has smaller letters on a small display.
        let sized = others.map(|text| (text, Notice::LINE));
        for (text, line) in values.chain(rest).map(|text| (text, Notice::LARGE_LINE)).chain(sized) {
            let told = Notice { text: text.clone(), thousandths: None }.lines(line);
            assert_eq!(told.join(" "), text, "{told:?}");
            assert!(text.is_ascii(), "{text}");
        }
        assert!(of_line("unit", Mistake::Value).contains("a-z"));
    }
}
