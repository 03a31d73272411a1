//! Resources that are denied for a while cost neither a clip nor the place in the walk.
//!
//! Owns the claims on a reader that stops reading the trace and on missing file descriptors. Damaged clips are in
//! `bad_clips.rs`.

use claims::flocks::SMALL;
use claims::player_run::PlayerRun;
use rustix::process::{Resource, Signal};

/// Options of a player that plays as fast as possible.
const FREE: [&str; 8] = ["--screen", "virtual", "--clock", "free", "--status", "off", "--seed", "5"];

#[test]
fn a_trace_that_nobody_reads_holds_up_no_signal_and_costs_no_place() {
    let flock = SMALL.flock();
    let playing = PlayerRun::of(&flock.folder).with(&FREE);
    let mut running = playing.start();
    running.await_lines(200);
    running.stop_listening();
    running.signal(Signal::TERM);
    let (code, trace) = running.end_unread_within(1);
    assert_eq!(code, Some(0), "a signal is a proper end, whoever does not listen");
    let told = trace.clips().len();

    let again = playing.with(&["--clips", "20"]).start().end_within(60).1;
    let walk = flock.walk("5", 8_000);
    let resumed = again.clips();
    let place = walk.windows(resumed.len()).position(|run| run == resumed).expect("the path goes on in the walk");
    assert!(place + 1 >= told, "the path goes on at clip {place}, though clip {told} was told of");
}

#[test]
fn a_machine_out_of_descriptors_is_waited_for_and_no_clip_is_struck() {
    let flock = SMALL.flock();
    let mut running = PlayerRun::of(&flock.folder).with(&FREE).start();
    running.await_lines(50);
    let limit = running.limit(Resource::Nofile, Some(0));
    running.await_line_with("missing-clip");
    running.limit(Resource::Nofile, limit);
    running.await_lines(500);
    running.signal(Signal::TERM);
    let (code, trace) = running.end_within(1);
    assert_eq!(code, Some(0));
    // Whether a join fell into the shortage, so that its place could not be kept, is chance.
    let (clips, others): (Vec<_>, Vec<_>) = trace.faults.iter().partition(|(kind, _)| kind == "missing-clip");
    let [(_, message)] = &clips[..] else { panic!("named once, found {:?}", trace.faults) };
    assert!(message.contains("yet") && message.contains("Too many open files"), "{message}");
    assert!(others.len() <= 1 && others.iter().all(|(kind, _)| kind == "place"), "{others:?}");
    let clips = trace.clips();
    assert_eq!(clips, flock.walk("5", clips.len()), "the walk is what it was without the shortage");
}
