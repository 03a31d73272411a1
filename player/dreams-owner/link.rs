//! The state of a Wi-Fi connection, and when a notice is due.
//!
//! Owns one pure state machine over the events of `wpa_supplicant`. An access point that goes and comes causes no notice:
//! only what the owner can mend does. Never connects to `wpa_supplicant`: `supplicant.rs` does.
//!
//! Start at [`Link::on`]; the table of it is its test.

use std::time::Duration;
use timing::Nanos;

/// How long a Wi-Fi that was never joined may be out of reach until its name is held to be wrong. An access point that
/// comes up together with the unit takes a few minutes.
const PATIENCE: Duration = Duration::from_mins(5);
/// So many refusals in a row are needed where the same password was taken before: a weak signal looks the same.
const DOUBT: u32 = 4;

/// An event of `wpa_supplicant`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Event {
    /// The unit is in the Wi-Fi.
    Joined,
    /// The access point is there, and does not accept the password, or the user with it.
    Refused,
    /// No authority of the owner's vouches for the server of a network with IEEE 802.1X.
    Unvouched,
    /// No access point of this name is there.
    Unseen,
}

/// What is to be done.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Effect {
    Nothing,
    /// Nothing is wrong any more; and these settings are known to be good.
    TakeBack,
    /// Tell that the name is wrong.
    TellName,
    /// Tell that the password is wrong.
    TellPassword,
    /// Say that no authority vouches for the server.
    TellServer,
}

/// What is known of the Wi-Fi, since its settings are these.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Link {
    /// It was not joined yet; out of reach since then, if it was looked for.
    New { unseen_since: Option<Nanos> },
    /// It was joined, now or in a life before; so often it refused since.
    Known { refused: u32 },
    /// The notice says that it refuses its password.
    WrongPassword,
    /// The notice says that nothing of this name is there.
    WrongName,
    /// The notice says that no authority vouches for the server.
    WrongServer,
}

impl Link {
    /// What is known, and to be done, after `event` at `now`.
    pub(super) fn on(self, event: Event, now: Nanos) -> (Self, Effect) {
        match (self, event) {
            (_, Event::Joined) => (Self::Known { refused: 0 }, Effect::TakeBack),
            (Self::New { .. } | Self::WrongName, Event::Refused) => (Self::WrongPassword, Effect::TellPassword),
            (Self::Known { refused }, Event::Refused) if refused + 1 >= DOUBT => {
                (Self::WrongPassword, Effect::TellPassword)
            }
            (Self::New { .. } | Self::Known { .. } | Self::WrongName | Self::WrongPassword, Event::Unvouched) => {
                (Self::WrongServer, Effect::TellServer)
            }
            (Self::Known { refused }, Event::Refused) => (Self::Known { refused: refused + 1 }, Effect::Nothing),
            (Self::New { unseen_since: None }, Event::Unseen) => {
                (Self::New { unseen_since: Some(now) }, Effect::Nothing)
            }
            (Self::New { unseen_since: Some(since) }, Event::Unseen)
                if u128::from(now.since(since)) >= PATIENCE.as_nanos() =>
            {
                (Self::WrongName, Effect::TellName)
            }
            // What was told stays until it is joined: an access point may be off while it is mended.
            (Self::New { .. } | Self::Known { .. } | Self::WrongName, Event::Unseen)
            | (Self::WrongPassword, Event::Refused | Event::Unseen)
            // `wpa_supplicant` counts a server that is not vouched for as a refusal, too.
            | (Self::WrongServer, Event::Unvouched | Event::Refused | Event::Unseen) => (self, Effect::Nothing),
        }
    }
}

/// The event in a line of `wpa_supplicant`, if it matters here.
pub(super) fn event(line: &str) -> Option<Event> {
    let told = line.split_once('>').map_or(line, |(_level, told)| told);
    let mut words = told.split_whitespace();
    match words.next()? {
        "CTRL-EVENT-CONNECTED" => Some(Event::Joined),
        "CTRL-EVENT-NETWORK-NOT-FOUND" => Some(Event::Unseen),
        // The name of the network stands in between, and is a stranger's. AUTH_FAILED is of networks with users.
        "CTRL-EVENT-SSID-TEMP-DISABLED" => {
            ["reason=WRONG_KEY", "reason=AUTH_FAILED"].contains(&words.next_back()?).then_some(Event::Refused)
        }
        "CTRL-EVENT-EAP-TLS-CERT-ERROR" => Some(Event::Unvouched),
        // By WPA3: the second step of its authentication confirms the password. Access points refuse it as "challenge
        // failure" (15), `hostapd` 2.10 as "unspecified" (1).
        "CTRL-EVENT-AUTH-REJECT" => {
            let words: Vec<_> = words.collect();
            ["auth_type=3", "auth_transaction=2"].iter().all(|word| words.contains(word)).then_some(Event::Refused)
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::{DOUBT, Effect, Event, Link, PATIENCE, event};
    use timing::Nanos;

    const NOW: Nanos = Nanos(1);

    /// What people are told after each of these.
    fn told(mut link: Link, events: &[Event], now: Nanos) -> Vec<Effect> {
        let mut effects = Vec::new();
        for event in events {
            let (next, effect) = link.on(*event, now);
            link = next;
            effects.push(effect);
        }
        effects
    }

    #[test]
    fn a_wrong_password_is_told_at_once_where_none_was_right_and_after_some_doubt_where_one_was() {
        let new = Link::New { unseen_since: None };
        assert_eq!(told(new, &[Event::Refused; 2], NOW), [Effect::TellPassword, Effect::Nothing]);
        let refused = [Event::Refused; DOUBT as usize];
        let mut wanted = vec![Effect::Nothing; DOUBT as usize - 1];
        wanted.push(Effect::TellPassword);
        assert_eq!(told(Link::Known { refused: 0 }, &refused, NOW), wanted);
        let between = [&refused[1..], &[Event::Joined], &refused[1..]].concat();
        assert!(!told(Link::Known { refused: 0 }, &between, NOW).contains(&Effect::TellPassword));
    }

    #[test]
    fn a_server_without_an_authority_is_named_and_no_password_is_blamed() {
        let failed = [Event::Unvouched, Event::Refused];
        let new = Link::New { unseen_since: None };
        assert_eq!(told(new, &failed, NOW), [Effect::TellServer, Effect::Nothing]);
        assert_eq!(told(Link::WrongPassword, &failed, NOW), [Effect::TellServer, Effect::Nothing]);
        assert_eq!(told(Link::Known { refused: 0 }, &failed, NOW), [Effect::TellServer, Effect::Nothing]);
        let vouched = [Event::Unvouched, Event::Joined];
        assert_eq!(told(new, &vouched, NOW), [Effect::TellServer, Effect::TakeBack]);
    }

    #[test]
    fn an_access_point_that_goes_and_comes_is_not_told() {
        let comes_and_goes = [Event::Joined, Event::Unseen, Event::Unseen, Event::Joined];
        let effects = told(Link::New { unseen_since: None }, &comes_and_goes, NOW);
        assert_eq!(effects, [Effect::TakeBack, Effect::Nothing, Effect::Nothing, Effect::TakeBack]);
        let (known, _) = Link::Known { refused: 0 }.on(Event::Unseen, NOW);
        assert_eq!(known.on(Event::Unseen, Nanos(u64::MAX)).1, Effect::Nothing, "however long");
    }

    #[test]
    fn a_name_that_was_never_seen_is_told_after_a_while_and_until_it_is_joined() {
        let (new, effect) = Link::New { unseen_since: None }.on(Event::Unseen, NOW);
        assert_eq!(effect, Effect::Nothing);
        let late = Nanos(NOW.0 + u64::try_from(PATIENCE.as_nanos()).unwrap());
        assert_eq!(new.on(Event::Unseen, Nanos(late.0 - 1)).1, Effect::Nothing);
        let (wrong, effect) = new.on(Event::Unseen, late);
        assert_eq!((wrong, effect), (Link::WrongName, Effect::TellName));
        assert_eq!(told(wrong, &[Event::Unseen, Event::Joined], late), [Effect::Nothing, Effect::TakeBack]);
        assert_eq!(told(wrong, &[Event::Refused], late), [Effect::TellPassword], "the name is right");
    }

    #[test]
    fn what_wpa_supplicant_tells_is_understood_whatever_a_network_is_called() {
        for (line, wanted) in [
            ("<3>CTRL-EVENT-CONNECTED - Connection to 02:00:00:00:01:00 completed [id=0 id_str=]", Some(Event::Joined)),
            ("<3>CTRL-EVENT-NETWORK-NOT-FOUND ", Some(Event::Unseen)),
            (
                "<3>CTRL-EVENT-SSID-TEMP-DISABLED id=0 ssid=\"a b\" auth_failures=1 duration=10 reason=WRONG_KEY",
                Some(Event::Refused),
            ),
            (
                "<3>CTRL-EVENT-SSID-TEMP-DISABLED id=0 ssid=\"reason=WRONG_KEY\" auth_failures=1 reason=CONN_FAILED",
                None,
            ),
            (
                "<3>CTRL-EVENT-AUTH-REJECT 02:00:00:00:01:00 auth_type=3 auth_transaction=2 status_code=15",
                Some(Event::Refused),
            ),
            (
                "<3>CTRL-EVENT-AUTH-REJECT 02:00:00:00:01:00 auth_type=3 auth_transaction=2 status_code=1",
                Some(Event::Refused),
            ),
            ("<3>CTRL-EVENT-AUTH-REJECT 02:00:00:00:01:00 auth_type=3 auth_transaction=1 status_code=77", None),
            ("<3>CTRL-EVENT-AUTH-REJECT 02:00:00:00:01:00 auth_type=0 auth_transaction=2 status_code=1", None),
            (
                "<3>CTRL-EVENT-SSID-TEMP-DISABLED id=0 ssid=\"a\" auth_failures=1 duration=10 reason=AUTH_FAILED",
                Some(Event::Refused),
            ),
            (
                "<3>CTRL-EVENT-EAP-TLS-CERT-ERROR reason=1 depth=0 subject='/CN=a' err='unable to get local issuer'",
                Some(Event::Unvouched),
            ),
            ("<3>CTRL-EVENT-SCAN-STARTED ", None),
            ("OK", None),
            ("", None),
        ] {
            assert_eq!(event(line), wanted, "{line}");
        }
    }
}
