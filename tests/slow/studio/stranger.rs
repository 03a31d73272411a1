//! A page from elsewhere, in the browser that has the artist's own page open.
//!
//! Owns the claim that it reads and changes nothing. Forged requests are in `it/studio/fence.rs`.

use claims::studio::browser::Browser;
use claims::studio::page::{DESK, Page};
use claims::studio::running::Studio;
use claims::studio::sheep::{SECRET_WORD, files, ring};
use claims::web::{Behaviour, WebServer};
use serde_json::json;
use std::fs;

/// What a page from elsewhere tries, at the studio's origin `STUDIO`. It tells what it could read.
const STRANGER: &str = r"(async () => {
  const read = []
  const attempt = async (what, action) => { try { const got = await action(); if (got) read.push(what + ': ' + got) } catch { } }
  const change = type => ({ method: 'POST', credentials: 'include', headers: { 'Content-Type': type },
    body: JSON.stringify({ revision: null, gesture: null, edits: [{ do: 'want', sheep: 's1', value: 7 }], force: true }) })
  const element = (tag, attribute, path) => new Promise(done => {
    const made = document.createElement(tag)
    made.onload = () => done(tag === 'iframe' ? made.contentDocument?.body?.innerText : tag + ' loaded')
    made.onerror = () => done('')
    made[attribute] = STUDIO + path
    document.body.append(made)
    setTimeout(() => done(''), 3000)
  })
  await attempt('fetch', async () => (await fetch(STUDIO + '/api/state', { credentials: 'include' })).text())
  await attempt('blind fetch', async () => (await fetch(STUDIO + '/api/state', { mode: 'no-cors', credentials: 'include' })).text())
  await attempt('edit', async () => (await fetch(STUDIO + '/api/edits', change('application/json'))).text())
  await attempt('plain edit', async () => (await fetch(STUDIO + '/api/edits', { ...change('text/plain'), mode: 'no-cors' })).text())
  await attempt('beacon', () => navigator.sendBeacon(STUDIO + '/api/undo', '{}') && '')
  await attempt('script', () => element('script', 'src', '/app/app.js'))
  await attempt('image', () => element('img', 'src', '/media/strip/nothing'))
  await attempt('frame', () => element('iframe', 'src', '/'))
  await attempt('events', () => new Promise(done => {
    const events = new EventSource(STUDIO + '/events', { withCredentials: true })
    events.onopen = () => done('open')
    events.onerror = () => done('')
  }))
  await attempt('form', () => new Promise(done => {
    const form = Object.assign(document.createElement('form'), { method: 'POST', action: STUDIO + '/api/undo', target: 'hole', enctype: 'text/plain' })
    const hole = Object.assign(document.createElement('iframe'), { name: 'hole' })
    document.body.append(hole, form)
    hole.onload = () => done(hole.contentDocument?.body?.innerText)
    form.submit()
    setTimeout(() => done(''), 3000)
  }))
  return read
})()";

#[test]
fn a_page_from_elsewhere_reads_and_changes_nothing() {
    let flock = ring(SECRET_WORD, 4, 1);
    let studio = Studio::of(flock.path());
    let browser = Browser::start();
    // The artist's own page is open beside it, with its cookie.
    let own = Page::open(&browser, &studio.address(), DESK);
    own.until("the studio's page shows the flock", &format!("document.body.innerText.includes('{SECRET_WORD}')"));
    let before = files(flock.path());
    let elsewhere = tempfile::tempdir().unwrap();
    fs::write(elsewhere.path().join("page.html"), "<!doctype html><title>elsewhere</title><body>").unwrap();
    let server = WebServer::serve(elsewhere.path(), Behaviour::Good);
    // Another port of this machine is the same site, so that it is sent the cookie; another name is not.
    let foreign = server.url().replace("127.0.0.1", "evil.example");
    for from in [server.url(), foreign] {
        let page = Page::open(&browser, &format!("{from}/page.html"), DESK);
        let read = page.ask(&STRANGER.replace("STUDIO", &format!("'{}'", studio.origin())));
        assert_eq!(read, json!([]), "from {from}");
        assert_eq!(files(flock.path()), before, "from {from}");
    }
    // A name that leads to this machine is of its own origin in the eyes of the browser, which then asks for no leave.
    let rebound = Page::open(&browser, &format!("http://evil.example:{}/", studio.port), DESK);
    let seen = rebound.ask("fetch('/api/state').then(answer => answer.status)");
    assert_eq!(seen, 421, "the browser is told that it has the wrong machine");
    let text = rebound.ask("document.documentElement.innerHTML");
    assert!(!text.to_string().contains(SECRET_WORD), "{text}");
    assert_eq!(files(flock.path()), before);
}
