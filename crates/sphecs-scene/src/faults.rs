//! Faults of a scene, each with its position, the value found and the values allowed.

use std::fmt;
use std::sync::Arc;

use miette::{Diagnostic, LabeledSpan, NamedSource, SourceCode, SourceSpan};

use super::notation::tree::Span;

/// One fault: position, value found, values allowed and advice.
#[derive(Clone, Debug)]
pub struct Fault {
    /// Description of the fault, in one line.
    pub title: String,
    /// Marked part of the text; None for faults without a position.
    pub span: Option<Span>,
    /// Value found and values allowed.
    pub label: String,
    /// Advice on how to correct it.
    pub help: Option<String>,
    /// Text that the position refers to if it is not the scene: a table or the value of a `--set`.
    pub source: Option<Arc<NamedSource<String>>>,
}

impl Fault {
    /// Returns a fault at a position of the scene's text.
    pub fn new(title: impl Into<String>, span: Span, label: impl Into<String>) -> Self {
        Self { title: title.into(), span: Some(span), label: label.into(), help: None, source: None }
    }

    /// Returns a fault without a position.
    pub fn placeless(title: impl Into<String>) -> Self {
        Self { title: title.into(), span: None, label: String::new(), help: None, source: None }
    }

    /// Adds advice.
    #[must_use]
    pub fn help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }

    /// Moves the fault into another text, such as a table.
    #[must_use]
    pub fn in_text(mut self, name: &str, text: &str) -> Self {
        self.source = Some(Arc::new(NamedSource::new(name, text.to_owned())));
        self
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.title)
    }
}

impl std::error::Error for Fault {}

impl Diagnostic for Fault {
    fn help<'a>(&'a self) -> Option<Box<dyn fmt::Display + 'a>> {
        self.help.as_ref().map(|help| Box::new(help) as Box<dyn fmt::Display>)
    }

    fn source_code(&self) -> Option<&dyn SourceCode> {
        self.source.as_deref().map(|source| source as &dyn SourceCode)
    }

    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        let span = self.span?;
        let label = (!self.label.is_empty()).then(|| self.label.clone());
        let place = SourceSpan::from((span.start, span.end.saturating_sub(span.start)));
        Some(Box::new(std::iter::once(LabeledSpan::new_with_span(label, place))))
    }
}

/// All faults of a scene, in the order of the text.
#[derive(Clone, Debug)]
pub struct SceneErrors {
    /// Name and text of the scene as read, `--set` values included.
    source: NamedSource<String>,
    /// The faults; at least one.
    faults: Vec<Fault>,
}

impl SceneErrors {
    /// Returns the faults of a text, sorted by position.
    pub fn new(name: &str, text: &str, mut faults: Vec<Fault>) -> Self {
        faults.sort_by_key(|fault| fault.span.map_or((usize::MAX, 0), |s| (s.start, s.end)));
        Self { source: NamedSource::new(name, text.to_owned()), faults }
    }

    /// Returns the faults, in the order of the text.
    pub fn faults(&self) -> &[Fault] {
        &self.faults
    }

    /// Returns line and column of a fault, from 1, counted in characters; None without a position.
    pub fn position(&self, fault: &Fault) -> Option<(usize, usize)> {
        let text = fault.source.as_deref().unwrap_or(&self.source).inner().as_str();
        let before = text.get(..fault.span?.start)?;
        let line = before.matches('\n').count() + 1;
        let column = before.rsplit('\n').next().map_or(0, |l| l.chars().count()) + 1;
        Some((line, column))
    }
}

impl fmt::Display for SceneErrors {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = self.source.name();
        match self.faults.len() {
            1 => write!(f, "{name} has 1 fault"),
            count => write!(f, "{name} has {count} faults"),
        }
    }
}

impl std::error::Error for SceneErrors {}

impl Diagnostic for SceneErrors {
    fn source_code(&self) -> Option<&dyn SourceCode> {
        Some(&self.source)
    }

    fn related<'a>(&'a self) -> Option<Box<dyn Iterator<Item = &'a dyn Diagnostic> + 'a>> {
        Some(Box::new(self.faults.iter().map(|fault| fault as &dyn Diagnostic)))
    }
}

/// Returns the candidate most similar to `name`, if one is similar enough.
pub fn nearest<'a>(name: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    candidates
        .into_iter()
        .map(|candidate| {
            let similarity =
                strsim::normalized_damerau_levenshtein(&name.to_lowercase(), &candidate.to_lowercase())
                    .max(0.95 * strsim::jaro_winkler(name, candidate) - 0.25);
            (candidate, similarity)
        })
        .filter(|(_, similarity)| *similarity > 0.4)
        .max_by(|a, b| a.1.total_cmp(&b.1))
        .map(|(candidate, _)| candidate)
}

/// Returns true if `name` differs from a candidate by few letters, as a misspelling does.
pub fn is_misspelt(name: &str, candidate: &str) -> bool {
    strsim::normalized_damerau_levenshtein(&name.to_lowercase(), &candidate.to_lowercase()) > 0.6
}

/// Returns advice such as "did you mean `near`? allowed: a, b, c".
pub fn advice<'a>(name: &str, candidates: impl IntoIterator<Item = &'a str> + Clone) -> String {
    let allowed = candidates.clone().into_iter().map(|c| format!("`{c}`")).collect::<Vec<_>>().join(", ");
    match nearest(name, candidates) {
        _ if allowed.is_empty() => "there are none: leave the name out".to_owned(),
        Some(near) => format!("did you mean `{near}`? allowed: {allowed}"),
        None => format!("allowed: {allowed}"),
    }
}
