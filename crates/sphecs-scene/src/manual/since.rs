//! Versions since which a scene file can have a field or choice.

/// First version, which has all that [`NEWER`] leaves out.
const FIRST: &str = "0.1.0";

/// Versions with the pages, choices and fields that they added or renamed.
///
/// A name covers everything below it. `CHANGELOG.md` lists the same changes.
const NEWER: [(&str, &[&str]); 2] = [
    (
        "0.3.0",
        &[
            "Inlet.on",
            "Outlet.on",
            "Inlet.extent",
            "Inlet.closed",
            "Outlet.extent",
            "Outlet.closed",
            "Extent",
            "Probe.every",
            "Output.fields",
            "Fields",
            "FieldPlane",
            "Output.walls",
            "WallQuantities",
            "OutletCondition.Pressure",
            "OutletCondition.TotalPressure",
            "OutletCondition.Resistance",
            "OutletCondition.Windkessel",
            "OutletCondition.FlowShare",
            "Acoustics",
            "Fill.Lattice.angle",
            "Fill.Lattice.axis",
            "Fill.Packed",
            "Scene.movers",
            "Scene.emitters",
            "Emitter",
            "Mover",
            "Motion",
            "Walls.motion",
            "Shape.Mesh",
            "Shape.Outline",
            "LengthUnit",
            "Walls.fill",
            "Walls.one_sided",
            "WallFill.Layers",
        ],
    ),
    (
        "0.2.0",
        &[
            "Scene.bodies",
            "Body",
            "Scheme.EdacTvf",
            "Scheme.Wcsph.noise_damping",
            "Scheme.Wcsph.integrator",
            "Integrator",
            "NoiseDamping",
            "Viscosity.Laminar.as_published",
            "Shifting.Local",
            "Shifting.Fickian.drift_correction",
            "DriftCorrection",
            "Fill.Lattice.jitter",
            "WallModel.Dummy",
            "WallModel.Ghost",
            "Slip.WallFunction",
            "WallPart.fill",
            "WallFill",
            "FirstRing",
            "Inlet.feed",
            "Feed",
            "InletVelocity.MassFlow",
            "InletVelocity.MassFlux",
            "OutletCondition.DoNothing",
            "OutletCondition.ModifiedDoNothing",
            "OutletCondition.Mirror",
            "OutletCondition.Characteristic",
            "OutletCondition.Hybrid",
            "OutletCondition.Custom",
            "ShownVelocity",
            "MirrorVariant",
            "OutletPressure.NonReflecting",
            "Waves",
            "Reservoir.recycle",
            "Output.forces",
            "Output.checkpoint_every",
            "ForcesEvery",
            "Probe.sees",
            "ProbeSight",
        ],
    ),
];

/// Returns the version since which a scene can have `name`, such as `Shifting.Local.coefficient`.
pub(super) fn since(name: &str) -> &'static str {
    let covers =
        |newer: &&str| name.strip_prefix(*newer).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'));
    let added = NEWER.iter().find(|(_, names)| names.iter().any(covers));
    added.map_or(FIRST, |(version, _)| *version)
}

/// Returns the names of the table.
#[cfg(test)]
pub(crate) fn newer_names() -> impl Iterator<Item = &'static str> {
    NEWER.iter().flat_map(|(_, names)| names.iter().copied())
}
