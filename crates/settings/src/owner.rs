//! What the owner of a unit has set, in one small file that is edited on any computer.
//!
//! Owns [`Owner`], the reading of its file `dreams.toml` and what it means to the network. Every key explains itself in
//! `config/dreams.toml`. Never acts on it: `dreams-owner` takes the file in, the others go by what it kept, which
//! `kept.rs` reads.
//!
//! Start at [`Owner::parse`].

use crate::authorities::Authorities;
use crate::button::{self, ButtonDevice, Key};
use crate::config_file::{ConfigError, Mistake, parse, unit, within};
use crate::hours::{Brightness, Night, Zone};
use crate::week::{Closed, Hours};
use crate::wifi::{self, Country, Password, Wifi};
use bundle::{PublicKey, UnitId};
use screen::{Margin, OutputSettings, RequestedMode, Rotation, SignalRange};
use serde::Deserialize;
use serde::de::{Deserializer, Error as _};
use std::fmt::Display;
use std::net::IpAddr;
use std::ops::RangeInclusive;
use std::path::Path;
use std::str::FromStr;

/// Minutes between two reports.
const REPORT_EVERY: RangeInclusive<u64> = 5..=10_080;
/// What the owner's file is called.
pub const FILE_NAME: &str = "dreams.toml";

/// A setting without the one that it is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Alone {
    /// The setting.
    pub(crate) key: &'static str,
    /// What it is for.
    pub(crate) needs: &'static str,
}

/// What an owner may set. What is not set is as the unit's own configs have it.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Owner {
    /// What the unit is called.
    #[serde(deserialize_with = "unit")]
    pub unit: Option<UnitId>,
    /// Keys that it trusts, besides those of its config.
    #[serde(deserialize_with = "keys")]
    pub keys: Vec<PublicKey>,
    /// Where it looks for flocks.
    #[serde(deserialize_with = "url")]
    pub url: Option<String>,
    /// Through which proxy.
    #[serde(deserialize_with = "url")]
    pub proxy: Option<String>,
    /// Who may vouch for the servers of both.
    pub authorities: Authorities,
    /// When the picture is lit.
    pub hours: Option<Hours>,
    /// On which days it is not.
    pub closed: Closed,
    /// How bright it is.
    pub brightness: Option<Brightness>,
    /// By which local time.
    pub timezone: Option<Zone>,
    /// What the display does when it is not.
    pub night: Option<Night>,
    /// At which connector it is lit.
    pub connector: Option<String>,
    /// In which mode.
    #[serde(deserialize_with = "mode")]
    pub mode: Option<RequestedMode>,
    /// How it is rotated.
    #[serde(deserialize_with = "numbered")]
    pub rotate: Rotation,
    /// With which levels.
    #[serde(deserialize_with = "spelled")]
    pub range: SignalRange,
    /// With which margin.
    #[serde(deserialize_with = "numbered")]
    pub margin: Margin,
    /// Its address on a network by cable, with the length of its prefix; `None` for what DHCP says.
    #[serde(deserialize_with = "address")]
    pub address: Option<(IpAddr, u8)>,
    /// The way out of that network.
    pub gateway: Option<IpAddr>,
    /// Whom it asks for names.
    pub dns: Vec<IpAddr>,
    /// Whom it asks for the time: names or addresses.
    #[serde(deserialize_with = "hosts")]
    pub ntp: Vec<String>,
    /// What its Wi-Fi is called.
    wifi: Option<wifi::Name>,
    /// Its password, or that of the user; `None` for one that is open.
    wifi_password: Option<Password>,
    /// In which country it is.
    wifi_country: Option<Country>,
    /// The name of the user, for a network with IEEE 802.1X.
    wifi_identity: Option<wifi::Identity>,
    /// The authorities that may vouch for the server of that network.
    wifi_authorities: Authorities,
    /// The name of that server.
    wifi_server: Option<wifi::Server>,
    /// The input device with the buttons of those who vote.
    pub button: Option<ButtonDevice>,
    /// The key that is a vote for what is shown.
    pub button_up: Option<Key>,
    /// The key that is a vote against it.
    #[serde(deserialize_with = "button::one")]
    pub button_down: Option<Key>,
    /// The input device that says whether somebody is near.
    #[serde(deserialize_with = "button::at")]
    pub presence: Option<ButtonDevice>,
    /// Whether a mark on the picture acknowledges each press.
    pub acknowledge: Option<bool>,
    /// Whether each total has some noise.
    pub vote_noise: Option<bool>,
    /// Where the unit reports to.
    #[serde(deserialize_with = "url")]
    pub report_to: Option<String>,
    /// How often, in minutes; `None` for after each look for updates.
    #[serde(deserialize_with = "report_every")]
    pub report_every: Option<u64>,
    /// Whether a small picture of what is shown is a part of the report.
    pub report_picture: bool,
    /// Whether the votes are a part of the report.
    pub report_votes: bool,
}

impl Owner {
    /// Reads `text`, which errors say lies at `path`.
    /// Errors: [`ConfigError::Malformed`].
    pub fn parse(path: &Path, text: &str) -> Result<Self, ConfigError> {
        let owner: Self = parse(path, text)?;
        let of = |key: &str, message, mistake| {
            let line = text.lines().position(|line| line.trim_start().starts_with(key)).map_or(1, |line| line + 1);
            ConfigError::Malformed { path: path.to_owned(), line, key: key.to_owned(), message, mistake }
        };
        if let Some(Alone { key, needs }) = owner.alone() {
            let message = format!("it needs `{}`, which is not set", needs.replace(" or ", "` or `"));
            return Err(of(key, message, Mistake::Alone { needs }));
        }
        match &owner.wifi_password {
            Some(password) if owner.wifi_identity.is_none() && !password.is_shared() => {
                Err(of("wifi_password", password.unshared(), Mistake::Value))
            }
            Some(_) | None => Ok(owner),
        }
    }

    /// The first setting without the one that it is for.
    pub(crate) fn alone(&self) -> Option<Alone> {
        let (no_wifi, no_button, no_user) = (self.wifi.is_none(), self.button.is_none(), self.wifi_identity.is_none());
        let no_authority = self.wifi_authorities.certificates().is_empty();
        let settings = [
            ("gateway", self.gateway.is_some() && self.address.is_none(), "address"),
            ("wifi_password", self.wifi_password.is_some() && no_wifi, "wifi"),
            ("wifi_country", self.wifi_country.is_some() && no_wifi, "wifi"),
            ("wifi_identity", !no_user && no_wifi, "wifi"),
            ("wifi_identity", !no_user && no_authority, "wifi_authorities"),
            ("wifi_identity", !no_user && self.wifi_password.is_none(), "wifi_password"),
            ("wifi_authorities", !no_authority && no_user, "wifi_identity"),
            ("wifi_server", self.wifi_server.is_some() && no_user, "wifi_identity"),
            ("button_up", self.button_up.is_some() && no_button, "button"),
            ("button_down", self.button_down.is_some() && no_button, "button"),
            ("acknowledge", self.acknowledge.is_some() && no_button, "button"),
            ("vote_noise", self.vote_noise.is_some() && no_button && self.presence.is_none(), "button or presence"),
            ("report_every", self.report_every.is_some() && self.report_to.is_none(), "report_to"),
            ("report_picture", self.report_picture && self.report_to.is_none(), "report_to"),
            ("report_votes", self.report_votes && self.report_to.is_none(), "report_to"),
        ];
        settings.into_iter().find(|(_, is_alone, _)| *is_alone).map(|(key, _, needs)| Alone { key, needs })
    }

    /// The Wi-Fi that it names.
    pub fn wifi(&self) -> Option<Wifi> {
        let Self { wifi_authorities: authorities, wifi_server: server, .. } = self;
        let user = |identity: &wifi::Identity| wifi::Enterprise {
            identity: identity.clone(),
            authorities: authorities.clone(),
            server: server.clone(),
        };
        let (password, country) = (self.wifi_password.clone(), self.wifi_country.clone());
        let enterprise = self.wifi_identity.as_ref().map(user);
        self.wifi.clone().map(|name| Wifi { name, password, country, enterprise })
    }

    /// What it says about the display.
    pub fn output(&self) -> OutputSettings {
        let Self { connector, mode, rotate, range, margin, .. } = self;
        OutputSettings { connector: connector.clone(), mode: *mode, rotation: *rotate, range: *range, margin: *margin }
    }

    /// The settings of systemd's network manager for the cable, beside `80-dreams.network`; `None` if there are none.
    pub fn wired(&self) -> Option<String> {
        let own = self.address.map(|(address, length)| format!("DHCP=no\nAddress={address}/{length}\n"));
        let gateway = self.gateway.map(|gateway| format!("Gateway={gateway}\n"));
        drop_in([own, gateway, self.names(), self.time()])
    }

    /// The same of the Wi-Fi, beside `81-dreams-wifi.network`.
    pub fn wireless(&self) -> Option<String> {
        drop_in([self.names(), self.time()])
    }

    fn names(&self) -> Option<String> {
        let line = |address: &IpAddr| format!("DNS={address}\n");
        (!self.dns.is_empty()).then(|| self.dns.iter().map(line).collect())
    }

    fn time(&self) -> Option<String> {
        let line = |host: &String| format!("NTP={host}\n");
        (!self.ntp.is_empty()).then(|| self.ntp.iter().map(line).collect())
    }

    /// What it says of votes, in the same form: for `dreams-votes`, which may not read the rest. `None` if there is neither a
    /// button nor a sensor.
    pub fn votes(&self) -> Option<String> {
        fn line(name: &str, value: Option<impl Display>) -> Option<String> {
            value.map(|value| format!("{name} = {value}\n"))
        }
        let devices = [line("button", self.button.as_ref()), line("presence", self.presence.as_ref())];
        let others = [
            line("button_up", self.button_up),
            line("button_down", self.button_down),
            line("acknowledge", self.acknowledge),
            line("vote_noise", self.vote_noise),
        ];
        let has_device = devices.iter().any(Option::is_some);
        let lines: String = devices.into_iter().chain(others).flatten().collect();
        has_device.then(|| format!("# From the owner's dreams.toml.\n{lines}"))
    }

    /// The host name of a unit that its owner has named: that name, with `-` for `_`, and without what no label of a host
    /// name may begin or end with.
    pub fn host_name(&self) -> Option<String> {
        let name = self.unit.as_ref()?.as_str().replace('_', "-");
        let labels = name.split('.').map(|label| label.trim_matches('-')).filter(|label| !label.is_empty());
        Some(labels.collect::<Vec<_>>().join("."))
    }
}

/// What adds `lines` to a network of systemd's; `None` if there are none.
fn drop_in<const N: usize>(lines: [Option<String>; N]) -> Option<String> {
    let lines: String = lines.into_iter().flatten().collect();
    (!lines.is_empty()).then(|| format!("# From the owner's dreams.toml.\n[Network]\n{lines}"))
}

fn keys<'de, D: Deserializer<'de>>(from: D) -> Result<Vec<PublicKey>, D::Error> {
    let lines = Vec::<String>::deserialize(from)?;
    let key = |line: &String| {
        let wrong =
            || D::Error::custom(format!("`{line}` is not a valid public key: the second line of a file `NAME.pub`"));
        PublicKey::parse(line).ok_or_else(wrong)
    };
    lines.iter().map(key).collect()
}

fn url<'de, D: Deserializer<'de>>(from: D) -> Result<Option<String>, D::Error> {
    let text = String::deserialize(from)?;
    let is_address = ["http://", "https://"].iter().any(|scheme| text.starts_with(scheme) && text.len() > scheme.len());
    let wrong = || D::Error::custom(format!("`{text}` is not a valid address: it begins with `https://` or `http://`"));
    if is_address { Ok(Some(text)) } else { Err(wrong()) }
}

/// Reads a list of names or addresses of machines.
fn hosts<'de, D: Deserializer<'de>>(from: D) -> Result<Vec<String>, D::Error> {
    let hosts = Vec::<String>::deserialize(from)?;
    let is_host = |host: &str| host.parse::<IpAddr>().is_ok() || is_host_name(host);
    match hosts.iter().find(|host| !is_host(host)) {
        Some(wrong) => Err(D::Error::custom(format!(
            "`{wrong}` is not a valid time server: its name or address, as in `ntp.example.org`"
        ))),
        None => Ok(hosts),
    }
}

/// Whether `host` is a name of a machine, by RFC 1123: labels of letters, digits and `-`, with dots between them.
pub(crate) fn is_host_name(host: &str) -> bool {
    let is_label = |label: &str| {
        let is_plain = label.bytes().all(|byte| byte.is_ascii_alphanumeric() || byte == b'-');
        is_plain && (1..=63).contains(&label.len()) && !label.starts_with('-') && !label.ends_with('-')
    };
    host.len() <= 253 && host.split('.').all(is_label)
}

fn report_every<'de, D: Deserializer<'de>>(from: D) -> Result<Option<u64>, D::Error> {
    within(from, &REPORT_EVERY).map(Some)
}

fn mode<'de, D: Deserializer<'de>>(from: D) -> Result<Option<RequestedMode>, D::Error> {
    spelled(from).map(Some)
}

/// Reads a setting that is a word.
fn spelled<'de, D: Deserializer<'de>, T: FromStr<Err: Display>>(from: D) -> Result<T, D::Error> {
    String::deserialize(from)?.parse().map_err(D::Error::custom)
}

/// Reads a setting that is a number.
fn numbered<'de, D: Deserializer<'de>, T: TryFrom<i64, Error: Display>>(from: D) -> Result<T, D::Error> {
    i64::deserialize(from)?.try_into().map_err(D::Error::custom)
}

fn address<'de, D: Deserializer<'de>>(from: D) -> Result<Option<(IpAddr, u8)>, D::Error> {
    let text = String::deserialize(from)?;
    let read = || {
        let (address, length) = text.split_once('/')?;
        let (address, length): (IpAddr, u8) = (address.parse().ok()?, length.parse().ok()?);
        (length >= 1 && length <= if address.is_ipv4() { 32 } else { 128 }).then_some((address, length))
    };
    let wrong = || D::Error::custom(format!("`{text}` is not a valid address with its prefix, as in `192.0.2.7/24`"));
    read().map(Some).ok_or_else(wrong)
}

#[cfg(test)]
mod tests {
    use super::Owner;
    use screen::OutputSettings;
    use std::path::Path;

    const SAMPLE: &str = include_str!("../../../config/dreams.toml");

    fn read(text: &str) -> Result<Owner, String> {
        Owner::parse(Path::new("dreams.toml"), text).map_err(|error| error.to_string())
    }

    /// The keys that the sample explains, all left out by a leading `# `.
    fn keys_of_the_sample() -> Vec<(String, String)> {
        let entry = |paragraph: &str| {
            let text = paragraph.lines().map(|line| line.trim_start_matches("# ")).collect::<Vec<_>>().join("\n");
            let is_entry = |line: &str| {
                let key = line.split_once(" = ").map(|(key, _)| key);
                key.is_some_and(|key| key.chars().all(|c| c.is_ascii_lowercase() || c == '_'))
            };
            let at = text.lines().position(is_entry)?;
            let value = text.lines().skip(at).collect::<Vec<_>>().join("\n");
            Some((value.split_once(" = ")?.0.to_owned(), value))
        };
        SAMPLE.split("\n\n").filter_map(entry).collect()
    }

    #[test]
    fn the_owners_sample_sets_nothing_and_explains_every_key_and_no_other() {
        assert_eq!(read(SAMPLE).unwrap(), Owner::default());
        assert_eq!(read("").unwrap(), Owner::default());
        let refused = read("colour = 1").unwrap_err();
        let known = refused.split("expected one of ").nth(1).unwrap().split(", ");
        let known: Vec<_> = known.map(|key| key.trim_matches('`').to_owned()).collect();
        let explained = keys_of_the_sample();
        assert_eq!(explained.iter().map(|(key, _)| key.clone()).collect::<Vec<_>>(), known);
        let all = explained.iter().map(|(_, line)| line.as_str()).collect::<Vec<_>>().join("\n");
        let owner = read(&all).unwrap();
        assert!(owner.unit.is_some() && owner.hours.is_some() && owner.brightness.is_some() && owner.url.is_some());
        assert!(!owner.closed.is_empty() && owner.ntp.len() == 1);
        assert_eq!((owner.keys.len(), owner.dns.len(), owner.authorities.certificates().len()), (1, 1, 1));
        assert!(owner.night.is_some() && owner.output() != OutputSettings::default());
        assert!(owner.button.is_some() && owner.button_up.is_some() && owner.button_down.is_some());
        assert!(owner.presence.is_some() && owner.acknowledge == Some(false));
        assert!(owner.vote_noise == Some(true) && owner.report_to.is_some() && owner.report_votes);
        assert_eq!((owner.report_every, owner.report_picture), (Some(60), true));
    }

    #[test]
    fn what_is_wrong_is_named_by_line_and_key() {
        for (text, said) in [
            ("\nhours = \"8-23\"", "`dreams.toml` line 2, key `hours`: `8-23` are not valid hours"),
            (
                "brightness = 101",
                "line 1, key `brightness`: `101` is not a valid brightness: a percentage from 1 to 100",
            ),
            ("\nbrightness = -5", "line 2, key `brightness`: `-5` is not a valid brightness"),
            ("brightness = 0.5", "line 1, key `brightness`: a percentage from 1 to 100, or some with their times"),
            (
                "night = \"dark\"",
                "line 1, key `night`: `dark` is not a valid value of night: `off`, `black`, `ddc` or `cec`",
            ),
            ("mode = \"1080p\"", "line 1, key `mode`: `1080p` is not a mode"),
            ("\nrotate = 45", "line 2, key `rotate`: `45` is not a rotation: expected 0, 90, 180 or 270"),
            ("range = \"tv\"", "line 1, key `range`: `tv` is not a signal range: expected `auto`, `full` or `limited`"),
            ("margin = 21", "line 1, key `margin`: `21` is not a margin: expected a percentage from 0 to 20"),
            ("timezone = \"Zurich\"", "line 1, key `timezone`: `Zurich` is not a valid time zone"),
            ("unit = \"The Lobby\"", "line 1, key `unit`"),
            ("keys = [\"rubbish\"]", "`rubbish` is not a valid public key"),
            ("url = \"example.org\"", "`example.org` is not a valid address"),
            (
                "\nauthorities = \"CN=Office\"",
                "line 2, key `authorities`: there is no certificate: expected certificates",
            ),
            ("address = \"192.0.2.7\"", "`192.0.2.7` is not a valid address with its prefix"),
            ("address = \"192.0.2.7/33\"", "`192.0.2.7/33` is not a valid address with its prefix"),
            ("dns = [\"example.org\"]", "line 1, key `dns`"),
            ("ntp = [\"ntp\\nDNS=192.0.2.1\"]", "line 1, key `ntp`: `ntp DNS=192.0.2.1` is not a valid time server"),
            ("ntp = [\"-a.example.org\"]", "`-a.example.org` is not a valid time server: its name or address"),
            ("closed = [\"Christmas\"]", "line 1, key `closed`: `Christmas` is not a valid closed day"),
            ("closed = \"Mon\"", "line 1, key `closed`"),
            (
                "unit = \"lobby\"\ngateway = \"192.0.2.1\"",
                "line 2, key `gateway`: it needs `address`, which is not set",
            ),
            ("button = \"pedal\"", "line 1, key `button`: invalid value: string \"pedal\", expected `any`, or a path"),
            ("button = \"any\"\nbutton_down = \"any\"", "line 2, key `button_down`"),
            ("button_down = \"KEY_DOWN\"", "line 1, key `button_down`: it needs `button`, which is not set"),
            ("vote_noise = true", "line 1, key `vote_noise`: it needs `button` or `presence`, which is not set"),
            (
                "presence = \"any\"",
                "line 1, key `presence`: invalid value: string \"any\", expected a path below /dev/input",
            ),
            ("acknowledge = false", "line 1, key `acknowledge`: it needs `button`, which is not set"),
            ("button = \"any\"\nacknowledge = \"off\"", "line 2, key `acknowledge`"),
            ("report_every = 60", "line 1, key `report_every`: it needs `report_to`, which is not set"),
            (
                "report_to = \"https://a\"\nreport_every = 4",
                "line 2, key `report_every`: invalid value: integer `4`, expected a number from 5 to 10080",
            ),
            ("report_picture = true", "line 1, key `report_picture`: it needs `report_to`, which is not set"),
            ("report_votes = true", "line 1, key `report_votes`: it needs `report_to`, which is not set"),
            ("hour = 1", "unknown field `hour`"),
        ] {
            let refused = read(text).unwrap_err();
            assert!(refused.contains(said), "{refused}");
        }
    }

    #[test]
    fn a_brightness_is_a_number_with_or_without_quotation_marks() {
        let owner = read("brightness = 60").unwrap();
        assert!(owner.brightness.is_some());
        assert_eq!(owner, read("brightness = \"60\"").unwrap());
    }

    #[test]
    fn the_network_is_told_what_the_owner_set_and_no_more() {
        let told = |text: &str| {
            let owner = read(text).unwrap();
            [owner.wired(), owner.wireless()]
                .map(|lines| lines.map(|text| text.split_once("[Network]\n").unwrap().1.to_owned()))
        };
        assert_eq!(told("unit = \"lobby\""), [None, None]);
        let names = Some("DNS=192.0.2.53\n".to_owned());
        assert_eq!(told("dns = [\"192.0.2.53\"]"), [names.clone(), names]);
        let time = Some("NTP=ntp.example.org\nNTP=2001:db8::123\n".to_owned());
        assert_eq!(told("ntp = [\"ntp.example.org\", \"2001:db8::123\"]"), [time.clone(), time]);
        let fixed = "address = \"192.0.2.7/24\"\ngateway = \"192.0.2.1\"\ndns = [\"192.0.2.53\", \"2001:db8::53\"]";
        let names = "DNS=192.0.2.53\nDNS=2001:db8::53\n".to_owned();
        let wired = format!("DHCP=no\nAddress=192.0.2.7/24\nGateway=192.0.2.1\n{names}");
        assert_eq!(told(fixed), [Some(wired), Some(names)]);
    }

    #[test]
    fn what_is_said_of_votes_reads_back_and_tells_nothing_else() {
        for votes in [
            "button = 'any'",
            "button = '/dev/a\"b'\nbutton_up = 'any'\nbutton_down = 'KEY_UP'\nvote_noise = false",
            "button = 'any'\nacknowledge = false",
            "presence = '/dev/mat'\nvote_noise = true",
        ] {
            let told = read(&format!("unit = 'lobby'\nproxy = 'http://me:secret@example.org'\n{votes}"))
                .unwrap()
                .votes()
                .unwrap();
            assert_eq!(read(&told).unwrap(), read(votes).unwrap(), "{told}");
            assert!(!told.contains("secret") && !told.contains("lobby"), "{told}");
        }
        assert_eq!(read("unit = 'lobby'").unwrap().votes(), None);
    }

    #[test]
    fn the_units_name_becomes_a_host_name_that_every_network_takes() {
        for (unit, host) in
            [("lobby", "lobby"), ("room_7.west-wing", "room-7.west-wing"), ("7_.", "7"), ("a..-.b", "a.b")]
        {
            let owner = read(&format!("unit = \"{unit}\"")).unwrap();
            assert_eq!(owner.host_name().as_deref(), Some(host), "{unit}");
        }
        assert_eq!(Owner::default().host_name(), None);
    }
}
