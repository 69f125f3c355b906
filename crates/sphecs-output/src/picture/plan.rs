//! Picture of a scene before it runs: zones, walls, openings and probes with their names.

use std::path::Path;

use glam::DVec3;

use super::painter::Painter;
use super::{Field, RenderOptions};
use crate::drawing::{Anchor, Drawing, Weight, text_width};
use crate::error::OutputError;
use crate::frame::Frame;
use crate::header::{Header, InitialParticles};
use sphecs_core::boundary::patch::Patch;
use sphecs_core::particles::zone::Zone;
use sphecs_scene::geometry::measure::exit_distance;
use sphecs_scene::model::{ParticleSeed, ProbeKind, Scene};

/// Colour of openings.
const OPENING: [u8; 3] = [0xc2, 0x2f, 0x4c];

/// Colour of probes.
const PROBE: [u8; 3] = [0x22, 0x26, 0x2b];

/// Length of the arrows of openings, text heights.
const ARROW: f64 = 2.2;

/// Draws the particles of a scene by their zone, with openings and probes, into a PNG file.
///
/// In 3D it is the slice of the options; openings and probes within two spacings of it are drawn.
///
/// # Errors
/// [`OutputError`] when the slice does not meet the domain or the file cannot be written.
pub fn render_plan(
    scene: &Scene,
    seeds: &[ParticleSeed],
    options: &RenderOptions,
    path: &Path,
) -> Result<(), OutputError> {
    let options = RenderOptions { field: Field::Zone, ..options.clone() };
    let frame = frame_of(seeds);
    let header = Header::new(scene, &InitialParticles::of_frame(&frame));
    let mut painter = Painter::new(&header, &options)?;
    let drawing = painter.draw(&frame);
    let mut plan = Plan { drawing, painter: &painter, labels: Vec::new() };
    for inlet in &scene.inlets {
        plan.opening(&inlet.patch);
    }
    for outlet in &scene.outlets {
        plan.opening(&outlet.patch);
    }
    for probe in &scene.output.probes {
        plan.probe(&probe.name, &probe.kind, scene);
    }
    plan.write_labels();
    plan.drawing.save(path)
}

/// Returns the frame of the initial particles.
fn frame_of(seeds: &[ParticleSeed]) -> Frame {
    let mut frame = Frame::absent(seeds.len());
    for (slot, seed) in seeds.iter().enumerate().filter(|(_, seed)| seed.zone != Zone::Reservoir) {
        for (column, coordinate) in frame.position.iter_mut().zip(seed.position.to_array()) {
            column[slot] = coordinate;
        }
        frame.zone[slot] = seed.zone as u8;
        frame.patch[slot] = seed.patch;
    }
    frame
}

/// A picture with marks, whose labels are written last.
struct Plan<'a, 'b> {
    drawing: Drawing,
    painter: &'b Painter<'a>,
    /// Text, and the point that it names, pixels.
    labels: Vec<(String, [f64; 2])>,
}

impl Plan<'_, '_> {
    /// Returns the pixel of a point, and its distance from the plane of the picture, m.
    fn pixel(&self, point: DVec3) -> ([f64; 2], f64) {
        let (view, sheet) = (&self.painter.view, &self.painter.sheet);
        let [right, up, across] = view.axes.map(|axis| point[axis]);
        let scale = sheet.size[0] as f64 / view.extent()[0];
        let [x, y] = sheet.corner.map(|corner| corner as f64);
        ([x + (right - view.low[0]) * scale, y + (view.high[1] - up) * scale], across - view.at)
    }

    fn in_plane(&self, distance: f64) -> bool {
        distance.abs() < 2.0 * self.painter.view.spacing
    }

    fn thickness(&self) -> f64 {
        f64::from(self.painter.sheet.text) / 6.0
    }

    /// Draws the plane of an opening, the direction of its flow and its name.
    fn opening(&mut self, patch: &Patch) {
        let Some([from, to]) = self.cut(patch) else { return };
        self.drawing.line(from, to, 1.5 * self.thickness(), OPENING);
        let (middle, _) = self.pixel(patch.at);
        let (ahead, _) = self.pixel(patch.at + patch.towards);
        let direction = [ahead[0] - middle[0], ahead[1] - middle[1]];
        let length = direction[0].hypot(direction[1]);
        if length > 0.0 {
            let along = direction.map(|part| part / length * ARROW * f64::from(self.painter.sheet.text));
            self.arrow(middle, along);
        }
        // Above the arrow.
        self.labels
            .push((patch.name.clone(), [middle[0], middle[1] - 1.4 * f64::from(self.painter.sheet.text)]));
    }

    /// Returns the ends of the line in which an opening meets the plane of the picture, pixels.
    fn cut(&self, patch: &Patch) -> Option<[[f64; 2]; 2]> {
        let [first, second] = patch.across;
        let view = &self.painter.view;
        let normal = DVec3::AXES[view.axes[2]];
        let depth = if view.dimensions == 2 { 0.0 } else { (patch.at - DVec3::splat(view.at)).dot(normal) };
        // The point of the section nearest to the plane of the picture, along both of its axes.
        let steepness = [first.dot(normal), second.dot(normal)];
        let square = steepness[0] * steepness[0] + steepness[1] * steepness[1];
        if square < 1e-12 {
            let axis = if first.dot(normal).abs() < 1e-6 && view.dimensions == 2 { 0 } else { 1 };
            let half = patch.half_extent[axis] * patch.across[axis];
            return self
                .in_plane(depth)
                .then(|| [self.pixel(patch.at - half).0, self.pixel(patch.at + half).0]);
        }
        let towards_plane = (first * steepness[0] + second * steepness[1]) / square;
        let foot = patch.at - depth * towards_plane;
        let along = (first * -steepness[1] + second * steepness[0]) / square.sqrt();
        let [a, b] = patch.half_extent;
        let half = (a * along.dot(first)).hypot(b * along.dot(second));
        patch
            .covers(foot, 0.0)
            .then(|| [self.pixel(foot - half * along).0, self.pixel(foot + half * along).0])
    }

    fn arrow(&mut self, from: [f64; 2], along: [f64; 2]) {
        let tip = [from[0] + along[0], from[1] + along[1]];
        self.drawing.line(from, tip, self.thickness(), OPENING);
        for side in [-1.0, 1.0] {
            let back = [-0.3 * along[0] - side * 0.18 * along[1], -0.3 * along[1] + side * 0.18 * along[0]];
            self.drawing.line(tip, [tip[0] + back[0], tip[1] + back[1]], self.thickness(), OPENING);
        }
    }

    /// Draws a probe and its name.
    fn probe(&mut self, name: &str, kind: &ProbeKind, scene: &Scene) {
        let place = match kind {
            ProbeKind::Point(at) => {
                let (pixel, distance) = self.pixel(*at);
                if !self.in_plane(distance) {
                    return;
                }
                self.cross(pixel);
                pixel
            }
            ProbeKind::Line { from, to, .. } => {
                let ((start, near), (end, far)) = (self.pixel(*from), self.pixel(*to));
                if !self.in_plane(near) || !self.in_plane(far) {
                    return;
                }
                self.drawing.line(start, end, self.thickness(), PROBE);
                self.cross(start);
                self.cross(end);
                end
            }
            ProbeKind::Section { at, normal } => match self.section(*at, *normal, scene) {
                Some(place) => place,
                None => return,
            },
        };
        self.labels.push((name.to_owned(), place));
    }

    /// Draws the line in which a section meets the picture, inside the domain, and returns its end.
    fn section(&mut self, at: DVec3, normal: DVec3, scene: &Scene) -> Option<[f64; 2]> {
        let view = &self.painter.view;
        let direction = normal.cross(DVec3::AXES[view.axes[2]]).try_normalize()?;
        let mut start = at;
        if view.dimensions == 3 {
            // Along the section to the plane of the picture.
            let across = direction.cross(normal);
            let depth = at[view.axes[2]] - view.at;
            start -= across * (depth / across[view.axes[2]]);
        }
        if !scene.domain.contains(start, 0.0) {
            return None;
        }
        let (step, longest) = (0.25 * scene.spacing, view.extent()[0].hypot(view.extent()[1]));
        let end = |along: DVec3| {
            let inside = |distance: f64| scene.domain.contains(start + distance * along, 0.0);
            start + exit_distance(inside, step, longest).unwrap_or(longest) * along
        };
        let ends = [self.pixel(end(-direction)).0, self.pixel(end(direction)).0];
        self.drawing.line(ends[0], ends[1], self.thickness(), PROBE);
        Some(ends[1])
    }

    fn cross(&mut self, [x, y]: [f64; 2]) {
        let half = 0.45 * f64::from(self.painter.sheet.text);
        let thick = self.thickness();
        self.drawing.line([x - half, y - half], [x + half, y + half], thick, PROBE);
        self.drawing.line([x - half, y + half], [x + half, y - half], thick, PROBE);
    }

    /// Writes the labels on white ground, moved down until none covers another.
    fn write_labels(&mut self) {
        let size = self.painter.sheet.text;
        let (height, gap) = (1.25 * f64::from(size), 0.5 * f64::from(size));
        let mut taken: Vec<[f64; 4]> = Vec::new();
        let right = self.painter.sheet.corner[0] + self.painter.sheet.size[0];
        for (text, place) in std::mem::take(&mut self.labels) {
            let width = f64::from(text_width(&text, size, Weight::Regular)) + gap;
            let left = (place[0] + gap).min(right as f64 - width - 1.0);
            let mut top = place[1] - 0.5 * height;
            while let Some(other) = taken
                .iter()
                .find(|[l, t, w, h]| left < l + w && *l < left + width && top < t + h && *t < top + height)
            {
                top = other[1] + other[3] + 1.0;
            }
            taken.push([left, top, width, height]);
            let corner = [left.round() as i64, top.round() as i64];
            self.drawing.fill(corner, [width.round() as i64, height.round() as i64], [0xff; 3]);
            let at = [(left + 0.5 * gap) as f32, (top + 0.78 * height) as f32];
            self.drawing.text(&text, at, size, Weight::Regular, Anchor::Left);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sphecs_scene::seeds;

    #[test]
    fn openings_and_probes_are_drawn_over_the_zones() {
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/quickstart.ron");
        let scene = Scene::from_file(&file).smoke().load().expect("a scene");
        let seeds = seeds(&scene);
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("plan.png");
        render_plan(&scene, &seeds, &RenderOptions { width: 800, ..RenderOptions::default() }, &path)
            .expect("a picture");
        let picture = image::open(&path).expect("a picture").into_rgb8();
        let has = |colour: [u8; 3]| picture.pixels().filter(|pixel| pixel.0 == colour).count();
        assert!(has(OPENING) > 200, "{} pixels of openings", has(OPENING));
        assert!(has(PROBE) > 400, "{} pixels of probes", has(PROBE));
    }

    #[test]
    fn oblique_opening_meets_a_slice_in_a_line() {
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/duct3d.ron");
        let scene = Scene::from_file(&file).smoke().load().expect("a scene");
        let options = RenderOptions::default();
        let frame = frame_of(&seeds(&scene));
        let header = Header::new(&scene, &InitialParticles::of_frame(&frame));
        let mut painter = Painter::new(&header, &options).expect("a painter");
        let drawing = painter.draw(&frame);
        let plan = Plan { drawing, painter: &painter, labels: Vec::new() };
        let patch = &scene.inlets[0].patch;
        let [from, to] = plan.cut(patch).expect("a line");
        let scale = painter.sheet.size[0] as f64 / painter.view.extent()[0];
        let length = (to[0] - from[0]).hypot(to[1] - from[1]) / scale;
        assert!((length - 2.0 * patch.half_extent[0]).abs() < 1e-6, "{length} m, {patch:?}");
    }
}
