//! Triangle meshes: readers of STL, OBJ and PLY files, repair, exact distance and inside test.
//!
//! [`read()`] turns the bytes of a file into [`Facets`]. [`Surface::new`] welds and orients the
//! facets of one or several files into a [`Surface`] and reports in a [`Report`] what it changed.
//! Knows neither the file system nor scenes: the caller opens files and states the unit.
//!
//! ```
//! use sphecs_mesh::{DVec3, Part, Surface, read};
//!
//! let text = "o tetrahedron\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n\
//!             f 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";
//! let facets = read(text.as_bytes(), "tetrahedron.obj")?;
//! let parts = vec![Part { name: "tetrahedron".to_owned(), facets }];
//! // Coordinates in mm.
//! let (surface, report) = Surface::new(parts, 1e-3)?;
//! assert!(report.is_closed());
//! assert!((surface.volume() - 1e-9 / 6.0).abs() < 1e-20);
//! let point = DVec3::new(0.1, 0.2, 0.3) * 1e-3;
//! assert!((surface.signed_distance(point) + 0.1e-3).abs() < 1e-15);
//! # Ok::<(), sphecs_mesh::Fault>(())
//! ```

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
/// Vector of three f64, of the crate glam.
pub use glam::DVec3;
pub use read::read;
pub use report::{OpenLoop, Report};
pub use surface::{Feature, Intersections, Nearest, Part, Plane, Surface};
