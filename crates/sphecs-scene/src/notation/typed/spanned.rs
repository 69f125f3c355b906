//! A value with its position in the text of the scene.

use std::marker::PhantomData;

use serde::de::{self, DeserializeSeed, IntoDeserializer, MapAccess, Visitor};
use serde::{Deserialize, Deserializer};

use super::{Abort, Context, Typed};
use crate::notation::tree::{Node, Span};

/// Struct name under which the position is requested; no scene can contain it.
pub(super) const NAME: &str = "$spanned";
const FIELDS: &[&str] = &["value", "start", "end", "head"];

/// A value and its position.
#[derive(Clone, Copy, Debug)]
pub struct Spanned<T> {
    /// The value.
    pub value: T,
    /// Position of the value, [`Span::PLACEHOLDER`] for a placeholder.
    pub span: Span,
    /// Part of the position to mark in a message.
    pub head: Span,
}

impl<T> Spanned<T> {
    /// Returns true if it is a placeholder for a faulty value.
    pub fn is_placeholder(&self) -> bool {
        self.span.is_placeholder()
    }
}

impl<'de, T: Deserialize<'de>> Deserialize<'de> for Spanned<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_struct(NAME, FIELDS, SpannedVisitor(PhantomData))
    }
}

/// The schema of the value: a scene does not write positions.
#[cfg(feature = "schema")]
impl<T: schemars::JsonSchema> schemars::JsonSchema for Spanned<T> {
    fn inline_schema() -> bool {
        T::inline_schema()
    }

    fn schema_name() -> std::borrow::Cow<'static, str> {
        T::schema_name()
    }

    fn schema_id() -> std::borrow::Cow<'static, str> {
        T::schema_id()
    }

    fn json_schema(generator: &mut schemars::SchemaGenerator) -> schemars::Schema {
        T::json_schema(generator)
    }
}

struct SpannedVisitor<T>(PhantomData<T>);

impl<'de, T: Deserialize<'de>> Visitor<'de> for SpannedVisitor<T> {
    type Value = Spanned<T>;

    fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("a value of a scene")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Spanned<T>, A::Error> {
        let (_, value): (IgnoredKey, T) =
            map.next_entry()?.ok_or_else(|| de::Error::custom("a value is missing"))?;
        let mut place = || -> Result<usize, A::Error> {
            let (_, number): (IgnoredKey, u64) =
                map.next_entry()?.ok_or_else(|| de::Error::custom("a place is missing"))?;
            Ok(usize::try_from(number).unwrap_or(usize::MAX))
        };
        let span = Span::new(place()?, place()?);
        let head = Span::new(span.start, place()?);
        Ok(Spanned { value, span, head })
    }
}

/// Key of an entry whose order is known.
struct IgnoredKey;

impl<'de> Deserialize<'de> for IgnoredKey {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_ignored_any(de::IgnoredAny).map(|_| IgnoredKey)
    }
}

/// Content that can be read before its position is known.
pub(super) trait Content<'de> {
    fn read<S: DeserializeSeed<'de>>(self, seed: S) -> Result<S::Value, Abort>;
}

impl<'de> Content<'de> for Typed<'de> {
    fn read<S: DeserializeSeed<'de>>(self, seed: S) -> Result<S::Value, Abort> {
        seed.deserialize(self)
    }
}

/// Entries of a spanned value: the value, start, end and end of the head. A value that was refused
/// has no position.
pub(super) struct Access<'a, C> {
    node: Option<&'a Node>,
    context: &'a Context<'a>,
    given: usize,
    content: Option<C>,
}

impl<'a, C> Access<'a, C> {
    pub(super) fn new(node: Option<&'a Node>, context: &'a Context<'a>, content: C) -> Self {
        Self { node, context, given: 0, content: Some(content) }
    }

    fn place(&self) -> [usize; 3] {
        let accepted = self.node.filter(|node| !self.context.refused.borrow().contains(&node.span));
        let (span, head) =
            accepted.map_or((Span::PLACEHOLDER, Span::PLACEHOLDER), |node| (node.span, node.head()));
        [span.start, span.end, head.end]
    }
}

impl<'de, C: Content<'de>> MapAccess<'de> for Access<'de, C> {
    type Error = Abort;

    fn next_key_seed<S: DeserializeSeed<'de>>(&mut self, seed: S) -> Result<Option<S::Value>, Abort> {
        match FIELDS.get(self.given) {
            Some(name) => {
                self.given += 1;
                seed.deserialize(IntoDeserializer::<Abort>::into_deserializer(*name)).map(Some)
            }
            None => Ok(None),
        }
    }

    fn next_value_seed<S: DeserializeSeed<'de>>(&mut self, seed: S) -> Result<S::Value, Abort> {
        if let Some(content) = self.content.take() {
            return content.read(seed);
        }
        let place = self.place()[self.given.saturating_sub(2).min(2)];
        let place = u64::try_from(place).unwrap_or(u64::MAX);
        seed.deserialize(IntoDeserializer::<Abort>::into_deserializer(place))
    }
}
