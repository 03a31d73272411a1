//! Flocks of another size or rate come to a player on a real display.
//!
//! Owns the claim that the screen is never dark: the next picture comes at its vblank, or, where a mode has to be set,
//! at the first one after that. That every frame is shown in order, and that the walk continues, is tried in
//! `player/flock_switch.rs`.

use crate::guest::{script, shell_words, succeed_in_virtual_time};
use claims::bundle_maker::BundleMaker;
use claims::editions::edition;
use claims::flocks::{Flock, Plan, SMALL};
use claims::player_run::{PlayerRun, VKMS};
use claims::programs::updater;
use claims::trace::{Flip, Trace};
use std::fmt::Write as _;
use std::fs;
use std::process::Command;

/// Flocks that come one after the other, each `SECONDS` after the one before, with the vblanks per frame and the mode:
/// all but the last are shown in the middle of the same mode.
const PLANS: [(Plan, u32, &str); 4] = [
    (Plan { name: "forms", ..SMALL }, 2, "1024x768@"),
    (Plan { name: "forms-smaller", size: (160, 120), ..SMALL }, 2, "1024x768@"),
    (Plan { name: "forms-slower", size: (160, 120), fps: (20, 1), ..SMALL }, 3, "1024x768@"),
    (Plan { name: "forms-larger", size: (640, 480), ..SMALL }, 2, "640x480@"),
];
const SECONDS: u32 = 4;
/// The most vblanks that the setting of a mode takes here.
const SETTING: u32 = 3;

/// The flock that a flip belongs to.
fn number(flip: &Flip) -> usize {
    flip.clip.split_once('/').unwrap().0.parse().unwrap()
}

/// Plays the first flock, and installs the others.
fn played() -> PlayerRun {
    let flocks: Vec<Flock> = PLANS.iter().map(|(plan, ..)| plan.flock()).collect();
    let maker = BundleMaker::with_new_keys();
    let playing = PlayerRun::of("/tmp/store/current".as_ref());
    let playing = playing.with(&["--screen", VKMS, "--seed", "5", "--hash", "--prefetch-ms", "2000"]);
    fs::rename(maker.keys(), playing.path("keys")).unwrap();
    let update = |number: usize| {
        let bundle = playing.path(&number.to_string());
        maker.bundle(&bundle, &edition(&flocks[number], &number.to_string()), &[], number as u64 + 1);
        let mut update = Command::new(updater());
        update.args(["--unit", "lobby", "--store", "/tmp/store", "--keys"]).arg(playing.path("keys")).arg(bundle);
        shell_words(&update)
    };
    let mut text = format!("{}\n{} & player=$!\n", update(0), shell_words(&playing.command()));
    for number in 1..PLANS.len() {
        writeln!(text, "sleep {SECONDS}\n{}", update(number)).unwrap();
    }
    writeln!(text, "sleep {}; kill -TERM $player; wait $player", 2 * SECONDS).unwrap();
    succeed_in_virtual_time(240, &script(&text));
    playing
}

#[test]
fn a_flock_of_another_size_or_rate_comes_without_a_dark_moment() {
    let playing = played();
    let trace: Trace = playing.trace();
    let counts = trace.end.as_ref().map(|end| (end.late, end.repeated, end.skipped, end.faults));
    assert_eq!(counts, Some((0, 0, 0, 0)), "{:?}", trace.faults);
    let modes: Vec<&str> = trace.starts.iter().map(|start| &*start.mode).collect();
    assert!(modes.len() == PLANS.len(), "{modes:?}");
    assert!(modes.iter().zip(PLANS).all(|(mode, (.., wanted))| mode.starts_with(wanted)), "{modes:?}");
    let period_ns = 1_000_000_000 / 60;
    for pair in trace.flips.windows(2) {
        let [before, after] = [number(&pair[0]), number(&pair[1])];
        let (lit, lit_ns) = (pair[1].vblank.wrapping_sub(pair[0].vblank), pair[1].t_ns - pair[0].t_ns);
        let sets_mode = PLANS[before].2 != PLANS[after].2;
        let most = PLANS[before].1 + if sets_mode { SETTING } else { 0 };
        assert!((PLANS[before].1..=most).contains(&lit), "{} {}: {lit} vblanks", pair[0].clip, pair[0].frame);
        assert!(lit_ns < u64::from(most) * period_ns * 21 / 20, "{} {}: {lit_ns} ns", pair[0].clip, pair[0].frame);
    }
    let lit = |flock: usize| trace.flips.iter().filter(|flip| number(flip) == flock).count();
    assert!((0..PLANS.len()).all(|flock| lit(flock) > 40), "all of them were played: {:?}", [0, 1, 2, 3].map(lit));
}
