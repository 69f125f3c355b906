//! The programs of `examples/`, run at smoke spacing.

#[expect(dead_code, reason = "the test calls `run`, not `main`")]
#[path = "../examples/own_force.rs"]
mod own_force;
#[expect(dead_code, reason = "the test calls `run`, not `main`")]
#[path = "../examples/sample_fields.rs"]
mod sample_fields;
#[expect(dead_code, reason = "the test calls `run`, not `main`")]
#[path = "../examples/sweep.rs"]
mod sweep;

use sphecs::{Scene, SceneLoader};

fn quickstart() -> SceneLoader {
    Scene::from_file("scenes/quickstart.ron").smoke()
}

#[test]
fn own_force_records_a_growing_inflow() {
    let record = own_force::run(quickstart().load().expect("a scene"), 0.4).expect("a run");
    assert!(record.is_sorted_by(|a, b| a.0 < b.0 && a.1 <= b.1), "{record:?}");
    assert!(record.last().is_some_and(|(time, entered)| *time >= 0.4 && *entered > 0), "{record:?}");
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
