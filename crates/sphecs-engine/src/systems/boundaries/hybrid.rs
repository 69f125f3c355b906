//! The zone of a hybrid outlet: the means of the fluid in its reach and of what has crossed.

use serde::{Deserialize, Serialize};

use super::outlets::{OutletStage, OutletState};
use sphecs_core::math::real::Real;
use sphecs_core::physics::outlet::hybrid::{Average, is_sound, share};

/// What a hybrid outlet remembers.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HybridZone {
    /// Means of the particles in reach and in the zone, by their numbers, which rise.
    pub averages: Vec<(u32, Average)>,
    /// Speed of what enters, followed, m/s; None before the first step.
    pub inflow_speed: Option<f64>,
    /// Those of the present step: first of the rows in reach, then of those in the zone, in their order.
    #[serde(skip)]
    present: Vec<(u32, Average)>,
    /// J2 of the rows in reach, Pa.
    #[serde(skip)]
    outgoing: Vec<f64>,
    /// Whether each of `present` was known before.
    #[serde(skip)]
    known: Vec<bool>,
}

impl HybridZone {
    /// The mean that a particle had.
    fn of(&self, id: u32) -> Option<Average> {
        let at = self.averages.binary_search_by_key(&id, |(id, _)| *id).ok()?;
        Some(self.averages[at].1)
    }
}

/// The speed of the threshold, m/s: the mean of what enters, followed; without an inlet the scene's.
fn threshold_speed<R: Real, const D: usize>(
    stage: &OutletStage<'_, R, D>,
    share: f64,
    zone: &mut HybridZone,
) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    for &row in stage.rows.inflow.iter().flatten() {
        sum += stage.arrays.velocity_of(row as usize).length();
        count += 1.0;
    }
    let present = if count > 0.0 { sum / count } else { stage.scene.reference_velocity };
    let before = zone.inflow_speed.unwrap_or(present);
    let followed = before + share * (present - before);
    zone.inflow_speed = Some(followed);
    followed
}

/// `Hybrid`.
pub fn apply_hybrid<R: Real, const D: usize>(
    stage: &mut OutletStage<'_, R, D>,
    velocity: Option<f64>,
    swings_about: f64,
    steps: f64,
    state: &mut OutletState,
) {
    let (normal, impedance, density) = (stage.normal(), stage.impedance(), stage.scene.fluid.density);
    let in_reach = &stage.rows.in_reach[stage.index];
    let share = share(steps);
    let mut hybrid = std::mem::take(&mut state.hybrid);
    let followed = threshold_speed(stage, share, &mut hybrid);
    let threshold = velocity.unwrap_or(followed);
    let normal_flow = |row: usize, arrays: &sphecs_core::particles::arrays::ParticleArrays<R, D>| {
        (arrays.velocity_of(row).dot(normal), arrays.pressure[row].to_f64())
    };

    hybrid.present.clear();
    hybrid.known.clear();
    let (mut sound, mut count) = (0.0, 0.0);
    for &row in in_reach {
        let row = row as usize;
        let (v, p) = normal_flow(row, stage.arrays);
        let id = stage.arrays.id[row];
        let before = hybrid.of(id);
        let mut average = before.unwrap_or_default();
        if before.is_some() {
            if !is_sound(p - swings_about, density, threshold) {
                average.follow(v, p, share);
            }
            sound += average.references().outgoing(v, p, impedance);
            count += 1.0;
        }
        hybrid.known.push(before.is_some());
        hybrid.present.push((id, average));
    }
    let sound = if count > 0.0 { sound / count } else { 0.0 };
    hybrid.outgoing.clear();
    for (at, &row) in in_reach.iter().enumerate() {
        let (v, p) = normal_flow(row as usize, stage.arrays);
        if !hybrid.known[at] {
            hybrid.present[at].1 = Average::without_sound(v, p, sound, impedance);
        }
        hybrid.outgoing.push(hybrid.present[at].1.references().outgoing(v, p, impedance));
    }
    stage.find_mean(in_reach.iter().map(|&row| row as usize).zip(hybrid.outgoing.iter().copied()));
    let others = stage.mean_found(|mean| mean.pressure).unwrap_or(0.0);
    for (at, &row) in stage.zone.iter().enumerate() {
        let row = row as usize;
        let (own, pressure) = stage.own(row);
        let id = stage.arrays.id[row];
        let base = hybrid.of(id).unwrap_or(Average { velocity: own.dot(normal), pressure });
        let outgoing = stage.found()[at].map_or(others, |mean| mean.pressure);
        let outflow = base.references().outflow(own, outgoing, impedance, normal);
        hybrid.present.push((id, base));
        stage.set(row, outflow, state);
    }
    // Numbers are unique, so that the order does not depend on the sort.
    hybrid.present.sort_unstable_by_key(|(id, _)| *id);
    std::mem::swap(&mut hybrid.averages, &mut hybrid.present);
    state.hybrid = hybrid;
}
