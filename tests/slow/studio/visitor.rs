//! The hands and ears of the claims on the page.
//!
//! Owns the claim that what a visitor does reaches a page, and that what goes wrong there is heard.

use claims::studio::browser::Browser;
use claims::studio::page::{DESK, Page, Window};
use serde_json::json;
use std::fs;

/// A page that tells what reached it.
const LISTENING: &str = "<!doctype html><title>ears</title><style>body { color-scheme: light dark }</style>
<button id=bell>ring</button><input aria-label=word><script>
  window.heard = []
  addEventListener('keydown', event => heard.push((event.shiftKey ? 'Shift ' : '') + event.key))
  bell.onclick = () => { heard.push('rung'); console.error('too loud'); fetch('/nowhere') }
</script>";

#[test]
fn what_a_visitor_does_reaches_the_page_and_what_goes_wrong_there_is_heard() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("ears.html"), LISTENING).unwrap();
    let server = claims::web::WebServer::serve(folder.path(), claims::web::Behaviour::Good);
    let browser = Browser::start();
    let page = Page::open(&browser, &format!("{}/ears.html", server.url()), DESK);
    page.press("k");
    page.press("Shift+K");
    page.press("ArrowLeft");
    page.click("#bell");
    page.press("Tab");
    page.enter("Ram 7");
    assert_eq!(page.ask("document.querySelector('input').value"), "Ram 7");
    let heard = page.ask("heard.join()");
    assert_eq!(heard, "k,Shift K,ArrowLeft,rung,Tab,R,a,m, ,7");
    page.until("the request has failed", "performance.getEntriesByType('resource').length");
    let complaints = page.complaints().concat();
    assert!(complaints.contains("too loud") && complaints.contains("404"), "{complaints}");
    assert_eq!(page.requests().last().unwrap(), &format!("{}/nowhere", server.url()));
    let tree = page.tree();
    let button = tree.iter().find(|node| node.role == "button").unwrap();
    assert!(button.name == "ring" && button.is_focusable, "{tree:?}");
    page.resize(Window { width: 390, height: 844, is_dark: true, scale: 2 });
    assert_eq!(
        page.ask("[innerWidth, devicePixelRatio, matchMedia('(prefers-color-scheme: dark)').matches]"),
        json!([390, 2, true])
    );
    let picture = folder.path().join("picture.png");
    page.picture(&picture);
    assert!(fs::read(picture).unwrap().starts_with(b"\x89PNG"));
    for miracle in ["false", "Promise.resolve(false)"] {
        let waits = std::panic::AssertUnwindSafe(|| page.until_within("a miracle", 1, miracle));
        assert!(std::panic::catch_unwind(waits).is_err(), "{miracle}");
    }
}
