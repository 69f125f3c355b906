//! Reference of the scene file: complete, up to date, and with examples that load.

use std::collections::BTreeSet;
use std::path::Path;

use super::schema_fields;
use crate::manual::{Argument, Content, Field, Manual, ValueKind, examples, json_schema, newer_names};
use crate::meshes::MeshFile;
use crate::model::Scene;
use crate::schema::SceneFile;

fn expect_none(faults: &[String]) {
    assert!(faults.is_empty(), "\n{}\n", faults.join("\n"));
}

/// Returns all fields with the names of their structs or choices.
fn fields(manual: &Manual) -> Vec<(String, &Field)> {
    let mut found = Vec::new();
    for page in &manual.pages {
        match &page.content {
            Content::Fields(fields) => found.extend(fields.iter().map(|field| (page.name.clone(), field))),
            Content::Choices(choices) => {
                for choice in choices {
                    let owner = format!("{}.{}", page.name, choice.name);
                    found.extend(choice.fields().iter().map(|field| (owner.clone(), field)));
                }
            }
        }
    }
    found
}

#[test]
fn every_field_has_a_meaning_a_unit_and_a_default() {
    let manual = Manual::read();
    let mut faults = Vec::new();
    for (owner, field) in fields(&manual) {
        let name = format!("{owner}.{}", field.name);
        if !is_sentence(&field.meaning) {
            faults.push(format!("{name}: its doc line `{}` must be a sentence", field.meaning));
        }
        if field.value.has_unit != field.unit.is_some() {
            let ValueKind { text, .. } = &field.value;
            faults.push(format!(
                "{name}: is a {text} with the unit {:?}: write `, m,` or `, dimensionless,`",
                field.unit
            ));
        }
        if field.default.as_ref().is_some_and(String::is_empty) {
            faults
                .push(format!("{name}: has a default that its doc line does not name: write `, default …`"));
        }
        if field.default.is_none() && field.meaning.contains("default") {
            faults.push(format!("{name}: is required, but its doc line names a default"));
        }
    }
    expect_none(&faults);
}

#[test]
fn every_choice_has_a_sentence_and_a_unit() {
    let manual = Manual::read();
    let mut faults = Vec::new();
    for page in &manual.pages {
        if !is_sentence(&page.meaning) {
            faults.push(format!("{}: its doc line `{}` must be a sentence", page.name, page.meaning));
        }
        let Content::Choices(choices) = &page.content else { continue };
        for choice in choices {
            if !is_sentence(&choice.meaning) {
                let doc_line = &choice.meaning;
                faults.push(format!(
                    "{}.{}: its doc line `{doc_line}` must be a sentence",
                    page.name, choice.name
                ));
            }
            if let Argument::Value(value) = &choice.argument
                && value.has_unit != choice.unit.is_some()
            {
                faults.push(format!("{}.{}: has the unit {:?}", page.name, choice.name, choice.unit));
            }
        }
    }
    expect_none(&faults);
}

#[test]
fn every_choice_says_when_to_take_it() {
    let manual = Manual::read();
    let mut faults = Vec::new();
    for page in &manual.pages {
        let Content::Choices(choices) = &page.content else { continue };
        for choice in choices {
            let count = format!(" {}", choice.meaning).matches(". Take it ").count();
            if count != 1 {
                faults.push(format!(
                    "{}.{}: has {count} sentences that begin with `Take it`, must have one: say when to take it",
                    page.name, choice.name
                ));
            }
        }
    }
    expect_none(&faults);
}

#[test]
fn versions_are_those_of_names_that_exist() {
    let manual = Manual::read();
    let mut known: BTreeSet<String> = manual.pages.iter().map(|page| page.name.clone()).collect();
    for page in &manual.pages {
        if let Content::Choices(choices) = &page.content {
            known.extend(choices.iter().map(|choice| format!("{}.{}", page.name, choice.name)));
        }
    }
    known.extend(fields(&manual).into_iter().map(|(owner, field)| format!("{owner}.{}", field.name)));
    let unknown = newer_names().filter(|name| !known.contains(*name));
    expect_none(
        &unknown.map(|name| format!("since.rs: names {name}, which no scene has")).collect::<Vec<_>>(),
    );
    let explained = manual.explain("outlets.condition.Hybrid").expect("a choice");
    assert!(explained.contains("since     0.2.0\n"), "{explained}");
    assert_eq!(json_schema()["properties"]["bodies"]["x-since"], "0.2.0");
    assert_eq!(json_schema()["properties"]["spacing"]["x-since"], "0.1.0");
}

/// Returns true for two words or more with a stop behind them.
fn is_sentence(text: &str) -> bool {
    text.ends_with('.') && text.split(' ').count() >= 2
}

#[test]
fn every_name_that_a_scene_can_have_is_described() {
    let manual = Manual::read();
    let (_, names) = schema_fields::all::<SceneFile>();
    // Names of types differ by an ending: `SchemeFile::Wcsph.kernel` is `Scheme.Wcsph.kernel`.
    let ends: BTreeSet<String> =
        names.iter().map(|name| name.replace("::", ".").replacen("File.", ".", 1)).collect();
    let mut described: BTreeSet<String> =
        fields(&manual).into_iter().map(|(owner, field)| format!("{owner}.{}", field.name)).collect();
    for page in &manual.pages {
        if let Content::Choices(choices) = &page.content {
            described.extend(choices.iter().map(|choice| format!("{}.{}", page.name, choice.name)));
            // Parameters with a type of their own are read under its name.
            for choice in choices {
                described
                    .extend(choice.fields().iter().map(|field| format!("{}.{}", choice.name, field.name)));
            }
        }
    }
    let missing: Vec<String> = ends.difference(&described).cloned().collect();
    expect_none(&missing);
}

#[test]
fn every_path_is_explained() {
    let manual = Manual::read();
    let entries = manual.entries();
    assert!(entries.len() > 200, "{}", entries.len());
    for entry in &entries {
        let text = manual.explain(&entry.path).unwrap_or_else(|fault| panic!("{}: {fault:?}", entry.path));
        assert!(text.starts_with(&entry.path) || entry.path.is_empty(), "{text}");
        let text = manual.explain_entry(entry);
        assert!(text.lines().all(|line| line.chars().count() <= 100), "{text}");
        assert!(text.contains("\nexample\n"), "{text}");
    }
}

#[test]
fn paths_may_have_numbers_and_leave_out_choices() {
    let manual = Manual::read();
    let explained = |path: &str| manual.explain(path).unwrap_or_else(|fault| panic!("{path}: {fault:?}"));
    assert_eq!(explained("outlets.0.condition"), explained("outlets.condition"));
    assert!(explained("outlets.condition").contains("WaveEquation(…)"));
    assert_eq!(explained("WaveEquation"), explained("outlets.condition.WaveEquation"));
    assert_eq!(explained("scheme.Wcsph.shifting"), explained("scheme.shifting"));
    assert!(explained("scheme.kernel").contains("QuinticSpline"));
    assert!(explained("spacing").contains("unit      m\n"), "{}", explained("spacing"));
    assert!(explained("constants.v0").contains("constants"));
    assert!(explained("velocity").contains("occurs"));
    assert!(explained("").starts_with("Scene: "));
}

#[test]
fn a_misspelt_path_names_the_nearest() {
    let manual = Manual::read();
    for (path, near) in [
        ("outlets.conditon", "`condition`"),
        ("outlet.condition", "`outlets`"),
        ("scheme.Wscph", "`Wcsph`"),
        ("scheme.Wcsph.shiftin", "`shifting`"),
        ("WaveEqation", "`WaveEquation`"),
        ("fluid.denstiy", "`density`"),
        // No field has these names, but the meaning of one mentions them.
        ("drag", "`bodies.velocity`"),
        ("lift", "`bodies.velocity`"),
    ] {
        let fault = manual.explain(path).expect_err(path);
        assert!(fault.title.contains(path) && fault.advice.contains(near), "{fault:?}");
    }
    let fault = manual.explain("spacing.x").expect_err("a single value");
    assert!(fault.advice.contains("single value"), "{fault:?}");
}

/// Returns the mesh file of a cube with edges of 100.
fn cube(path: &str) -> MeshFile {
    let corner =
        |bits: usize| [0, 1, 2].map(|axis| if bits >> axis & 1 == 1 { "100" } else { "0" }.to_owned());
    let mut text = String::from("solid cube\n");
    for [a, b, c, d] in [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]] {
        for facet in [[a, b, c], [a, c, d]] {
            let vertices = facet.map(|bits| format!("vertex {}\n", corner(bits).join(" ")));
            text += &format!("facet normal 0 0 0\nouter loop\n{}endloop\nendfacet\n", vertices.concat());
        }
    }
    text += "endsolid cube\n";
    MeshFile { path: path.to_owned(), bytes: text.into_bytes().into() }
}

/// Returns the file of an outline, the section of a wing.
fn wing(path: &str) -> MeshFile {
    let text = "x, y\n1.0, 0.0\n0.7, 0.04\n0.3, 0.06\n0.0, 0.0\n0.3, -0.06\n0.7, -0.04\n";
    MeshFile { path: path.to_owned(), bytes: text.as_bytes().into() }
}

/// Fields of scenes into which a passage is put: a channel, and boxes in 2D and 3D.
const BASES: [&[(&str, &str)]; 3] = [
    &[
        ("dimensions", "2"),
        ("domain", "Box(min: (0.0, 0.0), max: (0.2, 0.04))"),
        ("inlets", "[(at: (0.0, 0.02), towards: (1.0, 0.0), velocity: Normal(0.1))]"),
        ("outlets", "[(at: (0.2, 0.02), towards: (1.0, 0.0))]"),
    ],
    &[("dimensions", "2"), ("domain", "Box(min: (0.0, 0.0), max: (0.2, 0.04))")],
    &[("dimensions", "3"), ("domain", "Box(min: (0.0, 0.0, 0.0), max: (0.1, 0.1, 0.1))")],
];

const COMMON: [(&str, &str); 6] = [
    ("title", "\"Passage\""),
    ("spacing", "2.0e-3"),
    ("fluid", "(density: 1000.0, viscosity: 1.0e-5, sound_speed: 2.0)"),
    ("time", "(end: 2.0)"),
    ("output", "(every: 0.05)"),
    ("reference", "(velocity: 0.1)"),
];

fn faults_within(base: &[(&str, &str)], passage: &str) -> Option<String> {
    let given = |name: &str| passage.lines().any(|line| line.starts_with(&format!("{name}:")));
    let fields: String = base
        .iter()
        .chain(&COMMON)
        .filter(|(name, _)| !given(name))
        .map(|(name, value)| format!("{name}: {value},\n"))
        .collect();
    let text =
        if passage.starts_with("Scene(") { passage.to_owned() } else { format!("Scene({fields}{passage})") };
    let faults =
        Scene::from_text("passage", &text).meshes([cube("pipe.stl"), wing("naca0012.csv")]).load().err()?;
    Some(faults.faults().iter().map(|fault| format!("{}: {}; ", fault.title, fault.label)).collect())
}

#[test]
fn every_example_loads_within_a_scene() {
    let mut faults = Vec::new();
    for (name, passage) in examples() {
        let found: Vec<String> = BASES.iter().map_while(|base| faults_within(base, passage)).collect();
        if found.len() == BASES.len() {
            faults.push(format!("{name}: {}", found.join("\n    ")));
        }
    }
    expect_none(&faults);
}

#[test]
fn every_page_has_an_example_and_every_example_a_page() {
    let manual = Manual::read();
    let mut faults = Vec::new();
    for page in &manual.pages {
        if examples().all(|(name, _)| name != page.name) {
            faults.push(format!("{}: has no example", page.name));
        }
    }
    for (name, _) in examples() {
        let (page, choice) = name.split_once('.').unwrap_or((name, ""));
        let is_known = manual.page(page).is_some_and(|page| match &page.content {
            Content::Choices(choices) => choice.is_empty() || choices.iter().any(|one| one.name == choice),
            Content::Fields(_) => choice.is_empty(),
        });
        if !is_known {
            faults.push(format!("{name}: is an example of nothing"));
        }
    }
    expect_none(&faults);
}

#[test]
fn json_schema_has_units_and_defaults_as_data() {
    let schema = json_schema();
    let text = serde_json::to_string(&schema).expect("JSON");
    assert_eq!(serde_json::from_str::<serde_json::Value>(&text).expect("JSON"), schema);
    assert_eq!(schema["properties"]["spacing"]["x-unit"], "m");
    assert_eq!(schema["properties"]["spacing"]["type"], serde_json::json!(["number", "string"]));
    assert_eq!(schema["properties"]["precision"]["x-default"], "`F64`");
    let condition = &schema["$defs"]["OutletCondition"]["oneOf"][0]["properties"];
    assert!(condition["WaveEquation"].is_object(), "{condition}");
}

#[test]
fn the_page_of_the_manual_is_up_to_date() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/book/src/reference/scene.md");
    let page = Manual::read().scene_page();
    if std::env::var_os("UPDATE_REFERENCE").is_some() {
        std::fs::write(&path, &page).expect("written");
    }
    let committed = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(
        committed == page,
        "{} is out of date: run `UPDATE_REFERENCE=1 cargo test -p sphecs-scene --features schema`",
        path.display()
    );
}
