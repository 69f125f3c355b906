//! Conditions that say in every step what an outflow particle has: kept from its crossing, mirrored, or by the characteristics.
//!
//! Their particles move along the normal only and are not shifted: Negi et al. (2020), Sec. 3.4.

use std::iter::empty;

use super::outlets::{OutletStage, OutletState};
use sphecs_core::math::real::Real;
use sphecs_core::pass::fits::PointFit;
use sphecs_core::physics::outlet::characteristic::References;
use sphecs_core::physics::outlet::do_nothing::kept;
use sphecs_core::physics::outlet::mirror::MirrorVariant;
use sphecs_core::physics::outlet::modified_do_nothing::{ShownVelocity, carried};

/// `DoNothing`.
pub fn apply_do_nothing<R: Real, const D: usize>(stage: &mut OutletStage<'_, R, D>, state: &mut OutletState) {
    let normal = stage.normal();
    for &row in stage.zone {
        let (velocity, pressure) = stage.own(row as usize);
        stage.set(row as usize, kept(velocity, pressure, normal), state);
    }
}

/// `ModifiedDoNothing`.
pub fn apply_modified_do_nothing<R: Real, const D: usize>(
    stage: &mut OutletStage<'_, R, D>,
    shown: ShownVelocity,
    state: &mut OutletState,
) {
    let normal = stage.normal();
    stage.find_at_zone(PointFit::Mean { normal }, |point| point, empty());
    let others = stage.mean_found(|flow| flow.velocity).unwrap_or(state.fluid_velocity);
    for (at, &row) in stage.zone.iter().enumerate() {
        let fluid = stage.found()[at].map_or(others, |flow| flow.velocity);
        let (velocity, pressure) = stage.own(row as usize);
        stage.set(row as usize, carried(velocity, pressure, fluid, shown, normal), state);
    }
}

/// `Mirror`. A particle whose image is not in the fluid stays as it is.
pub fn apply_mirror<R: Real, const D: usize>(
    stage: &mut OutletStage<'_, R, D>,
    variant: MirrorVariant,
    state: &mut OutletState,
) {
    let (normal, patch) = (stage.normal(), &stage.outlet.patch);
    stage.find_at_zone(
        PointFit::Image { normal },
        |point| point - normal * (2.0 * patch.along(point)),
        empty(),
    );
    for (at, &row) in stage.zone.iter().enumerate() {
        let row = row as usize;
        let depth = patch.along(stage.arrays.position_of(row));
        let outflow = match stage.found()[at] {
            Some(flow) => variant.mirrored(flow.image, depth, normal),
            None => {
                let (velocity, pressure) = stage.own(row);
                kept(velocity, pressure, normal)
            }
        };
        stage.set(row, outflow, state);
    }
}

/// `Characteristic`.
pub fn apply_characteristic<R: Real, const D: usize>(
    stage: &mut OutletStage<'_, R, D>,
    references: References,
    state: &mut OutletState,
) {
    let (normal, impedance) = (stage.normal(), stage.impedance());
    // The impedance is the same for all, so that the mean of J2 is that of velocity and pressure.
    stage.find_at_zone(PointFit::Mean { normal }, |point| point, empty());
    let outgoing = |velocity: f64, pressure: f64| references.outgoing(velocity, pressure, impedance);
    let others = stage
        .mean_found(|flow| outgoing(flow.velocity, flow.pressure))
        .unwrap_or_else(|| outgoing(state.fluid_velocity, state.fluid_pressure));
    for (at, &row) in stage.zone.iter().enumerate() {
        let j2 = stage.found()[at].map_or(others, |flow| outgoing(flow.velocity, flow.pressure));
        let (velocity, _) = stage.own(row as usize);
        stage.set(row as usize, references.outflow(velocity, j2, impedance, normal), state);
    }
}
