//! Columns that the pair passes write beside the particle arrays, and buffers that they keep from
//! step to step.

use std::ops::Range;

use rayon::iter::{IndexedParallelIterator, ParallelIterator};
use rayon::slice::{ParallelSlice, ParallelSliceMut};

use super::blocks::for_each_part;
use super::column_access::Written;
use super::fused::FusedRates;
use super::gradients::Gradients;
use super::pack::{NeighbourMask, PackPool};
use super::settings::PairSettings;
use super::strain::Strain;
use super::stress::Stress;
use super::wall_friction::WallFriction;
use super::wall_sides::{SideColumns, WallSides};
use super::wall_velocity::WallVelocity;
use crate::math::real::Real;
use crate::particles::arrays::ParticleArrays;
use crate::particles::zone::Zone;

/// Sums per particle and buffers of the passes; the rows are those of the particle arrays.
#[derive(Debug)]
pub struct PairSums<R, const D: usize> {
    /// Shifting vector of the fluid, written by `rates`.
    ///
    /// Fickian and Local: ∇C = Σ V_b ∇W, or `concentration_gradient` less its mean over the
    /// support, 1/m. Vacondio: r̄² Σ (m_b/M) x_ab/r³, dimensionless. Where the pressure evolves,
    /// written by `edac`: acceleration by the background pressure, m/s²; for outflow ∇C, 1/m.
    pub shift: Written<[Vec<R>; D], FusedRates>,
    /// dp/dt of the fluid, Pa/s, written by `edac`; else empty.
    pub pressure_rate: Written<Vec<R>, FusedRates>,
    /// ∇·v = Σ V_b (v_b − v_a)·∇W of the fluid with image velocities, 1/s, written by `rates` and
    /// `edac`.
    pub divergence: Written<Vec<R>, FusedRates>,
    /// Rate λ at which the viscous term damps a fluid particle among neighbours at rest, 1/s,
    /// written by `rates`.
    ///
    /// Empty without walls, and where the pressure evolves.
    pub damping: Written<Vec<R>, FusedRates>,
    /// Velocity gradient `gradient[i][j]` = ∂v_i/∂x_j of the flow, 1/s, written by `gradients`;
    /// else empty.
    pub gradient: Written<[[Vec<R>; D]; D], Gradients>,
    /// Velocity gradient among the neighbours of a particle, 1/s, written by `strain`.
    ///
    /// Empty unless shifting carries the velocity.
    pub neighbour_gradient: Written<[[Vec<R>; D]; D], Strain>,
    /// ∇C = Σ V_b ∇W of the flow, 1/m, by the volumes of the step before, written by `strain`.
    ///
    /// Empty unless the mean over the support is subtracted from the shift.
    pub concentration_gradient: Written<[Vec<R>; D], Strain>,
    /// Rate of strain of the flow, 1/s, with the components of `stress`, written by `strain`; else
    /// empty.
    pub strain: Written<[Vec<R>; 6], Strain>,
    /// Eddy viscosity ν_t of the flow, m²/s, written by `stress`; else empty.
    pub eddy_viscosity: Written<Vec<R>, Stress>,
    /// T/ρ² of all particles, m⁵/(kg s²), written by `stress`: xx, yy, xy in 2D; xx, yy, zz, xy,
    /// yz, zx in 3D; else empty.
    pub stress: Written<[Vec<R>; 6], Stress>,
    /// Stress of wall particles until it is found for all of them.
    pub(super) wall_stress: [Vec<R>; 6],
    /// Velocities of all particles in the viscous term of the fluid, m/s, written by
    /// `wall_velocity`.
    ///
    /// For walls see `physics/wall/dummy.rs`. Empty unless walls are dummy particles.
    pub velocity_seen: Written<[Vec<R>; D], WallVelocity>,
    /// Body force per mass on the fluid, m/s², by which a mirrored pressure is continued into a
    /// wall; the caller writes it.
    ///
    /// Empty where it is uniform:
    /// [`PairSettings::body_force`](super::settings::PairSettings::body_force).
    pub body_force: [Vec<R>; D],
    /// Acceleration by a wall particle with a wall function over w(q), m/s², written by
    /// `wall_friction`; 0 for others.
    ///
    /// Empty where no wall has a wall function.
    pub friction: Written<[Vec<R>; D], WallFriction>,
    /// Σ w(q) over the fluid that the friction acts on; empty with it.
    pub friction_felt: Written<Vec<R>, WallFriction>,
    /// Sides of the particles near thin walls, written by `wall_sides`.
    ///
    /// Empty where no wall is thin.
    pub sides: Written<SideColumns<R, D>, WallSides>,
    /// Vectors of the pack with a neighbour in the support, for particles whose density was summed
    /// since the last sort.
    ///
    /// Empty before that, and in 3D.
    pub(super) near: Vec<NeighbourMask>,
    pub(super) columns: PairColumns<R>,
    pub(super) packs: PackPool<R>,
}

/// Neighbour columns that are derived from the particle arrays, made once per pass.
#[derive(Debug, Default)]
pub(super) struct PairColumns<R> {
    /// Distance of a wall particle behind its surface, m; 0 for others. Empty if there is no wall.
    ///
    /// Negative for free-slip walls after [`PairColumns::find_images`].
    pub image_distance: Vec<R>,
    /// 1 for fluid, inflow and outflow, 0 for walls.
    pub flow: Vec<R>,
    /// Volume m/ρ of fluid particles, m³ (m² in 2D), 0 for others. Empty unless an inlet, an outlet
    /// or shifting needs it.
    pub fluid_volume: Vec<R>,
    /// Volume m/ρ of all particles before their density is summed, m³ (m² in 2D). Empty unless
    /// shifting carries no mass.
    pub volume: Vec<R>,
    /// Number of wall particles before each row, and of all at the end. Empty if there is no wall.
    pub walls_before: Vec<u32>,
    /// Number of wall particles before each chunk of rows.
    walls_by_chunk: Vec<u32>,
    /// Walls as the columns above describe them; None until they are found in the present order.
    walls: Option<Walls>,
    /// True if `fluid_volume` is that of the present densities.
    has_fluid_volume: bool,
    /// Pressure of wall particles, Pa, until it is found for all of them.
    pub wall_pressure: Vec<R>,
    /// 1 for the wall particles of the body whose force is summed, 0 for all others.
    pub body: Vec<R>,
}

/// Walls as the columns describe them.
#[derive(Clone, Copy, Debug)]
struct Walls {
    /// True if there are walls, here or among the particles of another rank.
    exist: bool,
    /// True if the image distances are those of the wall model, for [`PairColumns::find_images`].
    as_images: bool,
}

impl<R: Real, const D: usize> Default for PairSums<R, D> {
    fn default() -> Self {
        Self {
            shift: Written::new(std::array::from_fn(|_| Vec::new())),
            pressure_rate: Written::new(Vec::new()),
            divergence: Written::new(Vec::new()),
            damping: Written::new(Vec::new()),
            gradient: Written::new(std::array::from_fn(|_| std::array::from_fn(|_| Vec::new()))),
            neighbour_gradient: Written::new(std::array::from_fn(|_| std::array::from_fn(|_| Vec::new()))),
            concentration_gradient: Written::new(std::array::from_fn(|_| Vec::new())),
            strain: Written::new(std::array::from_fn(|_| Vec::new())),
            eddy_viscosity: Written::new(Vec::new()),
            stress: Written::new(std::array::from_fn(|_| Vec::new())),
            wall_stress: std::array::from_fn(|_| Vec::new()),
            velocity_seen: Written::new(std::array::from_fn(|_| Vec::new())),
            body_force: std::array::from_fn(|_| Vec::new()),
            friction: Written::new(std::array::from_fn(|_| Vec::new())),
            friction_felt: Written::new(Vec::new()),
            sides: Written::new(SideColumns::default()),
            near: Vec::new(),
            columns: PairColumns::default(),
            packs: PackPool::default(),
        }
    }
}

impl<R: Real, const D: usize> PairSums<R, D> {
    /// Discards what depends on the order of the rows, on zones and on the position of walls.
    pub fn forget_order(&mut self) {
        self.near.clear();
        self.columns.walls = None;
        self.columns.forget_densities();
    }
}

/// A wall particle is never nearer to its surface than this, over Δ: a distance of 0 means "not a
/// wall".
const LEAST_IMAGE_DISTANCE: f64 = 1e-6;

/// Rows that a thread takes at a time.
const CHUNK: usize = 8192;

/// Rows that are tested together for walls.
const GROUP: usize = 32;

impl<R: Real> PairColumns<R> {
    /// Fills the columns of the walls unless they are valid since the last sort; returns true if
    /// there are walls, here or among the particles of another rank.
    pub(super) fn find_walls<const D: usize>(
        &mut self,
        pair: &PairSettings,
        particles: &ParticleArrays<R, D>,
    ) -> bool {
        match self.walls {
            Some(Walls { exist, as_images: false }) => exist,
            _ => {
                let exist = self.fill_wall_columns(pair, particles);
                self.walls = Some(Walls { exist, as_images: false });
                exist
            }
        }
    }

    /// Fills image distances and wall counts; returns true if there are walls.
    fn fill_wall_columns<const D: usize>(
        &mut self,
        pair: &PairSettings,
        particles: &ParticleArrays<R, D>,
    ) -> bool {
        let rows = particles.len();
        let zones = particles.zone.par_chunks(CHUNK);
        let count = |zones: &[Zone]| zones.iter().filter(|&&zone| zone == Zone::Wall).count() as u32;
        zones.clone().map(count).collect_into_vec(&mut self.walls_by_chunk);
        let mut total = 0;
        for walls in &mut self.walls_by_chunk {
            total += std::mem::replace(walls, total);
        }
        if total == 0 && !pair.ranks.have_walls() {
            self.image_distance.clear();
            self.walls_before.clear();
            return false;
        }
        self.image_distance.resize(rows, R::default());
        self.walls_before.resize(rows + 1, 0);
        self.walls_before[rows] = total;
        let least = R::from_f64(LEAST_IMAGE_DISTANCE * pair.discretisation.spacing);
        let columns = self.image_distance.par_chunks_mut(CHUNK).zip(self.walls_before.par_chunks_mut(CHUNK));
        let inputs = zones.zip(particles.wall_distance.par_chunks(CHUNK)).zip(&self.walls_by_chunk);
        columns.zip(inputs).for_each(|((image, before), ((zones, distances), &walls))| {
            let mut walls = walls;
            // Most groups have no wall: they need no branch per row.
            // The last chunk of `before` has the total behind it.
            let before = &mut before[..zones.len()];
            let groups = image.chunks_mut(GROUP).zip(before.chunks_mut(GROUP));
            for ((image, before), (zones, distances)) in
                groups.zip(zones.chunks(GROUP).zip(distances.chunks(GROUP)))
            {
                image.fill(R::default());
                before.fill(walls);
                if !zones.iter().fold(false, |any, &zone| any | (zone == Zone::Wall)) {
                    continue;
                }
                for (((image, before), zone), &distance) in
                    image.iter_mut().zip(before).zip(zones).zip(distances)
                {
                    *before = walls;
                    if *zone == Zone::Wall {
                        *image = if distance > least { distance } else { least };
                        walls += 1;
                    }
                }
            }
        });
        true
    }

    /// Fills the column of the volumes from the present densities.
    pub(super) fn find_volume<const D: usize>(
        &mut self,
        pair: &PairSettings,
        particles: &ParticleArrays<R, D>,
    ) {
        fill_volumes(&mut self.volume, pair, particles, |_| true);
    }

    /// Fills the column of the fluid's volumes unless it is valid since the density was last
    /// summed.
    pub(super) fn find_fluid_volume<const D: usize>(
        &mut self,
        pair: &PairSettings,
        particles: &ParticleArrays<R, D>,
    ) {
        if !self.has_fluid_volume {
            fill_volumes(&mut self.fluid_volume, pair, particles, |zone| zone == Zone::Fluid);
            self.has_fluid_volume = true;
        }
    }

    /// Discards the volumes of densities that are about to change.
    pub(super) fn forget_densities(&mut self) {
        self.has_fluid_volume = false;
    }

    /// Fills the column of particles of the flow.
    pub(super) fn find_flow<const D: usize>(&mut self, particles: &ParticleArrays<R, D>) {
        self.flow.resize(particles.len(), R::default());
        let work = |rows: Range<usize>, flow: &mut [R]| {
            for (flow, zone) in flow.iter_mut().zip(&particles.zone[rows]) {
                *flow = if *zone == Zone::Wall { R::default() } else { R::from_f64(1.0) };
            }
        };
        for_each_part(0..particles.len(), self.flow.as_mut_slice(), &work);
    }

    /// Fills the column of the particles of a part of the wall.
    pub(super) fn find_body<const D: usize>(
        &mut self,
        particles: &ParticleArrays<R, D>,
        is_body: impl Fn(usize) -> bool + Sync,
    ) {
        self.body.resize(particles.len(), R::default());
        let work = |rows: Range<usize>, body: &mut [R]| {
            for (body, row) in body.iter_mut().zip(rows) {
                *body = if is_body(row) { R::from_f64(1.0) } else { R::default() };
            }
        };
        for_each_part(0..particles.len(), self.body.as_mut_slice(), &work);
    }

    /// Fills the columns of the walls with the distances of the wall model, negative for free-slip
    /// walls.
    ///
    /// Returns whether there are any walls.
    pub(super) fn find_images<const D: usize>(
        &mut self,
        pair: &PairSettings,
        particles: &ParticleArrays<R, D>,
    ) -> bool {
        if let Some(Walls { exist, as_images: true }) = self.walls {
            return exist;
        }
        let exist = self.find_walls(pair, particles);
        let model = pair.wall_model;
        if exist && (pair.has_free_slip() || model.mirrors_velocity()) {
            self.walls = Some(Walls { exist, as_images: true });
            let work = |rows: Range<usize>, images: &mut [R]| {
                for (image, row) in images.iter_mut().zip(rows) {
                    if particles.zone[row] != Zone::Wall {
                        continue;
                    }
                    if model.mirrors_velocity() {
                        *image = R::from_f64(model.image_distance(image.to_f64()));
                    }
                    if pair.wall_part(particles.patch[row]).free_slip {
                        *image = R::default() - *image;
                    }
                }
            };
            for_each_part(0..particles.len(), self.image_distance.as_mut_slice(), &work);
        }
        exist
    }
}

/// Fills a column with the volumes of the particles whose zone counts, 0 for the others.
fn fill_volumes<R: Real, const D: usize>(
    column: &mut Vec<R>,
    pair: &PairSettings,
    particles: &ParticleArrays<R, D>,
    counts: impl Fn(Zone) -> bool + Sync,
) {
    column.resize(particles.len(), R::default());
    let mass = R::from_f64(pair.discretisation.mass);
    let work = |rows: Range<usize>, volumes: &mut [R]| {
        let densities = &particles.density[rows.clone()];
        for ((volume, &zone), &density) in volumes.iter_mut().zip(&particles.zone[rows]).zip(densities) {
            *volume = if counts(zone) { mass / density } else { R::default() };
        }
    };
    for_each_part(0..particles.len(), column.as_mut_slice(), &work);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::kernel::Kernel;
    use crate::particles::rows::ParticleRow;
    use crate::pass::samples::{SPACING, settings};

    #[test]
    fn walls_are_counted_across_ends_of_groups_and_chunks() {
        let pair = settings(Kernel::WendlandC2, 2, 1.3);
        for rows in [1, GROUP - 1, GROUP, 3 * GROUP + 7, CHUNK, CHUNK + 1, CHUNK + GROUP + 5] {
            let mut particles = ParticleArrays::<f64, 2>::default();
            for id in 0..rows {
                // Some groups have no wall, some have one, the last row is one.
                let is_wall = id + 1 == rows || (id / 50 % 3 == 0 && id % 7 == 2);
                let zone = if is_wall { Zone::Wall } else { Zone::Fluid };
                let wall_distance = if id % 2 == 0 { 0.3 * SPACING } else { 0.0 };
                particles.push(&ParticleRow { id: id as u32, zone, wall_distance, ..Default::default() });
            }
            let mut columns = PairColumns::default();
            let exist = columns.find_walls(&pair, &particles);
            let mut walls = 0;
            for row in 0..rows {
                assert_eq!(columns.walls_before[row], walls, "row {row} of {rows}");
                let behind = particles.wall_distance[row].max(LEAST_IMAGE_DISTANCE * SPACING);
                let is_wall = particles.zone[row] == Zone::Wall;
                assert_eq!(columns.image_distance[row], if is_wall { behind } else { 0.0 });
                walls += u32::from(is_wall);
            }
            assert_eq!((exist, columns.walls_before[rows]), (true, walls), "{rows} rows");
        }
    }
}
