//! The owner's hours on a display.
//!
//! Owns the claim that a running player goes by them from the moment at which they are set.

use crate::guest::{script, shell_words, succeed_in_virtual_time, word};
use claims::flocks::SMALL;
use claims::owner::Settings;
use claims::player_run::{PlayerRun, VKMS};

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
