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

/// Every file, by its name, compressed by gzip.
const FILES: &[(&str, &[u8])] = include!(concat!(env!("OUT_DIR"), "/page_files.rs"));
/// The file that `/` shows.
const INDEX: &str = "index.html";

/// Where the files are.
#[derive(Clone, Debug, Default)]
pub(crate) enum Page {
    /// In the program.
    #[default]
    Embedded,
    /// In this folder, read at each request: for those who write the page. Only files that are in the program, too.
    Folder(PathBuf),
}

impl Page {
    /// The page at `/`, and its files under `/app/`.
    pub(crate) fn router(self) -> Router {
        let index = |State(page): State<Arc<Page>>| async move { page.answer(INDEX) };
        let file = |State(page): State<Arc<Page>>, Path(name): Path<String>| async move { page.answer(&name) };
        Router::new().route("/", get(index)).route("/app/{name}", get(file)).with_state(Arc::new(self))
    }

    fn answer(&self, name: &str) -> Response {
        let missing = || Problem::new(StatusCode::NOT_FOUND, "there is no such file of the page").into_response();
        let Some((name, bytes)) = FILES.iter().find(|(known, _)| *known == name) else { return missing() };
        let kind = [(header::CONTENT_TYPE, content_type(name))];
        match self {
            Self::Embedded => (kind, [(header::CONTENT_ENCODING, "gzip")], *bytes).into_response(),
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

#[cfg(test)]
mod tests {
    use super::{FILES, INDEX, content_type};
    use flate2::read::GzDecoder;
    use std::io::Read as _;

    #[test]
    fn the_page_is_there_and_asks_nothing_of_elsewhere() {
        assert!(FILES.iter().any(|(name, _)| *name == INDEX));
        for (name, bytes) in FILES {
            let mut text = String::new();
            GzDecoder::new(*bytes).read_to_string(&mut text).unwrap();
            assert!(content_type(name) != "application/octet-stream", "{name}");
            // What a drawing names its language by is no address.
            let addresses = text.replace("http://www.w3.org/", "");
            for elsewhere in ["http://", "https://", "innerHTML", "outerHTML", "insertAdjacentHTML", "document.write"] {
                assert!(!addresses.contains(elsewhere), "`{name}` has `{elsewhere}`");
            }
        }
    }
}
