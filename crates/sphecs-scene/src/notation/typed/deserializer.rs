//! serde `Deserializer` over the tree.

use serde::de::{self, IntoDeserializer, Visitor};

use super::parts::{Entries, Items};
use super::value::Typed;
use super::{Abort, spanned};
use crate::notation::tree::{Node, Value};

macro_rules! whole {
    ($($method:ident $visit:ident $type:ty),* $(,)?) => {
        $(fn $method<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Abort> {
            let value = <$type>::try_from(self.whole_number()).unwrap_or(<$type>::MAX);
            visitor.$visit(value).map_err(|abort: Abort| abort.at(self.node))
        })*
    };
}

impl<'de> de::Deserializer<'de> for Typed<'de> {
    type Error = Abort;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Abort> {
        match self.node.map(|node| &node.value) {
            None | Some(Value::Number(..)) => visitor.visit_f64(self.number()),
            Some(Value::Bool(value)) => visitor.visit_bool(*value),
            Some(Value::Text(text, _)) => visitor.visit_borrowed_str(text),
            Some(_) => visitor.visit_unit(),
        }
        .map_err(|abort: Abort| abort.at(self.node))
    }

    fn deserialize_bool<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Abort> {
        let value = match self.node {
            Some(Node { value: Value::Bool(value), .. }) => *value,
            Some(node) => {
                self.mismatch(node, "`true` or `false`");
                false
            }
            None => false,
        };
        visitor.visit_bool(value)
    }

    whole! {
        deserialize_u8 visit_u8 u8, deserialize_u16 visit_u16 u16,
        deserialize_u32 visit_u32 u32, deserialize_u64 visit_u64 u64,
        deserialize_i8 visit_i8 i8, deserialize_i16 visit_i16 i16,
        deserialize_i32 visit_i32 i32, deserialize_i64 visit_i64 i64,
    }

    fn deserialize_f32<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Abort> {
        visitor.visit_f32(self.number() as f32)
    }

    fn deserialize_f64<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Abort> {
        visitor.visit_f64(self.number())
    }

    fn deserialize_str<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Abort> {
        let text = match self.node.map(|node| (node, &node.value)) {
            Some((_, Value::Text(text, _))) => text.as_str(),
            Some((node, _)) => {
                self.mismatch(node, "text in quotes");
                ""
            }
            None => "",
        };
        visitor.visit_borrowed_str(text).map_err(|abort: Abort| abort.at(self.node))
    }

    fn deserialize_string<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Abort> {
        self.deserialize_str(visitor)
    }

    fn deserialize_identifier<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Abort> {
        self.deserialize_str(visitor)
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Abort> {
        match self.node.map(|node| &node.value) {
            None => visitor.visit_none(),
            Some(Value::Name(name)) if name == "None" => visitor.visit_none(),
            Some(Value::Tuple(Some(name), items)) if name.text == "Some" && items.len() == 1 => {
                visitor.visit_some(Typed::new(items.first(), self.context, self.field))
            }
            Some(_) => visitor.visit_some(self),
        }
    }

    fn deserialize_unit<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Abort> {
        visitor.visit_unit()
    }

    fn deserialize_unit_struct<V: Visitor<'de>>(
        self,
        _name: &'static str,
        visitor: V,
    ) -> Result<V::Value, Abort> {
        visitor.visit_unit()
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(
        self,
        _name: &'static str,
        visitor: V,
    ) -> Result<V::Value, Abort> {
        visitor.visit_newtype_struct(self)
    }

    fn deserialize_seq<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Abort> {
        let items = self.elements().unwrap_or_else(|| {
            if let Some(node) = self.node {
                self.mismatch(node, "a list");
            }
            &[]
        });
        visitor.visit_seq(Items::of(items, self.context, self.field)).map_err(|abort| abort.at(self.node))
    }

    fn deserialize_tuple<V: Visitor<'de>>(self, length: usize, visitor: V) -> Result<V::Value, Abort> {
        let items = match self.elements() {
            Some(items) if items.len() == length => Items::of(items, self.context, self.field),
            _ => {
                if let Some(node) = self.node {
                    self.mismatch(node, &format!("a tuple of {length} values"));
                }
                Items::placeholders(length, self.context, self.field)
            }
        };
        visitor.visit_seq(items).map_err(|abort| abort.at(self.node))
    }

    fn deserialize_tuple_struct<V: Visitor<'de>>(
        self,
        _name: &'static str,
        length: usize,
        visitor: V,
    ) -> Result<V::Value, Abort> {
        self.deserialize_tuple(length, visitor)
    }

    fn deserialize_map<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Abort> {
        visitor.visit_map(Entries::new(Vec::new(), self.context)).map_err(|abort| abort.at(self.node))
    }

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        name: &'static str,
        fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Abort> {
        if name == spanned::NAME {
            return visitor.visit_map(spanned::Access::new(self.node, self.context, self));
        }
        visitor.visit_map(self.entries(name, fields)).map_err(|abort| abort.at(self.node))
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        _name: &'static str,
        variants: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Abort> {
        visitor.visit_enum(self.variant(variants)).map_err(|abort| abort.at(self.node))
    }

    fn deserialize_ignored_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Abort> {
        visitor.visit_unit()
    }

    serde::forward_to_deserialize_any! { char bytes byte_buf }
}

impl<'de> IntoDeserializer<'de, Abort> for Typed<'de> {
    type Deserializer = Self;

    fn into_deserializer(self) -> Self {
        self
    }
}
