//! From the switch to the art, and nothing else ever on the glass.
//!
//! Owns the claims on a unit that nobody disturbs: what it shows, what it is made of, what it offers to the network.

use crate::machine::{Unit, image};
use crate::picture::Look;

/// Whether an address of `/proc/net/tcp` and its like is this machine's own.
fn is_loopback(address: &str) -> bool {
    let host = address.split(':').next().unwrap();
    host.ends_with("7F") || host == "00000000000000000000000001000000" || host == "0000000000000000FFFF00000100007F"
}

#[test]
fn the_system_is_small() {
    let mb = |file: std::path::PathBuf| std::fs::metadata(file).unwrap().len() as f64 / 1e6;
    let root = mb(image().join("root.img"));
    let initramfs = mb(image().with_file_name("initramfs").join("initramfs"));
    assert!(root <= 180.0 && initramfs <= 3.0, "a root of {root} MB, an initramfs of {initramfs} MB");
}

#[test]
fn from_power_to_art_and_nothing_else_ever() {
    let unit = Unit::new();
    let mut machine = unit.start();
    let mut looks = machine.await_shell();
    looks.extend(machine.await_flips(100));
    let first = looks.iter().position(Look::is_art).expect("art is lit");
    for look in &looks[first..] {
        assert!(look.is_art(), "after the first lit frame: {look:?}");
    }
    assert!(looks.len() - first >= 10, "{} looks from the first lit frame on are too few", looks.len() - first);
    let ready = machine.run("systemctl show --value --property=ActiveEnterTimestampMonotonic dreams-player.service");
    println!(
        "{} looks before and {} after the first lit frame, ready {ready} us after the kernel's start",
        first,
        looks.len() - first
    );
    println!("{}", machine.run("systemd-analyze blame | head -n 20"));

    let root = machine.run("grep ' / ' /proc/mounts");
    assert!(root.contains("/dev/dm-0 / erofs ro,"), "the root is verified: {root}");
    assert!(machine.serial.run("touch /usr/bin/dreams-player").1 != 0, "the root is read-only");
    let size: u64 = machine.run("findmnt --noheadings --bytes --output SIZE /var/lib/dreams").trim().parse().unwrap();
    assert!(size > 400 << 20, "the disk of the flocks takes the rest of the disk, found {size} bytes");
    assert_eq!(machine.run("cat /proc/swaps | wc -l"), "1", "no swap");
    assert_eq!(machine.run("systemctl --failed --no-legend --plain"), "");
    assert_eq!(machine.run("ls /usr/sbin/agetty /usr/sbin/sshd /usr/bin/login 2> /dev/null; true"), "");
    for socket in machine.run("cat /proc/net/tcp /proc/net/tcp6 | grep -v local_address; true").lines() {
        let words: Vec<_> = socket.split_whitespace().collect();
        assert!(words[3] != "0A" || is_loopback(words[1]), "something listens: {socket}");
    }
}
