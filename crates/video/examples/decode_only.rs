//! Decodes a clip with one thread and throws the frames away: `decode_only CLIP`. Prints how many there were.
//!
//! Owns the least that playing a clip can cost, with the very ffmpeg that a unit has: `tests/bench/players.py` compares.
//! Uses nothing of this crate, and is never part of the player.
#![expect(clippy::print_stdout, reason = "a bench prints its figures")]

use ffmpeg_next::codec::context::Context;
use ffmpeg_next::codec::threading::Config;
use ffmpeg_next::error::EAGAIN;
use ffmpeg_next::{Error, decoder, format, frame, media};
use std::env;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let clip = env::args().nth(1).ok_or("CLIP is missing")?;
    ffmpeg_next::init()?;
    println!("{}", decode(&clip)?);
    Ok(())
}

/// The number of frames of the first video stream of the file at `clip`.
fn decode(clip: &str) -> Result<u32, Error> {
    let mut input = format::input(clip)?;
    let stream = input.streams().best(media::Type::Video).ok_or(Error::StreamNotFound)?;
    let index = stream.index();
    let mut context = Context::from_parameters(stream.parameters())?;
    context.set_threading(Config::count(1));
    let mut decoder = context.decoder().video()?;
    let mut frames = 0;
    for (stream, packet) in input.packets() {
        if stream.index() == index {
            decoder.send_packet(&packet)?;
            frames += drain(&mut decoder)?;
        }
    }
    decoder.send_eof()?;
    frames += drain(&mut decoder)?;
    Ok(frames)
}

/// How many frames were ready.
fn drain(decoder: &mut decoder::Video) -> Result<u32, Error> {
    let (mut frame, mut frames) = (frame::Video::empty(), 0);
    loop {
        match decoder.receive_frame(&mut frame) {
            Ok(()) => frames += 1,
            Err(Error::Eof | Error::Other { errno: EAGAIN }) => return Ok(frames),
            Err(error) => return Err(error),
        }
    }
}
