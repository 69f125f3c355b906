//! Columns of a pack by name and type: scalars, vectors and symmetric tensors.
//!
//! A pass adds its columns one after another and keeps the returned indices, so that their order is
//! written only once.

use super::{Entry, Source};
use crate::math::lanes::Lanes;
use crate::math::real::Real;
use crate::math::symmetric::components;

/// Index of a scalar among the columns of a pack.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Scalar(pub usize);

/// Index of the first component of a vector among the columns of a pack.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Vector(pub usize);

/// Index of the first component of a symmetric tensor among the columns of a pack.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Symmetric(pub usize);

/// Columns of a pass in the order in which they are packed; the coordinates precede them.
#[derive(Clone, Copy, Debug)]
pub struct ColumnList<'a, R, const D: usize, const MOST: usize> {
    columns: [&'a [R]; MOST],
    count: usize,
}

impl<'a, R, const D: usize, const MOST: usize> ColumnList<'a, R, D, MOST> {
    /// Returns a list without columns.
    pub fn empty() -> Self {
        Self { columns: [&[]; MOST], count: 0 }
    }

    /// Adds a scalar.
    pub fn add_scalar(&mut self, column: &'a [R]) -> Scalar {
        Scalar(self.add(column))
    }

    /// Adds a vector.
    pub fn add_vector(&mut self, vector: &'a [Vec<R>; D]) -> Vector {
        let first = D + self.count;
        for column in vector {
            self.add(column);
        }
        Vector(first)
    }

    /// Adds the components of a symmetric tensor.
    pub fn add_symmetric(&mut self, tensor: &'a [Vec<R>; 6]) -> Symmetric {
        let first = D + self.count;
        for column in tensor.iter().take(components(D)) {
            self.add(column);
        }
        Symmetric(first)
    }

    fn add(&mut self, column: &'a [R]) -> usize {
        self.columns[self.count] = column;
        self.count += 1;
        D + self.count - 1
    }

    /// Returns the columns that were added.
    pub fn as_slice(&self) -> &[&'a [R]] {
        &self.columns[..self.count]
    }

    /// Returns the number of columns of the pack, coordinates included.
    pub fn width(&self) -> usize {
        D + self.count
    }
}

impl<L: Lanes> Entry<'_, L> {
    /// Returns a scalar of the neighbours.
    #[inline(always)]
    pub fn scalar(&self, scalar: Scalar) -> L {
        self.column(scalar.0)
    }

    /// Returns a vector of the neighbours.
    #[inline(always)]
    pub fn vector_at<const D: usize>(&self, vector: Vector) -> [L; D] {
        self.vector(vector.0)
    }

    /// Returns a symmetric tensor of the neighbours; components beyond those of `D` are 0.
    #[inline(always)]
    pub fn symmetric<const D: usize>(&self, tensor: Symmetric) -> [L; 6] {
        let mut components_of = [L::constant(0.0); 6];
        for (c, component) in components_of.iter_mut().enumerate().take(components(D)) {
            *component = self.column(tensor.0 + c);
        }
        components_of
    }
}

impl<R: Real, const D: usize> Source<'_, R, D> {
    /// Returns a scalar of a row.
    #[inline(always)]
    pub fn scalar(&self, scalar: Scalar, row: usize) -> R {
        self.columns[scalar.0 - D][row]
    }

    /// Returns a component of a vector of a row.
    #[inline(always)]
    pub fn component(&self, vector: Vector, axis: usize, row: usize) -> R {
        self.columns[vector.0 + axis - D][row]
    }

    /// Returns a vector of a row in every lane.
    #[inline(always)]
    pub fn splat_vector<L: Lanes<Real = R>>(&self, vector: Vector, row: usize) -> [L; D] {
        let mut components = [L::constant(0.0); D];
        for (axis, component) in components.iter_mut().enumerate() {
            *component = L::splat(self.component(vector, axis, row));
        }
        components
    }

    /// Returns a symmetric tensor of a row in every lane, 0 if there is no such column; components
    /// beyond those of `D` are 0.
    #[inline(always)]
    pub fn splat_optional<L: Lanes<Real = R>>(&self, tensor: Option<Symmetric>, row: usize) -> [L; 6] {
        let mut components_of = [L::constant(0.0); 6];
        if let Some(tensor) = tensor {
            for (c, component) in components_of.iter_mut().enumerate().take(components(D)) {
                *component = L::splat(self.columns[tensor.0 + c - D][row]);
            }
        }
        components_of
    }
}
