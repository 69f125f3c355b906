//! Walls of the file → wall parts and their regions.

use super::checker::Checker;
use super::shapes;
use crate::physics::wall::{Slip, WallModel};
use crate::scene::expression::Expression;
use crate::scene::faults::Fault;
use crate::scene::geometry::Shape;
use crate::scene::model::{WallPart, Walls};
use crate::scene::notation::typed::Spanned;
use crate::scene::schema::WallsFile;

/// The wall parts, and the regions of those after the first.
pub fn walls(file: Option<&Spanned<WallsFile>>, check: &mut Checker<'_>) -> (Walls, Vec<Shape>) {
    let rest = |slip: Slip, velocity: [Expression; 3]| WallPart { name: "walls".to_owned(), slip, velocity };
    let at_rest = || std::array::from_fn(|_| Expression::Constant(0.0));
    let Some(file) = file.map(|file| &file.value) else {
        let parts = vec![rest(Slip::NoSlip, at_rest())];
        let model = WallModel::default();
        return (Walls { model, parts }, Vec::new());
    };
    if let WallModel::Image { velocity_cap: Some(cap), .. } = file.model
        && (cap.is_nan() || cap < 1.0)
    {
        check.report(Fault::placeless(
            "`velocity_cap` of the walls is less than 1: the image velocity would point the wrong way",
        ));
    }
    let mut parts = vec![rest(file.slip, check.components_or_zero(file.velocity.as_ref()))];
    let mut regions = Vec::new();
    for part in &file.parts {
        let name = &part.name;
        if parts.iter().any(|other| other.name == name.value) {
            check.report(Fault::new(
                format!("two wall parts are called `{}`", name.value),
                name.span,
                "must differ (the rest is called `walls`)",
            ));
        }
        let velocity = check.components_or_zero(part.velocity.as_ref());
        if let Some(region) = shapes::shape(&part.region.value, check) {
            regions.push(region);
            parts.push(WallPart { name: name.value.clone(), slip: part.slip.unwrap_or(file.slip), velocity });
        }
    }
    (Walls { model: file.model, parts }, regions)
}
