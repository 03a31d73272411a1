//! The page of all units.
//!
//! Owns its two forms: one that a server shows and that asks for itself again, and one file that needs nothing else. It is
//! complete without code: `fleet.js` only replaces it by a newer one. Every text of a report is escaped, whatever it is.
//!
//! Start at [`page`].

mod html;

use crate::finding::span;
use crate::record::{UnitView, WrongView};
use html::{coded, elapsed, escaped};

/// The style of both forms, and the code of the one that a server shows.
pub(crate) const LOOK: &str = include_str!("fleet.css");
pub(crate) const CODE: &str = include_str!("fleet.js");
/// The head of the form that a server shows.
const SERVED: &str = "<link rel=\"stylesheet\" href=\"fleet.css\">\n<script src=\"fleet.js\" defer></script>\n\
     <noscript><meta http-equiv=\"refresh\" content=\"60\"></noscript>\n";
/// The head of the file, before and after the style. A browser reads the file anew each minute.
const FILE: [&str; 2] = [
    "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; style-src 'unsafe-inline'; \
     img-src data:\">\n<meta http-equiv=\"refresh\" content=\"60\">\n<style>\n",
    "</style>\n",
];
/// What a page without units says.
const EMPTY: &str = "<p class=\"empty\">Set <code>report_to</code> in the <code>dreams.toml</code> of each unit to the \
     address of this server. A unit reports after each look for updates; its first report may take some hours.</p>";

/// Which form a page has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Form {
    File,
    Served,
}

/// The page of `views`. `picture` gives the address of a unit's picture, and is asked for units that have one.
pub(crate) fn page(views: &[UnitView], form: Form, picture: impl Fn(&UnitView) -> Option<String>) -> String {
    let wrong: Vec<_> = views.iter().filter(|view| !view.ok).collect();
    let title = if wrong.is_empty() { "Fleet".to_owned() } else { format!("({}) Fleet", wrong.len()) };
    let head = match form {
        Form::Served => SERVED.to_owned(),
        Form::File => [FILE[0], LOOK, FILE[1]].concat(),
    };
    let units = match views.len() {
        0 => "No units yet".to_owned(),
        1 => "One unit".to_owned(),
        count => format!("{count} units"),
    };
    let rows: String = views.iter().map(|view| row(view, picture(view))).collect();
    let table = if views.is_empty() { EMPTY.to_owned() } else { table(&rows) };
    format!(
        "<!doctype html>\n<html lang=\"en\">\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<link rel=\"icon\" href=\"data:,\">\n\
         <title>{title}</title>\n{head}<main id=\"fleet\">\n<header>\n<p class=\"over\">Dreams in High Fidelity</p>\n\
         <h1>{units}</h1>\n{}\n</header>\n{table}\n</main>\n\
         <p id=\"offline\" role=\"status\" hidden>The server does not answer. What is shown here is old.</p>\n",
        lead(views.len(), &wrong)
    )
}

/// The sentence at the top, with a link to each unit with which something is wrong.
fn lead(count: usize, wrong: &[&UnitView]) -> String {
    let link = |view: &&UnitView| format!("<a id=\"to-{0}\" href=\"#unit-{0}\">{0}</a>", escaped(&view.unit));
    let links: Vec<_> = wrong.iter().map(link).collect();
    match (count, &links[..]) {
        (0, _) => String::new(),
        (_, []) => "<p class=\"lead\">Nothing is wrong.</p>".to_owned(),
        (_, [one]) => format!("<p class=\"lead bad\">Something is wrong with {one}.</p>"),
        (_, all) => {
            format!("<p class=\"lead bad\">Something is wrong with {} of them: {}.</p>", all.len(), all.join(", "))
        }
    }
}

fn table(rows: &str) -> String {
    format!(
        "<table>\n<thead><tr><th scope=\"col\">Unit</th><th scope=\"col\">State</th><th scope=\"col\">Hangs there</th>\
         <th scope=\"col\">System</th><th scope=\"col\">Machine</th><th scope=\"col\">Last seen</th></tr></thead>\n\
         <tbody>\n{rows}</tbody>\n</table>"
    )
}

fn row(view: &UnitView, picture: Option<String>) -> String {
    let name = escaped(&view.unit);
    let small = |text: String| format!("<small>{text}</small>");
    let address = view.address.as_ref().map(|address| small(escaped(address))).unwrap_or_default();
    let picture = picture.map(|src| {
        format!("<img src=\"{}\" alt=\"the picture of {name} at its last report\" loading=\"lazy\">", escaped(&src))
    });
    let number = view.sequence.map(|sequence| format!(" <span class=\"dim\">{sequence}</span>")).unwrap_or_default();
    let flock = view.flock.as_ref().map(|flock| {
        let since = view
            .flock_since
            .as_ref()
            .zip(view.flock_age_s)
            .map(|(date, age_s)| small(elapsed(date, &format!("for {}", span(age_s)))));
        format!("<div><b>{}</b>{number}{}</div>", escaped(flock), since.unwrap_or_default())
    });
    let system = view.system.as_ref().map(|system| {
        let slot = view.slot.as_ref().map(|slot| format!(" <span class=\"dim\">slot {}</span>", escaped(slot)));
        format!("{}{}", escaped(system), slot.unwrap_or_default())
    });
    let programs = view.programs.as_ref().map(|programs| small(format!("programs {}", escaped(programs))));
    let seen = view.last_seen.as_ref().zip(view.age_s);
    let seen = seen.map(|(date, age_s)| elapsed(date, &format!("{} ago", span(age_s))));
    let dash = || "<span class=\"dim\">–</span>".to_owned();
    let or_dash = |text: String| if text.is_empty() { dash() } else { text };
    let class = if view.ok { "fine" } else { "wrong" };
    let cells = [
        ("State", state(view)),
        ("Hangs there", or_dash([picture, flock].into_iter().flatten().collect())),
        ("System", or_dash([system, programs].into_iter().flatten().collect())),
        ("Machine", or_dash(machine(view))),
        ("Last seen", seen.unwrap_or_else(|| "never".to_owned())),
    ];
    let cell = |(head, text): (&str, String)| format!("<td data-head=\"{head}\"><div>{text}</div></td>\n");
    let cells: String = cells.into_iter().map(cell).collect();
    format!(
        "<tr id=\"unit-{name}\" class=\"{class}\" tabindex=\"-1\">\n<th scope=\"row\">{name}{address}</th>\n{cells}</tr>\n"
    )
}

/// What is wrong, each with what to do; then the remarks.
fn state(view: &UnitView) -> String {
    let wrong = |wrong: &WrongView| {
        let since =
            wrong.since.as_ref().map(|since| format!(" title=\"since {}\"", escaped(since))).unwrap_or_default();
        format!(
            "<li{since}><b>{}</b> {} <em>{}</em></li>",
            escaped(&wrong.kind.replace('-', " ")),
            escaped(&wrong.what),
            coded(wrong.advice)
        )
    };
    let remark = |remark: &String| format!("<li class=\"remark\">{}</li>", escaped(remark));
    let items: String = view.wrong.iter().map(wrong).chain(view.remarks.iter().map(remark)).collect();
    let fine = if view.ok { "<span class=\"good\">fine</span>" } else { "" };
    if items.is_empty() { fine.to_owned() } else { format!("{fine}<ul>{items}</ul>") }
}

/// Temperature, disk and running time.
fn machine(view: &UnitView) -> String {
    let disk = view.disk.unwrap_or_default();
    let parts = [
        view.temperature_c.map(|degrees| format!("{degrees:.0} °C")),
        disk.free_bytes.map(|free| format!("{} free", crate::finding::size(free))),
        disk.worn_percent.map(|worn| format!("{worn} % worn")),
        view.uptime_s.map(|uptime_s| format!("up {}", span(uptime_s))),
    ];
    let parts: Vec<_> = parts.into_iter().flatten().map(|part| format!("<span class=\"part\">{part}</span>")).collect();
    parts.join(" ")
}

#[cfg(test)]
mod tests {
    use super::{CODE, Form, LOOK, page};
    use crate::facts::Facts;
    use crate::record::{Noted, Record, UnitView};
    use serde_json::json;

    #[test]
    fn no_text_of_a_report_is_anything_but_text() {
        let evil = "</style></td><script>alert(1)</script><img src=x onerror='alert(2)' alt=\"";
        let report = json!({"unit": "lobby", "error": evil,
            "status": {"flock": evil, "faults": 1, "latest_faults": [{"message": evil}]},
            "machine": {"system": evil, "programs": evil, "slot": evil, "address": evil,
                "rolled_back": {"from": evil, "why": evil}}});
        let facts = Facts::parse(report.to_string().as_bytes()).unwrap().0;
        let noted = Noted::after(None, &facts, 100);
        let view = UnitView::of(&Record { facts, noted }, 100, 60);
        let clean = UnitView { wrong: Vec::new(), remarks: Vec::new(), ..UnitView::clone(&view) };
        for form in [Form::Served, Form::File] {
            let text = page(&[view.clone(), clean.clone()], form, |_| None);
            assert!(!text.contains("<script>") && !text.contains("<img") && !text.contains("onerror='"), "{text}");
            assert!(text.matches("&lt;script&gt;alert(1)").count() >= 8, "{text}");
            let ends = usize::from(form == Form::File);
            assert_eq!(text.matches("</style>").count(), ends);
        }
    }

    #[test]
    fn nothing_on_the_page_comes_from_elsewhere() {
        for text in [LOOK, CODE, &page(&[], Form::File, |_| None), &page(&[], Form::Served, |_| None)] {
            for word in ["http:", "https:", "//www", "@import", "url(", "innerHTML", "outerHTML", "</script><"] {
                assert!(!text.contains(word), "`{word}`");
            }
        }
        assert!(page(&[], Form::File, |_| None).contains("default-src 'none'"), "the browser holds the file to it");
    }
}
