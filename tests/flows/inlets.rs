//! Pressure of inflow particles, extrapolated from the fluid.

use sphecs::bevy_ecs::query::With;
use sphecs::glam::DVec3;
use sphecs_engine::components::{Inflow, Position, Thermodynamics};

use crate::flow;

/// Plug flow between frictionless walls, under a pressure that is linear in both directions,
/// oblique to the lattice.
const SLOPE: &str = r#"Scene(
    title: "A plug askew under a slope", dimensions: 2, spacing: 0.01, smoke: 0.01,
    constants: { "angle": 20.0, "c": "cos(angle*pi/180)", "s": "sin(angle*pi/180)", "L": 0.3, "D": 0.16 },
    fluid: (density: 1000.0, viscosity: 1.0e-3, sound_speed: 1.5),
    scheme: EdacTvf(),
    domain: Rotated(angle: "angle", shape: Box(min: (0.0, "-D/2"), max: ("L", "D/2"))),
    fill: Lattice(angle: 0.0),
    walls: (slip: FreeSlip),
    initial: (velocity: ("0.1*c", "0.1*s"), pressure: "1 + 20*x - 30*y"),
    inlets: [(at: (0.0, 0.0), towards: ("c", "s"), velocity: Normal(0.1))],
    outlets: [(at: ("L*c", "L*s"), towards: ("c", "s"), condition: WaveEquation())],
    time: (end: 10.0), output: (every: 1.0),
)"#;

/// Negi et al. (2020), Eq. 22, is first-order consistent: a linear field is exact at the mirror
/// image, also for particles near walls and the plane. A uniform flow without forces needs no
/// additional gradient.
#[test]
fn linear_pressure_is_exact_at_the_mirror_image_of_every_inflow_particle() {
    let mut simulation = flow(SLOPE, &[]);
    simulation.step().expect("a step");
    let inlet = simulation.scene().inlets[0].patch.clone();
    let moved = DVec3::new(0.1, 0.0, 0.0).length() * simulation.clock().time;
    let world = simulation.world_mut();
    let mut query = world.query_filtered::<(&Position, &Thermodynamics), With<Inflow>>();
    let mut count = 0;
    for (position, thermodynamics) in query.iter(world) {
        let image = position.0 - inlet.towards * (2.0 * inlet.along(position.0));
        let expected = 1.0 + 20.0 * image.x - 30.0 * image.y;
        let off = (thermodynamics.pressure - expected).abs();
        // The slope is 36 Pa/m, and both points have moved.
        assert!(off < 40.0 * 2.0 * moved, "{off} Pa of {expected} Pa at {}", position.0);
        count += 1;
    }
    assert!(count > 50, "only {count} inflow particles");
}
