//! Density by summation.
//!
//! ```text
//! ρ_a = (m/S0) Σ_b W_ab,   a itself included
//! ```
//!
//! Alvarado-Rodríguez et al. (2017), Eq. 9, over fluid, walls, inflow and outflow, divided by the
//! lattice sum S0 = Σ Δ^D W: without it a uniform fill starts with the pressure of the sum's error,
//! hundreds of Pa.

/// Density, kg/m³, of a kernel sum Σ W (1/m^D) for particles of mass `mass` (kg) and lattice sum
/// `lattice_sum`.
#[inline(always)]
pub fn from_kernel_sum(sum: f64, mass: f64, lattice_sum: f64) -> f64 {
    sum * mass / lattice_sum
}
