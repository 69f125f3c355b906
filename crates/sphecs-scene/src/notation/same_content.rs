//! Comparison of scene texts without their comments and layout.

use super::reader::read;
use super::tree::{Name, Node, Value};

/// Returns true if two texts have equal values in equal order: they may differ in comments, blanks
/// and line ends. Texts with faults are the same only if they are equal.
pub fn same_content(one: &str, other: &str) -> bool {
    if one == other {
        return true;
    }
    let (one, other) = (read(one), read(other));
    one.faults.is_empty() && other.faults.is_empty() && are_same(&one.root, &other.root)
}

fn are_same(one: &Node, other: &Node) -> bool {
    let all = |one: &[Node], other: &[Node]| {
        one.len() == other.len() && one.iter().zip(other).all(|(one, other)| are_same(one, other))
    };
    match (&one.value, &other.value) {
        (Value::Text(one, _), Value::Text(other, _)) => one == other,
        (Value::List(one), Value::List(other)) => all(one, other),
        (Value::Map(one), Value::Map(other)) => {
            let same = |((key, value), (other_key, other_value)): (&(Node, Node), &(Node, Node))| {
                are_same(key, other_key) && are_same(value, other_value)
            };
            one.len() == other.len() && one.iter().zip(other).all(same)
        }
        (Value::Tuple(name, one), Value::Tuple(other_name, other)) => {
            text_of(name) == text_of(other_name) && all(one, other)
        }
        (Value::Struct(name, one), Value::Struct(other_name, other)) => {
            text_of(name) == text_of(other_name)
                && one.len() == other.len()
                && one.iter().zip(other).all(|(one, other)| {
                    one.name.text == other.name.text && are_same(&one.value, &other.value)
                })
        }
        // Those without positions.
        (one, other) => one == other,
    }
}

fn text_of(name: &Option<Name>) -> Option<&str> {
    name.as_ref().map(|name| name.text.as_str())
}

#[cfg(test)]
mod tests {
    use super::*;

    const SCENE: &str = "Scene(spacing: 0.1, // m
        domain: Box(min: (0.0, 0.0), max: (\"L\", 1.0)), constants: {\"L\": 2.0}, periodic: [\"x\"], slip: NoSlip)";

    #[test]
    fn comments_and_layout_do_not_count() {
        let other = SCENE.replace("// m", "/* spacing */").replace(", ", ",\r\n\t");
        assert!(same_content(SCENE, &other));
        assert!(same_content(SCENE, &format!("// Head.\n{SCENE}\n")));
    }

    #[test]
    fn every_value_counts() {
        for (from, to) in [
            ("0.1", "0.2"),
            ("\"L\", 1.0", "\"2*L\", 1.0"),
            ("Box", "Ball"),
            ("min", "low"),
            ("2.0", "2"),
            ("[\"x\"]", "[]"),
            ("NoSlip", "FreeSlip"),
        ] {
            assert!(!same_content(SCENE, &SCENE.replacen(from, to, 1)), "{from} → {to}");
        }
        assert!(!same_content("Scene(", "Scene( "));
    }
}
