//! No panic, whatever the bytes.

use std::path::Path;

use proptest::prelude::{ProptestConfig, Strategy, any, prop_oneof, proptest};
use proptest::sample::{Index, select};

use super::shipped::shipped;
use crate::scene::build::Origin;
use crate::scene::{load_str, read, seeds};

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

/// Texts of the shipped scenes, coarse so that a sound mutation costs little.
fn texts() -> Vec<String> {
    shipped()
        .iter()
        .filter(|path| !path.ends_with("constricted_r3.ron"))
        .map(|path| std::fs::read_to_string(path).unwrap())
        .collect()
}

/// Texts tried: as many as `PROPTEST_CASES` says; the long version in docs/RELIABILITY.md has a million.
fn cases() -> u32 {
    if std::env::var_os("PROPTEST_CASES").is_some() { ProptestConfig::default().cases } else { 600 }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: cases(), failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn mutated_scenes_are_read_or_refused(
        scene in any::<Index>(),
        mutations in proptest::collection::vec(mutation(), 1..6),
    ) {
        let texts = texts();
        let text = mutated(&texts[scene.index(texts.len())], &mutations);
        // A tenth of a gigabyte: a finer spacing by mutation must not make a test of minutes.
        let origin = Origin {
            name: "mutated",
            text: &text,
            folder: Path::new("."),
            tables: &[],
            memory: Some(1e8),
        };
        match read("mutated", origin, &[]) {
            Ok(scene) => assert!(!seeds(&scene).is_empty()),
            Err(faults) => {
                assert!(!faults.faults().is_empty(), "{text}");
                let report = format!("{:?}", miette::Report::new(faults));
                assert!(!report.is_empty());
            }
        }
    }

    #[test]
    fn any_text_is_read_or_refused(text in any::<String>()) {
        let _ = load_str("any", &text, &[]);
    }

    #[test]
    fn any_set_is_taken_or_refused(path in "[a-z0-9_.]{0,20}", value in any::<String>()) {
        let text = std::fs::read_to_string(super::shipped::path("duct3d.ron")).unwrap();
        let _ = load_str("set", &text, &[(path, value)]);
    }
}

#[test]
fn deep_nesting_is_refused_before_the_stack_ends() {
    for open in ["(", "[", "{", "a(", "(a:", "\"", "/*"] {
        let text = open.repeat(100_000);
        assert!(load_str("deep", &text, &[]).is_err());
    }
    let expression = "(".repeat(100_000);
    let text = format!("Scene(constants: {{\"a\": \"{expression}\"}})");
    assert!(load_str("deep", &text, &[]).is_err());
    let negations = "-".repeat(100_000);
    let text = format!("Scene(constants: {{\"a\": \"{negations}1\"}})");
    assert!(load_str("deep", &text, &[]).is_err());
}
