//! Density by summation.
//!
//! ```text
//! ρ_a = (m/S0) Σ_b W_ab,   a itself included
//! ```
//!
//! This is Eq. 9 of Alvarado-Rodríguez et al. (2017), over fluid, walls, inflow and outflow,
//! divided by the lattice sum S0 = Σ Δ^D W. Without S0 the error of the sum gives a uniform fill a
//! pressure of hundreds of Pa.

/// Returns the density, kg/m³, from a kernel sum Σ W (1/m^D), the mass of a particle (kg) and the
/// lattice sum S0.
#[inline(always)]
pub fn from_kernel_sum(sum: f64, mass: f64, lattice_sum: f64) -> f64 {
    sum * mass / lattice_sum
}
