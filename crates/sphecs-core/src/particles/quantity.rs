//! Columns of one quantity of the particles: one column for a scalar, one per axis for a vector.
//!
//! The code that the table of columns (`table`) generates uses these two traits to read and write
//! particles and checkpoints.

use glam::DVec3;

use super::zone::Zone;
use crate::math::column::{ColumnMismatch, Columns, Element};
use crate::math::real::Real;

/// Number of one particle in a column.
pub trait ColumnElement: Copy + Default + PartialEq + Send + Sync {
    /// The number as a [`ParticleRow`](super::rows::ParticleRow) holds it.
    type Value: Copy + Default;
    /// The number as a checkpoint keeps it.
    type Saved: Element;

    /// Returns the value of the number.
    fn value(self) -> Self::Value;

    /// Returns the number of a value.
    fn from_value(value: Self::Value) -> Self;

    /// Returns the number as a checkpoint keeps it.
    fn saved(self) -> Self::Saved;

    /// Returns the number that a checkpoint has kept.
    ///
    /// # Errors
    /// [`ColumnMismatch`] when no particle can have it.
    fn from_saved(saved: Self::Saved) -> Result<Self, ColumnMismatch>;
}

impl<R: Real> ColumnElement for R {
    type Value = f64;
    type Saved = R;

    fn value(self) -> f64 {
        self.to_f64()
    }

    fn from_value(value: f64) -> R {
        R::from_f64(value)
    }

    fn saved(self) -> R {
        self
    }

    fn from_saved(saved: R) -> Result<R, ColumnMismatch> {
        Ok(saved)
    }
}

/// Implements [`ColumnElement`] for a type that is its own value.
macro_rules! element {
    ($type:ty, $saved:ty, $into:expr, $from:expr) => {
        impl ColumnElement for $type {
            type Value = $type;
            type Saved = $saved;

            fn value(self) -> $type {
                self
            }

            fn from_value(value: $type) -> $type {
                value
            }

            fn saved(self) -> $saved {
                $into(self)
            }

            fn from_saved(saved: $saved) -> Result<$type, ColumnMismatch> {
                $from(saved)
            }
        }
    };
}

element!(u32, u32, |number| number, Ok);
element!(u16, u16, |number| number, Ok);
element!(bool, u8, u8::from, |number| Ok(number != 0));
element!(Zone, u8, |zone| zone as u8, active_zone);

/// Returns the zone of a number; particles of the reservoir have no row.
fn active_zone(number: u8) -> Result<Zone, ColumnMismatch> {
    let zone = Zone::from_number(number).filter(|zone| *zone != Zone::Reservoir);
    zone.ok_or_else(|| ColumnMismatch(format!("it has a particle of zone `{number}`")))
}

/// Columns of one quantity.
pub trait Quantity: Sized {
    /// Number in a column.
    type Element: ColumnElement;
    /// Value of one particle.
    type Value: Copy + Default;

    /// Returns the columns: one, or one per axis.
    fn columns(&self) -> &[Vec<Self::Element>];

    /// Returns the columns for writing.
    fn columns_mut(&mut self) -> &mut [Vec<Self::Element>];

    /// Returns columns without particles.
    fn empty() -> Self;

    /// Returns the value of the particle of a row.
    fn value(&self, row: usize) -> Self::Value;

    /// Appends the value of a particle. Rows up to `row`, which had none, get the default.
    fn push(&mut self, row: usize, value: Self::Value);

    /// Writes the value of the particle of a row.
    fn set(&mut self, row: usize, value: Self::Value);

    /// Returns the name of a column in a checkpoint: `name`, or `name.axis` of a vector.
    fn saved_name(name: &str, axis: usize) -> String;

    /// Adds the columns to a checkpoint, of the particles that `pick` chooses.
    fn save(&self, name: &str, pick: &impl Fn(&[Self::Element]) -> Vec<Self::Element>, to: &mut Columns) {
        for (axis, column) in self.columns().iter().enumerate() {
            let values = if column.is_empty() { Vec::new() } else { pick(column) };
            to.put(Self::saved_name(name, axis), values.into_iter().map(ColumnElement::saved).collect());
        }
    }

    /// Takes the columns from a checkpoint; all must have one of these numbers of rows.
    ///
    /// # Errors
    /// [`ColumnMismatch`] when a column is missing, of another type or length, or has a wrong
    /// value.
    fn restore(name: &str, lengths: &[usize], from: &mut Columns) -> Result<Self, ColumnMismatch> {
        let mut quantity = Self::empty();
        let mut length = None;
        for (axis, column) in quantity.columns_mut().iter_mut().enumerate() {
            let name = Self::saved_name(name, axis);
            let saved = from.take::<<Self::Element as ColumnElement>::Saved>(&name)?;
            let count = saved.len();
            if !lengths.contains(&count) || *length.get_or_insert(count) != count {
                let expected = length.filter(|length| *length != count).unwrap_or(lengths[0]);
                return Err(ColumnMismatch(format!(
                    "its column `{name}` has {count} values, must have {expected}"
                )));
            }
            *column = saved.into_iter().map(ColumnElement::from_saved).collect::<Result<_, _>>()?;
        }
        Ok(quantity)
    }
}

impl<E: ColumnElement> Quantity for Vec<E> {
    type Element = E;
    type Value = E::Value;

    fn columns(&self) -> &[Vec<E>] {
        std::slice::from_ref(self)
    }

    fn columns_mut(&mut self) -> &mut [Vec<E>] {
        std::slice::from_mut(self)
    }

    fn empty() -> Self {
        Self::new()
    }

    #[inline]
    fn value(&self, row: usize) -> E::Value {
        self[row].value()
    }

    fn push(&mut self, row: usize, value: E::Value) {
        self.resize(row, E::default());
        self.push(E::from_value(value));
    }

    #[inline]
    fn set(&mut self, row: usize, value: E::Value) {
        self[row] = E::from_value(value);
    }

    fn saved_name(name: &str, _axis: usize) -> String {
        name.to_owned()
    }
}

impl<E: ColumnElement<Value = f64>, const D: usize> Quantity for [Vec<E>; D] {
    type Element = E;
    type Value = DVec3;

    fn columns(&self) -> &[Vec<E>] {
        self
    }

    fn columns_mut(&mut self) -> &mut [Vec<E>] {
        self
    }

    fn empty() -> Self {
        std::array::from_fn(|_| Vec::new())
    }

    #[inline]
    fn value(&self, row: usize) -> DVec3 {
        let mut vector = DVec3::ZERO;
        for axis in 0..D {
            vector[axis] = self[axis][row].value();
        }
        vector
    }

    fn push(&mut self, row: usize, value: DVec3) {
        for axis in 0..D {
            self[axis].resize(row, E::default());
            self[axis].push(E::from_value(value[axis]));
        }
    }

    #[inline]
    fn set(&mut self, row: usize, value: DVec3) {
        for axis in 0..D {
            self[axis][row] = E::from_value(value[axis]);
        }
    }

    fn saved_name(name: &str, axis: usize) -> String {
        format!("{name}.{axis}")
    }
}
