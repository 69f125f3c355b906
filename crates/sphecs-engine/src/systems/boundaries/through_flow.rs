//! Flow through the openings that follows from the velocities in the whole domain.
//!
//! ```text
//! Q_i = V Σ_b v_b·∇φ_i(x_b) + ⟨φ_i⟩ Q̃_in + Q̃_i − Σ_j M_ij/(ρ0 c0²) dp_j/dt − A_i S_i
//! V   = ∫ |∇φ_i|² dV/Σ_b |∇φ_i(x_b)|²,   M_ij = ∫ φ_i φ_j dV
//! ```
//!
//! The sums are over the fluid particles, with the weights of
//! [`potential_flow`](sphecs_scene::potential_flow), in which sound does not count. Q̃_in is the
//! slow part of the flow of the inlets, Q̃_i that of the flow of emitters and that which movers
//! displace, with the weight φ_i at their surfaces. V is the mean volume of a particle: with m/ρ0 a
//! flow would seem to vary with the number of particles in the domain, by a per cent or two. The
//! last term is the fluid that is stored as the pressures p_j of the openings rise, since between
//! them the pressure is Σ_j φ_j p_j: the divergence is −dp/dt/(ρ0 c0²). Without it a pressure that
//! oscillates at the frequency ω over a length L is wrong by ω L/(4 c0).
//!
//! ```text
//! A_i dS_i/dt = −Σ_j K_ij p'_j/ρ0 − A_i S_i/τ,   K_ij = ∫ ∇φ_i·∇φ_j dV
//! ```
//!
//! Sound inside the domain adds to the first sum in the ratio of its length to that of the domain,
//! until it leaves with the pressures p'_j at the openings. S_i counts that momentum. Without it a
//! pulse that leaves through one opening is answered by the others.

use rayon::iter::{IndexedParallelIterator, IntoParallelIterator, ParallelIterator};

use super::prescribed_inflow::PrescribedInflow;
use sphecs_core::boundary::outlet::method::{Needs, PlanePressure};
use sphecs_core::boundary::outlet::outflow_zone::settling_time;
use sphecs_core::boundary::slow_part::SlowPart;
use sphecs_core::math::exact_sum::ExactSum;
use sphecs_core::math::grid::CellGrid;
use sphecs_core::particles::arrays::ParticleArrays;
use sphecs_core::particles::zone::Zone;
use sphecs_core::pass::pair_real::PairReal;
use sphecs_core::pass::ranks::Ranks;
use sphecs_scene::displaced_flow::DisplacedFlow;
use sphecs_scene::model::{Outlet, Scene};
use sphecs_scene::potential_flow::{PotentialFlow, potential_flows};

/// Cells per part of the sums.
const CHUNK: usize = 256;

/// Time over which the velocity of sound fades, in times after which sound has left the domain.
const SOUND_FADES: f64 = 5.0;

/// Flow through the openings whose condition uses it.
#[derive(Debug, Default)]
pub struct ThroughFlow {
    weights: Vec<Option<PotentialFlow>>,
    /// Flow of emitters and movers towards each outlet; None without both or without weights.
    displaced: Vec<Option<Displaced>>,
    /// Velocity S that sound adds for each outlet, m/s, which a checkpoint saves.
    pub sound_velocity: Vec<f64>,
    /// Mean velocity through each section in the present step, m/s.
    velocities: Vec<Option<f64>>,
    /// Σ v·∇φ (1/s) and Σ |∇φ|² (1/m²) of each part of the cells.
    sums: Vec<[ExactSum; 2]>,
}

impl ThroughFlow {
    /// Returns the flow of a scene whose outlets have these requirements.
    pub fn new(scene: &Scene, needs: &[Needs]) -> Self {
        let weights = potential_flows(scene, |outlet| needs[outlet].uses_through_flow);
        let sound_velocity = vec![0.0; scene.outlets.len()];
        let displaced = |(outlet, weights): (&Outlet, &Option<PotentialFlow>)| {
            let weights = weights.as_ref()?;
            let flow = DisplacedFlow::new(scene, |point| weights.potential(point));
            if flow.is_none() && scene.emitters.is_empty() {
                return None;
            }
            let passage = scene.extent_along(outlet.patch.towards) / scene.fluid.sound_speed;
            Some(Displaced { flow, slow: SlowPart::new(passage) })
        };
        let displaced = scene.outlets.iter().zip(&weights).map(displaced).collect();
        Self { weights, displaced, sound_velocity, velocities: Vec::new(), sums: Vec::new() }
    }

    /// Finds the velocities at a time after a time step (s), from the pressures at the
    /// planes.
    pub fn find<R: PairReal<D>, const D: usize>(
        &mut self,
        (scene, time, time_step): (&Scene, f64, f64),
        inflow: &PrescribedInflow,
        plane_pressure: impl Fn(usize) -> PlanePressure,
        (grid, arrays, ranks): (&CellGrid<D>, &ParticleArrays<R, D>, &Ranks),
    ) {
        let Self { weights, displaced, sound_velocity, velocities, sums } = self;
        velocities.clear();
        let own = ranks.own_cells();
        let stiffness = scene.fluid.density * scene.fluid.sound_speed.powi(2);
        for (index, (outlet, weights)) in scene.outlets.iter().zip(&*weights).enumerate() {
            velocities.push(weights.as_ref().map(|weights| {
                // By cells, and exactly: the sums depend neither on the number of threads nor on
                // which cells are summed together.
                let of_cell = |cell: usize| {
                    let fluid = grid.rows(cell).filter(|&row| arrays.zone[row] == Zone::Fluid);
                    fluid.map(|row| products(weights, arrays, row)).fold([0.0; 2], joined)
                };
                let of_chunk = |chunk: usize| {
                    let mut sums = <[ExactSum; 2]>::default();
                    let cells = chunk * CHUNK..grid.len().min((chunk + 1) * CHUNK);
                    for cell in cells.filter(|&cell| own.has(cell)) {
                        sums.iter_mut().zip(of_cell(cell)).for_each(|(sum, part)| *sum += part);
                    }
                    sums
                };
                (0..grid.len().div_ceil(CHUNK)).into_par_iter().map(of_chunk).collect_into_vec(sums);
                let mut all = <[ExactSum; 2]>::default();
                for (of, all) in all.iter_mut().enumerate() {
                    sums.iter().for_each(|sums| *all += &sums[of]);
                }
                ranks.sum_exactly(&mut all);
                let [flow, square] = all.each_ref().map(ExactSum::value);
                let displaced =
                    displaced[index].as_mut().map(|displaced| displaced.rate(scene, weights, time));
                let volume = if !scene.movers.is_empty() {
                    // The weights are those of the casing, the fluid does not fill it.
                    scene.discretisation.cell_volume()
                } else if square > 0.0 {
                    weights.square / square
                } else {
                    0.0
                };
                let prescribed = inflow.of_inlets(index);
                let sum = |factors: &[f64], value: &dyn Fn(PlanePressure) -> f64| -> f64 {
                    factors
                        .iter()
                        .enumerate()
                        .map(|(other, factor)| factor * value(plane_pressure(other)))
                        .sum()
                };
                let stored = sum(&weights.overlaps, &|pressure| pressure.rate) / stiffness;
                let push = sum(&weights.conductances, &|pressure| pressure.sound) / scene.fluid.density;
                let sound = &mut sound_velocity[index];
                let extent = scene.extent_along(outlet.patch.towards);
                let fading = SOUND_FADES * settling_time(extent, scene.fluid.sound_speed);
                *sound -= time_step * (push / outlet.patch.area + *sound / fading);
                let rate =
                    volume * flow + weights.inlet_potential * prescribed - stored + displaced.unwrap_or(0.0);
                rate / outlet.patch.area - *sound
            }));
        }
    }

    /// Returns the mean velocity through the section of an outlet, m/s; None if its condition does
    /// not use it.
    pub fn velocity(&self, outlet: usize) -> Option<f64> {
        self.velocities.get(outlet).copied().flatten()
    }
}

/// Flow of emitters and movers towards an outlet.
#[derive(Debug)]
struct Displaced {
    /// Flow that movers displace; None without them.
    flow: Option<DisplacedFlow>,
    slow: SlowPart,
}

impl Displaced {
    /// Returns the slow part of the volume flow at a time (s), m³/s (m²/s in 2D).
    fn rate(&mut self, scene: &Scene, weights: &PotentialFlow, time: f64) -> f64 {
        let Self { flow, slow } = self;
        let at = |time: f64| {
            let moved = flow.as_ref().map_or(0.0, |flow| flow.rate(scene, time));
            moved + scene.emitted_flow(time, |place| weights.potential(place))
        };
        slow.at(time, at).0
    }
}

/// Returns v·∇φ (1/s) and |∇φ|² (1/m²) of a row.
fn products<R: PairReal<D>, const D: usize>(
    weights: &PotentialFlow,
    arrays: &ParticleArrays<R, D>,
    row: usize,
) -> [f64; 2] {
    let gradient = weights.gradient(arrays.position_of(row)).map(f64::from);
    let velocity = arrays.velocity_of(row);
    (0..D).map(|axis| [velocity[axis] * gradient[axis], gradient[axis].powi(2)]).fold([0.0; 2], joined)
}

/// Returns the sum of two pairs.
fn joined(one: [f64; 2], other: [f64; 2]) -> [f64; 2] {
    [one[0] + other[0], one[1] + other[1]]
}
