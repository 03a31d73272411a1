//! The screen of a computer that starts by BIOS, as text.
//!
//! Owns that computer, which has a disk and a card for text and nothing else, and the reading of its memory.

use crate::machine::monitor::Monitor;
use crate::machine::qemu::{Qemu, Socket};
use claims::wait;
use serde_json::json;
use std::fs;
use std::path::Path;
use std::process::Command;

/// Where a card for text has its letters, each followed by its colours.
const TEXT: u64 = 0xb_8000;
/// The letters of a line, and the lines.
const SIZE: (usize, usize) = (80, 25);
/// Seconds until the disk has been started.
const PATIENCE_S: u32 = 120;

/// The lines on the screen, without empty ones, once `word` is among their words; `disk` is the file of the disk, and other
/// files are in `folder`.
pub(crate) fn bios_screen(folder: &Path, disk: &Path, word: &str) -> Vec<String> {
    let socket = Socket::new(folder.join("monitor"));
    let mut command = Command::new("qemu-system-x86_64");
    command.args(["-accel", "tcg", "-m", "64", "-nodefaults", "-vga", "std", "-display", "none"]);
    command.args(["-chardev", &socket.argument("monitor"), "-mon", "monitor,mode=control"]);
    command.args(["-drive", &format!("format=raw,file={}", disk.display())]);
    let mut qemu = Qemu::start(&mut command, folder.join("said"));
    let mut monitor = Monitor::new(socket.accept(&mut qemu), qemu.said());
    let memory = folder.join("memory");
    let mut lines = Vec::new();
    wait::until(&format!("`{word}` is on the screen"), PATIENCE_S, || {
        let asked = json!({ "val": TEXT, "size": 2 * SIZE.0 * SIZE.1, "filename": memory });
        monitor.ask("pmemsave", &asked);
        let letters: Vec<u8> = fs::read(&memory).unwrap().into_iter().step_by(2).collect();
        let line = |line: &[u8]| String::from_utf8_lossy(line).trim_matches([' ', '\0']).to_owned();
        lines = letters.chunks(SIZE.0).map(line).filter(|line| !line.is_empty()).collect();
        lines.iter().any(|line| line.split_whitespace().any(|found| found == word))
    });
    lines
}
