//! Settings of the pair passes: the properties of a scene that they need, as plain values.

use std::sync::Arc;

use super::ranks::Ranks;
use crate::discretisation::Discretisation;
use crate::math::lanes::InstructionSet;
use crate::math::lattice::LatticeSums;
use crate::particles::zone::Zone;
use crate::physics::edac::Edac;
use crate::physics::eos::Tait;
use crate::physics::shifting::Shifting;
use crate::physics::viscosity::Viscosity;
use crate::physics::wall::WallModel;

/// Settings of the pair passes. [`PairSettings::new`] returns the defaults of a scene; the rest is
/// set by field.
#[derive(Clone, Debug)]
pub struct PairSettings {
    /// Kernel, spacing, smoothing length, support and mass.
    pub discretisation: Discretisation,
    /// Sums on the initial lattice.
    pub lattice: LatticeSums,
    /// Equation of state.
    pub tait: Tait,
    /// Origin of the pressure of the fluid.
    pub pressure: PressureLaw,
    /// Kinematic viscosity ν, m²/s.
    pub viscosity: f64,
    /// Viscous term.
    pub viscous_term: Viscosity,
    /// α of the noise damping, dimensionless; 0: none.
    pub noise_damping: f64,
    /// Shifting method, which decides the vector that is summed.
    pub shifting: Shifting,
    /// True if p_b − p_a takes the place of p_a + p_b where p_a < 0 and the support is full.
    pub tensile_control: bool,
    /// Treatment of walls in the sums.
    pub wall_model: WallModel,
    /// Body force per mass, m/s², if it is uniform: for the hydrostatic part of a mirrored wall
    /// pressure.
    pub body_force: [f64; 3],
    /// Wall parts, by the patch index of their rows.
    pub wall_parts: Arc<[WallPartSettings]>,
    /// Instruction set of the passes.
    pub lanes: InstructionSet,
    /// Ranks that share the passes.
    pub ranks: Ranks,
}

/// Origin of the pressure of the fluid, and with it the scheme of the sums.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum PressureLaw {
    /// From the summed density, by Tait's equation.
    #[default]
    Tait,
    /// From an evolution equation of its own.
    Evolved(Edac),
}

/// A wall part as the pair passes see it. Parts that are not listed are no-slip and at rest.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct WallPartSettings {
    /// True if pairs with the part exert no viscous force.
    pub free_slip: bool,
    /// True if the part takes the stress of the law of the wall.
    pub wall_function: bool,
}

impl PairSettings {
    /// Returns the settings for work that the members of a region of the ranks share; None on one
    /// rank alone.
    #[must_use]
    pub fn of_region(&self, region: Option<usize>) -> Self {
        Self { ranks: self.ranks.of_region(region), ..self.clone() }
    }

    /// Returns the settings of an inviscid fluid with Fickian shifting, tensile control, image
    /// walls without a cap and no body force.
    pub fn new(discretisation: &Discretisation, tait: Tait) -> Self {
        let Discretisation { kernel, dimensions, smoothing_ratio, .. } = *discretisation;
        Self {
            discretisation: *discretisation,
            lattice: LatticeSums::new(kernel, smoothing_ratio, dimensions),
            tait,
            pressure: PressureLaw::default(),
            viscosity: 0.0,
            viscous_term: Viscosity::default(),
            noise_damping: 0.0,
            shifting: Shifting::default(),
            tensile_control: true,
            wall_model: WallModel::default(),
            body_force: [0.0; 3],
            wall_parts: Arc::default(),
            lanes: InstructionSet::best(),
            ranks: Ranks::default(),
        }
    }

    /// Returns ν of the Lo–Shao sum, m²/s: divided by the lattice coefficient if the scene says so.
    pub fn pair_viscosity(&self) -> f64 {
        if let PressureLaw::Evolved(edac) = self.pressure {
            return self.viscosity / self.edac_coefficient(&edac);
        }
        self.viscous_term.pair_viscosity(self.viscosity, &self.lattice)
    }

    /// Returns the lattice coefficient by which the viscous sums of `EdacTvf` are divided,
    /// dimensionless.
    pub fn edac_coefficient(&self, edac: &Edac) -> f64 {
        match (edac.lattice_normalised, edac.as_published) {
            (true, true) => self.lattice.viscosity_printed,
            (true, false) => self.lattice.viscosity,
            (false, _) => 1.0,
        }
    }

    /// Returns the density of a wall, inflow or outflow particle of a given pressure (Pa), kg/m³;
    /// None if it does not follow from the pressure.
    pub fn density_at(&self, pressure: f64) -> Option<f64> {
        match self.pressure {
            PressureLaw::Tait => Some(self.tait.density(pressure)),
            PressureLaw::Evolved(_) => None,
        }
    }

    /// Returns true if the density of a zone's particles is summed.
    #[inline(always)]
    pub fn sums_density(&self, zone: Zone) -> bool {
        match (self.pressure, zone) {
            (_, Zone::Fluid) => true,
            (PressureLaw::Evolved(_), Zone::Inflow | Zone::Outflow) => true,
            (_, Zone::Inflow | Zone::Outflow | Zone::Wall | Zone::Reservoir) => false,
        }
    }

    /// Returns a wall part by the patch index of its rows.
    pub fn wall_part(&self, patch: u16) -> WallPartSettings {
        self.wall_parts.get(usize::from(patch)).copied().unwrap_or_default()
    }

    /// Returns true if any part of the wall takes the stress of the law of the wall.
    pub fn has_wall_function(&self) -> bool {
        self.wall_parts.iter().any(|part| part.wall_function)
    }

    /// Returns true if any part of the wall is free-slip.
    pub fn has_free_slip(&self) -> bool {
        self.wall_parts.iter().any(|part| part.free_slip)
    }
}
