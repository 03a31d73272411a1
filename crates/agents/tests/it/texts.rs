//! Texts: read, refused by name, kept and written again.

use crate::bred::{self, SMALL, globe, many, read, settings, sketch};
use agents::{Agents, AgentsError, Globe, MOST_BYTES, Pfeiffer, crossover};
use species::{Genome, RenderError, Rng, Species, Threads};

#[test]
fn pfeiffers_own_agent_has_three_twelve_and_forty_eight_segments() {
    let segments = |it: &str| Pfeiffer::read(&format!("v=60&str=F++F++F&it={it}&sc=5")).segments();
    assert_eq!(["0", "1", "2", "3"].map(segments), [3, 12, 48, 192]);
    // A damaged parameter means its default, and where nothing is extended, 2000 segments are the most.
    assert_eq!(["", "two", "2&it=-3"].map(segments), [48; 3]);
    assert_eq!(segments("9"), 2000);
}

#[test]
fn half_of_all_crossovers_keep_the_length_and_a_quarter_each_is_one_longer_or_shorter() {
    let (first, second) = ("v=60&str=F++F++F&it=2&sc=5", "v=72&str=F+F+F+F+F+F+F+F&it=3&sc=4&sw=3");
    let (mut rng, mut counts, rounds) = (Rng::stream(1, 0), [0_u32; 3], 40_000);
    let mut others = 0;
    for _ in 0..rounds {
        let length = crossover(first, second, &mut rng).len() + 1 - first.len();
        // A piece of no characters cannot be shorter.
        counts.get_mut(length).map_or_else(|| others += 1, |count| *count += 1);
    }
    let share = |count: u32| f64::from(count) / f64::from(rounds);
    assert_eq!(others, 0);
    let [shorter, equal, longer] = counts.map(share);
    assert!((equal - 0.5).abs() < 0.02 && (shorter - 0.25).abs() < 0.02 && (longer - 0.25).abs() < 0.02, "{counts:?}");
    let drift = (0..1000).map(|_| crossover(first, "v=1", &mut rng).len()).sum::<usize>();
    assert!(drift < 1000 * first.len() * 9 / 10, "shorter seconds give shorter children: {drift}");
}

#[test]
fn a_text_survives_reading_and_writing_with_what_is_not_known() {
    let text =
        format!("later = 2026-01-01\n{SMALL}mood = \"calm\"\n[agents.notes]\nby = 'me'\n[[more]]\na = [1.5, nan]\n");
    let globe = Globe::parse(&text).unwrap();
    let written = globe.text();
    assert_eq!(Globe::parse(&written).unwrap(), globe, "{written}");
    for kept in ["later = 2026-01-01", "mood = \"calm\"", "[agents.notes]", "by = \"me\"", "[[more]]", "a = [1.5, nan]"]
    {
        assert!(written.contains(kept), "`{kept}` is lost: {written}");
    }
    assert_eq!(globe.text(), Globe::parse(&written).unwrap().text());
    assert_eq!(Genome::name(&globe), Some("small"));
    let recipe = |text: &str| read(text).recipe(&settings([16, 9]));
    assert_eq!(recipe(&text), recipe(SMALL), "what means nothing to pictures is no part of their recipe");
    assert_ne!(recipe(SMALL), recipe(&SMALL.replace("drift = 7", "drift = 8")));
    for seed in 0..many("GENOMES", 40) {
        let globe = bred::globe(seed);
        assert_eq!(read(&globe.text()).text(), globe.text(), "{seed}");
        assert_eq!(Globe::parse(&globe.text()).as_ref().ok(), globe.as_any().downcast_ref(), "{seed}");
    }
}

#[test]
fn files_are_known_by_how_they_begin() {
    for text in ["[agents]", "\n# mine\n [agents]\n", "\u{feff}[agents]", "x = 1\n[agents]\n", "agents = { }"] {
        assert!(Agents.begins(text), "{text}");
    }
    for text in ["", "<flame/>", "(expression 1 x)", "[plant]\n", "[agent]\n", "agents", "# [agents]"] {
        assert!(!Agents.begins(text), "{text}");
    }
    assert!(SMALL.trim_start().starts_with("[agents]") && Agents.begins(&globe(0).text()));
}

/// What is done to the small file, and the start of what is said then.
const REFUSED: [(&str, &str, &str); 20] = [
    ("[agents]", "[agent]", "line 1, column 1: `[agents]` is missing"),
    ("[agents]", "agents = 3", "line 2, column 10: `agents` is `3`, not a table"),
    ("[agents]", "[agents", "line 2, column 8: "),
    ("version = 1", "version = 2", "line 3, column 11: `version` is `2`, not 1, the only version"),
    ("\"small\"", "7", "line 4, column 8: `name` is `7`, not a text of up to 80 characters"),
    ("\"small\"", "\"a\\nb\"", "line 4, column 8: `name` is `\"a\\nb\"`, not a text of up to 80"),
    ("\"#0e1630\", ", "", "line 5, column 14: `background` is `[\"#223054\"]`, not two colours"),
    ("#0e1630", "#0e163g", "line 5, column 15: `background` is `\"#0e163g\"`, not a colour as `#80c0ff`"),
    ("[\"#96cdff\", \"#ebf5ff\", \"#7896fa\"]", "[]", "line 6, column 11: `palette` is `[]`, not a list of 1 to 16"),
    ("drift = 7", "drift = -1", "line 7, column 9: `drift` is `-1`, not a whole number from 0 to 4294967295"),
    ("drift = 7", "drift = 1e3", "line 7, column 9: `drift` is `1e3`, not a whole"),
    ("glow = 1.25", "glow = nan", "line 8, column 8: `glow` is `nan`, not a number from 0 to 4"),
    ("glow = 1.25", "glow = inf", "line 8, column 8: `glow` is `inf`, not a number from 0 to 4"),
    ("dust = 30", "dust = 401", "line 9, column 8: `dust` is `401`, not a whole number from 0 to 400"),
    ("flock", "sheep", "line 2, column 1: `flock` is missing"),
    ("\"v=72&str=F+F+F+F+F\"", "4", "line 14, column 3: `flock` is `4`, not a text of up to 4096 characters"),
    ("v=72&str=F+F+F+F+F", "it=0&str=F", "line 14, column 3: agent 4 has 2 different points, at least 3 are needed"),
    ("v=72&str=F+F+F+F+F", "v=0", "line 14, column 3: agent 4 has a box whose shorter side is 0.00 % of the picture's"),
    (
        "v=72&str=F+F+F+F+F",
        "it=1&sc=1",
        "line 14, column 3: agent 4 has a box whose shorter side is 0.75 % of the picture's height, at least 1 % is needed",
    ),
    ("v=72&str=F+F+F+F+F", "it=3&sc=2&c=9", "line 14, column 3: agent 4 draws what agent 1 draws"),
];

#[test]
fn what_is_refused_is_named_with_its_line_and_column() {
    for (from, to, said) in REFUSED {
        let text = SMALL.replacen(from, to, 1);
        assert_ne!(text, SMALL, "{from}");
        let error = Globe::parse(&text).unwrap_err();
        assert!(error.to_string().starts_with(said), "{to}: {error}");
        assert!(error.place().is_some());
    }
    let long = format!("{SMALL}# {}", "x".repeat(MOST_BYTES));
    assert!(matches!(Globe::parse(&long), Err(AgentsError::Long { most: MOST_BYTES, .. })));
    let heavy: Vec<String> = (0..4).map(|k| format!("\"v=9{k}&str=F&it=20&rules=('F','F+F')\"")).collect();
    let heavy = format!("[agents]\nflock = [{}]", heavy.join(","));
    assert!(matches!(Globe::parse(&heavy), Err(AgentsError::Heavy { agent: 4, segments: 80_000, .. })));
    let nested = format!("[agents]\nx = {}", "[".repeat(30_000));
    assert!(matches!(Globe::parse(&nested), Err(AgentsError::Syntax { .. })));
    let dotted = format!("[agents{}]", ".a".repeat(30_000));
    assert!(matches!(Globe::parse(&dotted), Err(AgentsError::Syntax { .. })));
}

/// `text` with up to four things done to it.
fn mutated(text: &str, others: &[String], rng: &mut Rng) -> String {
    let mut below = |count: usize| (rng.unit() * count as f64) as usize;
    let mut bytes = text.as_bytes().to_vec();
    for _ in 0..=below(4) {
        let at = below(bytes.len() + 1);
        let other = others[below(others.len())].as_bytes();
        match below(8) {
            0 if at < bytes.len() => bytes[at] ^= 1 << below(7),
            1 if below(8) == 0 => bytes.truncate(at),
            2 => bytes.insert(at, b"\n \"=&[]{}#'-+.,019eFXv"[below(22)]),
            3 => bytes = [&bytes[..at], &other[at.min(other.len())..]].concat(),
            4 => bytes = [&bytes[..at], &other[below(other.len())..][..0], &bytes[at..]].concat(),
            5 if at + 9 < bytes.len() => {
                let digit = b"0123456789"[below(10)];
                bytes[at..at + 9].iter_mut().filter(|byte| byte.is_ascii_digit()).for_each(|byte| *byte = digit);
            }
            6 if at + 5 < bytes.len() => drop(bytes.drain(at..at + 1 + below(4))),
            _ if at < bytes.len() => drop(bytes.remove(at)),
            _ => {}
        }
    }
    String::from_utf8_lossy(&bytes).into_owned()
}

#[test]
fn any_text_is_refused_by_name_or_drawn_within_its_demand() {
    let threads = Threads::new(1).unwrap();
    let texts: Vec<String> = (0..6).map(|seed| globe(seed).text()).chain([SMALL.to_owned()]).collect();
    let (mut drawn, mutants) = (0, many("MUTANTS", 3000));
    for number in 0..mutants {
        let mut rng = Rng::stream(number, 5);
        let text = mutated(&texts[number as usize % texts.len()], &texts, &mut rng);
        match Globe::parse(&text) {
            Ok(globe) => {
                drawn += 1;
                assert_eq!(Globe::parse(&globe.text()).as_ref(), Ok(&globe), "mutant {number}: {text}");
                let (settings, frame) = (sketch([16, 9]), rng.unit() * 100.0);
                let motion = globe.turning(settings.size, 60.0);
                let demand = motion.demand(frame, &settings).unwrap();
                let picture = motion.frame(frame, &settings, &threads).unwrap();
                assert_eq!(picture.samples, demand.samples, "mutant {number}: {text}");
                let is_light = |light: &f32| (0.0..=1.0).contains(light);
                assert!(picture.image.pixels.as_flattened().iter().all(is_light), "mutant {number}: {text}");
            }
            Err(error) => {
                let said = error.to_string();
                assert!(
                    said.starts_with("line ") && said.contains(", column ") && said.len() < 600,
                    "{number}: {said}"
                );
            }
        }
    }
    assert!(drawn > mutants / 10 && drawn < mutants * 9 / 10, "{drawn} of {mutants} were drawn");
}

#[test]
fn sizes_that_cannot_be_drawn_are_refused() {
    let globe = read(SMALL);
    for size in [[0, 9], [16, 0], [16_385, 9]] {
        let error = globe.turning(size, 9.0).demand(0.0, &settings(size)).unwrap_err();
        assert!(matches!(error, RenderError::Refused(_)) && error.to_string().contains("1 to 16384 are possible"));
    }
}
