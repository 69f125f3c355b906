//! Checks of the walls of a scene file.

use super::checker::Checker;
use super::names::{Named, names};
use super::shapes;
use crate::expression::Expression;
use crate::faults::Fault;
use crate::geometry::Shape;
use crate::model::{Fill, Rings, Scene, WallPart, Walls};
use crate::movers::Wall;
use crate::notation::typed::Spanned;
use crate::rings::FirstRing;
use crate::schema::{FillFile, Number, SceneFile, Vector, WallFillFile, WallsFile};
use glam::DVec3;
use sphecs_core::physics::wall::{Slip, WallModel};

/// Places of the particles of the wall parts.
#[derive(Debug, Default)]
pub struct WallLayout {
    /// Regions of the parts after the first.
    pub regions: Vec<Shape>,
    /// Cylinders whose particles lie on rings.
    pub rings: Vec<Rings>,
    /// Indices of the parts whose particles lie in layers.
    pub layered: Vec<u16>,
}

/// Returns the wall parts and the places of their particles.
pub fn walls(
    scene: &SceneFile,
    (domain, spacing): (&Shape, f64),
    check: &mut Checker<'_>,
) -> (Walls, WallLayout) {
    let rest = |slip: Slip, velocity: [Expression; 3]| WallPart {
        name: "walls".to_owned(),
        slip,
        velocity,
        mover: None,
    };
    let at_rest = || std::array::from_fn(|_| Expression::Constant(0.0));
    let Some(file) = scene.walls.as_ref().map(|file| &file.value) else {
        let parts = vec![rest(Slip::NoSlip, at_rest())];
        let model = WallModel::default();
        return (Walls { model, one_sided: false, parts }, WallLayout::default());
    };
    if let Some(fault) = file.model.fault() {
        check.report(Fault::placeless(fault));
    }
    let one_sided = is_one_sided(file, check);
    let mut parts = vec![rest(file.slip, check.components_or_zero(file.velocity.as_ref()))];
    let WallLayout { mut regions, mut rings, mut layered } = WallLayout::default();
    let all = file.fill.as_ref();
    // The walls of a packed scene lie in layers without saying so.
    let is_packed = scene.fill.as_ref().is_some_and(|fill| matches!(fill.value, FillFile::Packed { .. }));
    if is_packed && all.is_none() {
        layered.push(0);
    }
    if let Some(fill) = all {
        match fill.value {
            WallFillFile::Layers => layered.push(0),
            WallFillFile::Concentric { .. } => check.report(
                Fault::new(
                    "`Concentric` of all walls",
                    fill.head,
                    "must be the `fill` of a part of the walls",
                )
                .help("`parts: [(name: \"cylinder\", region: …, fill: Concentric(…))]`"),
            ),
        }
    }
    // What belongs to no part is called `walls`.
    let rest_of_all = std::iter::once(Named::Default(parts[0].name.clone()));
    let given = file.parts.iter().map(|part| Named::Given(&part.name));
    // The movers share the names of the results with them.
    let movers = scene.movers.iter().map(|mover| Named::Given(&mover.name));
    names(&rest_of_all.chain(given).chain(movers).collect::<Vec<_>>(), "wall parts", check);
    for part in &file.parts {
        let name = &part.name;
        let is_layered = match part.fill.as_ref().map(|fill| (fill, &fill.value)) {
            None => layered.first() == Some(&0),
            Some((_, WallFillFile::Layers)) => true,
            Some((fill, WallFillFile::Concentric { center, radius, first })) => {
                let circle = (center, radius, *first);
                rings.extend(concentric(circle, fill, (domain, spacing), check));
                false
            }
        };
        let velocity = check.components_or_zero(part.velocity.as_ref());
        if let Some(region) = shapes::shape(&part.region.value, check) {
            regions.push(region);
            if is_layered {
                layered.push(parts.len() as u16);
            }
            let slip = part.slip.unwrap_or(file.slip);
            parts.push(WallPart { name: name.value.clone(), slip, velocity, mover: None });
        }
    }
    (Walls { model: file.model, one_sided, parts }, WallLayout { regions, rings, layered })
}

/// Returns whether thin walls are one-sided, which only walls of images can be.
fn is_one_sided(file: &WallsFile, check: &mut Checker<'_>) -> bool {
    let Some(one_sided) = file.one_sided.as_ref().filter(|one_sided| one_sided.value) else { return false };
    if !file.model.can_be_one_sided() {
        check.report(
            Fault::new(
                "`one_sided` walls need images",
                one_sided.head,
                "must be left out beside this `model`",
            )
            .help("or `model: Image()`: other models take velocity and pressure from both sides"),
        );
    }
    true
}

/// Reports walls with an arrangement of their own beside `WallFitted`, whose rows continue into the
/// walls.
pub fn fitted_twice(scene: &Scene, file: &SceneFile, faults: &mut Vec<Fault>) {
    let Some(walls) = file.walls.as_ref().filter(|_| matches!(scene.layout.fill, Fill::WallFitted { .. }))
    else {
        return;
    };
    let of_parts = walls.value.parts.iter().filter_map(|part| part.fill.as_ref());
    for fill in walls.value.fill.iter().chain(of_parts) {
        let label = "must be left out: the rows of `WallFitted` continue into the walls";
        faults.push(
            Fault::new("walls cannot have a `fill` beside `WallFitted`", fill.head, label)
                .help("or leave out `fill: WallFitted(…)` of the scene"),
        );
    }
}

/// Largest distance of the circle of `Concentric` from the surface of the domain, over Δ.
const OFF_THE_SURFACE: f64 = 1e-3;

/// Returns the rings of a cylinder, which must be the surface of a shape; None if it has a fault.
pub fn concentric(
    (center, radius, first): (&Vector, &Number, FirstRing),
    file: &Spanned<WallFillFile>,
    (domain, spacing): (&Shape, f64),
    check: &mut Checker<'_>,
) -> Option<Rings> {
    let before = check.fault_count();
    let (centre, radius) = (check.vector(center, "m"), check.positive(radius, "m"));
    let rings = Rings { centre, radius, first, wall: Wall::Casing.number() };
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
