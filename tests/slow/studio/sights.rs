//! Every view, seen by a careful visitor in both lights, on a desk, on a small screen, on a telephone and at 200 % zoom.
//!
//! Owns the claims on names, contrast, and what is cut off; and the pictures of all views, which lie in the folder of the
//! claims for people to look at.
//!
//! Start at [`visit`] and `audit.js`.

use claims::programs::claims_folder;
use claims::studio::browser::Browser;
use claims::studio::page::MOST_BYTES;
use claims::studio::page::{DESK, Page, Window};
use claims::studio::running::Studio;
use claims::studio::sheep::demo;
use claims::wait;
use serde_json::json;
use std::fmt::Write as _;
use std::fs;

/// What is wrong with a page as it is shown now.
pub(crate) const AUDIT: &str = include_str!("audit.js");

/// The views, each by its address.
const VIEWS: [(&str, &str); 9] = [
    ("wall", "wall"),
    ("graph", "graph?at=aurora"),
    ("walk", "walk?seed=7"),
    ("loupe", "walk?show=joins"),
    ("breed", "breed?at=aurora"),
    ("lineage", "lineage"),
    ("globe", "globe"),
    ("jobs", "jobs"),
    ("ship", "ship"),
];

/// A desk, a small screen, a telephone, and a desk at 200 % zoom.
const SIZES: [(&str, u32, u32, u32); 4] =
    [("desk", 1440, 900, 1), ("small", 1024, 768, 1), ("telephone", 390, 844, 1), ("zoomed", 640, 400, 2)];

/// The page at the view with this address, once its first data is drawn.
fn visit(page: &Page, address: &str) {
    page.ask(&format!("location.hash = '#/{address}'"));
    let name = address.split('?').next().unwrap_or_default();
    let is_shown = format!("document.body.dataset.view === '{name}'");
    page.until(&format!("the view `{address}` is shown"), &is_shown);
    let is_ready = "document.querySelector('.view:not([hidden])')?.dataset.state === 'ready'";
    page.until(&format!("the view `{address}` has its data"), is_ready);
    // For a second nothing more has come: the pictures are drawn.
    let is_at_rest =
        "performance.now() - Math.max(...performance.getEntriesByType('resource').map(one => one.responseEnd)) > 1000";
    page.until("the page is at rest", is_at_rest);
    let is_decoded = "[...document.querySelectorAll('.title-card, .strip')]
        .every(one => !one.checkVisibility() || !one.textContent.endsWith('…'))";
    page.until("nothing is being drawn or decoded", is_decoded);
}

/// Asks for the moving pictures of all sheep until they are there: pages then have nothing to wait for.
fn make_pictures(studio: &Studio) {
    let state = studio.get("/api/state");
    for sheep in state["sheep"].as_array().unwrap() {
        let path = format!("/media/strip/{}", sheep["strip"].as_str().unwrap());
        wait::until(&format!("the strip of {}", sheep["id"]), 120, || studio.ask("GET", &path, None).status == 200);
    }
}

#[test]
fn every_view_is_whole_named_and_readable_in_both_lights_at_every_size() {
    let flock = demo();
    let studio = Studio::of(flock.path());
    make_pictures(&studio);
    let browser = Browser::start();
    let page = Page::open(&browser, &studio.address(), DESK);
    let pictures = claims_folder().join("studio");
    fs::create_dir_all(&pictures).unwrap();
    let mut faults = String::new();
    for (view, address) in VIEWS {
        for (size, width, height, scale) in SIZES {
            for is_dark in [false, true] {
                page.resize(Window { width, height, is_dark, scale });
                visit(&page, address);
                let light = if is_dark { "dark" } else { "light" };
                page.picture(&pictures.join(format!("{view}-{size}-{light}.png")));
                for fault in page.ask(AUDIT).as_array().expect("a list") {
                    writeln!(faults, "{view}, {size}, {light}: {fault}").unwrap();
                }
            }
        }
        let controls =
            ["button", "link", "textbox", "slider", "combobox", "checkbox", "option", "searchbox", "spinbutton"];
        let silent = page.tree().into_iter().filter(|node| {
            node.name.trim().is_empty()
                && (node.is_focusable && node.role != "RootWebArea" && node.role != "generic"
                    || controls.contains(&&*node.role))
        });
        for node in silent {
            writeln!(faults, "{view}: a screen reader has no name for {node:?}").unwrap();
        }
        for complaint in page.complaints() {
            writeln!(faults, "{view}: {complaint}").unwrap();
        }
    }
    assert!(faults.is_empty(), "\n{faults}\nThe pictures lie in {}", pictures.display());
}

#[test]
fn the_page_is_small_and_asks_for_nothing_elsewhere() {
    let flock = demo();
    let studio = Studio::of(flock.path());
    let browser = Browser::start();
    let page = Page::open(&browser, &studio.address(), DESK);
    for (_, address) in VIEWS {
        visit(&page, address);
    }
    let requests = page.requests();
    let elsewhere: Vec<_> = requests.iter().filter(|address| !address.starts_with(&studio.origin())).collect();
    assert!(elsewhere.is_empty(), "{elsewhere:?}");
    let of_page = |path: &str| path == "/" || path.starts_with("/app/");
    let mut paths: Vec<_> =
        requests.iter().map(|address| address[studio.origin().len()..].split(['?', '#']).next().unwrap()).collect();
    paths.sort_unstable();
    paths.dedup();
    paths.retain(|path| of_page(path));
    assert!(paths.len() > 10, "the page is of modules: {paths:?}");
    let bytes: usize = paths.iter().map(|path| studio.ask("GET", path, None).body.len()).sum();
    assert!(bytes <= MOST_BYTES, "{bytes} bytes of code and style are sent, of at most {MOST_BYTES}");
    assert_eq!(json!(page.complaints()), json!([]));
}
