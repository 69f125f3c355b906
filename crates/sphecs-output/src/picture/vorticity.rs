//! Vorticity of a frame's particles by moving least squares.
//!
//! ```text
//! G_a = (Σ_b w_ab v_ba ⊗ x_ba) (Σ_b w_ab x_ba ⊗ x_ba)⁻¹,   w = (1 − r/2h)⁴ (1 + 2r/h)   inside 2h
//! ω = (G_zy − G_yz, G_xz − G_zx, G_yx − G_xy)
//! ```
//!
//! G minimises Σ_b w_ab |v_ba − G x_ba|² and is exact for a linear velocity field with any particle
//! disorder, so walls and voids cause no false shear. The weight is Wendland's C2 kernel without
//! its normalisation, which cancels. Wall particles are excluded.

use glam::{DMat3, DVec3};
use rayon::iter::{IntoParallelIterator, ParallelIterator};

use super::view::{Cells, View};
use crate::frame::Frame;
use sphecs_core::particles::zone::Zone;

/// Returns the vorticity by slot, 1/s: ω_z in 2D, |ω| in 3D; NaN outside the view, for walls and
/// without neighbours.
pub(super) fn vorticity(frame: &Frame, view: &View) -> Vec<f32> {
    let reach = 2.0 * view.smoothing_length.max(view.spacing);
    let moving =
        |slot: &usize| frame.zone[*slot] <= Zone::Outflow as u8 && frame.zone[*slot] != Zone::Wall as u8;
    // Particles that may be neighbours of a drawn one.
    let slab = if view.is_whole { f64::INFINITY } else { reach + 2.0 * view.spacing };
    let is_near = |slot: &usize| {
        let place = view.place(frame, *slot);
        place[2].abs() <= slab && (view.is_whole || view.is_near(place, slab))
    };
    let slots: Vec<usize> = (0..frame.len()).filter(moving).filter(is_near).collect();
    let places: Vec<[f64; 3]> = slots.iter().map(|&slot| view.place(frame, slot)).collect();
    let cells = Cells::new(view, reach, &places);
    let vector = |slot: usize| DVec3::from_array([0, 1, 2].map(|axis| f64::from(frame.velocity[axis][slot])));
    let position = |slot: usize| DVec3::from_array([0, 1, 2].map(|axis| frame.position[axis][slot]));
    let curls: Vec<f32> = (0..slots.len())
        .into_par_iter()
        .map(|a| {
            let (x_a, v_a) = (position(slots[a]), vector(slots[a]));
            let mut moment = DMat3::ZERO;
            let mut slope = DMat3::ZERO;
            for b in cells.near(places[a][0], places[a][1]) {
                let x_ba = position(slots[b]) - x_a;
                let q = x_ba.length() / reach;
                if q < 1.0 {
                    let weight = (1.0 - q).powi(4) * (1.0 + 4.0 * q);
                    // The columns of a tensor product are scaled by the second factor.
                    let row = x_ba * weight;
                    moment += DMat3::from_cols(x_ba * row.x, x_ba * row.y, x_ba * row.z);
                    let v_ba = vector(slots[b]) - v_a;
                    slope += DMat3::from_cols(v_ba * row.x, v_ba * row.y, v_ba * row.z);
                }
            }
            curl(slope, moment, view) as f32
        })
        .collect();
    let mut result = vec![f32::NAN; frame.len()];
    for (&slot, curl) in slots.iter().zip(curls) {
        result[slot] = curl;
    }
    result
}

fn curl(slope: DMat3, mut moment: DMat3, view: &View) -> f64 {
    if view.dimensions == 2 {
        moment.z_axis.z = 1.0;
    }
    let size = view.spacing.powi(2 * view.dimensions as i32);
    // Fewer than two (in 3D three) neighbours in different directions determine no gradient.
    if moment.determinant() < 1e-6 * size {
        return f64::NAN;
    }
    let gradient = slope * moment.inverse();
    let [of_x, of_y, of_z] = [gradient.x_axis, gradient.y_axis, gradient.z_axis];
    let omega = DVec3::new(of_y.z - of_z.y, of_z.x - of_x.z, of_x.y - of_y.x);
    if view.dimensions == 2 { omega.z } else { omega.length() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::header::Header;

    /// Returns a disordered block in solid rotation about an axis with a shear on top, so that ω is
    /// uniform.
    fn rotating(dimensions: usize, omega: DVec3) -> (Frame, View) {
        let layers = if dimensions == 3 { 8 } else { 1 };
        let mut frame = Frame::absent(12 * 12 * layers);
        for slot in 0..frame.len() {
            let jitter = |k: usize| 0.2 * ((slot * k % 17) as f64 / 17.0 - 0.5);
            let mut x = DVec3::new((slot % 12) as f64 + jitter(5), (slot / 12 % 12) as f64 + jitter(7), 0.0);
            if dimensions == 3 {
                x.z = (slot / 144) as f64 + jitter(3);
            }
            let v = 0.5 * omega.cross(x) + DVec3::new(0.3 * x.x, -0.3 * x.y, 0.0);
            frame.zone[slot] = 0;
            for axis in 0..3 {
                frame.position[axis][slot] = x[axis];
                frame.velocity[axis][slot] = v[axis] as f32;
            }
        }
        let header = Header {
            dimensions,
            spacing: 1.0,
            smoothing_length: 1.5,
            bounds: frame.bounds().expect("particles"),
            ..Header::default()
        };
        let view = View::new(&header, None).expect("a view");
        (frame, view)
    }

    #[test]
    fn solid_rotation_has_its_vorticity_up_to_the_edge() {
        for (dimensions, omega, wanted) in
            [(2, DVec3::new(0.0, 0.0, -3.0), -3.0), (3, DVec3::new(2.0, -1.0, 2.0), 3.0)]
        {
            let (frame, view) = rotating(dimensions, omega);
            for (slot, value) in vorticity(&frame, &view).into_iter().enumerate() {
                // Velocities are stored in f32: 30 m/s over 1 m is known to 1e-5.
                assert!(
                    value.is_nan() && dimensions == 3 || (value - wanted).abs() < 1e-4,
                    "slot {slot}: {value}"
                );
            }
        }
    }

    #[test]
    fn particle_without_neighbours_has_none() {
        let (mut frame, view) = rotating(2, DVec3::Z);
        frame.zone[1..].fill(4);
        assert!(vorticity(&frame, &view)[0].is_nan());
    }
}
