//! The files of the page.
//!
//! Owns their table, which `build.rs` makes of the folder `page/`, and their content types. A file is found by its name in
//! the table, never by a path.
//!
//! Start at [`Page::router`].

use std::fs;
use std::path::PathBuf;
use std::sync::Arc;

use axum::Router;
use axum::extract::{Path, State};
use axum::http::{StatusCode, header};
use axum::response::{IntoResponse, Response};
use axum::routing::get;

use crate::answer::Problem;

/// Every file, by its name.
const FILES: &[(&str, &[u8])] = include!(concat!(env!("OUT_DIR"), "/page_files.rs"));
/// The file that `/` shows.
const INDEX: &str = "index.html";

/// Where the files are.
#[derive(Clone, Debug, Default)]
pub enum Page {
    /// In the program.
    #[default]
    Embedded,
    /// In this folder, read at each request: for those who write the page. Only files that are in the program, too.
    Folder(PathBuf),
}

impl Page {
    /// The page at `/`, and its files under `/app/`.
    pub fn router(self) -> Router {
        let index = |State(page): State<Arc<Page>>| async move { page.answer(INDEX) };
        let file = |State(page): State<Arc<Page>>, Path(name): Path<String>| async move { page.answer(&name) };
        Router::new().route("/", get(index)).route("/app/{name}", get(file)).with_state(Arc::new(self))
    }

    /// The names of all files, with their bytes.
    pub fn files() -> &'static [(&'static str, &'static [u8])] {
        FILES
    }

    fn answer(&self, name: &str) -> Response {
        let missing = || Problem::new(StatusCode::NOT_FOUND, "there is no such file of the page").into_response();
        let Some((name, bytes)) = FILES.iter().find(|(known, _)| *known == name) else { return missing() };
        let kind = [(header::CONTENT_TYPE, content_type(name))];
        match self {
            Self::Embedded => (kind, *bytes).into_response(),
            Self::Folder(folder) => {
                fs::read(folder.join(name)).map_or_else(|_| missing(), |bytes| (kind, bytes).into_response())
            }
        }
    }
}

fn content_type(name: &str) -> &'static str {
    match name.rsplit_once('.').map_or("", |(_, ending)| ending) {
        "css" => "text/css; charset=utf-8",
        "html" => "text/html; charset=utf-8",
        "js" => "text/javascript; charset=utf-8",
        "json" => "application/json",
        "svg" => "image/svg+xml",
        "woff2" => "font/woff2",
        _ => "application/octet-stream",
    }
}

/// What `build.rs` does to scripts and styles.
#[cfg(test)]
#[path = "../lean.rs"]
mod lean;

#[cfg(test)]
mod tests {
    use super::lean::{lean, lean_style};
    use super::{FILES, INDEX, content_type};

    /// The most bytes of the page's code and style as it is served.
    const MOST_BYTES: usize = 250_000;

    #[test]
    fn the_page_is_there_is_small_and_asks_nothing_of_elsewhere() {
        assert!(FILES.iter().any(|(name, _)| *name == INDEX));
        let all: usize = FILES.iter().map(|(_, bytes)| bytes.len()).sum();
        assert!(all <= MOST_BYTES, "{all} bytes");
        for (name, bytes) in FILES {
            let text = String::from_utf8_lossy(bytes);
            assert!(content_type(name) != "application/octet-stream", "{name}");
            // What a drawing names its language by is no address.
            let addresses = text.replace("http://www.w3.org/", "");
            for elsewhere in ["http://", "https://", "innerHTML", "outerHTML", "insertAdjacentHTML", "document.write"] {
                assert!(!addresses.contains(elsewhere), "`{name}` has `{elsewhere}`");
            }
        }
    }

    #[test]
    fn a_script_loses_comments_and_no_letter_of_its_texts() {
        for (script, left) in [
            ("/** A. */\nconst a = 1; // one\n\n  f(a,\n    2)\n", "const a=1;f(a,2)\n"),
            ("let a = 'x // y'\nlet b = \"/* z */\"", "let a='x // y'\nlet b=\"/* z */\""),
            ("t = `a // ${ f(`b  ${ {c: 1} }`) }\n  d`", "t=`a // ${ f(`b  ${ {c: 1} }`) }\n  d`"),
            ("a = b / c / d; e = /[/'] \\/\"/g.test(f)", "a=b/c/d;e=/[/'] \\/\"/g.test(f)"),
            ("return a\n++b", "return a\n++b"),
            ("x = a + +b - -c", "x=a+ +b- -c"),
            ("async () => { await it; }", "async()=>{await it;}"),
        ] {
            assert_eq!(lean(script), left, "{script}");
        }
    }

    #[test]
    fn a_style_loses_comments_and_spaces_that_mean_nothing() {
        let style = "/* A. */\n.wall > .cell {\n  margin: 0 auto; color: red; /* b */\n}\n";
        assert_eq!(lean_style(style), ".wall > .cell{\nmargin:0 auto;color:red;\n}\n");
    }
}
