//! How fast the studio's page answers, as a visitor's eyes and fingers have it.
//!
//! Owns the measurements in a real browser; the page's own clock counts. Prints one JSON document. `tests/bench/studio.py`
//! holds them against what is promised.
//!
//! Start at [`main`].
#![forbid(unsafe_code)]
#![allow(clippy::unwrap_used, clippy::panic, clippy::print_stdout, reason = "a measurement fails by panicking")]

mod pictured;

use claims::studio::browser::Browser;
use claims::studio::page::{DESK, Page};
use claims::studio::running::Studio;
use claims::studio::sheep::ring;
use pictured::pictured;
use serde_json::{Value, json};

/// Runs before the page: notes when the Wall was drawn, every frame's distance from the one before, and when what a key
/// changed was on the screen.
const CLOCK: &str = include_str!("clock.js");
const IS_DRAWN: &str = "window.drawnMs !== null";

fn main() {
    let browser = Browser::start();
    let told = json!({
        "first_paint_ms": first_paint(&browser),
        "key_to_mark_ms": key_to_mark(&browser),
        "scrolling_200_frames_ms": scrolling(&browser, 200),
        "scrolling_3000_frames_ms": scrolling(&browser, 3_000),
        "slider_300_ms": slider(&browser, 300),
        "slider_1000_ms": slider(&browser, 1_000),
    });
    println!("{told}");
}

/// The page of a studio on the Wall.
fn wall(browser: &Browser, studio: &Studio) -> Page {
    let page = Page::prepared(browser, &studio.address(), DESK, CLOCK);
    page.until("the Wall is drawn", IS_DRAWN);
    page
}

/// Milliseconds from the beginning of loading to the Wall of 200 sheep with the pictures in view; of five loads, after a
/// first one that filled the cache.
fn first_paint(browser: &Browser) -> Value {
    let flock = pictured(200);
    let studio = Studio::of(flock.path());
    let page = wall(browser, &studio);
    (0..5)
        .map(|_| {
            reload(&page);
            page.until("the Wall is drawn", IS_DRAWN);
            page.ask("window.drawnMs")
        })
        .collect()
}

/// Loads `page` again, and waits until it is loaded.
fn reload(page: &Page) {
    page.ask("window.isOld = true");
    page.call("Page.reload", &json!({}));
    page.until("the page is loaded again", "!window.isOld && document.readyState === 'complete'");
}

/// Milliseconds from each of 200 keys to the frame with its mark.
fn key_to_mark(browser: &Browser) -> Value {
    let flock = pictured(200);
    let studio = Studio::of(flock.path());
    let page = wall(browser, &studio);
    page.press("Home");
    for at in 0..200 {
        page.ask("window.watchMark()");
        page.press(if at % 2 == 0 { "k" } else { "x" });
        page.until("the mark is drawn", "window.took !== null");
        page.ask("window.all.push(window.took)");
    }
    page.ask("window.all")
}

/// Milliseconds between the frames while the Wall of so many sheep is scrolled for five seconds.
fn scrolling(browser: &Browser, sheep: usize) -> Value {
    let flock = pictured(sheep);
    let studio = Studio::of(flock.path());
    let page = wall(browser, &studio);
    page.ask("window.scrolling(5000)")
}

/// Milliseconds from each of 100 keys on a slider to the frame with the new figures, in a flock of so many sheep with
/// four transitions each.
fn slider(browser: &Browser, sheep: usize) -> Value {
    let flock = ring("meadow", sheep, 3);
    let studio = Studio::of(flock.path());
    let page = Page::prepared(browser, &studio.address(), DESK, CLOCK);
    page.until("the Wall is there", "document.querySelector('.view.wall')?.dataset.state === 'ready'");
    page.ask("location.hash = '#/graph?at=s5'");
    page.until("the graph is drawn", "document.querySelector('.view.graph')?.dataset.state === 'ready'");
    page.until("the panel has a slider", "document.querySelector('.view.graph [type=range]')");
    page.ask("document.querySelector('.view.graph [type=range]').focus()");
    for at in 0..100 {
        page.ask("window.watchFigures()");
        page.press(if at % 20 < 10 { "ArrowRight" } else { "ArrowLeft" });
        page.until("new figures are drawn", "window.took !== null");
        page.ask("window.all.push(window.took)");
    }
    page.ask("window.all")
}
