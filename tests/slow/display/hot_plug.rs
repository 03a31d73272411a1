//! The cable is unplugged and plugged in a hundred times.
//!
//! Owns the claim that the same process shows its picture again and leaks nothing. vkms makes the card from a
//! description, so that its cable can be unplugged by writing a file.

use crate::guest::{script, shell_words, succeed_in_virtual_time, word};
use claims::flocks::JOINS;
use claims::player_run::{PlayerRun, VKMS};
use claims::random::Random;
use std::fmt::Write as _;
use std::fs;

/// The number of times.
const TIMES: usize = 100;

/// The longest time until the picture is back, in nanoseconds of virtual time.
const BACK_NS: u64 = 2_000_000_000;

/// The time after which a player has seen that the cable is unplugged.
const DARK_NS: u64 = 300_000_000;

/// Makes a card `frame` with one of everything; `$card` is its device.
pub(crate) const CARD: &str = r"
frame=/sys/kernel/config/vkms/frame
mkdir $frame
mkdir $frame/planes/plane $frame/crtcs/crtc $frame/encoders/encoder $frame/connectors/cable
echo 1 > $frame/planes/plane/type
ln -s $frame/crtcs/crtc $frame/planes/plane/possible_crtcs/
ln -s $frame/crtcs/crtc $frame/encoders/encoder/possible_crtcs/
ln -s $frame/encoders/encoder $frame/connectors/cable/possible_encoders/
echo 1 > $frame/enabled
card=$(basename /sys/devices/faux/frame/drm/card*)
";

/// Functions of the guest's script: the cable, and the number of everything that a player could leak.
pub(crate) const HANDS: &str = r#"
now() { read -r up _ < /proc/uptime; echo "$1 $up"; }
pull() { now pull; echo 2 > $frame/connectors/cable/status; }
push() { echo 1 > $frame/connectors/cable/status; now push; }
light() { echo "light $(awk -F= '/^\tactive=/ {print $2}' /sys/kernel/debug/dri/frame/state)"; }
holds() {
  echo "holds $(grep -c '^framebuffer' /sys/kernel/debug/dri/frame/framebuffer) framebuffers," \
    "$(awk '/^Shmem:/ {print $2}' /proc/meminfo) kB of buffers, $(ls -l /proc/$player/fd | grep -vc '[.]mp4$') descriptors beside clips"
}
"#;

#[test]
fn a_cable_pulled_a_hundred_times_brings_the_picture_back_and_leaks_nothing() {
    let flock = JOINS.flock();
    let playing = PlayerRun::of(&flock.folder).with(&["--seed", "5", "--screen", "kms:/dev/dri/$card"]);
    let log = playing.path("log");
    let mut text = format!("{CARD}{HANDS}exec > {}\n", word(&log));
    writeln!(text, "{} &\nplayer=$!", shell_words(&playing.command())).unwrap();
    let mut random = Random(2);
    for time in 0..TIMES {
        // Every third time the cable is back before the player has noticed.
        let away_ms = if time % 3 == 0 { random.below(40) } else { random.below(1_500) };
        let lit_ms = BACK_NS / 1_000_000 + random.below(700);
        writeln!(text, "sleep {}; holds; pull", seconds(lit_ms)).unwrap();
        writeln!(text, "sleep {}; light; push; kill -0 $player", seconds(away_ms)).unwrap();
    }
    text += "sleep 3; holds\nkill -TERM $player; wait $player\n";
    fs::write(playing.path("hands.sh"), &text).unwrap();
    succeed_in_virtual_time(240, &script(&format!("bash -eu {}", word(&playing.path("hands.sh")))));

    let trace = playing.trace();
    let log = fs::read_to_string(log).unwrap();
    let away: Vec<_> = log.lines().filter(|line| !line.starts_with("holds")).collect();
    for cable in away.chunks(3) {
        let [pull, light, push] = cable else { panic!("a pull, a look and a push, found {cable:?}") };
        let away_ns = nanoseconds(&push[5..]) - nanoseconds(&pull[5..]);
        assert!(away_ns < DARK_NS || *light == "light 0", "the player saw that the cable was out: {cable:?}");
    }
    let pushes = log.lines().filter_map(|line| line.strip_prefix("push ")).map(nanoseconds);
    let back: Vec<u64> = pushes
        .map(|push| trace.flips.iter().map(|flip| flip.t_ns).find(|&t| t > push).unwrap_or(u64::MAX) - push)
        .collect();
    assert_eq!(back.len(), TIMES);
    assert!(back.iter().all(|&wait| wait <= BACK_NS), "nanoseconds until the picture is back: {back:?}");
    let holds: Vec<&str> = log.lines().filter(|line| line.starts_with("holds")).collect();
    let (first, last) = (holds.first().unwrap(), holds.last().unwrap());
    assert_eq!(first, last, "what the player holds before the first pull and after the last push");
    assert_eq!(trace.end.map(|end| end.skipped), Some(0), "no frame is skipped to catch up");
}

#[test]
fn a_player_started_before_its_display_lights_it_within_two_seconds() {
    let flock = JOINS.flock();
    let playing = PlayerRun::of(&flock.folder).with(&["--seed", "5", "--clips", "3", "--screen", "kms:/dev/dri/$card"]);
    let log = playing.path("log");
    let play = shell_words(&playing.command());
    let text = format!("{CARD}{HANDS}exec > {}\npull\n{play} &\nplayer=$!\nsleep 20; push; wait $player", word(&log));
    succeed_in_virtual_time(60, &script(&text));
    let log = fs::read_to_string(log).unwrap();
    let push = log.lines().find_map(|line| line.strip_prefix("push ")).map(nanoseconds).unwrap();
    let first = playing.trace().flips[0].t_ns;
    assert!((push..push + BACK_NS).contains(&first), "the display came at {push} ns, the picture at {first} ns");
}

#[test]
fn a_player_waits_while_another_program_has_the_display() {
    let flock = JOINS.flock();
    let playing = PlayerRun::of(&flock.folder).with(&["--seed", "5", "--clips", "3", "--screen", VKMS]);
    let other = "sleep 20 | modetest -M vkms -s 53@45:640x480 &";
    let text = format!("{other} sleep 1; {} &\nwait %2", shell_words(&playing.command()));
    let console = succeed_in_virtual_time(60, &script(&text));
    let first = playing.trace().flips[0].t_ns;
    let free = 20_000_000_000;
    assert!((free..free + 2 * BACK_NS).contains(&first), "freed after {free} ns, lit at {first} ns");
    assert_eq!(console.matches("WARN").count(), 1, "it says so once: {console}");
}

fn seconds(ms: u64) -> String {
    format!("{}.{:03}", ms / 1_000, ms % 1_000)
}

/// A reading of `/proc/uptime`, in hundredths of a second, in nanoseconds.
fn nanoseconds(uptime: &str) -> u64 {
    let (whole, hundredths) = uptime.split_once('.').unwrap();
    whole.parse::<u64>().unwrap() * 1_000_000_000 + hundredths.parse::<u64>().unwrap() * 10_000_000
}
