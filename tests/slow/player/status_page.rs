//! The status page in a browser.
//!
//! Owns the claim that it shows its picture there. Its answers are in `it/player/status_page.rs`.

use claims::programs::output;
use claims::status_page::{on_a_port, pixels};
use std::fs;
use std::process::Command;

#[test]
fn the_page_shows_its_picture_in_a_browser_without_a_complaint() {
    let (playing, _running, address) = on_a_port();
    let shot = playing.path("page.png");
    let mut chromium = Command::new("timeout");
    chromium.args(["60", "chromium", "--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars"]);
    chromium.arg(format!("--user-data-dir={}", playing.path("chromium").display()));
    chromium.args(["--window-size=1280,1200", "--virtual-time-budget=4000", "--enable-logging=stderr"]);
    chromium.arg(format!("--screenshot={}", shot.display())).arg(format!("http://{address}/"));
    let said = output(&mut chromium);
    let console = String::from_utf8_lossy(&said.stderr);
    assert!(said.status.success(), "{console}");
    assert!(!console.contains("CONSOLE"), "the browser's console is empty: {console}");
    let rgb = pixels(&fs::read(&shot).unwrap(), "png");
    let vivid = rgb.chunks(3).filter(|pixel| pixel.iter().max().unwrap() - pixel.iter().min().unwrap() > 120).count();
    assert!(vivid * 50 > rgb.len() / 3, "the test picture's colours are on the page: {vivid} vivid pixels");
}
