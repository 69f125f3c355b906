//! The programs of `examples/`, run at smoke spacing.

#[expect(dead_code, reason = "the test calls `run`, not `main`")]
#[path = "../examples/own_force.rs"]
mod own_force;
#[expect(dead_code, reason = "the test calls `reflection`, not `main`")]
#[path = "../examples/own_outlet.rs"]
mod own_outlet;
#[expect(dead_code, reason = "the test calls `run`, not `main`")]
#[path = "../examples/sample_fields.rs"]
mod sample_fields;
#[expect(dead_code, reason = "the test calls `run`, not `main`")]
#[path = "../examples/sweep.rs"]
mod sweep;

use sphecs::glam::DVec3;
use sphecs::{
    AddedForces, ParticleState, Plugin, PluginContext, Scene, SceneLoader, Simulation, SimulationBuilder,
};

fn quickstart() -> SceneLoader {
    Scene::from_file("scenes/quickstart.ron").smoke()
}

#[test]
fn own_force_records_a_growing_inflow() {
    let record = own_force::run(quickstart().load().expect("a scene"), 0.4).expect("a run");
    assert!(record.is_sorted_by(|a, b| a.0 < b.0 && a.1 <= b.1), "{record:?}");
    assert!(record.last().is_some_and(|(time, entered)| *time >= 0.4 && *entered > 0), "{record:?}");
}

/// Porous plug of the tutorial on own forces.
struct PorousPlug {
    /// Rate of the drag, 1/s.
    rate: f64,
}

impl Plugin for PorousPlug {
    fn build(&self, context: &mut PluginContext<'_>) {
        let rate = self.rate;
        // The markers name the lines that the tutorial shows.
        #[rustfmt::skip]
        // ANCHOR: drag
let force = move |particle: &ParticleState| {
    let inside = particle.position.x > 0.12 && particle.position.x < 0.16;
    if inside { -rate * particle.velocity } else { DVec3::ZERO }
};
        // ANCHOR_END: drag
        context.world.get_resource_or_init::<AddedForces>().add(force);
    }
}

#[test]
fn porous_plug_raises_the_pressure_upstream() {
    let pressure = |rate: f64| {
        let scene = quickstart().load().expect("a scene");
        let mut simulation =
            Simulation::builder(scene).plugin(PorousPlug { rate }).build().expect("a simulation");
        simulation.run_until(0.6).expect("a run");
        let at = [DVec3::new(0.1, 0.0, 0.0)];
        simulation.sample(&at)[0].expect("fluid").pressure
    };
    let (free, plugged) = (pressure(0.0), pressure(50.0));
    assert!(plugged > free + 20.0, "{plugged} Pa with the plug, {free} Pa without");
}

#[test]
fn sampled_profile_is_fastest_between_the_walls() {
    let profile = sample_fields::run(quickstart().load().expect("a scene"), 0.4).expect("a run");
    let speed = |at: usize| profile[at].1.map_or(0.0, |sample| sample.velocity.x);
    let (wall, centre) = (speed(1), speed(profile.len() / 2));
    assert!(centre > wall && centre > 0.02, "{centre} m/s at the centre, {wall} m/s at the wall");
}

#[test]
fn sweep_has_a_result_for_each_viscosity() {
    let speeds = sweep::run(&quickstart(), 0.2).expect("a sweep");
    assert_eq!(speeds.len(), sweep::VISCOSITIES.len());
    assert!(speeds.iter().all(|speed| *speed > 0.0), "{speeds:?}");
    assert!(speeds.windows(2).all(|pair| pair[0] != pair[1]), "{speeds:?}");
}

#[test]
fn own_outlet_transmits_the_pulse_that_another_reflects() {
    let reflection = |condition| own_outlet::reflection(condition).expect("a run");
    let (own, reflecting) = (reflection("Custom(\"Impedance\")"), reflection("DoNothing"));
    // A plane wave is transmitted; the mean over disordered layers leaves some percent.
    assert!(own < 0.1 && reflecting > 3.0 * own, "R = {own} and {reflecting}");
}

#[test]
fn a_run_with_an_own_outlet_resumes_bitwise() {
    let scene = || own_outlet::scene("Custom(\"Impedance\")").expect("a scene");
    let build = |builder: SimulationBuilder| {
        builder.plugin(own_outlet::ImpedanceOutlet).build().expect("a simulation")
    };
    let mut whole = build(Simulation::builder(scene()));
    (0..40).for_each(|_| whole.step().expect("a step"));
    let mut resumed = build(Simulation::builder(scene()).state(whole.state()));
    for _ in 0..20 {
        whole.step().expect("a step");
        resumed.step().expect("a step");
    }
    assert!(whole.state() == resumed.state(), "the resumed run differs");
}

#[test]
fn an_outlet_that_no_plugin_adds_is_an_error_with_those_added() {
    let build = |builder: SimulationBuilder| builder.build().err().expect("an error").to_string();
    let scene = |name: &str| own_outlet::scene(&format!("Custom(\"{name}\")")).expect("a scene");
    let none = build(Simulation::builder(scene("Impedance")));
    assert!(none.contains("`Impedance`, added are: none"), "{none}");
    let other = build(Simulation::builder(scene("Sponge")).plugin(own_outlet::ImpedanceOutlet));
    assert!(other.contains("`Sponge`, added are: `Impedance`"), "{other}");
}
