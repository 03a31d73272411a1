//! `dreams report` for a browser and for other programs.
//!
//! Owns the claims on the page: it opens without a network, shows its pictures in light and dark mode, and no name in a
//! flock can break it; and on the graph for other programs.
//!
//! Start at [`seen`].

use claims::flocks::SMALL;
use claims::programs::{self, output};
use claims::report::{bare, dreams, report, written};
use serde_json::Value;
use std::fs;
use std::path::Path;
use std::process::Command;

/// The probe that a browser runs in the page. It is put at the top, so that it sees every error.
const PROBE: &str = r"<body><script>
  const complaints = []
  addEventListener('error', event => complaints.push(String(event.message ?? event.target)), true)
  addEventListener('securitypolicyviolation', event => complaints.push('policy: ' + event.blockedURI))
  addEventListener('load', () => {
    const all = selector => [...document.querySelectorAll(selector)]
    const sizes = () => all('.disc .share').map(disc => disc.getAttribute('r')).join(' ')
    const asWritten = sizes()
    all('.disc')[1]?.dispatchEvent(new MouseEvent('click', { bubbles: true }))
    const chosen = document.querySelector('#panel .id')?.textContent ?? null
    all('#weighing button')[1]?.click()
    const asBalanced = sizes()
    const texts = selector => all(selector).map(item => item.textContent)
    const find = part => {
      Object.assign(document.querySelector('#query'), { value: part }).dispatchEvent(new Event('input'))
      return { note: document.querySelector('#search .note').textContent, rows: texts('#search tbody tr') }
    }
    const told = JSON.stringify({
      complaints, chosen, asWritten, asBalanced, name: document.querySelector('h1').textContent, title: document.title,
      lead: document.querySelector('#lead').textContent,
      faults: all('#faults:not([hidden]) li').map(item => item.textContent),
      images: document.images.length, broken: all('img').filter(image => !image.naturalWidth).length,
      silent: all('img').filter(image => !image.hasAttribute('alt')).length,
      discs: all('.disc').length, pictured: all('.disc image').length, arrows: all('.arrows path').length,
      unplaced: all('.disc').filter(disc => !/^translate\([\d.]+ [\d.]+\)$/.test(disc.getAttribute('transform'))).length,
      rows: all('tbody tr').map(row => row.textContent), lanes: all('.lane').filter(lane => lane.style.background.includes('gradient')).length,
      pairs: all('#joins:not([hidden]) .pair').map(pair => [pair.querySelectorAll('img').length, pair.classList.contains('jumps'), pair.textContent]),
      suggested: all('#suggested:not([hidden]) li').map(item => item.textContent),
      joins: document.querySelector('#joins:not([hidden]) .note')?.textContent ?? null,
      credits: all('#credits:not([hidden]) :is(.note, li)').map(item => item.textContent),
      panel: document.querySelector('#panel')?.textContent ?? null,
      shares: document.querySelector('#shares .note')?.textContent ?? null,
      worst: texts('#worst tbody tr'), bars: texts('#ratios g').length, ratios: document.querySelector('#ratios .note')?.textContent ?? null,
      found: document.querySelector('#query') ? ['s.2999', 'S.299', 'nobody', ''].map(find) : null,
      ground: getComputedStyle(document.body).backgroundColor, ink: getComputedStyle(document.body).color,
      foreign: all('[data-foreign]').length, wide: document.documentElement.scrollWidth > innerWidth,
      asked: performance.getEntriesByType('resource').map(entry => entry.name).filter(name => !name.startsWith('data:')),
    })
    const probe = document.createElement('pre')
    probe.id = 'probe'
    probe.textContent = told
    document.body.append(probe)
  })
</script>";

/// The screen of a browser.
#[derive(Clone, Copy)]
pub(crate) struct Screen {
    pub(crate) size: &'static str,
    pub(crate) dark: bool,
}

pub(crate) const DESK: Screen = Screen { size: "1400,1000", dark: false };
const DESK_AT_NIGHT: Screen = Screen { size: "1400,1000", dark: true };

/// The page in a browser without a network: the browser's console, which must be empty, and the answer of [`PROBE`].
fn seen(page: &Path, screen: Screen) -> Value {
    seen_by(PROBE, page, screen)
}

/// The same with another probe, which answers at least what is asserted here.
pub(crate) fn seen_by(probe: &str, page: &Path, screen: Screen) -> Value {
    let text = fs::read_to_string(page).unwrap();
    let probed = page.with_file_name("probed.html");
    fs::write(&probed, text.replacen("<body>", probe, 1)).unwrap();
    let profile = tempfile::tempdir().unwrap();
    let mut chromium = Command::new("timeout");
    chromium.args(["90", "chromium", "--headless", "--no-sandbox", "--disable-gpu", "--enable-logging=stderr"]);
    chromium.arg(format!("--user-data-dir={}", profile.path().display())).arg("--host-resolver-rules=MAP * ~NOTFOUND");
    chromium.arg(format!("--window-size={}", screen.size));
    chromium.arg(format!("--blink-settings=preferredColorScheme={}", i32::from(!screen.dark)));
    chromium.args(["--virtual-time-budget=5000", "--dump-dom"]).arg(format!("file://{}", probed.display()));
    let said = output(&mut chromium);
    let console = String::from_utf8_lossy(&said.stderr);
    assert!(said.status.success(), "{console}");
    assert!(!console.contains("CONSOLE"), "the browser's console is empty: {console}");
    let dom = String::from_utf8(said.stdout).unwrap();
    let told =
        dom.split_once("<pre id=\"probe\">").expect("the page was drawn to its end").1.split_once("</pre>").unwrap().0;
    let told = told.replace("&lt;", "<").replace("&gt;", ">").replace("&nbsp;", "\u{a0}").replace("&amp;", "&");
    let told: Value = serde_json::from_str(&told).unwrap();
    assert_eq!(told["complaints"], Value::Array(vec![]), "{told}");
    assert_eq!(told["asked"], Value::Array(vec![]), "the page asks for nothing: {told}");
    assert_eq!((&told["broken"], &told["silent"], &told["foreign"]), (&0.into(), &0.into(), &0.into()), "{told}");
    assert_eq!(told["wide"], false, "nothing sticks out sideways: {told}");
    told
}

#[test]
fn a_report_opens_without_a_network_in_either_light_and_its_pictures_are_there() {
    let (_scratch, page) = report(&SMALL.flock().folder, 0);
    let day = seen(&page, DESK);
    assert_eq!((&day["name"], &day["discs"], &day["pictured"]), (&"small".into(), &5.into(), &5.into()), "{day}");
    assert_eq!((&day["arrows"], &day["unplaced"], &day["lanes"]), (&10.into(), &0.into(), &24.into()), "{day}");
    // One beside each bar, one beside each return, one in each row of the table.
    assert!(day["images"].as_u64().unwrap() >= 15, "{day}");
    let rows: Vec<&str> = day["rows"].as_array().unwrap().iter().map(|row| row.as_str().unwrap()).collect();
    assert!((0..5).all(|sheep| rows[sheep].starts_with(&format!("s{sheep}"))), "{rows:?}");
    let night = seen(&page, DESK_AT_NIGHT);
    assert_ne!(day["ground"], night["ground"], "a dark page on a dark system");
    assert_ne!(day["ink"], night["ink"]);
}

#[test]
fn the_worst_joins_are_shown_with_their_frames_and_figures() {
    // Colour bars into others of another hue: nothing meets.
    let (_scratch, page) = report(&SMALL.flock().folder, 0);
    let told = seen(&page, DESK);
    let pairs = told["pairs"].as_array().unwrap();
    assert_eq!(pairs.len(), 6, "{told}");
    assert!(pairs.iter().all(|pair| pair[0] == 2 && pair[1] == true), "{told}");
    let first = pairs[0][2].as_str().unwrap();
    assert!(first.contains(".mp4") && first.contains("jumps, ") && first.contains("dB PSNR across it"), "{first}");
    let joins = told["joins"].as_str().unwrap();
    assert!(joins.contains(" joins jump. Below are the worst: "), "{joins}");
    assert!(told["shares"].as_str().unwrap().starts_with("Bars to the right are "), "{told}");

    let demo = programs::repository().join("flock-tools/demo/small");
    let (_scratch, page) = report(&demo, 0);
    let told = seen(&page, DESK_AT_NIGHT);
    assert!(told["joins"].as_str().unwrap().starts_with("All 80 joins meet"), "{told}");
    assert!(told["pairs"].as_array().unwrap().iter().all(|pair| pair[1] == false), "{told}");
    let scratch = tempfile::tempdir().unwrap();
    let page = scratch.path().join("page.html");
    let said = dreams(&["report", "--no-joins", "--json", "--out", page.to_str().unwrap()], &demo);
    let answer: Value = serde_json::from_slice(&said.stdout).unwrap();
    assert_eq!((said.status.code(), &answer["jumps"]), (Some(0), &Value::Null));
    assert_eq!(seen(&page, DESK)["joins"], Value::Null);
}

#[test]
fn a_sheep_that_is_chosen_is_told_about_and_balancing_changes_the_shares() {
    let text = bare(9, 2).replacen("frames = 384", "frames = 384\nweight = 9", 1);
    let folder = written(&text);
    let (_scratch, page) = report(folder.path(), 0);
    let told = seen(&page, DESK);
    assert_eq!(told["chosen"], "s.1");
    let spread = |weights: &str| {
        let sizes: Vec<f64> = told[weights].as_str().unwrap().split(' ').map(|size| size.parse().unwrap()).collect();
        sizes.iter().copied().fold(0.0, f64::max) / sizes.iter().copied().fold(f64::INFINITY, f64::min)
    };
    assert!(spread("asBalanced") < spread("asWritten"), "balanced discs are more alike: {told}");
}

#[test]
fn the_credits_stand_on_the_page_of_a_flock_that_has_some() {
    let folder = written(&bare(3, 1));
    let entry = |sheep: usize, more: &str| format!("[[sheep]]\nid = \"s.{sheep}\"\nauthors = [\"Ram\"]\n{more}\n");
    let sold = entry(1, "licence = \"CC-BY-NC-3.0\"\nattribution = \"<b data-foreign>by Ram\"\nsource = \"ram.flam3\"");
    fs::write(folder.path().join("credits.toml"), entry(0, "licence = \"MIT\"") + &sold).unwrap();
    let (_scratch, page) = report(folder.path(), 0);
    let told = seen(&page, DESK);
    let credits: Vec<&str> = told["credits"].as_array().unwrap().iter().map(|item| item.as_str().unwrap()).collect();
    assert_eq!(credits[0], "Whoever shows this flock has to say: <b data-foreign>by Ram.");
    for wanted in
        ["CC-BY-NC-3.0: 1 sheep and ", "MIT: 1 sheep, may be sold", "no licence: 1 sheep and ", "Ram: 2 sheep"]
    {
        assert!(credits.iter().any(|item| item.starts_with(wanted)), "{wanted}: {credits:?}");
    }
    let panel = told["panel"].as_str().unwrap();
    assert!(panel.contains("byRamlicenceCC-BY-NC-3.0fromram.flam3"), "{panel}");
    let plain = written(&bare(3, 1));
    let (_scratch, page) = report(plain.path(), 0);
    assert_eq!(seen(&page, DESK)["credits"], Value::Array(vec![]));
}

#[test]
fn transitions_that_would_help_are_told_with_what_they_cost() {
    let folder = tempfile::tempdir().unwrap();
    let demo = programs::repository().join("flock-tools/demo/small");
    programs::succeed(Command::new("cp").arg("-r").arg(&demo).arg(folder.path().join("small")));
    let small = folder.path().join("small");
    programs::succeed(Command::new(programs::dreams()).arg("want").arg(&small).args(["selene", "6"]));
    let (_scratch, page) = report(&small, 0);
    let told = seen(&page, DESK);
    let suggested: Vec<&str> =
        told["suggested"].as_array().unwrap().iter().map(|item| item.as_str().unwrap()).collect();
    assert!(!suggested.is_empty(), "{told}");
    let costs = |told: &&str| told.contains(" billion samples to render, about ") && told.ends_with(" MB");
    assert!(suggested.iter().all(costs), "by the genomes' samples and the clips' sizes: {suggested:?}");
    // Without genomes and clips what is left is the length; a large flock is searched when it is asked for.
    let bare = |sheep| written(&bare(sheep, 2).replacen("clip = \"s0.mp4\"", "clip = \"s0.mp4\"\nwant = 40", 1));
    for (sheep, words, count) in
        [(40, &[][..], 5), (40, &["--suggest", "1"], 1), (201, &[], 0), (201, &["--suggest", "2"], 2)]
    {
        let folder = bare(sheep);
        let page = folder.path().join("page.html");
        let said = dreams(&[&["report", "--out", page.to_str().unwrap()], words].concat(), folder.path());
        assert_eq!(said.status.code(), Some(0), "{}", String::from_utf8_lossy(&said.stderr));
        let told = seen(&page, DESK);
        let suggested = told["suggested"].as_array().unwrap();
        assert_eq!(suggested.len(), count, "{sheep} {words:?}: {suggested:?}");
        // Which they are is what `dreams balance` says.
        let said = dreams(&["balance", "--suggest", "5", "--json"], folder.path());
        let balance: Value = serde_json::from_slice(&said.stdout).unwrap();
        for (told, add) in suggested.iter().zip(balance["add"].as_array().unwrap()) {
            let (from, to) = (add["from"].as_str().unwrap(), add["to"].as_str().unwrap());
            let (told, ratio) = (told.as_str().unwrap(), add["worst_ratio"].as_f64().unwrap());
            assert!(told.starts_with(&format!("{from} to {to}: worst ratio ")), "{told}, {add}");
            assert!(told.ends_with("; 384 frames, 12.8 s"), "{told}");
            let number = told.split("ratio ").nth(1).unwrap().split(';').next().unwrap();
            assert!((number.parse::<f64>().unwrap() / ratio - 1.0).abs() < 0.02, "{told}, {ratio}");
        }
    }
}

#[test]
fn three_hundred_sheep_without_a_clip_are_drawn_on_a_desk_and_on_a_phone() {
    let folder = written(&bare(300, 3));
    let (_scratch, page) = report(folder.path(), 0);
    for size in ["1400,1000", "500,900"] {
        let told = seen(&page, Screen { size, dark: false });
        assert_eq!((&told["discs"], &told["unplaced"]), (&300.into(), &0.into()));
        assert!(told["arrows"].as_u64().unwrap() > 1000 && told["lanes"] == 24);
        assert_eq!(told["rows"].as_array().unwrap().len(), 300);
        assert!(told["shares"].as_str().unwrap().starts_with("Bars upwards are "), "{}", told["shares"]);
    }
}

#[test]
fn a_large_flock_has_a_page_of_a_few_bytes_a_sheep_which_finds_every_one_of_them() {
    let wanted =
        |at: usize, want: f64| (format!("clip = \"s{at}.mp4\""), format!("clip = \"s{at}.mp4\"\nwant = {want}"));
    let [(often, much), (seldom, little)] = [wanted(2_987, 50.0), wanted(11, 0.01)];
    let text = bare(3_000, 4).replacen(&often, &much, 1).replacen(&seldom, &little, 1);
    let folder = written(&(text + "[[sheep]]\nid = \"lonely\"\nframes = 5\nclip = \"l.mp4\"\n"));
    let (_scratch, page) = report(folder.path(), 1);
    let bytes = fs::metadata(&page).unwrap().len();
    assert!(bytes < 150_000, "{bytes} bytes for 3,000 sheep");
    for size in ["1400,1000", "500,900"] {
        let told = seen(&page, Screen { size, dark: false });
        assert_eq!((&told["discs"], &told["bars"], &told["shares"]), (&0.into(), &61.into(), &Value::Null), "{told}");
        assert!(told["lead"].as_str().unwrap().starts_with("3,001 sheep and "), "{told}");
        let ratios = told["ratios"].as_str().unwrap();
        assert!(ratios.contains("1 never shown"), "{ratios}");
        let worst: Vec<&str> = told["worst"].as_array().unwrap().iter().map(|row| row.as_str().unwrap()).collect();
        assert_eq!(worst.len(), 50);
        assert!(worst[0].starts_with("lonely0") && worst[0].ends_with("never00"), "{worst:?}");
        assert!(worst[1].starts_with("s.11") && worst[2].starts_with("s.2987"), "{worst:?}");
        let found = |at: usize| {
            let rows = told["found"][at]["rows"].as_array().unwrap().iter().map(|row| row.as_str().unwrap());
            (told["found"][at]["note"].as_str().unwrap(), rows.collect::<Vec<_>>())
        };
        let (note, rows) = found(0);
        assert!(note == "1 sheep found." && rows.len() == 1 && rows[0].starts_with("s.2999"), "{note} {rows:?}");
        let (note, rows) = found(1);
        assert!(note == "11 sheep found." && rows.iter().all(|row| row.starts_with("s.299")), "{note} {rows:?}");
        assert_eq!(found(2), ("No id has that in it.", vec![]));
        assert_eq!(found(3), ("Any of the 3,001, by its id or a part of it.", vec![]));
    }
}

#[test]
fn whatever_a_flock_is_called_it_is_text() {
    let name = "</script><script data-foreign>alert(1)</script><b data-foreign>&amp; {{facts}} \u{1} \u{2028} \" ' \\";
    let quoted = serde_json::to_string(name).unwrap();
    let odd = bare(5, 1).replace("name = \"bare\"", &format!("name = {quoted}"));
    let odd =
        odd.replace("\"s.0\"", "\"__proto__\"").replace("\"s.1\"", "\"constructor\"").replace("\"s.2\"", "\"-..-\"");
    let folder = written(&odd);
    let (_scratch, page) = report(folder.path(), 0);
    let told = seen(&page, DESK);
    assert_eq!(told["name"], name);
    let rows = told["rows"].as_array().unwrap();
    assert!(rows.iter().any(|row| row.as_str().unwrap().starts_with("__proto__")), "{rows:?}");
}

#[test]
fn faults_stand_at_the_top_and_a_flock_that_cannot_walk_is_drawn_all_the_same() {
    let faulty = bare(6, 1) + "[[sheep]]\nid = \"lonely\"\nframes = 5\nclip = \"l.mp4\"\n";
    let folder = written(&faulty);
    let (_scratch, page) = report(folder.path(), 1);
    let told = seen(&page, DESK);
    assert!(
        told["faults"].as_array().unwrap().iter().any(|fault| fault.as_str().unwrap().contains("lonely")),
        "{told}"
    );
    assert_eq!(told["discs"], 7);
    let still = "format = 1\nname = \"still\"\nsize = [64, 64]\nfps = [30, 1]\n[[sheep]]\nid = \"a\"\n[[sheep]]\nid = \"b\"\n\
                 [[transition]]\nfrom = \"a\"\nto = \"b\"\nframes = 9\nclip = \"t.mp4\"\n";
    let folder = written(still);
    let (_scratch, page) = report(folder.path(), 1);
    let told = seen(&page, DESK);
    assert_eq!((&told["discs"], &told["arrows"], &told["lanes"]), (&2.into(), &1.into(), &0.into()), "{told}");
}
