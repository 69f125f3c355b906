//! Names that other programs and papers use for fields and choices of a scene.

/// Names of fields: the name given, the one of a scene, and what is to be known about it.
const FIELDS: [(&str, &str, &str); 46] = [
    ("gravity", "body_force", "the force per mass, m/s²: `body_force: (0.0, -9.81)`"),
    ("g", "body_force", "the force per mass, m/s²: `body_force: (0.0, -9.81)`"),
    ("acceleration", "body_force", "the force per mass, m/s²"),
    ("rho", "density", "kg/m³"),
    ("rho0", "density", "kg/m³"),
    ("nu", "viscosity", "the kinematic viscosity, m²/s"),
    ("kinematic_viscosity", "viscosity", "m²/s"),
    ("mu", "viscosity", "the kinematic viscosity ν = μ/ρ0, m²/s"),
    ("dynamic_viscosity", "viscosity", "the kinematic viscosity ν = μ/ρ0, m²/s"),
    ("c0", "sound_speed", "m/s"),
    ("cs", "sound_speed", "m/s"),
    ("speed_of_sound", "sound_speed", "m/s"),
    ("dx", "spacing", "m"),
    ("dp", "spacing", "m"),
    ("resolution", "spacing", "m"),
    ("particle_spacing", "spacing", "m"),
    ("h", "smoothing_ratio", "the ratio h/Δ"),
    ("smoothing_length", "smoothing_ratio", "the ratio h/Δ"),
    ("dim", "dimensions", "2 or 3"),
    ("geometry", "domain", "the shape that the fluid fills"),
    ("shape", "domain", "the shape that the fluid fills"),
    ("parameters", "constants", "a map: `constants: {\"v0\": 0.1}`"),
    ("variables", "constants", "a map: `constants: {\"v0\": 0.1}`"),
    ("boundaries", "walls", "openings are `inlets` and `outlets`"),
    ("solver", "scheme", "such as `Wcsph()`"),
    ("dt", "cfl", "the Courant factor: the time step follows from it"),
    ("time_step", "cfl", "the Courant factor: the time step follows from it"),
    ("end_time", "end", "s"),
    ("duration", "end", "s"),
    ("stop", "end", "s"),
    ("position", "at", "a point of the plane, m"),
    ("origin", "at", "a point of the plane, m"),
    ("point", "at", "a point of the plane, m"),
    ("normal", "towards", "the direction of the flow"),
    ("direction", "towards", "the direction of the flow"),
    ("type", "condition", "such as `WaveEquation()`"),
    ("interval", "every", "s"),
    ("grid", "fields", "fields on a regular grid: `fields: (spacing: 0.01)`"),
    ("average", "mean", "an interval of time, s: `mean: (1.0, 2.0)`"),
    ("centre", "center", "m"),
    ("start", "from", "m"),
    ("lower", "min", "the lower corner, m"),
    ("upper", "max", "the upper corner, m"),
    ("size", "max", "the upper corner, not the size, m"),
    ("vertices", "points", "the corners in order, m"),
    ("speed", "velocity", "m/s"),
];

/// Names of choices: the name given and the one of a scene.
const CHOICES: [(&str, &str); 26] = [
    ("Rectangle", "Box"),
    ("Square", "Box"),
    ("Cuboid", "Box"),
    ("Cube", "Box"),
    ("Ball", "Sphere"),
    ("Disc", "Circle"),
    ("Disk", "Circle"),
    ("Pipe", "Cylinder"),
    ("Tube", "Cylinder"),
    ("Subtract", "Difference"),
    ("Subtraction", "Difference"),
    ("Minus", "Difference"),
    ("Sum", "Union"),
    ("Join", "Union"),
    ("Common", "Intersection"),
    ("Extrude", "Extruded"),
    ("Rotate", "Rotated"),
    ("Translate", "Translated"),
    ("Scale", "Scaled"),
    ("Uniform", "Normal"),
    ("Constant", "Normal"),
    ("FlowRate", "MassFlow"),
    ("Smagorinsky", "Sps"),
    ("Les", "Sps"),
    ("LES", "Sps"),
    ("Wendland", "WendlandC2"),
];

/// Returns the field that a name stands for elsewhere, with advice, if it is a known one.
pub(crate) fn field(name: &str, known: &[&'static str]) -> Option<(&'static str, String)> {
    let (_, meant, what) = FIELDS.iter().find(|(given, meant, _)| *given == name && known.contains(meant))?;
    Some((meant, format!("it is called `{meant}` here, {what}")))
}

/// Returns the choice that a name stands for elsewhere, if it is a known one.
pub(crate) fn choice(name: &str, known: &[&'static str]) -> Option<&'static str> {
    let found = CHOICES.iter().find(|(given, meant)| *given == name && known.contains(meant));
    found.map(|(_, meant)| *meant)
}
