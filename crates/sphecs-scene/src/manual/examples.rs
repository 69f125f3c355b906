//! Passages of scenes, one for every struct and list of choices.

const PASSAGES: &str = include_str!("examples.ron");

/// Begins a passage, with its name behind it.
const MARK: &str = "// ## ";

/// Returns all passages with their names, which are those of a page, or of a page and a choice.
///
/// A passage is one field of the scene, or several, or a scene.
pub fn examples() -> impl Iterator<Item = (&'static str, &'static str)> {
    PASSAGES.split(MARK).skip(1).filter_map(|passage| {
        let (name, text) = passage.split_once('\n')?;
        Some((name.trim(), text.trim()))
    })
}

/// Returns the passage of a name.
pub fn example(name: &str) -> Option<&'static str> {
    examples().find(|(other, _)| *other == name).map(|(_, text)| text)
}
