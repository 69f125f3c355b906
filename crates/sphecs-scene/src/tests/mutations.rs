//! Reading any text never panics.

use std::cell::Cell;
use std::path::PathBuf;

use proptest::prelude::{ProptestConfig, Strategy, any, prop_assert, prop_oneof, proptest};
use proptest::sample::{Index, select};
use proptest::test_runner::TestRunner;
use rustix::time::{ClockId, clock_gettime};

use super::shipped::shipped;
use crate::{Scene, seeds};

/// A change of a text.
#[derive(Clone, Debug)]
enum Mutation {
    Delete(Index, usize),
    Insert(Index, String),
    Replace(Index, String),
    Repeat(Index, usize),
}

fn snippet() -> impl Strategy<Value = String> {
    let snippets = [
        "(",
        ")",
        "[",
        "]",
        "{",
        "}",
        ",",
        ":",
        "\"",
        "-",
        "1e999",
        "NaN",
        "inf",
        "-1",
        "0",
        "1e-300",
        "None",
        "Some(",
        "\"x^\"",
        "\"1/0\"",
        "//",
        "/*",
        "*/",
        "é",
        "\\",
        "r#\"",
        "true",
        "Box(",
        "99999999999999999999",
        "\"((((\"",
        "\"t\"",
        "'",
        "0.0",
        "\u{0}",
    ];
    prop_oneof![select(snippets.to_vec()).prop_map(str::to_owned), any::<char>().prop_map(String::from)]
}

fn mutation() -> impl Strategy<Value = Mutation> {
    prop_oneof![
        (any::<Index>(), 1..40_usize).prop_map(|(at, length)| Mutation::Delete(at, length)),
        (any::<Index>(), snippet()).prop_map(|(at, text)| Mutation::Insert(at, text)),
        (any::<Index>(), snippet()).prop_map(|(at, text)| Mutation::Replace(at, text)),
        (any::<Index>(), 1..60_usize).prop_map(|(at, length)| Mutation::Repeat(at, length)),
    ]
}

fn mutated(text: &str, mutations: &[Mutation]) -> String {
    let mut characters: Vec<char> = text.chars().collect();
    for mutation in mutations {
        let length = characters.len().max(1);
        match mutation {
            Mutation::Delete(at, count) => {
                let at = at.index(length).min(characters.len());
                characters.drain(at..(at + count).min(characters.len()));
            }
            Mutation::Insert(at, text) => {
                let at = at.index(length).min(characters.len());
                characters.splice(at..at, text.chars());
            }
            Mutation::Replace(at, text) => {
                let at = at.index(length).min(characters.len());
                characters.splice(at..(at + 1).min(characters.len()), text.chars());
            }
            Mutation::Repeat(at, count) => {
                let at = at.index(length).min(characters.len());
                let again = characters[at..(at + count).min(characters.len())].to_vec();
                characters.splice(at..at, again);
            }
        }
    }
    characters.into_iter().collect()
}

/// Returns the texts of the shipped scenes at their smoke spacing, so that a readable mutation is
/// filled quickly.
fn texts() -> Vec<String> {
    let coarse = |path: &PathBuf| {
        // The box of the bend is almost empty: shorter ducts make it smaller.
        let long = path.ends_with("square_bend.ron");
        let short = ["constants.L1", "constants.L2"].map(|name| (name, "0.3"));
        let changes = if long { short.as_slice() } else { &[] };
        Scene::from_file(path).smoke().sets(changes).load().unwrap().text
    };
    shipped().iter().map(coarse).collect()
}

/// Returns the number of texts, from `PROPTEST_CASES`; the long version in docs/RELIABILITY.md has
/// a million.
fn cases() -> u32 {
    if is_long() { ProptestConfig::default().cases } else { 600 }
}

fn is_long() -> bool {
    std::env::var_os("PROPTEST_CASES").is_some()
}

/// Largest processor time of a text, s. Only the long version, which runs this test alone, measures
/// it; a wall clock would include other work.
const LONGEST: f64 = 1.0;

/// Returns the processor time of all threads of the process, s.
fn processor_time() -> f64 {
    let now = clock_gettime(ClockId::ProcessCPUTime);
    now.tv_sec as f64 + 1e-9 * now.tv_nsec as f64
}

/// Reads a text and fills the scene or renders its faults; returns true if it is a scene.
fn read_through(text: &str) -> bool {
    // At 0.1 GB a mutation to a finer spacing is refused instead of taking minutes.
    match Scene::from_text("mutated", text).memory(1e8).load() {
        Ok(scene) => {
            assert!(!seeds(&scene).is_empty());
            true
        }
        Err(faults) => {
            assert!(!faults.faults().is_empty(), "{text}");
            assert!(!format!("{:?}", miette::Report::new(faults)).is_empty());
            false
        }
    }
}

#[test]
fn mutated_scenes_are_read_or_refused() {
    let texts = texts();
    let strategy = (any::<Index>(), proptest::collection::vec(mutation(), 1..6));
    let config = ProptestConfig { cases: cases(), failure_persistence: None, ..ProptestConfig::default() };
    let taken = Cell::new(0_u32);
    let ran = TestRunner::new(config).run(&strategy, |(scene, mutations)| {
        let text = mutated(&texts[scene.index(texts.len())], &mutations);
        let begun = processor_time();
        let is_scene = read_through(&text);
        taken.set(taken.get() + u32::from(is_scene));
        let seconds = processor_time() - begun;
        prop_assert!(!is_long() || seconds < LONGEST, "{seconds} s: {text}");
        Ok(())
    });
    ran.unwrap_or_else(|failure| panic!("{failure}"));
    // Mutations of comments or numbers may leave a valid scene, so both outcomes must occur.
    let taken = f64::from(taken.get()) / f64::from(cases());
    assert!(taken > 0.02 && taken < 0.98, "{taken} of the texts are scenes");
}

proptest! {
    #![proptest_config(ProptestConfig { cases: cases(), failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn any_text_is_read_or_refused(text in any::<String>()) {
        let _ = Scene::from_text("any", &text).load();
    }

    #[test]
    fn any_set_option_is_accepted_or_refused(path in "[a-z0-9_.]{0,20}", value in any::<String>()) {
        let text = std::fs::read_to_string(super::shipped::path("duct3d.ron")).unwrap();
        let _ = Scene::from_text("set", &text).set(path, value).load();
    }
}

#[test]
fn deep_nesting_is_refused_before_the_stack_overflows() {
    for open in ["(", "[", "{", "a(", "(a:", "\"", "/*"] {
        let text = open.repeat(100_000);
        assert!(Scene::from_text("deep", &text).load().is_err());
    }
    let expression = "(".repeat(100_000);
    let text = format!("Scene(constants: {{\"a\": \"{expression}\"}})");
    assert!(Scene::from_text("deep", &text).load().is_err());
    let negations = "-".repeat(100_000);
    let text = format!("Scene(constants: {{\"a\": \"{negations}1\"}})");
    assert!(Scene::from_text("deep", &text).load().is_err());
}
