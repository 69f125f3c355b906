//! The columns of a pack that the pair loop asks for.

use crate::pass::settings::PairSettings;
use crate::physics::sps;
use crate::physics::viscosity::Viscosity;
use crate::physics::wall::WallModel;

/// Which of a pack's columns is what. The coordinates are the first `D`, the velocity the next.
#[derive(Clone, Copy, Debug)]
pub(super) struct Layout {
    pub velocity: usize,
    pub density: usize,
    pub pressure: usize,
    /// Components of the rate of strain, only where noise is damped.
    pub strain: Option<usize>,
    /// Only where there are walls.
    pub image_distance: Option<usize>,
    /// Wall normals, only where a wall is free-slip.
    pub normal: Option<usize>,
    /// Components of T/ρ², only with sub-particle stress.
    pub stress: Option<usize>,
    /// ∇C, then the fluid's volumes, only where its mean is taken from the shift.
    pub crowding: Option<usize>,
    /// All columns, coordinates included.
    pub count: usize,
}

/// What the columns are taken from.
#[derive(Clone, Copy, Debug)]
pub(super) struct Fields<'a, R, const D: usize> {
    pub velocity: &'a [Vec<R>; D],
    /// Density and pressure.
    pub scalars: [&'a [R]; 2],
    pub strain: &'a [Vec<R>; 6],
    pub image_distance: &'a [R],
    pub wall_normal: &'a [Vec<R>; D],
    pub stress: &'a [Vec<R>; 6],
    pub crowding: &'a [Vec<R>; D],
    pub fluid_volume: &'a [R],
}

impl Layout {
    /// Most columns beside the coordinates: velocity, three scalars, strain, normal, stress, and ∇C with volume in 3D.
    pub const MOST_COLUMNS: usize = 3 + 3 + 6 + 3 + 6 + 4;

    /// The columns that every pass has, those of the damping, those of walls and those of the mean shift; `seen`: walls are in the pack and in the
    /// support.
    #[inline(always)]
    pub const fn plain<const D: usize>(damped: bool, walls: bool, net: bool, seen: bool) -> Self {
        let of_flow = 2 * D + 2 + if damped { sps::components(D) } else { 0 };
        let before_net = if walls { of_flow + 1 } else { of_flow };
        Self {
            velocity: D,
            density: 2 * D,
            pressure: 2 * D + 1,
            strain: if damped { Some(2 * D + 2) } else { None },
            image_distance: if walls && seen { Some(of_flow) } else { None },
            normal: None,
            stress: None,
            crowding: if net { Some(before_net) } else { None },
            count: if net { before_net + D + 1 } else { before_net },
        }
    }

    pub fn new<const D: usize>(pair: &PairSettings, has_walls: bool) -> Self {
        let net = !pair.shifting.keeps_drift();
        let mut layout = Self::plain::<D>(pair.noise_damping != 0.0, has_walls, net, true);
        if has_walls && pair.has_free_slip() {
            layout.normal = Some(layout.count);
            layout.count += D;
        }
        if matches!(pair.viscous_term, Viscosity::Sps { .. }) {
            layout.stress = Some(layout.count);
            layout.count += sps::components(D);
        }
        layout
    }

    /// Whether velocities are those that dummy walls show.
    pub fn sees_dummies(&self, pair: &PairSettings) -> bool {
        self.image_distance.is_some() && pair.wall_model == WallModel::Dummy
    }

    /// The columns of a pack after the coordinates, and how many there are.
    pub fn in_order<'a, R, const D: usize>(
        &self,
        fields: Fields<'a, R, D>,
    ) -> ([&'a [R]; Self::MOST_COLUMNS], usize) {
        let of = |columns: &'a [Vec<R>], count: usize| columns.iter().take(count).map(Vec::as_slice);
        let along = |column: Option<usize>| if column.is_some() { D } else { 0 };
        let net = of(fields.crowding, along(self.crowding)).chain(self.crowding.map(|_| fields.fluid_volume));
        let walls = self.image_distance.map(|_| fields.image_distance);
        let strains = of(fields.strain, self.strain_components::<D>());
        let before = of(fields.velocity, D).chain(fields.scalars).chain(strains).chain(walls);
        // The plain columns first: the loop without the others counts on their places.
        let (normals, stresses) =
            (of(fields.wall_normal, along(self.normal)), of(fields.stress, self.stress_components::<D>()));
        let in_order = before.chain(net).chain(normals).chain(stresses);
        let mut neighbours: [&[R]; Self::MOST_COLUMNS] = [&[]; Self::MOST_COLUMNS];
        let mut count = 0;
        for (slot, column) in neighbours.iter_mut().zip(in_order) {
            *slot = column;
            count += 1;
        }
        (neighbours, count)
    }

    /// Components of the rate of strain that are packed.
    pub fn strain_components<const D: usize>(&self) -> usize {
        if self.strain.is_some() { sps::components(D) } else { 0 }
    }

    /// Components of the stress that are packed.
    pub fn stress_components<const D: usize>(&self) -> usize {
        if self.stress.is_some() { sps::components(D) } else { 0 }
    }
}
