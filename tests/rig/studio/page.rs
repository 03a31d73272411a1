//! A page in Chromium, as its visitor and as its reader.
//!
//! Owns the questions to a page, the keys, the pointer, the size of its window and what it complained of. Never knows
//! the studio: that is [`super::running`].
//!
//! Start at [`Page::open`], [`Page::ask`] and [`Page::until`].

use super::browser::{Browser, PATIENCE_S};
use crate::wait;
use ct_codecs::{Base64, Decoder};
use serde_json::{Value, json};
use std::cell::RefCell;
use std::fs;
use std::path::Path;

/// The most bytes of the page's code and style, minified, and the most that are sent of it.
pub const MOST_BYTES: usize = 250_000;

/// A page. It is closed when dropped.
pub struct Page {
    browser: Browser,
    session: String,
    target: String,
    heard: RefCell<Heard>,
}

/// What a page was heard of so far.
#[derive(Default)]
struct Heard {
    /// Errors of its scripts, of its policy and of its requests, in the browser's words.
    complaints: Vec<String>,
    /// The addresses of its requests.
    requests: Vec<String>,
}

/// A window: its size in pixels of CSS, and the light.
#[derive(Clone, Copy, Debug)]
pub struct Window {
    pub width: u32,
    pub height: u32,
    pub is_dark: bool,
    /// Pixels of the screen per pixel of CSS: 2 at 200 % zoom.
    pub scale: u32,
}

/// A desk's window.
pub const DESK: Window = Window { width: 1440, height: 900, is_dark: false, scale: 1 };

/// A node of the accessibility tree: what a screen reader says of it.
#[derive(Debug)]
pub struct Node {
    pub role: String,
    pub name: String,
    pub is_focusable: bool,
}

impl Page {
    /// Opens `address` in a window of its own, and waits until it is loaded.
    pub fn open(browser: &Browser, address: &str, window: Window) -> Self {
        Self::prepared(browser, address, window, "")
    }

    /// The same; the script `before` runs before any of the page.
    pub fn prepared(browser: &Browser, address: &str, window: Window, before: &str) -> Self {
        let text = |value: &Value| value.as_str().expect("an id is a text").to_owned();
        let target = text(&browser.call("", "Target.createTarget", &json!({ "url": "about:blank" }))["targetId"]);
        let attached = browser.call("", "Target.attachToTarget", &json!({ "targetId": target, "flatten": true }));
        let session = text(&attached["sessionId"]);
        let page = Self { browser: browser.clone(), session, target, heard: RefCell::default() };
        for domain in ["Page", "Runtime", "Log", "Network", "Accessibility"] {
            page.call(&format!("{domain}.enable"), &json!({}));
        }
        page.call("Page.addScriptToEvaluateOnNewDocument", &json!({ "source": before }));
        page.resize(window);
        page.go(address);
        page
    }

    /// What a method of Chromium's protocol answers for this page.
    pub fn call(&self, method: &str, params: &Value) -> Value {
        self.browser.call(&self.session, method, params)
    }

    /// Goes to `address` and waits until it is loaded.
    pub fn go(&self, address: &str) {
        let went = self.call("Page.navigate", &json!({ "url": address }));
        assert_eq!(went.get("errorText"), None, "cannot open `{address}`");
        // Within one document only the fragment changes.
        let is_there = "location.href !== 'about:blank' && document.readyState === 'complete'";
        self.until(&format!("`{address}` is loaded"), is_there);
    }

    /// The value of `expression` in the page; promises are waited for.
    pub fn ask(&self, expression: &str) -> Value {
        self.attempt(expression).unwrap_or_else(|error| panic!("{expression}: {error}"))
    }

    fn attempt(&self, expression: &str) -> Result<Value, String> {
        let wanted =
            json!({ "expression": expression, "awaitPromise": true, "returnByValue": true, "userGesture": true });
        let mut told = self.browser.attempt(&self.session, "Runtime.evaluate", &wanted)?;
        match told.get("exceptionDetails") {
            Some(thrown) => Err(thrown["exception"]["description"].as_str().unwrap_or("it threw").to_owned()),
            None => Ok(told["result"]["value"].take()),
        }
    }

    /// Waits until `expression`, or what its promise gives, is true in the page. It is asked every 20 ms; an error counts
    /// as false, since pages that are being loaded have nothing yet.
    pub fn until(&self, what: &str, expression: &str) {
        self.until_within(what, PATIENCE_S, expression);
    }

    /// The same, for at most `seconds`.
    pub fn until_within(&self, what: &str, seconds: u32, expression: &str) {
        let (mut ticks, mut last) = (0, Ok(Value::Null));
        wait::until(what, seconds + 1, || {
            if ticks % 20 == 0 {
                last = self.attempt(&format!("Promise.resolve({expression}).then(Boolean)"));
            }
            ticks += 1;
            last == Ok(Value::Bool(true)) || ticks >= seconds * 1_000
        });
        if last != Ok(Value::Bool(true)) {
            let text = self.attempt("document.body.innerText").unwrap_or_default();
            panic!("waited {seconds} s for this: {what}; `{expression}` was {last:?} in the page {text}");
        }
    }

    /// Presses a key, written as `Enter`, `k`, `Shift+K` or `Alt+1`.
    pub fn press(&self, written: &str) {
        let (key, modifiers) = modifiers(written);
        let (code, number, text) = meaning(key);
        let is_typed = modifiers & !SHIFT == 0;
        let mut event = json!({
            "type": if is_typed && !text.is_empty() { "keyDown" } else { "rawKeyDown" }, "key": key, "code": code,
            "windowsVirtualKeyCode": number, "modifiers": modifiers,
        });
        if is_typed {
            event["text"] = text.into();
        }
        self.call("Input.dispatchKeyEvent", &event);
        event["type"] = "keyUp".into();
        self.call("Input.dispatchKeyEvent", &event);
    }

    /// Types `text`, a key after the other.
    pub fn enter(&self, text: &str) {
        for character in text.chars() {
            self.press(&character.to_string());
        }
    }

    /// Moves the pointer to a place of the window.
    pub fn point(&self, (x, y): (f64, f64)) {
        self.mouse("mouseMoved", (x, y), 0, 0);
    }

    /// Presses the pointer's button at a place.
    pub fn hold(&self, at: (f64, f64)) {
        self.point(at);
        self.mouse("mousePressed", at, 1, 0);
    }

    /// Moves the pointer to a place while its button is held.
    pub fn drag_on(&self, to: (f64, f64)) {
        self.mouse("mouseMoved", to, 1, 0);
    }

    /// Lets the pointer's button go at a place.
    pub fn release(&self, at: (f64, f64)) {
        self.mouse("mouseReleased", at, 1, 0);
    }

    /// Drags from one place to another, by ten steps.
    pub fn drag(&self, from: (f64, f64), to: (f64, f64)) {
        self.hold(from);
        for step in 1..=10 {
            let part = f64::from(step) / 10.0;
            self.drag_on((from.0 + (to.0 - from.0) * part, from.1 + (to.1 - from.1) * part));
        }
        self.release(to);
    }

    /// Clicks on the first element that `selector` finds, once it is there.
    pub fn click(&self, selector: &str) {
        self.click_at(self.middle(&format!("document.querySelector({})", json!(selector))));
    }

    /// Clicks on the control with the name `name`, once it is there: in the topmost dialog, if there is one.
    pub fn click_named(&self, name: &str) {
        let finder = format!(
            "[...([...document.querySelectorAll('dialog[open]')].at(-1) ?? document).querySelectorAll('button, a, label, summary')].find(one =>
               one.checkVisibility() && !one.disabled && (one.getAttribute('aria-label') ?? one.textContent).trim() === {})",
            json!(name)
        );
        self.click_at(self.middle(&finder));
    }

    /// Presses and lets go of the pointer's button at a place.
    pub fn click_at(&self, at: (f64, f64)) {
        self.hold(at);
        self.release(at);
    }

    /// The same with the Shift key held.
    pub fn shift_click(&self, selector: &str) {
        let at = self.middle(&format!("document.querySelector({})", json!(selector)));
        self.point(at);
        for kind in ["mousePressed", "mouseReleased"] {
            self.mouse(kind, at, 1, SHIFT);
        }
    }

    /// Turns the wheel by so many pixels down at a place.
    pub fn wheel(&self, (x, y): (f64, f64), down: f64) {
        let event = json!({ "type": "mouseWheel", "x": x, "y": y, "deltaX": 0, "deltaY": down });
        self.call("Input.dispatchMouseEvent", &event);
    }

    /// Where the middle of the element is that the expression `finder` finds, once it is there and visible; it is
    /// scrolled into view, and has not moved for a frame; one that never rests is taken after 60.
    pub fn middle(&self, finder: &str) -> (f64, f64) {
        self.until(&format!("`{finder}` is there"), &format!("({finder})?.checkVisibility()"));
        let place = self.ask(&format!(
            "(async () => {{ let item = {finder}
               item.scrollIntoView({{ block: 'nearest', inline: 'nearest', behavior: 'instant' }})
               let last, place = []
               for (let frame = 0; frame < 60 && last !== String(place); frame++) {{
                 last = String(place)
                 await new Promise(done => requestAnimationFrame(done))
                 item = {finder} ?? item
                 const box = item.getBoundingClientRect()
                 place = [box.x + box.width / 2, box.y + box.height / 2]
               }}
               return place }})()"
        ));
        let number = |at: usize| place[at].as_f64().expect("a place is numbers");
        (number(0), number(1))
    }

    fn mouse(&self, kind: &str, (x, y): (f64, f64), buttons: u32, modifiers: u32) {
        let button = if buttons == 0 { "none" } else { "left" };
        let event = json!({
            "type": kind, "x": x, "y": y, "button": button, "buttons": buttons, "clickCount": buttons, "modifiers": modifiers,
        });
        self.call("Input.dispatchMouseEvent", &event);
    }

    /// Gives the page another window.
    pub fn resize(&self, window: Window) {
        let Window { width, height, is_dark, scale } = window;
        let metrics = json!({ "width": width, "height": height, "deviceScaleFactor": scale, "mobile": false });
        self.call("Emulation.setDeviceMetricsOverride", &metrics);
        let light = if is_dark { "dark" } else { "light" };
        let features = json!([{ "name": "prefers-color-scheme", "value": light }]);
        self.call("Emulation.setEmulatedMedia", &json!({ "features": features }));
    }

    /// What a screen reader can say of the page, hidden and ignored parts left out.
    pub fn tree(&self) -> Vec<Node> {
        let told = self.call("Accessibility.getFullAXTree", &json!({}));
        let nodes = told["nodes"].as_array().expect("a tree has nodes").iter();
        let read = |node: &Value| {
            let text = |key: &str| node[key]["value"].as_str().unwrap_or_default().to_owned();
            let properties = node["properties"].as_array().into_iter().flatten();
            let is_focusable =
                properties.clone().any(|one| one["name"] == "focusable" && one["value"]["value"] == true);
            Node { role: text("role"), name: text("name"), is_focusable }
        };
        nodes.filter(|node| node["ignored"] == false).map(read).collect()
    }

    /// Writes what is seen now to `file`, as PNG.
    pub fn picture(&self, file: &Path) {
        let told = self.call("Page.captureScreenshot", &json!({ "format": "png" }));
        let text = told["data"].as_str().expect("a picture is a text");
        fs::write(file, Base64::decode_to_vec(text, None).unwrap()).unwrap();
    }

    /// What the page has complained of so far.
    pub fn complaints(&self) -> Vec<String> {
        self.hear();
        self.heard.borrow().complaints.clone()
    }

    /// The addresses that the page has requested so far, without what it made itself.
    pub fn requests(&self) -> Vec<String> {
        self.hear();
        self.heard.borrow().requests.clone()
    }

    fn hear(&self) {
        // An answer comes after the events before it.
        self.attempt("0").ok();
        let mut heard = self.heard.borrow_mut();
        for event in self.browser.events(&self.session) {
            let params = &event.params;
            match &*event.method {
                "Runtime.exceptionThrown" => {
                    let details = &params["exceptionDetails"];
                    let thrown = details["exception"]["description"].as_str().or(details["text"].as_str());
                    heard.complaints.push(thrown.unwrap_or("an error").to_owned());
                }
                "Log.entryAdded" if ["error", "warning"].map(Value::from).contains(&params["entry"]["level"]) => {
                    heard.complaints.push(format!("{}: {}", params["entry"]["text"], params["entry"]["url"]));
                }
                "Runtime.consoleAPICalled"
                    if ["error", "warning", "assert"].map(Value::from).contains(&params["type"]) =>
                {
                    heard.complaints.push(params["args"].to_string());
                }
                "Network.requestWillBeSent" => {
                    let address = params["request"]["url"].as_str().unwrap_or_default();
                    if !address.starts_with("data:") && !address.starts_with("blob:") {
                        heard.requests.push(address.to_owned());
                    }
                }
                _ => {}
            }
        }
    }
}

impl Drop for Page {
    fn drop(&mut self) {
        if !std::thread::panicking() {
            self.browser.attempt("", "Target.closeTarget", &json!({ "targetId": self.target })).ok();
        }
    }
}

/// Chromium's number of the Shift key among the modifiers.
const SHIFT: u32 = 8;

/// A written key without its modifiers, and those.
fn modifiers(written: &str) -> (&str, u32) {
    let known = [("Alt+", 1), ("Control+", 2), ("Meta+", 4), ("Shift+", SHIFT)];
    let held = known.into_iter().find(|(name, _)| written.starts_with(name) && written.len() > name.len());
    held.map_or((written, 0), |(name, number)| {
        let (key, others) = modifiers(&written[name.len()..]);
        (key, others | number)
    })
}

/// The code of a key on a keyboard for US English, its Windows number, and the text that it types.
fn meaning(key: &str) -> (String, u32, String) {
    let named = [
        ("Enter", 13, "\r"),
        ("Tab", 9, ""),
        ("Escape", 27, ""),
        ("Backspace", 8, ""),
        ("Delete", 46, ""),
        ("ArrowLeft", 37, ""),
        ("ArrowUp", 38, ""),
        ("ArrowRight", 39, ""),
        ("ArrowDown", 40, ""),
        ("PageUp", 33, ""),
        ("PageDown", 34, ""),
        ("End", 35, ""),
        ("Home", 36, ""),
        ("F10", 121, ""),
    ];
    if let Some((name, number, text)) = named.into_iter().find(|(name, ..)| *name == key) {
        return (name.to_owned(), number, text.to_owned());
    }
    let mut characters = key.chars();
    let (Some(character), None) = (characters.next(), characters.next()) else { panic!("no key `{key}`") };
    let upper = character.to_ascii_uppercase();
    let code = match character {
        ' ' => "Space".to_owned(),
        'a'..='z' | 'A'..='Z' => format!("Key{upper}"),
        '0'..='9' => format!("Digit{character}"),
        ',' | '<' => "Comma".to_owned(),
        '.' | '>' => "Period".to_owned(),
        '-' | '_' => "Minus".to_owned(),
        '=' | '+' => "Equal".to_owned(),
        '/' | '?' => "Slash".to_owned(),
        _ => String::new(),
    };
    let number = match character {
        ',' | '<' => 188,
        '.' | '>' => 190,
        '-' | '_' => 189,
        '=' | '+' => 187,
        '/' | '?' => 191,
        other => {
            if other.is_ascii_alphanumeric() || other == ' ' {
                u32::from(upper)
            } else {
                0
            }
        }
    };
    (code, number, key.to_owned())
}
