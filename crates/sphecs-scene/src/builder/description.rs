//! Declaration of a description: a struct with a chained method per field.

/// Declares a struct whose fields may all be left out, and a method for each of them.
///
/// A field `name: Kind` becomes an `Option<Kind>` that the method `name` sets. A list
/// `method -> name: Kind` becomes a `Vec<Kind>` to which `method` adds. Field names are those of
/// the scene file; a field that is left out is not written.
macro_rules! description {
    (
        $(#[$attribute:meta])*
        pub struct $struct:ident {
            $($(#[$text:meta])* $field:ident: $kind:ty,)*
        }
        $(lists {
            $($(#[$list_text:meta])* $method:ident -> $list:ident: $item:ty,)*
        })?
    ) => {
        $(#[$attribute])*
        #[derive(Clone, Debug, Default, PartialEq, serde::Serialize)]
        #[must_use = "a description does nothing until it is part of a scene"]
        pub struct $struct {
            $(
                #[serde(skip_serializing_if = "Option::is_none")]
                $field: Option<$kind>,
            )*
            $($(
                #[serde(skip_serializing_if = "Vec::is_empty")]
                $list: Vec<$item>,
            )*)?
        }

        impl $struct {
            $(
                $(#[$text])*
                pub fn $field(mut self, $field: impl Into<$kind>) -> Self {
                    self.$field = Some($field.into());
                    self
                }
            )*
            $($(
                $(#[$list_text])*
                pub fn $method(mut self, $method: impl Into<$item>) -> Self {
                    self.$list.push($method.into());
                    self
                }
            )*)?
        }
    };
}

pub(super) use description;
