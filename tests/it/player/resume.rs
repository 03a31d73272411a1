//! The walk is the one that `dreams walk` prints, also after the player was killed at any moment.
//!
//! Owns the claims on the seed and on the saved place.

use claims::flocks::SMALL;
use claims::player_run::PlayerRun;
use claims::random::Random;
use rustix::fs::{CWD, FileType, Mode, mknodat};
use rustix::process::Signal;
use std::fs;
use std::os::unix::net::UnixListener;

/// The number of kills.
const KILLS: u64 = 50;

/// Options of a player that plays as fast as possible.
const FREE: [&str; 6] = ["--screen", "virtual", "--clock", "free", "--status", "off"];

#[test]
fn the_player_plays_what_the_walk_prints() {
    let flock = SMALL.flock();
    for seed in ["0", "1", "20260101"] {
        let playing = PlayerRun::of(&flock.folder).with(&FREE).with(&["--clips", "60", "--hash", "--seed", seed]);
        let (code, trace) = playing.start().end_within(60);
        assert_eq!(code, Some(0));
        let clips = flock.walk(seed, 60);
        assert_eq!(trace.clips(), clips, "seed {seed}");
        let lit = trace.flips.iter().map(|flip| (flip.clip.as_str(), flip.frame, flip.hash.as_deref().unwrap()));
        assert!(lit.eq(flock.frames(&clips)), "seed {seed}: a frame is not where the walk has it");
    }
}

#[test]
fn a_path_started_without_a_seed_is_a_new_one() {
    let flock = SMALL.flock();
    let path = || {
        let (code, trace) = PlayerRun::of(&flock.folder).with(&FREE).with(&["--clips", "60"]).start().end_within(60);
        assert_eq!(code, Some(0));
        trace.clips().iter().map(|&clip| clip.to_owned()).collect::<Vec<_>>()
    };
    assert_ne!(path(), path());
}

/// A program that may write to the state folder, or a damaged disk, can leave one there.
#[test]
fn a_pipe_or_a_socket_in_place_of_the_saved_place_holds_up_no_start() {
    let flock = SMALL.flock();
    let playing = PlayerRun::of(&flock.folder).with(&FREE).with(&["--seed", "11", "--clips", "5"]);
    let state = playing.path("state");
    fs::create_dir_all(&state).unwrap();
    mknodat(CWD, state.join("place.0"), FileType::Fifo, Mode::RUSR | Mode::WUSR, 0).unwrap();
    let _socket = UnixListener::bind(state.join("place.1")).unwrap();
    let (code, trace) = playing.start().end_within(20);
    assert_eq!((code, trace.clips().len()), (Some(0), 5));
    let (_, again) = playing.start().end_within(20);
    let place = flock.walk("11", 20).windows(5).position(|run| run == again.clips());
    assert!(place.is_some_and(|place| place + 1 >= 5), "the place was saved over them: {place:?}");
}

/// The player is ahead of its reader by what the pipe holds, which varies: the moments of the kills are as random as
/// those of power cuts.
#[test]
fn a_player_killed_fifty_times_goes_on_where_it_was() {
    let flock = SMALL.flock();
    let playing = PlayerRun::of(&flock.folder).with(&FREE).with(&["--seed", "11"]);
    let walk = flock.walk("11", 8_000);
    let (mut place, mut repeated) = (0, 0);
    let mut random = Random(1);
    for kill in 0..KILLS {
        let mut running = playing.start();
        running.await_lines(1 + random.below(150));
        running.signal(Signal::KILL);
        let (_, trace) = running.end_within(5);
        let clips = trace.clips();
        if clips.is_empty() {
            continue;
        }
        let again = walk[place..].iter().zip(&clips).all(|(walked, played)| walked == played);
        if kill > 0 && !again {
            place += 1;
        }
        repeated += u64::from(kill > 0 && again);
        let due = &walk[place..place + clips.len()];
        assert_eq!(clips, due, "after kill {kill} the path goes on from clip {place} of the walk");
        place += clips.len() - 1;
    }
    assert!(repeated > KILLS / 2, "a kill in the middle of a clip repeats it, and no more: {repeated} of {KILLS}");
}
