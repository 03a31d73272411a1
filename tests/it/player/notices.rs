//! Notices over the running picture.
//!
//! Owns the claim on player and updater together, that a notice appears and disappears. Its sentences are in
//! `updates/sticks.rs`.

use claims::bundle_maker::rubbish;
use claims::flocks::JOINS;
use claims::player_run::PlayerRun;
use claims::status_page::{ask, pixels};
use claims::unit::Unit;

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
    running.signal(rustix::process::Signal::TERM);
    let (code, trace) = running.end_within(10);
    assert_eq!((code, trace.faults.len()), (Some(0), 0));
    assert_eq!(trace.end.map(|end| (end.skipped, end.repeated)), Some((0, 0)), "the picture went on");
}
