//! Notices over the running picture.
//!
//! Owns the claim on player and updater together, that a notice appears and disappears, and the one on a player that is too
//! slow. The updater's sentences are in `updates/sticks.rs`.

use claims::bundle_maker::rubbish;
use claims::flocks::JOINS;
use claims::player_run::PlayerRun;
use claims::status_page::{ask, pixels};
use claims::unit::Unit;
use rustix::process::Signal;
use std::thread::park_timeout;
use std::time::Duration;

/// The size of the picture, and of its lowest quarter, where a notice may be.
const SIZE: (usize, usize) = (640, 480);
/// The luma of a notice's pane is far below that of the test picture there, and it has no colour.
const DARK: u8 = 40;

/// The number of dark, colourless pixels in the lowest quarter of the picture.
fn pane(rgb: &[u8]) -> usize {
    let quarter = &rgb[SIZE.0 * SIZE.1 * 3 * 3 / 4..];
    let is_pane = |pixel: &&[u8]| pixel.iter().all(|sample| (10..DARK).contains(sample));
    quarter.chunks(3).filter(is_pane).count()
}

/// How long the player stands still and plays, in turns: so late are frames on a computer that is too slow.
const STILL: Duration = Duration::from_millis(70);
const PLAYING: Duration = Duration::from_millis(10);
/// Looks at the status, a second apart, until it must be noticed: that takes six times 600 vblanks, of which the screen has a
/// thousand per second.
const LOOKS: u32 = 60;

#[test]
fn a_player_that_is_too_slow_says_so_in_its_status_its_faults_and_once_on_the_picture() {
    let folder = tempfile::tempdir().unwrap();
    let socket = folder.path().join("page");
    let status = format!("unix:{}", socket.display());
    let notice = folder.path().join("notice").display().to_string();
    let options = ["--screen", "virtual:640x480@1000", "--seed", "1", "--status", &status, "--notice", &notice];
    let playing = PlayerRun::of(&JOINS.flock().folder).with(&options);
    let mut running = playing.start();
    running.await_lines(40);
    let facts = || serde_json::from_slice::<serde_json::Value>(&ask(&socket, "GET /status.json").body).unwrap();
    let before = facts();
    assert_eq!((&before["too_slow"], &before["screen"]["refresh_mhz"]), (&false.into(), &1_000_000.into()), "{before}");
    let dark = pane(&pixels(&ask(&socket, "GET /screen.jpg").body, "jpg"));

    let mut looks = (0..LOOKS).map(|_| {
        for _ in 0..12 {
            running.signal(Signal::STOP);
            park_timeout(STILL);
            running.signal(Signal::CONT);
            park_timeout(PLAYING);
        }
        facts()
    });
    let found = looks.find(|facts| facts["too_slow"] == true).expect("the player finds that it is too slow");
    assert_eq!((&found["faults"], &found["latest_faults"][0]["kind"]), (&1.into(), &"too-slow".into()), "{found}");
    assert!(ask(&socket, "GET /metrics").text().contains("\ndreams_too_slow 1\n"));
    let shot = || pane(&pixels(&ask(&socket, "GET /screen.jpg").body, "jpg"));
    // The player looks twice a second.
    let is_told = (0..20).any(|_| {
        park_timeout(Duration::from_millis(250));
        shot() > dark + 2_000
    });
    assert!(is_told, "the notice is on the picture");
    running.signal(Signal::TERM);
    let (code, trace) = running.end_within(10);
    assert_eq!((code, trace.faults.len()), (Some(0), 1), "{:?}", trace.faults);
    assert_eq!(trace.end.map(|end| end.skipped), Some(0), "every frame was shown");
}

#[test]
fn people_are_told_over_the_running_picture_what_became_of_their_stick() {
    let unit = Unit::new();
    let (socket, notice) = (unit.path("page"), unit.path("notice"));
    let status = format!("unix:{}", socket.display());
    let options = ["--screen", "virtual", "--seed", "1", "--status", &status, "--notice", notice.to_str().unwrap()];
    let playing = PlayerRun::of(&JOINS.flock().folder).with(&options);
    let mut running = playing.start();
    running.await_lines(40);
    let shot = || pixels(&ask(&socket, "GET /screen.jpg").body, "jpg");
    let before = pane(&shot());
    unit.maker.bundle(&unit.stick(), &rubbish(2, 1_000, 0), &["stairs"], 1);
    assert_eq!(unit.update(&[]).status.code(), Some(1));
    // The player looks twice a second; frames are told meanwhile.
    let mut told = 0;
    for _ in 0..20 {
        running.await_lines(10);
        told = pane(&shot());
        if told > before + 2_000 {
            break;
        }
    }
    assert!(told > before + 2_000, "a pane is over the picture: {told} dark pixels after {before}");
    running.signal(Signal::TERM);
    let (code, trace) = running.end_within(10);
    assert_eq!((code, trace.faults.len()), (Some(0), 0));
    assert_eq!(trace.end.map(|end| (end.skipped, end.repeated)), Some((0, 0)), "the picture went on");
}
