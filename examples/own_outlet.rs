//! Outlet condition of a user, compared with conditions of the engine.
//!
//! An acoustic pulse meets the outlet of a channel. The condition `Impedance` gives the outflow
//! particles the pressure of a plane wave that leaves, so that it transmits the pulse; `DoNothing`
//! reflects much of it. The program prints the reflection coefficient R, the largest incoming over
//! the largest outgoing characteristic upstream of the outlet.
//!
//! ```text
//! cargo run --release --example own_outlet
//! ```

#![expect(clippy::print_stdout, reason = "the program prints its result")]

use std::error::Error;

use serde::{Deserialize, Serialize};
use sphecs::glam::DVec3;
use sphecs::outlet::{OutflowState, OutflowZone, OutletMethod, OutletParameters, PairReal, ParameterFault};
use sphecs::{Plugin, PluginContext, Scene, Simulation};

/// Outlet with the impedance of a channel that continues:
///
/// ```text
/// p_o = p_ref + ½ ((p̄ − p_ref) + ρ0 c0 (v̄ − u)),   du/dt = (v̄ − u)/τ
/// v_o = v̄ + (p̄ − p_o)/(ρ0 c0)
/// ```
///
/// p̄ and v̄ are means over the fluid next to the plane; u is the velocity of the flow without
/// sound.
#[derive(Clone, Debug)]
pub(crate) struct Impedance {
    /// Reference pressure p_ref, Pa.
    pub pressure: f64,
    /// Time τ over which the velocity of the flow is averaged, s.
    pub time: f64,
}

/// State of the condition between steps, which checkpoints contain.
#[derive(Default, Serialize, Deserialize)]
pub(crate) struct ImpedanceMemory {
    /// Velocity u of the flow, m/s; None before the first step.
    flow_velocity: Option<f64>,
}

impl OutletParameters for Impedance {
    fn name(&self) -> &str {
        "Impedance"
    }

    fn faults(&self) -> Vec<ParameterFault> {
        ParameterFault::unless_positive("time", self.time, "s").into_iter().collect()
    }
}

impl OutletMethod for Impedance {
    type Memory = ImpedanceMemory;

    fn apply<R: PairReal<D>, const D: usize>(
        &self,
        zone: &mut OutflowZone<'_, R, D>,
        memory: &mut ImpedanceMemory,
    ) {
        let (normal, impedance, fluid) = (zone.normal(), zone.flow.impedance(), zone.adjacent);
        let flow_velocity = memory.flow_velocity.get_or_insert(fluid.velocity);
        let outgoing = fluid.pressure - self.pressure + impedance * (fluid.velocity - *flow_velocity);
        *flow_velocity += (1.0 - (-zone.time_step / self.time).exp()) * (fluid.velocity - *flow_velocity);
        let pressure = self.pressure + 0.5 * outgoing;
        let speed = fluid.velocity + (fluid.pressure - pressure) / impedance;
        for &row in zone.rows {
            let (velocity, _) = zone.state(row as usize);
            let state = OutflowState { velocity, pressure, speed };
            zone.set(row as usize, state.at_speed(speed, normal));
        }
    }
}

/// Plugin that adds the condition under the name that a scene uses.
pub(crate) struct ImpedanceOutlet;

impl Plugin for ImpedanceOutlet {
    fn build(&self, context: &mut PluginContext<'_>) {
        context.add_outlet("Impedance", Impedance { pressure: 0.0, time: 5.0 });
    }
}

/// Returns `scenes/acoustic_pulse.ron` at its smoke spacing with an outlet condition in scene
/// notation.
pub(crate) fn scene(condition: &str) -> Result<Scene, Box<dyn Error>> {
    let pulse = Scene::from_file("scenes/acoustic_pulse.ron").smoke();
    Ok(pulse.set("outlets.0.condition", condition).load()?)
}

/// Returns the reflection coefficient of an outlet condition in scene notation.
pub(crate) fn reflection(condition: &str) -> Result<f64, Box<dyn Error>> {
    let scene = scene(condition)?;
    let impedance = scene.fluid.density * scene.fluid.sound_speed;
    let stream = scene.reference_velocity;
    // Five pulse widths upstream of the outlet.
    let probe = [DVec3::new(3.0, 0.0, 0.0)];
    let mut simulation = Simulation::builder(scene).plugin(ImpedanceOutlet).build()?;
    let (mut outgoing, mut incoming) = (0.0_f64, 0.0_f64);
    while simulation.clock().time < 0.38 {
        simulation.step()?;
        for sample in simulation.sample(&probe).into_iter().flatten() {
            let wave = impedance * (sample.velocity.x - stream);
            outgoing = outgoing.max((sample.pressure + wave).abs());
            incoming = incoming.max((sample.pressure - wave).abs());
        }
    }
    Ok(incoming / outgoing)
}

fn main() -> Result<(), Box<dyn Error>> {
    for condition in ["Custom(\"Impedance\")", "WaveEquation()", "DoNothing"] {
        println!("{condition}: R = {:.3}", reflection(condition)?);
    }
    Ok(())
}
