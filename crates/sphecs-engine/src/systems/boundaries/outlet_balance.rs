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
//! viscosity and force, U the mean velocity at the plane. In a flow that a force drives against
//! friction G is 0, in a vertical pipe ρ0 f·n. The particles of the zone are accelerated by the
//! rest, a'. So a full conduit flows with gravity as without it.
//!
//! A pressure that a condition prescribes holds at the centre of the section.

use glam::DVec3;
use serde::{Deserialize, Serialize};

use crate::systems::forces::body_force;
use sphecs_core::particles::arrays::ParticleArrays;
use sphecs_core::particles::rows::{real_vector, set_real_vector};
use sphecs_core::particles::zone::Zone;
use sphecs_core::pass::pair_real::PairReal;
use sphecs_core::pass::settings::PairSettings;
use sphecs_scene::model::{BodyForce, Patch, Scene};

/// Nodes and weights of Gauss' rule on 0 to 1, exact for potentials of degree 6.
const GAUSS: [(f64, f64); 3] = [
    (0.112_701_665_379_258_3, 0.277_777_777_777_777_8),
    (0.5, 0.444_444_444_444_444_4),
    (0.887_298_334_620_741_7, 0.277_777_777_777_777_8),
];

/// State of the balance at an outlet.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OutletBalance {
    /// Gradient G along the normal, Pa/m.
    pub gradient: f64,
    /// Mean velocity that lags behind U by the passage of sound, m/s; None before the first step.
    pub lagged_velocity: Option<f64>,
}

/// Body force at one outlet in a step, with the balance of the outlet.
pub struct OutletForce<'a> {
    scene: &'a Scene,
    patch: &'a Patch,
    time: f64,
    gradient: f64,
}

impl<'a> OutletForce<'a> {
    /// Returns the force at an outlet at a time, s; None in a scene without a body force.
    pub fn new(scene: &'a Scene, patch: &'a Patch, balance: &OutletBalance, time: f64) -> Option<Self> {
        let is_absent = matches!(scene.body_force, BodyForce::Constant(DVec3::ZERO));
        (!is_absent).then_some(Self { scene, patch, time, gradient: balance.gradient })
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
        self.rows.clear();
        self.pressures.clear();
        for row in 0..arrays.len() {
            let along = patch.along(arrays.position_of(row));
            if arrays.zone[row] == Zone::Fluid && along > -reach && along < reach {
                self.rows.push(row as u32);
                self.pressures.push(arrays.pressure[row]);
            }
        }
        for &row in self.rows.iter().chain(outflow) {
            let row = row as usize;
            let weight = force.weight(arrays.position_of(row));
            arrays.pressure[row] = R::from_f64(arrays.pressure[row].to_f64() - weight);
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
    ///
    /// `velocity` is the mean velocity at the plane, m/s, `passage` the travel time of sound
    /// through the domain, s.
    pub fn accelerate<R: PairReal<D>, const D: usize>(
        &mut self,
        force: &OutletForce<'_>,
        (velocity, passage, time_step): (f64, f64, f64),
        outflow: &[u32],
        arrays: &mut ParticleArrays<R, D>,
    ) {
        if outflow.is_empty() {
            return;
        }
        let (normal, density) = (force.patch.towards, force.scene.fluid.density);
        let share = -(-time_step / passage).exp_m1();
        let lagged = self.lagged_velocity.get_or_insert(velocity);
        let acceleration = (velocity - *lagged) / passage;
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
