//! Checks that the plane of an inlet or outlet is on the surface of the domain and free outside.

use glam::DVec3;

use super::checker::Checker;
use super::mesh_groups;
use super::section::{across, exit, measure};
use crate::faults::Fault;
use crate::geometry::Shape;
use crate::model::{Patch, UnopenedPart};
use crate::notation::tree::Span;
use crate::schema::{Number, Text, Vector};
use sphecs_core::boundary::patch::Extent;
use sphecs_core::format::{point as point_text, significant};

/// Largest number of layers of a zone, more than any flow needs; it bounds the number of particles.
pub(super) const MOST_LAYERS: f64 = 1e4;

/// Domain and discretisation that the patches are checked against.
#[derive(Clone, Copy, Debug)]
pub struct Site<'a> {
    /// The domain.
    pub domain: &'a Shape,
    /// Periodic directions.
    pub periodic: &'a [Option<(f64, f64)>; 3],
    /// Particle spacing Δ, m.
    pub spacing: f64,
    /// Radius of the kernel's support, m.
    pub support: f64,
    /// 2 or 3.
    pub dimensions: usize,
    /// True if domain, spacing and kernel have no faults; otherwise nothing is measured.
    pub is_valid: bool,
}

/// Fields of a patch in the file.
pub struct PatchFile<'a> {
    /// Name, if given.
    pub name: Option<&'a Text>,
    /// Name if none is given.
    pub default_name: String,
    /// A point of the plane.
    pub at: Option<&'a Vector>,
    /// Group of a mesh that is the opening.
    pub on: Option<&'a Text>,
    /// Direction of the flow.
    pub towards: Option<&'a Vector>,
    /// Place of the plane in the file.
    pub place: Span,
    /// Length of the zone.
    pub depth: Option<&'a Number>,
    /// Layers of the zone if no length is given.
    pub layers: f64,
    /// Parts of the domain's end that belong to it.
    pub extent: Extent,
    /// True if the other parts are deliberately walls.
    pub closed: bool,
    /// True for an inlet.
    pub is_inlet: bool,
}

/// Returns a checked patch with its measured section; None if it has a fault.
pub fn patch(file: &PatchFile<'_>, site: &Site<'_>, check: &mut Checker<'_>) -> Option<Patch> {
    let before = check.fault_count();
    let plane = plane(file, site, check);
    let depth = depth(file, site, check);
    let (at, towards) = plane?;
    if check.fault_count() > before || !site.is_valid {
        return None;
    }
    let inwards = if file.is_inlet { towards } else { -towards };
    not_periodic(file, towards, site, check)?;
    on_surface(file, at, inwards, site, check)?;
    let across = across(site.domain, towards, site.dimensions);
    let mut patch = Patch {
        name: file.name.map_or_else(|| file.default_name.clone(), |name| name.value.clone()),
        at,
        towards,
        across,
        half_extent: [0.0; 2],
        depth,
        area: 0.0,
        perimeter: 0.0,
        raster: None,
    };
    for part in measure(&mut patch, inwards, file.extent, site) {
        if !file.closed {
            let opening = patch.name.clone();
            check.unopened.push(UnopenedPart { opening, at: part.at, area: part.area });
        }
    }
    outside_is_free(&patch, file, inwards, site, check)?;
    Some(patch)
}

impl PatchFile<'_> {
    /// Returns the place of the direction in the file.
    fn direction_place(&self) -> Span {
        self.towards.map_or(self.place, |towards| towards.span)
    }
}

/// Returns a point of the plane, m, and the direction of the flow; None if they have a fault.
fn plane(file: &PatchFile<'_>, site: &Site<'_>, check: &mut Checker<'_>) -> Option<(DVec3, DVec3)> {
    let kind = if file.is_inlet { "inlet" } else { "outlet" };
    let Some(on) = file.on else {
        let at = file.at.map(|at| check.vector(at, "m"));
        let towards = file.towards.map(|towards| check.direction(towards));
        for (field, is_missing) in [("at", at.is_none()), ("towards", towards.is_none())] {
            if is_missing && !check.has_reading_faults {
                let title = format!("field `{field}` is missing");
                let label = format!("the {kind} `{}` needs it", file.default_name);
                let help =
                    format!("{label}, or a flat group of facets of a mesh in the domain: `on: \"in\"`");
                let fault = match file.at.or(file.towards).map(|given| given.span) {
                    Some(place) => Fault::new(title, place, label),
                    None if !file.place.is_placeholder() => Fault::new(title, file.place, label),
                    None => Fault::placeless(title),
                };
                check.report(fault.help(help));
            }
        }
        return at.zip(towards);
    };
    if let Some(given) = file.at.or(file.towards) {
        let label = "must be left out: `on` names the plane";
        check.report(Fault::new(format!("the plane of the {kind} is given twice"), given.span, label));
        return None;
    }
    let plane = mesh_groups::plane_of_group(on, site, check)?;
    Some((plane.at, if file.is_inlet { -plane.outwards } else { plane.outwards }))
}

/// Returns the depth of the zone in whole layers, at least the support, m.
fn depth(file: &PatchFile<'_>, site: &Site<'_>, check: &mut Checker<'_>) -> f64 {
    let layers = |depth: f64| (depth / site.spacing - 1e-6).ceil() * site.spacing;
    let Some(number) = file.depth else {
        return layers((file.layers * site.spacing).max(site.support));
    };
    let depth = check.positive(number, "m");
    if depth > MOST_LAYERS * site.spacing && site.is_valid {
        check.report(Fault::new(
            "a zone is too long",
            number.span,
            format!("is `{depth}` m, must be at most {MOST_LAYERS} spacings"),
        ));
        return 1.0;
    }
    if depth < site.support * (1.0 - 1e-9) && site.is_valid {
        let kind = if file.is_inlet { "inlet" } else { "outlet" };
        let label =
            format!("is `{depth}` m, must be at least `{}` m (the support)", significant(site.support));
        check.report(
            Fault::new(
                format!("the zone of the {kind} is shorter than the kernel's support"),
                number.span,
                label,
            )
            .help("raise `depth` or lower `spacing`"),
        );
    }
    layers(depth)
}

/// Checks that the opening is not at an end of the domain that is periodic.
fn not_periodic(
    file: &PatchFile<'_>,
    towards: DVec3,
    site: &Site<'_>,
    check: &mut Checker<'_>,
) -> Option<()> {
    let Some(axis) = (0..3).find(|&axis| site.periodic[axis].is_some() && towards[axis].abs() > 1e-6) else {
        return Some(());
    };
    let (kind, name) = (if file.is_inlet { "inlet" } else { "outlet" }, ["x", "y", "z"][axis]);
    check.report(
        Fault::new(
            format!("the {kind} is at an end of the domain that is periodic"),
            file.direction_place(),
            format!("points along {name}, which is in `periodic`: there fluid passes to the other end of the domain"),
        )
        .help(format!("take \"{name}\" out of `periodic`, or leave the inlets and outlets along {name} out")),
    );
    None
}

/// Checks that the domain ends at the plane.
fn on_surface(
    file: &PatchFile<'_>,
    at: DVec3,
    inwards: DVec3,
    site: &Site<'_>,
    check: &mut Checker<'_>,
) -> Option<()> {
    let kind = if file.is_inlet { "inlet" } else { "outlet" };
    let offset = 1e-3 * site.spacing;
    let inner = site.domain.signed_distance(at + offset * inwards);
    let outer = site.domain.signed_distance(at - offset * inwards);
    if inner < 0.0 && outer > 0.0 {
        return Some(());
    }
    let fault = if inner > 0.0 && outer < 0.0 {
        let (is, must) = if file.is_inlet { ("out of", "into") } else { ("into", "out of") };
        Fault::new(
            format!("the {kind} faces the wrong way"),
            file.direction_place(),
            format!("points {is} the domain, must point {must} it: the direction of the flow"),
        )
        .help("turn the sign of `towards`")
    } else if inner < 0.0 {
        let exit = exit(site.domain, at, -inwards, site.spacing);
        let near = exit.map_or("along the flow there is none".to_owned(), |distance| {
            format!("along the flow it is at {}", printed(at - distance * inwards, site))
        });
        Fault::new(
            format!("the {kind} is inside the domain"),
            file.place,
            format!("must be on the domain's surface; {near}"),
        )
    } else {
        let near = site.domain.nearest_surface(at, 1e-3 * site.spacing, site.dimensions);
        Fault::new(
            format!("the {kind} is not on the domain's surface"),
            file.place,
            format!("the domain is not behind this point, it begins at {}", printed(near, site)),
        )
        .help("`at` must be a point of the opening, `towards` must be perpendicular to it")
    };
    check.report(fault);
    None
}

fn printed(point: DVec3, site: &Site<'_>) -> String {
    format!("{} m", point_text(&point.to_array()[..site.dimensions], site.spacing))
}

/// Checks that the domain ends over the whole opening, not only at the given point.
fn outside_is_free(
    patch: &Patch,
    file: &PatchFile<'_>,
    inwards: DVec3,
    site: &Site<'_>,
    check: &mut Checker<'_>,
) -> Option<()> {
    let offset = 1e-3 * site.spacing * inwards;
    let count = 21;
    for index in 0..count * count {
        let place = |index: i32| f64::from(index) / f64::from(count - 1) * 1.98 - 0.99;
        let point = patch.at
            + place(index % count) * patch.half_extent[0] * patch.across[0]
            + place(index / count) * patch.half_extent[1] * patch.across[1];
        let open = patch.covers(point, 0.0) && site.domain.contains(point + offset, 0.0);
        if open && site.domain.contains(point - 2.0 * offset, 0.0) {
            check.report(
                Fault::new(
                    "the opening is not a plane end of the domain",
                    file.place,
                    format!("at {} the domain extends beyond it", printed(point, site)),
                )
                .help("an inlet or outlet must be where a straight piece of the domain ends"),
            );
            return None;
        }
    }
    Some(())
}
