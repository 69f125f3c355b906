//! Numbers, formulas, vectors and intervals of a scene description.

use glam::{DVec2, DVec3};
use serde::Serialize;

/// A number, or an expression of the constants such as `"2*R"`.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Number {
    /// A number.
    Value(f64),
    /// An expression of the constants.
    Expression(String),
}

impl From<f64> for Number {
    fn from(value: f64) -> Self {
        Self::Value(value)
    }
}

impl From<i32> for Number {
    fn from(value: i32) -> Self {
        Self::Value(value.into())
    }
}

impl From<u32> for Number {
    fn from(value: u32) -> Self {
        Self::Value(value.into())
    }
}

impl From<&str> for Number {
    fn from(text: &str) -> Self {
        Self::Expression(text.to_owned())
    }
}

impl From<String> for Number {
    fn from(text: String) -> Self {
        Self::Expression(text)
    }
}

/// A field of x, y, z (m) and t (s): a number or an expression such as `"v0*(1 - y^2/R^2)"`.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(transparent)]
pub struct Formula(Number);

impl<N: Into<Number>> From<N> for Formula {
    fn from(number: N) -> Self {
        Self(number.into())
    }
}

/// Components along x, y and, in 3D, z: made of a tuple, which may mix numbers and text, of an
/// array, or of a vector of glam.
#[derive(Clone, Debug, PartialEq)]
pub struct Components<C>(Vec<C>);

/// Two or three numbers: a point in m or a direction.
pub type Vector = Components<Number>;

/// Two or three formulas: a vector field.
pub type VectorFormula = Components<Formula>;

impl<C> Components<C> {
    /// Returns the components.
    pub(super) fn into_list(self) -> Vec<C> {
        self.0
    }
}

impl<C: Serialize> Serialize for Components<C> {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        use serde::ser::SerializeTuple;
        let mut tuple = serializer.serialize_tuple(self.0.len())?;
        for component in &self.0 {
            tuple.serialize_element(component)?;
        }
        tuple.end()
    }
}

impl<C, X: Into<C>, Y: Into<C>> From<(X, Y)> for Components<C> {
    fn from((x, y): (X, Y)) -> Self {
        Self(vec![x.into(), y.into()])
    }
}

impl<C, X: Into<C>, Y: Into<C>, Z: Into<C>> From<(X, Y, Z)> for Components<C> {
    fn from((x, y, z): (X, Y, Z)) -> Self {
        Self(vec![x.into(), y.into(), z.into()])
    }
}

impl<C, N: Into<C>> From<[N; 2]> for Components<C> {
    fn from(components: [N; 2]) -> Self {
        Self(components.into_iter().map(N::into).collect())
    }
}

impl<C, N: Into<C>> From<[N; 3]> for Components<C> {
    fn from(components: [N; 3]) -> Self {
        Self(components.into_iter().map(N::into).collect())
    }
}

impl<C: From<f64>> From<DVec2> for Components<C> {
    fn from(vector: DVec2) -> Self {
        vector.to_array().into()
    }
}

impl<C: From<f64>> From<DVec3> for Components<C> {
    fn from(vector: DVec3) -> Self {
        vector.to_array().into()
    }
}

/// An interval of time, s: made of a tuple of beginning and end.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Interval(Number, Number);

impl<B: Into<Number>, E: Into<Number>> From<(B, E)> for Interval {
    fn from((begin, end): (B, E)) -> Self {
        Self(begin.into(), end.into())
    }
}
