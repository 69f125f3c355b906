//! Triangle meshes: readers of STL, OBJ and PLY files, repair, exact distance and inside test.
//!
//! [`read()`] turns the bytes of a file into [`Facets`]. [`Surface::new`] welds and orients the
//! facets of one or several files into a [`Surface`] and reports in a [`Report`] what it changed.
//! Knows neither the file system nor scenes: the caller opens files and states the unit.

mod facets;
mod fault;
mod read;
mod repair;
mod report;
mod surface;
#[cfg(test)]
mod tests;
mod triangulation;
mod weld;

pub use facets::Facets;
pub use fault::{Fault, Place};
pub use read::read;
pub use report::{OpenLoop, Report};
pub use surface::{Feature, Intersections, Nearest, Part, Plane, Surface};
