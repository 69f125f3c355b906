//! Entries of a path such as `outlets.condition`, `scheme.Wcsph.shifting` or `WaveEquation`.

use std::collections::BTreeSet;

use super::entries::{Argument, Choice, Content, Field, Manual, Page};
use crate::faults::{advice, is_misspelt, nearest};

/// Largest number of paths named for a word that is no field or choice.
const MOST_MENTIONS: usize = 3;

/// An entry with its path.
#[derive(Clone, Debug)]
pub struct Entry<'a> {
    /// Path from the scene, empty for the scene itself.
    pub path: String,
    /// Page whose field or choice it is.
    pub owner: &'a Page,
    /// The entry.
    pub item: Item<'a>,
}

/// A page, field or choice.
#[derive(Clone, Copy, Debug)]
pub enum Item<'a> {
    /// A struct or a list of choices.
    Page(&'a Page),
    /// A field.
    Field(&'a Field),
    /// A choice.
    Choice(&'a Choice),
}

/// A path that the scene file does not have.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error, miette::Diagnostic)]
#[error("{title}")]
#[diagnostic(help("{advice}"))]
pub struct UnknownPath {
    /// Description in one line.
    pub title: String,
    /// Nearest name and the names allowed.
    pub advice: String,
}

impl Item<'_> {
    /// Name of the entry.
    pub fn name(&self) -> &str {
        match self {
            Item::Page(page) => &page.name,
            Item::Field(field) => &field.name,
            Item::Choice(choice) => &choice.name,
        }
    }
}

impl Manual {
    /// Returns the entries of a path; the scene for an empty one.
    ///
    /// Numbers of list items are skipped, and names of choices may be left out. A path that does
    /// not begin with a field of the scene stands for all entries whose path ends with it.
    ///
    /// # Errors
    /// [`UnknownPath`], with the nearest name.
    pub fn find(&self, path: &str) -> Result<Vec<Entry<'_>>, UnknownPath> {
        let is_name = |segment: &&str| !segment.is_empty() && segment.parse::<usize>().is_err();
        let segments: Vec<&str> = path.split('.').filter(is_name).collect();
        let top = self.top();
        let begins_at_top = segments.first().is_none_or(|first| {
            *first == "constants" || self.children(&top).iter().any(|child| child.item.name() == *first)
        });
        if begins_at_top {
            return self.walk(path, vec![top], &segments);
        }
        let all = self.entries();
        let named = |entry: &&Entry<'_>| entry.item.name() == segments[0];
        let found: Vec<Entry<'_>> = all.iter().filter(named).cloned().collect();
        if found.is_empty() {
            let is_path = segments.len() > 1;
            let named = all.iter().filter(|entry| !is_path || !matches!(entry.item, Item::Page(_)));
            return Err(self.unknown(path, segments[0], named));
        }
        self.walk(path, found, &segments[1..])
    }

    /// Returns all entries of the scene file; those of a page at the first path that leads to it.
    pub fn entries(&self) -> Vec<Entry<'_>> {
        let mut visited = BTreeSet::new();
        let mut found = Vec::new();
        self.collect(self.top(), &mut visited, &mut found);
        found
    }

    fn top(&self) -> Entry<'_> {
        Entry { path: String::new(), owner: &self.pages[0], item: Item::Page(&self.pages[0]) }
    }

    fn collect<'a>(&'a self, entry: Entry<'a>, visited: &mut BTreeSet<&'a str>, found: &mut Vec<Entry<'a>>) {
        let own_fields = match entry.item {
            Item::Choice(Choice { argument: Argument::Fields(_), .. }) => true,
            _ => self.target(&entry).is_some_and(|page| visited.insert(&page.name)),
        };
        let target = self.target(&entry).filter(|_| own_fields && !matches!(entry.item, Item::Page(_)));
        let page = target.map(|page| Entry { item: Item::Page(page), owner: page, path: entry.path.clone() });
        let children = if own_fields { self.direct_children(&entry) } else { Vec::new() };
        found.push(entry);
        found.extend(page);
        for child in children {
            self.collect(child, visited, found);
        }
    }

    fn walk<'a>(
        &'a self,
        path: &str,
        mut entries: Vec<Entry<'a>>,
        segments: &[&str],
    ) -> Result<Vec<Entry<'a>>, UnknownPath> {
        for segment in segments {
            // A constant has the name that the scene gives it.
            if entries.iter().any(|entry| entry.path == "constants") {
                return Ok(entries);
            }
            let children: Vec<Entry<'_>> = entries.iter().flat_map(|entry| self.children(entry)).collect();
            let direct: Vec<Entry<'_>> =
                entries.iter().flat_map(|entry| self.direct_children(entry)).collect();
            let named = |entry: &&Entry<'_>| entry.item.name() == *segment;
            let found: Vec<Entry<'_>> = match direct.iter().filter(named).cloned().collect::<Vec<_>>() {
                none if none.is_empty() => children.iter().filter(named).cloned().collect(),
                some => some,
            };
            if found.is_empty() {
                return Err(unknown_child(path, &entries[0], segment, &children));
            }
            entries = found;
        }
        Ok(entries)
    }

    /// Returns the page that describes the value of an entry.
    pub fn target<'a>(&'a self, entry: &Entry<'a>) -> Option<&'a Page> {
        match entry.item {
            Item::Page(page) => Some(page),
            Item::Field(field) => self.page(field.value.page.as_deref()?),
            Item::Choice(Choice { argument: Argument::Value(value), .. }) => {
                self.page(value.page.as_deref()?)
            }
            Item::Choice(_) => None,
        }
    }

    /// Returns the fields and choices of an entry.
    fn direct_children<'a>(&'a self, entry: &Entry<'a>) -> Vec<Entry<'a>> {
        let child = |owner: &'a Page, item: Item<'a>| {
            let dot = if entry.path.is_empty() { "" } else { "." };
            Entry { path: format!("{}{dot}{}", entry.path, item.name()), owner, item }
        };
        if let Item::Choice(Choice { argument: Argument::Fields(fields), .. }) = entry.item {
            return fields.iter().map(|field| child(entry.owner, Item::Field(field))).collect();
        }
        match self.target(entry) {
            None => Vec::new(),
            Some(page) => match &page.content {
                Content::Fields(fields) => fields.iter().map(|one| child(page, Item::Field(one))).collect(),
                Content::Choices(choices) => {
                    choices.iter().map(|one| child(page, Item::Choice(one))).collect()
                }
            },
        }
    }

    /// Returns the fields and choices of an entry, and the fields of its choices.
    fn children<'a>(&'a self, entry: &Entry<'a>) -> Vec<Entry<'a>> {
        let mut children = self.direct_children(entry);
        let choices = children.iter().filter(|child| matches!(child.item, Item::Choice(_)));
        let inner: Vec<Entry<'_>> = choices.flat_map(|choice| self.direct_children(choice)).collect();
        children.extend(inner.into_iter().filter(|child| matches!(child.item, Item::Field(_))));
        children
    }

    fn unknown<'a>(
        &self,
        path: &str,
        name: &str,
        entries: impl Iterator<Item = &'a Entry<'a>>,
    ) -> UnknownPath {
        let title = format!("`{path}`: the scene file has no field or choice `{name}`");
        let top: Vec<String> =
            self.children(&self.top()).iter().map(|child| child.item.name().to_owned()).collect();
        let fields = || top.iter().map(String::as_str);
        let entries: Vec<&Entry<'_>> = entries.collect();
        let is_misspelling = entries.iter().any(|entry| is_misspelt(name, entry.item.name()));
        let mentions = mentions(name, &entries);
        if !is_misspelling && !mentions.is_empty() {
            let advice = format!(
                "it is mentioned by {}: see `sphecs explain {}`",
                mentions.join(", "),
                mentions[0].trim_matches('`')
            );
            return UnknownPath { title, advice };
        }
        let advice = match nearest(name, entries.iter().map(|entry| entry.item.name())) {
            Some(near) if fields().all(|field| field != near) => {
                format!("did you mean `{near}`? (`sphecs explain` lists the fields of a scene)")
            }
            _ => advice(name, fields()),
        };
        UnknownPath { title, advice }
    }
}

/// Returns the first paths whose meaning contains a word that no field has as its name, such as
/// `drag`.
fn mentions(word: &str, entries: &[&Entry<'_>]) -> Vec<String> {
    let word = word.to_lowercase();
    let meaning = |entry: &Entry<'_>| match entry.item {
        Item::Page(page) => page.meaning.to_lowercase(),
        Item::Field(field) => field.meaning.to_lowercase(),
        Item::Choice(choice) => choice.meaning.to_lowercase(),
    };
    let contains = |text: &str| text.split(|letter: char| !letter.is_alphanumeric()).any(|part| part == word);
    let mut paths: Vec<String> = Vec::new();
    for entry in entries.iter().filter(|entry| contains(&meaning(entry))) {
        let path = format!("`{}`", entry.path);
        if !entry.path.is_empty() && !paths.contains(&path) && paths.len() < MOST_MENTIONS {
            paths.push(path);
        }
    }
    paths
}

fn unknown_child(path: &str, parent: &Entry<'_>, name: &str, children: &[Entry<'_>]) -> UnknownPath {
    let place = if parent.path.is_empty() { "the scene".to_owned() } else { format!("`{}`", parent.path) };
    let title = format!("`{path}`: {place} has no field or choice `{name}`");
    let names: BTreeSet<&str> = children.iter().map(|child| child.item.name()).collect();
    let advice = if names.is_empty() {
        format!("{place} is a single value; see `sphecs explain {}`", parent.path)
    } else {
        advice(name, names.iter().copied())
    };
    UnknownPath { title, advice }
}
