//! Painter of the frames of one run with one colour scale and one scale of arrows.

use super::overlay::Overlay;
use super::plane_grid::{PlaneGrid, PlaneSampler};
use super::sheet::{ColourKey, Sheet, clock, interval};
use super::view::View;
use super::{Colours, Field, RenderOptions, perspective, raster};
use crate::drawing::{Colour, Drawing};
use crate::error::OutputError;
use crate::frame::Frame;
use crate::header::Header;
use crate::results::Results;
use sphecs_core::particles::zone::Zone;

/// Painter of the frames of one run.
pub(super) struct Painter<'a> {
    options: &'a RenderOptions,
    header: &'a Header,
    pub(super) view: View,
    pub(super) sheet: Sheet,
    /// Smallest and largest value of the frames so far.
    found: Option<(f64, f64)>,
    /// Largest speed in the plane of the frames so far, m/s.
    largest_speed: f64,
    sampler: Option<PlaneSampler>,
}

impl<'a> Painter<'a> {
    /// Returns the painter of a run.
    ///
    /// # Errors
    /// [`OutputError::Request`] when the options do not match the run.
    pub(super) fn new(header: &'a Header, options: &'a RenderOptions) -> Result<Self, OutputError> {
        let mut view = View::new(header, options.slice)?;
        if let Some(part) = options.part {
            view = view.part(part)?;
        }
        if options.field == Field::W && view.dimensions == 2 {
            return Err(OutputError::Request(
                "field `w`: the run is in 2D and has no velocity along z, draw `u` or `v`".to_owned(),
            ));
        }
        if let Some((low, high)) = options.range
            && !(low < high && low.is_finite() && high.is_finite())
        {
            return Err(OutputError::Request(format!(
                "range {low} to {high}: must be two finite numbers, the smaller first"
            )));
        }
        let mut sheet = Sheet::new(&view, options.width);
        if let Some(towards) = options.perspective {
            if view.dimensions == 2 {
                return Err(OutputError::Request(
                    "perspective: the flow is in 2D and has one plane only: leave `--perspective` out"
                        .to_owned(),
                ));
            }
            view.is_whole = true;
            sheet = Sheet::in_space(perspective::extent(header, towards), options.width);
        }
        let mut painter =
            Self { options, header, view, sheet, found: None, largest_speed: 0.0, sampler: None };
        if options.arrows.or(options.streamlines).or(options.contours).is_some() {
            painter.sampler = Some(painter.new_sampler(options.contours.is_some())?);
        }
        Ok(painter)
    }

    fn new_sampler(&self, needs_values: bool) -> Result<PlaneSampler, OutputError> {
        PlaneSampler::new(self.header, &self.view, self.options.field, needs_values)
    }

    /// Returns true if the scales depend on the frames.
    pub(super) fn needs_all_frames(&self) -> bool {
        let needs_range = self.options.range.is_none() && self.options.field != Field::Zone;
        needs_range || self.options.arrows.is_some()
    }

    /// Extends the scales to the values of a frame.
    pub(super) fn include(&mut self, frame: &Frame) {
        let field = self.options.field;
        let depth = self.view.depth();
        let drawn = |slot: &usize| {
            let place = self.view.place(frame, *slot);
            frame.zone[*slot] <= Zone::Outflow as u8
                && frame.zone[*slot] != Zone::Wall as u8
                && place[2].abs() < depth
                && (self.view.is_whole || self.view.shows(place))
        };
        let slots: Vec<usize> = (0..frame.len()).filter(drawn).collect();
        if self.options.arrows.is_some() {
            let [right, up, _] = self.view.axes;
            let speed = |&slot: &usize| frame.velocity[right][slot].hypot(frame.velocity[up][slot]);
            let largest = slots.iter().map(speed).fold(0.0_f32, f32::max);
            self.largest_speed = self.largest_speed.max(f64::from(largest));
        }
        if self.options.range.is_some() {
            return;
        }
        let values = field.values(frame, &self.view);
        let values = slots.into_iter().map(|slot| f64::from(values[slot]));
        self.extend(values.collect());
    }

    /// Extends the colour scale to values, of which the field may leave out a few extreme ones.
    fn extend(&mut self, mut values: Vec<f64>) {
        values.retain(|value| value.is_finite());
        if values.is_empty() {
            return;
        }
        values.sort_by(f64::total_cmp);
        let cut = (self.options.field.cut() * values.len() as f64) as usize;
        let (low, high) = (values[cut], values[values.len() - 1 - cut]);
        let (low_before, high_before) = self.found.unwrap_or((low, high));
        self.found = Some((low_before.min(low), high_before.max(high)));
    }

    /// Returns the meaning of the colours.
    pub(super) fn key(&self) -> ColourKey {
        let field = self.options.field;
        if field == Field::Zone {
            return ColourKey::Zones;
        }
        let own = field.colours(self.view.dimensions);
        let (mut low, mut high) = self.found.unwrap_or((0.0, 1.0));
        if field == Field::Speed {
            low = 0.0;
        }
        if own == Colours::Diverging {
            high = high.abs().max(low.abs());
            low = -high;
        }
        // A uniform field has an empty range.
        if high - low <= 1e-6 * high.abs().max(low.abs()) {
            let margin = if high == 0.0 { 1.0 } else { 1e-3 * high.abs() };
            (low, high) = (low - margin, high + margin);
        }
        ColourKey::Scale {
            colours: self.options.colours.unwrap_or(own),
            range: self.options.range.unwrap_or((low, high)),
        }
    }

    /// Draws a square around a slot that has a position.
    pub(super) fn mark(&self, drawing: &mut Drawing, frame: &Frame, slot: usize) {
        let [right, up, _] = self.view.place(frame, slot);
        if !(right.is_finite() && up.is_finite()) {
            return;
        }
        let pixels_per_metre = self.sheet.size[0] as f64 / self.view.extent()[0];
        let pixel = |metres: f64| (metres * pixels_per_metre).round() as i64;
        let half = pixel(0.9 * self.view.spacing).max(4);
        let [x, y] = self.sheet.corner;
        let corner = [x + pixel(right - self.view.low[0]) - half, y + pixel(self.view.high[1] - up) - half];
        drawing.outline(corner, [2 * half, 2 * half], (half / 6).max(2));
    }

    /// Draws a frame.
    pub(super) fn draw(&mut self, frame: &Frame) -> Drawing {
        let field = self.options.field;
        let key = self.key();
        let values = field.values(frame, &self.view);
        if let Some(towards) = self.options.perspective {
            let mut drawing = self.sheet.draw_in_space(field, &key, &self.header.title, frame.time);
            let scene = perspective::View3 { header: self.header, towards, cut: self.options.slice };
            let size = self.sheet.size.map(|length| length as usize);
            let pixels = perspective::paint(frame, &scene, &values, size, |value| key.colour(value));
            drawing.image(self.sheet.corner, size, pixels);
            self.sheet.triad(&mut drawing, perspective::axes(towards));
            return drawing;
        }
        let when = clock(&self.view, frame.time);
        let mut drawing = self.sheet.draw(&self.view, field, &key, &self.header.title, &when);
        let found = |[x, y]: [f64; 2], particles: &raster::Particles| particles.at(x, y, field.is_label());
        self.field(&mut drawing, frame, &values, &key, found);
        if let Some(sampler) = &mut self.sampler {
            let grid = sampler.sample(frame);
            self.lines(&mut drawing, &grid, &key);
        }
        drawing
    }

    /// Draws the time mean of the frames in an interval, s, and returns the part that they cover.
    ///
    /// # Errors
    /// [`OutputError`] when the interval has no frames or one cannot be read.
    pub(super) fn draw_mean(
        &mut self,
        results: &Results,
        wanted: (f64, f64),
    ) -> Result<(Drawing, (f64, f64)), OutputError> {
        let mut sampler = self.new_sampler(true)?;
        let (grid, covered, last) = sampler.mean(results, wanted)?;
        self.largest_speed = grid.largest_speed();
        self.extend(grid.values.clone());
        let key = self.key();
        let when = interval(&self.view, covered);
        let mut drawing = self.sheet.draw(&self.view, self.options.field, &key, &self.header.title, &when);
        let found =
            |place: [f64; 2], particles: &raster::Particles| match particles.at(place[0], place[1], true) {
                raster::Found::Value(_) => raster::Found::Value(grid.value_at(place)),
                other => other,
            };
        self.field(&mut drawing, &last, &vec![0.0; last.len()], &key, found);
        self.lines(&mut drawing, &grid, &key);
        Ok((drawing, covered))
    }

    /// Draws the pixels of the field.
    fn field(
        &self,
        drawing: &mut Drawing,
        frame: &Frame,
        values: &[f32],
        key: &ColourKey,
        found: impl Fn([f64; 2], &raster::Particles) -> raster::Found + Sync,
    ) {
        let size = self.sheet.size.map(|length| length as usize);
        drawing.image(self.sheet.corner, size, self.painted(size, (frame, values), key, found));
    }

    /// Returns the colours of an area of pixels.
    fn painted(
        &self,
        size: [usize; 2],
        (frame, values): (&Frame, &[f32]),
        key: &ColourKey,
        found: impl Fn([f64; 2], &raster::Particles) -> raster::Found + Sync,
    ) -> Vec<Colour> {
        let particles = raster::Particles::new(frame, &self.view, values);
        raster::paint(&self.view, size, |place| match found(place, &particles) {
            raster::Found::Value(value) if value.is_finite() => key.colour(value),
            other => other.colour(),
        })
    }

    /// Returns the pixels of a frame without axes and text, and the meaning of the colours.
    pub(super) fn pixels(&self, frame: &Frame, size: [usize; 2]) -> (Vec<Colour>, ColourKey) {
        let (field, key) = (self.options.field, self.key());
        let values = field.values(frame, &self.view);
        let found = |[x, y]: [f64; 2], particles: &raster::Particles| particles.at(x, y, field.is_label());
        (self.painted(size, (frame, &values), &key, found), key)
    }

    /// Draws arrows, streamlines and lines of equal value, as wanted.
    fn lines(&self, drawing: &mut Drawing, grid: &PlaneGrid, key: &ColourKey) {
        let mut overlay = Overlay { drawing, view: &self.view, sheet: &self.sheet, grid };
        if let (Some(count), ColourKey::Scale { range, .. }) = (self.options.contours, key) {
            // Of a scale about zero only a part may occur.
            overlay.contours(self.found.unwrap_or(*range), count);
        }
        if let Some(across) = self.options.streamlines {
            overlay.streamlines(across);
        }
        if let Some(across) = self.options.arrows {
            overlay.arrows(across, self.largest_speed);
        }
    }
}
