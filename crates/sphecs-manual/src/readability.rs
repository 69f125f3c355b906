//! Readability: lengths of pages and of sentences.

use pulldown_cmark::{Event, Tag, TagEnd};

use crate::fault::Fault;
use crate::markdown;
use crate::sources::Page;

/// Most lines of a guide and of other pages.
const MOST_LINES_OF_A_GUIDE: usize = 100;
const MOST_LINES: usize = 250;

/// Folders of pages that are as long as their contents: complete lists, generated pages, diaries.
const LONG: [&str; 3] = ["reference/", "validation/", "notebook/"];

/// Folders of pages with short sentences, and the largest mean number of words.
const SHORT_SENTENCES: [&str; 2] = ["guides/", "tutorials/"];
const MOST_WORDS: f64 = 20.0;

/// Words whose period ends no sentence.
const ABBREVIATIONS: [&str; 9] = ["al.", "approx.", "cf.", "e.g.", "Eq.", "Eqs.", "Fig.", "i.e.", "vs."];

/// Adds faults for a page that is too long and for one whose sentences are.
pub fn check(page: &Page, faults: &mut Vec<Fault>) {
    let is_in = |folders: &[&str]| folders.iter().any(|folder| page.path.starts_with(folder));
    let mut fault = |message| faults.push(Fault::at(&page.file, &page.text, 0, message));
    let most = if page.path.starts_with("guides/") { MOST_LINES_OF_A_GUIDE } else { MOST_LINES };
    let lines = page.text.lines().count();
    if lines > most && !is_in(&LONG) {
        fault(format!("has {lines} lines, must have at most {most}: shorten it, or split off a page"));
    }
    if is_in(&SHORT_SENTENCES) {
        let sentences = sentences(&page.text);
        let mean = sentences.iter().sum::<usize>() as f64 / sentences.len().max(1) as f64;
        if mean > MOST_WORDS {
            fault(format!(
                "has {mean:.1} words a sentence on average, must have at most {MOST_WORDS}: split long sentences"
            ));
        }
    }
}

/// Returns the number of words of every sentence of a page. Headings, tables and code are left out;
/// a code span or an equation in a sentence is one word.
fn sentences(text: &str) -> Vec<usize> {
    let mut found = Vec::new();
    let mut paragraph = String::new();
    // Depth of elements whose text is no sentence.
    let mut outside = 0;
    for event in markdown::parser(text) {
        match event {
            Event::Start(Tag::Heading { .. } | Tag::Table(_) | Tag::CodeBlock(_) | Tag::Image { .. }) => {
                outside += 1
            }
            Event::End(TagEnd::Heading(_) | TagEnd::Table | TagEnd::CodeBlock | TagEnd::Image) => {
                outside -= 1
            }
            Event::Start(Tag::Paragraph | Tag::Item) | Event::End(TagEnd::Paragraph | TagEnd::Item) => {
                words_of_sentences(&std::mem::take(&mut paragraph), &mut found);
            }
            Event::Text(part) if outside == 0 => paragraph.push_str(&part),
            Event::Code(_) | Event::InlineMath(_) if outside == 0 => paragraph.push_str("code"),
            Event::DisplayMath(_) if outside == 0 => paragraph.push_str(" equation "),
            Event::SoftBreak | Event::HardBreak => paragraph.push(' '),
            _ => {}
        }
    }
    words_of_sentences(&paragraph, &mut found);
    found
}

/// Adds the numbers of words of the sentences of a paragraph.
fn words_of_sentences(paragraph: &str, found: &mut Vec<usize>) {
    let mut count = 0;
    for word in paragraph.split_whitespace().filter(|word| word.contains(char::is_alphanumeric)) {
        count += 1;
        let bare = word.trim_end_matches([')', '”', '’', '"', '\'']);
        let is_end =
            bare.ends_with(['.', '!', '?']) && !ABBREVIATIONS.contains(&bare.trim_start_matches('('));
        if is_end {
            found.push(std::mem::take(&mut count));
        }
    }
    if count > 0 {
        found.push(count);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn faults(path: &str, text: &str) -> Vec<String> {
        let page = Page { file: path.to_owned(), path: path.to_owned(), text: text.to_owned() };
        let mut faults = Vec::new();
        check(&page, &mut faults);
        faults.iter().map(Fault::to_string).collect()
    }

    #[test]
    fn sentences_of_text_and_lists_are_counted() {
        let text = "# A heading of some words\n\nIt is 0.5 m, as Lo et al. (2002) say. Take `a b` or $x y$.\n\n\
                    - one item\n- two words. three words more\n\n```sh\nno sentence.\n```\n\n| a | b |\n|---|---|\n| c | d |\n";
        assert_eq!(sentences(text), [10, 4, 2, 2, 3]);
    }

    #[test]
    fn long_sentences_of_a_guide_are_a_fault() {
        let text = format!("{}end.\n", "word ".repeat(20));
        assert_eq!(faults("guides/a.md", &text).len(), 1);
        assert_eq!(faults("theory/a.md", &text), [""; 0]);
    }

    #[test]
    fn long_pages_are_a_fault() {
        let text = "Word.\n\n".repeat(60);
        assert_eq!(
            faults("guides/a.md", &text),
            ["guides/a.md:1:1: has 120 lines, must have at most 100: shorten it, or split off a page"]
        );
        assert_eq!(faults("theory/a.md", &text), [""; 0]);
        assert_eq!(faults("theory/a.md", &text.repeat(3)).len(), 1);
        assert_eq!(faults("reference/a.md", &text.repeat(3)), [""; 0]);
    }
}
