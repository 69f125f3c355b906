//! Parts of a compound value as serde requests them: items, named fields, variants.

use serde::de::{self, DeserializeSeed, IntoDeserializer, MapAccess, SeqAccess, Visitor};

use super::{Abort, Context, Typed, seed};
use crate::notation::tree::{Node, Value};

/// Items of a list or tuple.
pub(super) struct Items<'a> {
    items: std::vec::IntoIter<Option<&'a Node>>,
    context: &'a Context<'a>,
    field: &'a str,
}

impl<'a> Items<'a> {
    pub(super) fn of(items: &'a [Node], context: &'a Context<'a>, field: &'a str) -> Self {
        Self { items: items.iter().map(Some).collect::<Vec<_>>().into_iter(), context, field }
    }

    pub(super) fn placeholders(count: usize, context: &'a Context<'a>, field: &'a str) -> Self {
        Self { items: vec![None; count].into_iter(), context, field }
    }
}

impl<'de> SeqAccess<'de> for Items<'de> {
    type Error = Abort;

    fn next_element_seed<S: DeserializeSeed<'de>>(
        &mut self,
        item_seed: S,
    ) -> Result<Option<S::Value>, Abort> {
        self.items.next().map(|node| seed(item_seed, node, self.context, self.field)).transpose()
    }
}

/// Named fields of a struct.
pub(super) struct Entries<'a> {
    entries: std::vec::IntoIter<(&'a str, Option<&'a Node>)>,
    value: Option<(&'a str, Option<&'a Node>)>,
    context: &'a Context<'a>,
}

impl<'a> Entries<'a> {
    pub(super) fn new(entries: Vec<(&'a str, Option<&'a Node>)>, context: &'a Context<'a>) -> Self {
        Self { entries: entries.into_iter(), value: None, context }
    }
}

impl<'de> MapAccess<'de> for Entries<'de> {
    type Error = Abort;

    fn next_key_seed<S: DeserializeSeed<'de>>(&mut self, key_seed: S) -> Result<Option<S::Value>, Abort> {
        self.value = self.entries.next();
        match self.value {
            Some((name, _)) => {
                key_seed.deserialize(IntoDeserializer::<Abort>::into_deserializer(name)).map(Some)
            }
            None => Ok(None),
        }
    }

    fn next_value_seed<S: DeserializeSeed<'de>>(&mut self, value_seed: S) -> Result<S::Value, Abort> {
        let (name, node) = self.value.take().unwrap_or(("", None));
        seed(value_seed, node, self.context, name)
    }
}

/// A variant of an enum; `node` is None for a placeholder.
pub(super) struct Variant<'a> {
    pub(super) name: &'static str,
    pub(super) node: Option<&'a Node>,
    pub(super) context: &'a Context<'a>,
}

impl<'a> Variant<'a> {
    fn content(&self) -> Typed<'a> {
        Typed::new(self.node, self.context, self.name)
    }

    /// Reports that the variant needs a value in brackets.
    fn mismatch_of_content(&self) {
        if let Some(node) = self.node {
            let wanted = format!("`{}(…)` with one value", self.name);
            self.content().mismatch(node, &wanted);
        }
    }

    fn is_name_alone(&self) -> bool {
        matches!(self.node, Some(Node { value: Value::Name(_) | Value::Text(..), .. }))
    }
}

impl<'de> de::EnumAccess<'de> for Variant<'de> {
    type Error = Abort;
    type Variant = Self;

    fn variant_seed<S: DeserializeSeed<'de>>(self, name_seed: S) -> Result<(S::Value, Self), Abort> {
        let name = name_seed.deserialize(IntoDeserializer::<Abort>::into_deserializer(self.name))?;
        Ok((name, self))
    }
}

impl<'de> de::VariantAccess<'de> for Variant<'de> {
    type Error = Abort;

    fn unit_variant(self) -> Result<(), Abort> {
        match self.node.map(|node| (node, &node.value)) {
            None | Some((_, Value::Name(_) | Value::Text(..))) => {}
            Some((_, Value::Tuple(_, items))) if items.is_empty() => {}
            Some((node, _)) => self.content().mismatch(node, "a name without content"),
        }
        Ok(())
    }

    fn newtype_variant_seed<S: DeserializeSeed<'de>>(self, content_seed: S) -> Result<S::Value, Abort> {
        let node = match self.node.map(|node| &node.value) {
            // In `Reference(0.0)` or `Union([…])` the bracket holds the content alone.
            Some(Value::Tuple(_, items)) if items.len() == 1 => items.first(),
            // In `Box(min: …, max: …)` the bracket of the content is omitted.
            Some(Value::Struct(..)) => return content_seed.deserialize(Unnamed(self)),
            Some(Value::Tuple(_, items)) if items.is_empty() => {
                return content_seed.deserialize(Unnamed(self));
            }
            // `WaveEquation` alone: every field at its default.
            Some(Value::Name(_) | Value::Text(..)) => return content_seed.deserialize(Unnamed(self)),
            Some(_) => {
                self.mismatch_of_content();
                None
            }
            None => None,
        };
        seed(content_seed, node, self.context, self.name)
    }

    fn tuple_variant<V: Visitor<'de>>(self, length: usize, visitor: V) -> Result<V::Value, Abort> {
        let items = match self.node.map(|node| (node, &node.value)) {
            Some((_, Value::Tuple(_, items))) if items.len() == length => {
                Items::of(items, self.context, self.name)
            }
            given => {
                if let Some((node, _)) = given {
                    let wanted = format!("`{}(…)` with {length} values", self.name);
                    self.content().mismatch(node, &wanted);
                }
                Items::placeholders(length, self.context, self.name)
            }
        };
        visitor.visit_seq(items)
    }

    fn struct_variant<V: Visitor<'de>>(
        self,
        fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Abort> {
        let content = self.content();
        let entries = match self.node.map(|node| &node.value) {
            // `WaveEquation` alone: every field at its default.
            Some(Value::Name(_) | Value::Text(..)) => Entries::new(Vec::new(), self.context),
            _ => content.entries(self.name, fields),
        };
        visitor.visit_map(entries).map_err(|abort| abort.at(self.node))
    }
}

/// Content of a newtype variant whose bracket is omitted.
struct Unnamed<'a>(Variant<'a>);

impl<'a> Unnamed<'a> {
    /// Returns the content if it is a single value; otherwise reports it and returns a placeholder.
    fn value(&self) -> Typed<'a> {
        if self.0.is_name_alone() {
            self.0.mismatch_of_content();
            return Typed::new(None, self.0.context, self.0.name);
        }
        self.0.content()
    }
}

impl<'de> de::Deserializer<'de> for Unnamed<'de> {
    type Error = Abort;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Abort> {
        self.value().deserialize_any(visitor)
    }

    fn deserialize_f64<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Abort> {
        self.value().deserialize_f64(visitor)
    }

    fn deserialize_seq<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Abort> {
        self.value().deserialize_seq(visitor)
    }

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        name: &'static str,
        fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Abort> {
        if name == super::spanned::NAME {
            let (node, context) = (self.0.node, self.0.context);
            return visitor.visit_map(super::spanned::Access::new(node, context, self.0));
        }
        let node = self.0.node;
        if self.0.is_name_alone() {
            let defaults = Entries::new(Vec::new(), self.0.context);
            return visitor.visit_map(defaults).map_err(|abort| abort.at(node));
        }
        visitor.visit_map(self.0.content().entries(self.0.name, fields)).map_err(|abort| abort.at(node))
    }

    serde::forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 char str string bytes byte_buf option unit
        unit_struct newtype_struct tuple tuple_struct map enum identifier ignored_any
    }
}

impl<'de> super::spanned::Content<'de> for Variant<'de> {
    fn read<S: DeserializeSeed<'de>>(self, content_seed: S) -> Result<S::Value, Abort> {
        content_seed.deserialize(Unnamed(self))
    }
}
