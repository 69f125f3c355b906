//! Markdown as mdBook reads it, with equations.

use pulldown_cmark::{BrokenLink, BrokenLinkCallback, Options, Parser};

/// Returns the options of mdBook, with equations between `$` added.
fn options() -> Options {
    Options::ENABLE_TABLES
        | Options::ENABLE_FOOTNOTES
        | Options::ENABLE_STRIKETHROUGH
        | Options::ENABLE_TASKLISTS
        | Options::ENABLE_HEADING_ATTRIBUTES
        | Options::ENABLE_SMART_PUNCTUATION
        | Options::ENABLE_DEFINITION_LIST
        | Options::ENABLE_GFM
        | Options::ENABLE_MATH
}

/// Returns a parser of a page.
pub fn parser(text: &str) -> Parser<'_> {
    Parser::new_ext(text, options())
}

/// Returns a parser that hands links without a target to a function.
pub fn parser_with_broken_links<'a, F>(text: &'a str, broken: F) -> Parser<'a, impl BrokenLinkCallback<'a>>
where
    F: FnMut(BrokenLink<'a>) -> Option<(pulldown_cmark::CowStr<'a>, pulldown_cmark::CowStr<'a>)>,
{
    Parser::new_with_broken_link_callback(text, options(), Some(broken))
}
