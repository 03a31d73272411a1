//! A unit in its owner's Wi-Fi.
//!
//! Owns the claims, on two simulated radios of `mac80211_hwsim`: the unit has one, and `hostapd` in its own network
//! namespace has the other. Both programs and the module come on a disk of the test and are not part of the unit's
//! system. The settings are tried in `crates/settings/src/wifi.rs`, the notices in `player/dreams-owner/link.rs`.
//!
//! Start at [`a_unit_joins_its_owners_wifi_and_tells_why_where_it_cannot`].

use crate::machine::open_ports::open_ports;
use crate::machine::picture::only_art;
use crate::machine::{Machine, PAUSE};
use crate::owner::settings_error::{OPEN, TAKE_IN, has_notice};
use crate::starts::first_start::{OFTEN, playing_unit};
use claims::programs::{repository, succeed};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Where the disk of the test is mounted, and the network namespace of the access point.
const AIR: &str = "/run/air";
const AP: &str = "nsenter --net=/run/netns/ap";
/// The access point's settings but for its kind, and its DHCP server's.
const ACCESS_POINT: &str =
    "interface=wlan1\ndriver=nl80211\nssid=Home\nhw_mode=g\nchannel=1\nwpa=2\nrsn_pairwise=CCMP\n";
const WPA2: &str = "wpa_key_mgmt=WPA-PSK\nwpa_passphrase=velvet under\n";
const WPA3: &str = "wpa_key_mgmt=SAE\nieee80211w=2\nsae_password=velvet under\n";
/// IEEE 802.1X, with `hostapd`'s own server of users.
const ENTERPRISE: &str = "wpa_key_mgmt=WPA-EAP\nieee8021x=1\neap_server=1\neap_user_file=/run/air/users\n\
    ca_cert=/run/air/authority.pem\nserver_cert=/run/air/for-another-name.pem\nprivate_key=/run/air/server.key\n";
const USERS: &str = "* PEAP\n\"frame@example.org\" MSCHAPV2 \"let me\" [2]\n";
const SERVER: &str = "interface wlan1\nstart 10.9.0.20\nend 10.9.0.30\nlease_file /run/leases\npidfile /run/udhcpd.pid\n\
    opt router 10.9.0.1\nopt subnet 255.255.255.0\nopt lease 600\n";
/// For the unit's shell: it is in the Wi-Fi, and it is not.
const IS_IN: &str = "[ \"$(cat /sys/class/net/wlan0/carrier 2> /dev/null)\" = 1 ] && /run/air/busybox ping -I wlan0 -c 1 -w 2 10.9.0.1 > /dev/null";
const IS_OUT: &str = "[ \"$(cat /sys/class/net/wlan0/carrier 2> /dev/null)\" != 1 ]";
/// The same: the notice on the Wi-Fi.
const TOLD: &str = "cat /run/dreams-update/notice.wifi 2> /dev/null; echo";

fn certificate(name: &str) -> PathBuf {
    repository().join("tests/fixtures/certificates").join(name)
}

/// The owner's lines for the network with users: its authority is the certificate in the file of this name.
fn enterprise(authority: &str, password: &str) -> String {
    let pem = fs::read_to_string(certificate(authority)).unwrap().replace('\n', "\\\\n");
    format!(
        "wifi = \"Home\"\nwifi_identity = \"frame@example.org\"\nwifi_password = \"{password}\"\n\
         wifi_server = \"example.org\"\nwifi_authorities = \"{pem}\"\n"
    )
}

/// Makes the disk of the test in `folder`.
fn disk(folder: &Path) -> PathBuf {
    let (tools, files) = (repository().join("target/image/system/tools"), folder.join("air"));
    fs::create_dir(&files).unwrap();
    for file in ["usr/sbin/hostapd", "usr/sbin/iw", "usr/bin/busybox", "modules/mac80211_hwsim.ko.xz"] {
        let to = files.join(Path::new(file).file_name().unwrap());
        fs::copy(tools.join(file), to).unwrap_or_else(|error| panic!("{file}: {error}"));
    }
    for (name, kind) in [("wpa2.conf", WPA2), ("wpa3.conf", WPA3), ("enterprise.conf", ENTERPRISE)] {
        fs::write(files.join(name), format!("{ACCESS_POINT}{kind}")).unwrap();
    }
    for name in ["authority.pem", "for-another-name.pem", "server.key"] {
        fs::copy(certificate(name), files.join(name)).unwrap();
    }
    fs::write(files.join("users"), USERS).unwrap();
    fs::write(files.join("server.conf"), SERVER).unwrap();
    let disk = folder.join("air.img");
    fs::File::create(&disk).unwrap().set_len(32 << 20).unwrap();
    succeed(Command::new("mke2fs").args(["-q", "-t", "ext4", "-d"]).args([&files, &disk]));
    disk
}

/// Waits until `command` succeeds.
fn until(machine: &mut Machine, command: &str) {
    machine.run(&format!("until {command}; do sleep 1; done"));
}

/// Creates two radios, and moves the second one to a network namespace of its own.
fn give_radios(machine: &mut Machine, disk: &Path) {
    machine.plug(disk);
    machine.run(&format!("mkdir -p {AIR} /run/netns"));
    until(machine, &format!("mount -o ro /dev/sda {AIR}"));
    machine.run(&format!("modprobe mac80211 && insmod {AIR}/mac80211_hwsim.ko.xz radios=2"));
    until(machine, "systemctl --quiet is-active dreams-wifi@wlan0 dreams-wifi@wlan1");
    machine.run("touch /run/netns/ap && unshare --net=/run/netns/ap true");
    machine.run(&format!("{AIR}/iw phy $(cat /sys/class/net/wlan1/phy80211/name) set netns name ap"));
    until(machine, "! systemctl --quiet is-active dreams-wifi@wlan1");
    machine.run(&format!("{AP} {AIR}/busybox ip address add 10.9.0.1/24 dev wlan1"));
}

/// Starts an access point of this kind.
fn comes(machine: &mut Machine, kind: &str) {
    machine.run(&format!("{AP} {AIR}/hostapd -B -P /run/hostapd.pid {AIR}/{kind}.conf > /run/hostapd.log || {{ cat /run/hostapd.log; false; }}"));
    machine.run(&format!("[ -e /run/udhcpd.pid ] || {AP} {AIR}/busybox udhcpd {AIR}/server.conf"));
}

fn goes(machine: &mut Machine) {
    machine.run("kill $(cat /run/hostapd.pid)");
    until(machine, "[ ! -e /run/hostapd.pid ]");
}

/// Sets these lines, and no others, of the Wi-Fi in the owner's file.
fn set(machine: &mut Machine, lines: &str) {
    let (file, lines) = ("/run/owner/dreams.toml", lines.replace('\n', "\\n"));
    machine.run(&format!("{OPEN} && sed -i /^wifi/d {file} && printf '{lines}' >> {file} && {TAKE_IN}"));
}

/// The notice on the Wi-Fi, once there is one.
fn told(machine: &mut Machine) -> String {
    let mut looks = machine.watch_while(PAUSE, "until [ -e /run/dreams-update/notice.wifi ]; do sleep 1; done");
    looks.extend(machine.watch_for(PAUSE, "a notice", has_notice));
    only_art(&looks, OFTEN);
    machine.run(TOLD)
}

#[test]
fn a_unit_joins_its_owners_wifi_and_tells_why_where_it_cannot() {
    let folder = tempfile::tempdir_in(repository().join("target/image")).unwrap();
    let disk = disk(folder.path());
    let (_unit, mut machine) = playing_unit().snapshot.wake();
    assert_eq!(machine.run("systemctl list-units --all --plain --no-legend 'dreams-wifi@*'"), "", "there is no radio");
    give_radios(&mut machine, &disk);
    machine.run("[ ! -e /run/dreams-wifi/wlan0 ]");
    assert_eq!(machine.run(TOLD), "", "nobody has set a Wi-Fi");

    comes(&mut machine, "wpa2");
    let home = "wifi = \"Home\"\nwifi_country = \"CH\"\nwifi_password = ";
    set(&mut machine, &format!("{home}\"velvet over\"\n"));
    let sentence = "The Wi-Fi Home does not take the password in dreams.toml.";
    assert!(told(&mut machine).contains(sentence), "a wrong password");
    set(&mut machine, &format!("{home}\"velvet under\"\n"));
    until(&mut machine, IS_IN);
    assert_eq!(machine.run(TOLD), "", "what was wrong is mended");
    until(&mut machine, &format!("{AIR}/iw reg get | grep -q 'country CH:'"));
    let routes = machine.run(
        "while read -r name to _ _ _ _ metric _; do [ $to != 00000000 ] || echo $metric $name; done < /proc/net/route",
    );
    let mut routes: Vec<_> = routes.lines().map(|line| line.split_once(' ').unwrap()).collect();
    routes.sort_by_key(|(metric, _)| metric.parse::<u32>().unwrap());
    let known = machine.run(&format!("{AIR}/busybox ip route; networkctl --no-pager status wlan0"));
    assert!(routes.len() == 2 && routes[1].1 == "wlan0", "the cable goes before it: {routes:?}; {known}");
    assert_eq!(open_ports(&mut machine), [""; 0], "no port is open to the network");

    for kind in ["wpa2", "wpa3"] {
        goes(&mut machine);
        until(&mut machine, IS_OUT);
        assert_eq!(machine.run(TOLD), "", "an access point that goes is nobody's business");
        comes(&mut machine, kind);
        until(&mut machine, IS_IN);
    }
    set(&mut machine, &format!("{home}\"velvet over\"\n"));
    assert!(told(&mut machine).contains(sentence), "a wrong password of WPA3");

    goes(&mut machine);
    comes(&mut machine, "enterprise");
    set(&mut machine, &enterprise("good.pem", "let me"));
    until(
        &mut machine,
        "grep -qs 'The Wi-Fi Home has a server without an authority in dreams.toml.' /run/dreams-update/notice.wifi",
    );
    set(&mut machine, &enterprise("authority.pem", "let you"));
    until(&mut machine, &format!("grep -qs '{sentence}' /run/dreams-update/notice.wifi"));
    set(&mut machine, &enterprise("authority.pem", "let me"));
    until(&mut machine, IS_IN);
    assert_eq!(machine.run(TOLD), "", "the user is known");

    for secret in ["velvet under", "velvet over", "let me", "let you"] {
        machine.run(&format!(
            "! {{ journalctl --no-pager; dreams-status; cat /run/dreams-update/*; }} | grep -qF '{secret}'"
        ));
        machine.run(&format!("! setpriv --reuid=dreams --regid=dreams --clear-groups grep -rqFs --exclude-dir=air '{secret}' /var/lib/dreams/owner /run"));
    }
    machine.is_well();
}
