//! Numbers of the openings that the conditions of other openings use, in one stage of a step.

use super::opening_regions::OpeningRegions;
use super::outlets::RunningOutlet;
use super::patch_rows::PatchRows;
use sphecs_core::boundary::outlet::method::{Needs, PlanePressure};
use sphecs_core::particles::arrays::ParticleArrays;
use sphecs_core::pass::pair_real::PairReal;
use sphecs_core::pass::ranks::Ranks;

/// Numbers of all openings, which all ranks have.
#[derive(Debug, Default)]
pub(super) struct OpeningNumbers {
    /// Pressure at the plane of each outlet; none if no condition uses it.
    plane_pressures: Vec<PlanePressure>,
    /// Sum of the speeds (m/s) of the inflow particles of each inlet and emitter, and their number;
    /// none if no condition uses it.
    inflow: Vec<[f64; 2]>,
}

impl OpeningNumbers {
    /// Finds the numbers that the conditions use.
    pub(super) fn find<R: PairReal<D>, const D: usize>(
        &mut self,
        (outlets, needs): (&[RunningOutlet<R, D>], &[Needs]),
        (openings, rows): (&OpeningRegions, &PatchRows),
        arrays: &ParticleArrays<R, D>,
        ranks: &Ranks,
    ) {
        self.plane_pressures.clear();
        if needs.iter().any(|needs| needs.uses_through_flow) {
            self.plane_pressures.extend(outlets.iter().map(|outlet| outlet.condition.plane_pressure()));
        }
        self.inflow.clear();
        if needs.iter().any(|needs| needs.uses_inflow_speed) {
            let speed = |&row: &u32| arrays.velocity_of(row as usize).length();
            let of_source = |rows: &Vec<u32>| {
                [rows.iter().map(speed).fold(0.0, |sum, speed| sum + speed), rows.len() as f64]
            };
            self.inflow.extend(rows.inflow.iter().map(of_source));
        }
        if ranks.size() > 1 && !(self.plane_pressures.is_empty() && self.inflow.is_empty()) {
            self.share(openings, ranks);
        }
    }

    /// Takes the numbers of each opening from the leader of its region.
    fn share(&mut self, openings: &OpeningRegions, ranks: &Ranks) {
        let Self { plane_pressures, inflow } = self;
        let pressures = plane_pressures.iter().map(|pressure| [pressure.rate, pressure.sound]);
        let own: Vec<[f64; 2]> = pressures.chain(inflow.iter().copied()).collect();
        let all = ranks.values_of_all(&own);
        let number = |leader: usize, at: usize| all[leader * own.len() + at];
        for (outlet, pressure) in plane_pressures.iter_mut().enumerate() {
            let [rate, sound] = number(openings.leader_of_outlet(outlet), outlet);
            *pressure = PlanePressure { rate, sound };
        }
        let before = plane_pressures.len();
        for (source, inflow) in inflow.iter_mut().enumerate() {
            *inflow = number(openings.leader_of_source(source), before + source);
        }
    }

    /// Returns the pressure at the plane of an outlet.
    pub(super) fn plane_pressure(&self, outlet: usize) -> PlanePressure {
        self.plane_pressures.get(outlet).copied().unwrap_or_default()
    }

    /// Returns the mean speed of the inflow particles, m/s; None if there are none.
    pub(super) fn inflow_speed(&self) -> Option<f64> {
        let [sum, count] = self.inflow.iter().fold([0.0; 2], |[sum, count], [s, n]| [sum + s, count + n]);
        (count > 0.0).then(|| sum / count)
    }
}
