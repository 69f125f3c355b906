//! Balance of a body force at an outlet: the pressure that carries the weight of the fluid.
//!
//! ```text
//! p* = p − ρ0 ∫ f_t · dx − G d       f_t = f − (f·n) n along the plane, from its centre
//! G  = ρ0 (⟨a·n⟩ − dU/dt)            d distance beyond the plane
//! a' = a − (f_t + G n/ρ0)
//! ```
//!
//! Outlet conditions know of no force. They work with the reduced pressure p*, from which what
//! balances the body force f is taken away. Along the plane this is the weight of the fluid (Φ of
//! f = −∇Φ where f has a potential). Along the normal it is the part that neither friction takes
//! up nor accelerates the mean flow: ⟨a·n⟩ is the mean over the zone of the acceleration by
//! viscosity and force, U the mean velocity that the inlets prescribe, or without inlets the one
//! at the plane. In a flow that a force drives against
//! friction G is 0, in a vertical pipe ρ0 f·n. The particles of the zone are accelerated by the
//! rest, a'. So a full conduit flows with gravity as without it.
//!
//! A pressure that a condition prescribes holds at the centre of the section.

use glam::DVec3;
use rayon::iter::{IndexedParallelIterator, IntoParallelRefIterator, ParallelIterator};
use serde::{Deserialize, Serialize};

use crate::systems::forces::body_force;
use sphecs_core::particles::arrays::ParticleArrays;
use sphecs_core::particles::rows::{real_vector, set_real_vector};
use sphecs_core::particles::zone::Zone;
use sphecs_core::pass::blocks::with_lists;
use sphecs_core::pass::pair_real::PairReal;
use sphecs_core::pass::settings::PairSettings;
use sphecs_scene::model::{BodyForce, Patch, Scene};

/// Nodes and weights of Gauss' rule on 0 to 1, exact for potentials of degree 6.
const GAUSS: [(f64, f64); 3] = [
    (0.112_701_665_379_258_3, 0.277_777_777_777_777_8),
    (0.5, 0.444_444_444_444_444_4),
    (0.887_298_334_620_741_7, 0.277_777_777_777_777_8),
];

/// Smallest number of rows per thread: a force may be an expression.
const CHUNK: usize = 64;

/// State of the balance at an outlet.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OutletBalance {
    /// Gradient G along the normal, Pa/m.
    pub gradient: f64,
    /// Mean velocity that lags behind U by the passage of sound, m/s; None before the first step.
    pub lagged_velocity: Option<f64>,
}

/// Motion of the fluid at the plane of an outlet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlaneMotion {
    /// Mean velocity, m/s.
    pub velocity: f64,
    /// Acceleration that the inlets prescribe, m/s²; None without inlets, where it is measured.
    pub acceleration: Option<f64>,
    /// Travel time of sound through the domain, s.
    pub passage: f64,
    /// Time step, s.
    pub time_step: f64,
}

/// Body force at one outlet in a step, with the balance of the outlet.
pub struct OutletForce<'a> {
    scene: &'a Scene,
    patch: &'a Patch,
    time: f64,
    gradient: f64,
}

impl<'a> OutletForce<'a> {
    /// Returns the force at an outlet at a time, s; None in a scene without a body force, unless
    /// the pressure gradient of the flow `continues` into the zone.
    pub fn new(
        scene: &'a Scene,
        patch: &'a Patch,
        continues: bool,
        balance: &OutletBalance,
        time: f64,
    ) -> Option<Self> {
        let is_absent = matches!(scene.body_force, BodyForce::Constant(DVec3::ZERO));
        (continues || !is_absent).then_some(Self { scene, patch, time, gradient: balance.gradient })
    }

    fn at(&self, point: DVec3) -> DVec3 {
        body_force(&self.scene.body_force, point, self.time)
    }

    /// Returns p − p* at a point, Pa.
    pub fn weight(&self, point: DVec3) -> f64 {
        let along = self.patch.along(point);
        let path = point - self.patch.at - self.patch.towards * along;
        let across = match &self.scene.body_force {
            BodyForce::Constant(force) => force.dot(path),
            BodyForce::Expression(_) => GAUSS
                .iter()
                .map(|(node, weight)| weight * self.at(self.patch.at + path * *node).dot(path))
                .sum(),
        };
        self.scene.fluid.density * across + self.gradient * along
    }
}

/// Fluid rows near an outlet whose pressure is reduced, kept from step to step.
#[derive(Debug, Default)]
pub struct ReducedBuffers<R> {
    rows: Vec<u32>,
    pressures: Vec<R>,
    /// Rows of each part of all rows.
    parts: Vec<Vec<u32>>,
    /// p − p* at the rows, then at the outflow rows, Pa.
    weights: Vec<f64>,
}

impl<R: Copy> ReducedBuffers<R> {
    /// Reduces the pressures of the outflow rows and of the fluid that a condition may read.
    pub fn reduce<const D: usize>(
        &mut self,
        force: &OutletForce<'_>,
        outflow: &[u32],
        arrays: &mut ParticleArrays<R, D>,
    ) where
        R: PairReal<D>,
    {
        let (scene, patch) = (force.scene, force.patch);
        // A condition may fit the fluid at the mirror images of its particles.
        let reach = patch.depth + scene.discretisation.support + 2.0 * scene.spacing;
        let Self { rows, pressures, parts, weights } = self;
        let before = &*arrays;
        let is_near = |&row: &usize| {
            let along = patch.along(before.position_of(row));
            before.zone[row] == Zone::Fluid && along > -reach && along < reach
        };
        let parts = with_lists(arrays.len(), parts, &|among, part: &mut Vec<u32>| {
            part.clear();
            part.extend(among.filter(is_near).map(|row| row as u32));
        });
        rows.clear();
        parts.iter().for_each(|part| rows.extend_from_slice(part));
        pressures.clear();
        pressures.extend(rows.iter().map(|&row| before.pressure[row as usize]));
        let all = rows.par_iter().chain(outflow).with_min_len(CHUNK);
        all.map(|&row| force.weight(before.position_of(row as usize))).collect_into_vec(weights);
        for (&row, weight) in rows.iter().chain(outflow).zip(weights) {
            let row = row as usize;
            arrays.pressure[row] = R::from_f64(arrays.pressure[row].to_f64() - *weight);
        }
    }

    /// Restores the pressures of the fluid, and adds the weight to those of the outflow rows, whose
    /// density follows where the scheme has an equation of state.
    pub fn restore<const D: usize>(
        &mut self,
        force: &OutletForce<'_>,
        outflow: &[u32],
        pair: &PairSettings,
        arrays: &mut ParticleArrays<R, D>,
    ) where
        R: PairReal<D>,
    {
        for (&row, &pressure) in self.rows.iter().zip(&self.pressures) {
            arrays.pressure[row as usize] = pressure;
        }
        for &row in outflow {
            let row = row as usize;
            let pressure = arrays.pressure[row].to_f64() + force.weight(arrays.position_of(row));
            arrays.pressure[row] = R::from_f64(pressure);
            if let Some(density) = pair.density_at(pressure) {
                arrays.density[row] = R::from_f64(density);
            }
        }
    }
}

impl OutletBalance {
    /// Follows the gradient and adds to the accelerations of the outflow rows the part of the body
    /// force that the pressure does not balance.
    pub fn accelerate<R: PairReal<D>, const D: usize>(
        &mut self,
        force: &OutletForce<'_>,
        motion: &PlaneMotion,
        outflow: &[u32],
        arrays: &mut ParticleArrays<R, D>,
    ) {
        if outflow.is_empty() {
            return;
        }
        let PlaneMotion { velocity, acceleration, passage, time_step } = *motion;
        let (normal, density) = (force.patch.towards, force.scene.fluid.density);
        let share = -(-time_step / passage).exp_m1();
        let lagged = self.lagged_velocity.get_or_insert(velocity);
        let acceleration = acceleration.unwrap_or((velocity - *lagged) / passage);
        *lagged += share * (velocity - *lagged);
        let mut mean = 0.0;
        for &row in outflow {
            let row = row as usize;
            let along = force.at(arrays.position_of(row)).dot(normal);
            mean += real_vector(&arrays.acceleration, row).dot(normal) + along;
        }
        mean /= outflow.len() as f64;
        self.gradient += share * (density * (mean - acceleration) - self.gradient);
        for &row in outflow {
            let row = row as usize;
            let along = force.at(arrays.position_of(row)).dot(normal) - self.gradient / density;
            let sum = real_vector(&arrays.acceleration, row) + normal * along;
            set_real_vector(&mut arrays.acceleration, row, sum);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::resources::pair::pair_settings;

    /// Returns a channel along x whose end is at x = 0.2 m, 0.04 m wide, with a body force.
    fn scene(force: &str) -> Scene {
        let text = format!(
            "Scene(title: \"t\", dimensions: 2, spacing: 0.002,
            fluid: (density: 1000.0, viscosity: 1.0e-5, sound_speed: 2.0),
            domain: Box(min: (0.0, -0.02), max: (0.2, 0.02)), body_force: {force},
            inlets: [(at: (0.0, 0.0), towards: (1.0, 0.0), velocity: Normal(0.1))],
            outlets: [(at: (0.2, 0.01), towards: (1.0, 0.0))],
            time: (end: 1.0), output: (every: 0.1))"
        );
        Scene::from_text("force", text).load().expect("a scene")
    }

    fn weight(scene: &Scene, gradient: f64, point: DVec3) -> Option<f64> {
        let balance = OutletBalance { gradient, ..OutletBalance::default() };
        OutletForce::new(scene, &scene.outlets[0].patch, false, &balance, 0.5)
            .map(|force| force.weight(point))
    }

    #[test]
    fn weight_is_that_of_the_fluid_above() {
        let point = DVec3::new(0.21, -0.015, 0.0);
        assert_eq!(weight(&scene("(0.0, 0.0)"), 0.0, point), None);
        let found = weight(&scene("(3.0, -9.81)"), 50.0, point).expect("a force");
        assert!((found - (1000.0 * 9.81 * 0.015 + 0.5)).abs() < 1e-9, "{found} Pa");
        // −∂Φ/∂y of Φ = y⁴ − 2 t y, with t = 0.5 s.
        let found = weight(&scene("(0.0, \"-4*y^3 + 2*t\")"), 0.0, point).expect("a force");
        let exact = 1000.0 * (-(0.015_f64.powi(4)) - 0.015);
        assert!((found - exact).abs() < 1e-9, "{found} Pa, exact {exact}");
    }

    #[test]
    fn reduced_pressures_are_restored_bit_by_bit() {
        let scene = scene("(0.0, -9.81)");
        let mut arrays = ParticleArrays::<f32, 2>::default();
        let places = [(0.15, 0.013, Zone::Fluid), (0.19, -0.007, Zone::Fluid), (0.201, 0.003, Zone::Outflow)];
        for (index, (x, y, zone)) in places.into_iter().enumerate() {
            arrays.position[0].push(x);
            arrays.position[1].push(y);
            arrays.zone.push(zone);
            arrays.pressure.push(12.345 + index as f32);
            arrays.density.push(1000.0);
            arrays.id.push(index as u32);
        }
        let before = arrays.pressure.clone();
        let force =
            OutletForce::new(&scene, &scene.outlets[0].patch, false, &OutletBalance::default(), 0.0).unwrap();
        let mut buffers = ReducedBuffers::default();
        buffers.reduce(&force, &[2], &mut arrays);
        // The first particle is out of reach.
        assert_eq!(arrays.pressure[0], before[0]);
        assert!((f64::from(arrays.pressure[1] - before[1]) + 1000.0 * 9.81 * 0.007).abs() < 1e-3);
        let pair = pair_settings(&scene);
        buffers.restore(&force, &[2], &pair, &mut arrays);
        assert_eq!(arrays.pressure[..2], before[..2]);
        assert!((arrays.pressure[2] - before[2]).abs() < 1e-5);
    }

    #[test]
    fn steady_flow_leaves_the_zone_without_mean_acceleration() {
        let scene = scene("(2.0, 0.0)");
        let mut arrays = ParticleArrays::<f64, 2>::default();
        for index in 0..4 {
            arrays.position[0].push(0.201);
            arrays.position[1].push(0.002 * f64::from(index));
            // Friction of 0.5 m/s² on average.
            arrays.acceleration[0].push(-0.2 * f64::from(index) - 0.2);
            arrays.acceleration[1].push(0.1);
            arrays.id.push(index);
        }
        let friction = arrays.acceleration[0].clone();
        let rows = [0, 1, 2, 3];
        let mut balance = OutletBalance::default();
        for _ in 0..2000 {
            arrays.acceleration[0].copy_from_slice(&friction);
            let force = OutletForce::new(&scene, &scene.outlets[0].patch, false, &balance, 0.0).unwrap();
            let motion = PlaneMotion { velocity: 0.1, acceleration: None, passage: 0.1, time_step: 1e-3 };
            balance.accelerate(&force, &motion, &rows, &mut arrays);
        }
        assert!((balance.gradient - 1000.0 * 1.5).abs() < 1e-3, "{} Pa/m", balance.gradient);
        let mean = arrays.acceleration[0].iter().sum::<f64>() / 4.0;
        assert!(mean.abs() < 1e-6 && arrays.acceleration[1] == [0.1; 4], "{mean} m/s²");
        assert!((arrays.acceleration[0][0] - 0.3).abs() < 1e-6);
    }
}
