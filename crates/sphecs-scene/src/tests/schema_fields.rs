//! Names of the fields and variants that a type can be read from, found by reading it.
//!
//! serde passes the field names of a struct and the variants of an enum to the deserializer. The
//! one here records them. Without a text it gives every field a value and takes each variant in
//! turn; with a text it follows the text.

use std::cell::RefCell;
use std::collections::BTreeSet;

use serde::de::value::{Error, MapDeserializer, SeqDeserializer};
use serde::de::{DeserializeOwned, DeserializeSeed, Deserializer, EnumAccess, IntoDeserializer};
use serde::de::{VariantAccess, Visitor};

use crate::notation::tree::{Node, Value};

/// Names as `Struct.field`, `Enum::Variant` and `Enum::Variant.field`.
pub(super) type Names = BTreeSet<String>;

/// Reads values of a type until all fields and variants have occurred; returns them and the names.
pub(super) fn all<T: DeserializeOwned>() -> (Vec<T>, Names) {
    let found = RefCell::new(Names::new());
    let mut values = Vec::new();
    loop {
        let before = found.borrow().len();
        values.push(T::deserialize(Recorder { source: Source::Every, found: &found }).unwrap());
        if found.borrow().len() == before {
            return (values, found.into_inner());
        }
    }
}

/// Returns the names that a text gives.
pub(super) fn given<T: DeserializeOwned>(root: &Node) -> Names {
    let found = RefCell::new(Names::new());
    let read = T::deserialize(Recorder { source: Source::Text(root), found: &found });
    assert!(read.is_ok(), "{:?} in {root:?}", read.err());
    found.into_inner()
}

/// Origin of the values.
#[derive(Clone, Copy)]
enum Source<'a> {
    /// Every field of the type.
    Every,
    /// A text.
    Text(&'a Node),
    /// A variant that a text gives by its name alone.
    Nothing,
}

#[derive(Clone, Copy)]
struct Recorder<'a> {
    source: Source<'a>,
    found: &'a RefCell<Names>,
}

impl<'a> Recorder<'a> {
    fn with(self, source: Source<'a>) -> Self {
        Self { source, ..self }
    }

    fn value(self) -> Option<&'a Value> {
        match self.source {
            Source::Text(node) => Some(&node.value),
            Source::Every | Source::Nothing => None,
        }
    }

    fn number(self) -> f64 {
        match self.value() {
            Some(Value::Number(number, _)) => *number,
            _ => 1.0,
        }
    }

    fn text(self) -> &'a str {
        match self.value() {
            Some(Value::Text(text, _)) => text,
            _ => "text",
        }
    }

    /// Returns the elements of a list or tuple, or `count` elements if there is no text.
    fn elements(self, count: usize) -> Vec<Self> {
        match (self.source, self.value()) {
            (_, Some(Value::List(items) | Value::Tuple(_, items))) => {
                items.iter().map(|item| self.with(Source::Text(item))).collect()
            }
            (Source::Every, _) => vec![self; count],
            _ => Vec::new(),
        }
    }

    /// Fields that occur of those of a struct; they are recorded under its name.
    fn fields(self, name: &str, known: &'static [&'static str]) -> Vec<(&'static str, Self)> {
        let occurs = |field: &&'static str| {
            let source = match self.source {
                Source::Every => Source::Every,
                Source::Text(node) => Source::Text(node.field(field)?),
                Source::Nothing => return None,
            };
            self.found.borrow_mut().insert(format!("{name}.{field}"));
            Some((*field, self.with(source)))
        };
        known.iter().filter_map(occurs).collect()
    }
}

impl<'de> IntoDeserializer<'de, Error> for Recorder<'de> {
    type Deserializer = Self;

    fn into_deserializer(self) -> Self {
        self
    }
}

macro_rules! numbers {
    ($($method:ident $visit:ident $type:ty),*) => {
        $(fn $method<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
            visitor.$visit(self.number() as $type)
        })*
    };
}

impl<'de> Deserializer<'de> for Recorder<'de> {
    type Error = Error;

    numbers! { deserialize_f64 visit_f64 f64, deserialize_u64 visit_u64 u64, deserialize_u32 visit_u32 u32 }

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        match self.value() {
            Some(Value::Text(text, _)) => visitor.visit_str(text),
            _ => visitor.visit_f64(self.number()),
        }
    }

    fn deserialize_bool<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        visitor.visit_bool(true)
    }

    fn deserialize_str<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        visitor.visit_str(self.text())
    }

    fn deserialize_string<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        visitor.visit_str(self.text())
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        match self.value() {
            Some(Value::Name(name)) if name == "None" => visitor.visit_none(),
            _ => visitor.visit_some(self),
        }
    }

    fn deserialize_seq<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        visitor.visit_seq(SeqDeserializer::new(self.elements(1).into_iter()))
    }

    fn deserialize_tuple<V: Visitor<'de>>(self, count: usize, visitor: V) -> Result<V::Value, Error> {
        visitor.visit_seq(SeqDeserializer::new(self.elements(count).into_iter()))
    }

    fn deserialize_ignored_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        visitor.visit_unit()
    }

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        name: &'static str,
        fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Error> {
        // A value with its place: the value, then numbers.
        let entries = match name {
            "$spanned" => fields.iter().map(|field| (*field, self)).collect(),
            _ => self.fields(name, fields),
        };
        visitor.visit_map(MapDeserializer::new(entries.into_iter()))
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        name: &'static str,
        variants: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Error> {
        let full = |variant: &str| format!("{name}::{variant}");
        let written = match self.value() {
            Some(Value::Tuple(Some(variant), _) | Value::Struct(Some(variant), _)) => {
                Some(variant.text.as_str())
            }
            Some(Value::Name(variant)) => Some(variant.as_str()),
            _ => None,
        };
        let fresh = |variant: &&&str| !self.found.borrow().contains(&full(variant));
        // The first variants of the schema's enums contain no further one.
        let variant = written.or_else(|| variants.iter().find(fresh).copied()).unwrap_or(variants[0]);
        self.found.borrow_mut().insert(full(variant));
        visitor.visit_enum(Variant { content: self, variant, full: full(variant) })
    }

    serde::forward_to_deserialize_any! {
        i8 i16 i32 i64 u8 u16 f32 char bytes byte_buf unit unit_struct newtype_struct tuple_struct map
        identifier
    }
}

/// A variant that was chosen.
struct Variant<'a> {
    content: Recorder<'a>,
    variant: &'a str,
    full: String,
}

impl<'de> EnumAccess<'de> for Variant<'de> {
    type Error = Error;
    type Variant = Self;

    fn variant_seed<S: DeserializeSeed<'de>>(self, seed: S) -> Result<(S::Value, Self), Error> {
        Ok((seed.deserialize(self.variant.into_deserializer())?, self))
    }
}

impl<'de> VariantAccess<'de> for Variant<'de> {
    type Error = Error;

    fn unit_variant(self) -> Result<(), Error> {
        Ok(())
    }

    fn newtype_variant_seed<S: DeserializeSeed<'de>>(self, seed: S) -> Result<S::Value, Error> {
        seed.deserialize(match self.content.value() {
            Some(Value::Tuple(_, items)) if items.len() == 1 => self.content.with(Source::Text(&items[0])),
            Some(Value::Name(_)) => self.content.with(Source::Nothing),
            _ => self.content,
        })
    }

    fn tuple_variant<V: Visitor<'de>>(self, count: usize, visitor: V) -> Result<V::Value, Error> {
        self.content.deserialize_tuple(count, visitor)
    }

    fn struct_variant<V: Visitor<'de>>(
        self,
        fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Error> {
        let fields = self.content.fields(&self.full, fields);
        visitor.visit_map(MapDeserializer::new(fields.into_iter()))
    }
}
