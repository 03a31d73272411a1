//! The owner's hours and settings of the display, on a display.
//!
//! Owns the claims that a running player goes by them from the moment at which they are set.

use crate::display::scanout::{SHORT, scanned_out_while};
use crate::guest::{script, shell_words, succeed_in_virtual_time, word};
use claims::flocks::SMALL;
use claims::owner::Settings;
use claims::player_run::{PlayerRun, VKMS};
use std::collections::HashMap;

/// Vblanks whose picture is looked at.
const LOOKS: usize = 150;

#[test]
fn the_player_goes_by_what_the_owner_sets_from_that_moment_on() {
    let settings = Settings::new();
    let kept = settings.path("kept");
    let options = ["--screen", VKMS, "--seed", "3", "--timezone", "UTC", "--owner", kept.to_str().unwrap()];
    let playing = PlayerRun::of(&SMALL.flock().folder).with(&options);
    let text = format!(
        "state() {{ sleep 3; sed -n 's/^\\tactive=//p' /sys/kernel/debug/dri/vkms/state; }}
        set_to() {{ echo \"$1\" > {partition}; {owner} || echo refused; }}
        exec > {seen}
        date -u -s '2046-07-01 12:00:00' > /dev/null; {player} & player=$!
        state; set_to 'hours = \"20:00-23:00\"'; state; set_to 'hours = 20'; state; set_to 'unit = \"lobby\"'; state
        kill $player; wait $player",
        partition = word(&settings.path("partition/dreams.toml")),
        seen = word(&settings.path("seen")),
        owner = shell_words(&settings.taking()),
        player = shell_words(&playing.command())
    );
    succeed_in_virtual_time(180, &script(&text));
    let seen = settings.read("seen").unwrap();
    let seen: Vec<_> = seen.split_whitespace().filter(|word| ["0", "1", "refused"].contains(word)).collect();
    assert_eq!(seen, ["1", "0", "refused", "0", "1"], "lit, asleep, asleep, lit");
}

#[test]
fn a_display_is_dimmed_and_gets_another_mode_while_no_frame_is_late() {
    let settings = Settings::new();
    let kept = settings.path("kept");
    let options = ["--screen", VKMS, "--seed", "3", "--owner", kept.to_str().unwrap()];
    let playing = PlayerRun::of(&SMALL.flock().folder).with(&options);
    let text = format!(
        "look() {{ sleep 3; awk -F'\"' '/^\tmode:/ {{ print $2 }}' /sys/kernel/debug/dri/vkms/state
            modetest -M vkms -p | awk '/GAMMA_LUT:/ {{ values = 1 }} /GAMMA_LUT_SIZE/ {{ values = 0 }}
                values && length($1) == 32 {{ last = $1 }} END {{ print last == \"\" ? \"full\" : substr(last, 17, 4) }}'; }}
        set_to() {{ echo \"$1\" > {partition}; {owner}; }}
        exec > {seen}
        {player} & player=$!
        look; set_to 'brightness = 50'; look; set_to 'brightness = 25\nmode = \"640x480\"'; look; set_to '# nothing'; look
        kill $player; wait $player",
        partition = word(&settings.path("partition/dreams.toml")),
        seen = word(&settings.path("seen")),
        owner = shell_words(&settings.taking()),
        player = shell_words(&playing.command())
    );
    succeed_in_virtual_time(180, &script(&text));
    let seen = settings.read("seen").unwrap();
    // The last value of the ramp, in the order of its bytes.
    let wanted = ["1024x768", "full", "1024x768", "ff7f", "640x480", "ff3f", "1024x768", "full"];
    assert_eq!(seen.split_whitespace().collect::<Vec<_>>(), wanted);
    let trace = playing.trace();
    let counts = trace.end.map(|end| (end.late, end.repeated, end.skipped, end.faults));
    assert_eq!(counts, Some((0, 0, 0, 0)), "{:?}", trace.faults);
}

#[test]
fn a_picture_is_rotated_while_it_plays_and_stays_so() {
    let settings = Settings::new();
    let kept = settings.path("kept");
    let options = ["--screen", VKMS, "--seed", "3", "--hash", "--owner", kept.to_str().unwrap()];
    let playing = PlayerRun::of(&SHORT.flock().folder).with(&options);
    let [player, owner] = [playing.command(), settings.taking()].map(|command| shell_words(&command));
    let partition = word(&settings.path("partition/dreams.toml"));
    let before = format!("{player} & player=$!; sleep 1");
    let beside = format!("echo 'rotate = 180' > {partition}; {owner}; sleep 4; kill $player; wait $player");
    let glass = scanned_out_while(&playing, LOOKS, &before, &beside);
    // What each frame looks like, in the order of the looks.
    let mut looks: HashMap<String, Vec<&str>> = HashMap::new();
    for pair in playing.trace().flips.windows(2) {
        let lit = pair[1].vblank.wrapping_sub(pair[0].vblank);
        let seen = (0..lit).filter_map(|after| glass.get(&pair[0].vblank.wrapping_add(after)));
        looks.entry(pair[0].hash.clone().unwrap()).or_default().extend(seen.map(String::as_str));
    }
    looks.values_mut().for_each(Vec::dedup);
    let both = looks.values().filter(|looks| looks.len() == 2).count();
    assert!(looks.values().all(|looks| looks.len() <= 2), "rotated once: {looks:?}");
    assert!(both >= 5, "{both} frames were seen in both ways");
}
