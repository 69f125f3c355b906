//! Checks of the walls of a scene file.

use super::checker::Checker;
use super::names::{Named, names};
use super::shapes;
use crate::expression::Expression;
use crate::faults::Fault;
use crate::geometry::Shape;
use crate::model::{Rings, WallPart, Walls};
use crate::notation::typed::Spanned;
use crate::schema::{WallFillFile, WallsFile};
use glam::DVec3;
use sphecs_core::physics::wall::{Slip, WallModel};

/// Returns the wall parts, the regions of the parts after the first, and the rings of their
/// particles.
pub fn walls(
    file: Option<&Spanned<WallsFile>>,
    (domain, spacing): (&Shape, f64),
    check: &mut Checker<'_>,
) -> (Walls, Vec<Shape>, Vec<Rings>) {
    let rest = |slip: Slip, velocity: [Expression; 3]| WallPart { name: "walls".to_owned(), slip, velocity };
    let at_rest = || std::array::from_fn(|_| Expression::Constant(0.0));
    let Some(file) = file.map(|file| &file.value) else {
        let parts = vec![rest(Slip::NoSlip, at_rest())];
        let model = WallModel::default();
        return (Walls { model, parts }, Vec::new(), Vec::new());
    };
    if let Some(fault) = file.model.fault() {
        check.report(Fault::placeless(fault));
    }
    let mut parts = vec![rest(file.slip, check.components_or_zero(file.velocity.as_ref()))];
    let (mut regions, mut rings) = (Vec::new(), Vec::new());
    // What belongs to no part is called `walls`.
    let rest_of_all = std::iter::once(Named::Default(parts[0].name.clone()));
    let given = file.parts.iter().map(|part| Named::Given(&part.name));
    names(&rest_of_all.chain(given).collect::<Vec<_>>(), "wall parts", check);
    for part in &file.parts {
        let name = &part.name;
        rings.extend(part.fill.as_ref().and_then(|fill| concentric(fill, (domain, spacing), check)));
        let velocity = check.components_or_zero(part.velocity.as_ref());
        if let Some(region) = shapes::shape(&part.region.value, check) {
            regions.push(region);
            parts.push(WallPart { name: name.value.clone(), slip: part.slip.unwrap_or(file.slip), velocity });
        }
    }
    (Walls { model: file.model, parts }, regions, rings)
}

/// Largest distance of the circle of `Concentric` from the surface of the domain, over Δ.
const OFF_THE_SURFACE: f64 = 1e-3;

/// Returns the rings of a cylinder, which must be the surface of the domain; None if it has a
/// fault.
fn concentric(
    file: &Spanned<WallFillFile>,
    (domain, spacing): (&Shape, f64),
    check: &mut Checker<'_>,
) -> Option<Rings> {
    let before = check.fault_count();
    let WallFillFile::Concentric { center, radius, first } = &file.value;
    let rings =
        Rings { centre: check.vector(center, "m"), radius: check.positive(radius, "m"), first: *first };
    if check.dimensions != 2 {
        let label = "must be left out in 3D";
        check.report(Fault::new("`Concentric` is for cylinders in 2D", file.head, label));
    }
    if check.fault_count() > before {
        return None;
    }
    let off = (0..16).map(|index| {
        let angle = std::f64::consts::TAU * (f64::from(index) + 0.3) / 16.0;
        let point = rings.centre + rings.radius * DVec3::new(angle.cos(), angle.sin(), 0.0);
        domain.signed_distance(point).abs()
    });
    let off = off.fold(0.0, f64::max);
    if off > OFF_THE_SURFACE * spacing {
        let label = format!(
            "is up to `{off:.3e}` m off the surface, must be the circle that is cut out of the domain"
        );
        check.report(
            Fault::new("the circle of `Concentric` is not the surface of the domain", file.head, label).help(
                "give `center` and `radius` of the `Circle` that the `Difference` of `domain` takes out",
            ),
        );
        // The number of particles of a circle that is not a surface of the domain would have no
        // bound.
        return None;
    }
    Some(rings)
}
