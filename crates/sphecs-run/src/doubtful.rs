//! Notes of `sphecs check` on choices of a scene that are valid and seldom meant: kernels far from
//! the usual size, walls that move into the fluid, emitters at the side of their solid, and inflows
//! that leave or pulsate faster than sound can follow.

use std::f64::consts::TAU;

use sphecs_core::format::{point, significant, with_digits};
use sphecs_core::particles::zone::Zone;
use sphecs_core::physics::wall::Slip;
use sphecs_scene::emitters::bare_side;
use sphecs_scene::flow_path::FlowPath;
use sphecs_scene::model::{Emitter, Inlet, ParticleSeed, Scene};

/// Usual range of h/Δ.
const USUAL_RATIO: [f64; 2] = [1.2, 2.2];

/// Largest 2π f L/c0 of a pulsation, the phase by which its far end lags behind, rad.
const LARGEST_PHASE: f64 = 0.3;

/// Least difference of the extremes of a pulsation over the largest speed. Smaller ones are
/// disturbances that a scene adds to its inflow.
const LEAST_PULSATION: f64 = 0.1;

/// Component of a velocity normal to its wall over the speed from which it counts.
const NORMAL_SHARE: f64 = 0.3;

/// Number of intervals in which an inflow is sampled, and largest number of points of its section.
const TIMES: usize = 2000;
const POINTS: usize = 40;

/// Returns the notes on a scene with its initial particles and a run to `until`, s.
pub(crate) fn notes(
    scene: &Scene,
    seeds: &[ParticleSeed],
    until: f64,
    path: Option<&FlowPath>,
) -> Vec<String> {
    let mut notes: Vec<String> = kernel_note(scene).into_iter().collect();
    notes.extend(wall_function_note(scene));
    notes.extend(field_spacing_note(scene));
    notes.extend(wall_velocity_notes(scene, seeds, until));
    notes.extend(scene.emitters.iter().filter_map(|emitter| emitter_note(scene, emitter)));
    for inlet in &scene.inlets {
        let flow = Inflow::sampled(scene, inlet, until);
        notes.extend(flow.outward_note(inlet));
        notes.extend(path.and_then(|path| flow.pulsation_note(scene, inlet, path.length)));
    }
    notes
}

fn emitter_note(scene: &Scene, emitter: &Emitter) -> Option<String> {
    bare_side(scene, emitter).map(|place| {
        format!(
            "the emitter `{}` has fluid beside its inflow zone near {} m, which feels the inflow through the side of the \
             solid: keep the emitter two spacings from its edges",
            emitter.name,
            point(&place.to_array()[..scene.dimensions], scene.spacing)
        )
    })
}

fn kernel_note(scene: &Scene) -> Option<String> {
    let ratio = scene.discretisation.smoothing_length / scene.spacing;
    let [least, most] = USUAL_RATIO;
    let effect = match ratio {
        ratio if ratio < least - 1e-9 => "with too few neighbours the sums are inexact and noisy",
        ratio if ratio > most + 1e-9 => {
            "more neighbours cost time and smooth the flow over a larger distance"
        }
        _ => return None,
    };
    Some(format!(
        "the smoothing length is {} Δ, {least} to {most} Δ is usual: {effect}; leave `smoothing_ratio` out for its default",
        significant(ratio)
    ))
}

/// Spacing of gridded fields over that of the particles below which nodes only interpolate.
const LEAST_FIELD_SPACING: f64 = 0.5;

fn field_spacing_note(scene: &Scene) -> Option<String> {
    let spacing = scene.output.fields.as_ref()?.spacing;
    (spacing < LEAST_FIELD_SPACING * scene.spacing).then(|| {
        format!(
            "the spacing of the gridded fields is {} Δ: nodes closer than particles only interpolate between them; leave \
             `output.fields.spacing` out for that of the particles",
            significant(spacing / scene.spacing)
        )
    })
}

fn wall_function_note(scene: &Scene) -> Option<String> {
    let has_law = scene.walls.parts.iter().any(|part| part.slip == Slip::WallFunction);
    (has_law && !scene.scheme.has_stress()).then(|| {
        "`WallFunction` is the friction of a turbulent boundary layer, the fluid has no model of turbulence: take \
         `viscosity: Sps()` of `Wcsph` with it, or `NoSlip` where the spacing resolves the layer"
            .to_owned()
    })
}

/// Returns a note for each wall part that moves into or out of the fluid. The wall particles stay
/// in their places, so such a wall is porous.
fn wall_velocity_notes(scene: &Scene, seeds: &[ParticleSeed], until: f64) -> Vec<String> {
    let moving = scene.walls.parts.iter().enumerate().filter(|(_, part)| part.moves());
    let note = |(index, part): (usize, &sphecs_scene::model::WallPart)| {
        let at_surface = |seed: &&ParticleSeed| {
            seed.zone == Zone::Wall && usize::from(seed.patch) == index && seed.wall_distance < scene.spacing
        };
        let (mut all, mut normal) = (0, 0);
        for seed in seeds.iter().filter(at_surface) {
            let surface = seed.position + seed.wall_distance * seed.wall_normal;
            for time in [0.0, 0.37 * until, until] {
                let velocity = part.velocity_at(surface, time);
                if velocity.length() > 0.0 {
                    all += 1;
                    let across = velocity.dot(seed.wall_normal).abs();
                    normal += usize::from(across > NORMAL_SHARE * velocity.length());
                }
            }
        }
        // At the corners of a sliding lid the nearest surface is that of the side walls.
        (4 * normal > all).then(|| {
            format!(
                "the velocity of the wall part `{}` has a component normal to the wall at {} % of its surface: a wall \
                 slides along itself and stays in its place; an opening lets fluid through",
                part.name,
                with_digits(100.0 * normal as f64 / all as f64, 2)
            )
        })
    };
    moving.filter_map(note).collect()
}

/// Mean velocity into the domain through an inlet, at even times of a run.
struct Inflow {
    velocities: Vec<f64>,
    interval: f64,
}

impl Inflow {
    fn sampled(scene: &Scene, inlet: &Inlet, until: f64) -> Self {
        let all = inlet.section_points(scene, POINTS);
        let points: Vec<_> = all.iter().copied().step_by(all.len().div_ceil(POINTS).max(1)).collect();
        let interval = if until.is_finite() { until / TIMES as f64 } else { 0.0 };
        let velocity = |index: usize| {
            let time = index as f64 * interval;
            inlet.volume_flow(scene.fluid.viscosity, &points, time) / inlet.patch.area
        };
        Self { velocities: (0..=TIMES).map(velocity).collect(), interval }
    }

    fn outward_note(&self, inlet: &Inlet) -> Option<String> {
        let mean = self.velocities.iter().sum::<f64>() / self.velocities.len() as f64;
        (mean < 0.0).then(|| {
            format!(
                "{}: the flow is {} m/s on average over the run, out of the domain: a positive `Normal` is along \
                 `towards`, into the domain; fluid leaves through outlets",
                inlet.patch.name,
                significant(mean)
            )
        })
    }

    fn pulsation_note(&self, scene: &Scene, inlet: &Inlet, length: f64) -> Option<String> {
        let frequency = self.frequency()?;
        let per_sound_speed = TAU * frequency * length;
        let phase = per_sound_speed / scene.fluid.sound_speed;
        (phase > LARGEST_PHASE).then(|| {
            format!(
                "{}: the inflow pulsates with about {} Hz, and sound passes {} m in {} s: 2π f L/c0 = {}, {LARGEST_PHASE} \
                 or less is wanted unless sound is the subject: `fluid.sound_speed` of at least {} m/s",
                inlet.patch.name,
                with_digits(frequency, 2),
                significant(length),
                with_digits(length / scene.fluid.sound_speed, 2),
                with_digits(phase, 2),
                with_digits(per_sound_speed / LARGEST_PHASE, 2)
            )
        })
    }

    /// Returns the frequency of an inflow that turns at least three times, 1/s.
    fn frequency(&self) -> Option<f64> {
        let range = |start: (f64, f64), value: &f64| (start.0.min(*value), start.1.max(*value));
        let (low, high) = self.velocities.iter().fold((f64::INFINITY, f64::NEG_INFINITY), range);
        if (high - low).is_nan() || high - low <= LEAST_PULSATION * low.abs().max(high.abs()) {
            return None;
        }
        // Smaller turns are noise of a table.
        let least = 0.1 * (high - low);
        let (mut turns, mut direction) = (Vec::new(), 0.0);
        let mut extreme = (0, self.velocities[0]);
        for (index, &velocity) in self.velocities.iter().enumerate() {
            let change = velocity - extreme.1;
            if change * direction >= 0.0 && change.abs() > 0.0 && direction != 0.0 {
                extreme = (index, velocity);
            } else if change.abs() > least {
                if direction != 0.0 {
                    turns.push(extreme.0);
                }
                direction = change.signum();
                extreme = (index, velocity);
            }
        }
        let [first, .., last] = turns.as_slice() else { return None };
        (turns.len() >= 3).then(|| (turns.len() - 1) as f64 / (2.0 * (last - first) as f64 * self.interval))
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use sphecs_scene::flow_path::flow_path;

    fn notes_of(scene: &str, sets: &[(&str, &str)]) -> String {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes").join(scene);
        let scene = Scene::from_file(&path).sets(sets).smoke().load().expect("a scene");
        let seeds = sphecs_scene::seeds(&scene);
        notes(&scene, &seeds, scene.time.end, flow_path(&scene, &seeds).as_ref()).join("\n")
    }

    #[test]
    fn usual_choices_have_no_notes() {
        // A start is no pulsation, and a lid slides along itself.
        for scene in ["quickstart.ron", "couette.ron", "step.ron", "../assets/templates/cavity.ron"] {
            assert_eq!(notes_of(scene, &[]), "", "{scene}");
        }
    }

    #[test]
    fn kernels_far_from_the_usual_size_are_noted() {
        let ratio = |ratio| notes_of("quickstart.ron", &[("scheme.smoothing_ratio", ratio)]);
        assert!(ratio("0.9").contains("0.9 Δ") && ratio("4.0").contains("cost time"));
        assert_eq!([ratio("1.2"), ratio("2.2")], ["", ""]);
    }

    #[test]
    fn law_of_the_wall_wants_a_model_of_turbulence() {
        let slip = ("walls.slip", "WallFunction");
        assert!(notes_of("quickstart.ron", &[slip]).contains("`viscosity: Sps()`"));
        assert_eq!(notes_of("quickstart.ron", &[slip, ("scheme.viscosity", "Sps()")]), "");
    }

    #[test]
    fn wall_that_moves_into_the_fluid_is_noted() {
        let into = notes_of("quickstart.ron", &[("walls.velocity", "(0.0, 0.1)")]);
        assert!(into.contains("wall part `walls`") && into.contains("normal to the wall"), "{into}");
        let turned = notes_of("quickstart.ron", &[("walls.velocity", "(\"-y\", \"x\")")]);
        assert!(turned.contains("normal to the wall"), "{turned}");
    }

    #[test]
    fn inflow_that_leaves_or_pulsates_too_fast_is_noted() {
        let flow = |speed: &str| notes_of("quickstart.ron", &[("inlets.0.velocity", speed)]);
        let out = flow("Normal(-0.1)");
        assert!(out.contains("inlet 0: the flow is -0.1 m/s on average"), "{out}");
        // L = 0.2 m, c0 = 2 m/s: 2π f L/c0 = 0.63 f s.
        assert_eq!(flow("Normal(\"0.1*(1 + 0.5*sin(2*pi*0.2*t))\")"), "");
        let fast = flow("Normal(\"0.1*(1 + 0.5*sin(2*pi*5*t))\")");
        assert!(fast.contains("about 5 Hz") && fast.contains("2π f L/c0 = 3.2"), "{fast}");
        // Turns back and is an inflow on average.
        assert!(!flow("Normal(\"0.1*(0.2 + sin(2*pi*5*t))\")").contains("on average"));
    }
}
