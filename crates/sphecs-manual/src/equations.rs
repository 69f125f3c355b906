//! Equations: LaTeX between `$` or `$$` as MathML.
//!
//! Code spans and code blocks are left as they are. A `$` that is no equation is written `\$`.

use std::ops::Range;

use pulldown_cmark::{CowStr, Event};
use pulldown_latex::config::DisplayMode;
use pulldown_latex::{Parser, RenderConfig, Storage, push_mathml};

use crate::fault::Fault;
use crate::markdown;
use crate::sources::Page;

/// An equation of a page.
struct Equation<'a> {
    /// Bytes of the page, with the dollars.
    range: Range<usize>,
    latex: CowStr<'a>,
    mode: DisplayMode,
}

fn equations(text: &str) -> Vec<Equation<'_>> {
    let found = markdown::parser(text).into_offset_iter().filter_map(|(event, range)| match event {
        Event::InlineMath(latex) => Some(Equation { range, latex, mode: DisplayMode::Inline }),
        Event::DisplayMath(latex) => Some(Equation { range, latex, mode: DisplayMode::Block }),
        _ => None,
    });
    found.collect()
}

/// Adds a fault for every equation that does not parse and every `$` without a partner.
pub fn check(page: &Page, faults: &mut Vec<Fault>) {
    let mut fault = |offset, message| faults.push(Fault::at(&page.file, &page.text, offset, message));
    for equation in equations(&page.text) {
        if let Err(problem) = mathml(&equation.latex, equation.mode) {
            fault(equation.range.start, format!("cannot read the equation: {problem}"));
        }
    }
    for offset in single_dollars(&page.text) {
        fault(offset, "`$` begins no equation: close it and its braces, or write `\\$`".to_owned());
    }
}

/// Returns the places of dollars that belong to no equation and are not escaped.
fn single_dollars(text: &str) -> Vec<usize> {
    let mut found = Vec::new();
    let mut is_code = false;
    for (event, range) in markdown::parser(text).into_offset_iter() {
        match event {
            Event::Start(pulldown_cmark::Tag::CodeBlock(_)) => is_code = true,
            Event::End(pulldown_cmark::TagEnd::CodeBlock) => is_code = false,
            Event::Text(_) if !is_code => {
                let dollars = text[range.clone()].match_indices('$').map(|(at, _)| range.start + at);
                found.extend(dollars.filter(|&at| !text[..at].ends_with('\\')));
            }
            _ => {}
        }
    }
    found
}

/// Returns a page with MathML in place of its equations; those that do not parse are left.
pub fn render(text: &str) -> String {
    let mut rendered = String::with_capacity(text.len());
    let mut end = 0;
    for equation in equations(text) {
        let Ok(mathml) = mathml(&equation.latex, equation.mode) else { continue };
        rendered.push_str(&text[end..equation.range.start]);
        rendered.push_str(&protect(&mathml));
        end = equation.range.end;
    }
    rendered.push_str(&text[end..]);
    rendered
}

/// Returns the MathML of an equation.
///
/// # Errors
/// The problem and the part of the equation near it.
fn mathml(latex: &str, mode: DisplayMode) -> Result<String, String> {
    let storage = Storage::new();
    let mut events = Vec::new();
    for event in Parser::new(latex, &storage) {
        match event {
            Ok(event) => events.push(Ok::<_, pulldown_latex::ParserError>(event)),
            Err(error) => return Err(first_and_last(&error.to_string())),
        }
    }
    let mut mathml = String::new();
    let config = RenderConfig { display_mode: mode, ..RenderConfig::default() };
    push_mathml(&mut mathml, events.into_iter(), config).map_err(|error| error.to_string())?;
    // Browsers put space around a slash, which TeX does not.
    Ok(mathml.replace("<mo>/</mo>", "<mo lspace=\"0\" rspace=\"0\">/</mo>"))
}

/// Shortens a message of many lines to its problem and the source text that it quotes last.
fn first_and_last(message: &str) -> String {
    let problem = message.lines().next().unwrap_or_default().trim_start_matches("parsing error: ");
    let quoted = message.lines().rev().filter_map(|line| line.strip_prefix('│'));
    let near = quoted.map(|line| line.trim_matches([' ', '…', '^'])).find(|line| !line.is_empty());
    match near {
        Some(near) => format!("{problem}, near `{near}`"),
        None => problem.to_owned(),
    }
}

/// Hides the characters of MathML that Markdown would take for marks of its own, such as `*`.
fn protect(mathml: &str) -> String {
    let mut text = String::with_capacity(mathml.len());
    let mut is_tag = false;
    for c in mathml.chars() {
        match c {
            '<' => is_tag = true,
            '>' => is_tag = false,
            // An empty line would end the paragraph.
            '\n' | '\r' => {
                text.push(' ');
                continue;
            }
            _ if !is_tag && "*_`~[]|\\'\"-.!${}".contains(c) => {
                text.push_str(&format!("&#{};", u32::from(c)));
                continue;
            }
            _ => {}
        }
        text.push(c);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    fn faults(text: &str) -> Vec<String> {
        let page = Page { file: "a.md".to_owned(), path: "a.md".to_owned(), text: text.to_owned() };
        let mut faults = Vec::new();
        check(&page, &mut faults);
        faults.iter().map(Fault::to_string).collect()
    }

    #[test]
    fn equations_in_text_become_mathml() {
        let text = render("The density $\\rho_a$ of a particle.\n");
        assert!(
            text.starts_with("The density <math display=\"inline\"><msub><mi>ρ</mi><mi>a</mi></msub></math>")
        );
        assert!(text.ends_with(" of a particle.\n"), "{text}");
        let block = render("$$\n\\frac{dv}{dt} = 0\n$$\n");
        assert!(block.starts_with("<math display=\"block\"><mfrac>"), "{block}");
        assert_eq!(block.trim_end().lines().count(), 1, "{block}");
        assert!(render("$a/b$").contains("<mi>a</mi><mo lspace=\"0\" rspace=\"0\">/</mo><mi>b</mi>"));
    }

    #[test]
    fn code_and_escaped_dollars_are_left() {
        let text = "`$a$` costs \\$5 and \\$6.\n\n```sh\necho $HOME $PATH\n```\n\n    $indented$\n";
        assert_eq!(render(text), text);
        assert_eq!(faults(text), [""; 0]);
    }

    #[test]
    fn every_broken_equation_is_a_fault_with_its_place() {
        let found = faults("One $a$ and\ntwo $\\right)$ and $b_c_d$.\n\n$$\n\\nonsense{x}\n$$\n");
        assert_eq!(found.len(), 3, "{found:?}");
        assert!(found[0].starts_with("a.md:2:5: cannot read the equation: "), "{found:?}");
        assert!(found[1].starts_with("a.md:2:19: cannot read the equation: "), "{found:?}");
        assert!(found[2].starts_with("a.md:4:1: cannot read the equation: "), "{found:?}");
    }

    #[test]
    fn dollar_without_a_partner_is_a_fault() {
        assert_eq!(faults("An open brace $\\frac{a}{$.\n").len(), 2);
        assert_eq!(
            faults("It costs $5.\n"),
            ["a.md:1:10: `$` begins no equation: close it and its braces, or write `\\$`"]
        );
    }

    #[test]
    fn markdown_does_not_change_the_mathml() {
        let text = render("| a |\n|---|\n| $x * y * \\lvert z \\rvert$ |\n");
        let cells = markdown::parser(&text).filter(|event| {
            matches!(event, Event::Start(pulldown_cmark::Tag::TableCell | pulldown_cmark::Tag::Emphasis))
        });
        assert_eq!(cells.count(), 2, "{text}");
    }
}
