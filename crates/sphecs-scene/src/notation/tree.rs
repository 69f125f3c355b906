//! RON values with their positions in the text.

/// Bytes `start..end` of a text.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Span {
    /// First byte.
    pub start: usize,
    /// One past the last byte.
    pub end: usize,
}

impl Span {
    /// Span of a placeholder for a faulty value: faults there are consequences, not causes.
    pub const PLACEHOLDER: Span = Span { start: usize::MAX, end: usize::MAX };

    /// Returns the span of the bytes `start..end`.
    pub fn new(start: usize, end: usize) -> Self {
        Self { start, end }
    }

    /// Returns true if the value is a placeholder for a faulty or missing one.
    pub fn is_placeholder(self) -> bool {
        self == Self::PLACEHOLDER
    }

    /// Returns true if `inner` lies within.
    pub fn contains(self, inner: Span) -> bool {
        self.start <= inner.start && inner.end <= self.end
    }
}

/// A value and its position.
#[derive(Clone, Debug, PartialEq)]
pub struct Node {
    /// Value of the node.
    pub value: Value,
    /// Position in the text.
    pub span: Span,
}

/// A name and its position.
#[derive(Clone, Debug, PartialEq)]
pub struct Name {
    /// The name.
    pub text: String,
    /// Position in the text.
    pub span: Span,
}

/// A RON value.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// A syntax fault was reported here.
    Broken,
    /// `true` or `false`.
    Bool(bool),
    /// A number; true if it was written without point and exponent.
    Number(f64, bool),
    /// Text in quotes, with the byte at which it begins if it has no escapes.
    Text(String, Option<usize>),
    /// A bare name: `None` or a variant without content.
    Name(String),
    /// `[a, b]`
    List(Vec<Node>),
    /// `{a: b}`
    Map(Vec<(Node, Node)>),
    /// `(a, b)` or `Name(a, b)`, also empty.
    Tuple(Option<Name>, Vec<Node>),
    /// `(a: b)` or `Name(a: b)`
    Struct(Option<Name>, Vec<StructField>),
}

/// A field of a struct.
#[derive(Clone, Debug, PartialEq)]
pub struct StructField {
    /// Its name.
    pub name: Name,
    /// Its value.
    pub value: Node,
}

impl Node {
    /// Returns the part to mark instead of a long value: the name or the opening bracket.
    pub fn head(&self) -> Span {
        match &self.value {
            Value::Tuple(Some(name), _) | Value::Struct(Some(name), _) => name.span,
            Value::List(_) | Value::Map(_) | Value::Tuple(..) | Value::Struct(..) => {
                Span::new(self.span.start, (self.span.start + 1).min(self.span.end))
            }
            _ => self.span,
        }
    }

    /// Returns the kind of the value in words.
    pub fn kind(&self) -> String {
        match &self.value {
            Value::Broken => "unreadable".to_owned(),
            Value::Bool(value) => format!("`{value}`"),
            Value::Number(value, _) => format!("the number `{value}`"),
            Value::Text(..) => "text in quotes".to_owned(),
            Value::Name(name) => format!("the name `{name}`"),
            Value::List(_) => "a list".to_owned(),
            Value::Map(_) => "a map".to_owned(),
            Value::Tuple(None, items) | Value::Tuple(_, items) if items.is_empty() => {
                "empty brackets".to_owned()
            }
            Value::Tuple(None, items) => format!("a tuple of {}", items.len()),
            Value::Struct(None, _) => "brackets with named fields".to_owned(),
            Value::Tuple(Some(name), _) | Value::Struct(Some(name), _) => {
                format!("`{}(…)`", name.text)
            }
        }
    }

    /// Returns the value of a field of a struct.
    pub fn field(&self, name: &str) -> Option<&Node> {
        match &self.value {
            Value::Struct(_, fields) => {
                fields.iter().find(|field| field.name.text == name).map(|field| &field.value)
            }
            _ => None,
        }
    }
}
