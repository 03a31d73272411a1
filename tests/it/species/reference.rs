//! The page on files says what the species read.
//!
//! Owns the claims on `docs/genomes.md`: its lists are the code's.

use std::collections::BTreeSet;

use agents::{Agents, PARAMETERS};
use expression::{Expressions, FUNCTIONS, Genome};
use plant::{GENES, Plants};
use species::{Breed, Rng, Species};

const PAGE: &str = include_str!("../../../docs/genomes.md");

/// The part of the page under a heading, up to the next one that is no deeper.
fn under(heading: &str) -> &'static str {
    let (_, rest) = PAGE.split_once(&format!("\n{heading}\n")).unwrap_or_else(|| panic!("no `{heading}`"));
    let depth = heading.len() - heading.trim_start_matches('#').len();
    let ends = (2..=depth).filter_map(|depth| rest.find(&format!("\n{} ", "#".repeat(depth))));
    &rest[..ends.min().unwrap_or(rest.len())]
}

/// What is in code in the first column of the tables of a text, and the rest of the row.
fn rows(text: &'static str) -> Vec<(Vec<&'static str>, &'static str)> {
    let row = |line: &'static str| {
        let (first, rest) = line.strip_prefix("| ")?.split_once(" | ")?;
        let code: Vec<&str> = first.split('`').skip(1).step_by(2).collect();
        if code.is_empty() { None } else { Some((code, rest)) }
    };
    text.lines().filter_map(row).collect()
}

fn names(text: &'static str) -> Vec<&'static str> {
    rows(text).into_iter().flat_map(|(code, _)| code).collect()
}

#[test]
fn the_page_lists_every_function_with_its_arguments() {
    let mut listed = BTreeSet::new();
    for (calls, meaning) in rows(under("### Functions")) {
        for call in calls {
            let mut words = call.trim_matches(['(', ')']).split(' ');
            let name = words.next().unwrap();
            assert!(listed.insert((name, words.count())), "`{name}` is there twice");
            let also = expression::Function::named(name).unwrap_or_else(|| panic!("no `{name}`")).also;
            assert!(also.is_none_or(|also| meaning.contains(&format!("also `{also}`"))), "`{name}`: {meaning}");
        }
    }
    assert_eq!(listed, FUNCTIONS.iter().map(|function| (function.name, function.arguments.len())).collect());
}

#[test]
fn what_the_page_says_of_expressions_is_read() {
    let example = under("## Expressions").split("```").nth(1).unwrap().trim_start_matches("lisp\n");
    assert_eq!(Genome::parse(example).unwrap().name.as_deref(), Some("tide"));
    for (code, _) in rows(under("### Leaves")) {
        for leaf in code {
            let leaf = leaf.replace(" n p)", " 2 .5)");
            assert!(Genome::parse(&format!("(expression 1 (picture {leaf}))")).is_ok(), "{leaf}");
        }
    }
    for form in names(under("### The map")) {
        let filled: Vec<&str> = form.split(' ').map(|word| if word.starts_with('(') { word } else { "2" }).collect();
        let text = format!("(expression 1 (map {})) (picture x))", filled.join(" "));
        assert!(Genome::parse(&text).is_ok(), "{text}");
    }
    // The writer knows of no further form.
    let all = "(expression 1 (turns 2) (map (zoom 1 2 0) (drift 1 2 3 0)) (name \"a\") (lineage) (picture x))";
    let written = Genome::parse(all).unwrap().to_string();
    let forms = written.split('(').skip(1).filter_map(|form| form.split([' ', ')']).next());
    let unsaid: Vec<&str> = forms.filter(|form| !PAGE.contains(&format!("({form}")) && *form != "lineage").collect();
    assert_eq!(unsaid, [""; 0], "{written}");
}

/// Asserts that a species reads just these keys of its table: each is refused with a value that makes no sense, which says
/// so of a key that is known, and nothing else is written.
fn reads(species: &dyn Breed, example: &str, keys: &BTreeSet<&str>) {
    assert!(species.parse(example).is_ok(), "{example}");
    let (head, entries) = example.split_once('\n').unwrap();
    for key in keys {
        let rest: Vec<&str> = entries.lines().filter(|line| !line.starts_with(&format!("{key} ="))).collect();
        let odd = format!("{head}\n{key} = {{ odd = 1 }}\n{}", rest.join("\n"));
        let refusal = species.parse(&odd).err().unwrap_or_else(|| panic!("`{key}` is not known: {odd}"));
        assert!(refusal.to_string().contains(&format!("`{key}`")), "{refusal}");
    }
    let written = species.random(&mut Rng::stream(3, 38)).text();
    let written = written.lines().filter_map(|line| line.split_once(" = ")).map(|(key, _)| key.trim());
    let unsaid: Vec<&str> = written.filter(|key| !keys.contains(key)).collect();
    assert_eq!(unsaid, [""; 0], "{}", species.name());
}

#[test]
fn the_page_lists_every_key_of_agents_and_every_parameter_of_one() {
    let all = rows(under("## Agents")).into_iter().map(|(code, _)| code[0]);
    let (parameters, keys): (BTreeSet<&str>, BTreeSet<&str>) = all.partition(|name| PARAMETERS.contains(name));
    assert_eq!(parameters, PARAMETERS.into_iter().collect());
    reads(&Agents, under("## Agents").split("```").nth(1).unwrap().trim_start_matches("toml\n"), &keys);
}

#[test]
fn the_page_lists_every_key_of_plants_and_every_gene_with_its_range() {
    let genes: Vec<String> = GENES
        .iter()
        .map(|gene| {
            let [low, high, default] = [gene.low, gene.high, gene.default];
            format!("{} | {low} to {high} | {default} |", gene.meaning)
        })
        .collect();
    let (mut listed, mut keys) = (Vec::new(), BTreeSet::new());
    for (code, rest) in rows(under("## Plants")) {
        keys.extend(&code);
        if GENES.iter().any(|gene| gene.name == code[0]) {
            listed.push(rest);
        }
    }
    assert_eq!(listed, genes);
    reads(&Plants, under("## Plants").split("```").nth(1).unwrap().trim_start_matches("toml\n"), &keys);
}

#[test]
fn all_three_keep_a_lineage_as_the_page_says() {
    for (species, text) in [
        (&Expressions as &dyn Species, "(expression 1 (lineage (parents \"a\")) (picture x))"),
        (&Agents, "[agents]\nflock = [\"v=72&str=F+F+F+F+F\"]\n[lineage]\nparents = [\"a\"]\n"),
        (&Plants, "[plant]\nversion = 1\n[lineage]\nparents = [\"a\"]\n"),
    ] {
        assert_eq!(species.parse(text).unwrap().lineage().parents, ["a"], "{text}");
    }
}
