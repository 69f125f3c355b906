//! Checks of the paths of movers over the run: speed, walls at rest, other movers, zones of
//! openings, and the volume that they leave to the fluid.

use glam::DVec3;
use rayon::iter::{IntoParallelIterator, IntoParallelRefIterator, ParallelIterator};

use super::consistency::zone_points;
use crate::displaced_flow::CasingGrid;
use crate::faults::Fault;
use crate::fill::{Place, patches, wall_thickness};
use crate::model::Scene;
use crate::movers::{Wall, WallPoses};
use crate::sampled_times::sampled_times;
use crate::schema::SceneFile;
use sphecs_core::format::{point, significant};
use sphecs_core::particles::zone::Zone;

/// Least number of intervals of the run at whose ends places are compared.
const INTERVALS: u32 = 64;

/// Path of a wall between two times, in spacings, where the run has time enough.
const STRIDE: f64 = 4.0;

/// Depth in a mover from which a wall particle at rest counts as overlapped, in spacings: less is
/// the misfit of lattice and surface.
const OVERLAP: f64 = 0.5;

/// Depth in a mover from which a particle of another counts as inside, in spacings.
const CONTACT: f64 = 0.25;

/// Largest relative change of the volume of a closed domain.
const VOLUME_CHANGE: f64 = 0.005;

/// Reports movers that cannot take their path.
pub fn check(scene: &Scene, file: &SceneFile, places: &[Place], faults: &mut Vec<Fault>) {
    if !scene.has_moving_walls() {
        return;
    }
    let before = faults.len();
    speeds(scene, file, faults);
    if faults.len() > before || scene.movers.is_empty() {
        return;
    }
    let end = if scene.time.end.is_finite() { scene.time.end } else { 0.0 };
    let times = compared_times(scene, end);
    let poses: Vec<WallPoses> = times.iter().map(|time| scene.wall_poses(*time)).collect();
    let course = Course { scene, times: &times, poses: &poses };
    zones(&course, file, faults);
    if faults.len() == before {
        overlaps(&course, file, places, faults);
        if faults.len() == before {
            departures(&course, file, places, faults);
        }
        collisions(&course, file, places, faults);
        volume(&course, file, faults);
    }
}

/// Returns the times of a run to `end`, s, at which places are compared: the ends of equal
/// intervals, or, for walls that move far in one of these, times that follow no period.
fn compared_times(scene: &Scene, end: f64) -> Vec<f64> {
    let step = STRIDE * scene.spacing / scene.largest_wall_speed();
    let interval = end / f64::from(INTERVALS);
    if step >= interval {
        return (0..=INTERVALS).map(|at| end * f64::from(at) / f64::from(INTERVALS)).collect();
    }
    let mut times = vec![0.0];
    for time in sampled_times(end) {
        if time >= times[times.len() - 1] + step || time == end {
            times.push(time);
        }
    }
    times
}

/// Poses of the walls at some times of the run.
struct Course<'a> {
    scene: &'a Scene,
    /// Times, s.
    times: &'a [f64],
    poses: &'a [WallPoses],
}

impl Course<'_> {
    /// Returns the depth of a point in a mover in the poses `at`, m; negative outside.
    fn depth(&self, mover: usize, at: usize, place: DVec3) -> f64 {
        let (pose, mover) = (&self.poses[at].movers[mover], &self.scene.movers[mover]);
        let centre = pose.place(mover.centre);
        let near = self.scene.nearest_image(place, centre);
        if near.distance_squared(centre) > mover.radius * mover.radius {
            return f64::NEG_INFINITY;
        }
        -mover.shape.signed_distance(pose.reference(near))
    }

    /// Returns a position as text.
    fn text(&self, place: DVec3) -> String {
        point(&place.to_array()[..self.scene.dimensions], self.scene.spacing)
    }
}

/// Reports walls that are as fast as sound.
fn speeds(scene: &Scene, file: &SceneFile, faults: &mut Vec<Fault>) {
    let (speed, sound) = (scene.largest_wall_speed(), scene.fluid.sound_speed);
    if speed < sound {
        return;
    }
    let label = format!("is {} m/s, but walls move at up to {} m/s", significant(sound), significant(speed));
    let help =
        format!("give a `sound_speed` of {} m/s or more, or slow the motion down", significant(10.0 * speed));
    faults.push(Fault::new("a wall is as fast as sound", file.fluid.sound_speed.span, label).help(help));
}

/// Reports movers that enter the zone of an opening.
fn zones(course: &Course<'_>, file: &SceneFile, faults: &mut Vec<Fault>) {
    let scene = course.scene;
    for (index, mover) in scene.movers.iter().enumerate() {
        for (patch, is_inlet) in patches(scene) {
            let points = zone_points(patch, is_inlet, scene);
            let enters = |at: usize| {
                points.iter().copied().find(|place| course.depth(index, at, *place) > 0.25 * scene.spacing)
            };
            let first = (0..course.times.len()).into_par_iter().find_map_first(|at| Some((at, enters(at)?)));
            if let Some((at, place)) = first {
                let title = format!("the mover `{}` enters the zone of `{}`", mover.name, patch.name);
                let label = format!(
                    "is there at t = {} s near {} m",
                    significant(course.times[at]),
                    course.text(place)
                );
                let help = "keep movers inside the domain, away from openings";
                faults.push(Fault::new(title, file.movers[index].name.span, label).help(help));
            }
        }
    }
}

/// Reports movers that enter a wall at rest next to fluid.
fn overlaps(course: &Course<'_>, file: &SceneFile, places: &[Place], faults: &mut Vec<Fault>) {
    let scene = course.scene;
    let walls: Vec<DVec3> = places
        .iter()
        .filter(|place| place.zone == Zone::Wall && place.patch == 0)
        .map(|place| place.position)
        .collect();
    for (index, mover) in scene.movers.iter().enumerate() {
        let deepest = |at: usize| {
            let depths = walls.par_iter().map(|place| (course.depth(index, at, *place), *place));
            let inside = depths.filter(|(depth, _)| *depth > OVERLAP * scene.spacing);
            let next_to_fluid = inside.filter(|(_, place)| is_next_to_fluid(course, at, *place));
            next_to_fluid.max_by(|a, b| a.0.total_cmp(&b.0))
        };
        if let Some((at, (depth, place))) = (0..course.times.len()).find_map(|at| Some((at, deepest(at)?))) {
            let title = format!("the mover `{}` enters a wall", mover.name);
            let label = format!(
                "is {} m deep in it at t = {} s near {} m, next to fluid",
                significant(depth),
                significant(course.times[at]),
                course.text(place)
            );
            let help = "change shape or motion, or cut its way out of the `domain`; what it covers from the start \
                        to the end of the run may be wall";
            faults.push(Fault::new(title, file.movers[index].name.span, label).help(help));
        }
    }
}

/// Reports movers whose particles go from the fluid into the walls: plates that are too thin to
/// hold particles of a wall.
fn departures(course: &Course<'_>, file: &SceneFile, places: &[Place], faults: &mut Vec<Fault>) {
    let scene = course.scene;
    if scene.casing_motion.is_some() {
        return;
    }
    let behind = |place: DVec3| Wall::Casing.distance(scene, place);
    for (index, mover) in scene.movers.iter().enumerate() {
        let of_mover =
            |place: &&Place| place.zone == Zone::Wall && Wall::numbered(place.patch) == Wall::Mover(index);
        let in_fluid = |place: &&Place| of_mover(place) && behind(place.position) < 0.0;
        let particles: Vec<DVec3> =
            places.iter().filter(in_fluid).map(|place| mover.start.reference(place.position)).collect();
        let gone = |at: usize| {
            let pose = &course.poses[at].movers[index];
            // What the mover covers from the start is no wall: a rod may turn in it.
            let enters =
                |place: DVec3| behind(place) > OVERLAP * scene.spacing && course.depth(index, 0, place) < 0.0;
            let mut placed = particles.iter().map(|particle| pose.place(*particle));
            placed.find(|place| enters(*place) && is_next_to_fluid(course, at, *place))
        };
        let first = (0..course.times.len()).into_par_iter().find_map_first(|at| Some((at, gone(at)?)));
        if let Some((at, place)) = first {
            let title = format!("the mover `{}` enters a wall", mover.name);
            let label = format!(
                "is {} m deep in it at t = {} s near {} m, next to fluid",
                significant(behind(place)),
                significant(course.times[at]),
                course.text(place)
            );
            let help = "change shape or motion, or cut its way out of the `domain`";
            faults.push(Fault::new(title, file.movers[index].name.span, label).help(help));
        }
    }
}

/// Reports movers that run into each other. Those that overlap from the start are parts of one
/// body.
fn collisions(course: &Course<'_>, file: &SceneFile, places: &[Place], faults: &mut Vec<Fault>) {
    let scene = course.scene;
    for (first, mover) in scene.movers.iter().enumerate() {
        let of_mover =
            |place: &&Place| place.zone == Zone::Wall && Wall::numbered(place.patch) == Wall::Mover(first);
        let particles: Vec<DVec3> =
            places.iter().filter(of_mover).map(|place| mover.start.reference(place.position)).collect();
        for second in (0..scene.movers.len()).filter(|second| *second != first) {
            let hit = |at: usize| {
                let pose = &course.poses[at].movers[first];
                let placed = particles.iter().map(|particle| pose.place(*particle));
                placed.into_iter().find(|place| course.depth(second, at, *place) > CONTACT * scene.spacing)
            };
            if hit(0).is_some() {
                continue;
            }
            let found = (1..course.times.len()).into_par_iter().find_map_first(|at| Some((at, hit(at)?)));
            if let Some((at, place)) = found {
                let other = &scene.movers[second].name;
                let title = format!("the mover `{}` runs into `{other}`", mover.name);
                let label = format!(
                    "is in it at t = {} s near {} m",
                    significant(course.times[at]),
                    course.text(place)
                );
                let help = "change shape or motion of one of them; leave three spacings between both";
                faults.push(Fault::new(title, file.movers[first].name.span, label).help(help));
                return;
            }
        }
    }
}

/// Returns true if fluid may be within the support of a wall particle, in the poses `at`.
fn is_next_to_fluid(course: &Course<'_>, at: usize, place: DVec3) -> bool {
    let scene = course.scene;
    let casing = &scene.layout.casing.confines;
    let steps = wall_thickness(scene) / scene.spacing;
    let directions = (0..27).map(|index| {
        let step = |place: i32| f64::from(index / place % 3 - 1);
        DVec3::new(step(1), step(3), if scene.dimensions == 3 { step(9) } else { 0.0 })
    });
    let mut directions = directions.filter(|direction| *direction != DVec3::ZERO);
    directions.any(|direction| {
        (1..=steps as i32).any(|step| {
            let near = place + direction.normalize() * (f64::from(step) * scene.spacing);
            scene.nearest_wall(casing, &course.poses[at], near).0 < 0.0
        })
    })
}

/// Reports movers that change the volume of the fluid in a domain without openings.
fn volume(course: &Course<'_>, file: &SceneFile, faults: &mut Vec<Fault>) {
    let scene = course.scene;
    if !scene.inlets.is_empty() || !scene.outlets.is_empty() {
        return;
    }
    let grid = CasingGrid::new(scene);
    // A volume takes long and changes slowly.
    let stride = course.times.len().div_ceil(INTERVALS as usize + 1);
    let compared: Vec<usize> = (0..course.times.len()).step_by(stride).collect();
    let volumes: Vec<f64> = compared.par_iter().map(|at| grid.free_volume(&course.poses[*at])).collect();
    let change = |volume: f64| (volume / volumes[0] - 1.0).abs();
    let Some(most) = (0..volumes.len()).max_by(|a, b| change(volumes[*a]).total_cmp(&change(volumes[*b])))
    else {
        return;
    };
    if change(volumes[most]) <= VOLUME_CHANGE {
        return;
    }
    // Distances misjudge the volume of thin bodies.
    let [start, changed] = [0, compared[most]].map(|at| grid.sampled_free_volume(&course.poses[at]));
    if (changed / start - 1.0).abs() > VOLUME_CHANGE {
        let unit = if scene.dimensions == 2 { "m²" } else { "m³" };
        let label = format!(
            "leaves the fluid {} {unit} at t = {} s, {} {unit} at the start",
            significant(changed),
            significant(course.times[compared[most]]),
            significant(start)
        );
        faults.push(
            Fault::new("movers change the volume of a closed domain", file.movers[0].name.span, label)
                .help("give the domain an outlet that takes the rest"),
        );
    }
}
