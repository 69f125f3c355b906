//! Quantities of the gridded fields and of their means, with names and units.

use sphecs_core::pass::grid_rows::NodeFields;

/// A quantity at the nodes of a grid.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Quantity {
    /// Name of its variable.
    pub(crate) name: String,
    /// Unit in UDUNITS notation.
    pub(crate) unit: &'static str,
    /// Long name.
    pub(crate) long_name: String,
}

impl Quantity {
    fn new(name: impl Into<String>, unit: &'static str, long_name: impl Into<String>) -> Self {
        Self { name: name.into(), unit, long_name: long_name.into() }
    }
}

/// Names of the components of velocity.
const VELOCITIES: [&str; 3] = ["u", "v", "w"];

/// Names of the axes.
const AXES: [&str; 3] = ["x", "y", "z"];

fn velocities(dimensions: usize) -> impl Iterator<Item = Quantity> {
    (0..dimensions)
        .map(|axis| Quantity::new(VELOCITIES[axis], "m s-1", format!("velocity along {}", AXES[axis])))
}

fn vorticities(dimensions: usize) -> Vec<Quantity> {
    if dimensions == 2 {
        return vec![Quantity::new("vorticity", "s-1", "vorticity")];
    }
    let along =
        |axis: &str| Quantity::new(format!("vorticity_{axis}"), "s-1", format!("vorticity along {axis}"));
    AXES.map(along).to_vec()
}

fn vorticities_of(node: &NodeFields, dimensions: usize) -> &[f64] {
    if dimensions == 2 { &node.vorticity[2..] } else { &node.vorticity }
}

/// Returns the quantities that are written at each time; the last one is the fluid fraction.
pub(crate) fn quantities(dimensions: usize, tagged: bool) -> Vec<Quantity> {
    let mut all: Vec<Quantity> = velocities(dimensions).collect();
    all.push(Quantity::new("pressure", "Pa", "pressure above that of the reference density"));
    all.push(Quantity::new("density", "kg m-3", "density"));
    all.extend(vorticities(dimensions));
    if tagged {
        all.push(Quantity::new("tag", "1", "passive scalar carried along"));
    }
    all.push(Quantity::new("fluid_fraction", "1", "fraction of the space between the walls that is filled"));
    all
}

/// Visits the values of [`quantities`] at a node, without the fluid fraction.
pub(super) fn for_each_value(
    node: &NodeFields,
    dimensions: usize,
    tagged: bool,
    visit: impl FnMut((usize, f64)),
) {
    let tag = tagged.then_some(node.tag);
    let vector = node.velocity[..dimensions].iter();
    let scalars = [node.pressure, node.density];
    let values = vector.chain(&scalars).chain(vorticities_of(node, dimensions)).copied().chain(tag);
    values.enumerate().for_each(visit);
}

/// Largest number of quantities with a mean.
pub(super) const MOST_MEANS: usize = 7;

/// Returns the number of quantities with a mean: velocity, pressure, vorticity.
pub(super) fn mean_count(dimensions: usize) -> usize {
    if dimensions == 2 { 4 } else { MOST_MEANS }
}

/// Returns the quantities of a node with a mean: velocity, pressure, vorticity.
pub(super) fn mean_values(node: &NodeFields, dimensions: usize) -> [f64; MOST_MEANS] {
    let mut values = [0.0; MOST_MEANS];
    values[..dimensions].copy_from_slice(&node.velocity[..dimensions]);
    values[dimensions] = node.pressure;
    let vorticity = vorticities_of(node, dimensions);
    values[dimensions + 1..dimensions + 1 + vorticity.len()].copy_from_slice(vorticity);
    values
}

/// Returns pairs of quantities of [`mean_values`] with a covariance: those of velocity components,
/// and the pressure with itself.
pub(super) fn pairs(dimensions: usize) -> Vec<(usize, usize)> {
    let stresses = (0..dimensions).flat_map(|i| (i..dimensions).map(move |j| (i, j)));
    stresses.chain([(dimensions, dimensions)]).collect()
}

/// Returns the means in the order of their columns: those of [`mean_values`], covariances of
/// [`pairs`], time with fluid, fluid fraction.
pub(crate) fn means(dimensions: usize) -> Vec<Quantity> {
    let pressure = Quantity::new("pressure", "Pa", "pressure");
    let of = velocities(dimensions).chain([pressure]).chain(vorticities(dimensions));
    let mean = |quantity: Quantity| {
        let name = format!("{}_mean", quantity.name);
        Quantity::new(name, quantity.unit, format!("time mean of {}", quantity.long_name))
    };
    let mut all: Vec<Quantity> = of.map(mean).collect();
    for (i, j) in pairs(dimensions) {
        all.push(match (VELOCITIES.get(i), VELOCITIES.get(j)) {
            (Some(a), Some(b)) if i < dimensions => Quantity::new(
                format!("{a}{b}_covariance"),
                "m2 s-2",
                format!("Reynolds stress over density, mean of {a}'{b}'"),
            ),
            _ => Quantity::new("pressure_variance", "Pa2", "variance in time of pressure"),
        });
    }
    all.push(Quantity::new("fluid_time", "s", "part of the interval of the means with fluid"));
    all.push(Quantity::new("fluid_fraction_mean", "1", "time mean of the fluid fraction"));
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_follow_the_order_of_the_names() {
        let node = NodeFields {
            velocity: [1.0, 2.0, 3.0],
            vorticity: [4.0, 5.0, 6.0],
            pressure: 7.0,
            density: 8.0,
            tag: 9.0,
            fraction: 1.0,
        };
        for (dimensions, tagged, expected) in [
            (2, false, "u1 v2 pressure7 density8 vorticity6"),
            (3, true, "u1 v2 w3 pressure7 density8 vorticity_x4 vorticity_y5 vorticity_z6 tag9"),
        ] {
            let names = quantities(dimensions, tagged);
            let mut found = Vec::new();
            for_each_value(&node, dimensions, tagged, |(index, value)| {
                found.push(format!("{}{value}", names[index].name));
            });
            assert_eq!(found.join(" "), expected);
            assert_eq!(names.len(), found.len() + 1);
        }
        assert_eq!(mean_values(&node, 3), [1.0, 2.0, 3.0, 7.0, 4.0, 5.0, 6.0]);
        let names: Vec<String> = means(2).into_iter().map(|quantity| quantity.name).collect();
        assert_eq!(
            names.join(" "),
            "u_mean v_mean pressure_mean vorticity_mean uu_covariance uv_covariance vv_covariance \
             pressure_variance fluid_time fluid_fraction_mean"
        );
    }
}
