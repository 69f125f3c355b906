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
pub(super) const MOST_MEANS: usize = 9;

/// Returns the number of quantities with a mean: velocity, pressure, vorticity, density and the
/// passive scalar if there is one.
pub(super) fn mean_count(dimensions: usize, tagged: bool) -> usize {
    let vorticities = if dimensions == 2 { 1 } else { 3 };
    dimensions + vorticities + 2 + usize::from(tagged)
}

/// Returns the quantities of a node with a mean, in the order of [`means`].
pub(super) fn mean_values(node: &NodeFields, dimensions: usize, tagged: bool) -> [f64; MOST_MEANS] {
    let mut values = [0.0; MOST_MEANS];
    let tag = tagged.then_some(node.tag);
    let all = node.velocity[..dimensions]
        .iter()
        .chain([&node.pressure])
        .chain(vorticities_of(node, dimensions))
        .chain([&node.density])
        .copied()
        .chain(tag);
    values.iter_mut().zip(all).for_each(|(value, of_node)| *value = of_node);
    values
}

/// Returns pairs of quantities of [`mean_values`] with a covariance: those of velocity components,
/// the pressure with itself, and the passive scalar with itself.
pub(super) fn pairs(dimensions: usize, tagged: bool) -> Vec<(usize, usize)> {
    let stresses = (0..dimensions).flat_map(|i| (i..dimensions).map(move |j| (i, j)));
    let tag = mean_count(dimensions, tagged) - 1;
    stresses.chain([(dimensions, dimensions)]).chain(tagged.then_some((tag, tag))).collect()
}

/// Returns the means in the order of their columns: those of [`mean_values`], covariances of
/// [`pairs`], time with fluid, fluid fraction.
pub(crate) fn means(dimensions: usize, tagged: bool) -> Vec<Quantity> {
    let mut of: Vec<Quantity> = velocities(dimensions).collect();
    of.push(Quantity::new("pressure", "Pa", "pressure"));
    of.extend(vorticities(dimensions));
    of.push(Quantity::new("density", "kg m-3", "density"));
    if tagged {
        of.push(Quantity::new("tag", "1", "passive scalar"));
    }
    let mean = |quantity: &Quantity| {
        let name = format!("{}_mean", quantity.name);
        Quantity::new(name, quantity.unit, format!("time mean of {}", quantity.long_name))
    };
    let mut all: Vec<Quantity> = of.iter().map(mean).collect();
    for (i, j) in pairs(dimensions, tagged) {
        all.push(match (i, j) {
            (i, j) if j < dimensions => {
                let (a, b) = (VELOCITIES[i], VELOCITIES[j]);
                let long_name = format!("Reynolds stress over density, mean of {a}'{b}'");
                Quantity::new(format!("{a}{b}_covariance"), "m2 s-2", long_name)
            }
            (i, _) if i == dimensions => {
                Quantity::new("pressure_variance", "Pa2", "variance in time of pressure")
            }
            _ => Quantity::new("tag_variance", "1", "variance in time of passive scalar"),
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
        assert_eq!(mean_values(&node, 3, true), [1.0, 2.0, 3.0, 7.0, 4.0, 5.0, 6.0, 8.0, 9.0]);
        assert_eq!((mean_count(3, true), mean_count(2, false)), (9, 5));
        let names: Vec<String> = means(2, true).into_iter().map(|quantity| quantity.name).collect();
        assert_eq!(
            names.join(" "),
            "u_mean v_mean pressure_mean vorticity_mean density_mean tag_mean uu_covariance uv_covariance \
             vv_covariance pressure_variance tag_variance fluid_time fluid_fraction_mean"
        );
    }
}
