//! Checks of the names that the results use, before a run: none is empty or too long, and no two
//! become one in the names of files and variables.

use super::checker::Checker;
use crate::faults::Fault;
use crate::result_name::{MOST_CHARACTERS, collide, result_name};
use crate::schema::Text;

/// Name of an opening, wall part or probe.
pub enum Named<'a> {
    /// Name given in the file.
    Given(&'a Text),
    /// Name of what has none in the file.
    Default(String),
}

impl Named<'_> {
    fn text(&self) -> &str {
        match self {
            Named::Given(name) => &name.value,
            Named::Default(name) => name,
        }
    }
}

/// Reports names that are empty, too long, or the same in the results; `kind` is in the plural.
pub fn names(names: &[Named<'_>], kind: &str, check: &mut Checker<'_>) {
    for (at, named) in names.iter().enumerate() {
        let Named::Given(name) = named else { continue };
        let count = name.value.chars().count();
        if name.value.is_empty() || count > MOST_CHARACTERS {
            let title = format!("a name among the {kind} is empty or too long");
            let label = format!("has {count} characters, must have 1 to {MOST_CHARACTERS}");
            check.report(Fault::new(title, name.span, label));
            continue;
        }
        // Of two given names the second is reported, of a given and a default one the given.
        let earlier = names[..at].iter();
        let later = names[at + 1..].iter().filter(|other| matches!(other, Named::Default(_)));
        let Some(other) = earlier.chain(later).find(|other| collide(other.text(), &name.value)) else {
            continue;
        };
        let other = other.text();
        let fault = if other == name.value {
            let title = format!("two {kind} are called `{other}`");
            Fault::new(title, name.span, "every name must differ")
        } else {
            let title = format!("two {kind} have the same name in the results");
            let label = format!("`{other}` and `{}` are both `{}`", name.value, result_name(&name.value));
            Fault::new(title, name.span, label).help(
                "names must differ in their letters a to z and digits: all else becomes `_`, and case does not count",
            )
        };
        check.report(fault);
    }
}
