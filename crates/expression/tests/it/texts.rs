//! Texts: what is read, written and refused.

use crate::bred;
use crate::drawing::Renderer;
use crate::many::many;
use expression::{Drift, ExpressionError, Genome, Loop, Map, Node, Samples, Settings, Zoom, cost};
use species::Rng;

const TIDE: &str = r#"; A comment.
(expression 1
  (name "tide \"two\"") (turns 2)
  (map (scale 1.5) (center 0 -.25) (zoom 2 .5 .25) (drift 1 .2 -.1 0))
  (light (from above) "as; (it) is")
  (picture (hsv-to-rgb (vector (warped-bw-noise x (wave 1 .25) .4 7) .8 (abs (sin (* 3 y)))))))
"#;

#[test]
fn a_text_survives_reading_and_writing_with_what_is_not_known() {
    let genome = Genome::parse(TIDE).unwrap();
    assert_eq!((genome.name.as_deref(), genome.turns), (Some("tide \"two\""), 2));
    let zoom = Some(Zoom { n: 2, by: 0.5, p: 0.25 });
    let drift = Some(Drift { n: 1, by: [0.2, -0.1], p: 0.0 });
    assert_eq!(genome.map, Map { scale: 1.5, center: [0.0, -0.25], zoom, drift });
    assert_eq!(genome.unknown, [r#"(light (from above) "as; (it) is")"#]);
    let written = genome.to_string();
    assert_eq!(Genome::parse(&written).unwrap(), genome);
    assert_eq!(Genome::parse(&written).unwrap().to_string(), written);
    assert!(written.contains("(picture (hsv-to-rgb (vector (warped-bw-noise x (wave 1 0.25) 0.4 7) 0.8"), "{written}");
}

#[test]
fn both_names_of_a_function_and_of_a_wave_are_read_and_one_is_written() {
    let written = Node::parse("(grad-dir (+ z (wave 1 -0)) -.0 1e-30)").unwrap().to_string();
    assert_eq!(written, "(grad-direction (+ z z) 0 1e-30)");
}

#[test]
fn what_is_refused_is_named_with_line_and_column() {
    let refused = |text: &str| Genome::parse(text).unwrap_err().to_string();
    let picture = |text: &str| refused(&format!("(expression 1\n (picture {text}))"));
    assert_eq!(picture("(sine x)"), "line 2, column 12: `sine` is not known");
    assert_eq!(picture("(+ x q)"), "line 2, column 16: `q` is not known");
    assert_eq!(picture("(sin x y)"), "line 2, column 12: `sin` takes 1 arguments, not 2");
    assert_eq!(picture("(wave 5 0)"), "line 2, column 17: `5` is not a whole number from 1 to 4");
    assert_eq!(picture("(+ x 1e7)"), "line 2, column 16: `1e7` is not a number from -1e6 to 1e6");
    assert_eq!(picture("(+ x -inf)"), "line 2, column 16: `-inf` is not a number from -1e6 to 1e6");
    assert_eq!(picture("#(1 2)"), "line 2, column 11: `#` takes 3 arguments, not 2");
    assert_eq!(picture("#(1 2 x)"), "line 2, column 17: `x` is not a number from -1e6 to 1e6");
    assert_eq!(picture("\"x\""), "line 2, column 11: an expression is expected");
    assert_eq!(picture("x y"), "line 2, column 2: one value is expected");
    assert_eq!(refused("(expression 1 (picture x)"), "line 1, column 26: `)` is expected");
    assert_eq!(refused("(expression 1 (picture x)) x"), "line 1, column 28: the end of the text is expected");
    assert_eq!(refused("(expression 2 (picture x))"), "line 1, column 13: `2` is not version 1");
    assert_eq!(refused("(expression 1 (turns 1))"), "line 1, column 1: a `(picture ...)` inside is expected");
    assert_eq!(
        refused("(expression 1 (picture x) (picture y))"),
        "line 1, column 27: no second form of this name is expected"
    );
    assert_eq!(
        refused("(expression 1 (map (scale 0)) (picture x))"),
        "line 1, column 27: `0` is not a scale from 0.001 to 1000"
    );
    let map = |text: &str| refused(&format!("(expression 1 (map {text}) (picture x))"));
    assert_eq!(map("(zoom 0 .5 0)"), "line 1, column 26: `0` is not a whole number from 1 to 4");
    assert_eq!(map("(zoom 1 3.5 0)"), "line 1, column 28: `3.5` is not a zoom from -3 to 3");
    assert_eq!(map("(drift 1 .5 z 0)"), "line 1, column 32: `z` is not a number from -1e6 to 1e6");
    let forms = "`(scale s)`, `(center x y)`, `(zoom n by p)` or `(drift n x y p)`";
    assert_eq!(map("(zoom 1 2)"), format!("line 1, column 20: {forms} is expected"));
}

#[test]
fn what_is_too_much_is_refused_with_its_place_and_the_limit() {
    let nested = |depth: usize| format!("(expression 1 (picture {}x{}))", "(sin ".repeat(depth), ")".repeat(depth));
    assert!(Genome::parse(&nested(62)).is_ok());
    let error = Genome::parse(&nested(63)).unwrap_err().to_string();
    assert_eq!(error, "line 1, column 334: more than 64 parentheses within each other");

    // 1 + 2 + 4 + ... + 512 sums and 1024 leaves.
    let tree = |depth: usize| (0..depth).fold("x".to_owned(), |inner, _| format!("(+ {inner} {inner})"));
    assert_eq!(Node::parse(&tree(9)).unwrap().size(), 1023);
    assert!(matches!(Node::parse(&tree(10)), Err(ExpressionError::Many { most: 2000, .. })));

    let long = format!("(expression 1 (picture x))\n{}", " ".repeat(1 << 16));
    let place = Genome::parse(&long).unwrap_err().place().unwrap();
    assert_eq!((place.line, place.column), (2, (1 << 16) - 26));

    assert!(Node::parse("(blur (grad-mag (grad-mag x)) .1)").is_err());
    assert!(Node::parse("(band-pass (grad-mag x) .1)").is_ok());
    let error = Node::parse("(blur\n (blur x .1) .1)").unwrap_err().to_string();
    assert_eq!(
        error,
        "line 2, column 3: `blur` evaluates its argument 81 times a sample, with all around it; 72 is the most"
    );
}

#[test]
fn what_would_take_for_ever_is_refused_before_it_is_drawn() {
    let sum = (0..7)
        .fold("(color-noise .3 1)".to_owned(), |inner, level| format!("(+ {inner} (warp-rel {inner} .{level} .3))"));
    let turning = Loop::new(&Genome::from(Node::parse(&sum).unwrap()), 9.0);
    let settings = Settings { size: [32, 18], samples: Samples::One, is_blurred: true };
    assert_eq!(cost(&turning, 0.0, &settings), Err(ExpressionError::Slow { most_ns: 1000.0 }));
    for size in [[0, 9], [9, 20_000]] {
        let error = cost(&turning, 0.0, &Settings { size, ..settings }).unwrap_err();
        assert!(matches!(error, ExpressionError::Size { .. }), "{error}");
    }
}

/// A text in which one name or number is replaced by another one of it.
fn exchanged(text: &str, rng: &mut Rng) -> String {
    let is_delimiter = |c: char| c.is_whitespace() || "()#".contains(c);
    let pieces: Vec<&str> = text.split_inclusive(is_delimiter).collect();
    let body = |piece: &str| piece.trim_end_matches(is_delimiter).to_owned();
    let words: Vec<usize> = (0..pieces.len()).filter(|at| !body(pieces[*at]).is_empty()).collect();
    let [to, from] = [0; 2].map(|_| words[(rng.unit() * words.len() as f64) as usize]);
    let exchanged = pieces[to].replace(&body(pieces[to]), &body(pieces[from]));
    pieces.iter().enumerate().map(|(at, piece)| if at == to { &exchanged } else { *piece }).collect()
}

/// A text with some of it deleted, doubled or replaced.
fn damaged(text: &str, rng: &mut Rng) -> String {
    const SNIPPETS: [&str; 16] =
        ["(", ")", " ", "x", "#(", "\"", "-", "1e9", "nan", "(blur", "(wave 1 ", "\u{e9}", ";", "\\", "\n", "\0"];
    let mut chars: Vec<char> = text.chars().collect();
    let mut number = |below: usize| (rng.unit() * below as f64) as usize;
    for _ in 0..=number(3) {
        let from = number(chars.len());
        let to = (from + number(8)).min(chars.len());
        let part: Vec<char> = match number(3) {
            0 => Vec::new(),
            1 => chars[from..to].iter().chain(&chars[from..to]).copied().collect(),
            _ => SNIPPETS[number(SNIPPETS.len())].chars().collect(),
        };
        chars.splice(from..to, part);
        if chars.is_empty() {
            chars.push('(');
        }
    }
    chars.into_iter().collect()
}

#[test]
fn damaged_texts_are_refused_with_their_place_or_drawn_within_their_demand() {
    let renderer = Renderer::new(1);
    let settings = Settings { size: [8, 6], samples: Samples::One, is_blurred: true };
    let mut rng = Rng::stream(12, 0);
    let (mut refused, mut drawn) = (0, 0);
    let mutants = many("MUTANTS", 1000);
    for number in 0..mutants {
        let whole = if number % 10 == 0 { TIDE.to_owned() } else { bred::genome(number / 20).to_string() };
        let text = if number % 2 == 0 { damaged(&whole, &mut rng) } else { exchanged(&whole, &mut rng) };
        let genome = match Genome::parse(&text) {
            Ok(genome) => genome,
            Err(error) => {
                let place = error.place().unwrap_or_else(|| panic!("no place: {error}"));
                let line = text.split('\n').nth(place.line - 1).unwrap();
                assert!((1..=line.chars().count() + 1).contains(&place.column), "{error}\n{text}");
                refused += 1;
                continue;
            }
        };
        assert_eq!(Genome::parse(&genome.to_string()).as_ref(), Ok(&genome), "{text}");
        let turning = Loop::new(&genome, 9.0);
        let Ok(cost) = cost(&turning, 4.0, &settings) else { continue };
        assert!(
            cost.ns_per_sample <= 1000.0 && cost.samples == [48; 2] && cost.bytes_per_thread < 50 << 20,
            "{cost:?}"
        );
        let image = renderer.render(&turning, 4.0, &settings).unwrap();
        assert!(image.pixels.as_flattened().iter().all(|light| (0.0..=1.0).contains(light)), "{text}");
        drawn += 1;
    }
    assert!(refused > mutants * 3 / 10 && drawn > mutants * 15 / 100, "{refused} refused, {drawn} drawn");
}
