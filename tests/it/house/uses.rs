//! What the files of a package use of each other.
//!
//! Owns the way from a path in a file (`crate::a::B`, `super::{a, b::C}`, `a::b()`) to the module that it leads to. A name
//! that a module has by `use` leads on to its origin for those within that module's folder; whoever is outside sees the
//! folder. What macros make and which methods are called is not seen. Judges nothing: [`super::folders`] does.
//!
//! Start at [`Modules::uses`].

use std::collections::BTreeMap;

use super::tokens::{Token, read};

/// The path of a module from the root of its package: empty for the root.
pub(super) type Place = Vec<String>;

/// The most names that are followed from one to the next.
const LONGEST_WAY: usize = 8;

/// The modules of a package that have files or are folders.
pub(super) struct Modules(BTreeMap<Place, Module>);

/// What the file of a module says; nothing for a folder without a file of its own.
#[derive(Default)]
struct Module {
    file: String,
    paths: Vec<Path>,
    /// The modules that it declares in other files.
    declared: Vec<String>,
}

/// A path in a file.
struct Path {
    parts: Vec<String>,
    /// What a `use` calls it here; `*` for all that is in it.
    name: Option<String>,
    /// Whether that name is for others, too.
    is_public: bool,
    line: usize,
    /// How many modules within the file are around it.
    inside: usize,
}

/// A module uses what another one has.
pub(super) struct Use<'m> {
    pub(super) from: &'m Place,
    pub(super) to: Place,
    /// The path of the file and the line.
    pub(super) at: String,
    /// Whether the path only gives a name to others.
    pub(super) is_export: bool,
    /// Whether the path ends at the module and names nothing in it.
    pub(super) is_module: bool,
}

impl Modules {
    /// The modules of `files`, each by its path from the root's folder, with its text.
    pub(super) fn new(files: &[(&str, &str)]) -> Self {
        let mut modules: BTreeMap<Place, Module> = BTreeMap::new();
        for (path, text) in files {
            let place = place(path);
            for above in 0..place.len() {
                modules.entry(place[..above].to_vec()).or_default();
            }
            let module = modules.entry(place).or_default();
            let mut reader = Reader { tokens: &read(path, text), module, inside: Vec::new() };
            (*path).clone_into(&mut reader.module.file);
            reader.read();
        }
        Self(modules)
    }

    /// Whether there are modules below `place`.
    pub(super) fn is_folder(&self, place: &[String]) -> bool {
        self.0.keys().any(|other| other.len() > place.len() && other.starts_with(place))
    }

    /// The names of the modules in the folder of `place`.
    pub(super) fn within(&self, place: &[String]) -> impl Iterator<Item = &str> {
        self.0.keys().filter(move |other| other.len() == place.len() + 1 && other.starts_with(place)).map(last)
    }

    /// What every module uses of the others.
    pub(super) fn uses(&self) -> Vec<Use<'_>> {
        let mut uses = Vec::new();
        for (from, module) in &self.0 {
            for path in &module.paths {
                let Some((to, rest)) = self.target(from, path, from, LONGEST_WAY) else { continue };
                let is_module = rest.is_empty() && path.name.as_deref() != Some("*");
                let at = format!("{}:{}", module.file, path.line);
                uses.push(Use { from, to, at, is_export: path.is_public, is_module });
            }
        }
        uses.retain(|found| *found.from != found.to);
        uses
    }

    /// The module that `path` in the file of `here` leads to for `user`, and what it names there; `None` outside of the
    /// package.
    fn target(&self, here: &Place, path: &Path, user: &Place, left: usize) -> Option<(Place, Vec<String>)> {
        let left = left.checked_sub(1)?;
        let supers = path.parts.iter().take_while(|part| *part == "super").count();
        match &*path.parts[0] {
            "crate" => self.below(Vec::new(), &path.parts[1..], user, left),
            "self" => self.below(here.clone(), &path.parts[1..], user, left),
            "super" => {
                let up = supers.saturating_sub(path.inside);
                let base = here[..here.len().checked_sub(up)?].to_vec();
                self.below(base, &path.parts[supers..], user, left)
            }
            first if self.0.contains_key(&joined(here, first)) => self.below(here.clone(), &path.parts, user, left),
            first => {
                let same = |other: &&Path| !std::ptr::eq(*other, path) && other.name.as_deref() == Some(first);
                let import = self.0[here].paths.iter().find(same)?;
                let (base, rest) = self.target(here, import, user, left)?;
                self.below(base, &[&rest, &path.parts[1..]].concat(), user, left)
            }
        }
    }

    /// Follows `rest` down from the module `base`.
    fn below(&self, base: Place, rest: &[String], user: &Place, left: usize) -> Option<(Place, Vec<String>)> {
        let Some(first) = rest.first() else { return Some((base, Vec::new())) };
        let (child, module) = (joined(&base, first), &self.0[&base]);
        if self.0.contains_key(&child) {
            return self.below(child, &rest[1..], user, left);
        }
        // A module whose file is elsewhere.
        if module.declared.contains(first) {
            return None;
        }
        let named = |path: &&Path| path.inside == 0 && path.name.as_ref() == Some(first);
        match module.paths.iter().find(named) {
            Some(import) if *user != base && user.starts_with(&base) => {
                let (origin, named) = self.target(&base, import, user, left)?;
                if origin == base {
                    return Some((base, rest.to_vec()));
                }
                self.below(origin, &[&named, &rest[1..]].concat(), user, left.checked_sub(1)?)
            }
            _ => Some((base, rest.to_vec())),
        }
    }
}

/// Reads the paths of a file.
struct Reader<'r> {
    tokens: &'r [Token],
    module: &'r mut Module,
    /// The depths of the modules within the file that are open.
    inside: Vec<usize>,
}

impl Reader<'_> {
    fn is(&self, at: usize, text: &str) -> bool {
        self.tokens.get(at).is_some_and(|token| token.text == text)
    }

    fn leads_on(&self, at: usize) -> bool {
        self.is(at, ":") && self.is(at + 1, ":")
    }

    fn is_word(&self, at: usize) -> bool {
        self.tokens.get(at).is_some_and(|token| token.text.starts_with(|c: char| c.is_alphabetic() || c == '_'))
    }

    fn read(&mut self) {
        let mut at = 0;
        while at < self.tokens.len() {
            self.inside.pop_if(|depth| self.tokens[at].text == "}" && self.tokens[at].depth == *depth);
            let is_start = self.is_word(at) && !(at > 1 && self.leads_on(at - 2)) && !(at > 0 && self.is(at - 1, "in"));
            if self.is(at, "mod") && self.is_word(at + 1) && self.is(at + 2, "{") {
                self.inside.push(self.tokens[at].depth);
                at += 3;
            } else if self.is(at, "mod") && self.is_word(at + 1) && self.is(at + 2, ";") {
                self.module.declared.push(self.tokens[at + 1].text.clone());
                at += 3;
            } else if self.is(at, "use") && !self.is(at + 1, "<") {
                let is_public = at > 0 && (self.is(at - 1, "pub") || self.is(at - 1, ")"));
                at = self.read_use(at + 1, &[], is_public);
            } else if is_start && self.leads_on(at + 1) {
                at = self.read_path(at);
            } else {
                at += 1;
            }
        }
    }

    /// Reads a path outside of a `use`, and returns where it ends.
    fn read_path(&mut self, start: usize) -> usize {
        let (mut at, mut parts) = (start, vec![self.tokens[start].text.clone()]);
        while self.leads_on(at + 1) && self.is_word(at + 3) {
            at += 3;
            parts.push(self.tokens[at].text.clone());
        }
        self.keep(start, parts, None, false);
        at + 1
    }

    /// Reads one path of a `use`, or a group of them, and returns where it ends.
    fn read_use(&mut self, start: usize, above: &[String], is_public: bool) -> usize {
        let (mut at, mut parts) = (start, above.to_vec());
        loop {
            match &*self.tokens[at].text {
                "{" => {
                    at += 1;
                    while !self.is(at, "}") {
                        at = self.read_use(at, &parts, is_public);
                        at += usize::from(self.is(at, ","));
                    }
                    return at + 1;
                }
                // A crate: no module of ours has an empty name.
                ":" => parts.push(String::new()),
                part => {
                    parts.push(part.to_owned());
                    at += 1;
                }
            }
            if self.leads_on(at) {
                at += 2;
                continue;
            }
            let mut name = parts.last().cloned();
            if matches!(name.as_deref(), Some("self" | "*")) && parts.len() > 1 {
                parts.pop();
                name = name.filter(|name| name == "*").or_else(|| parts.last().cloned());
            }
            if self.is(at, "as") {
                name = Some(self.tokens[at + 1].text.clone());
                at += 2;
            }
            self.keep(start, parts, name, is_public);
            return at;
        }
    }

    fn keep(&mut self, start: usize, parts: Vec<String>, name: Option<String>, is_public: bool) {
        let (line, inside) = (self.tokens[start].line, self.inside.len());
        self.module.paths.push(Path { parts, name, is_public, line, inside });
    }
}

/// The module of the file at `path`, which is relative to the root's folder.
pub(super) fn place(path: &str) -> Place {
    let mut place: Place = path.trim_end_matches(".rs").split('/').map(str::to_owned).collect();
    if last(&place) == "mod" || ["lib", "main"].contains(&last(&place)) && place.len() == 1 {
        place.pop();
    }
    place
}

fn last(place: &Place) -> &str {
    place.last().map_or("", |name| name)
}

fn joined(place: &Place, name: &str) -> Place {
    [&**place, &[name.to_owned()]].concat()
}

#[test]
fn a_path_leads_to_the_module_that_has_what_it_names() {
    let files = [
        ("lib.rs", "mod a; mod b; #[path = \"../c.rs\"] mod c; pub use b::deep::Deep; use b as other; fn own() {}"),
        ("a.rs", "mod own; use super::own; use crate::{b::{self, deep, B as Bee}, c::C, Deep}; fn a(_: b::Plain) {}"),
        ("a/own.rs", "use super::super::other::{B, deep::*}; use self::X; fn a() -> crate::a::Y { super::Bee::new() }"),
        (
            "b/mod.rs",
            "mod deep; pub use deep::Deep; use ::a::A; pub(in crate::b) fn b() -> impl Fn() + use<'_> { a() }",
        ),
        ("b/deep.rs", "use super::Deep; mod tests { use super::B; use super::super::B; fn b() { std::b::c() } }"),
    ];
    let modules = Modules::new(&files);
    let found: Vec<_> = modules
        .uses()
        .into_iter()
        .map(|found| format!("{}: {}{}", found.at, found.to.join("::"), if found.is_module { " itself" } else { "" }))
        .collect();
    assert_eq!(
        found,
        [
            "lib.rs:1: b::deep",
            "lib.rs:1: b itself",
            "a.rs:1: ",
            "a.rs:1: b itself",
            "a.rs:1: b::deep itself",
            "a.rs:1: b",
            "a.rs:1: b::deep",
            "a.rs:1: b",
            "a/own.rs:1: b",
            "a/own.rs:1: b::deep",
            "a/own.rs:1: a",
            "a/own.rs:1: b",
            "b/mod.rs:1: b::deep",
            "b/deep.rs:1: b",
        ]
    );
}
