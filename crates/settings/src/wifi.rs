//! The Wi-Fi that the owner of a unit has set.
//!
//! Owns what a name, a password, a country and a user (IEEE 802.1X) may be, the settings of `wpa_supplicant` for them, and
//! how a password is kept out of every text that others read. Never connects: `dreams-owner connect` does.
//!
//! Start at [`Wifi::settings`].

use crate::authorities::Authorities;
use crate::owner::is_host_name;
use bundle::ObjectId;
use serde::de::{Deserialize, Deserializer, Error as _};
use std::fmt::{self, Debug, Formatter, Write as _};
use std::ops::Range;
use std::path::Path;
use toml::{Spanned, Value};

/// The folder of the control sockets of `wpa_supplicant`.
pub const CONTROL: &str = "/run/dreams-wifi";
/// What stands for a password in a text that others read. It may stand where a password does.
pub const HIDDEN: &str = "********";
/// The countries that the kernel has rules for, as in Debian's `wireless-regdb`.
const COUNTRIES: &str = "\
    AD AE AF AI AL AM AN AR AS AT AU AW AZ BA BB BD BE BF BG BH BL BM BN BO BR BS BT BW BY BZ CA CF CH CI CL CN CO \
    CR CU CX CY CZ DE DK DM DO DZ EC EE EG ES ET FI FM FO FR GB GD GE GF GH GI GL GP GR GT GU GY HK HN HR HT HU ID \
    IE IL IM IN IR IS IT JM JO JP KE KH KN KP KR KW KY KZ LB LC LI LK LS LT LU LV MA MC MD ME MF MH MK MN MO MP MQ \
    MR MT MU MV MW MX MY NA NG NI NL NO NP NZ OM PA PE PF PG PH PK PL PM PR PT PW PY QA RE RO RS RU RW SA SE SG SI \
    SK SM SN SR SV SX SY TC TD TG TH TN TR TT TW TZ UA UG US UY UZ VA VC VE VI VN VU WF WS YE YT ZA ZW";

/// A Wi-Fi.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Wifi {
    /// What it is called.
    pub name: Name,
    /// `None` if it is open.
    pub password: Option<Password>,
    /// Where the unit hangs.
    pub country: Option<Country>,
    /// The user and the server, for a network with IEEE 802.1X (WPA-Enterprise).
    pub enterprise: Option<Enterprise>,
}

/// How a unit and a network with IEEE 802.1X know each other.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Enterprise {
    /// The name of the user.
    pub identity: Identity,
    /// The authorities that may vouch for the network's server. At least one: without them any access point of this name
    /// would get the password.
    pub authorities: Authorities,
    /// The name, or the end of the name, that its certificate must have; `None` for any.
    pub server: Option<Server>,
}

/// The name of a user: 1 to 128 characters.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Identity(String);

/// The name of a server, as `radius.example.org`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Server(String);

/// What a Wi-Fi is called: 1 to 32 bytes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Name(String);

/// A password: 1 to 128 letters, digits and signs of ASCII. Without a user, it has 8 to 63 of them, or is the key itself, in
/// 64 hexadecimal digits: see [`Password::is_shared`].
#[derive(Clone, PartialEq, Eq)]
pub struct Password(String);

/// A country, by two capital letters.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Country(String);

impl Wifi {
    /// The settings of `wpa_supplicant`: WPA3 where the access point has it, else WPA2; a network that hides its name is
    /// asked for by it. The certificates of [`Enterprise::authorities`] are in the file at `authorities`, in PEM.
    pub fn settings(&self, authorities: &Path) -> String {
        let country = self.country.as_ref().map(|Country(code)| format!("country={code}\n")).unwrap_or_default();
        let mut name = String::new();
        for byte in self.name.0.bytes() {
            write!(name, "{byte:02x}").expect("memory can be written");
        }
        let key = match (&self.enterprise, &self.password) {
            (Some(enterprise), password) => enterprise.settings(password.as_ref(), authorities),
            (None, None) => "\tkey_mgmt=NONE\n".to_owned(),
            (None, Some(Password(key))) if is_key(key) => format!("\tkey_mgmt=WPA-PSK WPA-PSK-SHA256\n\tpsk={key}\n"),
            (None, Some(Password(text))) => format!("\tkey_mgmt=SAE WPA-PSK WPA-PSK-SHA256\n\tpsk=\"{text}\"\n"),
        };
        // Protected frames where the access point has them: WPA3 demands them. Both ways to derive WPA3's element.
        format!(
            "# From the owner's dreams.toml.\nctrl_interface={CONTROL}\n{country}sae_pwe=2\n\
             network={{\n\tssid={name}\n\tscan_ssid=1\n\tieee80211w=1\n{key}}}\n"
        )
    }
}

impl Enterprise {
    /// What the network has instead of a shared password: PEAP or TTLS, with `MSCHAPv2` inside.
    fn settings(&self, password: Option<&Password>, authorities: &Path) -> String {
        let Self { identity: Identity(identity), server, .. } = self;
        let Password(password) = password.cloned().unwrap_or_else(|| Password(String::new()));
        let server =
            server.as_ref().map(|Server(name)| format!("\tdomain_suffix_match=\"{name}\"\n")).unwrap_or_default();
        // A unit learns the time from the network, so it cannot ask before whether a certificate has expired. The line
        // with the checksum makes other certificates other settings.
        format!(
            "\tkey_mgmt=WPA-EAP WPA-EAP-SHA256\n\teap=PEAP TTLS\n\tphase2=\"auth=MSCHAPV2\"\n\
             \tphase1=\"tls_disable_time_checks=1\"\n\tidentity=\"{identity}\"\n\tpassword=\"{password}\"\n\
             \t# {}\n\tca_cert=\"{}\"\n{server}",
            ObjectId::of(self.authorities.pem().as_bytes()),
            authorities.display()
        )
    }
}

impl Password {
    /// Whether it can be the password that all who use a network share.
    pub fn is_shared(&self) -> bool {
        is_key(&self.0) || (8..=63).contains(&self.0.len())
    }

    /// What it is not, if it is not [shared](Self::is_shared).
    pub(crate) fn unshared(&self) -> String {
        unfit(&format!("it has {}", self.0.len()))
    }
}

impl Name {
    /// As text.
    pub fn as_str(&self) -> &str {
        &self.0
    }
}

impl Debug for Password {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.write_str(HIDDEN)
    }
}

impl<'de> Deserialize<'de> for Name {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        let name = String::deserialize(from)?;
        let wrong = || {
            D::Error::custom(format!(
                "`{name}` is not a valid name of a Wi-Fi: it has {} bytes, of 1 to 32",
                name.len()
            ))
        };
        if (1..=32).contains(&name.len()) { Ok(Self(name)) } else { Err(wrong()) }
    }
}

impl<'de> Deserialize<'de> for Password {
    /// No error repeats what stands there.
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        let Value::String(text) = Value::deserialize(from)? else {
            return Err(D::Error::custom("a password stands between quotation marks"));
        };
        let is_plain = text.bytes().all(|byte| (b' '..=b'~').contains(&byte));
        if is_plain && (1..=128).contains(&text.len()) {
            return Ok(Self(text));
        }
        let wrong = if is_plain { format!("it has {}", text.len()) } else { "some are others".to_owned() };
        Err(D::Error::custom(unfit(&wrong)))
    }
}

impl<'de> Deserialize<'de> for Identity {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        let text = String::deserialize(from)?;
        if (1..=128).contains(&text.chars().count()) && !text.chars().any(char::is_control) {
            return Ok(Self(text));
        }
        Err(D::Error::custom("expected the name of a user: 1 to 128 characters in one line"))
    }
}

impl<'de> Deserialize<'de> for Server {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        let text = String::deserialize(from)?;
        if is_host_name(&text) {
            return Ok(Self(text));
        }
        Err(D::Error::custom(format!("`{text}` is not the name of a server: expected one as `radius.example.org`")))
    }
}

impl<'de> Deserialize<'de> for Country {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        let code = String::deserialize(from)?;
        let wrong = || {
            D::Error::custom(format!("`{code}` is not a valid country: two capital letters of ISO 3166, as CH or GB"))
        };
        if COUNTRIES.split(' ').any(|country| country == code) { Ok(Self(code)) } else { Err(wrong()) }
    }
}

/// What is wrong with a password.
fn unfit(why: &str) -> String {
    format!("a password has 8 to 63 letters, digits and signs of the English keyboard, {why}")
}

fn is_key(text: &str) -> bool {
    text.len() == 64 && text.bytes().all(|byte| byte.is_ascii_hexdigit())
}

/// The owner's file `text`, which is right, with [`HIDDEN`] for the password.
pub fn without_password(text: &str) -> String {
    match password_at(text) {
        Some(at) => format!("{}\"{HIDDEN}\"{}", &text[..at.start], &text[at.end..]),
        None => text.to_owned(),
    }
}

/// Where in the owner's file the value of the password stands.
fn password_at(text: &str) -> Option<Range<usize>> {
    #[derive(serde::Deserialize)]
    struct Spot {
        wifi_password: Option<Spanned<String>>,
    }
    toml::from_str::<Spot>(text).ok()?.wifi_password.map(|password| password.span())
}

#[cfg(test)]
mod tests {
    use super::{HIDDEN, without_password};
    use crate::owner::Owner;
    use std::path::Path;

    fn owner(text: &str) -> Result<Owner, String> {
        Owner::parse(Path::new("dreams.toml"), text).map_err(|error| error.to_string())
    }

    fn settings(text: &str) -> String {
        owner(text).unwrap().wifi().unwrap().settings(Path::new("/kept/wifi.pem"))
    }

    const HOME: &str = "wifi = \"Home\"\nwifi_password = \"velvet under\"\n";

    #[test]
    fn a_wifi_is_told_by_its_bytes_and_only_what_the_owner_set() {
        assert_eq!(owner("hours = \"08:00-23:00\"").unwrap().wifi(), None);
        let home = settings(HOME);
        assert!(home.contains("\tssid=486f6d65\n") && home.contains("\tpsk=\"velvet under\"\n"), "{home}");
        assert!(home.contains("\tkey_mgmt=SAE WPA-PSK WPA-PSK-SHA256\n") && !home.contains("country"), "{home}");
        assert!(home.contains("\tscan_ssid=1\n"), "one that hides its name is found, too: {home}");
        let open = settings("wifi = \"Caf\u{e9} \\\"7\\\"\"\nwifi_country = \"CH\"");
        assert!(open.contains("\tssid=436166c3a920223722\n") && open.contains("\ncountry=CH\n"), "{open}");
        assert!(open.contains("\tkey_mgmt=NONE\n") && !open.contains("psk"), "{open}");
        let key = "0123456789abcdef".repeat(4);
        let raw = settings(&format!("wifi = \"Home\"\nwifi_password = \"{key}\""));
        assert!(raw.contains(&format!("\tpsk={key}\n")) && !raw.contains("SAE"), "WPA3 has no use for it: {raw}");
        let quoted = settings("wifi = \"Home\"\nwifi_password = 'say \"hello\"'");
        assert!(quoted.contains("\tpsk=\"say \"hello\"\"\n"), "up to the last quotation mark: {quoted}");
    }

    const AUTHORITY: &str = include_str!("../../../tests/fixtures/certificates/authority.pem");

    #[test]
    fn a_user_of_a_network_with_802_1x_has_its_own_settings() {
        let office = format!(
            "wifi = \"Office\"\nwifi_identity = \"frame@example.org\"\nwifi_password = 'let\"me'\n\
             wifi_server = \"radius.example.org\"\nwifi_authorities = \"\"\"\n{AUTHORITY}\"\"\"\n"
        );
        let said = settings(&office);
        for line in [
            "key_mgmt=WPA-EAP WPA-EAP-SHA256",
            "eap=PEAP TTLS",
            "identity=\"frame@example.org\"",
            "password=\"let\"me\"",
            "ca_cert=\"/kept/wifi.pem\"",
            "domain_suffix_match=\"radius.example.org\"",
        ] {
            assert!(said.contains(&format!("\t{line}\n")), "{line}: {said}");
        }
        assert!(!said.contains("psk") && !said.contains("SAE"), "{said}");
        let without = settings(&office.replace("wifi_server", "# wifi_server"));
        assert!(!without.contains("domain_suffix_match"), "{without}");
        let enterprise = owner(&office).unwrap().wifi().unwrap().enterprise.unwrap();
        assert_eq!(enterprise.authorities.pem(), AUTHORITY);
    }

    #[test]
    fn a_user_needs_an_authority_and_all_its_keys_need_a_user() {
        let office = "wifi = \"Office\"\nwifi_password = \"let me\"\n";
        let authorities = format!("wifi_authorities = \"\"\"\n{AUTHORITY}\"\"\"\n");
        for (text, said) in [
            (office.to_owned(), "line 2, key `wifi_password`: a password has 8 to 63"),
            (
                format!("{office}wifi_identity = \"frame\"\n"),
                "line 3, key `wifi_identity`: it needs `wifi_authorities`, which is not set",
            ),
            (
                format!("{office}wifi_server = \"radius.example.org\"\n"),
                "line 3, key `wifi_server`: it needs `wifi_identity`",
            ),
            (format!("{authorities}wifi = \"Office\"\n"), "line 1, key `wifi_authorities`: it needs `wifi_identity`"),
            (
                format!("wifi = \"Office\"\nwifi_identity = \"frame\"\n{authorities}"),
                "line 2, key `wifi_identity`: it needs `wifi_password`",
            ),
            (
                format!("wifi_identity = \"frame\"\nwifi_password = \"let me\"\n{authorities}"),
                "line 2, key `wifi_password`: it needs `wifi`, which",
            ),
            (
                format!("{office}wifi_identity = \"a\\nb\"\n"),
                "line 3, key `wifi_identity`: expected the name of a user",
            ),
            (format!("{office}wifi_server = \"a b\"\n"), "`a b` is not the name of a server"),
            (format!("{office}wifi_authorities = \"rubbish\"\n"), "line 3, key `wifi_authorities`: there is no cert"),
        ] {
            let refused = owner(&text).unwrap_err();
            assert!(refused.contains(said) && !refused.contains("let me"), "{said}: {refused}");
        }
    }

    #[test]
    fn what_is_wrong_of_a_wifi_is_named_by_line_and_key_and_without_the_password() {
        for (text, said) in [
            ("wifi = \"Home\"\nwifi_password = \"velvet1\"", "line 2, key `wifi_password`: a password has 8 to 63"),
            ("wifi = \"Home\"\nwifi_password = \"velvet1\"", "it has 7"),
            ("wifi = \"Home\"\nwifi_password = \"velvet1\u{e9}\"", "some are others"),
            ("wifi = \"Home\"\nwifi_password = 1234velvet", "line 2, key `wifi_password`"),
            ("wifi = \"Home\"\nwifi_password = 1234567890", "between quotation marks"),
            ("wifi = \"Home\"\nwifi_password = \"velvet", "line 2, key `wifi_password`"),
            ("wifi = \"Home\"\nwifi_password = velvet", "line 2, key `wifi_password`"),
            ("wifi = \"Home\"\nwifi_password: velvet", "line 2, key `wifi_password`"),
            ("wifi = \"Home\"\nwifi_password = velvet under # ground", "line 2, key `wifi_password`"),
            ("wifi = \"Home\"\nwifi_passwort = \"velvet\"", "unknown field `wifi_passwort`"),
            ("wifi = \"Home\"\nvelvet", "line 2"),
            ("wifi = \"Home\"\nvelvet under", "line 2"),
            (
                "wifi_password = \"velvet underground\"",
                "line 1, key `wifi_password`: it needs `wifi`, which is not set",
            ),
            ("\nwifi_country = \"CH\"", "line 2, key `wifi_country`: it needs `wifi`, which is not set"),
            ("wifi = \"\"", "`` is not a valid name of a Wi-Fi: it has 0 bytes, of 1 to 32"),
            ("wifi = \"A name that is far too long for this\"", "it has 36 bytes"),
            (
                "wifi = \"Home\"\nwifi_country = \"Switzerland\"",
                "`Switzerland` is not a valid country: two capital letters",
            ),
            ("wifi = \"Home\"\nwifi_country = \"ch\"", "`ch` is not a valid country"),
            ("wifi = \"Home\"\nwifi_country = \"UK\"", "`UK` is not a valid country"),
        ] {
            let refused = owner(text).unwrap_err();
            assert!(refused.contains(said), "{refused}");
            assert!(!refused.contains("velvet") && !refused.contains("1234"), "{refused}");
        }
    }

    #[test]
    fn a_password_is_in_no_text_that_others_read() {
        assert!(!format!("{:?}", owner(HOME).unwrap()).contains("velvet"));
        let hidden = without_password(HOME);
        assert_eq!(hidden, format!("wifi = \"Home\"\nwifi_password = \"{HIDDEN}\"\n"));
        assert_eq!(owner(&hidden).unwrap().wifi().unwrap().name, owner(HOME).unwrap().wifi().unwrap().name);
        for spelled in ["'velvet under'", "\"\"\"\nvelvet under\"\"\"", "\"velv\\u0065t under\""] {
            let text = format!("# velvet?\nwifi_password = {spelled} # as ever\nwifi = \"Home\"\n");
            let hidden = without_password(&text);
            assert_eq!(hidden, format!("# velvet?\nwifi_password = \"{HIDDEN}\" # as ever\nwifi = \"Home\"\n"));
        }
        let without = "hours = \"08:00-23:00\"\n";
        assert_eq!(without_password(without), without);
    }
}
