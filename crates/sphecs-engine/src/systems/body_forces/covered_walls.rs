//! Particles of walls at rest that stand behind a body that moves.
//!
//! In the corner between a piston and the wall beside it, the particles diagonally behind the fluid
//! belong to the wall, but they push the fluid away from the piston as well. Without them the force
//! on a piston of 10 particles was 6 % too small (test
//! `force_of_a_piston_includes_its_corners`). A particle counts for a mover that covers the surface
//! in front of it.

use glam::DVec3;

use sphecs_core::particles::arrays::ParticleArrays;
use sphecs_core::particles::rows::real_vector;
use sphecs_core::particles::zone::Zone;
use sphecs_core::pass::pair_real::PairReal;
use sphecs_core::pass::ranks::Ranks;
use sphecs_scene::model::Scene;
use sphecs_scene::movers::{Wall, WallPoses};

/// Distance in front of the surface at which a mover must be, in spacings.
const IN_FRONT: f64 = 0.25;

/// Points in front of the walls at rest that a mover may cover.
#[derive(Debug, Default)]
pub(super) struct CoveredWalls {
    /// Number of each particle and the point in front of its surface, m; in the order of the
    /// numbers.
    points: Vec<(u32, DVec3)>,
    /// Changes of the rank's cells at which the points were found; None until then.
    found_at: Option<u64>,
}

impl CoveredWalls {
    /// Collects the numbers of the particles that a wall part covers in the present poses; none of
    /// a part that is not a mover's.
    pub(super) fn collect<R: PairReal<D>, const D: usize>(
        &mut self,
        (scene, poses): (&Scene, &WallPoses),
        part: u16,
        (arrays, ranks): (&ParticleArrays<R, D>, &Ranks),
        numbers: &mut Vec<u32>,
    ) {
        numbers.clear();
        let Wall::Mover(index) = Wall::of_part(scene, part) else { return };
        let changes = Some(ranks.changes());
        if self.found_at != changes {
            self.found_at = changes;
            self.find(scene, arrays);
        }
        let (mover, pose) = (&scene.movers[index], &poses.movers[index]);
        let (centre, (low, high)) = (pose.place(mover.centre), mover.shape.bounds());
        let is_covered = |point: DVec3| {
            let near = scene.nearest_image(point, centre);
            let reference = pose.reference(near);
            // Bounds first: a distance to a mesh takes some µs.
            reference.cmpge(low).all()
                && reference.cmple(high).all()
                && mover.shape.signed_distance(reference) < 0.0
        };
        numbers.extend(self.points.iter().filter(|(_, point)| is_covered(*point)).map(|(id, _)| *id));
    }

    /// Finds the particles of walls at rest, in a scene of which the casing does not move.
    fn find<R: PairReal<D>, const D: usize>(&mut self, scene: &Scene, arrays: &ParticleArrays<R, D>) {
        if scene.casing_motion.is_some() {
            return;
        }
        let is_at_rest = |row: &usize| {
            arrays.zone[*row] == Zone::Wall && Wall::of_part(scene, arrays.patch[*row]) == Wall::Casing
        };
        let point = |row: usize| {
            let depth = arrays.wall_distance[row].to_f64() + IN_FRONT * scene.spacing;
            (arrays.id[row], arrays.position_of(row) + depth * real_vector(&arrays.wall_normal, row))
        };
        self.points = (0..arrays.len()).filter(is_at_rest).map(point).collect();
        self.points.sort_unstable_by_key(|(id, _)| *id);
    }
}
